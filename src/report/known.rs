//! What is known of each parameter: its nominal value, its prior, its posterior, in the unit in which the study writes it, or that in which people
//! read it.

use serde::{Deserialize, Serialize};

use crate::document::time::{is_rate, unit_of_rate};
use crate::job::calibrate;
use crate::random::Distribution;

use super::number::{NONE, Shown, as_given, significant, typeset};
use super::section::problem::prior_words;
use super::view::PassReport;

/// A posterior's mean, standard deviation and ends of its 95 % interval, in the parameter's unit, and the calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Posterior {
    /// Name of the calibration.
    pub job: String,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Quantiles of 2.5 % and 97.5 %.
    pub interval: [f64; 2],
}

/// What is known of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// The parameter.
    pub name: String,
    /// Unit, typeset; empty for a pure number.
    pub unit: String,
    /// Nominal value.
    pub nominal: f64,
    /// Prior in words.
    pub prior: String,
    /// Quantiles of 2.5 % and 97.5 % of the prior; `None` where it is fixed or draws stand in for it.
    pub prior_interval: Option<[f64; 2]>,
    /// Posterior of the first calibration that infers it.
    pub posterior: Option<Posterior>,
    /// Where the prior comes from.
    pub source: String,
    /// What it takes to state a change in a time by the hour, day or year.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<Rate>,
}

/// A parameter that is a change in a time, as the study writes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Its unit.
    pub unit: String,
    /// Its prior, SI; `None` where it is fixed or draws stand in for it.
    pub prior: Option<Distribution>,
}

impl Known {
    /// About how large it is, in its unit.
    fn size(&self) -> f64 {
        // About a standard deviation.
        let spread = self.prior_interval.map_or(0.0, |[low, high]| 0.25 * (high - low));
        let posterior = self.posterior.as_ref().map_or(0.0, |own| own.mean.abs().max(own.sd));
        [self.nominal.abs(), spread, posterior].into_iter().filter(|size| size.is_finite()).fold(0.0, f64::max)
    }

    /// The nominal value as text.
    pub fn nominal_text(&self) -> String {
        as_given(self.nominal)
    }

    /// Posterior as text: mean, standard deviation, 95 % interval, calibration.
    pub fn posterior_text(&self) -> String {
        let digits = |value: f64| significant(value, 4);
        self.posterior.as_ref().map_or_else(
            || NONE.to_owned(),
            |own| {
                let [low, high] = own.interval;
                format!(
                    "{} \u{B1} {} ({} to {}; {})",
                    digits(own.mean),
                    significant(own.sd, 2),
                    digits(low),
                    digits(high),
                    own.job
                )
            },
        )
    }
}

/// The same of one parameter in several passes, in the unit in which all are read: a slow change by the hour, day or year.
pub fn stated(passes: &[&Known]) -> Vec<Known> {
    let size = passes.iter().map(|own| own.size()).fold(0.0, f64::max);
    let unit = passes.iter().find_map(|own| own.rate.as_ref()).map(|rate| rate.unit.as_str());
    let Some((times, unit)) = unit.and_then(|unit| unit_of_rate(unit, size)) else {
        return passes.iter().map(|own| (*own).clone()).collect();
    };
    let one = |own: &&Known| {
        let prior =
            own.rate.as_ref().and_then(|rate| Some(prior_words(&rate.prior?, &Shown::parameter(&rate.unit, size))));
        let posterior = own.posterior.clone().map(|own| Posterior {
            mean: times * own.mean,
            sd: times * own.sd,
            interval: own.interval.map(|end| times * end),
            ..own
        });
        Known {
            unit: typeset(&unit),
            nominal: times * own.nominal,
            prior: prior.unwrap_or_else(|| own.prior.clone()),
            prior_interval: own.prior_interval.map(|ends| ends.map(|end| times * end)),
            posterior,
            rate: None,
            ..(*own).clone()
        }
    };
    passes.iter().map(one).collect()
}

/// What is known of the model's parameters, in its order, each as the study writes it.
pub fn parameters(report: &PassReport<'_>) -> Vec<Known> {
    let one = |parameter: &crate::thermal::Parameter| {
        let shown = Shown::written(&parameter.unit);
        let own = report.priors.iter().find(|prior| prior.0 == parameter.name).map(|(_, prior)| prior);
        let draws = report.posterior_priors.iter().find(|(name, _)| *name == parameter.name);
        let prior = match (draws, own) {
            (Some((_, source)), _) => format!("draws of {}", source.replace('`', "")),
            (None, Some(own)) => prior_words(own, &shown),
            (None, None) => "fixed".to_owned(),
        };
        let spreads = own.filter(|own| draws.is_none() && !matches!(own, Distribution::Fixed(_)));
        let mut found = report.outputs::<calibrate::Kind>();
        let found = found.find_map(|(job, output)| Some((job, output.parameters.get(&parameter.name)?)));
        Known {
            name: parameter.name.clone(),
            nominal: shown.value(parameter.nominal),
            prior,
            prior_interval: spreads.map(|own| [0.025, 0.975].map(|share| shown.value(own.quantile(share)))),
            // A calibration states its numbers in the parameter's unit.
            posterior: found
                .filter(|(_, own)| [own.mean, own.sd, own.q025, own.q975].iter().all(|x| x.is_finite()))
                .map(|(job, own)| Posterior {
                    job: job.to_owned(),
                    mean: own.mean,
                    sd: own.sd,
                    interval: [own.q025, own.q975],
                }),
            source: parameter.source.clone(),
            rate: is_rate(&parameter.unit).then(|| Rate { unit: parameter.unit.clone(), prior: spreads.copied() }),
            unit: shown.unit,
        }
    };
    report.model.parameters.iter().map(one).collect()
}
