//! Settings and result of a discrepancy.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::inference::gaussian_process::hyperparameters::Beforehand;
use crate::inference::gaussian_process::tested_range::TestedRange;
use crate::inference::gaussian_process::{Form, Kernel, Trend};
use crate::job::calibrate::KeptDraws;
use crate::job::key_number::KeyNumber;
use crate::study::resolved::{Blocked, Upstream};

/// A law of the discrepancy, simplest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// None.
    None,
    /// A constant.
    Constant,
    /// A constant, and scatter that no input explains.
    ResidualLaw,
    /// A Gaussian process over the inputs, and scatter.
    GaussianProcess,
}

impl Law {
    /// All, simplest first.
    pub const ALL: [Self; 4] = [Self::None, Self::Constant, Self::ResidualLaw, Self::GaussianProcess];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Constant => "constant",
            Self::ResidualLaw => "residual law",
            Self::GaussianProcess => "Gaussian process",
        }
    }

    /// The parts that it has.
    pub fn form(self, kernel: Kernel, trend: Trend) -> Form {
        match self {
            Self::None => Form { kernel: None, trend: Trend::None, scatter: false },
            Self::Constant => Form { kernel: None, trend: Trend::Constant, scatter: false },
            Self::ResidualLaw => Form { kernel: None, trend: Trend::Constant, scatter: true },
            Self::GaussianProcess => Form { kernel: Some(kernel), trend, scatter: true },
        }
    }
}

/// Resolved settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// Positions of the measurements in the pass's list.
    pub data: Vec<usize>,
    /// The calibration.
    pub calibration: Upstream,
    /// The calibration, for people.
    pub source: String,
    /// Why it does not run now, where it is another pass's.
    pub blocked: Option<Blocked>,
    /// Names of the sensors.
    pub sensors: Vec<String>,
    /// Positions of the inputs in the model's list.
    pub inputs: Vec<usize>,
    /// Covariance.
    pub kernel: Kernel,
    /// Trend of the Gaussian process.
    pub trend: Trend,
    /// The law, where it is not chosen by scores.
    pub law: Option<Law>,
    /// Whether hyperparameters are drawn.
    pub sampled: bool,
    /// What is known of them beforehand.
    pub beforehand: Beforehand,
    /// Whether parameters and discrepancy are inferred together.
    pub is_joint: bool,
    /// Draws of the calibration, or of parameters and hyperparameters together.
    pub draws: u64,
    /// A diagnosis of the pass.
    pub diagnosis: Option<String>,
}

/// A residual of a phase: measured minus predicted, SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PhaseResidual {
    /// Measurement.
    pub measurement: String,
    /// Phase.
    pub phase: String,
    /// The inputs that the discrepancy may depend on, SI.
    pub inputs: Vec<f64>,
    /// Residual at the posterior mean.
    pub residual: f64,
    /// Standard deviation of the residual over the posterior draws.
    pub calibration_sd: f64,
    /// Standard deviation of the reading's noise.
    pub noise_sd: f64,
    /// Slopes of the residual with the unknowns of the calibration.
    pub slopes: Vec<f64>,
    /// Kept from calibration and law.
    pub held_out: bool,
    /// What the other readings, or for one held out those that are not, say of it.
    pub expected: f64,
    /// Standard deviation of that, noise included.
    pub expected_sd: f64,
}

/// How a law did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct LawScore {
    /// The law.
    pub law: Law,
    /// Why it could not be fitted.
    pub refused: Option<String>,
    /// Sum of the log densities of readings left out, hyperparameters fitted without them.
    pub score: Option<f64>,
    /// Its standard error.
    pub score_se: Option<f64>,
    /// How much less that is than the best law's.
    pub behind: Option<f64>,
    /// Standard error of that, from the paired differences.
    pub behind_se: Option<f64>,
    /// Sum of the log densities of readings held out; `None` without such.
    pub held_out_score: Option<f64>,
    /// Logarithm of the marginal likelihood.
    pub log_marginal_likelihood: Option<f64>,
}

/// Hyperparameters of the law that was taken, in units that people read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Hyperparameter {
    /// What it is: `standard deviation`, `length in V`, `scatter`, `constant`, `slope in V`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Of the highest marginal likelihood, median of the draws where they were inferred with the parameters; mean of the trend's
    /// coefficients.
    pub value: f64,
    /// Quantiles of 2.5 % and 97.5 % of its draws, where it was drawn.
    pub interval: Option<[f64; 2]>,
    /// Whether it ended at a bound of the search.
    pub at_bound: bool,
}

