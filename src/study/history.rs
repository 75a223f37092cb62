//! How the passes of a study stand to one another: by which jobs each is judged, and in which order they are stated.

use super::job::{CALIBRATION, JobSpec};
use super::resolved::Pass;

/// The jobs by which a pass is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JudgedBy<'p> {
    /// The comparison with its measurements.
    pub comparison: &'p str,
    /// The calibration whose tuned state the comparison shows, else the pass's first.
    pub calibration: Option<&'p str>,
    /// Where there is none: the first job that fits the model to what the comparison compares, which knows the tuned error.
    pub diagnosis: Option<&'p str>,
}

/// The jobs by which a pass is judged: its first comparison that shows a tuned state, else its first. `None` where the
/// pass compares nothing.
pub fn judged_by(pass: &Pass) -> Option<JudgedBy<'_>> {
    let comparisons = || pass.jobs.iter().filter_map(|job| Some((job.name.as_str(), job.spec.comparison()?)));
    let (comparison, own) =
        comparisons().find(|(_, own)| own.calibration.is_some()).or_else(|| comparisons().next())?;
    let is_calibration = |spec: &JobSpec| spec.resolved().is_some() && spec.kind() == CALIBRATION;
    let first = || pass.jobs.iter().find(|job| is_calibration(&job.spec)).map(|job| job.name.as_str());
    let calibration = own.calibration.or_else(first);
    let fits = |spec: &JobSpec| spec.kind() != CALIBRATION && spec.inference().is_some_and(|fit| fit.data == own.data);
    let fitting = pass.jobs.iter().find(|job| fits(&job.spec)).map(|job| job.name.as_str());
    Some(JudgedBy { comparison, calibration, diagnosis: fitting.filter(|_| calibration.is_none()) })
}

/// The order in which passes are stated: each after its parents, else as given. A pass is its file and those of its
/// parents, nearest first.
pub fn order(passes: &[(&str, &[String])]) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::new();
    while order.len() < passes.len() {
        let waits = |position: usize| {
            let (_, parents) = passes[position];
            (0..passes.len()).any(|other| {
                other != position && !order.contains(&other) && parents.iter().any(|parent| parent == passes[other].0)
            })
        };
        let mut left = (0..passes.len()).filter(|position| !order.contains(position));
        // A loaded pass has no circle of parents; were there one, its first member would be stated first.
        let Some(next) = left.clone().find(|&position| !waits(position)).or_else(|| left.next()) else { break };
        order.push(next);
    }
    order
}
