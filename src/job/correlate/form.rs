//! Settings of `correlate` as written.

use crate::document::{Map, Spanned, written_struct, written_words};
use crate::study::pass::variable::RangeForm;

written_struct! {
    /// Settings of `correlate`.
    pub struct CorrelateForm: "settings of `correlate`" {
        /// Measurements; all of the pass where they are left out.
        optional data: Vec<Spanned<String>>,
        /// Parameters that may be changed; all whose prior is not fixed where they are left out.
        optional parameters: Vec<Spanned<String>>,
        /// Criteria profile that is to be met, `smc-3k` where it is left out.
        optional criteria: Spanned<String>,
        /// How parameters are changed, `one-at-a-time` where it is left out.
        optional method: MethodForm,
        /// Between which values parameters may be changed; the ends of their priors where nothing is said.
        default(Map::default()) ranges: Map<RangeForm>,
    }
}

written_words! {
    /// How parameters are changed.
    pub enum MethodForm: "a method" {
        /// Always that one which alone lowers the misfit most, until the criteria are met.
        "one-at-a-time" => OneAtATime,
        /// All together, to the least sum of squares.
        "least-squares" => LeastSquares,
    }
}
