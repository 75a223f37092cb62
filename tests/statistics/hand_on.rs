//! Posteriors handed on, on a straight line whose posterior, evidence and predictions are exact.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use bmv::inference::likelihood::rows::used_rows;
use bmv::job::ready::Readiness;
use bmv::job::{calibrate, predict, propagate};
use bmv::job::{load, ready};
use nalgebra::{DMatrix, DVector};
use serde_json::Value;

const MODEL: &str = r#"{"format": "bmv-network/1", "title": "Line",
 "inputs": {"x": {"unit": "1", "nominal": 0.5}},
 "parameters": {"a": {"unit": "1", "nominal": 1, "prior": {"normal": {"mean": 1, "sd": 2}}},
                "b": {"unit": "1", "nominal": 0, "prior": {"normal": {"mean": -0.5, "sd": 1.5}}},
                "c": {"unit": "1", "nominal": 0, "prior": {"uniform": [-0.1, 0.1]}}},
 "quantities": {"y": {"expression": {"of": "a + b * x", "unit": "1"}}, "z": {"expression": {"of": "a + b + c", "unit": "1"}}}}"#;

const NOISE: f64 = 0.3;

/// Inputs and readings: made up, of no line in particular.
const FIRST: [(f64, f64); 5] = [(0.0, 0.31), (0.5, 0.92), (1.0, 1.71), (1.5, 2.13), (2.0, 2.48)];
const SECOND: [(f64, f64); 4] = [(1.0, 1.2), (2.0, 3.05), (3.0, 3.61), (4.0, 5.2)];

fn table(rows: &[(f64, f64)], name: &str) -> String {
    let rows = rows.iter().enumerate().map(|(i, (x, y))| format!("{name}{i},{x},{y}\n"));
    format!("phase,x [1],y [1]\n{}", rows.collect::<String>())
}

fn pass(parameters: &str, measurements: &str, jobs: &str) -> String {
    format!(
        r#"{{"format": "bmv-pass/1", "title": "t", "parent": null, "seed": 5, "parameters": {{{parameters}}},
            "requirements": {{"low": {{"quantity": "z", "below": 1.6, "probability": 0.9}}}},
            "measurements": {{{measurements}}}, "jobs": {{{jobs}}}}}"#
    )
}

fn measurement(name: &str) -> String {
    format!(
        r#""{name}": {{"steady": {{"file": "data/{name}.csv", "sensors": {{"y": {{"measures": "y", "sigma": {NOISE}}}}}}}}}"#
    )
}

const HANDED_ON: &str = r#""a": {"prior": {"posterior": {"pass": "pass-1.json", "job": "fit"}}, "because": "handed on"},
                           "b": {"prior": {"posterior": {"pass": "pass-1.json", "job": "fit"}}, "because": "handed on"}"#;

/// Pass 1 has the first data, pass 2 the second with the posterior of pass 1 as its prior, pass 3 all at once.
fn study() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| {
        let path = root.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    put("model.json", MODEL);
    put("data/first.csv", &table(&FIRST, "A"));
    put("data/second.csv", &table(&SECOND, "B"));
    let fit = r#""fit": {"calibrate": {"parameters": ["a", "b"]}}"#;
    put("pass-1.json", &pass("", &measurement("first"), fit));
    let jobs = format!(
        r#"{fit}, "spread": {{"propagate": {{"samples": 4096, "quantities": ["y", "z"]}}}},
           "carried": {{"predict": {{"from": {{"pass": "pass-1.json", "job": "fit"}}, "samples": 4096}}}}"#
    );
    put("pass-2.json", &pass(HANDED_ON, &measurement("second"), &jobs));
    put("pass-3.json", &pass("", &format!("{}, {}", measurement("first"), measurement("second")), fit));
    root
}

/// Results of the jobs of passes, by file and name, each after those that it needs.
pub struct Results<'s> {
    study: &'s Path,
    known: BTreeMap<(String, String), Arc<Value>>,
}

impl<'s> Results<'s> {
    /// Nothing has run yet.
    pub fn of_study(study: &'s Path) -> Self {
        Self { study, known: BTreeMap::new() }
    }

    /// The result of a job of a pass.
    pub fn of(&mut self, file: &str, job: &str) -> Arc<Value> {
        if let Some(known) = self.known.get(&(file.to_owned(), job.to_owned())) {
            return Arc::clone(known);
        }
        let pass = load(&self.study.join(file)).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
        let (_, readiness) = ready(&pass).into_iter().find(|(name, _)| name == job).unwrap();
        let job_ready = match readiness {
            Readiness::Ready(job) => job,
            Readiness::After(deferred) => {
                let upstream: Vec<_> = deferred.from.iter().map(|from| self.of(&from.file, &from.job)).collect();
                let known = deferred.identity();
                let job = deferred.prepare(&upstream).unwrap();
                assert_eq!(job.identity(), known, "known before the upstream ran");
                job
            }
            Readiness::NotRun(reason) => panic!("{reason}"),
            Readiness::Refused(wrong) => panic!("{wrong:?}"),
        };
        let result = Arc::new(crate::serial::run(job_ready.as_ref()).unwrap());
        self.known.insert((file.to_owned(), job.to_owned()), Arc::clone(&result));
        result
    }
}

