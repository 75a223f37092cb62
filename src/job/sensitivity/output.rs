//! Settings and result of a sensitivity analysis.

use serde::{Deserialize, Serialize};

use crate::statistics::elementary_effects::ElementaryEffect;
use crate::statistics::sobol_indices::{Estimate, Place};
use crate::study::requirement::Environment;

/// A way to tell which parameters matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Exact derivatives at the nominal parameters.
    Local,
    /// Elementary effects along trajectories.
    Morris,
    /// Shares of the variance.
    Sobol,
    /// Bounds of the total effects by mean squared derivatives.
    Derivative,
}

/// Resolved settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Indices of the quantities in the model's list.
    pub quantities: Vec<usize>,
    /// What is computed.
    pub methods: Vec<Method>,
    /// Base points of each scramble, a power of two; with a precision the most that are taken.
    pub samples: u64,
    /// Independent scrambles of the Sobol points, at least 2.
    pub scrambles: u64,
    /// Whether effects of pairs are computed too, which doubles the solves.
    pub second_order: bool,
    /// The widest interval of a main or total effect that is good enough; base points are doubled until it is reached.
    pub precision: Option<f64>,
    /// Trajectories of the elementary effects.
    pub trajectories: u64,
    /// Environments; one named `nominal` with the inputs' nominal values where the study names none.
    pub environments: Vec<Environment>,
    /// Largest share of failed solves that is tolerated.
    pub failure_limit: f64,
}

impl Spec {
    /// Whether a method is asked for.
    pub fn has(&self, method: Method) -> bool {
        self.methods.contains(&method)
    }
}

/// An uncertain parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Unit as the study writes it, for people; the numbers are SI.
    pub unit: String,
    /// Nominal value.
    pub nominal: f64,
    /// Standard deviation of its prior.
    pub sd: f64,
}

impl Parameter {
    /// About how large it is, SI: its nominal value, or its prior's spread where that is larger.
    pub fn size(&self) -> f64 {
        if self.sd.is_finite() { self.nominal.abs().max(self.sd) } else { self.nominal.abs() }
    }
}

/// Derivative of a quantity by a parameter at the nominal parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Local {
    /// Derivative, SI of the quantity by SI of the parameter; nothing where it is not finite.
    pub derivative: Option<f64>,
    /// Times the parameter's value by the quantity's: the relative change by a relative change.
    pub scaled_by_value: Option<f64>,
    /// Times the prior's standard deviation, SI of the quantity.
    pub scaled_by_sd: Option<f64>,
}

/// An index with its interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Index {
    /// Estimate with its 95 % interval from the scatter of the scrambles.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// Where rows were left out: the smallest and largest value that this index could have, if the values of those rows
    /// were within the range of the others.
    pub bounds: Option<[f64; 2]>,
}

/// Effect of a pair beyond the main effects of both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PairEffect {
    /// The parameters.
    pub parameters: [String; 2],
    /// Estimate with its 95 % interval.
    #[serde(flatten)]
    pub estimate: Estimate,
}

/// Shares of a quantity's variance, by parameter in the order of [`Output::parameters`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Sobol {
    /// Mean of the quantity.
    pub mean: f64,
    /// Standard deviation of the quantity.
    pub sd: f64,
    /// Main effects: the share of the variance that would go if the parameter were known.
    pub main: Vec<Index>,
    /// Total effects: the share that would stay if all but the parameter were known.
    pub total: Vec<Index>,
    /// Effects of pairs, where they were asked for.
    pub second_order: Vec<PairEffect>,
    /// Sum of the main effects: the share of the variance that parameters explain one by one.
    pub sum_main: Estimate,
    /// Places by total effect; a range where the intervals do not tell parameters apart.
    pub places: Vec<Place>,
}

/// A bound of a total effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct DerivativeBound {
    /// The total effect is at most this; estimate with its 95 % interval. It may lie above 1.
    #[serde(flatten)]
    pub bound: Estimate,
    /// Root of the mean squared derivative, SI of the quantity by SI of the parameter (by its logarithm for priors in it).
    pub root_mean_square: f64,
}

/// Some samples of a quantity with the parameters that matter most to it, for a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Scatter {
    /// Positions in [`Output::parameters`].
    pub parameters: Vec<usize>,
    /// Values of each of these parameters, SI.
    pub x: Vec<Vec<f64>>,
    /// Values of the quantity, SI.
    pub y: Vec<f64>,
}

/// What was found of a quantity; lists by parameter are in the order of [`Output::parameters`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct OfQuantity {
    /// Name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Whether it is an absolute temperature.
    pub is_temperature: bool,
    /// Value at the nominal parameters.
    pub nominal: f64,
    /// Whether it does not vary with the parameters: there is nothing to divide among them.
    pub is_constant: bool,
    /// Derivatives; empty where not asked for.
    pub local: Vec<Local>,
    /// Elementary effects; empty where not asked for.
    pub morris: Vec<ElementaryEffect>,
    /// Shares of the variance; nothing where not asked for, or constant.
    pub sobol: Option<Sobol>,
    /// Bounds by derivatives; empty where not asked for, or constant.
    pub derivative: Vec<DerivativeBound>,
    /// Samples for a picture.
    pub scatter: Option<Scatter>,
}

/// A solve that failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct FailedSolve {
    /// What it belonged to: a row of a scramble or a trajectory, in words.
    pub place: String,
    /// The parameters, SI, by name.
    pub parameters: Vec<(String, f64)>,
    /// Why.
    pub reason: String,
}

/// One environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Case {
    /// Environment.
    pub environment: String,
    /// By quantity, in the order asked for.
    pub quantities: Vec<OfQuantity>,
    /// Number of solves.
    pub solves: u64,
    /// Number of failed solves.
    pub failed: u64,
    /// Rows of the Sobol design that are left out because one of their solves failed.
    pub rows_left_out: u64,
    /// Rows of the Sobol design.
    pub rows: u64,
    /// Trajectories that are left out because one of their solves failed.
    pub trajectories_left_out: u64,
    /// The first failed solves.
    pub failures: Vec<FailedSolve>,
}

/// What became of the precision that was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Precision {
    /// The widest interval asked for.
    pub asked: f64,
    /// The widest interval of all main and total effects.
    pub widest: f64,
    /// Whether it was reached.
    pub is_reached: bool,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// What was computed.
    pub methods: Vec<Method>,
    /// Base points of each scramble that were used.
    pub samples: u64,
    /// Scrambles.
    pub scrambles: u64,
    /// Trajectories of the elementary effects.
    pub trajectories: u64,
    /// The uncertain parameters.
    pub parameters: Vec<Parameter>,
    /// Precision, where one was asked for.
    pub precision: Option<Precision>,
    /// One an environment.
    pub cases: Vec<Case>,
}
