//! Sections, a section a file. A section looks at the whole report and builds itself, or `None` where it has
//! nothing to say; one that shows results of a job kind also tells them in brief. One more is a
//! file here with a `SECTION`, and a line in the list below.

pub mod brief;
pub mod design_values;
mod validation;

use brief::ErasedBrief;

use super::history::History;
use super::page::{Section, Statement, Text};
use super::view::PassReport;

/// Builds a section, where it applies.
pub type Build = fn(&PassReport<'_>) -> Option<Section>;

/// A section, as its file gives it.
#[derive(Clone, Copy)]
pub struct Entry {
    /// Builds it.
    pub build: Build,
    /// Results of its kind in brief, where it shows those of a kind.
    pub brief: Option<&'static dyn ErasedBrief>,
    /// Whether a terminal shows it with the results of jobs.
    is_shown: bool,
}

impl Entry {
    /// A section that shows no results of its own.
    const fn plain(build: Build) -> Self {
        Self { build, brief: None, is_shown: false }
    }

    /// A section on results of a kind.
    const fn of_kind(build: Build, brief: &'static dyn ErasedBrief) -> Self {
        Self { build, brief: Some(brief), is_shown: true }
    }

    /// The same for one that a terminal shows by itself, in another form.
    const fn apart(self) -> Self {
        Self { is_shown: false, ..self }
    }
}

/// The sections that show results of jobs, in the order of the report.
pub fn results() -> impl Iterator<Item = Build> {
    SECTIONS.iter().filter(|section| section.is_shown).map(|section| section.build)
}

/// What the sections know in brief of results, whatever their kind.
pub fn briefs() -> impl Iterator<Item = &'static dyn ErasedBrief> {
    SECTIONS.iter().filter_map(|section| section.brief)
}

/// The summary alone.
pub const SUMMARY: Build = summary::build;

/// Calibrations without the figures' tables: posterior, how far its draws can be trusted, evidence.
pub const CALIBRATION: Build = calibration::outlined;

/// What diagnoses say, alone.
pub const DIAGNOSIS: Build = diagnosis::build;

/// Test plans, alone.
pub const TEST_PLAN: Build = test_plan::build;

/// What tuning achieved in comparisons, alone.
pub const TUNED: Build = calibration::achieved_alone;

/// The readings of all comparisons beside their predictions, however many.
pub const READINGS: Build = comparison::readings_alone;

/// The section on the error of a study's passes; not where nothing was measured.
pub fn error_by_pass(history: &History) -> Option<Section> {
    history::section(history)
}

/// What came out of a pass and the key statements of its first screen.
pub fn in_brief(report: &PassReport<'_>) -> (Option<Text>, Vec<Statement>) {
    summary::in_brief(report)
}

/// Why no requirement of a pass may be called met, where its results would call one so.
pub fn objection(report: &PassReport<'_>) -> Option<Text> {
    summary::claims::objection_to_all(report)
}

/// What the names of pictures on the first screen begin with: in full they stand in their own sections.
fn prefix(is_small: bool) -> &'static str {
    if is_small { "first-screen-" } else { "" }
}

/// Which jobs the passes of a study lack for their errors to be stated.
pub fn missing_jobs(history: &History) -> Vec<Text> {
    history.passes.iter().flat_map(history::missing_jobs).collect()
}

/// Declares the sections: a module each, and their order in the report.
macro_rules! sections {
    ($( $visibility:vis $module:ident ),* $(,)?) => {
        $( $visibility mod $module; )*

        /// The sections in the order of the report.
        pub static SECTIONS: &[Entry] = &[$( $module::SECTION ),*];
    };
}

sections! {
    pub summary,
    pub compliance,
    pub problem,
    adopted,
    network,
    surrogate,
    pub propagation,
    sensitivity,
    goal,
    sizing,
    margins_from_history,
    design,
    test_plan,
    comparison,
    calibration,
    diagnosis,
    discrepancy,
    history,
    pub prediction,
    figures,
    pub margins,
    record,
    pub document,
    data,
    provenance,
    glossary,
}
