//! A target some of whose parameters have joint priors (`joint_prior`), as a target of independent priors.
//!
//! In place of those parameters stand whitened coordinates with standard normal priors; every sampler and estimator works
//! with them as with any other target, and results are taken back by [`Informed::estimate`] and [`Informed::chain`].
//! Without joint priors everything passes through unchanged.

use crate::inference::estimate::identifiability::{Finding, Share};
use crate::inference::estimate::point_estimate::PointEstimate;
use crate::inference::prior::joint_prior::{JointPrior, STANDARD, unknowns_at};
use crate::inference::sampler::chains::Chain;
use crate::inference::target::{LeastSquares, Rejected, Target};
use crate::math::sort::sort_by;
use crate::random::Distribution;

/// Shares below this are not named in a direction.
const NOTICEABLE: f64 = 0.1;

/// A target with joint priors.
#[derive(Clone, Debug)]
pub struct Informed<T> {
    target: T,
    priors: Vec<Distribution>,
    joint: Vec<JointPrior>,
}

/// Memory of one chain.
pub struct Memory<W> {
    target: W,
    parameters: Vec<f64>,
    slopes: Vec<Vec<f64>>,
    part: Vec<f64>,
}

impl<T: Target> Informed<T> {
    /// The target with these joint priors, which share no parameter.
    pub fn new(target: T, joint: Vec<JointPrior>) -> Self {
        let mut priors = target.priors().to_vec();
        for &place in joint.iter().flat_map(JointPrior::places) {
            priors[place] = STANDARD;
        }
        Self { target, priors, joint }
    }

    /// The target itself, over its own parameters.
    pub fn target(&self) -> &T {
        &self.target
    }

    /// The same, to be changed.
    pub fn target_mut(&mut self) -> &mut T {
        &mut self.target
    }

    /// The joint priors.
    pub fn joint(&self) -> &[JointPrior] {
        &self.joint
    }

    /// The target's own parameters (SI) at coordinates.
    pub fn parameters(&self, coordinates: &[f64]) -> Vec<f64> {
        unknowns_at(&self.joint, coordinates).0
    }

    /// Writes the parameters and slopes at coordinates.
    fn take(&self, coordinates: &[f64], memory: &mut Memory<T::Workspace>) {
        memory.parameters.copy_from_slice(coordinates);
        for (prior, slopes) in self.joint.iter().zip(&mut memory.slopes) {
            memory.part.clear();
            memory.part.extend(prior.places().iter().map(|&place| coordinates[place]));
            let (values, prior_slopes) = prior.at(&memory.part);
            *slopes = prior_slopes;
            for (&place, value) in prior.places().iter().zip(values) {
                memory.parameters[place] = value;
            }
        }
    }

    /// Turns derivatives by the parameters into derivatives by the coordinates.
    fn pull_back(&self, memory: &mut Memory<T::Workspace>, derivatives: &mut [f64]) {
        for (prior, slopes) in self.joint.iter().zip(&memory.slopes) {
            memory.part.clear();
            memory.part.extend(prior.places().iter().map(|&place| derivatives[place]));
            prior.pull_back(slopes, &mut memory.part);
            for (&place, value) in prior.places().iter().zip(&memory.part) {
                derivatives[place] = *value;
            }
        }
    }

    /// Derivatives of the parameters by the coordinates (`n x n`, row after row).
    fn derivatives(&self, coordinates: &[f64]) -> Vec<f64> {
        let n = coordinates.len();
        let mut derivatives = vec![0.0; n * n];
        for i in 0..n {
            derivatives[i * n + i] = 1.0;
        }
        for prior in &self.joint {
            let whitened: Vec<f64> = prior.places().iter().map(|&place| coordinates[place]).collect();
            let prior_derivatives = prior.derivatives(&prior.at(&whitened).1);
            let width = whitened.len();
            for (a, &i) in prior.places().iter().enumerate() {
                for (b, &j) in prior.places().iter().enumerate() {
                    derivatives[i * n + j] = prior_derivatives[a * width + b];
                }
            }
        }
        derivatives
    }

    /// A chain over the coordinates as one over the parameters.
    pub fn chain(&self, chain: Chain) -> Chain {
        let mut transformed = chain;
        if self.joint.is_empty() {
            return transformed;
        }
        for draw in transformed.draws.chunks_exact_mut(transformed.dimension.max(1)) {
            for prior in &self.joint {
                let whitened: Vec<f64> = prior.places().iter().map(|&place| draw[place]).collect();
                let (values, _) = prior.at(&whitened);
                for (&place, value) in prior.places().iter().zip(values) {
                    draw[place] = value;
                }
            }
        }
        transformed
    }

