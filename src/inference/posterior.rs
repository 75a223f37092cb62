//! The posterior density in unconstrained coordinates, evaluated by one chain with its own memory and counters.

use serde::{Deserialize, Serialize};

use super::target::{Rejected, Rejections, Target};
use super::transform::{Transform, TransformError};
use crate::random::Stream;

/// The posterior of a target over unconstrained coordinates, shared between chains.
pub struct Posterior<'a, T: Target> {
    target: &'a T,
    transforms: Vec<Transform>,
}

impl<'a, T: Target> Posterior<'a, T> {
    /// The posterior of a target.
    ///
    /// # Errors
    /// [`TransformError`] for a prior that cannot be sampled.
    pub fn new(target: &'a T) -> Result<Self, TransformError> {
        let transforms = target
            .priors()
            .iter()
            .enumerate()
            .map(|(index, prior)| Transform::new(prior, index))
            .collect::<Result<_, _>>()?;
        Ok(Self { target, transforms })
    }

    /// Number of coordinates.
    pub fn dimension(&self) -> usize {
        self.transforms.len()
    }

    /// The maps of the parameters.
    pub fn transforms(&self) -> &[Transform] {
        &self.transforms
    }

    /// The coordinates of parameters (SI).
    pub fn coordinates(&self, parameters: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(parameters).map(|(transform, &value)| transform.coordinate(value)).collect()
    }

    /// The parameters (SI) at coordinates.
    pub fn parameters(&self, coordinates: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(coordinates).map(|(transform, &z)| transform.at(z).value).collect()
    }

    /// Parameters (SI) moved away from their bounds by a hundredth of the interval (of the scale on a half-line).
    pub fn inner_parameters(&self, parameters: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(parameters).map(|(transform, &value)| transform.inner(value, 0.01)).collect()
    }

    /// The coordinates of one draw from the prior.
    pub fn draw_prior(&self, stream: &mut Stream) -> Vec<f64> {
        let draw: Vec<f64> = self.target.priors().iter().map(|prior| prior.quantile(stream.uniform())).collect();
        self.coordinates(&draw)
    }

    /// An evaluator with memory and counters of its own.
    pub fn evaluator(&self) -> Evaluator<'_, T> {
        let dimension = self.dimension();
        Evaluator {
            posterior: self,
            workspace: self.target.workspace(),
            parameters: vec![0.0; dimension],
            slopes: vec![0.0; dimension],
            gradient: vec![0.0; dimension],
            work: Work::default(),
        }
    }
}

/// What a chain spent.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Likelihoods without gradient.
    pub likelihoods: u64,
    /// Likelihoods with gradient.
    pub gradients: u64,
    /// Evaluations that were rejected, by reason.
    pub rejections: Rejections,
}

impl Work {
    /// Adds the work of another chain.
    pub fn merge(&mut self, other: &Self) {
        self.likelihoods += other.likelihoods;
        self.gradients += other.gradients;
        self.rejections.merge(&other.rejections);
    }
}

/// The parts of the posterior's log density at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Density {
    /// Log density of the prior over the parameters (SI).
    pub log_prior: f64,
    /// Logarithm of the map's slope, all parameters together.
    pub log_slope: f64,
    /// Logarithm of the likelihood.
    pub log_likelihood: f64,
}

impl Density {
    /// Log density over the coordinates of prior times likelihood to a power.
    #[inline]
    pub fn tempered(&self, temperature: f64) -> f64 {
        self.log_prior + self.log_slope + temperature * self.log_likelihood
    }

    /// Log density over the coordinates, not normalised.
    #[inline]
    pub fn total(&self) -> f64 {
        self.log_prior + self.log_slope + self.log_likelihood
    }
}

/// Evaluates a posterior for one chain.
pub struct Evaluator<'a, T: Target> {
    posterior: &'a Posterior<'a, T>,
    workspace: T::Workspace,
    parameters: Vec<f64>,
    slopes: Vec<f64>,
    gradient: Vec<f64>,
    /// What was spent so far.
    pub work: Work,
}

impl<T: Target> Evaluator<'_, T> {
    /// Parameters (SI) of the last evaluation.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// The density at coordinates; `None`, counted, where the target refuses or gives no finite number.
    #[inline]
    pub fn density(&mut self, coordinates: &[f64]) -> Option<Density> {
        let (log_prior, log_slope) = self.prior(coordinates, None)?;
        self.work.likelihoods += 1;
        let answer = self.posterior.target.log_likelihood(&self.parameters, &mut self.workspace);
        let log_likelihood = self.checked(answer)?;
        Some(Density { log_prior, log_slope, log_likelihood })
    }

    /// The density at coordinates and the gradient of its total.
    #[inline]
    pub fn density_gradient(&mut self, coordinates: &[f64], gradient: &mut [f64]) -> Option<Density> {
        let (log_prior, log_slope) = self.prior(coordinates, Some(gradient))?;
        self.work.gradients += 1;
        let answer =
            self.posterior.target.log_likelihood_gradient(&self.parameters, &mut self.workspace, &mut self.gradient);
        let log_likelihood = self.checked(answer)?;
        for (i, g) in gradient.iter_mut().enumerate() {
            *g += self.gradient[i] * self.slopes[i];
            if !g.is_finite() {
                self.work.rejections.count(&Rejected::new("the gradient is not finite"));
                return None;
            }
        }
        Some(Density { log_prior, log_slope, log_likelihood })
    }

    /// Prior and map, with their gradient over the coordinates where asked for.
    #[inline]
    fn prior(&mut self, coordinates: &[f64], gradient: Option<&mut [f64]>) -> Option<(f64, f64)> {
        let priors = self.posterior.target.priors();
        let (mut log_prior, mut log_slope) = (0.0, 0.0);
        let mut gradient = gradient;
        for (i, &z) in coordinates.iter().enumerate() {
            let image = self.posterior.transforms[i].at(z);
            self.parameters[i] = image.value;
            self.slopes[i] = image.slope;
            log_prior += priors[i].log_density(image.value);
            log_slope += image.log_slope;
            if let Some(gradient) = gradient.as_deref_mut() {
                gradient[i] = priors[i].log_density_derivative(image.value) * image.slope + image.log_slope_slope;
            }
        }
        if (log_prior + log_slope).is_finite() {
            Some((log_prior, log_slope))
        } else {
            self.work.rejections.count(&Rejected::new("the prior density is not finite"));
            None
        }
    }

    #[inline]
    fn checked(&mut self, answer: Result<f64, Rejected>) -> Option<f64> {
        match answer {
            Ok(value) if value.is_finite() => Some(value),
            Ok(_) => {
                self.work.rejections.count(&Rejected::new("the log likelihood is not finite"));
                None
            }
            Err(rejected) => {
                self.work.rejections.count(&rejected);
                None
            }
        }
    }
}
