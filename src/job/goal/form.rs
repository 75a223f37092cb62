//! Settings of `goal` as written.

use crate::document::{Amount, Map, NameOr, Spanned, written_struct};
use crate::study::pass::variable::RangeForm;

written_struct! {
    /// Settings of `goal`.
    pub struct GoalForm: "settings of `goal`" {
        /// Requirements; all of the pass where they are left out.
        optional requirements: Vec<Spanned<String>>,
        /// Parameters whose knowledge is sharpened, in this order; those with the largest main effects where they are left out.
        optional parameters: Vec<Spanned<String>>,
        /// A design variable whose reachable value is sought: a name, or a name with `from` and `to`. The pass's one entry under
        /// `design` where it is left out, else none.
        optional design_variable: NameOr<Spanned<Map<RangeForm>>>,
        /// Environments, in all of which the requirements must be met; all of the pass, else `nominal`.
        optional environments: Vec<Spanned<String>>,
        /// Number of samples, 4096 where it is left out.
        optional samples: Spanned<u64>,
        /// Standard deviation of the model's discrepancy by quantity, as a validation experiment found it.
        default(Map::default()) discrepancy: Map<Amount>,
        /// Largest share of failed solves that is tolerated, 0.01 where it is left out.
        optional failure_limit: Spanned<f64>,
    }
}
