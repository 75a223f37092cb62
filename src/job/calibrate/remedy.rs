//! What mends a calibration whose chains did not converge: the fields of its settings, and what to write there.

use super::output::{Evidence, Output};
use super::sampler::Sampler;

/// Draws of `independence-metropolis` that suffice where the posterior is nearly normal, for 15 unknowns and more.
pub const MANY_DRAWS: u64 = 8000;
/// Effective draws that are asked for.
const WANTED: f64 = 400.0;
/// Share of accepted moves above which the steps of trajectories are those of an acceptance of 0.95.
const SHORT_STEPS: f64 = 0.92;
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

impl Evidence {
    /// What to write into the settings where the importance weights are not to be trusted: what gives the evidence without them.
    /// Nothing where they are.
    pub fn remedy(&self) -> Option<String> {
        (!self.is_trusted()).then(|| format!(r#""sampler": "{}""#, Sampler::Smc.name()))
    }
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
            // Steps that are short already do not get shorter by the same settings.
            Some(Sampler::Nuts) if self.has_short_steps() && self.least_effective() >= WANTED => {
                format!(r#""sampler": "{}""#, Sampler::Smc.name())
            }
            Some(Sampler::Nuts) => {
                let draws = match self.least_effective() < WANTED {
                    true => format!(r#", "draws": {}"#, self.more_draws()),
                    false => String::new(),
                };
                format!(r#""acceptance": 0.95, "warmup": 1000{draws}"#)
            }
            Some(Sampler::AdaptiveMetropolis) => format!(r#""draws": {}"#, self.more_draws()),
        };
        Some(Remedy::Settings(settings))
    }

    /// Whether trajectories accepted so many of their moves as steps do that aim at 0.95.
    fn has_short_steps(&self) -> bool {
        let chains = self.acceptance.len().max(1) as f64;
        self.acceptance.iter().sum::<f64>() / chains > SHORT_STEPS
    }

    /// The least effective number of draws of any unknown, in the bulk or the tails.
    fn least_effective(&self) -> f64 {
        let effective = |own: Option<f64>| own.unwrap_or(0.0);
        let all = self.parameters.values().flat_map(|own| [effective(own.ess_bulk), effective(own.ess_tail)]);
        all.fold(f64::INFINITY, f64::min)
    }

    /// So many more draws that the least effective number becomes enough, and at least twice as many; to two digits.
    fn more_draws(&self) -> u64 {
        let least = self.least_effective().max(1.0);
        let times = (1.5 * WANTED / least).clamp(2.0, MOST_TIMES);
        let draws = times * self.chains[1] as f64;
        format!("{draws:.1e}").parse::<f64>().unwrap_or(draws) as u64
    }
}

impl Remedy {
    /// Where to write what, in words: `write "draws": 8000 under jobs.tuned.calibrate`.
    pub fn in_words(&self, job: &str) -> String {
        match self {
            // Another sampler refuses what only the old one knows.
            Self::Settings(settings) if settings.contains("\"sampler\"") => {
                format!("write {settings} under jobs.{job}.calibrate, in place of what is said of the sampler there")
            }
            Self::Settings(settings) => format!("write {settings} under jobs.{job}.calibrate"),
            Self::Upstream(source) => format!("mend {source} first, whose draws are the prior here"),
        }
    }
}
