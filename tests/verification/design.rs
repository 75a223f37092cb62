//! Designs of experiments against exact expected information: the example of Huan & Marzouk (2013, J. Comput. Phys. 232,
//! 288, section 5.1), linear models with normal priors, the radiator's coupon by quadrature, the monitor's chamber.

use std::path::Path;
use std::sync::Arc;

use bmv::job::design::{Candidate, Design, Estimator, Output, Spec};
use bmv::random::Distribution;
use bmv::study::Pass;

use super::radiator::run;

/// A pass in a folder of its own.
fn pass(model: &str, jobs: &str) -> Pass {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("model.json"), model).unwrap();
    let text = format!(
        r#"{{"format": "bmv-pass/1", "title": "t", "parent": null, "model": "model.json", "seed": 7, "jobs": {jobs}}}"#
    );
    std::fs::write(folder.path().join("pass-1.json"), text).unwrap();
    match bmv::job::load(&folder.path().join("pass-1.json")) {
        Ok(pass) => pass,
        Err(diagnostics) => panic!("{}", diagnostics.render(false, 20)),
    }
}

/// Settings of the pass's design.
pub fn settings(pass: &Pass) -> Spec {
    let found = pass.jobs.iter().find_map(|job| job.spec.get::<bmv::job::design::Spec>().cloned());
    found.unwrap()
}

/// Result of a design for the pass's model with other settings and priors.
pub fn designed(pass: &Pass, spec: Spec, priors: &[Distribution]) -> Output {
    run(&Design::new(spec, Arc::new(pass.model.clone()), priors.to_vec(), pass.seed, "design").unwrap())
}

/// Value, and three standard errors with the bias.
fn value(candidate: &Candidate) -> (f64, f64) {
    // Of approximations no bias is known.
    (candidate.information_nats.unwrap(), 3.0 * candidate.se.unwrap() + candidate.bias_bound.unwrap_or(0.0))
}

const HUAN: &str = r#"{"format": "bmv-network/1", "title": "y = theta^3 d^2 + theta exp(-|0.2 - d|)",
 "inputs": {"d": {"unit": "1", "nominal": 0, "range": [0, 1]}, "e": {"unit": "1", "nominal": 0, "range": [0, 1]}},
 "parameters": {"theta": {"unit": "1", "nominal": 0.5, "prior": {"uniform": [0, 1]}}},
 "quantities": {"y": {"expression": {"of": "theta^3 * d^2 + theta * exp(-abs(0.2 - d))", "unit": "1"}},
                "z": {"expression": {"of": "theta^3 * e^2 + theta * exp(-abs(0.2 - e))", "unit": "1"}}}}"#;

