//! A pass with everything looked up: SI units, indices, data read.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use crate::document::{Diagnostic, Diagnostics, Place};
use crate::effect::{Catalogue, GroupPlace};
use crate::inference::likelihood::rows::UsedRow;
use crate::measurement::Measurement;
use crate::random::Distribution;
use crate::thermal::Model;

use super::document::StudyDocument;
use super::external::External;
use super::figure::Figure;
use super::job::NamedJob;
use super::ledger::Content;
use super::model::InputError;
use super::model::surrogate::Surrogate;
use super::pinned::Pinned;
use super::posterior_prior::PosteriorPrior;
use super::requirement::{Environment, Requirement, Statement};
use super::resolve::belongs_to;

/// A pass that can be run.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The study's folder, as the user gave it.
    pub folder: PathBuf,
    /// The pass's file within the folder.
    pub file: String,
    /// Files of its parents within the folder, nearest first.
    pub parents: Vec<String>,
    /// The model's file within the folder.
    pub model_file: String,
    /// Title, for people.
    pub title: String,
    /// Description, for the report.
    pub description: String,
    /// What of the model was reconstructed, and how.
    pub reconstructed: Option<String>,
    /// The document that the reports of the study belong to.
    pub document: Option<Arc<StudyDocument>>,
    /// What people add to the record of the validation that this pass closes.
    pub closing: Option<Closing>,
    /// Figures of the study's own, in the order of the file.
    pub figures: Vec<Figure>,
    /// Every file of the study that was read, by its path within the folder, as it was then.
    pub files: BTreeMap<String, Content>,
    /// SHA-256 of the canonical JSON of the files as written: pass, parents, model, own rules and criteria.
    pub definition_sha256: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The model.
    pub model: Model,
    /// What answers for the model in place of nodes and elements.
    pub external: Option<Arc<External>>,
    /// The surrogate in place of that.
    pub surrogate: Option<Arc<Surrogate>>,
    /// The parameters' priors, SI, in the model's order; where draws stand in for one, the original one.
    pub priors: Vec<Distribution>,
    /// Draws that stand in for priors.
    pub posterior_priors: Vec<PosteriorReference>,
    /// The passes whose calibrations are used.
    pub upstream: Vec<Arc<Pass>>,
    /// How many passes hand their posteriors on, one to the next, up to this one.
    pub handed_on_depth: usize,
    /// Own errors of the inputs, in the model's order.
    pub input_errors: Vec<InputError>,
    /// Requirements in the order of the file.
    pub requirements: Vec<Requirement>,
    /// What the requirements say, in the order of the file.
    pub statements: Vec<Statement>,
    /// Environments in the order of the file.
    pub environments: Vec<Environment>,
    /// Measurements in the order of the file; those whose pinned data are missing are not among them.
    pub measurements: Vec<Measurement>,
    /// Sensors that are left out, with the reason.
    pub ignored_sensors: Vec<IgnoredSensor>,
    /// Jobs in the order of the file.
    pub jobs: Vec<NamedJob>,
    /// Groups as effects see them.
    pub groups: Vec<GroupPlace>,
    /// Physical effects: the program's and the study's own.
    pub catalogue: Arc<Catalogue>,
    /// Jobs that do not run as they are written, though the others do.
    pub refused: Vec<Refused>,
    /// What the pass changes in the model.
    pub changes: Vec<ParameterChange>,
    /// Effects that the pass adopts, in the order of the file.
    pub adopted: Vec<AdoptedEffect>,
    /// Inputs without a stated range, which took the data's smallest and largest value.
    pub ranges_from_data: Vec<String>,
    /// All pinned data.
    pub pinned: Vec<Pinned>,
    /// Pinned data that are not there.
    pub missing: Vec<Pinned>,
    /// Warnings.
    pub warnings: Diagnostics,
}

