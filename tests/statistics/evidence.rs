//! Evidence by the Laplace approximation with active bounds, and by importance sampling, against exact values.

use bmv::inference::estimate::identifiability::{Combination, Finding};
use bmv::inference::estimate::point_estimate::{End, PointEstimate, PointSettings, estimate};
use bmv::inference::sampler::importance::{ImportanceSettings, estimate as importance};
use bmv::inference::target::{LeastSquares, Rejected, Target};
use bmv::random::{Distribution, StreamKey};

use super::models::{self, HALF_LN_TAU, normal, uniform};

type Predict = fn(&[f64], f64, &mut [f64]) -> f64;

/// Readings at abscissas with a known noise, or with one inferred as the last parameter.
struct Readings {
    names: Vec<String>,
    priors: Vec<Distribution>,
    readings: Vec<(f64, f64)>,
    noise: Option<f64>,
    predict: Predict,
}

impl Readings {
    fn new(priors: Vec<Distribution>, readings: &[(f64, f64)], noise: Option<f64>, predict: Predict) -> Self {
        let names = (0..priors.len()).map(|i| format!("parameter {i}")).collect();
        Self { names, priors, readings: readings.to_vec(), noise, predict }
    }

    fn estimate(&self) -> PointEstimate {
        estimate(self, &PointSettings::default(), &StreamKey::new(3, "evidence", "starts"), &[]).expect("an estimate")
    }
}

impl Target for Readings {
    type Workspace = ();

    fn names(&self) -> &[String] {
        &self.names
    }

    fn priors(&self) -> &[Distribution] {
        &self.priors
    }

    fn workspace(&self) {}

    fn log_likelihood(&self, parameters: &[f64], workspace: &mut ()) -> Result<f64, Rejected> {
        let mut residuals = vec![0.0; self.readings.len()];
        let offset = self.residuals(parameters, workspace, &mut residuals)?;
        Ok(offset - 0.5 * residuals.iter().map(|r| r * r).sum::<f64>())
    }

    fn log_likelihood_gradient(
        &self,
        parameters: &[f64],
        workspace: &mut (),
        gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        let n = parameters.len();
        let (mut residuals, mut jacobian) = (vec![0.0; self.readings.len()], vec![0.0; self.readings.len() * n]);
        let offset = self.jacobian(parameters, workspace, &mut residuals, &mut jacobian, gradient)?;
        for (row, r) in jacobian.chunks_exact(n).zip(&residuals) {
            for i in 0..n {
                gradient[i] -= r * row[i];
            }
        }
        Ok(offset - 0.5 * residuals.iter().map(|r| r * r).sum::<f64>())
    }
}

impl LeastSquares for Readings {
    fn residual_count(&self) -> usize {
        self.readings.len()
    }

    fn residuals(&self, parameters: &[f64], _: &mut (), residuals: &mut [f64]) -> Result<f64, Rejected> {
        let mut jacobian = vec![0.0; residuals.len() * parameters.len()];
        self.jacobian(parameters, &mut (), residuals, &mut jacobian, &mut vec![0.0; parameters.len()])
    }

    fn jacobian(
        &self,
        parameters: &[f64],
        _: &mut (),
        residuals: &mut [f64],
        jacobian: &mut [f64],
        offset_gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        offset_gradient.fill(0.0);
        let n = parameters.len();
        let count = self.readings.len() as f64;
        let noise = self.noise.unwrap_or(parameters[n - 1]);
        for (i, row) in jacobian.chunks_exact_mut(n).enumerate() {
            let (x, y) = self.readings[i];
            row.fill(0.0);
            residuals[i] = ((self.predict)(parameters, x, row) - y) / noise;
            for slope in row.iter_mut() {
                *slope /= noise;
            }
            if self.noise.is_none() {
                row[n - 1] = -residuals[i] / noise;
            }
        }
        if self.noise.is_none() {
            offset_gradient[n - 1] = -count / noise;
        }
        Ok(-count * (libm::log(noise) + HALF_LN_TAU))
    }
}

fn line(b: &[f64], x: f64, slopes: &mut [f64]) -> f64 {
    slopes[0] = 1.0;
    slopes[1] = x;
    b[0] + b[1] * x
}

const LINE: [(f64, f64); 5] = [(0.0, 1.1), (1.0, 2.2), (2.0, 2.8), (3.0, 4.3), (4.0, 4.9)];

/// Log evidence of two parameters by the midpoint rule over a box.
fn quadrature(model: &Readings, lower: [f64; 2], upper: [f64; 2]) -> f64 {
    let points = 1500;
    let mut logs = Vec::new();
    for i in 0..points {
        for j in 0..points {
            let place =
                |k: usize, axis: usize| lower[axis] + (upper[axis] - lower[axis]) * (k as f64 + 0.5) / points as f64;
            let x = [place(i, 0), place(j, 1)];
            let prior: f64 = model.priors.iter().zip(x).map(|(prior, x)| prior.log_density(x)).sum();
            logs.push(model.log_likelihood(&x, &mut ()).expect("evaluates") + prior);
        }
    }
    let cell = (upper[0] - lower[0]) * (upper[1] - lower[1]) / (points * points) as f64;
    bmv::math::sum::log_sum_exp(&logs) + libm::log(cell)
}

