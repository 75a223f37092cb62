//! Tests of `src/job/calibrate/monte_carlo.rs`.

use bmv::inference::sampler::chains::{Chain, Chains};
use bmv::job::calibrate::monte_carlo::*;
use bmv::job::calibrate::output::Evidence;
use bmv::random::StreamKey;

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
    let density = bmv::math::special::normal_density;
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
