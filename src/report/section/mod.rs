//! Sections, a section a file. A section looks at the whole report and builds itself, or `None` where it has
//! nothing to say. To add one, write its file and put its `build` into [`SECTIONS`].

mod adopted;
mod comparison;
mod data;
mod network;
pub mod problem;
mod propagation;
mod provenance;
mod sizing;
mod summary;

use super::page::Section;
use super::view::PassReport;

/// Builds a section, where it applies.
pub type Build = fn(&PassReport<'_>) -> Option<Section>;

/// The sections in the order of the report.
pub const SECTIONS: &[Build] = &[
    summary::build,
    problem::build,
    adopted::build,
    network::build,
    propagation::build,
    sizing::build,
    comparison::build,
    data::build,
    provenance::build,
];
