//! The section on calibration.

use bmv::job::calibrate::{Kind, Output, Remedy};
use serde_json::json;

use super::rendering::{adopted, assert_well_formed, rendered, section};
use super::samples::{Sample, edit, entry, transient};

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
    let place = |text: &str| summary.find(text).unwrap_or_else(|| panic!("{text}: {summary}"));
    assert!(
        summary.contains("> **Warning.** **The posterior is not to be trusted**: calibration `tuned` did not converge"),
        "{summary}"
    );
    // Before all else, with what mends it as the next step: not the next step of a pass that is in order.
    assert!(place("The posterior is not to be trusted") < place("under `jobs.tuned.calibrate`; then `bmv run"));
    assert!(place("under `jobs.tuned.calibrate`") < place("| State of the model"));
    assert!(!summary.contains("bmv verify"), "{summary}");
    assert!(
        !summary.contains("Measured: G") && !summary.contains("presses against"),
        "of such draws nothing is said: {summary}"
    );
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

#[test]
fn what_mends_a_calibration_follows_from_its_sampler_and_the_shape_of_its_weights() {
    let settings = |sampler: &str, pareto_k: Option<f64>| {
        let mut own = output(false);
        own.sampler = sampler.to_owned();
        own.chains = [4, 1000];
        own.log_evidence.pareto_k = pareto_k;
        own.parameters
            .values_mut()
            .for_each(|summary| (summary.ess_bulk, summary.ess_tail) = (Some(150.0), Some(200.0)));
        match own.remedy().expect("a remedy") {
            Remedy::Settings(settings) => settings,
            Remedy::Upstream(source) => panic!("{source}"),
        }
    };
    let independence = r#""sampler": "independence-metropolis", "draws": 8000"#;
    assert_eq!(settings("nuts", Some(0.3)), independence, "nearly normal");
    assert_eq!(settings("adaptive-metropolis", Some(0.3)), independence);
    assert_eq!(settings("nuts", Some(0.9)), r#""acceptance": 0.95, "warmup": 1000, "draws": 4000"#);
    assert_eq!(settings("nuts", None), r#""acceptance": 0.95, "warmup": 1000, "draws": 4000"#);
    let trajectories = |acceptance: f64, effective: f64| {
        let mut own = output(false);
        (own.sampler, own.log_evidence.pareto_k, own.chains) = ("nuts".to_owned(), Some(0.9), [4, 1000]);
        own.acceptance = vec![acceptance; 4];
        let enough = Some(effective);
        own.parameters.values_mut().for_each(|summary| (summary.ess_bulk, summary.ess_tail) = (enough, enough));
        own.remedy().expect("a remedy").in_words("fit")
    };
    assert_eq!(trajectories(0.85, 500.0), r#"write "acceptance": 0.95, "warmup": 1000 under jobs.fit.calibrate"#);
    // What has been done already mends nothing.
    let other = r#"write "sampler": "smc" under jobs.fit.calibrate, in place of what is said of the sampler there"#;
    assert_eq!(trajectories(0.95, 500.0), other);
    // 150 effective draws of 1000: 400 and half as many again are asked for.
    assert_eq!(settings("independence-metropolis", Some(0.3)), r#""draws": 4000"#);
    assert_eq!(settings("independence-metropolis", Some(0.9)), r#""sampler": "smc""#);
    assert_eq!(settings("smc", None), r#""draws": 4000"#);
    assert_eq!(output(true).remedy(), None, "nothing to mend");
    assert_eq!(Remedy::Settings("X".into()).in_words("fit"), "write X under jobs.fit.calibrate");
}

/// The same everywhere: without the error that must not be believed, and marked.
#[test]
fn an_evidence_that_is_not_to_be_trusted_is_marked() {
    let mut own = output(true);
    own.log_evidence = serde_json::from_value(
        json!({"value": 845.23, "sd": 0.4, "method": "importance sampling", "pareto_k": 1.14, "laplace": 840.0}),
    )
    .expect("an evidence");
    let mut sample = with(own);
    let report = rendered(&sample);
    let section = section(&report.markdown, "calibration");
    assert!(
        section.contains(
            "Log evidence by importance sampling: 845.2, not to be trusted (Pareto k 1.14, wanted: 0.7 or less; \"sampler\": \"smc\" gives it otherwise)"
        ),
        "{section}"
    );
    let lines = bmv::report::headline::headlines(sample.results.last().expect("a job")).join("\n");
    assert!(lines.contains("845.2, not to be trusted") && !lines.contains('\u{B1}'), "{lines}");
    assert!(edit::<Kind>(sample.results.last_mut().expect("a job"), |own| own.log_evidence.pareto_k = Some(0.2)));
    let lines = bmv::report::headline::headlines(sample.results.last().expect("a job")).join("\n");
    assert!(lines.contains("845.23 \u{B1} 0.40"), "{lines}");
}

/// Temperatures of a report are in degrees Celsius, those at which a transient starts too.
#[test]
fn start_temperatures_are_in_degrees_celsius() {
    let mut own = output(true);
    let name = "run.start.board".to_owned();
    let mut summary = own.parameters["G"].clone();
    summary.unit = "K".into();
    (summary.mean, summary.sd, summary.q50) = (295.65, 0.07, 295.65);
    own.order.push(name.clone());
    own.parameters.insert(name, summary);
    let report = rendered(&with(own));
    let row = report.markdown.lines().find(|line| line.starts_with("| `run.start.board`")).expect("a row").to_owned();
    assert!(row.contains("| 22.500 |") && row.contains("\u{B0}C") && !row.contains("295"), "{row}");
}

/// The card of an adopted effect states from when on it is there: in the record, or after each start.
#[test]
fn the_card_of_an_adopted_effect_states_its_time() {
    let card = |time: &str, seconds: f64| {
        let mut output = output(true);
        let mut size = output.parameters["G"].clone();
        size.unit = "W".into();
        let mut when = size.clone();
        (when.unit, when.mean) = ("s".into(), seconds);
        output.parameters.extend([("late.power".to_owned(), size), (format!("late.{time}"), when)]);
        let mut sample = with(output);
        sample.model.parameters[0].name = "late.power".into();
        sample.model.parameters[0].unit = "W".into();
        let mut report = sample.report();
        report.adopted = vec![adopted("late", &["board"])];
        let markdown = bmv::report::render(&report).expect("renders").markdown.replace('\u{A0}', " ");
        let summary = markdown.split("\n## 2. ").next().expect("a summary");
        summary.lines().find(|line| line.contains("Measured: late")).unwrap_or_else(|| panic!("{summary}")).to_owned()
    };
    for (time, seconds, said) in [
        ("date", 40_320.0, "W, from 11.20 h on"),
        ("elapsed", 7560.0, "W, from 2.10 h after each start on"),
        ("elapsed", 750.0, "W, from 12.5 min after each start on"),
    ] {
        let line = card(time, seconds);
        assert!(line.contains(said), "{line}");
    }
}

/// A drift of 2e-7 K/s is 6.3 K a year, on the axes of traces and of pairs too.
#[test]
fn traces_of_slow_changes_have_the_unit_of_the_tables() {
    let mut output = output(true);
    let drift = output.parameters.get_mut("G").expect("an unknown");
    (drift.unit, drift.mean, drift.map, drift.sd) = ("K/s".to_owned(), 2e-7, 2e-7, 1e-9);
    output.draws.values.iter_mut().for_each(|draw| draw[0] *= 2.5e-7);
    let report = rendered(&with(output));
    for figure in ["tuned-trace-g", "tuned-pairs"] {
        let (_, drawing, ..) =
            report.figures.iter().find(|own| own.0 == figure).unwrap_or_else(|| {
                panic!("{figure}: {:?}", report.figures.iter().map(|own| &own.0).collect::<Vec<_>>())
            });
        assert!(drawing.contains("G [K/yr]") && !drawing.contains("K/s"), "{drawing}");
    }
}

/// A deviation that drifts by 5.9e-9 K/s drifts by 0.19 K a year.
#[test]
fn slopes_in_time_have_the_unit_of_slow_changes() {
    let mut sample = transient();
    let trend = json!({"measurement": "step test", "sensor": "T1", "against": "time", "unit": "s", "slope": -5.889e-9,
        "slope_error": 3.4e-9, "correlation": -0.35, "change": -0.37});
    let is_one = sample.results.iter_mut().any(|job| {
        edit::<bmv::job::compare::Kind>(job, |output| {
            let mut of_power = trend.clone();
            of_power["against"] = json!("P");
            of_power["unit"] = json!("W");
            output.trends = [&trend, &of_power].map(|own| serde_json::from_value(own.clone()).expect("a trend")).into();
        })
    });
    assert!(is_one, "a comparison");
    let markdown = rendered(&sample).markdown;
    assert!(markdown.contains("`time` | \u{2212}0.37 | \u{2212}0.19 \u{b1} 0.11 | K/yr |"), "{markdown}");
    assert!(markdown.contains("| K/W |"), "the slope's own unit: {markdown}");
}
