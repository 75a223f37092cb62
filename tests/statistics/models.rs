//! Posteriors with known answers, and a check of their gradients.

use bmv::inference::target::{Rejected, Target};
use bmv::random::Distribution;

type Evaluate = dyn Fn(&[f64], &mut [f64]) -> Result<f64, Rejected> + Sync;

/// A target given by a function that writes the gradient of the log likelihood and returns its value.
pub struct Model {
    names: Vec<String>,
    priors: Vec<Distribution>,
    evaluate: Box<Evaluate>,
}

impl Model {
    pub fn new(
        priors: Vec<Distribution>,
        evaluate: impl Fn(&[f64], &mut [f64]) -> Result<f64, Rejected> + Sync + 'static,
    ) -> Self {
        let names = (0..priors.len()).map(|i| format!("parameter {i}")).collect();
        Self { names, priors, evaluate: Box::new(evaluate) }
    }
}

impl Target for Model {
    type Workspace = Vec<f64>;

    fn names(&self) -> &[String] {
        &self.names
    }

    fn priors(&self) -> &[Distribution] {
        &self.priors
    }

    fn workspace(&self) -> Vec<f64> {
        vec![0.0; self.priors.len()]
    }

    fn log_likelihood(&self, parameters: &[f64], workspace: &mut Vec<f64>) -> Result<f64, Rejected> {
        workspace.fill(0.0);
        (self.evaluate)(parameters, workspace)
    }

    fn log_likelihood_gradient(
        &self,
        parameters: &[f64],
        _workspace: &mut Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        gradient.fill(0.0);
        (self.evaluate)(parameters, gradient)
    }
}

/// Compares the gradient at parameters with central differences of relative step 1e-6, to 1e-6 of the gradient's size.
pub fn check_gradient<T: Target>(target: &T, at: &[f64]) {
    let mut workspace = target.workspace();
    let mut gradient = vec![0.0; at.len()];
    target.log_likelihood_gradient(at, &mut workspace, &mut gradient).expect("evaluates");
    let size = gradient.iter().fold(1.0_f64, |size, g| size.max(g.abs()));
    for i in 0..at.len() {
        let step = 1e-6 * at[i].abs().max(1e-3);
        let mut value = |x: f64| {
            let mut point = at.to_vec();
            point[i] = x;
            target.log_likelihood(&point, &mut workspace).expect("evaluates")
        };
        let difference = (value(at[i] + step) - value(at[i] - step)) / (2.0 * step);
        assert!((difference - gradient[i]).abs() < 1e-6 * size, "{i}: {difference} {}", gradient[i]);
    }
}

pub fn normal(mean: f64, sd: f64) -> Distribution {
    Distribution::Normal { mean, sd, lower: None, upper: None }
}

pub fn uniform(lower: f64, upper: f64) -> Distribution {
    Distribution::Uniform { lower, upper }
}

/// Half of ln(2 pi).
pub const HALF_LN_TAU: f64 = 0.918_938_533_204_672_7;

/// Log density of a normal variable; adds nothing else.
pub fn log_normal_density(deviation: f64, sd: f64) -> f64 {
    let z = deviation / sd;
    -0.5 * z * z - libm::log(sd) - HALF_LN_TAU
}

/// Conjugate normal: prior N(1, 2^2), five readings with noise 0.5. Mean and sd of the posterior, log evidence.
pub fn conjugate() -> (Model, [f64; 3]) {
    let readings = [2.1, 2.9, 2.4, 2.6, 2.2];
    let (prior_mean, prior_sd, noise) = (1.0, 2.0, 0.5);
    let model = Model::new(vec![normal(prior_mean, prior_sd)], move |x, g| {
        let mut sum = 0.0;
        for y in readings {
            sum += log_normal_density(y - x[0], noise);
            g[0] += (y - x[0]) / (noise * noise);
        }
        Ok(sum)
    });
    let n = readings.len() as f64;
    let precision = 1.0 / (prior_sd * prior_sd) + n / (noise * noise);
    let sum: f64 = readings.iter().sum();
    let mean = (prior_mean / (prior_sd * prior_sd) + sum / (noise * noise)) / precision;
    // Bayes' rule at the posterior mean.
    let mut g = [0.0];
    let likelihood = (model.evaluate)(&[mean], &mut g).expect("evaluates");
    let sd = 1.0 / precision.sqrt();
    let evidence = likelihood + log_normal_density(mean - prior_mean, prior_sd) + libm::log(sd) + HALF_LN_TAU;
    (model, [mean, sd, evidence])
}

