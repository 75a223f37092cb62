//! Key numbers of a posterior with their Monte Carlo errors, from all draws: mean, standard deviation and quantiles of every
//! unknown, covariance of every two.

use super::output::{Evidence, Output};
use super::summary::Weighted;
use crate::inference::sampler::chains::Chains;
use crate::job::key_number::KeyNumber;
use crate::statistics::chain_diagnostics as diagnostics;
use crate::statistics::monte_carlo::StandardError;

/// Quantiles of every unknown, by name.
const QUANTILES: [(&str, f64); 3] = [("q05", 0.05), ("q50", 0.5), ("q95", 0.95)];
/// Degrees of freedom of the evidence's error by importance sampling. Weights of Pareto shape `k` up to 0.7 make it less
/// certain than its number of draws tells; how much is not known, so that this is a cautious choice.
const OF_IMPORTANCE: f64 = 30.0;

/// How an unknown is shown: its unit, the value and the difference in it.
pub struct Shown<'a> {
    /// Name.
    pub name: &'a str,
    /// Unit.
    pub unit: &'a str,
    /// A value, from SI.
    pub value: Box<dyn Fn(f64) -> f64 + 'a>,
    /// A difference of values, from SI.
    pub difference: Box<dyn Fn(f64) -> f64 + 'a>,
}

/// Numbers of the posterior of these unknowns, given in the order of the chains' parameters. `weights`, one a chain, are those
/// of islands. Draws that no error can be had of (too few, not finite) give numbers without one.
pub fn numbers(chains: &Chains, weights: Option<&[f64]>, unknowns: &[Shown<'_>]) -> Vec<KeyNumber> {
    let weighted = Weighted::new(chains, weights);
    let draws: Vec<Vec<Vec<f64>>> = (0..unknowns.len()).map(|place| chains.parameter(place)).collect();
    let means: Vec<f64> = (0..unknowns.len()).map(|place| weighted.mean(place)).collect();
    let mut numbers = Vec::new();
    for (place, shown) in unknowns.iter().enumerate() {
        let own = &draws[place];
        let sd = weighted.covariance(place, place).sqrt();
        let quantiles = weighted.quantiles(place, &QUANTILES.map(|(_, share)| share));
        let in_unit = |error: Option<StandardError>| {
            let error = error?;
            StandardError::new((shown.difference)(error.standard_error), error.degrees_of_freedom)
        };
        let number = |statistic: &str, value: f64, error| {
            KeyNumber::new(shown.name, statistic, shown.unit, value, in_unit(error))
        };
        let value = &shown.value;
        numbers.push(number("mean", value(means[place]), diagnostics::error_of_mean(own, weights)));
        let of_sd = diagnostics::error_of_sd(own, weights, means[place], sd);
        numbers.push(number("sd", (shown.difference)(sd), of_sd));
        for ((name, share), quantile) in QUANTILES.iter().zip(quantiles) {
            let at = |share: f64| weighted.quantiles(place, &[share]).first().copied().unwrap_or(f64::NAN);
            numbers.push(number(name, value(quantile), diagnostics::error_of_quantile(own, weights, *share, at)));
        }
    }
    for (first, a) in unknowns.iter().enumerate() {
        for (second, b) in unknowns.iter().enumerate().skip(first + 1) {
            let scale = (a.difference)(1.0) * (b.difference)(1.0);
            let pair = [draws[first].as_slice(), draws[second].as_slice()];
            let error = diagnostics::error_of_covariance(pair, weights, [means[first], means[second]])
                .and_then(|error| StandardError::new(error.standard_error * scale, error.degrees_of_freedom));
            let unit = match (a.unit, b.unit) {
                ("", unit) | (unit, "") => unit.to_owned(),
                (a, b) => format!("({a})*({b})"),
            };
            let value = weighted.covariance(first, second) * scale;
            numbers.push(KeyNumber::new(format!("{} and {}", a.name, b.name), "covariance", unit, value, error));
        }
    }
    numbers
}

/// All key numbers of a calibration: its posterior's and the evidence.
pub(super) fn of_output(output: &Output) -> Vec<KeyNumber> {
    let mut numbers = output.key_numbers.clone();
    if let Some(value) = output.log_evidence.value {
        let error = of_evidence(&output.log_evidence, output.chains[0]);
        numbers.push(KeyNumber::new("evidence", "logarithm", "", value, error));
    }
    numbers
}

/// Error of the logarithm of the evidence; that of islands is from their scatter.
pub fn of_evidence(evidence: &Evidence, chains: u64) -> Option<StandardError> {
    if !evidence.is_trusted() {
        return None;
    }
    let degrees = if evidence.pareto_k.is_some() { OF_IMPORTANCE } else { chains.saturating_sub(1) as f64 };
    StandardError::new(evidence.sd?, Some(degrees))
}
