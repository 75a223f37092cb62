//! Tests of `core/src/inference/joint_discrepancy.rs`.

use bmv::inference::gaussian_process::{Form, Kernel, Training, Trend};
use bmv::inference::joint_discrepancy::*;
use bmv::inference::likelihood::HALF_LN_TAU;
use bmv::inference::sampler::nuts;
use bmv::inference::sampler::nuts::NutsSettings;
use bmv::inference::target::{LeastSquares, Rejected, Target};
use bmv::math::functions::{exp, ln};
use bmv::random::{Distribution, StreamKey};
use bmv::statistics::chain_diagnostics;
use nalgebra::{DMatrix, DVector};

/// `z = H theta + noise`.
#[derive(Clone)]
struct Line {
    slopes: Vec<f64>,
    readings: Vec<f64>,
    sds: Vec<f64>,
    names: Vec<String>,
    priors: Vec<Distribution>,
}

impl Line {
    fn new(slopes: Vec<f64>, readings: Vec<f64>, sds: Vec<f64>, prior_sd: f64) -> Self {
        let n = slopes.len() / readings.len();
        let prior = Distribution::Normal { mean: 0.0, sd: prior_sd, lower: None, upper: None };
        Self { slopes, readings, sds, names: (0..n).map(|k| format!("theta {k}")).collect(), priors: vec![prior; n] }
    }
}

impl Target for Line {
    type Workspace = ();
    fn names(&self) -> &[String] {
        &self.names
    }
    fn priors(&self) -> &[Distribution] {
        &self.priors
    }
    fn workspace(&self) {}
    fn log_likelihood(&self, parameters: &[f64], (): &mut ()) -> Result<f64, Rejected> {
        let mut residuals = vec![0.0; self.readings.len()];
        let offset = self.residuals(parameters, &mut (), &mut residuals)?;
        Ok(offset - 0.5 * residuals.iter().map(|r| r * r).sum::<f64>())
    }
    fn log_likelihood_gradient(&self, _: &[f64], (): &mut (), _: &mut [f64]) -> Result<f64, Rejected> {
        Err(Rejected::new("not asked for"))
    }
}

impl LeastSquares for Line {
    fn residual_count(&self) -> usize {
        self.readings.len()
    }
    fn residuals(&self, parameters: &[f64], (): &mut (), residuals: &mut [f64]) -> Result<f64, Rejected> {
        let n = parameters.len();
        for (i, residual) in residuals.iter_mut().enumerate() {
            let predicted: f64 = (0..n).map(|j| self.slopes[i * n + j] * parameters[j]).sum();
            *residual = (self.readings[i] - predicted) / self.sds[i];
        }
        Ok(self.sds.iter().map(|sd| -ln(*sd) - HALF_LN_TAU).sum())
    }
    fn jacobian(
        &self,
        parameters: &[f64],
        memory: &mut (),
        residuals: &mut [f64],
        jacobian: &mut [f64],
        offset_gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        let n = parameters.len();
        offset_gradient.fill(0.0);
        for (k, entry) in jacobian.iter_mut().enumerate() {
            *entry = -self.slopes[k] / self.sds[k / n];
        }
        self.residuals(parameters, memory, residuals)
    }
}

fn process(sensor: &str, rows: Vec<usize>, points: &[f64], sds: &[f64], form: Form) -> SensorProcess {
    let noise = sds.iter().map(|sd| sd * sd).collect();
    let training = Training::new(1, points.to_vec(), vec![0.0; points.len()], noise).expect("points");
    let prior = |mean| Distribution::Normal { mean, sd: 1.0, lower: None, upper: None };
    let mut priors = vec![prior(-1.0), prior(0.0)];
    priors.truncate(form.hyperparameters(1));
    SensorProcess { sensor: sensor.into(), rows, sds: sds.to_vec(), training, form, priors }
}

fn square(x: f64) -> f64 {
    x * x
}

const SMOOTH: Form = Form { kernel: Some(Kernel::SquaredExponential), trend: Trend::None, scatter: false };

