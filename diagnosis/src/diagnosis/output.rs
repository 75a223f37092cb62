//! The result of a diagnosis.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::document::counted;
use crate::inference::prior::joint_prior::Fit;
use crate::measurement::Doubt;

/// What is said of a model against its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No test finds anything.
    Adequate,
    /// One set of effects explains the misfit.
    Identified,
    /// Several sets explain it about equally.
    Ambiguous,
    /// Something is missing and nothing in the catalogue explains it.
    Unexplained,
}

impl Verdict {
    /// Whether it names one set to adopt: what the diagnosis proposes and what `bmv adopt` takes unasked.
    pub fn names_one_set(self) -> bool {
        self == Self::Identified
    }

    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::Identified => "identified",
            Self::Ambiguous => "ambiguous",
            Self::Unexplained => "unexplained",
        }
    }
}

/// An error on the fitted rows and on the held-out ones, K.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Rmse {
    /// On the fitted rows.
    pub train: Option<f64>,
    /// On the held-out rows.
    pub held_out: Option<f64>,
}

/// How an effect changes the errors, K: before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RmseChange {
    /// On the fitted rows.
    pub train: [Option<f64>; 2],
    /// On the held-out rows.
    pub held_out: [Option<f64>; 2],
}

/// One test of the family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Test {
    /// What was tested.
    pub name: String,
    /// What it found worst.
    pub at: String,
    /// Its p-value, corrected for its own multiplicity.
    pub p: f64,
}

/// The misfit of the tuned model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Misfit {
    /// Sum of squares of the whitened residuals over the readings fitted less the unknowns, as in a calibration; the noise is
    /// that of `noise`, parts of which may have been estimated here.
    pub reduced_chi2: f64,
    /// Probability of a misfit as clear as this where nothing is missing, over all tests.
    pub family_wise_p: f64,
    /// Errors of the tuned model.
    pub rmse_k: Rmse,
    /// The tests behind it.
    pub tests: Vec<Test>,
}

/// Factor by which an error has risen, and that is said.
pub const RISES: f64 = 1.05;

/// A number with its spread and unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Amount {
    /// Mean, with the bounds of all parameters considered (of the logarithm where the prior is logarithmic); the bound where the fit
    /// pressed it against one.
    pub value: f64,
    /// Standard deviation, with the bounds considered; 0 at a bound.
    pub sd: f64,
    /// Most probable value together with all other parameters: errors and heats are those of the fit with it.
    pub most_probable: f64,
    /// Unit.
    pub unit: String,
    /// Whether the fit pressed it against a bound.
    pub at_bound: bool,
    /// Of what it is a value, where it says from which value of that on an effect acts, and that is no clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<Level>,
}

/// Of what a parameter is a value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Level {
    /// An input, or a node for its temperature.
    pub of: String,
    /// Whether it is a temperature, in K, and no difference of two.
    pub is_temperature: bool,
}

/// Why an effect goes before a more probable one of its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precedence {
    /// A larger share of its own probability is given to errors of the model.
    ModelError,
    /// Held-out readings speak against the other.
    HeldOut,
    /// The fitted readings speak against the other.
    Fitted,
    /// It is a law, the other an unknown function.
    Law,
    /// It acts on a group, the other at a single place.
    Group,
    /// The other would have to be a hundred times as large as is plausible.
    Size,
    /// The other follows a heat that a control makes.
    Control,
    /// It is heat that was logged, the other heat that goes by a clock.
    Logged,
    /// It is heat that was logged, the other a change of a path or a load that follows the same power or irradiance.
    ChangeByHeat,
    /// The other takes several inputs.
    Inputs,
    /// The whole selected set is more probable than those with the other in its place.
    Set,
    /// The other is that probable at another step only.
    OtherStep,
    /// A prior is in question, and the other adds something to the model.
    Prior,
    /// Its set has the fewest parameters.
    FewestParameters,
    /// Its set is the most probable one; the other is that probable over all its sets together.
    BestSet,
}

/// Heat that an effect gives a node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectHeat {
    /// The node.
    pub node: String,
    /// The measurement.
    pub measurement: String,
    /// The phase; `None` in a transient.
    pub phase: Option<String>,
    /// Middle of the stretch of a transient, s, over which it is the mean.
    pub time_s: Option<f64>,
    /// Heat into the node, W.
    pub watts: f64,
}

