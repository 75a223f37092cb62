//! Whether the requirements of a study are met by the given design.

use super::section::briefs;
use super::view::JobEntry;

/// A requirement, and how it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Standing {
    /// In a sentence's part.
    pub words: String,
    /// Whether it is met; not where the samples leave that open.
    pub is_met: bool,
}

/// What a job's result says of the requirements.
pub fn standings(job: &JobEntry) -> Vec<Standing> {
    briefs().find_map(|brief| brief.standings(job)).unwrap_or_default()
}