/// Exact mean, covariance and log evidence of a line with a normal prior.
fn exact(mean: &DVector<f64>, covariance: &DMatrix<f64>, rows: &[(f64, f64)]) -> (DVector<f64>, DMatrix<f64>, f64) {
    let design = DMatrix::from_fn(rows.len(), 2, |row, column| if column == 0 { 1.0 } else { rows[row].0 });
    let readings = DVector::from_fn(rows.len(), |row, _| rows[row].1);
    let prior = covariance.clone().try_inverse().unwrap();
    let posterior = (&prior + design.transpose() * &design / (NOISE * NOISE)).try_inverse().unwrap();
    let at = &posterior * (&prior * mean + design.transpose() * &readings / (NOISE * NOISE));
    let marginal =
        &design * covariance * design.transpose() + DMatrix::identity(rows.len(), rows.len()) * NOISE * NOISE;
    let rest = &readings - &design * mean;
    let quadratic = rest.dot(&(marginal.clone().try_inverse().unwrap() * &rest));
    let constant = rows.len() as f64 * libm::log(core::f64::consts::TAU);
    (at, posterior, -0.5 * (quadratic + libm::log(marginal.determinant()) + constant))
}

fn prior() -> (DVector<f64>, DMatrix<f64>) {
    (DVector::from_vec(vec![1.0, -0.5]), DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 2.25])))
}

/// Mean and sd of both parameters and their correlation agree with the exact ones, within five standard errors of `draws`
/// independent draws.
fn agrees(output: &calibrate::Output, mean: &DVector<f64>, covariance: &DMatrix<f64>, draws: f64) {
    assert!(output.converged, "{:?}", output.objections);
    for (place, name) in ["a", "b"].into_iter().enumerate() {
        let (own, sd) = (&output.parameters[name], covariance[(place, place)].sqrt());
        assert!((own.mean - mean[place]).abs() < 5.0 * sd / draws.sqrt(), "{name}: {} {}", own.mean, mean[place]);
        assert!((own.sd / sd - 1.0).abs() < 5.0 * (0.5 / draws).sqrt(), "{name}: {} {sd}", own.sd);
        assert!((own.map - mean[place]).abs() < 5.0 * sd / draws.sqrt(), "{name}: {} {}", own.map, mean[place]);
    }
    let exact = covariance[(0, 1)] / (covariance[(0, 0)] * covariance[(1, 1)]).sqrt();
    let error = (1.0 - exact * exact) / draws.sqrt();
    let found = output.correlations[0][1];
    assert!((found - exact).abs() < 5.0 * error, "{found} {exact} {error}");
}

#[test]
#[ignore = "thorough"]
fn data_one_after_the_other_are_all_data_at_once() {
    let root = study();
    let mut results = Results::of_study(root.path());
    let mut fit =
        |file: &str| -> calibrate::Output { serde_json::from_value((*results.of(file, "fit")).clone()).unwrap() };
    let (first, second, whole) = (fit("pass-1.json"), fit("pass-2.json"), fit("pass-3.json"));
    let (mean, covariance) = prior();
    let (mean_1, covariance_1, evidence_1) = exact(&mean, &covariance, &FIRST);
    let all: Vec<(f64, f64)> = FIRST.iter().chain(&SECOND).copied().collect();
    let (mean_all, covariance_all, evidence_all) = exact(&mean, &covariance, &all);
    // The chain rule itself.
    let (_, _, evidence_2) = exact(&mean_1, &covariance_1, &SECOND);
    assert!((evidence_1 + evidence_2 - evidence_all).abs() < 1e-9);
    // 4000 draws of chains whose effective size is half of that at least.
    agrees(&first, &mean_1, &covariance_1, 2000.0);
    agrees(&whole, &mean_all, &covariance_all, 2000.0);
    // The prior is known from 1000 draws: their errors, which the second data only make smaller, and those of the chains.
    agrees(&second, &mean_all, &covariance_all, 1.0 / (1.0 / 1000.0 + 1.0 / 2000.0));
    assert_eq!(second.posterior_priors.len(), 1);
    assert_eq!((second.posterior_priors[0].draws, second.posterior_prior_fits[0].doubts.len()), (1000, 0));
    // The evidence: to first order in the errors of the prior's mean (covariance C / 1000) and covariance (Wishart).
    let design = DMatrix::from_fn(SECOND.len(), 2, |row, column| if column == 0 { 1.0 } else { SECOND[row].0 });
    let marginal = &design * &covariance_1 * design.transpose() + DMatrix::identity(4, 4) * NOISE * NOISE;
    let weight = design.transpose() * marginal.try_inverse().unwrap();
    let readings = DVector::from_fn(4, |row, _| SECOND[row].1);
    let pull = &weight * (&readings - &design * &mean_1);
    let bend = (&pull * pull.transpose() - &weight * &design) * 0.5;
    let by_mean = (pull.transpose() * &covariance_1 * &pull)[(0, 0)] / 1000.0;
    let by_covariance = 2.0 * (&bend * &covariance_1 * &bend * &covariance_1).trace() / 1000.0;
    let variance = |output: &calibrate::Output| output.log_evidence.sd.unwrap() * output.log_evidence.sd.unwrap();
    let sampled = variance(&first) + variance(&second);
    let error = (by_mean + by_covariance + sampled).sqrt();
    let found = first.log_evidence.value.unwrap() + second.log_evidence.value.unwrap();
    assert!(error < 0.2 && (found - evidence_all).abs() < 5.0 * error, "{found} {evidence_all} {error}");
    assert!((whole.log_evidence.value.unwrap() - evidence_all).abs() < 0.01);
}