/// One experiment (by its d) or two (by d and e).
fn huan(conditions: &str, settings: &str) -> Pass {
    let sensors = if conditions.contains("\"e\"") {
        r#"{"y": {"measures": "y", "sigma": 0.01}, "z": {"measures": "z", "sigma": 0.01}}"#
    } else {
        r#"{"y": {"measures": "y", "sigma": 0.01}}"#
    };
    pass(HUAN, &format!(r#"{{"j": {{"design": {{"conditions": {conditions}, "sensors": {sensors}{settings}}}}}}}"#))
}

/// By Gauss quadrature of both integrals; refining all rules changes the values by less than 2e-13.
const LONG: [(f64, f64); 12] = [
    (0.0, 3.008_295_006),
    (0.1, 3.116_823_719),
    (0.2, 3.241_977_4),
    (0.3, 3.195_570_218),
    (0.4, 3.172_521_617),
    (0.45, 3.169_290_013),
    (0.5, 3.171_135_048),
    (0.6, 3.188_370_417),
    (0.7, 3.220_719_179),
    (0.8, 3.264_830_112),
    (0.9, 3.317_815_831),
    (1.0, 3.377_332_214),
];

/// The same for a prior to 0.43727, printed to four decimals.
const SHORT: [(f64, f64); 5] = [(0.0, 2.2095), (0.2, 2.4075), (0.5, 2.1715), (0.8, 2.0083), (1.0, 1.9466)];

/// Two experiments, by quadrature as above.
const PAIRS: [(f64, f64, f64); 10] = [
    (0.0, 0.0, 3.348_406_39),
    (0.2, 0.2, 3.583_537_358),
    (0.2, 0.4, 3.552_637_483),
    (0.2, 0.6, 3.573_994_356),
    (0.2, 0.8, 3.639_730_195),
    (0.2, 1.0, 3.737_274_78),
    (0.4, 0.4, 3.513_806_511),
    (0.6, 0.6, 3.529_451_883),
    (0.8, 1.0, 3.671_702_124),
    (1.0, 1.0, 3.717_167_762),
];

/// Three standard errors and the bias hold at every d, and the optimum is right, for all seeds but `most`: such a margin
/// is missed by chance in 0.27 % of the cases, and the d share their random numbers. Gives the largest error, nats.
fn one_experiment(how: &str, seeds: u64, most: usize) -> f64 {
    let mut farthest: f64 = 0.0;
    let values: Vec<String> = LONG.iter().map(|(d, _)| d.to_string()).collect();
    let mut pass = huan(&format!(r#"{{"d": [{}]}}"#, values.join(", ")), how);
    let mut misses: Vec<(u64, f64, f64, f64)> = Vec::new();
    for seed in 0..seeds {
        pass.seed = seed;
        let output = designed(&pass, settings(&pass), &pass.priors);
        for (candidate, (d, exact)) in output.candidates.iter().zip(LONG) {
            let (found, margin) = value(candidate);
            farthest = farthest.max((found - exact).abs());
            if !((found - exact).abs() < margin) && !misses.iter().any(|(other, ..)| *other == seed) {
                misses.push((seed, d, found - exact, margin));
            }
            assert!(!candidate.sees_nothing && candidate.allowed);
        }
        let best = output.best.unwrap();
        assert_eq!(best.conditions["d"], 1.0, "{how}");
        assert_eq!(output.convergence.last().unwrap().information_nats, best.information_nats);
    }
    assert!(misses.len() <= most, "{how}: {misses:?}");
    farthest
}

#[test]
#[ignore = "thorough"]
fn one_experiment_is_that_of_huan_and_marzouk() {
    one_experiment(r#", "outer": 512, "inner": 256"#, 4, 0);
    // Acceptance check 4 asks for 0.05 nats with 4000 samples.
    let farthest = one_experiment(r#", "outer": 2048, "inner": 1024"#, 1, 0);
    assert!(farthest < 0.05, "{farthest}");
    one_experiment(r#", "outer": 512, "inner": 256, "estimator": "importance""#, 1, 0);
}

fn short_prior(how: &str) {
    let pass = huan(r#"{"d": [0, 0.2, 0.5, 0.8, 1]}"#, how);
    // theta_e = sqrt((1 - e^-0.8) / 2.88): where the slopes at d = 0.2 and d = 1 are equal.
    let output = designed(&pass, settings(&pass), &[Distribution::Uniform { lower: 0.0, upper: 0.437_271_7 }]);
    for (candidate, (d, exact)) in output.candidates.iter().zip(SHORT) {
        let (found, margin) = value(candidate);
        // Half of the last digit printed.
        assert!((found - exact).abs() < margin + 5e-5, "d = {d}: {found} {exact} {margin}");
    }
    assert_eq!(output.best.unwrap().conditions["d"], 0.2);
}

#[test]
fn a_short_prior_moves_the_optimum() {
    short_prior(r#", "outer": 1024, "inner": 512"#);
}

fn two_experiments(how: &str) {
    let phases: Vec<String> = PAIRS.iter().map(|(d, e, _)| format!(r#"{{"d": {d}, "e": {e}}}"#)).collect();
    let pass = huan(&format!("[{}]", phases.join(", ")), how);
    let output = designed(&pass, settings(&pass), &pass.priors);
    for (candidate, (d, e, exact)) in output.candidates.iter().zip(PAIRS) {
        let (found, margin) = value(candidate);
        assert!((found - exact).abs() < margin, "{d}, {e}: {found} {exact} {margin}");
    }
    let best = output.best.unwrap();
    assert_eq!((best.conditions["d"], best.conditions["e"]), (0.2, 1.0));
}

#[test]
#[ignore = "thorough"]
fn two_experiments_are_those_of_huan_and_marzouk() {
    two_experiments(r#", "outer": 1024, "inner": 512"#);
}

#[test]
#[ignore = "thorough"]
fn two_phases_are_chosen_one_after_the_other() {
    let pass = huan(r#"{"d": [0, 0.2, 0.6, 1]}"#, r#", "outer": 1024, "inner": 512, "pick": 2"#);
    let output = designed(&pass, settings(&pass), &pass.priors);
    let picks: Vec<usize> = output.picks.iter().map(|pick| pick.position).collect();
    assert_eq!(picks, [3, 1], "d = 1, then 0.2");
    let last = &output.picks[1];
    assert!((last.information_nats - 3.737_274_78).abs() < 3.0 * last.se + last.bias_bound.unwrap(), "{last:?}");
    assert!(output.guarantee.contains("63 %"), "{}", output.guarantee);
}

/// Two readings of three parameters with normal priors: all is linear and exact.
const LINEAR: &str = r#"{"format": "bmv-network/1", "title": "linear",
 "inputs": {"x": {"unit": "1", "nominal": 1, "range": [0, 4]}, "fixed": {"unit": "1", "nominal": 1, "settable": false}},
 "parameters": {"a": {"unit": "1", "nominal": 0, "prior": {"normal": {"mean": 0, "sd": 2}}},
                "b": {"unit": "1", "nominal": 1, "prior": {"normal": {"mean": 1, "sd": 0.5}}},
                "c": {"unit": "1", "nominal": 0, "prior": {"normal": {"mean": 0, "sd": 1}}}},
 "quantities": {"y": {"expression": {"of": "a + b * x", "unit": "1"}},
                "z": {"expression": {"of": "b * x - c + 0 * fixed", "unit": "1"}}}}"#;

/// `1/2 ln det(I + G S G' R^-1)` for all parameters, or for `a` and `b` with `c` a nuisance.
fn linear_exact(x: f64, learn_all: bool) -> f64 {
    let (r_y, r_z) = (0.25 * 0.25, 0.5 * 0.5);
    let (a, b, c) = (4.0, 0.25 * x * x, 1.0);
    let all = (a + b + r_y) * (b + c + r_z) - b * b;
    // What is left when a and b are known.
    let rest = r_y * (if learn_all { r_z } else { c + r_z });
    0.5 * bmv::math::functions::ln(all / rest)
}

const SENSORS: &str = r#"{"y": {"measures": "y", "sigma": 0.25}, "z": {"measures": "z", "sigma": 0.5}}"#;

fn linear(how: &str) -> Output {
    let job = format!(r#"{{"j": {{"design": {{"sensors": {SENSORS}, "outer": 2048, "inner": 1024, {how}}}}}}}"#);
    let pass = pass(LINEAR, &job);
    designed(&pass, settings(&pass), &pass.priors)
}

#[test]
#[ignore = "thorough"]
fn linear_models_with_normal_priors_are_exact() {
    for (learn, learn_all) in [(r#"["a", "b", "c"]"#, true), (r#"["a", "b"]"#, false)] {
        for estimator in ["nested", "importance", "laplace", "linear"] {
            let how = format!(r#""conditions": {{"x": [0, 1, 4]}}, "learn": {learn}, "estimator": "{estimator}""#);
            let output = linear(&how);
            for (candidate, x) in output.candidates.iter().zip([0.0, 1.0, 4.0]) {
                let (found, margin) = value(candidate);
                let exact = linear_exact(x, learn_all);
                assert!((found - exact).abs() < margin + 1e-12, "{how} {x}: {found} {exact} {margin}");
                assert!((candidate.linear_nats.unwrap() - exact).abs() < 1e-12, "{how} {x}");
            }
        }
    }
}

/// The linear model read with another noise at three places, about two of its parameters.
fn sharp(sigma: f64, learn: &str, estimator: &str) -> Output {
    let job = format!(
        r#"{{"j": {{"design": {{"sensors": {{"y": {{"measures": "y", "sigma": {sigma}}}, "z": {{"measures": "z", "sigma": {sigma}}}}},
            "outer": 512, "inner": 256, "conditions": {{"x": [0.5, 1, 4]}}, "learn": {learn}{estimator}}}}}}}"#
    );
    let pass = pass(LINEAR, &job);
    designed(&pass, settings(&pass), &pass.priors)
}

/// `1/2 ln det` of the readings' covariance by that without what is learnt.
fn sharp_exact(x: f64, sigma: f64, learns_c: bool) -> f64 {
    let (r, a, b, c) = (sigma * sigma, 4.0, 0.25 * x * x, 1.0);
    let all = (a + b + r) * (b + c + r) - b * b;
    0.5 * bmv::math::functions::ln(all / (r * if learns_c { r } else { c + r }))
}

#[test]
#[ignore = "thorough"]
fn any_noise_has_an_estimator_that_is_right_and_names_the_best() {
    for (learn, learns_c) in [(r#"["a", "b", "c"]"#, true), (r#"["a", "b"]"#, false)] {
        let mut used = Vec::new();
        for sigma in [2.0, 1.0, 0.1, 0.01, 1e-3, 1e-4] {
            let output = sharp(sigma, learn, "");
            for (candidate, x) in output.candidates.iter().zip([0.5, 1.0, 4.0]) {
                let (found, margin) = value(candidate);
                let exact = sharp_exact(x, sigma, learns_c);
                assert!((found - exact).abs() < margin, "{sigma} {x} {}: {found} {exact} {margin}", output.estimator);
                assert!(margin < 0.3 && !candidate.sees_nothing, "{sigma} {x}: {candidate:?}");
            }
            assert!(output.is_trusted && !output.because.is_empty(), "{sigma}");
            assert_eq!(output.best.unwrap().conditions["x"], 4.0, "{sigma}");
            used.push(output.estimator);
        }
        assert_eq!(used.first().map(String::as_str), Some("nested"), "{used:?}");
        assert!(used[3..].iter().all(|name| name == "importance"), "{used:?}");
    }
}

#[test]
fn an_estimator_that_its_diagnostics_forbid_names_no_best() {
    let output = sharp(1e-3, r#"["a", "b", "c"]"#, r#", "estimator": "nested""#);
    assert!(output.best.is_none() && output.picks.is_empty() && !output.is_trusted);
    let bias = output.candidates.iter().filter_map(|candidate| candidate.bias_bound).fold(0.0, f64::max);
    assert!(bias > 1.0 && output.candidates.iter().all(|candidate| !candidate.sees_nothing), "{bias}");
    let said = output.findings.join(" ");
    assert!(said.contains("by `nested` cannot be trusted") && !said.contains("cannot see"), "{said}");
    // With noise enough it is fine, and is what an open choice takes, with the same numbers.
    let [named, open] =
        ["nested", "automatic"].map(|name| sharp(2.0, r#"["a", "b", "c"]"#, &format!(r#", "estimator": "{name}""#)));
    assert!(named.best.is_some() && named.because.is_empty());
    assert_eq!((named.candidates, named.best), (open.candidates, open.best));
}

/// A sharp reading of `a^2 + b^2` leaves a ring: few prior samples lie near it, and no normal proposal follows it.
#[test]
fn where_no_estimator_can_be_trusted_none_is_named_the_best() {
    let model = r#"{"format": "bmv-network/1", "title": "a ring",
     "inputs": {"x": {"unit": "1", "nominal": 1, "range": [0, 2]}},
     "parameters": {"a": {"unit": "1", "nominal": 0.5, "prior": {"normal": {"mean": 0, "sd": 1}}},
        "b": {"unit": "1", "nominal": 0.5, "prior": {"normal": {"mean": 0, "sd": 1}}}},
     "quantities": {"q": {"expression": {"of": "x * (a^2 + b^2)", "unit": "1"}}}}"#;
    let job = r#"{"j": {"design": {"conditions": {"x": [1, 2]}, "outer": 256, "inner": 128, "pick": 2,
        "sensors": {"q": {"measures": "q", "sigma": 1e-5}}}}}"#;
    let pass = pass(model, job);
    let output = designed(&pass, settings(&pass), &pass.priors);
    assert!(output.best.is_none() && output.picks.is_empty() && !output.is_trusted, "{:?}", output.best);
    assert_eq!(output.estimator, "laplace");
    let said = output.findings.join(" ");
    assert!(said.contains("No estimate can be trusted") && said.contains("`importance` cannot be trusted"), "{said}");
}

#[test]
fn a_constant_error_of_a_sensor_is_a_nuisance_that_phases_share() {
    // y = a + b x + error + noise at x = 0, twice: a is seen through an error of sd 1 both times. Var of the mean of both
    // readings given a: 1 + 0.0625 / 2; the difference tells nothing of a.
    let sensors =
        r#"{"y": {"measures": "y", "sigma": 0.25, "bias": {"prior": {"normal": {"mean": 0, "sd": 1}}, "unit": "1"}}}"#;
    let job = format!(
        r#"{{"j": {{"design": {{"sensors": {sensors}, "outer": 2048, "inner": 1024, "conditions": {{"x": [0]}}, "learn": ["a"],
            "nuisance": ["b"], "pick": 2}}}}}}"#
    );
    let pass = pass(LINEAR, &job);
    let output = designed(&pass, settings(&pass), &pass.priors);
    assert_eq!(output.nuisance, ["b", "experiment.y.bias"]);
    for (pick, rest) in output.picks.iter().zip([1.062_5_f64, 1.031_25]) {
        let exact = 0.5 * bmv::math::functions::ln((4.0 + rest) / rest);
        let margin = 3.0 * pick.se + pick.bias_bound.unwrap();
        assert!((pick.information_nats - exact).abs() < margin, "{pick:?} {exact}");
    }
    assert!(output.guarantee.contains("no guarantee"), "{}", output.guarantee);
}

/// Between the values of a coarse grid lies what is best: `U = 1/2 ln(1 + (10 sin(2 x) (1 - (y - 0.3)^2))^2)` is largest at
/// `x = pi / 4`, `y = 0.3`.
#[test]
#[ignore = "thorough"]
fn a_search_finds_the_optimum_between_the_values_of_the_grid() {
    let model = r#"{"format": "bmv-network/1", "title": "a known optimum",
     "inputs": {"x": {"unit": "1", "nominal": 1, "range": [0, 2]}, "y": {"unit": "1", "nominal": 0, "range": [0, 1]}},
     "parameters": {"a": {"unit": "1", "nominal": 0, "prior": {"normal": {"mean": 0, "sd": 1}}}},
     "quantities": {"q": {"expression": {"of": "a * sin(2 * x) * (1 - (y - 0.3)^2)", "unit": "1"}}}}"#;
    let job = r#"{"j": {"design": {"conditions": {"x": [0.1, 0.5, 1.2, 1.5], "y": [0, 0.5, 1]}, "search": 16, "outer": 512, "inner": 256,
        "sensors": {"q": {"measures": "q", "sigma": 0.1}}}}}"#;
    let pass = pass(model, job);
    let output = designed(&pass, settings(&pass), &pass.priors);
    let best = output.best.as_ref().unwrap();
    // U is flat at its top: 0.03 off in each costs 0.003 nats of ln(10) = 2.3.
    let [x, y] = ["x", "y"].map(|name| best.conditions[name]);
    assert!((x - std::f64::consts::FRAC_PI_4).abs() < 0.03 && (y - 0.3).abs() < 0.03, "{x} {y}");
    assert!(
        output.candidates[best.candidate].is_found && output.candidates.len() <= 12 + 16,
        "{}",
        output.candidates.len()
    );
    assert!(output.candidates[..12].iter().all(|candidate| !candidate.is_found));
}

