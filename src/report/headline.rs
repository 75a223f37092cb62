//! What came out of a job, in a line or two.

use super::section::briefs;
use super::view::JobEntry;

/// Findings of a comparison, a design or a calibration and reasons of an advice that are stated.
pub(super) const MOST_FINDINGS: usize = 2;

/// The outcome of a job, a line each.
pub fn headlines(job: &JobEntry) -> Vec<String> {
    briefs().find_map(|brief| brief.headline(job)).unwrap_or_default()
}
