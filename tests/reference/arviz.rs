//! Diagnostics and smoothed weights against ArviZ 0.23.4 on stored numbers (`arviz/make.py` made them).

use bmv::inference::sampler::psis;
use bmv::statistics::chain_diagnostics as own;
use serde_json::Value;

/// ArviZ sums in another order and uses a fast Fourier transform: agreement to rounding, relative.
const TOLERANCE: f64 = 1e-10;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn rows(text: &str) -> Vec<Vec<f64>> {
    text.lines().map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect()
}

fn assert_close(own: f64, expected: f64, what: &str) {
    assert!((own - expected).abs() <= TOLERANCE * expected.abs().max(1e-3), "{what}: {own} {expected}");
}

#[test]
fn chain_diagnostics_equal_those_of_arviz() {
    let expected: Value = serde_json::from_str(include_str!("arviz/diagnostics.json")).expect("valid");
    let text = include_str!("arviz/chains.csv");
    let (head, body) = text.split_once('\n').expect("a head");
    let table = rows(body);
    let mut compared = 0;
    for (column, name) in head.split(',').enumerate().skip(1) {
        let chains: Vec<Vec<f64>> = (0..4)
            .map(|c| table.iter().filter(|row| row[0] == f64::from(c)).map(|row| row[column]).collect())
            .collect();
        let results = [
            ("r_hat", own::r_hat(&chains)),
            ("ess_bulk", own::ess_bulk(&chains)),
            ("ess_tail", own::ess_tail(&chains)),
            ("ess_mean", own::ess_mean(&chains)),
            ("ess_q30", own::ess_quantile(&chains, 0.3)),
            ("mcse_mean", own::mcse_mean(&chains)),
            ("mcse_sd", own::mcse_sd(&chains)),
            ("mcse_q05", own::mcse_quantile(&chains, 0.05)),
            ("mcse_q50", own::mcse_quantile(&chains, 0.5)),
            ("mcse_q95", own::mcse_quantile(&chains, 0.95)),
        ];
        for (what, result) in results {
            assert_close(result.expect("a result"), number(&expected[name][what]), &format!("{name} {what}"));
            compared += 1;
        }
    }
    assert_eq!(compared, 60);
}

#[test]
fn smoothed_weights_equal_those_of_arviz() {
    let expected: Value = serde_json::from_str(include_str!("arviz/psis.json")).expect("valid");
    let table = rows(include_str!("arviz/log_weights.csv"));
    for (efficiency, name) in [(1.0, "1.0"), (0.4, "0.4")] {
        for case in 0..4 {
            let ratios: Vec<f64> = table.iter().map(|row| row[case]).collect();
            let smoothed = psis::smooth(&ratios, efficiency);
            assert_close(smoothed.pareto_k, number(&expected[name]["pareto_k"][case]), &format!("k {name} {case}"));
            for (i, weight) in smoothed.log_weights.iter().enumerate() {
                let theirs = number(&expected[name]["log_weights"][case][i]);
                assert_close(*weight, theirs, &format!("weight {name} {case} {i}"));
            }
        }
    }
}

#[test]
fn leave_one_out_equals_that_of_arviz() {
    let expected: Value = serde_json::from_str(include_str!("arviz/psis.json")).expect("valid");
    let expected = &expected["loo"];
    let flat: Vec<f64> = rows(include_str!("arviz/log_likelihoods.csv")).concat();
    let loo = psis::leave_one_out(&flat, 12, number(&expected["reff"])).expect("a result");
    assert_close(loo.expected_log_density, number(&expected["elpd"]), "elpd");
    assert_close(loo.standard_error, number(&expected["se"]), "se");
    assert_close(loo.effective_parameters, number(&expected["p_loo"]), "p_loo");
    for i in 0..12 {
        assert_close(loo.pointwise[i], number(&expected["pointwise"][i]), "pointwise");
        assert_close(loo.pareto_k[i], number(&expected["pareto_k"][i]), "k");
    }
}
