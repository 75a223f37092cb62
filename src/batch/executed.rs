//! What became of the jobs of passes.

use super::LoadedPass;
use crate::runner::{Finished, Plan, RunSummary};
use crate::study::Pass;
use crate::study::history::judged_by;

/// Passes whose jobs were run.
pub struct Executed {
    /// The passes that were asked for.
    pub passes: Vec<LoadedPass>,
    /// Their parents, where those were wanted too.
    pub parents: Vec<LoadedPass>,
    /// All jobs.
    pub plan: Plan,
    /// What became of them.
    pub summary: RunSummary,
    /// Whether it was interrupted.
    pub is_interrupted: bool,
}

impl Executed {
    /// Results of a pass's wanted jobs: position in the plan, and the finished job.
    pub fn results<'e>(&'e self, pass: &'e LoadedPass) -> impl Iterator<Item = (usize, &'e Finished)> {
        pass.jobs.iter().filter_map(|id| Some((self.plan.find(id)?, self.summary.finished(id)?)))
    }

    /// Passes and names of the jobs whose sampler did not converge.
    pub fn not_converged(&self) -> impl Iterator<Item = (&LoadedPass, &str)> {
        self.passes.iter().flat_map(move |pass| {
            let unconverged = self.results(pass).filter(|(_, job)| !is_converged(job));
            unconverged.map(move |(position, _)| (pass, self.plan.nodes()[position].name.as_str()))
        })
    }
}

/// Whether a job is one of those by which its pass is judged.
pub fn is_judge(pass: &Pass, name: &str) -> bool {
    judged_by(pass).is_some_and(|judge| judge.comparison == name || judge.calibration.or(judge.diagnosis) == Some(name))
}

/// A sampler's result says whether it converged; other results do not speak of it.
fn is_converged(job: &Finished) -> bool {
    job.stored.value.get("converged").and_then(serde_json::Value::as_bool).unwrap_or(true)
}