#[test]
#[ignore = "thorough"]
fn a_line_with_normal_priors_is_exact() {
    let model = Readings::new(vec![normal(0.0, 2.0), normal(0.0, 2.0)], &LINE, Some(0.3), line);
    let fit = model.estimate();
    let exact = quadrature(&model, [-1.0, 0.2], [3.0, 1.8]);
    assert!((fit.log_evidence.expect("evidence") - exact).abs() < 1e-6, "{fit:?} {exact}");
    assert!(fit.findings.is_empty(), "{:?}", fit.findings);
    assert!(fit.descents.iter().all(|descent| descent.converged));
    let settings = ImportanceSettings::default();
    let key = StreamKey::new(3, "evidence", "importance");
    let sampled = importance(&model, &settings, &key, 0, Some(&fit.parameters)).expect("an estimate");
    assert!((sampled.log_evidence - exact).abs() < 4.0 * sampled.log_evidence_error, "{sampled:?} {exact}");
    assert!(sampled.log_evidence_error < 0.02 && sampled.pareto_k.expect("a shape") < 0.5, "{sampled:?}");
    for i in 0..2 {
        assert!((sampled.mean[i] - fit.parameters[i]).abs() < 0.05 * fit.sd()[i]);
        assert!((sampled.sd[i] / fit.sd()[i] - 1.0).abs() < 0.05);
    }
}

#[test]
#[ignore = "thorough"]
fn a_bound_that_cuts_the_fit_is_counted() {
    // The free fit has a slope of about 0.97 with sd 0.095; the box ends at 0.7, and cuts the intercept at 1.2.
    let priors = vec![uniform(-2.0, 2.2), uniform(0.0, 0.7)];
    let model = Readings::new(priors, &LINE, Some(0.3), line);
    let fit = model.estimate();
    assert_eq!(fit.held, vec![None, Some(End::Upper)]);
    assert_eq!(fit.parameters[1], 0.7);
    assert!(matches!(fit.findings[0], Finding::AtBound { parameter: 1, end: End::Upper, pull } if pull > 1.0));
    let exact = quadrature(&model, [0.0, 0.0], [2.2, 0.7]);
    // The model is linear, so that only the rule for the box is approximate.
    assert!((fit.log_evidence.expect("evidence") - exact).abs() < 0.01, "{fit:?} {exact}");
    let key = StreamKey::new(3, "evidence", "importance");
    let sampled = importance(&model, &ImportanceSettings::default(), &key, 0, Some(&fit.parameters)).expect("one");
    assert!((sampled.log_evidence - exact).abs() < 4.0 * sampled.log_evidence_error, "{sampled:?} {exact}");
}

#[test]
fn an_inferred_noise_is_estimated_with_its_curvature() {
    let priors = vec![normal(0.0, 5.0), normal(0.0, 5.0), Distribution::LogUniform { lower: 1e-3, upper: 10.0 }];
    let model = Readings::new(priors, &LINE, None, line);
    let fit = model.estimate();
    // The mode over the logarithm of the noise: its square is the mean of the squared residuals.
    let squares: f64 = LINE
        .iter()
        .map(|(x, y)| {
            let r = fit.parameters[0] + fit.parameters[1] * x - y;
            r * r
        })
        .sum();
    assert!((fit.parameters[2] - (squares / 5.0).sqrt()).abs() < 1e-6, "{fit:?}");
    // Curvature over the logarithm: twice the number of readings.
    assert!((fit.sd()[2] / fit.parameters[2] - 0.1_f64.sqrt()).abs() < 0.01, "{:?}", fit.sd());
}

#[test]
fn a_product_is_named_and_its_flat_direction_shown() {
    let predict: Predict = |b, x, slopes| {
        slopes[0] = b[1] * x;
        slopes[1] = b[0] * x;
        b[0] * b[1] * x
    };
    let model = Readings::new(vec![uniform(0.1, 4.0), uniform(0.1, 4.0)], &LINE, Some(0.3), predict);
    let fit = model.estimate();
    let together = Finding::OnlyTogether { first: 0, second: 1, combination: Combination::Product };
    assert!(fit.findings.contains(&together), "{:?}", fit.findings);
    assert!(
        fit.findings
            .iter()
            .any(|finding| matches!(finding, Finding::FlatDirection { information, .. } if *information < 1e-9))
    );
    assert!(fit.log_evidence.is_some_and(f64::is_finite));
}

#[test]
fn importance_sampling_of_a_pressed_posterior() {
    let model = models::pressed();
    let key = StreamKey::new(3, "evidence", "pressed");
    let sampled = importance(&model, &ImportanceSettings::default(), &key, 0, Some(&[0.0])).expect("an estimate");
    let exact = libm::log((1.0 - libm::exp(-20.0)) / 20.0);
    assert!((sampled.log_evidence - exact).abs() < 4.0 * sampled.log_evidence_error, "{sampled:?}");
    assert!(sampled.effective > 1000.0 && sampled.pareto_k.expect("a shape") < 0.7, "{sampled:?}");
    assert!((sampled.mean[0] - 0.05).abs() < 0.005);
}