/// The inferred start temperature of a node that an effect adds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StartResult {
    /// The measurement.
    pub measurement: String,
    /// The node's name.
    pub node: String,
    /// The most probable temperature, K.
    pub most_probable_k: f64,
    /// Mean and standard deviation of its normal prior, K.
    pub prior_k: [f64; 2],
    /// Bounds of the prior, K.
    pub bounds_k: [f64; 2],
}

/// An effect as an explanation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectResult {
    /// Such as `conductive-path:baseplate:board`.
    pub id: String,
    /// The effect.
    pub effect: String,
    /// Its title.
    pub title: String,
    /// Names of its place.
    #[serde(rename = "where")]
    pub place: Vec<String>,
    /// Kind of its place.
    pub where_kind: String,
    /// What its inputs stand for.
    pub input: Option<String>,
    /// Probability that it is missing.
    pub probability: f64,
    /// Probability that errors of the model itself are what it stands for; the probability that it is missing has lost this share.
    #[serde(default, skip_serializing_if = "is_none")]
    pub model_error: f64,
    /// Log Bayes factor for it, the rest of its best set given.
    pub log_bayes_factor: f64,
    /// The same with the amplitude's prior at half and at double scale.
    pub log_bayes_factor_scales: Option<[f64; 2]>,
    /// Whether its fit leaves every prediction where it is without it: the data speak against it, or cannot see it. Tables
    /// leave it out.
    #[serde(default)]
    pub changes_nothing: bool,
    /// Number of its group; effects of one group cannot be told apart with these data.
    pub group: Option<u64>,
    /// Why it leads its group although another one is more probable, where that is so and a rule says why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub precedence: Option<Precedence>,
    /// Its parameters at the fit of its best set.
    pub amplitudes: BTreeMap<String, Amount>,
    /// Date and time from which on it is there, where it sets in at a date and the record says when its time is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub since: Option<String>,
    /// Reference temperature of its law, K, where that is not 20 degC: the temperature about which its place worked, to 10 degC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_k: Option<f64>,
    /// Errors without it and with it, the rest of its best set given.
    pub rmse_k: RmseChange,
    /// Start temperatures of the nodes that it adds, where they were inferred.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub starts: Vec<StartResult>,
    /// Heat that it gives the node to which it gives most, W: smallest and largest over the fitted rows, negative where
    /// it takes heat; `None` where it moves none, as on sensors.
    pub watts: Option<[f64; 2]>,
    /// How many times as wide as the catalogue's the priors of its amplitudes had to be.
    #[serde(default = "one")]
    pub prior_width: f64,
    /// Whether it carries no more heat than the model moves; asked where its priors had to be wider.
    #[serde(default)]
    pub within_model: bool,
    /// Heat that it gives each node, by phase or stretch of time; empty for effects that are less probable than 0.001.
    #[serde(default)]
    pub carries: Vec<EffectHeat>,
    /// What it is confused with, from its file.
    pub confused_with: Vec<String>,
    /// What would tell it apart, from its file.
    pub separate: String,
    /// What of the model or the data should be checked before it is believed: numbers of which it has the law, and sizes of
    /// sign errors and wrong units.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hints: Vec<String>,
    /// Its file, where it is a law that describes the curve of another effect of its group within its error: to be adopted in
    /// the curve's stead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<EffectFile>,
}

/// An effect that a diagnosis proposes to a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct EffectFile {
    /// Its name: `effects/NAME.json` of the study.
    pub name: String,
    /// Its law in a word or two.
    pub law: String,
    /// The file's text.
    pub text: String,
    /// Ids of small effects of the selected set that are not needed beside it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub needless: Vec<String>,
}

fn is_none(probability: &f64) -> bool {
    *probability == 0.0
}

fn yes() -> bool {
    true
}

fn one() -> f64 {
    1.0
}

/// A set of effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelResult {
    /// Ids.
    pub effects: Vec<String>,
    /// Log evidence.
    pub log_evidence: f64,
    /// Probability.
    pub probability: f64,
    /// Sum of squares of the whitened residuals.
    pub chi_square: f64,
    /// Errors.
    pub rmse_k: Rmse,
}

/// What the effects of a group are together, where they are laws of one thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroupKind {
    /// Number of the group.
    pub group: u64,
    /// What they are, names in backticks: a loss of heat from `bar` to its surroundings.
    pub what: String,
    /// What the readings leave open of it, as the beginning of a relative clause: whose law.
    pub open: String,
    /// Probability that one of them is missing, 0 to 1.
    pub probability: f64,
}

