//! The figures that tell a job's result, one a row: what `bmv diff` holds beside one another.

use super::section::briefs;
use super::view::JobEntry;

/// Names and texts of the figures, in an order of their own for each kind.
pub fn essentials(job: &JobEntry) -> Vec<(String, String)> {
    briefs().find_map(|brief| brief.essentials(job)).unwrap_or_default()
}
