//! Diagnosis of a network that is linear in everything that is unknown, with normal priors: the evidence of every set of
//! effects is a normal density of the readings, so that its probabilities are known; and the family-wise p is kept.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use bmv::diagnosis::fits::refit::Begin;
use bmv::diagnosis::{Diagnosis, Problem, Settings, Verdict};
use bmv::job::ready::Readiness;
use bmv::math::functions::{exp, ln};
use bmv::measurement::Uncertain;
use bmv::random::StreamKey;
use nalgebra::{DMatrix, DVector};

use super::small_study;
use crate::serial;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "Two plates on a cold sink",
  "inputs": {"T_sink": {"unit": "K", "nominal": 280, "range": [260, 300]}, "Q": {"unit": "W", "nominal": 2, "range": [0, 10]}},
  "parameters": {"P_0": {"unit": "W", "nominal": 1, "prior": {"normal": {"mean": 1, "sd": 0.3}}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": "T_sink"}, "A": {"capacity": 100}, "B": {"capacity": 50}},
  "conductors": {
    "A to sink": {"between": ["A", "sink"], "conductance": 0.5},
    "A to B": {"between": ["A", "B"], "conductance": 0.3}
  },
  "loads": {"heater": {"into": "A", "power": "Q"}, "electronics": {"into": "B", "power": "P_0"}}
}"#;

/// Sink in K, heater in W.
const PHASES: [[f64; 2]; 8] =
    [[280.0, 0.0], [280.0, 5.0], [265.0, 10.0], [300.0, 1.0], [270.0, 3.0], [290.0, 8.0], [260.0, 6.0], [295.0, 2.0]];
const SIGMA: f64 = 0.2;

/// Temperatures of A and B, K, for the heats into them, by hand: all heat leaves through A's conductor to the sink.
fn plates(sink: f64, into_a: f64, into_b: f64) -> [f64; 2] {
    let a = sink + (into_a + into_b) / 0.5;
    [a, a + into_b / 0.3]
}

/// The 16 readings of a heat of the electronics, further heats and biases.
fn readings(p: f64, heat: [f64; 2], bias: [f64; 2]) -> DVector<f64> {
    let all = PHASES.iter().flat_map(|[sink, q]| {
        let [a, b] = plates(*sink, q + heat[0], p + heat[1]);
        [a + bias[0], b + bias[1]]
    });
    DVector::from_iterator(16, all)
}

/// What one unit of a parameter or effect does to the readings, times its standard deviation beforehand (the electronics'
/// 0.3 W; 1 W of `heat-load` and 0.5 K of `sensor-bias`, as the catalogue has them).
fn column(name: &str) -> DVector<f64> {
    let zero = readings(0.0, [0.0; 2], [0.0; 2]);
    match name {
        "P_0" => (readings(1.0, [0.0; 2], [0.0; 2]) - zero) * 0.3,
        "heat-load:A" => readings(0.0, [1.0, 0.0], [0.0; 2]) - zero,
        "heat-load:B" => readings(0.0, [0.0, 1.0], [0.0; 2]) - zero,
        "sensor-bias:A" => (readings(0.0, [0.0; 2], [1.0, 0.0]) - zero) * 0.5,
        "sensor-bias:B" => (readings(0.0, [0.0; 2], [0.0, 1.0]) - zero) * 0.5,
        other => panic!("no effect `{other}` was asked for"),
    }
}

/// Log density of readings of the model with effects: of what their priors are narrowed to, at its best.
fn log_evidence(readings_k: &DVector<f64>, effects: &[String]) -> f64 {
    with_narrower(effects.len(), |widths| log_evidence_of_widths(readings_k, effects, widths, SIGMA))
}

/// The same with amplitudes whose priors are so many times as wide, and noise in K.
fn log_evidence_of_widths(readings_k: &DVector<f64>, effects: &[String], widths: &[f64], sigma_k: f64) -> f64 {
    let mut covariance = DMatrix::from_diagonal_element(16, 16, sigma_k * sigma_k);
    for (name, width) in effects.iter().map(String::as_str).zip(widths.iter().copied()).chain([("P_0", 1.0)]) {
        let own = column(name) * width;
        covariance += &own * own.transpose();
    }
    let left = readings_k - readings(1.0, [0.0; 2], [0.0; 2]);
    let factor = covariance.cholesky().expect("positive");
    let log_determinant = 2.0 * factor.l().diagonal().iter().map(|d| ln(*d)).sum::<f64>();
    -0.5 * (left.dot(&factor.solve(&left)) + log_determinant + 16.0 * ln(core::f64::consts::TAU))
}

/// The largest evidence of the catalogue's widths and narrower ones of each of some effects, which have odds of 0.3 a decade.
fn with_narrower(effects: usize, log_evidence: impl Fn(&[f64]) -> f64) -> f64 {
    const NARROWER: [(f64, f64); 3] = [(1.0, 1.0), (0.1, 0.3), (0.01, 0.09)];
    let all = (0..NARROWER.len().pow(effects as u32)).map(|mut number| {
        let mut odds = 0.0;
        let mut next = || {
            let (width, own) = NARROWER[number % NARROWER.len()];
            number /= NARROWER.len();
            odds += ln(own);
            width
        };
        let widths: Vec<f64> = (0..effects).map(|_| next()).collect();
        log_evidence(&widths) + odds
    });
    all.fold(f64::NEG_INFINITY, f64::max)
}

fn problem(readings_k: &DVector<f64>) -> Problem {
    problem_of(readings_k, &["heat-load", "sensor-bias"])
}

/// With the effects of these kinds as candidates.
fn problem_of(readings_k: &DVector<f64>, kinds: &[&str]) -> Problem {
    let mut table = String::from("phase,T_sink [K],Q [W],A [K],B [K]\n");
    for (row, [sink, q]) in PHASES.iter().enumerate() {
        table.push_str(&format!("P{row},{sink},{q},{:e},{:e}\n", readings_k[2 * row], readings_k[2 * row + 1]));
    }
    let sensor = r#"{"sigma": {"value": 0.2, "unit": "K"}}"#;
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Linear", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"test": {{"steady": {{"file": "data.csv", "sensors": {{"A": {sensor}, "B": {sensor}}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{"data": ["test"], "effects": ["heat-load", "sensor-bias"]}}}}}}}}"#
    )
    .replace(r#"{"sigma""#, r#"{"measures": "X", "sigma""#);
    let pass = pass.replacen(r#""X""#, r#""A""#, 1).replacen(r#""X""#, r#""B""#, 1);
    let mut problem = small_study::problem(&[("model.json", MODEL), ("data.csv", &table), ("pass-1.json", &pass)]);
    Arc::make_mut(&mut problem.candidates).retain(|own| kinds.contains(&own.effect.as_str()));
    problem
}

/// Readings with the noise of a stream.
fn noisy(clean: DVector<f64>, key: &StreamKey, number: u64) -> DVector<f64> {
    let mut stream = key.stream(number);
    clean.map(|value| value + SIGMA * stream.normal())
}

#[test]
fn evidences_and_probabilities_are_those_of_normal_densities() {
    let key = StreamKey::new(8, "linear", "noise");
    // 0.3 W too much in B, and the sensor of A biased by 0.4 K.
    let measured = noisy(readings(1.1, [0.0, 0.3], [0.4, 0.0]), &key, 0);
    let problem = problem(&measured);
    assert_eq!(problem.candidates.len(), 4);
    let output = Diagnosis::new(problem, Settings::default(), key).run().expect("a diagnosis");
    let models: BTreeMap<Vec<String>, (f64, f64)> =
        output.models.iter().map(|own| (own.effects.clone(), (own.log_evidence, own.probability))).collect();
    // Nothing, four effects alone, pairs, some sets of three.
    assert!(models.len() >= 8, "{models:?}");
    // Two effects at two places each: odds of 0.05 / 0.95 / 2 for every effect.
    let odds = ln(0.05 / 0.95 / 2.0);
    let log_weight = |effects: &[String]| log_evidence(&measured, effects) + odds * effects.len() as f64;
    let (best, (_, highest)) = models.iter().max_by(|a, b| a.1.1.total_cmp(&b.1.1)).expect("models");
    for (effects, (log, probability)) in &models {
        // The fit's own accuracy: its gradient ends at 1e-8 of the sum of squares.
        let exact = log_evidence(&measured, effects);
        assert!((log - exact).abs() < 1e-6, "{effects:?}: {log} {exact}");
        let ratio = exp(log_weight(effects) - log_weight(best));
        assert!((probability / highest - ratio).abs() < 1e-6, "{effects:?}: {probability} {ratio}");
    }
    // Together with nothing else and something else they are 1.
    let total: f64 = models.values().map(|(_, probability)| probability).sum::<f64>() + output.probability_unexplained;
    assert!((total - 1.0).abs() < 1e-9, "{total}");
}

/// 12 W too much in A are 12 standard deviations of what the catalogue thinks plausible: a prior ten times as wide, which has
/// odds of 0.1 against the catalogue's, explains them; 200 W need one that is a hundred times as wide (0.01).
#[test]
fn what_is_larger_than_thought_plausible_has_the_evidence_of_a_wider_prior() {
    let key = StreamKey::new(10, "linear", "noise");
    for (heat, width, odds) in [(1.5, 1.0, 1.0), (12.0, 10.0, 0.1), (200.0, 100.0, 0.01)] {
        let measured = noisy(readings(1.1, [heat, 0.0], [0.0; 2]), &key, 0);
        let problem = problem(&measured);
        let output = Diagnosis::new(problem, Settings::default(), key).run().expect("a diagnosis");
        assert_eq!(output.selected, ["heat-load:A"], "{heat} W");
        let own = &output.effects[0];
        assert_eq!(own.prior_width, width);
        // The prior that counts pulls by (0.2 K / 2 K/W)^2 / 8 / width^2 of the heat at most; the noise by 0.04 W.
        assert!((own.amplitudes["power"].value - heat).abs() < 0.2, "{heat} W: {:?}", own.amplitudes);
        let effects = ["heat-load:A".to_owned()];
        let model = output.models.iter().find(|model| model.effects == effects).expect("fitted");
        let of_width = |width: f64| log_evidence_of_widths(&measured, &effects, &[width], SIGMA);
        let exact = of_width(width) + ln(odds);
        assert!((model.log_evidence - exact).abs() < 1e-6, "{heat} W: {} {exact}", model.log_evidence);
        for (other, odds) in [(1.0, 1.0), (10.0, 0.1), (100.0, 0.01)] {
            assert!(exact >= of_width(other) + ln(odds) - 1e-9, "{heat} W");
        }
    }
}

/// With noise of 20 K the data know 20 W of heat to 2.5 W, more than what the catalogue thinks plausible: beneath its prior the
/// fit lies only about 20 / (1 + 2.5^2) = 2.8 of its standard deviations out, and yet one ten times as wide explains far more.
#[test]
fn a_prior_that_outvotes_the_data_is_widened() {
    let key = StreamKey::new(12, "linear", "noise");
    let sigma = 20.0;
    let mut stream = key.stream(0);
    let measured = readings(1.0, [20.0, 0.0], [0.0; 2]).map(|value| value + sigma * stream.normal());
    let mut problem = problem(&measured);
    for sensor in &mut problem.measurements[0].sensors {
        sensor.sigma = Some(Uncertain::Known(sigma));
    }
    let heat = problem.candidates.iter().position(|own| own.id == "heat-load:A").expect("a candidate");
    let begin = Begin { starts: vec![BTreeMap::new()], scale: 1.0, ..Begin::default() };
    let fit = problem.refit(&[heat], &begin, &key).expect("a fit");
    let effects = ["heat-load:A".to_owned()];
    let of_width = |width: f64, odds: f64| log_evidence_of_widths(&measured, &effects, &[width], sigma) + ln(odds);
    assert!(of_width(10.0, 0.1) > of_width(1.0, 1.0) + 3.0 && of_width(10.0, 0.1) > of_width(100.0, 0.01));
    assert_eq!(fit.widths, [10.0]);
    assert!((fit.log_evidence - of_width(10.0, 0.1)).abs() < 1e-6, "{}", fit.log_evidence);
}

/// All of A's heat leaves through 0.5 W/K, so that 2.9 W into A and a sink that is 5.8 K warmer are one thing to any data. The
/// odds beforehand are 14 to 1: one place with 3 K against two with 1 W.
#[test]
fn what_predicts_the_same_is_not_told_apart() {
    let key = StreamKey::new(11, "linear", "noise");
    let measured = noisy(readings(1.0, [2.9, 0.0], [0.0; 2]), &key, 0);
    let problem = problem_of(&measured, &["heat-load", "sink-offset"]);
    let output = Diagnosis::new(problem, Settings::default(), key).run().expect("a diagnosis");
    assert_eq!(output.selected, ["sink-offset:sink"], "{:?}", output.words);
    assert_eq!(output.verdict, Verdict::Ambiguous, "{:?}", output.words);
    let group = |id: &str| output.effects.iter().find(|effect| effect.id == id).and_then(|effect| effect.group);
    assert_eq!(group("heat-load:A"), Some(1), "{:?}", output.words);
    assert!(output.effects[0].probability > 0.91, "{:?}", output.effects);
}

/// Data sets of the baseline model itself, parameter drawn from its prior, at a level of 0.1: the number found is within
/// the 99.9 % range of a binomial of 200 with 0.1, 8 to 35. The verdict finds no more: a chance that looks like a small
/// model error is none.
#[test]
#[ignore = "thorough"]
fn the_family_wise_level_is_kept() {
    let key = StreamKey::new(9, "linear", "noise");
    let mut problem = problem(&readings(1.0, [0.0; 2], [0.0; 2]));
    let settings = Settings { false_alarm: 0.1, ..Settings::default() };
    let (mut found, mut verdicts) = (0, 0);
    for number in 0..200 {
        let p = 1.0 + 0.3 * key.stream(1000 + number).normal();
        let measured = noisy(readings(p, [0.0; 2], [0.0; 2]), &key, number);
        for (own, value) in problem.measurements[0].readings.iter_mut().zip(measured.iter()) {
            *own = Some(*value);
        }
        let output = Diagnosis::new(problem.clone(), settings.clone(), key).run().expect("a diagnosis");
        found += i32::from(output.misfit.family_wise_p <= settings.false_alarm);
        verdicts += i32::from(output.verdict != Verdict::Adequate);
    }
    assert!((8..=35).contains(&found) && verdicts <= found, "{found} of 200 at 0.1, {verdicts} verdicts");
}

/// Heats of both plates are unknown, so that the posterior of some phases has them correlated.
const BOTH_UNKNOWN: [[f64; 2]; 2] = [[0.5, 0.6], [1.0, 0.3]];
/// Phases of the first pass; the others are those of the second.
const FIRST: usize = 3;

/// Readings of phases, as a matrix of the heats' effects and what is left without any.
fn design(phases: std::ops::Range<usize>) -> (DMatrix<f64>, DVector<f64>) {
    let rows = 2 * phases.start..2 * phases.end;
    let zero = readings(0.0, [0.0; 2], [0.0; 2]);
    let of = |heat: [f64; 2]| (readings(0.0, heat, [0.0; 2]) - &zero).rows(rows.start, rows.len()).into_owned();
    (DMatrix::from_columns(&[of([1.0, 0.0]), of([0.0, 1.0])]), zero.rows(rows.start, rows.len()).into_owned())
}

/// Mean and covariance of the heats after the first pass, exactly.
fn after_first(measured: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let (x, zero) = design(0..FIRST);
    let mut information = x.transpose() * &x / (SIGMA * SIGMA);
    let mut pull = x.transpose() * (measured.rows(0, 2 * FIRST) - zero) / (SIGMA * SIGMA);
    for (place, [mean, sd]) in BOTH_UNKNOWN.into_iter().enumerate() {
        information[(place, place)] += 1.0 / (sd * sd);
        pull[place] += mean / (sd * sd);
    }
    let covariance = information.try_inverse().expect("positive");
    (&covariance * pull, covariance)
}

/// Log density of the second pass's readings of the model with effects, heats being normal and effects' priors so many times as
/// wide.
fn log_evidence_after(
    measured: &DVector<f64>,
    (mean, spread): (&DVector<f64>, &DMatrix<f64>),
    effects: &[String],
    widths: &[f64],
) -> f64 {
    let (x, zero) = design(FIRST..PHASES.len());
    let count = x.nrows();
    let mut covariance = DMatrix::from_diagonal_element(count, count, SIGMA * SIGMA) + &x * spread * x.transpose();
    for (name, width) in effects.iter().zip(widths) {
        let own = column(name).rows(2 * FIRST, count) * *width;
        covariance += &own * own.transpose();
    }
    let left = measured.rows(2 * FIRST, count) - zero - &x * mean;
    let factor = covariance.cholesky().expect("positive");
    let log_determinant = 2.0 * factor.l().diagonal().iter().map(|d| ln(*d)).sum::<f64>();
    -0.5 * (left.dot(&factor.solve(&left)) + log_determinant + count as f64 * ln(core::f64::consts::TAU))
}

/// A study of two passes: the posterior of the first is the prior of the second, which is diagnosed.
fn two_passes(folder: &Path, measured: &DVector<f64>) {
    let model = MODEL.replace(
        r#""P_0": {"unit": "W", "nominal": 1, "prior": {"normal": {"mean": 1, "sd": 0.3}}, "source": "assumed"}"#,
        r#""P_A": {"unit": "W", "nominal": 0.5, "prior": {"normal": {"mean": 0.5, "sd": 0.6}}, "source": "assumed"},
           "P_B": {"unit": "W", "nominal": 1, "prior": {"normal": {"mean": 1, "sd": 0.3}}, "source": "assumed"}"#,
    );
    let model = model.replace(r#""power": "P_0"}"#, r#""power": "P_B"}, "standby": {"into": "A", "power": "P_A"}"#);
    let data = |rows: std::ops::Range<usize>| {
        let mut table = String::from("phase,T_sink [K],Q [W],A [K],B [K]\n");
        for row in rows {
            let [sink, q] = PHASES[row];
            table.push_str(&format!("P{row},{sink},{q},{:e},{:e}\n", measured[2 * row], measured[2 * row + 1]));
        }
        table
    };
    let pass = |parameters: &str, file: &str, jobs: &str| {
        format!(
            r#"{{"format": "bmv-pass/1", "title": "Linear", "parent": null, "seed": 3, "parameters": {{{parameters}}},
            "measurements": {{"{file}": {{"steady": {{"file": "{file}.csv", "sensors": {{
                "A": {{"measures": "A", "sigma": {{"value": 0.2, "unit": "K"}}}}, "B": {{"measures": "B", "sigma": {{"value": 0.2, "unit": "K"}}}}}}}}}}}},
            "jobs": {{{jobs}}}}}"#
        )
    };
    let prior = r#"{"prior": {"posterior": {"pass": "pass-1.json", "job": "fit"}}, "because": "handed on"}"#;
    let posterior_priors = format!(r#""P_A": {prior}, "P_B": {prior}"#);
    let diagnose = r#""missing": {"diagnose": {"effects": ["heat-load", "sensor-bias"]}}"#;
    for (name, text) in [
        ("model.json", model),
        ("first.csv", data(0..FIRST)),
        ("second.csv", data(FIRST..PHASES.len())),
        ("pass-1.json", pass("", "first", r#""fit": {"calibrate": {}}"#)),
        ("pass-2.json", pass(&posterior_priors, "second", diagnose)),
    ] {
        std::fs::write(folder.join(name), text).expect("written");
    }
}

#[test]
fn a_posterior_as_prior_gives_the_evidence_of_sequential_bayes() {
    let key = StreamKey::new(10, "linear", "noise");
    let measured = noisy(readings(1.1, [0.3, 0.0], [0.5, 0.0]), &key, 0);
    let folder = tempfile::tempdir().expect("a folder");
    two_passes(folder.path(), &measured);
    // Draws of the exact posterior in the place of a calibration's.
    let (mean, covariance) = after_first(&measured);
    assert!(covariance[(0, 1)].abs() > 0.3 * (covariance[(0, 0)] * covariance[(1, 1)]).sqrt(), "{covariance}");
    let factor = covariance.clone().cholesky().expect("positive").l();
    let mut stream = key.stream(1);
    const DRAWS: usize = 20_000;
    let draws: Vec<DVector<f64>> =
        (0..DRAWS).map(|_| &mean + &factor * DVector::from_fn(2, |_, _| stream.normal())).collect();
    let ess = serde_json::json!({"ess_bulk": DRAWS as f64, "ess_tail": DRAWS as f64});
    let values: Vec<Vec<f64>> = draws.iter().map(|draw| draw.iter().copied().collect()).collect();
    let result = serde_json::json!({"converged": true, "order": ["P_A", "P_B"],
        "parameters": {"P_A": ess, "P_B": ess}, "draws": {"values": values}});
    let pass = bmv::job::load(&folder.path().join("pass-2.json"));
    let pass = pass.unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 20)));
    let (_, readiness) = bmv::job::ready(&pass).into_iter().next().expect("a job");
    let Readiness::After(waiting) = readiness else { panic!("after the calibration") };
    let job = waiting.prepare(&[Arc::new(result)]).expect("a density");
    assert_eq!(job.identity(), waiting.identity(), "known before the calibration ran");
    let output: bmv::diagnosis::Output =
        serde_json::from_value(serial::run(job.as_ref()).expect("a result")).expect("a diagnosis");
    assert_eq!(output.posterior_priors[0].parameters, ["P_A", "P_B"]);
    assert!(output.warnings.is_empty() && output.converged.is_none(), "{:?}", output.warnings);

    let sample_mean = draws.iter().sum::<DVector<f64>>() / DRAWS as f64;
    let sample_covariance =
        draws.iter().map(|d| (d - &sample_mean) * (d - &sample_mean).transpose()).sum::<DMatrix<f64>>()
            / (DRAWS as f64 - 1.0);
    let odds = ln(0.05 / 0.95 / 2.0);
    let log_evidence = |moments: (&DVector<f64>, &DMatrix<f64>), effects: &[String]| {
        with_narrower(effects.len(), |widths| log_evidence_after(&measured, moments, effects, widths))
    };
    let exact = |effects: &[String]| log_evidence((&mean, &covariance), effects);
    let log_weight = |effects: &[String]| exact(effects) + odds * effects.len() as f64;
    let best = output.models.first().expect("models");
    assert!(output.models.len() >= 5, "{:?}", output.models);
    for model in &output.models {
        // Of the draws' own moments exactly: to the fit's accuracy.
        let own = log_evidence((&sample_mean, &sample_covariance), &model.effects);
        assert!((model.log_evidence - own).abs() < 1e-6, "{:?}: {} {own}", model.effects, model.log_evidence);
        // Of sequential Bayes to what 20 000 draws leave: each entry of the covariance is known to a hundredth, which a
        // sum of squares of ten readings takes ten times at most.
        let exact = exact(&model.effects);
        assert!((model.log_evidence - exact).abs() < 0.1, "{:?}: {} {exact}", model.effects, model.log_evidence);
        let ratio = exp(log_weight(&model.effects) - log_weight(&best.effects));
        let found = model.probability / best.probability;
        assert!((found - ratio).abs() < 0.05 * ratio.max(0.1), "{:?}: {found} {ratio}", model.effects);
    }
    // What little heat these data leave to B is better known than its prior is wide.
    let small = ["heat-load:B".to_owned()];
    assert!(exact(&small) > log_evidence_after(&measured, (&mean, &covariance), &small, &[1.0]) + 0.5);
}

#[test]
fn draws_that_are_not_normal_are_refused_as_a_prior() {
    let key = StreamKey::new(11, "linear", "noise");
    let folder = tempfile::tempdir().expect("a folder");
    two_passes(folder.path(), &readings(1.0, [0.5, 0.0], [0.0; 2]));
    let mut stream = key.stream(0);
    let values: Vec<Vec<f64>> = (0..2000)
        .map(|_| {
            let side = if stream.uniform() < 0.5 { 0.0 } else { 1.0 };
            vec![side + 0.1 * stream.normal(), 1.0 + 0.1 * stream.normal()]
        })
        .collect();
    let ess = serde_json::json!({"ess_bulk": 2000.0, "ess_tail": 2000.0});
    let result = serde_json::json!({"converged": true, "order": ["P_A", "P_B"],
        "parameters": {"P_A": ess, "P_B": ess}, "draws": {"values": values}});
    let pass = bmv::job::load(&folder.path().join("pass-2.json")).unwrap_or_else(|_| panic!("it loads"));
    let (_, readiness) = bmv::job::ready(&pass).into_iter().next().expect("a job");
    let Readiness::After(waiting) = readiness else { panic!("after the calibration") };
    let Err(error) = waiting.prepare(&[Arc::new(result)]) else { panic!("it is taken") };
    assert!(error.to_string().contains("cannot be a prior here: a normal distribution of the scores"), "{error}");
}

/// A heat that swings ten thousand times in a test of an hour: where it is large, an integrator must follow it.
const RIPPLE: &str = r#"{"format": "bmv-effect/1", "title": "Ripple", "applies": {"node": {}},
    "parameters": {"power": {"unit": "W", "prior": {"normal": {"mean": 0, "sd": 1000}}, "description": "amplitude", "plausible": 1000}},
    "adds": {"load": "power * sin(20 * t)"}, "equation": "Q = P sin(20 t)", "signature": "a ripple", "confused_with": ["heat-load"],
    "separate": "a faster logger", "source": "made up"}"#;

