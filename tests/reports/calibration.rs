//! The section on calibration.

use bmv::job::calibrate::{Kind, Output};
use serde_json::json;

use super::rendering::{assert_well_formed, rendered, section};
use super::samples::{Sample, entry, transient};

fn output(converged: bool) -> Output {
    let summary = |unit: &str, mean: f64, rhat: f64| {
        json!({"unit": unit, "prior": {"uniform": {"lower": 0.1, "upper": 2.0}}, "mean": mean, "sd": 0.02, "q025": mean - 0.04,
            "q50": mean, "q975": mean + 0.04, "rhat": rhat, "ess_bulk": 900.0, "ess_tail": 700.0, "mcse_mean": 0.001,
            "at_bound": 0.11, "map": mean, "laplace_sd": 0.02})
    };
    let draws: Vec<[f64; 2]> =
        (0..40).map(|k| [0.8 + 0.01 * f64::from(k % 7), 0.3 + 0.01 * f64::from(k % 5)]).collect();
    let row = |time: f64| {
        json!({"phase": null, "time_s": time, "measured": 300.0 + time, "mean": 300.1 + time, "band": [299.0, 301.0],
            "band_with_noise": [298.0, 302.0], "prior_band": null, "held_out": time > 5.0})
    };
    serde_json::from_value(json!({
        "converged": converged,
        "objections": if converged { vec![] } else { vec!["R-hat of G is 1.300: the chains do not agree (wanted: below 1.01)"] },
        "sampler": "nuts", "chains": [2, 20], "order": ["G", "run.s.sigma"], "model_parameters": 1,
        "parameters": {"G": summary("W/K", 0.8, 1.3), "run.s.sigma": summary("K", 0.3, 1.001)},
        "log_evidence": {"value": -12.5, "sd": 0.1, "method": "importance sampling", "pareto_k": 0.2, "laplace": -12.4},
        "correlations": [[1.0, -0.4], [-0.4, 1.0]],
        "most_probable": {"log_likelihood": -9.0, "log_prior": -1.0, "chi_square": 12.0, "starts": [8, 7]},
        "tuned": [["G", 0.8], ["run.s.sigma", 0.3]],
        "findings": ["11 % of the draws of G lie within 1 % of the upper bound of its prior."],
        "warnings": [], "acceptance": [0.8, 0.81],
        "draws": {"index": (0..40).map(|k| [k / 20, k % 20]).collect::<Vec<_>>(), "values": draws, "log_likelihoods": vec![-9.0; 40]},
        "predictive_draws": 40,
        "predictive": [{"measurement": "run", "sensor": "s", "unit": "K", "rows": (0..9).map(|t| row(f64::from(t))).collect::<Vec<_>>(),
            "train": {"count": 6, "inside": 5, "inside_prior": 6}, "held_out": {"count": 3, "inside": 1, "inside_prior": 3},
            "pit": [1, 1, 1, 0, 1, 0, 0, 1, 1, 0]}],
        "p_value": 1e-5,
        "leave_one_out": {"expected_log_density": -10.0, "standard_error": 2.0, "effective_parameters": 1.9, "unreliable": 1},
        "data": [], "spent": {"likelihoods": 10, "gradients": 20, "rejected": 0}
    }))
    .expect("an output")
}

/// A sample with a calibration that did not converge.
pub fn calibrated() -> Sample {
    with(output(false))
}

fn with(output: Output) -> Sample {
    let mut sample = transient();
    sample.results.push(entry::<Kind>("tuned", "00", output));
    sample
}

#[test]
fn the_verdict_stands_before_the_numbers() {
    let report = rendered(&calibrated());
    let summary = report.markdown.split("\n## ").nth(1).expect("a summary");
    assert!(summary.contains("did not converge: tuned numbers are not to be relied upon"), "{summary}");
    let section = section(&report.markdown, "calibration");
    let place = |text: &str| section.find(text).unwrap_or_else(|| panic!("{text}: {section}"));
    assert!(place("did not converge") < place("R-hat of G is 1.300"));
    assert!(place("R-hat of G is 1.300") < place("uniform, 0.1 to 2"));
    assert!(place("does not explain the data") < place("uniform, 0.1 to 2"));
    assert!(section.contains("11 % of the draws of G"));
    assert!(section.contains("\u{2212}12.50") || section.contains("-12.50"), "{section}");
    for (_, svg) in &report.figures {
        assert_well_formed(svg);
    }
}

#[test]
fn a_converged_calibration_says_so() {
    let report = rendered(&with(output(true)));
    assert!(report.markdown.contains("The sampler converged: 2 chains of 20 draws agree"));
    assert!(!report.markdown.contains("did not converge"));
}
