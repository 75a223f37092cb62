//! What a report is made of: definitions and outputs of one pass, already computed.

use std::sync::Arc;

use crate::effect::GroupPlace;
use crate::job::compare;
use crate::job::kind::{AnyOutput, JobKind};
use crate::measurement::{Measurement, Rows, Sensor};
use crate::random::Distribution;
use crate::study::requirement::{Environment, Requirement, Statement};
use crate::thermal::{Model, Quantity};

use crate::study::{AdoptedEffect, Closing, StudyDocument};

use super::history::History;
use super::number::Shown;
use super::section::prediction::tested::Tested;

/// A parameter's prior, SI.
pub type Prior = (String, Distribution);

/// A change that the pass makes to its parent or its model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ParameterChange {
    /// What is changed, such as a parameter's name.
    pub what: String,
    /// Before, in words.
    pub before: String,
    /// After, in words.
    pub after: String,
    /// The reason given.
    pub because: String,
}

/// A file that the results depend on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileHash {
    /// Path within the study.
    pub path: String,
    /// SHA-256 of its bytes, lower-case hex.
    pub sha256: String,
    /// What it is: `model`, `pass`, `data`, `effect`.
    pub role: String,
    /// Of a model its entries, by section and name, with their texts.
    pub entries: Vec<(String, String)>,
}

/// A job with its output.
#[derive(Clone, Debug)]
pub struct JobEntry {
    /// Name in the pass.
    pub name: String,
    /// Hash of everything that decides the result.
    pub key: String,
    /// Output, which knows its kind.
    pub output: Arc<dyn AnyOutput>,
    /// Whether the model has adopted effects, so that at its nominal parameters it is not the one that was delivered.
    pub has_adopted: bool,
}

/// What the model at its nominal parameters is called.
pub fn untuned(has_adopted: bool) -> &'static str {
    if has_adopted { "with adopted effects at their nominal sizes" } else { "as delivered" }
}

impl JobEntry {
    /// What the model at its nominal parameters is called.
    pub fn untuned(&self) -> &'static str {
        untuned(self.has_adopted)
    }

    /// The output, if the job is of this kind.
    pub fn output_of<K: JobKind>(&self) -> Option<&K::Output> {
        self.output.as_any().downcast_ref().filter(|_| self.output.kind() == K::NAME)
    }
}

/// The passes before and after one in its study, by their names without `.json`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Siblings {
    /// The one before.
    pub previous: Option<String>,
    /// The one after.
    pub next: Option<String>,
}

/// Everything that a report is made of.
#[derive(Clone, Debug)]
pub struct PassReport<'a> {
    /// Title of the pass.
    pub title: String,
    /// File of the pass within the study.
    pub pass_file: String,
    /// Name of the study.
    pub study: String,
    /// Description, for people.
    pub description: String,
    /// Set where numbers were reconstructed instead of taken from the source that the study follows: what and how.
    pub reconstructed: Option<String>,
    /// The document that the reports of the study belong to.
    pub document: Option<StudyDocument>,
    /// The passes before and after this one; `None` where the report has no others beside it.
    pub siblings: Option<Siblings>,
    /// SHA-256 of what the manifest says of where the report comes from; `None` where there is no manifest.
    pub origin_sha256: Option<String>,
    /// What people add to the record of the validation that the pass closes; `None` where it closes none.
    pub closing: Option<Closing>,
    /// Figures of the study's own.
    pub figures: Vec<crate::study::figure::Figure>,
    /// The model, adopted effects included.
    pub model: &'a Model,
    /// Groups of the model, in the order of its file and then those that it implies.
    pub groups: &'a [GroupPlace],
    /// Priors by parameter name; a parameter without one is fixed at its nominal value.
    pub priors: Vec<Prior>,
    /// Parameters whose prior is draws, with where these come from.
    pub posterior_priors: Vec<(String, String)>,
    /// Requirements.
    pub requirements: Vec<Requirement>,
    /// What the requirements say.
    pub statements: Vec<Statement>,
    /// Environments.
    pub environments: Vec<Environment>,
    /// Measurements.
    pub measurements: &'a [Measurement],
    /// What was tested for each prediction.
    pub tested: Vec<Tested>,
    /// Changes against the parent pass.
    pub changes: Vec<ParameterChange>,
    /// Effects that the pass adds to the model.
    pub adopted: Vec<AdoptedEffect>,
    /// Jobs in the order of the pass.
    pub results: Vec<JobEntry>,
    /// The error of the passes before this one, and its own.
    pub history: Option<History>,
    /// Files that the results depend on.
    pub files: Vec<FileHash>,
    /// Version of the numeric engine.
    pub engine_version: String,
    /// Command that makes the report anew.
    pub command: String,
    /// What the reader must know before believing: jobs that did not run, data that are not there.
    pub warnings: Vec<String>,
}

impl PassReport<'_> {
    /// Outputs of a kind with their jobs' names.
    pub fn outputs<K: JobKind>(&self) -> impl Iterator<Item = (&str, &K::Output)> {
        self.results.iter().filter_map(|job| Some((job.name.as_str(), job.output_of::<K>()?)))
    }

    /// What the model at its nominal parameters is called.
    pub fn untuned(&self) -> &'static str {
        untuned(!self.adopted.is_empty())
    }

    /// The measured quantity of a sensor.
    fn measured(&self, measurement: &str, sensor: &str) -> Option<&Quantity> {
        let sensor = self.sensor(measurement, sensor)?;
        self.model.quantities.get(sensor.quantity)
    }

    /// A sensor by the names of its measurement and itself.
    pub fn sensor(&self, measurement: &str, sensor: &str) -> Option<&Sensor> {
        let measurement = self.measurements.iter().find(|m| m.name == measurement)?;
        measurement.sensors.iter().find(|s| s.name == sensor)
    }

    /// How a sensor's readings are shown; `unit` is the SI unit of the readings.
    pub fn sensor_shown(&self, measurement: &str, sensor: &str, unit: &str) -> Shown {
        Shown::quantity(unit, self.measured(measurement, sensor).is_some_and(|q| q.is_temperature))
    }

    /// Whether a measurement is one of steady phases; from its rows where it is not at hand.
    pub fn is_steady(&self, measurement: &str, readings: &compare::Readings) -> bool {
        match self.measurements.iter().find(|m| m.name == measurement) {
            Some(measurement) => matches!(measurement.rows, Rows::Steady(_)),
            None => {
                let mut moments = readings.of_measurement(measurement).flat_map(compare::Table::moments_read);
                moments.all(|moment| moment.time_s.is_none())
            }
        }
    }

    /// Nominal value of a parameter or input, SI, by its name.
    pub fn nominal_design(&self, name: &str) -> Option<f64> {
        let parameter = self.model.parameters.iter().find(|own| own.name == name).map(|own| own.nominal);
        parameter.or_else(|| self.model.inputs.iter().find(|own| own.name == name).map(|own| own.nominal))
    }

    /// How the quantity of a requirement is shown.
    pub fn requirement_shown(&self, requirement: &Requirement) -> Shown {
        self.model
            .quantities
            .get(requirement.quantity)
            .map_or_else(|| Shown::si(""), |q| Shown::quantity(&q.unit, q.is_temperature))
    }

    /// How a quantity is shown, by its name.
    pub fn quantity_shown(&self, name: &str, unit: &str) -> Shown {
        Shown::quantity(unit, self.model.quantities.iter().any(|q| q.name == name && q.is_temperature))
    }
}
