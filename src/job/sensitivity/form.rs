//! Settings of `sensitivity` as written.

use crate::document::{Spanned, written_struct, written_words};

written_struct! {
    /// Settings of `sensitivity`.
    pub struct SensitivityForm: "settings of `sensitivity`" {
        /// Quantities; those of the pass's requirements, else all named ones, else all nodes.
        optional quantities: Vec<Spanned<String>>,
        /// What is computed; all of it where it is left out.
        optional methods: Vec<MethodForm>,
        /// Base points of each scramble, a power of two, 4096 where it is left out; the most that are taken where a
        /// precision is asked for.
        optional samples: Spanned<u64>,
        /// Independent scrambles of the Sobol points, 8 where it is left out.
        optional scrambles: Spanned<u64>,
        /// Whether effects of pairs are computed too, which doubles the solves.
        default(false) second_order: bool,
        /// The widest interval of a main or total effect that is good enough.
        optional precision: Spanned<f64>,
        /// Trajectories of `morris`, 64 where it is left out.
        optional trajectories: Spanned<u64>,
        /// Environments; all of the pass, else `nominal` with the inputs' nominal values.
        optional environments: Vec<Spanned<String>>,
        /// Largest share of failed solves that is tolerated, 0.01 where it is left out.
        optional failure_limit: Spanned<f64>,
    }
}

written_words! {
    /// A way to tell which parameters matter.
    pub enum MethodForm: "a method" {
        /// Exact derivatives at the nominal parameters.
        "local" => Local,
        /// Elementary effects.
        "morris" => Morris,
        /// Shares of the variance.
        "sobol" => Sobol,
        /// Bounds of the total effects by mean squared derivatives.
        "derivative" => Derivative,
    }
}