/// A linear model with Gaussian prior and noise in ten dimensions, by its design matrix.
pub struct LinearGaussian {
    pub dimension: usize,
    pub rows: usize,
    pub design: Vec<f64>,
    pub readings: Vec<f64>,
    pub noise: f64,
    pub prior_sd: f64,
}

/// A number of -1 to 1 that looks random, from an index.
fn scramble(index: usize) -> f64 {
    2.0 * ((index as f64 * 0.754_877_666_246_692_8 + 0.37).fract()) - 1.0
}

impl LinearGaussian {
    pub fn new(dimension: usize, rows: usize) -> Self {
        let design = (0..rows * dimension)
            .map(|k| scramble(k) + if k % dimension == 1 { 0.8 * scramble(k - 1) } else { 0.0 })
            .collect();
        let readings = (0..rows).map(|i| 2.0 * scramble(1000 + 7 * i)).collect();
        Self { dimension, rows, design, readings, noise: 0.4, prior_sd: 1.5 }
    }

    pub fn model(&self) -> Model {
        let (d, noise) = (self.dimension, self.noise);
        let (design, readings) = (self.design.clone(), self.readings.clone());
        Model::new(vec![normal(0.0, self.prior_sd); d], move |x, g| {
            let mut sum = 0.0;
            for (row, y) in design.chunks_exact(d).zip(&readings) {
                let fit: f64 = row.iter().zip(x).map(|(a, b)| a * b).sum();
                sum += log_normal_density(y - fit, noise);
                for j in 0..d {
                    g[j] += (y - fit) / (noise * noise) * row[j];
                }
            }
            Ok(sum)
        })
    }

    /// Exact mean, covariance and log evidence, by nalgebra.
    pub fn exact(&self) -> (nalgebra::DVector<f64>, nalgebra::DMatrix<f64>, f64) {
        use nalgebra::{DMatrix, DVector};
        let a = DMatrix::from_row_slice(self.rows, self.dimension, &self.design);
        let y = DVector::from_row_slice(&self.readings);
        let noise_precision = 1.0 / (self.noise * self.noise);
        let precision = a.transpose() * &a * noise_precision
            + DMatrix::identity(self.dimension, self.dimension) / (self.prior_sd * self.prior_sd);
        let covariance = precision.try_inverse().expect("regular");
        let mean = &covariance * a.transpose() * &y * noise_precision;
        let marginal = &a * a.transpose() * (self.prior_sd * self.prior_sd)
            + DMatrix::identity(self.rows, self.rows) * (self.noise * self.noise);
        let factor = marginal.cholesky().expect("positive definite");
        let log_det: f64 = factor.l().diagonal().iter().map(|v| 2.0 * libm::log(*v)).sum();
        let quadratic = y.dot(&factor.solve(&y));
        (mean, covariance, -0.5 * (quadratic + log_det) - self.rows as f64 * HALF_LN_TAU)
    }
}

/// Haario's banana: `x0 ~ N(0, 2^2)`, `x1 + 0.5 (x0^2 - 4) ~ N(0, 1)`, within a wide uniform box.
/// Means 0, 0; variances 4 and 1 + 0.25 Var(x0^2) = 1 + 0.25 * 2 * 16 = 9.
pub fn banana() -> Model {
    Model::new(vec![uniform(-20.0, 20.0), uniform(-150.0, 30.0)], |x, g| {
        let bend = x[1] + 0.5 * (x[0] * x[0] - 4.0);
        g[0] = -x[0] / 4.0 - bend * x[0];
        g[1] = -bend;
        Ok(log_normal_density(x[0], 2.0) + log_normal_density(bend, 1.0))
    })
}