/// A step from one set of effects to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StoryStep {
    /// Id of the effect that is added; `None` where the story ends.
    pub effect: Option<String>,
    /// Probability of it among all that may be added at this step and nothing; at the end, of nothing.
    pub probability: f64,
    /// Errors before and after it, K.
    pub rmse_k: RmseChange,
    /// Whether these are beside the later steps, as the effect shows only beside them; else beside the earlier ones.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub beside_later: bool,
    /// Ids of what else is likely at this step, most probable first.
    pub alternatives: Vec<String>,
    /// At the end, whether more is missing and it is open where: `alternatives` are what may be next.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub open: bool,
}

/// An effect that the data cannot see.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Unseen {
    /// Id.
    pub id: String,
    /// Why.
    pub why: String,
}

/// An amplitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Detectable {
    /// Amplitude that would have shown in nine of ten cases.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// A sensor's noise as it was used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseResult {
    /// Standard deviation of the noise of one reading, SI.
    pub sigma: f64,
    /// Standard deviation of the model error that is allowed for beside it, SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model_error: Option<f64>,
    /// Error of an independent reading of the same weight, as a standard deviation, SI, where a model error is allowed for:
    /// larger than that of both, since a model's errors are nearly the same in many successive readings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counts_as: Option<f64>,
    /// Correlation time, s.
    pub correlation_time_s: Option<f64>,
    /// Share of the variance that is correlated.
    pub correlated_share: f64,
    /// Unit of sigma.
    pub unit: String,
    /// Whether the diagnosis estimated it.
    pub estimated: bool,
}

/// A value with its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Setting {
    /// SI.
    pub value: f64,
    /// SI unit.
    pub unit: String,
}

/// Conditions that would part rivals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DiscriminatingExperiment {
    /// Ids of the rivals.
    pub between: Vec<String>,
    /// Inputs to set.
    pub conditions: BTreeMap<String, Setting>,
    /// Probability of telling them apart.
    pub probability: f64,
    /// The same for repeating the best of the old phases.
    pub repeat_probability: f64,
    /// Whether no red limit of a node is passed there.
    pub limits_ok: bool,
    /// Whether no sensor would read far beyond all readings so far, but where its node's limits allow it.
    #[serde(default = "yes")]
    pub near_tested: bool,
    /// What the rivals predict there: sensor, and each rival's reading, K.
    pub predictions: BTreeMap<String, Vec<f64>>,
}

/// Sets that no steady phase within the stated ranges tells apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OneThing {
    /// The selected set, then those that are the same as it here.
    pub sets: Vec<String>,
    /// Largest probability of telling one of them from the first.
    pub probability: f64,
    /// The same for repeating the best of the old phases.
    pub repeat_probability: f64,
}

/// A step of one input that tells rivals apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DiscriminatingStep {
    /// The input that steps, from a steady state.
    pub input: String,
    /// Its value before.
    pub from: Setting,
    /// Its value after.
    pub to: Setting,
    /// The measurement in whose first row the other inputs have the values that they keep.
    pub like: String,
    /// How long the step is watched, s.
    pub duration_s: f64,
    /// The sensor that is slowest to follow.
    pub slowest: String,
    /// Time in which all but 1/e of its change is done, s.
    pub time_constant_s: f64,
    /// Probability of telling the rivals apart.
    pub probability: f64,
    /// Whether no red limit of a node is passed.
    pub limits_ok: bool,
    /// Whether no sensor would read far beyond all readings so far, but where its node's limits allow it.
    pub near_tested: bool,
    /// Whether the data have the input at both values.
    pub was_set: bool,
    /// Whether it must end then: later a limit would be passed, or sensors would read far beyond all readings so far.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub ends_early: bool,
}

/// Sets that differ in what stores heat alone: no steady phase can part them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OnlyInTransients {
    /// The selected set, then its rivals.
    pub between: Vec<String>,
    /// What would part them; nothing where no input can be set within a range.
    pub step: Option<DiscriminatingStep>,
}

/// Heat that the model lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Heat {
    /// The node.
    pub node: String,
    /// The phase, in steady data.
    pub phase: Option<String>,
    /// The instant, in transients, s.
    pub time_s: Option<f64>,
    /// Heat, W.
    pub watts: f64,
    /// Its standard deviation, W.
    pub sd: f64,
}

