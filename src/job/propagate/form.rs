//! Settings of `propagate` as written.

use crate::document::{Map, Spanned, written_struct, written_words};
use crate::study::pass::variable::SweepForm;

written_struct! {
    /// Settings of `propagate`.
    pub struct PropagateForm: "settings of `propagate`" {
        /// Quantities; those of the requirements, else all named ones, else all nodes.
        optional quantities: Vec<Spanned<String>>,
        /// Number of samples, 4096 where it is left out.
        optional samples: Spanned<u64>,
        /// How the priors are sampled, `sobol` where it is left out.
        optional sampling: SamplingForm,
        /// Environments; all of the pass, else `nominal` with the inputs' nominal values.
        optional environments: Vec<Spanned<String>>,
        /// Requirements; all of the pass where they are left out.
        optional requirements: Vec<Spanned<String>>,
        /// A design variable with its values.
        optional sweep: Spanned<Map<SweepForm>>,
        /// Pairs of quantities whose joint distribution is wanted.
        default(Vec::new()) joint: Vec<[Spanned<String>; 2]>,
        /// Largest share of failed samples that is tolerated, 0.01 where it is left out.
        optional failure_limit: Spanned<f64>,
    }
}

written_words! {
    /// How priors are sampled.
    pub enum SamplingForm: "sampling" {
        /// Independent draws.
        "monte-carlo" => MonteCarlo,
        /// One draw in each of N equal slices.
        "latin-hypercube" => LatinHypercube,
        /// Scrambled Sobol points.
        "sobol" => Sobol,
    }
}
