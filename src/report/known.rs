//! What is known of each parameter: its nominal value, its prior, its posterior, in the unit in which the study writes it.

use serde::{Deserialize, Serialize};

use crate::job::calibrate;
use crate::random::Distribution;

use super::number::{NONE, Shown, as_given, significant};
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
}

impl Known {
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

/// What is known of the model's parameters, in its order.
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
            unit: shown.unit,
        }
    };
    report.model.parameters.iter().map(one).collect()
}
