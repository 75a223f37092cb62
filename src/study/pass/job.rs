//! Jobs as written: one key, the kind; every setting has a default.

use serde_json::json;

use super::design::DesignForm;
use crate::document::prior::PosteriorForm;
use crate::document::written::wrong_type;
use crate::document::{
    Amount, Diagnostics, Map, NameOr, Node, Schemas, Spanned, Value, Written, written_choice, written_struct,
    written_words,
};

written_choice! {
    /// A job.
    pub enum JobForm: "a job" {
        /// Propagation of the parameters' uncertainty.
        "propagate" => Propagate(PropagateForm),
        /// Which parameters matter.
        "sensitivity" => Sensitivity(SensitivityForm),
        /// Which parameter must be known how well.
        "goal" => Goal(GoalForm),
        /// The experiment that teaches most.
        "design" => Design(Box<DesignForm>),
        /// Parameters from measurements.
        "calibrate" => Calibrate(CalibrateForm),
        /// Model against measurements.
        "compare" => Compare(CompareForm),
        /// Which physical effect is missing.
        "diagnose" => Diagnose(DiagnoseForm),
        /// The model's discrepancy as a function.
        "discrepancy" => Discrepancy(Node),
        /// Flight prediction.
        "predict" => Predict(Box<PredictForm>),
        /// Stacked worst cases with margins by rule.
        "conventional" => Conventional(ConventionalForm),
    }
}

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

written_struct! {
    /// What is added to the model in a prediction.
    pub struct WithForm: "what is added to the model" {
        /// Standard deviation of the model's discrepancy by quantity, as a validation experiment found it: a normal error of
        /// that size is added to each sample.
        default(Map::default()) discrepancy: Map<Amount>,
    }
}

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

/// Values of a design variable.
#[derive(Clone, Debug, PartialEq)]
pub enum SweepForm {
    /// One by one.
    List(Vec<Amount>),
    /// Equally spaced.
    Steps(Box<StepsForm>),
}

written_struct! {
    /// Equally spaced values.
    pub struct StepsForm: "an object {\"from\": ..., \"to\": ..., \"steps\": ...}" {
        /// First value; above `to` where the largest value that passes is wanted.
        required from: Amount,
        /// Last value.
        required to: Amount,
        /// Number of values, both ends included.
        required steps: Spanned<usize>,
    }
}

impl Written for SweepForm {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        match &node.value {
            Value::Array(_) => Vec::read(node, diagnostics).map(Self::List),
            Value::Object(_) => Box::read(node, diagnostics).map(Self::Steps),
            _ => wrong_type(node, &Self::expected(), diagnostics),
        }
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"anyOf": [Vec::<Amount>::schema(schemas), StepsForm::schema(schemas)]})
    }
    fn expected() -> String {
        "an array of values, or {\"from\": ..., \"to\": ..., \"steps\": ...}".to_owned()
    }
}

written_struct! {
    /// A range of a design variable.
    pub struct RangeForm: "an object {\"from\": ..., \"to\": ...}" {
        /// Where the search starts; above `to` where the largest value that passes is wanted.
        required from: Amount,
        /// The end towards which requirements are easier to meet.
        required to: Amount,
    }
}

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
    }
}

written_struct! {
    /// Settings of `compare`.
    pub struct CompareForm: "settings of `compare`" {
        /// Measurements; all of the pass where they are left out.
        optional data: Vec<Spanned<String>>,
        /// Criteria profile, `smc-3k` where it is left out.
        optional criteria: Spanned<String>,
        /// The `calibrate` job whose tuned state stands beside the delivered one; `nominal` for none. The first of the
        /// pass on the same data where it is left out.
        optional from: Spanned<String>,
    }
}

written_struct! {
    /// Settings of `calibrate`.
    pub struct CalibrateForm: "settings of `calibrate`" {
        /// Measurements; all of the pass where they are left out.
        optional data: Vec<Spanned<String>>,
        /// Parameters; all whose prior is not fixed where they are left out.
        optional parameters: Vec<Spanned<String>>,
        /// How the posterior is sampled, `nuts` where it is left out.
        optional sampler: SamplerForm,
        /// Number of chains (of islands for `smc`), 4 where it is left out.
        optional chains: Spanned<u64>,
        /// Steps of a chain that adapt and are dropped: 500 for `nuts`, 5000 for `adaptive-metropolis`.
        optional warmup: Spanned<u64>,
        /// Draws of a chain that are kept: 1000, 5000 for `adaptive-metropolis`.
        optional draws: Spanned<u64>,
        /// Mean acceptance that the steps of `nuts` are adapted to, 0.8 where it is left out; 0.95 takes shorter steps, for
        /// posteriors in which trajectories diverge.
        optional acceptance: Spanned<f64>,
    }
}

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
    }
}

written_words! {
    /// How a posterior is sampled.
    pub enum SamplerForm: "a sampler" {
        /// The No-U-Turn sampler.
        "nuts" => Nuts,
        /// Adaptive Metropolis.
        "adaptive-metropolis" => AdaptiveMetropolis,
        /// Sequential Monte Carlo.
        "smc" => Smc,
    }
}
