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
/// Pareto shape above which the evidence's error is not to be trusted (Vehtari, Simpson, Gelman, Yao & Gabry 2024).
const TRUSTED: f64 = 0.7;

/// How an unknown is shown: its unit, the value and the difference in it.
pub(super) struct Shown<'a> {
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
pub(super) fn numbers(chains: &Chains, weights: Option<&[f64]>, unknowns: &[Shown<'_>]) -> Vec<KeyNumber> {
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
fn of_evidence(evidence: &Evidence, chains: u64) -> Option<StandardError> {
    if evidence.pareto_k.is_some_and(|k| !(k <= TRUSTED)) {
        return None;
    }
    let degrees = if evidence.pareto_k.is_some() { OF_IMPORTANCE } else { chains.saturating_sub(1) as f64 };
    StandardError::new(evidence.sd?, Some(degrees))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::sampler::chains::Chain;
    use crate::random::StreamKey;

    /// Four chains of two correlated normal unknowns in other units than SI.
    fn chains(seed: u64, draws: usize) -> Chains {
        let key = StreamKey::new(seed, "calibrate", "monte carlo");
        let chain = |index: u64| {
            let mut stream = key.stream(index);
            let mut numbers = Vec::new();
            for _ in 0..draws {
                let (a, b) = (stream.normal(), stream.normal());
                numbers.extend([2.0 + a, 300.0 + 10.0 * (0.6 * a + 0.8 * b)]);
            }
            Chain { dimension: 2, draws: numbers, log_likelihoods: vec![0.0; draws], ..Chain::default() }
        };
        Chains { names: vec!["a".into(), "b".into()], chains: (0..4).map(chain).collect() }
    }

    fn shown() -> [Shown<'static>; 2] {
        [
            Shown { name: "a", unit: "W/K", value: Box::new(|x| x), difference: Box::new(|x| x) },
            Shown { name: "b", unit: "degC", value: Box::new(|x| x - 273.15), difference: Box::new(|x| x) },
        ]
    }

    #[test]
    fn errors_of_independent_draws_are_those_of_theory() {
        let numbers = numbers(&chains(1, 2500), None, &shown());
        let find = |name: &str| numbers.iter().find(|number| number.name() == name).unwrap();
        // Errors of 10,000 normal draws; the estimated ones are known to some per cent, those of outer quantiles
        // to a seventh: three of that.
        let density = crate::math::special::normal_density;
        let of_quantile = |p: f64, z: f64| (p * (1.0 - p)).sqrt() / density(z) / 100.0;
        for (name, value, error, tolerance) in [
            ("a, mean", 2.0, 0.01, 0.1),
            ("a, sd", 1.0, 0.5_f64.sqrt() / 100.0, 0.1),
            ("a, q05", 2.0 - 1.644_853_6, of_quantile(0.05, 1.644_853_6), 0.45),
            ("a, q50", 2.0, of_quantile(0.5, 0.0), 0.45),
            ("b, q95", 26.85 + 16.448_536, 10.0 * of_quantile(0.05, 1.644_853_6), 0.45),
            ("a and b, covariance", 6.0, 10.0 * 1.36_f64.sqrt() / 100.0, 0.1),
        ] {
            let number = find(name);
            let own = number.error.expect("an error");
            assert!((number.value - value).abs() < 4.0 * error, "{number:?}");
            assert!((own.standard_error / error - 1.0).abs() < tolerance, "{name}: {own:?} {error}");
        }
        assert_eq!(numbers.len(), 11);
        assert_eq!(find("a and b, covariance").unit, "(W/K)*(degC)");
    }

    #[test]
    fn errors_of_islands_are_from_their_scatter() {
        let mut apart = chains(1, 100);
        for (index, chain) in apart.chains.iter_mut().enumerate() {
            chain.draws.iter_mut().for_each(|x| *x += index as f64);
        }
        let numbers = numbers(&apart, Some(&[1.0; 4]), &shown());
        // Four means about 0, 1, 2, 3 away: their scatter by 2, the root of the number.
        let error = numbers[0].error.expect("an error");
        assert!((error.standard_error - 1.29 / 2.0).abs() < 0.1, "{error:?}");
        assert!((error.degrees_of_freedom.expect("few") - 3.0).abs() < 1e-9);
        let q50 = numbers[3].error.expect("an error");
        assert!(q50.standard_error > 0.3, "{q50:?}");
    }

    #[test]
    fn an_evidence_that_is_not_to_be_trusted_has_no_error() {
        let evidence = |pareto_k, sd| Evidence { value: Some(1.0), sd, method: String::new(), pareto_k, laplace: None };
        assert!(of_evidence(&evidence(Some(0.8), Some(0.1)), 4).is_none());
        assert!(of_evidence(&evidence(None, None), 4).is_none());
        let degrees = |pareto_k| of_evidence(&evidence(pareto_k, Some(0.1)), 4).and_then(|e| e.degrees_of_freedom);
        assert_eq!((degrees(Some(0.3)), degrees(None)), (Some(30.0), Some(3.0)));
    }
}