#[test]
#[ignore = "thorough"]
fn a_search_finds_the_optimum_of_huan_and_marzouk() {
    // With the short prior it lies at 0.2, where U has a corner: 2.4075 (printed to four decimals).
    let pass = huan(r#"{"d": [0, 0.35, 0.7, 1]}"#, r#", "outer": 1024, "inner": 512, "search": 16"#);
    let output = designed(&pass, settings(&pass), &[Distribution::Uniform { lower: 0.0, upper: 0.437_271_7 }]);
    let best = output.best.unwrap();
    assert!((best.conditions["d"] - 0.2).abs() < 0.015, "{best:?}");
    // Within 0.015 of the corner U has fallen by 0.014 at most (slope 1 of ln y').
    let (found, margin) = value(&output.candidates[best.candidate]);
    assert!((found - 2.4075).abs() < margin + 0.015, "{found} {margin}");
}

#[test]
#[ignore = "thorough"]
fn errors_of_inputs_count() {
    // y = a + x + error, z = x + error: what errs in x is the same in both. Its constant part (variance 0.25) is one for all
    // phases, the rest (0.09) new in each. Exact by determinants of the readings' covariance with and without a.
    let erring = r#""x": {"unit": "1", "nominal": 1, "range": [0, 4], "sigma": 0.3, "bias": {"prior": {"normal": {"mean": 0, "sd": 0.5}}}}"#;
    let model = LINEAR.replace(r#""x": {"unit": "1", "nominal": 1, "range": [0, 4]}"#, erring);
    let covariance = |phases: usize, learnt: bool| {
        nalgebra::DMatrix::from_fn(2 * phases, 2 * phases, |i, j| {
            let noise = if i != j {
                0.0
            } else if i % 2 == 0 {
                0.25 * 0.25
            } else {
                0.5 * 0.5
            };
            let of_a = if learnt && i % 2 == 0 && j % 2 == 0 { 4.0 } else { 0.0 };
            noise + of_a + 0.25 + if i / 2 == j / 2 { 0.09 } else { 0.0 }
        })
        .determinant()
    };
    for estimator in ["nested", "importance", "laplace", "linear"] {
        let job = format!(
            r#"{{"j": {{"design": {{"sensors": {SENSORS}, "outer": 2048, "inner": 1024, "conditions": {{"x": [2]}}, "learn": ["a"],
                "nuisance": [], "pick": 2, "estimator": "{estimator}"}}}}}}"#
        );
        let pass = pass(&model, &job);
        let output = designed(&pass, settings(&pass), &pass.priors);
        assert_eq!(output.nuisance, ["x.bias"]);
        for (phases, pick) in output.picks.iter().enumerate() {
            let exact = 0.5 * bmv::math::functions::ln(covariance(phases + 1, true) / covariance(phases + 1, false));
            let margin = 3.0 * pick.se + pick.bias_bound.unwrap_or(0.0) + 1e-12;
            assert!((pick.information_nats - exact).abs() < margin, "{estimator} {pick:?} {exact}");
        }
    }
}

