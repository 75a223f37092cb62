//! The posterior density in unconstrained coordinates, evaluated by one chain with its own memory and counters.

use serde::{Deserialize, Serialize};

use crate::inference::prior::transform::{Transform, TransformError};
use crate::inference::prior::triangular_transport::{NormalApproximation, Transport, covariance_of_coordinates};
use crate::inference::target::{Rejected, Rejections, Target};
use crate::random::Stream;
use crate::watch;

/// The posterior of a target over unconstrained coordinates, shared between chains.
pub struct Posterior<'a, T: Target> {
    target: &'a T,
    transforms: Vec<Transform>,
    transport: Option<Transport>,
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
        Ok(Self { target, transforms, transport: None })
    }

    /// The posterior in coordinates that keep the ridges of a normal approximation straight ([`Transport`]).
    ///
    /// # Errors
    /// As [`Posterior::new`].
    pub fn along(target: &'a T, normal: &NormalApproximation) -> Result<Self, TransformError> {
        let untransported = Self::new(target)?;
        let transport = Transport::new(&untransported.transforms, target.priors(), normal);
        Ok(Self { transport, ..untransported })
    }

    /// A normal approximation's covariance over the coordinates, n x n, to first order at its mode.
    pub fn covariance(&self, normal: &NormalApproximation) -> Vec<f64> {
        covariance_of_coordinates(&self.transforms, self.transport.as_ref(), normal)
    }

    /// The parameter at a place of the order in which they are computed, and how far those before move its coordinate.
    #[inline]
    fn at_place(&self, place: usize, parameters: &[f64]) -> (usize, f64) {
        self.transport
            .as_ref()
            .map_or((place, 0.0), |transport| (transport.parameter(place), transport.shift(place, parameters)))
    }

    /// Number of coordinates.
    pub fn dimension(&self) -> usize {
        self.transforms.len()
    }

    /// The coordinates of parameters (SI).
    pub fn coordinates(&self, parameters: &[f64]) -> Vec<f64> {
        let maps = self.transforms.iter().zip(parameters);
        let mut coordinates: Vec<f64> = maps.map(|(transform, &value)| transform.coordinate(value)).collect();
        if let Some(transport) = &self.transport {
            // A parameter at its bound has a coordinate a little inside.
            let maps = self.transforms.iter().zip(&coordinates);
            let inside: Vec<f64> = maps.map(|(transform, &z)| transform.at(z).value).collect();
            for place in 0..coordinates.len() {
                coordinates[transport.parameter(place)] -= transport.shift(place, &inside);
            }
        }
        coordinates
    }

    /// The parameters (SI) at coordinates.
    pub fn parameters(&self, coordinates: &[f64]) -> Vec<f64> {
        let mut parameters = vec![0.0; coordinates.len()];
        self.write_parameters(coordinates, &mut parameters);
        parameters
    }

    /// Writes the parameters (SI) at coordinates.
    pub fn write_parameters(&self, coordinates: &[f64], parameters: &mut [f64]) {
        for place in 0..coordinates.len() {
            let (i, shift) = self.at_place(place, parameters);
            parameters[i] = self.transforms[i].at(coordinates[i] + shift).value;
        }
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
        watch::check();
        let (log_prior, log_slope) = self.prior(coordinates, None)?;
        self.work.likelihoods += 1;
        let answer = self.posterior.target.log_likelihood(&self.parameters, &mut self.workspace);
        let log_likelihood = self.checked(answer)?;
        Some(Density { log_prior, log_slope, log_likelihood })
    }

    /// The density at coordinates and the gradient of its total.
    #[inline]
    pub fn density_gradient(&mut self, coordinates: &[f64], gradient: &mut [f64]) -> Option<Density> {
        watch::check();
        let (log_prior, log_slope) = self.prior(coordinates, Some(gradient))?;
        self.work.gradients += 1;
        let answer =
            self.posterior.target.log_likelihood_gradient(&self.parameters, &mut self.workspace, &mut self.gradient);
        let log_likelihood = self.checked(answer)?;
        for place in (0..gradient.len()).rev() {
            let transport = self.posterior.transport.as_ref();
            let i = transport.map_or(place, |transport| transport.parameter(place));
            gradient[i] += self.gradient[i] * self.slopes[i];
            if let Some(transport) = transport {
                gradient[i] += transport.returned(place, gradient) * self.slopes[i];
            }
            if !gradient[i].is_finite() {
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
        for place in 0..coordinates.len() {
            let (i, shift) = self.posterior.at_place(place, &self.parameters);
            let image = self.posterior.transforms[i].at(coordinates[i] + shift);
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