/// An input that the missing heat goes with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GoesWith {
    /// The node.
    pub node: String,
    /// The input.
    pub input: String,
    /// Slope, W per SI unit of the input.
    pub slope: f64,
    /// p-value of no relation, corrected for the number of inputs and nodes.
    pub p: f64,
}

/// What the held-out rows say of the selected set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldOutTest {
    /// Mean fall of the squared error in units of the noise, a block; above 0 where the set is better.
    pub gain: f64,
    /// Its standard error; `None` with one block, which has no scatter.
    pub se: Option<f64>,
    /// Blocks.
    pub blocks: u64,
    /// Sum of squares of the held-out errors of the set over the covariance of noise and parameters.
    pub chi_square: Option<f64>,
    /// Held-out readings.
    pub readings: u64,
    /// Probability of a larger sum of squares where nothing else is missing.
    pub p: Option<f64>,
    /// Whether it speaks against the set.
    pub veto: bool,
}

/// A posterior that is the prior of some parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PriorOfDraws {
    /// Where it comes from.
    pub source: String,
    /// The parameters.
    pub parameters: Vec<String>,
    /// Number of draws.
    pub draws: u64,
    /// How many independent draws they are worth.
    pub effective: f64,
    /// Whether the chains that they come from converged.
    pub converged: bool,
    /// How well the normal distribution of their scores describes them.
    pub fit: Fit,
}

/// The result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Output {
    /// The verdict.
    pub verdict: Verdict,
    /// The verdict in sentences.
    pub words: Vec<String>,
    /// Probability that nothing is missing.
    pub probability_nothing: f64,
    /// Probability that something is missing which no set explains.
    pub probability_unexplained: f64,
    /// Whether a misfit that nothing explains may be no more than small errors everywhere: the tests find nothing definite.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub only_small_errors: bool,
    /// The misfit of the tuned model.
    pub misfit: Misfit,
    /// Effects: the selected ones in their order, then by probability.
    pub effects: Vec<EffectResult>,
    /// Sets by probability; nothing and those that lead to the selected set are always among them.
    pub models: Vec<ModelResult>,
    /// The set that would be adopted; in the order of `steps` where there are any.
    pub selected: Vec<String>,
    /// What groups are of which all members are laws of one thing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kinds: Vec<GroupKind>,
    /// How the set came about, effect by effect, where the model is taken to be a little wrong everywhere.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<StoryStep>,
    /// Effects that these data cannot see.
    pub unseen: Vec<Unseen>,
    /// Amplitudes that would have shown with 90 % power, by id.
    pub detectable: BTreeMap<String, Detectable>,
    /// Noise of each sensor; where several measurements have a sensor of one name, that of the last.
    pub noise: BTreeMap<String, NoiseResult>,
    /// Conditions that would part the rivals of an ambiguous group.
    #[serde(rename = "separating_experiment")]
    pub discriminating_experiment: Option<DiscriminatingExperiment>,
    /// Rivals of an ambiguous group that no allowed steady phase tells apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_thing: Option<OneThing>,
    /// Rivals of an ambiguous group that differ in what stores heat alone, and the step that tells them apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub only_in_transients: Option<OnlyInTransients>,
    /// Heat that the tuned model lacks.
    pub heat: Vec<Heat>,
    /// What that heat goes with.
    pub goes_with: Vec<GoesWith>,
    /// What the held-out rows say.
    pub held_out_test: Option<HeldOutTest>,
    /// Family-wise p of what the selected set leaves.
    pub remaining_p: Option<f64>,
    /// Numbers of effects screened, pairs screened and sets fitted.
    pub looked_at: [u64; 3],
    /// Posteriors that are priors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub posterior_priors: Vec<PriorOfDraws>,
    /// That chains behind a prior did not converge; `None` where none did so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converged: Option<bool>,
    /// What is doubtful about the data, a start apart from its first readings first: to be checked before the verdict is
    /// believed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<Doubt>,
    /// What went wrong on the way.
    pub warnings: Vec<String>,
}

/// Doubts that are stated in full.
const MOST_DOUBTS: usize = 3;

impl Output {
    /// What must be said before the verdict, whatever it is: doubts of the data, with what mends them.
    pub fn before_the_verdict(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.doubts.iter().take(MOST_DOUBTS).map(Doubt::in_words).collect();
        let more = self.doubts.len().saturating_sub(MOST_DOUBTS);
        if more > 0 {
            lines.push(format!("{} of the data: bmv diagnose --json lists all.", counted(more, "more doubt")));
        }
        lines
    }
}