#[test]
fn sensors_are_ranked_and_those_that_tell_the_same_are_named() {
    let job = r#"{"j": {"design": {"conditions": {"x": [1]}, "outer": 1024, "inner": 512, "choose_sensors": 2, "learn": ["a"],
        "nuisance": [], "sensors": {"z": {"measures": "z", "sigma": 0.5}, "coarse": {"measures": "y", "sigma": 1},
        "fine": {"measures": "y", "sigma": 0.25}}}}}"#;
    let pass = pass(LINEAR, job);
    let output = designed(&pass, settings(&pass), &pass.priors);
    let chosen: Vec<usize> = output.sensor_picks.iter().map(|pick| pick.position).collect();
    assert_eq!(chosen, [2, 1], "the fine one, then the coarse one");
    assert_eq!(output.redundant.len(), 1);
    assert_eq!(output.redundant[0].sensors, ["coarse", "fine"].map(str::to_owned));
    // z does not move with a, its only unknown here.
    assert_eq!(output.correlations[0][1], None);
    assert_eq!(output.observability[0].changes, [0.0, 2.0, 2.0]);
}

#[test]
fn an_experiment_that_cannot_see_says_so() {
    let job = r#"{"j": {"design": {"conditions": {"x": [1, 2]}, "sensors": {"y": {"measures": "y", "sigma": 0.25}},
        "learn": ["c"], "outer": 512, "inner": 256}}}"#;
    let pass = pass(LINEAR, job);
    let output = designed(&pass, settings(&pass), &pass.priors);
    assert!(output.candidates.iter().all(|candidate| candidate.sees_nothing), "{:?}", output.candidates);
    assert!(output.findings.iter().any(|f| f.contains("cannot see c")), "{:?}", output.findings);
    assert!(output.findings.iter().any(|f| f.contains("moves with c")), "{:?}", output.findings);
}

