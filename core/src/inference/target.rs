//! What a posterior is to the estimators and samplers of this room: parameters with priors, and a likelihood that can
//! be evaluated, or refuses with a reason.
//!
//! A target never answers a failed model run with an infinity of its own making: it returns [`Rejected`], which the
//! callers count by reason and treat as a likelihood of zero at that point.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::random::Distribution;

/// A point at which the likelihood could not be evaluated, and why.
#[derive(Clone, Debug, PartialEq, Eq, Error, Serialize, Deserialize)]
#[error("{reason}")]
pub struct Rejected {
    /// Why, without numbers that differ from point to point, so that equal reasons can be counted together.
    pub reason: Cow<'static, str>,
    /// Whether a transient was given up, since it took far more steps than it may.
    pub is_given_up: bool,
}

impl Rejected {
    /// A rejection for this reason.
    pub fn new(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { reason: reason.into(), is_given_up: false }
    }
}

/// A posterior over parameters with independent priors.
///
/// A target is shared between threads; everything that an evaluation writes to lies in a [`Target::Workspace`], of which
/// each chain owns one. An evaluation must depend on its arguments only, not on what the workspace saw before.
pub trait Target: Sync {
    /// Memory of one chain, reused from evaluation to evaluation.
    type Workspace: Send;

    /// Names of the parameters, in their order.
    fn names(&self) -> &[String];

    /// Priors of the parameters, SI, in their order; none of them [`Distribution::Fixed`].
    fn priors(&self) -> &[Distribution];

    /// A workspace for one chain.
    fn workspace(&self) -> Self::Workspace;

    /// Logarithm of the likelihood at parameters within their priors' supports (SI), normalising constants included.
    ///
    /// # Errors
    /// [`Rejected`] where the likelihood has no value. A result that is not finite is counted as a rejection too.
    fn log_likelihood(&self, parameters: &[f64], workspace: &mut Self::Workspace) -> Result<f64, Rejected>;

    /// The same, with the derivatives with respect to the parameters (per SI unit).
    ///
    /// # Errors
    /// As [`Target::log_likelihood`].
    fn log_likelihood_gradient(
        &self,
        parameters: &[f64],
        workspace: &mut Self::Workspace,
        gradient: &mut [f64],
    ) -> Result<f64, Rejected>;

    /// Number of parameters.
    fn dimension(&self) -> usize {
        self.priors().len()
    }
}

/// A target whose likelihood is that of Gaussian noise: `ln L = offset - |r|^2 / 2` with whitened residuals `r`.
///
/// The offset holds the normalising constants; it depends on the parameters where a noise parameter is inferred.
pub trait LeastSquares: Target {
    /// Number of whitened residuals.
    fn residual_count(&self) -> usize;

    /// Writes the whitened residuals and returns the offset.
    ///
    /// # Errors
    /// As [`Target::log_likelihood`].
    fn residuals(
        &self,
        parameters: &[f64],
        workspace: &mut Self::Workspace,
        residuals: &mut [f64],
    ) -> Result<f64, Rejected>;

    /// Writes the whitened residuals, their derivatives (`residuals x parameters`, row by row, per SI unit) and the
    /// derivatives of the offset, and returns the offset.
    ///
    /// # Errors
    /// As [`Target::log_likelihood`].
    fn jacobian(
        &self,
        parameters: &[f64],
        workspace: &mut Self::Workspace,
        residuals: &mut [f64],
        jacobian: &mut [f64],
        offset_gradient: &mut [f64],
    ) -> Result<f64, Rejected>;
}

/// Rejected evaluations by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rejections {
    /// Reasons with how often each was given, in the order of their first appearance; at most
    /// [`Rejections::MOST_REASONS`], then `other reasons`.
    pub by_reason: Vec<(String, u64)>,
    /// How many were transients that were given up.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub given_up: u64,
}

/// Whether nothing was counted.
fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Rejections {
    /// Reasons told apart.
    pub const MOST_REASONS: usize = 16;

    /// Counts one rejection.
    pub fn count(&mut self, rejected: &Rejected) {
        self.add(&rejected.reason, 1);
        self.given_up += u64::from(rejected.is_given_up);
    }

    /// Adds the counts of another tally.
    pub fn merge(&mut self, other: &Self) {
        for (reason, count) in &other.by_reason {
            self.add(reason, *count);
        }
    }

    /// Number of rejections for all reasons.
    pub fn total(&self) -> u64 {
        self.by_reason.iter().map(|(_, count)| count).sum()
    }

    fn add(&mut self, reason: &str, more: u64) {
        if let Some(entry) = self.by_reason.iter_mut().find(|(recorded, _)| recorded == reason) {
            entry.1 += more;
        } else if self.by_reason.len() < Self::MOST_REASONS {
            self.by_reason.push((reason.to_owned(), more));
        } else if let Some(last) = self.by_reason.last_mut() {
            // The last place is given up for everything that no longer fits.
            if last.0 != OTHER_REASONS {
                OTHER_REASONS.clone_into(&mut last.0);
            }
            last.1 += more;
        }
    }
}

/// Stands for reasons beyond those that are kept apart.
pub const OTHER_REASONS: &str = "other reasons";
