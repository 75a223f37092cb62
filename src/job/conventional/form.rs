//! Settings of `conventional` as written.

use crate::document::{Map, NameOr, Spanned, written_struct};
use crate::study::pass::variable::RangeForm;

written_struct! {
    /// Settings of `conventional`.
    pub struct ConventionalForm: "settings of `conventional`" {
        /// Margin rules by name; all that come with the program, then the study's own, where they are left out.
        optional rules: Vec<Spanned<String>>,
        /// Environments; all of the pass, else `nominal`.
        optional environments: Vec<Spanned<String>>,
        /// Requirements; all of the pass where they are left out.
        optional requirements: Vec<Spanned<String>>,
        /// What is sized: a name (its range from the pass's `design`, the input's range or the prior), or a name with
        /// `from` and `to`. The pass's one entry under `design` where it is left out.
        optional design_variable: NameOr<Spanned<Map<RangeForm>>>,
        /// Parameters and inputs that are heat loads, for margins on heat; those in W where they are left out.
        optional heat_loads: Vec<Spanned<String>>,
        /// A `correlate` job of this pass: the parameters that it changed stand at its values, with no uncertainty.
        optional from: Spanned<String>,
        /// An earlier pass whose nominal values and priors are taken: what was known then.
        optional priors_of: Spanned<String>,
    }
}