#[test]
fn what_cannot_be_done_is_refused_at_its_place() {
    let wrong = [
        (r#""conditions": {"x": [0, 9]}"#, "design-conditions", "range"),
        (r#""conditions": {"x": {"from": -1, "to": 4, "steps": 3}}"#, "design-conditions", "range"),
        (r#""conditions": {"x": [1, 1]}"#, "design-conditions", "twice"),
        (r#""conditions": {"x": {"from": 0, "to": 4, "steps": 5000}}"#, "design-conditions", "values"),
        (r#""conditions": [{"x": 1}, {"x": 1}]"#, "design-conditions", "twice"),
        (r#""conditions": []"#, "design-conditions", "candidate"),
        (r#""conditions": {"a": [1]}"#, "design-conditions", "parameter"),
        (r#""conditions": {"fixed": [1]}"#, "design-conditions", "cannot set"),
        (r#""conditions": {"q": [1]}"#, "unknown-name", "input"),
        (r#""conditions": {"x": [1]}, "learn": ["q"]"#, "job-reference", "parameter"),
        (r#""conditions": {"x": [1]}, "learn": ["a"], "nuisance": ["a"]"#, "job-reference", "nuisance"),
        (r#""conditions": {"x": [1]}, "outer": 100"#, "job-setting", "outer"),
        (r#""conditions": {"x": [1]}, "outer": 256, "inner": 256"#, "job-setting", "inner"),
        (r#""conditions": {"x": [1]}, "pick": 0"#, "job-setting", "phases"),
        (r#""conditions": {"x": [1]}, "search": 4"#, "design-conditions", "between"),
        (r#""conditions": [{"x": 1}, {"x": 2}], "search": 4"#, "design-conditions", "between"),
        (r#""conditions": {"x": [1, 2]}, "search": 5000"#, "job-setting", "search"),
        (r#""conditions": {"x": [1]}, "limits": {"red": 2}"#, "job-setting", "probability"),
        (r#""conditions": {"x": [1]}, "choose_sensors": 3"#, "job-setting", "sensors"),
        (r#""conditions": {"x": [1]}, "sensors": ["y", "y"]"#, "job-reference", "sensor"),
        (r#""conditions": {"x": [1]}, "sensors": {"y": {"measures": "y"}}"#, "design-sensor", "sigma"),
        (r#""conditions": {"x": [1]}, "sensors": {}"#, "design-sensor", "without sensors"),
    ];
    for (how, code, words) in wrong {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("model.json"), LINEAR).unwrap();
        let sensors = if how.contains("\"sensors\"") { String::new() } else { format!(r#", "sensors": {SENSORS}"#) };
        let text = format!(
            r#"{{"format": "bmv-pass/1", "title": "t", "model": "model.json", "jobs": {{"j": {{"design": {{{how}{sensors}}}}}}}}}"#
        );
        let file = folder.path().join("pass-1.json");
        std::fs::write(&file, text).unwrap();
        let Err(diagnostics) = bmv::job::load(&file) else { panic!("{how} is taken") };
        let shown = diagnostics.render(false, 20);
        assert!(shown.contains(code) && shown.contains(words) && shown.contains("pass-1.json:1:"), "{how}: {shown}");
    }
}

#[test]
fn a_sensor_of_the_measurements_that_stands_twice_is_refused() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/sxm");
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("data")).unwrap();
    for name in ["model.json", "pass-1.json", "data/thermal-vacuum.csv"] {
        std::fs::copy(file.join(name), folder.path().join(name)).unwrap();
    }
    let load = |sensors: &str| {
        let text = std::fs::read_to_string(file.join("pass-2.json")).unwrap();
        let job = format!(
            r#""jobs": {{ "next": {{"design": {{"learn": ["Gh"], "nuisance": [], "conditions": {{"V": [1, 2]}}{sensors}}}}},"#
        );
        std::fs::write(folder.path().join("pass-2.json"), text.replace(r#""jobs": {"#, &job)).unwrap();
        bmv::job::load(&folder.path().join("pass-2.json"))
    };
    let Ok(pass) = load("") else { panic!("the sensors of the pass") };
    assert_eq!(settings(&pass).sensors.len(), 5);
    assert_eq!(settings(&pass).sensors[4].sigma, 0.5);
    let Ok(pass) = load(r#", "sensors": ["bracket"]"#) else { panic!("one sensor of the pass") };
    assert_eq!(settings(&pass).sensors[0].sigma, 0.25);
    let Err(diagnostics) = load(r#", "sensors": ["bracket", "bracket"]"#) else { panic!("it is taken") };
    assert!(diagnostics.render(false, 20).contains("stands twice"));
}

/// Expected information about the emittance with the leak integrated out, by quadrature to three decimals (case study
/// 3.5): shrouds of 100 to 250 K by heaters of 5 to 25 W.
const COUPON: [[f64; 5]; 4] = [
    [0.268, 0.425, 0.556, 0.665, 0.757],
    [0.416, 0.589, 0.718, 0.822, 0.908],
    [0.607, 0.785, 0.904, 0.997, 1.074],
    [0.684, 0.925, 1.056, 1.149, 1.222],
];

fn radiator() -> Pass {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/radiator/pass-1.json");
    let Ok(pass) = bmv::job::load(&file) else { panic!("the radiator loads") };
    pass
}

/// Every candidate within its own margin and `most` of the quadrature.
fn coupon(pass: &Pass, how: Spec, most: f64) {
    let output = designed(pass, how, &pass.priors);
    for (candidate, exact) in output.candidates.iter().zip(COUPON.as_flattened()) {
        let (found, margin) = value(candidate);
        // Half of the last digit printed.
        assert!((found - exact).abs() < margin.min(most) + 5e-4, "{} {candidate:?}: {exact}", output.estimator);
        assert_eq!(candidate.violation.red, Some(0.0));
    }
    let best = output.best.unwrap();
    assert_eq!((best.conditions["W"], best.conditions["T_s"]), (25.0, 250.0), "{}", output.estimator);
}

#[test]
#[ignore = "thorough"]
fn the_coupon_of_the_radiator_tells_what_quadrature_says() {
    let pass = radiator();
    let quick = Spec { outer: 1024, inner: 512, pick: 1, ..settings(&pass) };
    coupon(&pass, quick.clone(), 0.03);
    // Importance sampling of both integrals by 32 draws knows that it is less sure.
    coupon(&pass, Spec { estimator: Estimator::Importance, ..quick.clone() }, f64::INFINITY);
    // A leak four times as uncertain: 0.054 at the coldest and weakest, 0.438 at the hottest and strongest.
    let leak = pass.model.parameters.iter().position(|p| p.name == "G_leak").unwrap();
    let mut priors = pass.priors.clone();
    priors[leak] = Distribution::Uniform { lower: 0.0, upper: 0.04 };
    let output = designed(&pass, quick, &priors);
    for (candidate, exact) in [(0, 0.054), (19, 0.438)] {
        let (found, margin) = value(&output.candidates[candidate]);
        assert!((found - exact).abs() < margin.min(0.03) + 5e-4, "{candidate}: {found} {exact} {margin}");
    }
}

#[test]
#[ignore = "thorough"]
fn limits_that_would_be_left_forbid_a_candidate() {
    let pass = radiator();
    let coupon = pass.model.nodes.iter().position(|node| node.name == "coupon").unwrap();
    let mut model = pass.model.clone();
    model.nodes[coupon].limits.red = Some([100.0, 325.0]);
    let how = Spec { outer: 256, inner: 128, pick: 1, ..settings(&pass) };
    let output: Output = run(&Design::new(how, Arc::new(model), pass.priors.clone(), 1, "design").unwrap());
    // 25 W into a shroud of 250 K: eps sigma A (T^4 - 250^4) <= 25 W gives at least 336 K for every emittance and leak.
    let hottest = output.candidates.last().unwrap();
    assert!(!hottest.allowed && hottest.violation.red == Some(1.0), "{hottest:?}");
    assert!(hottest.because.as_ref().unwrap().contains("coupon"), "{hottest:?}");
    assert_eq!(hottest.violation.node.as_deref(), Some("coupon"));
    let best = output.best.unwrap();
    assert!(output.candidates[best.candidate].allowed && best.information_nats < hottest.information_nats.unwrap());
}

/// Joint information about three joints in the chamber (case study 4.8), by nested Monte Carlo with reuse and a standard
/// error of 0.01 to 0.03.
const CHAMBER: [[f64; 5]; 3] =
    [[0.28, 1.13, 2.85, 3.70, 4.49], [0.11, 0.66, 2.31, 3.25, 4.12], [0.61, 0.93, 1.82, 2.82, 3.78]];

#[test]
#[ignore = "thorough"]
fn the_chamber_of_the_monitor_tells_more_with_the_cooler_at_work() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/sxm/pass-1.json");
    let Ok(pass) = bmv::job::load(&file) else { panic!("the monitor loads") };
    let how = Spec { outer: 1024, inner: 512, pick: 1, choose_sensors: None, ..settings(&pass) };
    let output = designed(&pass, how, &pass.priors);
    for (candidate, reference) in output.candidates.iter().zip(CHAMBER.as_flattened()) {
        let (found, margin) = value(candidate);
        // Three standard errors of the reference beside ours.
        assert!((found - reference).abs() < margin + 0.09, "{candidate:?}: {reference} {margin}");
    }
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly: many seeds, eight times the samples"]
    fn one_experiment_converges() {
        // A chance of 0.27 % for each of 100 seeds, of perhaps three times that over all d: more than 3 happen once in 100 runs.
        one_experiment(r#", "outer": 1024, "inner": 512"#, 100, 3);
        one_experiment(r#", "outer": 16384, "inner": 8192"#, 2, 0);
        // As above: more than 2 of 20 happen once in 1000 runs.
        one_experiment(r#", "outer": 16384, "draws": 64, "estimator": "importance""#, 20, 2);
    }

    #[test]
    #[ignore = "nightly: eight times the samples, both priors"]
    fn two_experiments_converge() {
        two_experiments(r#", "outer": 16384, "inner": 8192"#);
        short_prior(r#", "outer": 16384, "inner": 8192"#);
    }

    #[test]
    #[ignore = "nightly: enough draws for importance sampling"]
    fn the_coupon_of_the_radiator_by_importance_sampling() {
        let pass = radiator();
        let how = Spec { outer: 1024, pick: 1, draws: 512, estimator: Estimator::Importance, ..settings(&pass) };
        coupon(&pass, how, 0.03);
    }
}