#[test]
fn with_given_hyperparameters_the_parameters_are_those_of_generalised_least_squares() {
    // Readings a + b x of one sensor with a process, and 2 a - b x of another without one.
    let xs = [0.0, 0.3, 0.9, 1.4, 2.2, 3.0];
    let z = [1.1, 1.9, 2.4, 3.6, 3.1, 5.2, 1.7, 1.9, 0.4, 0.9, -0.8, -0.3];
    let sds = [0.2, 0.1, 0.3, 0.2, 0.2, 0.4, 0.5, 0.4, 0.3, 0.5, 0.6, 0.5];
    let slopes: Vec<f64> = xs.iter().flat_map(|x| [1.0, *x]).chain(xs.iter().flat_map(|x| [2.0, -x])).collect();
    let line = Line::new(slopes.clone(), z.to_vec(), sds.to_vec(), 10.0);
    let joint = JointDiscrepancy::new(line, vec![process("y", (0..6).collect(), &xs, &sds[..6], SMOOTH)]);
    let (variance, length) = (0.7, 1.2);
    // By dense matrices: C = K + S, theta = (H' C^-1 H)^-1 H' C^-1 z.
    let covariance = DMatrix::from_fn(12, 12, |i, j| {
        let noise = if i == j { sds[i] * sds[i] } else { 0.0 };
        let smooth = if i < 6 && j < 6 { variance * exp(-0.5 * square((xs[i] - xs[j]) / length)) } else { 0.0 };
        noise + smooth
    });
    let (h, z) = (DMatrix::from_row_slice(12, 2, &slopes), DVector::from_row_slice(&z));
    let inverse = covariance.clone().try_inverse().expect("regular");
    let information = h.transpose() * &inverse * &h;
    let theta = information.clone().try_inverse().expect("regular") * h.transpose() * &inverse * &z;
    let at = [theta[0], theta[1], ln(variance), ln(length)];
    let mut memory = joint.workspace();
    let mut gradient = [0.0; 4];
    let value = joint.log_likelihood_gradient(&at, &mut memory, &mut gradient).expect("a value");
    // Slopes are of order 100 next to it.
    assert!(gradient[0].abs() < 1e-8 && gradient[1].abs() < 1e-8, "{gradient:?}");
    let left = &z - &h * &theta;
    let expected =
        -0.5 * (left.transpose() * &inverse * &left)[0] - 0.5 * ln(covariance.determinant()) - 12.0 * HALF_LN_TAU;
    assert!(
        (value - expected).abs() < 1e-8
            && (joint.log_likelihood(&at, &mut memory).expect("a value") - value).abs() < 1e-10
    );
    // The curvature is the information: one step away, exactly in a linear model.
    for k in 0..2 {
        let mut moved = at;
        moved[k] += 0.01;
        let mut slopes = [0.0; 4];
        joint.log_likelihood_gradient(&moved, &mut memory, &mut slopes).expect("a value");
        for a in 0..2 {
            assert!((slopes[a] + 0.01 * information[(a, k)]).abs() < 1e-8, "{slopes:?} {information}");
        }
    }
    // Slopes with the hyperparameters: central differences, whose error is of order 1e-10 here.
    for k in 2..4 {
        let moved = |step: f64| {
            let mut moved = at;
            moved[k] += step;
            joint.log_likelihood(&moved, &mut joint.workspace()).expect("a value")
        };
        assert!(((moved(1e-5) - moved(-1e-5)) / 2e-5 - gradient[k]).abs() < 1e-6, "{gradient:?}");
    }
}

#[test]
#[ignore = "thorough"]
fn the_posterior_is_that_of_quadrature() {
    // z = theta x + discrepancy + noise; theta ~ N(0, 1), logarithms of variance and length as in `process`.
    let xs = [0.2, 0.6, 1.1, 1.5, 2.0, 2.6, 3.1];
    let z = [0.15, 0.41, 0.66, 0.95, 1.17, 1.45, 1.72];
    let line = Line::new(xs.to_vec(), z.to_vec(), vec![0.05; 7], 1.0);
    let joint = JointDiscrepancy::new(line, vec![process("y", (0..7).collect(), &xs, &[0.05; 7], SMOOTH)]);
    // Dense normal densities on a grid over the hyperparameters; theta in closed form: its conditional is normal.
    let (mut sum, mut moments) = (0.0, [0.0; 6]);
    let (h, z) = (DVector::from_row_slice(&xs), DVector::from_row_slice(&z));
    let grid = 61;
    for i in 0..grid * grid {
        let [a, b] = [i / grid, i % grid].map(|k| -5.0 + 10.0 * f64::from(k) / f64::from(grid - 1));
        let (variance, length) = (exp(a - 1.0), exp(b));
        let covariance = DMatrix::from_fn(7, 7, |i, j| {
            variance * exp(-0.5 * square((xs[i] - xs[j]) / length)) + if i == j { 0.0025 } else { 0.0 }
        });
        let factor = covariance.cholesky().expect("regular");
        let information = h.dot(&factor.solve(&h)) + 1.0;
        let mean = h.dot(&factor.solve(&z)) / information;
        let log_determinant = factor.l().diagonal().map(ln).sum();
        let distance = z.dot(&factor.solve(&z)) - mean * mean * information;
        let weight = exp(-0.5 * distance - log_determinant - 0.5 * ln(information) - 0.5 * (a * a + b * b));
        sum += weight;
        let of = [mean, mean * mean + 1.0 / information, a - 1.0, square(a - 1.0), b, b * b];
        moments.iter_mut().zip(of).for_each(|(moment, value)| *moment += weight * value);
    }
    let key = StreamKey::new(3, "joint", "chains");
    let settings = NutsSettings { warm_up: 500, draws: 2000, ..NutsSettings::default() };
    let chains: Vec<_> =
        (0..4).map(|chain| nuts::sample(&joint, &settings, &key, chain, None).expect("a chain")).collect();
    for k in 0..3 {
        let mean = moments[2 * k] / sum;
        let expected_sd = (moments[2 * k + 1] / sum - mean * mean).sqrt();
        let draws: Vec<Vec<f64>> = chains.iter().map(|chain| chain.parameter(k)).collect();
        let found = draws.iter().flatten().sum::<f64>() / 8000.0;
        let error = chain_diagnostics::mcse_mean(&draws).expect("an error");
        assert!((found - mean).abs() < 4.0 * error && error < 0.1 * expected_sd, "{k}: {found} {mean} {error}");
        let sd = (draws.iter().flatten().map(|x| square(x - found)).sum::<f64>() / 8000.0).sqrt();
        // Several thousand effective draws: 5 % are about four standard errors.
        assert!((sd / expected_sd - 1.0).abs() < 0.05, "{k}: {sd} {}", expected_sd);
    }
}