#[test]
fn a_transient_that_crawls_is_given_up_and_said() {
    let key = StreamKey::new(12, "linear", "noise");
    let [a, b] = plates(280.0, 2.0, 1.0);
    let mut stream = key.stream(0);
    let mut table = String::from("time [s],A [K],B [K]\n");
    for row in 0..60 {
        let read = [a, b].map(|value| value + SIGMA * stream.normal());
        table.push_str(&format!("{},{:e},{:e}\n", 60 * row, read[0], read[1]));
    }
    let sensor = |name: &str| format!(r#""{name}": {{"measures": "{name}", "sigma": {{"value": 0.2, "unit": "K"}}}}"#);
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Crawl", "parent": null, "seed": 3,
        "measurements": {{"test": {{"transient": {{"file": "data.csv", "initial": {{"steady": {{}}}}, "sensors": {{{}, {}}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{"effects": ["ripple"]}}}}}}}}"#,
        sensor("A"),
        sensor("B")
    );
    let output = diagnosed(&table, ("effects/ripple.json", RIPPLE), &pass);
    let said = |what: &str| output.warnings.iter().any(|warning| warning.contains(what));
    assert!(said("the transient `test` is given up") || said("more than 50 times the steps"), "{:?}", output.warnings);
}

/// A heat with the root of how much warmer the sink is than 262 K: in a phase at 260 K there is none.
const ROOT: &str = r#"{"format": "bmv-effect/1", "title": "Root", "applies": {"node": {}}, "inputs": {"u": {"unit": "K"}},
    "parameters": {"power": {"unit": "W/K^0.5", "prior": {"normal": {"mean": 0, "sd": 1}}, "description": "scale", "plausible": 1}},
    "adds": {"load": "power * sqrt(u - 262)"}, "equation": "Q = P sqrt(u - 262 K)", "signature": "a root",
    "confused_with": ["heat-load"], "separate": "a colder sink", "source": "made up"}"#;

