//! Why jobs of a pass do not run now.

use crate::document::suggest;

use super::job::JobSpec;
use super::resolved::{Blocked, Pass, PosteriorReference};

/// Parameters named in a message.
const NAMED: usize = 12;

/// Why a job of a pass does not run now; `None` where it does.
pub fn blocked(pass: &Pass, name: &str) -> Option<Blocked> {
    if let Some(refused) = pass.refused.iter().find(|refused| refused.job == name) {
        return Some(Blocked { reason: refused.diagnostic.message.clone(), is_wrong: true });
    }
    match &pass.jobs.iter().find(|job| job.name == name)?.spec {
        JobSpec::Resolved(spec) => spec.blocked(pass),
        JobSpec::Waiting { measurements, command, .. } => Some(Blocked::waits(format!(
            "the data of {} are not here; bring them with `{command}`",
            measurements.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
        ))),
        JobSpec::NotYet { reason, .. } => Some(Blocked::waits(reason.clone())),
    }
}

impl Blocked {
    /// By data or a version that is not there.
    pub fn waits(reason: String) -> Self {
        Self { reason, is_wrong: false }
    }

    /// By a definition that is wrong.
    pub fn wrong(reason: String) -> Self {
        Self { reason, is_wrong: true }
    }

    /// Of a job that builds on the posterior of one that is blocked itself.
    pub fn after(&self, source: &str) -> Self {
        let reason = format!("it builds on the posterior of {source}, which does not run: {}", self.reason);
        Self { reason, is_wrong: self.is_wrong }
    }
}

impl PosteriorReference {
    /// Why a job that takes these draws does not run.
    pub fn blocks(&self) -> Option<Blocked> {
        Some(self.blocked.as_ref()?.after(&self.draws.source))
    }
}

/// Draws that stand in for priors of the parameters that a job infers.
pub fn draws_among(pass: &Pass, parameters: &[usize]) -> Vec<PosteriorReference> {
    let used =
        |reference: &&PosteriorReference| reference.draws.parameters.iter().any(|index| parameters.contains(index));
    pass.posterior_priors.iter().filter(used).cloned().collect()
}

/// Why a job that takes independent distributions as priors does not run where some are draws.
pub fn by_draws(pass: &Pass) -> Option<Blocked> {
    let reference = pass.posterior_priors.first()?;
    let names = suggest::listed(reference.draws.names.iter().map(String::as_str), NAMED);
    let source = &reference.draws.source;
    Some(Blocked::wrong(format!("it takes independent distributions as priors, and {names} has the draws of {source}")))
}
