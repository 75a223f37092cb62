//! Sections, a section a file. A section looks at the whole report and builds itself, or `None` where it has
//! nothing to say. To add one, write its file and put its `build` into [`SECTIONS`].

mod adopted;
mod calibration;
mod comparison;
mod data;
pub mod design;
mod diagnosis;
pub mod goal;
mod history;
mod network;
mod prediction;
pub mod problem;
pub mod propagation;
mod provenance;
pub mod sensitivity;
mod sizing;
mod summary;

use super::history::History;
use super::page::{Section, Text};
use super::view::PassReport;

/// Builds a section, where it applies.
pub type Build = fn(&PassReport<'_>) -> Option<Section>;

/// The sections that show results of jobs, in the order of the report.
pub const RESULTS: &[Build] = &[
    propagation::build,
    sensitivity::build,
    goal::build,
    sizing::build,
    design::build,
    comparison::build,
    diagnosis::build,
    prediction::build,
];

/// The summary alone.
pub const SUMMARY: Build = summary::build;

/// Calibrations without the figures' tables: posterior, how far its draws can be trusted, evidence.
pub const CALIBRATION: Build = calibration::outlined;

/// What diagnoses say, alone.
pub const DIAGNOSIS: Build = diagnosis::build;

/// What tuning achieved in comparisons, alone.
pub const TUNED: Build = calibration::achieved_alone;

/// The readings of all comparisons beside their predictions, however many.
pub const READINGS: Build = comparison::readings_alone;

/// The section on the error of a study's passes; not where nothing was measured.
pub fn error_by_pass(history: &History) -> Option<Section> {
    history::section(history)
}

/// Which jobs the passes of a study lack for their errors to be told.
pub fn missing_jobs(history: &History) -> Vec<Text> {
    history.passes.iter().flat_map(history::missing_jobs).collect()
}

/// The sections in the order of the report.
pub const SECTIONS: &[Build] = &[
    summary::build,
    problem::build,
    adopted::build,
    network::build,
    propagation::build,
    sensitivity::build,
    goal::build,
    sizing::build,
    design::build,
    comparison::build,
    calibration::build,
    diagnosis::build,
    history::build,
    prediction::build,
    data::build,
    provenance::build,
];
