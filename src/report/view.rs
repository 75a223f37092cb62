//! What a report is made of: definitions and outputs of one pass, already computed.

use crate::diagnosis;
use crate::inference::measurement::{Measurement, Rows, Sensor};
use crate::job::{calibrate, compare, conventional, design, goal, predict, propagate, sensitivity};
use crate::random::Distribution;
use crate::study::requirement::{Environment, Requirement};
use crate::thermal::{Model, Quantity};

use crate::study::AdoptedEffect;

use super::history::History;
use super::number::Shown;

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
}

/// A job's output.
#[expect(clippy::large_enum_variant, reason = "a report holds a handful of them")]
#[derive(Clone, Debug, PartialEq)]
pub enum JobResult {
    /// Uncertainty propagation.
    Propagate(propagate::Output),
    /// A calibration carried to environments.
    Predict(Box<predict::Output>),
    /// The conventional way.
    Conventional(conventional::Output),
    /// Model against measurements.
    Compare(compare::Output),
    /// Parameters from measurements.
    Calibrate(Box<calibrate::Output>),
    /// Which physics is missing.
    Diagnose(Box<diagnosis::Output>),
    /// Which parameters matter.
    Sensitivity(sensitivity::Output),
    /// Which parameter must be known how well.
    Goal(Box<goal::Output>),
    /// The experiment that teaches most.
    Design(Box<design::Output>),
}

/// A job with its output.
#[derive(Clone, Debug, PartialEq)]
pub struct JobEntry {
    /// Name in the pass.
    pub name: String,
    /// Kind.
    pub kind: String,
    /// Hash of everything that decides the result.
    pub key: String,
    /// Output.
    pub result: JobResult,
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
    /// The model, adopted effects included.
    pub model: &'a Model,
    /// Priors by parameter name; a parameter without one is fixed at its nominal value.
    pub priors: Vec<Prior>,
    /// Parameters whose prior is draws, with where these come from.
    pub handed_on: Vec<(String, String)>,
    /// Requirements.
    pub requirements: Vec<Requirement>,
    /// Environments.
    pub environments: Vec<Environment>,
    /// Measurements.
    pub measurements: &'a [Measurement],
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
    /// Propagations with their jobs' names.
    pub fn propagations(&self) -> impl Iterator<Item = (&str, &propagate::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Propagate(output) => Some((job.name.as_str(), output)),
            _ => None,
        })
    }

    /// Predictions with their jobs' names.
    pub fn predictions(&self) -> impl Iterator<Item = (&str, &predict::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Predict(output) => Some((job.name.as_str(), &**output)),
            _ => None,
        })
    }

    /// Conventional analyses with their jobs' names.
    pub fn conventionals(&self) -> impl Iterator<Item = (&str, &conventional::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Conventional(output) => Some((job.name.as_str(), output)),
            _ => None,
        })
    }

    /// Comparisons with their jobs' names.
    pub fn comparisons(&self) -> impl Iterator<Item = (&str, &compare::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Compare(output) => Some((job.name.as_str(), output)),
            _ => None,
        })
    }

    /// Calibrations with their jobs' names.
    pub fn calibrations(&self) -> impl Iterator<Item = (&str, &calibrate::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Calibrate(output) => Some((job.name.as_str(), &**output)),
            _ => None,
        })
    }

    /// Diagnoses with their jobs' names.
    pub fn diagnoses(&self) -> impl Iterator<Item = (&str, &diagnosis::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Diagnose(output) => Some((job.name.as_str(), &**output)),
            _ => None,
        })
    }

    /// Sensitivity analyses with their jobs' names.
    pub fn sensitivities(&self) -> impl Iterator<Item = (&str, &sensitivity::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Sensitivity(output) => Some((job.name.as_str(), output)),
            _ => None,
        })
    }

    /// Goal settings with their jobs' names.
    pub fn goals(&self) -> impl Iterator<Item = (&str, &goal::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Goal(output) => Some((job.name.as_str(), &**output)),
            _ => None,
        })
    }

    /// Designs of experiments with their jobs' names.
    pub fn designs(&self) -> impl Iterator<Item = (&str, &design::Output)> {
        self.results.iter().filter_map(|job| match &job.result {
            JobResult::Design(output) => Some((job.name.as_str(), &**output)),
            _ => None,
        })
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
    pub fn is_steady(&self, measurement: &str, rows: &[compare::Row]) -> bool {
        match self.measurements.iter().find(|m| m.name == measurement) {
            Some(found) => matches!(found.rows, Rows::Steady(_)),
            None => rows.iter().filter(|r| r.measurement == measurement).all(|r| r.time_s.is_none()),
        }
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