#[test]
fn a_set_without_a_solution_in_a_held_out_row_is_left_out_and_said() {
    let key = StreamKey::new(13, "linear", "noise");
    let measured = noisy(readings(1.0, [3.0, 0.0], [0.0; 2]), &key, 0);
    let mut table = String::from("phase,T_sink [K],Q [W],A [K],B [K]\n");
    for (row, [sink, q]) in PHASES.iter().enumerate() {
        table.push_str(&format!("P{row},{sink},{q},{:e},{:e}\n", measured[2 * row], measured[2 * row + 1]));
    }
    let sensor = |name: &str| format!(r#""{name}": {{"measures": "{name}", "sigma": {{"value": 0.2, "unit": "K"}}}}"#);
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Root", "parent": null, "seed": 3,
        "measurements": {{"test": {{"steady": {{"file": "data.csv", "held_out": {{"phases": ["P6"]}}, "sensors": {{{}, {}}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{"effects": ["root", "heat-load"]}}}}}}}}"#,
        sensor("A"),
        sensor("B")
    );
    let output = diagnosed(&table, ("effects/root.json", ROOT), &pass);
    assert_eq!(output.selected, ["heat-load:A"], "{:?}", output.words);
    let said = |warning: &String| warning.contains("root:A:T_sink") && warning.contains("no solution in row 7");
    assert!(output.warnings.iter().any(said), "{:?}", output.warnings);
    let unseen = output.unseen.iter().find(|unseen| unseen.id == "root:A:T_sink").expect("listed");
    assert!(unseen.why.starts_with("it cannot be fitted: no solution in row 7"), "{}", unseen.why);
}

/// The diagnosis of a study with an effect of its own.
fn diagnosed(table: &str, effect: (&str, &str), pass: &str) -> bmv::diagnosis::Output {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("effects")).expect("made");
    let files = [("model.json", MODEL), ("data.csv", table), effect, ("pass-1.json", pass)];
    small_study::diagnosed(&small_study::loaded(folder.path(), &files))
}