/// What people add to the record of a validation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Closing {
    /// Where the model holds and where it does not, a sentence each.
    pub domain: Vec<String>,
    /// What became of each discrepancy or anomaly, by its name.
    pub dispositions: Vec<(String, String)>,
    /// What is left to do, a sentence each.
    pub left: Vec<String>,
}

/// A calibration of a study.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Upstream {
    /// File of its pass within the study.
    pub file: String,
    /// Its name.
    pub job: String,
}

/// Draws that stand in for the priors of some parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct PosteriorReference {
    /// The draws; a calibration's are not there before it ran.
    pub draws: PosteriorPrior,
    /// The calibration that gives them; `None` for a file.
    pub from: Option<Upstream>,
    /// Why it does not run now.
    pub blocked: Option<Blocked>,
    /// The readings that it was had from, those behind its own priors with them.
    pub behind: Vec<DataBehind>,
    /// Where the study asks for it.
    pub place: Place,
}

/// Why a job does not run now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocked {
    /// In a line.
    pub reason: String,
    /// Whether its definition is wrong, or that of a job that it builds on; else it waits for data, or for a version that
    /// runs it.
    pub is_wrong: bool,
}

/// Readings behind a posterior.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataBehind {
    /// The calibration.
    pub calibration: Upstream,
    /// The measurement there.
    pub measurement: String,
    /// Rows.
    pub rows: Arc<Vec<UsedRow>>,
}

/// A job that does not run as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// The job.
    pub job: String,
    /// Why, at its place, with what to write instead.
    pub diagnostic: Diagnostic,
}

/// A sensor that is left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IgnoredSensor {
    /// The measurement.
    pub measurement: String,
    /// The sensor.
    pub sensor: String,
    /// Why.
    pub because: String,
}

/// An effect that the pass adds to the model.
#[derive(Clone, Debug, PartialEq)]
pub struct AdoptedEffect {
    /// Its name in the pass; its parameters are `NAME.conductance` and so on.
    pub name: String,
    /// As a diagnosis names it: `conductive-path:baseplate:board`.
    pub id: String,
    /// The effect.
    pub effect: String,
    /// The effect's title.
    pub title: String,
    /// The effect's equation.
    pub equation: String,
    /// The effect's source.
    pub source: String,
    /// The effect's file within the study, where it is the study's own.
    pub file: Option<String>,
    /// Names of its place; of a group the group's.
    pub place: Vec<String>,
    /// What each of the effect's inputs stands for.
    pub inputs: Vec<(String, String)>,
    /// Indices of its parameters in the model.
    pub parameters: std::ops::Range<usize>,
    /// Why.
    pub because: String,
    /// What supports it.
    pub evidence: Option<Evidence>,
    /// Measurements and environments that have it; empty: all.
    pub applies_to: Vec<String>,
    /// Whether it acts on readings alone, which no prediction has.
    pub is_of_readings: bool,
}

impl AdoptedEffect {
    /// Whether a measurement or an environment has it.
    pub fn acts_in(&self, name: &str) -> bool {
        self.applies_to.is_empty() || self.applies_to.iter().any(|own| belongs_to(name, own))
    }
}

/// The job that supports an adopted effect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// File of its pass.
    pub pass: String,
    /// Its name.
    pub job: String,
    /// Probability that the effect is there, as the job stated it.
    pub probability: Option<f64>,
    /// Standard deviations of the sizes that it stated: parameter of the effect, value in the parameter's unit.
    pub sd: Vec<(String, f64)>,
}

/// A change of a parameter against the model's file.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterChange {
    /// The parameter.
    pub name: String,
    /// Unit as written, for people.
    pub unit: String,
    /// Nominal value, SI, before and after.
    pub nominal: [f64; 2],
    /// Prior, SI, before and after.
    pub prior: [Distribution; 2],
    /// Where the prior comes from after the change, if it is draws.
    pub draws: Option<String>,
    /// Why; empty where only texts change.
    pub because: String,
}
