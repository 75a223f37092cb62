//! Settings of `diagnose` as written.

use crate::document::{Map, Spanned, written_struct};

written_struct! {
    /// Settings of `diagnose`.
    pub struct DiagnoseForm: "settings of `diagnose`" {
        /// Measurements; all of the pass where they are left out.
        optional data: Vec<Spanned<String>>,
        /// Parameters; all whose prior is not fixed where they are left out.
        optional parameters: Vec<Spanned<String>>,
        /// Names of the effects that are considered; the whole catalogue and the study's own where they are left out.
        optional effects: Vec<Spanned<String>>,
        /// Names of effects that are not considered.
        default(Vec::new()) without: Vec<Spanned<String>>,
        /// Most effects at once, 3 where it is left out.
        optional most: Spanned<u64>,
        /// Family-wise probability of a false alarm, 0.005 where it is left out.
        optional false_alarm: Spanned<f64>,
        /// Probability beforehand that a kind of effect is missing, by its name: 0.05 where it is left out.
        default(Map::default()) missing_probability: Map<f64>,
    }
}