/// How standardised errors of predicted readings lie: with the right law mean 0, standard deviation 1, 95 % inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Check {
    /// Readings.
    pub count: u64,
    /// Mean of (reading - expected) / standard deviation; 0 without readings.
    pub mean: f64,
    /// Standard deviation of the same about 0.
    pub rms: f64,
    /// How many lie inside the 95 % interval.
    pub inside: u64,
}

/// The discrepancy along one input, the others in the middle of what was tested.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Curve {
    /// The input.
    pub input: String,
    /// Its SI unit.
    pub unit: String,
    /// Values of the input.
    pub at: Vec<f64>,
    /// Mean.
    pub mean: Vec<f64>,
    /// Lower end of the 95 % band, scatter included.
    pub lower: Vec<f64>,
    /// Upper end.
    pub upper: Vec<f64>,
}

/// Discrepancy of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SensorDiscrepancy {
    /// Sensor.
    pub sensor: String,
    /// The quantity that it measures.
    pub quantity: String,
    /// SI unit.
    pub unit: String,
    /// The law that is taken.
    pub law: Law,
    /// Why, in words.
    pub because: String,
    /// All laws.
    pub laws: Vec<LawScore>,
    /// Its parts.
    pub form: Form,
    /// Draws of its hyperparameters, logarithms over inputs in widths of the tested range; one where they are not drawn.
    pub draws: Vec<Vec<f64>>,
    /// The largest R-hat of the draws; `None` where none were taken or it has no value.
    pub r_hat: Option<f64>,
    /// Hyperparameters by name.
    pub hyperparameters: Vec<Hyperparameter>,
    /// Descents of the search for the highest marginal likelihood, and how many agreed.
    pub descents: [u64; 2],
    /// Residuals.
    pub residuals: Vec<PhaseResidual>,
    /// Readings left out one by one.
    pub left_out: Check,
    /// Readings held out.
    pub held_out: Check,
    /// Along each input.
    pub curves: Vec<Curve>,
    /// Warnings.
    pub findings: Vec<String>,
}

/// What would become of a parameter if the discrepancy were free beside it, to first order; in the mode `joint` what became of
/// it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Confounded {
    /// Unknown of the calibration.
    pub name: String,
    /// Its posterior standard deviation, SI.
    pub sd: f64,
    /// The same with the discrepancy free, SI.
    pub free_sd: f64,
    /// By how much its mean would move, SI.
    pub shift: f64,
    /// Share of what the readings say of it alone that the discrepancy could say as well.
    pub absorbed: f64,
    /// Whether parameter and discrepancy cannot be told apart by these data.
    pub is_confounded: bool,
}

/// A parameter that was inferred together with the discrepancies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct JointParameter {
    /// Quantiles of 2.5 % and 97.5 %, SI.
    pub interval: [f64; 2],
    /// Rank-normalised split R-hat.
    pub rhat: Option<f64>,
    /// Effective sample size of the bulk.
    pub ess_bulk: Option<f64>,
    /// Effective sample size of the tails.
    pub ess_tail: Option<f64>,
}

/// The posterior of the parameters together with the discrepancies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Joint {
    /// Whether the chains converged.
    pub converged: bool,
    /// What stands against them.
    pub objections: Vec<String>,
    /// Chains and draws of each.
    pub chains: [u64; 2],
    /// Unknowns of the calibration.
    pub order: Vec<String>,
    /// The same with what is known of each.
    pub parameters: BTreeMap<String, JointParameter>,
    /// Their draws; hyperparameters of the same draws stand with the sensors.
    pub draws: KeptDraws,
    /// Numbers of the posterior with their Monte Carlo errors.
    pub key_numbers: Vec<KeyNumber>,
}

/// Result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Output {
    /// Whether the chains of the calibration and of the hyperparameters converged.
    pub converged: bool,
    /// The calibration.
    pub source: String,
    /// Draws of the calibration (in the mode `joint` of both together) that were used, and those of which a phase has no solution.
    pub draws: [u64; 2],
    /// Unknowns of the calibration.
    pub unknowns: Vec<String>,
    /// Their posterior means, in the mode `joint` those beside the discrepancies, SI.
    pub means: Vec<f64>,
    /// Largest part of a residual that is not linear in the unknowns over the draws, in standard deviations of the noise.
    pub nonlinearity: Option<f64>,
    /// Inputs that the discrepancy may depend on.
    pub inputs: Vec<String>,
    /// What was tested of every input of the model.
    pub tested: Vec<TestedRange>,
    /// Sensors.
    pub sensors: Vec<SensorDiscrepancy>,
    /// Parameters; none where the posterior's covariance is singular.
    pub parameters: Vec<Confounded>,
    /// What the reader must know.
    pub findings: Vec<String>,
    /// The posterior of parameters and discrepancies together; nothing in the mode `modular`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<Joint>,
}
