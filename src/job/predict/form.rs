//! Settings of `predict` as written.

use crate::document::prior::PosteriorForm;
use crate::document::{Amount, Map, NameOr, Spanned, written_struct};
use crate::job::propagate::SamplingForm;
use crate::study::pass::variable::SweepForm;

written_struct! {
    /// Settings of `predict`.
    pub struct PredictForm: "settings of `predict`" {
        /// The `calibrate` job whose posterior is carried: one of this pass by its name, or `{"pass": ..., "job": ...}`. The
        /// pass's only one where it is left out.
        optional from: NameOr<Spanned<PosteriorForm>>,
        /// Quantities, as in `propagate`.
        optional quantities: Vec<Spanned<String>>,
        /// Number of samples, 4096 where it is left out.
        optional samples: Spanned<u64>,
        /// How the sample space is covered, `sobol` where it is left out.
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
        /// What is added to the model; effects are adopted by the pass.
        optional with: WithForm,
    }
}

written_struct! {
    /// What is added to the model in a prediction.
    pub struct WithForm: "what is added to the model" {
        /// Standard deviation of the model's discrepancy by quantity, as a validation experiment found it: a normal error of
        /// that size is added to each sample.
        default(Map::default()) discrepancy: Map<Amount>,
    }
}
