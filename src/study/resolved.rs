//! A pass with everything looked up: SI units, indices, data read.

use std::path::PathBuf;

use crate::document::Diagnostics;
use crate::inference::measurement::Measurement;
use crate::job::requirement::{Environment, Requirement};
use crate::job::{calibrate, compare, conventional, design, propagate};
use crate::random::Distribution;
use crate::thermal::Model;

use super::model::InputError;
use super::pinned::Pinned;

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
    /// SHA-256 of the canonical JSON of the files as written: pass, parents, model, own rules and criteria.
    pub definition_sha256: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The model.
    pub model: Model,
    /// The parameters' priors, SI, in the model's order.
    pub priors: Vec<Distribution>,
    /// Own errors of the inputs, in the model's order.
    pub input_errors: Vec<InputError>,
    /// Requirements in the order of the file.
    pub requirements: Vec<Requirement>,
    /// Environments in the order of the file.
    pub environments: Vec<Environment>,
    /// Measurements in the order of the file; those whose pinned data are missing are not among them.
    pub measurements: Vec<Measurement>,
    /// Sensors that are left out, with the reason.
    pub ignored_sensors: Vec<IgnoredSensor>,
    /// Jobs in the order of the file.
    pub jobs: Vec<NamedJob>,
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

/// A job with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedJob {
    /// Name.
    pub name: String,
    /// What is to be done.
    pub spec: JobSpec,
}

/// What a job is to do.
#[derive(Clone, Debug, PartialEq)]
pub enum JobSpec {
    /// Propagation.
    Propagate(propagate::Spec),
    /// Model against measurements.
    Compare(compare::Spec),
    /// Parameters from measurements.
    Calibrate(calibrate::Spec),
    /// Stacked worst cases with margins.
    Conventional(conventional::Spec),
    /// The experiment that teaches most.
    Design(design::Spec),
    /// Waits for pinned data.
    Waiting {
        /// The kind.
        kind: &'static str,
        /// Measurements whose data are missing.
        measurements: Vec<String>,
        /// The command that brings them.
        command: String,
    },
    /// This version does not run it.
    NotYet {
        /// The kind.
        kind: &'static str,
        /// The settings as written.
        settings: serde_json::Value,
        /// Why, in a line.
        reason: String,
    },
}

impl JobSpec {
    /// The kind, as in the pass file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Propagate(_) => "propagate",
            Self::Compare(_) => "compare",
            Self::Calibrate(_) => "calibrate",
            Self::Conventional(_) => "conventional",
            Self::Design(_) => "design",
            Self::Waiting { kind, .. } | Self::NotYet { kind, .. } => kind,
        }
    }
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdoptedEffect {
    /// Its name in the pass; its parameters are `NAME.conductance` and so on.
    pub name: String,
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
    /// Pass and job that support it.
    pub evidence: Option<[String; 2]>,
    /// Measurements and environments that have it; empty: all.
    pub applies_to: Vec<String>,
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
    /// Why; empty where only texts change.
    pub because: String,
}