    /// A point estimate over the coordinates as one over the parameters; the covariance to first order. The density whose
    /// maximum it is, is that over the coordinates.
    pub fn estimate(&self, estimate: &PointEstimate) -> PointEstimate {
        let mut transformed = estimate.clone();
        if self.joint.is_empty() {
            return transformed;
        }
        let n = transformed.parameters.len();
        let slopes = self.derivatives(&estimate.parameters);
        transformed.parameters = self.parameters(&estimate.parameters);
        let mut half = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                half[i * n + j] = (0..n).map(|k| slopes[i * n + k] * estimate.covariance[k * n + j]).sum();
            }
        }
        for i in 0..n {
            for j in 0..n {
                transformed.covariance[i * n + j] = (0..n).map(|k| half[i * n + k] * slopes[j * n + k]).sum();
            }
        }
        for descent in &mut transformed.descents {
            descent.start = self.parameters(&descent.start);
            descent.end = descent.end.take().map(|end| self.parameters(&end));
        }
        transformed.findings = estimate.findings.iter().filter_map(|finding| self.finding(finding, &slopes)).collect();
        transformed
    }

    /// A finding about coordinates as one about parameters; none where it has no meaning for them.
    fn finding(&self, finding: &Finding, slopes: &[f64]) -> Option<Finding> {
        let is_joint = |place: usize| self.joint.iter().any(|prior| prior.places().contains(&place));
        match finding {
            Finding::FlatDirection { information, shares } if shares.iter().any(|share| is_joint(share.parameter)) => {
                let n = self.priors.len();
                let weight = |i: usize| {
                    // In standard deviations of the parameter's own prior.
                    let row = &slopes[i * n..(i + 1) * n];
                    let spread = row.iter().map(|slope| slope * slope).sum::<f64>().sqrt();
                    shares.iter().map(|share| row[share.parameter] * share.weight).sum::<f64>() / spread
                };
                let weights: Vec<f64> = (0..n).map(weight).collect();
                let length = weights.iter().map(|weight| weight * weight).sum::<f64>().sqrt();
                let mut shares: Vec<Share> = (0..n)
                    .map(|parameter| Share { parameter, weight: weights[parameter] / length })
                    .filter(|share| share.weight.abs() > NOTICEABLE)
                    .collect();
                sort_by(&mut shares, |a, b| b.weight.abs().total_cmp(&a.weight.abs()));
                (!shares.is_empty()).then_some(Finding::FlatDirection { information: *information, shares })
            }
            // Products and sums of whitened coordinates say nothing about parameters.
            Finding::OnlyTogether { first, second, .. } if is_joint(*first) || is_joint(*second) => None,
            other => Some(other.clone()),
        }
    }
}

impl<T: Target> Target for Informed<T> {
    type Workspace = Memory<T::Workspace>;

    fn names(&self) -> &[String] {
        self.target.names()
    }

    fn priors(&self) -> &[Distribution] {
        &self.priors
    }

    fn workspace(&self) -> Self::Workspace {
        Memory {
            target: self.target.workspace(),
            parameters: vec![0.0; self.priors.len()],
            slopes: vec![Vec::new(); self.joint.len()],
            part: Vec::new(),
        }
    }

    fn log_likelihood(&self, coordinates: &[f64], memory: &mut Self::Workspace) -> Result<f64, Rejected> {
        self.take(coordinates, memory);
        self.target.log_likelihood(&memory.parameters, &mut memory.target)
    }

    fn log_likelihood_gradient(
        &self,
        coordinates: &[f64],
        memory: &mut Self::Workspace,
        gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        self.take(coordinates, memory);
        let value = self.target.log_likelihood_gradient(&memory.parameters, &mut memory.target, gradient)?;
        self.pull_back(memory, gradient);
        Ok(value)
    }
}

impl<T: LeastSquares> LeastSquares for Informed<T> {
    fn residual_count(&self) -> usize {
        self.target.residual_count()
    }

    fn residuals(
        &self,
        coordinates: &[f64],
        memory: &mut Self::Workspace,
        residuals: &mut [f64],
    ) -> Result<f64, Rejected> {
        self.take(coordinates, memory);
        self.target.residuals(&memory.parameters, &mut memory.target, residuals)
    }

    fn jacobian(
        &self,
        coordinates: &[f64],
        memory: &mut Self::Workspace,
        residuals: &mut [f64],
        jacobian: &mut [f64],
        offset_gradient: &mut [f64],
    ) -> Result<f64, Rejected> {
        self.take(coordinates, memory);
        let offset =
            self.target.jacobian(&memory.parameters, &mut memory.target, residuals, jacobian, offset_gradient)?;
        if !self.joint.is_empty() {
            for row in jacobian.chunks_exact_mut(self.priors.len().max(1)) {
                self.pull_back(memory, row);
            }
            self.pull_back(memory, offset_gradient);
        }
        Ok(offset)
    }
}
