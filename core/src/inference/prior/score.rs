//! Normal scores: a parameter's value as the coordinate in which its prior is the standard normal distribution,
//! `z = Phi^-1(F(x))`.
//!
//! What data say nothing about keeps the score's normal distribution whatever the prior's shape is; what they determine
//! well is nearly linear in the score. So draws of a posterior are closer to a normal distribution here than in the
//! parameter itself, or in coordinates that know its bounds alone. For normal and lognormal priors the score is linear in
//! the parameter or its logarithm.

use crate::inference::prior::transform::{Transform, TransformError};
use crate::math::functions::exp;
use crate::math::special::{ln_normal_density, normal_cdf, normal_quantile};
use crate::random::Distribution;

/// Largest score of a draw for which probabilities keep their digits: beyond, they are too close to 0 or 1.
const LARGEST: f64 = 6.0;
/// Scores are cut here, where a probability differs from 1 by a few units in its last place.
const END: f64 = 8.0;

/// The score of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Score {
    /// By the prior's own probabilities.
    Probability(Distribution),
    /// By the map of the prior's support onto the line, where that is as good (normal, lognormal) or where draws lie too
    /// far out in the prior's tails for probabilities.
    Support(Transform),
}

/// A parameter at a score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scored {
    /// The parameter, SI.
    pub value: f64,
    /// `dx/dz`.
    pub slope: f64,
}

impl Score {
    /// The score by a prior, suited to these draws of the parameter.
    ///
    /// # Errors
    /// [`TransformError`] for a fixed value or a support without extent.
    pub fn new(prior: &Distribution, draws: impl IntoIterator<Item = f64>) -> Result<Self, TransformError> {
        let support = Transform::new(prior, 0)?;
        if matches!(support, Transform::Line { .. } | Transform::LogLine { .. }) {
            return Ok(Self::Support(support));
        }
        let probability = Self::Probability(*prior);
        let inside = draws.into_iter().all(|draw| probability.of(draw).abs() <= LARGEST);
        Ok(if inside { probability } else { Self::Support(support) })
    }

    /// The score of a value (SI); finite also at and beyond a bound.
    pub fn of(&self, value: f64) -> f64 {
        match self {
            Self::Support(transform) => transform.coordinate(value),
            Self::Probability(prior) => match prior.cdf(value) {
                below if below <= 0.0 => -END,
                below if below >= 1.0 => END,
                below => normal_quantile(below).clamp(-END, END),
            },
        }
    }

    /// The value at a score.
    pub fn at(&self, z: f64) -> Scored {
        match self {
            Self::Support(transform) => {
                let image = transform.at(z);
                Scored { value: image.value, slope: image.slope }
            }
            Self::Probability(prior) => {
                let cut = z.clamp(-END, END);
                let value = prior.quantile(normal_cdf(cut));
                let slope = exp(ln_normal_density(cut) - prior.log_density(value));
                Scored { value, slope: if cut == z && slope.is_finite() { slope } else { 0.0 } }
            }
        }
    }
}