#[test]
fn a_propagation_keeps_the_draws_correlations() {
    let root = study();
    let mut results = Results::of_study(root.path());
    let output: propagate::Output = serde_json::from_value((*results.of("pass-2.json", "spread")).clone()).unwrap();
    let (mean, covariance) = prior();
    let (mean, covariance, _) = exact(&mean, &covariance, &FIRST);
    // z = a + b + c; apart from their correlation a and b would give more than twice the variance.
    let variance = covariance.sum() + 0.04 / 12.0;
    let apart = covariance[(0, 0)] + covariance[(1, 1)];
    assert!(apart > 2.0 * variance, "{apart} {variance}");
    let z = &output.cases[0].quantities[1];
    assert_eq!(z.name, "z");
    // Five standard errors of 1000 draws.
    assert!((z.sd / variance.sqrt() - 1.0).abs() < 5.0 * (0.5_f64 / 1000.0).sqrt(), "{} {}", z.sd, variance.sqrt());
    assert!((z.mean - mean.sum()).abs() < 5.0 * (variance / 1000.0).sqrt(), "{} {}", z.mean, mean.sum());
    // What is stated as error is that of a thousand draws, not of 4096 samples: nearly all of z is a and b.
    let stated = z.mean_standard_error / (variance / 1000.0).sqrt();
    assert!((0.8..1.2).contains(&stated), "{stated}");
    assert_eq!((output.converged, output.posterior_priors[0].draws), (Some(true), 1000));
}

#[test]
fn a_prediction_is_the_propagation_of_posterior_and_prior() {
    let root = study();
    let mut results = Results::of_study(root.path());
    let output: predict::Output = serde_json::from_value((*results.of("pass-2.json", "carried")).clone()).unwrap();
    let (mean, covariance) = prior();
    let (posterior, spread, _) = exact(&mean, &covariance, &FIRST);
    let check = |output: &propagate::Output, mean: &DVector<f64>, covariance: &DMatrix<f64>, draws: f64| {
        let case = &output.cases[0];
        let z = case.quantities.iter().find(|q| q.name == "z").unwrap();
        let sd = (covariance.sum() + 0.04 / 12.0).sqrt();
        assert!((z.mean - mean.sum()).abs() < 5.0 * sd / draws.sqrt(), "{} {}", z.mean, mean.sum());
        let share = bmv::math::special::normal_cdf((1.6 - mean.sum()) / sd);
        let met = case.requirements[0].probability;
        // c is not normal, and a small part of z.
        assert!((met.value - share).abs() < 5.0 * (share * (1.0 - share) / draws).sqrt() + 0.01, "{met:?} {share}");
        assert!(met.lower < met.value && met.value < met.upper);
    };
    check(&output.posterior, &posterior, &spread, 1000.0);
    check(&output.prior, &mean, &covariance, 4096.0);
    assert!(output.converged && output.prior.converged.is_none());
}

#[test]
fn rows_are_known_by_their_content() {
    let root = study();
    std::fs::copy(root.path().join("data/first.csv"), root.path().join("data/second.csv")).unwrap();
    let (a, b) = (load(&root.path().join("pass-1.json")).unwrap(), load(&root.path().join("pass-3.json")).unwrap());
    // A copy under another name is the same data; other readings are others.
    assert_eq!(used_rows(&a.measurements[0]), used_rows(&b.measurements[1]));
    let error = load(&root.path().join("pass-2.json")).expect_err("the same data twice").render(false, 9);
    assert!(error.contains("data-used-twice") && error.contains("phases A0, A1, A2, A3, A4 of `second`"), "{error}");
}
