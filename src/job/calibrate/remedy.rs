//! What mends a calibration whose chains did not converge: the fields of its settings, and what to write there.

use super::output::Output;
use super::sampler::Sampler;

/// Draws of `independence-metropolis` that suffice where the posterior is nearly normal, for 15 unknowns and more.
pub const MANY_DRAWS: u64 = 8000;
/// Effective draws that are asked for.
const WANTED: f64 = 400.0;
/// Most times as many draws as before.
const MOST_TIMES: f64 = 16.0;

/// What to change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// These settings, as a file has them: `"sampler": "smc", "draws": 4000`.
    Settings(String),
    /// Another calibration, whose draws are the prior here: mended itself, this one may be as it is.
    Upstream(String),
}

impl Output {
    /// What to change where the chains did not converge; nothing where they did.
    ///
    /// Proposals of `independence-metropolis` are those by which the evidence is estimated, so that the Pareto shape of their
    /// weights tells whether that sampler suits the posterior.
    pub fn remedy(&self) -> Option<Remedy> {
        if self.converged {
            return None;
        }
        if let Some(prior) = self.posterior_priors.iter().find(|prior| !prior.converged) {
            return Some(Remedy::Upstream(prior.source.clone()));
        }
        let is_nearly_normal = self.log_evidence.pareto_k.is_some() && self.log_evidence.is_trusted();
        let own = Sampler::ALL.iter().find(|sampler| sampler.name() == self.sampler);
        let independent = Sampler::IndependenceMetropolis.name();
        let settings = match own {
            Some(Sampler::IndependenceMetropolis) if is_nearly_normal => format!(r#""draws": {}"#, self.more_draws()),
            Some(Sampler::IndependenceMetropolis) | None => format!(r#""sampler": "{}""#, Sampler::Smc.name()),
            Some(Sampler::Smc) => format!(r#""draws": {}"#, self.more_draws()),
            Some(Sampler::Nuts | Sampler::AdaptiveMetropolis) if is_nearly_normal => {
                format!(r#""sampler": "{independent}", "draws": {MANY_DRAWS}"#)
            }
            Some(Sampler::Nuts) => r#""acceptance": 0.95, "warmup": 1000"#.to_owned(),
            Some(Sampler::AdaptiveMetropolis) => format!(r#""draws": {}"#, self.more_draws()),
        };
        Some(Remedy::Settings(settings))
    }

    /// So many more draws that the least effective number becomes enough, and at least twice as many; to two digits.
    fn more_draws(&self) -> u64 {
        let effective = |own: Option<f64>| own.unwrap_or(0.0);
        let least = self.parameters.values().flat_map(|own| [effective(own.ess_bulk), effective(own.ess_tail)]);
        let least = least.fold(f64::INFINITY, f64::min).max(1.0);
        let times = (1.5 * WANTED / least).clamp(2.0, MOST_TIMES);
        let draws = times * self.chains[1] as f64;
        format!("{draws:.1e}").parse::<f64>().unwrap_or(draws) as u64
    }
}

impl Remedy {
    /// Where to write what, in words: `write "draws": 8000 under jobs.tuned.calibrate`.
    pub fn in_words(&self, job: &str) -> String {
        match self {
            Self::Settings(settings) => format!("write {settings} under jobs.{job}.calibrate"),
            Self::Upstream(source) => format!("mend {source} first, whose draws are the prior here"),
        }
    }
}