/// Two normal modes at -3 and 3 in each of two dimensions, sd 0.5, weights 0.3 and 0.7, in a box from -10 to 10.
/// Evidence: the density of the box, 1 / 400.
pub fn two_modes() -> Model {
    Model::new(vec![uniform(-10.0, 10.0); 2], |x, g| {
        let part = |centre: f64, weight: f64| {
            libm::log(weight) + log_normal_density(x[0] - centre, 0.5) + log_normal_density(x[1] - centre, 0.5)
        };
        let (a, b) = (part(-3.0, 0.3), part(3.0, 0.7));
        let top = a.max(b);
        let total = top + libm::log(libm::exp(a - top) + libm::exp(b - top));
        let share = libm::exp(a - total);
        for i in 0..2 {
            g[i] = (share * (-3.0 - x[i]) + (1.0 - share) * (3.0 - x[i])) / 0.25;
        }
        Ok(total)
    })
}

/// A uniform box 0 to 1 whose likelihood falls by e^-20 from the lower bound: an exponential, cut at one.
pub fn pressed() -> Model {
    Model::new(vec![uniform(0.0, 1.0)], |x, g| {
        g[0] = -20.0;
        Ok(-20.0 * x[0])
    })
}

/// Inferred noise: three groups' effects with a common, inferred spread and an inferred noise, non-centred.
/// Parameters: mean, ln-uniform noise, half-normal spread, three standard effects.
pub fn inferred_noise() -> Model {
    let readings = [[1.2, 0.8, 1.1, 1.4], [2.0, 2.2, 1.7, 2.3], [0.2, 0.5, 0.1, 0.4]];
    let mut priors = vec![
        normal(0.0, 5.0),
        Distribution::LogUniform { lower: 1e-3, upper: 10.0 },
        Distribution::HalfNormal { scale: 2.0 },
    ];
    priors.extend([normal(0.0, 1.0); 3]);
    Model::new(priors, move |x, g| {
        let mut sum = 0.0;
        for (group, values) in readings.iter().enumerate() {
            for y in values {
                let deviation = y - x[0] - x[2] * x[3 + group];
                let pull = deviation / (x[1] * x[1]);
                sum += log_normal_density(deviation, x[1]);
                g[0] += pull;
                g[1] += deviation * pull / x[1] - 1.0 / x[1];
                g[2] += pull * x[3 + group];
                g[3 + group] += pull * x[2];
            }
        }
        Ok(sum)
    })
}

/// A standard normal in two dimensions whose model fails where the first parameter is above 1 and gives NaN below -2:
/// the posterior is the normal cut to -2..1 in the first parameter.
pub fn failing() -> Model {
    Model::new(vec![normal(0.0, 3.0), normal(0.0, 3.0)], |x, g| {
        if x[0] > 1.0 {
            return Err(Rejected::new("the solver did not converge"));
        }
        if x[0] < -2.0 {
            return Ok(f64::NAN);
        }
        // With the prior of sd 3 the posterior is the standard normal.
        let precision = 1.0 - 1.0 / 9.0;
        g[0] = -precision * x[0];
        g[1] = -precision * x[1];
        Ok(-0.5 * precision * (x[0] * x[0] + x[1] * x[1]))
    })
}

/// Correlation of [`ridge`], and its standard deviations.
pub const RIDGE: (f64, [f64; 2]) = (0.995, [0.015, 0.0007]);

/// A ridge between two parameters of which the first lies two standard deviations above its bound of 0.75, and its mode.
pub fn ridge() -> (Model, [f64; 2]) {
    let (rho, [a, b]) = RIDGE;
    let mode = [0.78, 0.0348];
    let model = Model::new(vec![uniform(0.75, 0.95), uniform(0.02, 0.08)], move |x, g| {
        let (u, v) = ((x[0] - mode[0]) / a, (x[1] - mode[1]) / b);
        let rest = 1.0 - rho * rho;
        g[0] = -(u - rho * v) / rest / a;
        g[1] = -(v - rho * u) / rest / b;
        Ok(-0.5 * (u * u - 2.0 * rho * u * v + v * v) / rest)
    });
    (model, mode)
}
