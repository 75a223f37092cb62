//! The whitening `W` of a likelihood at given unknowns, for columns of one's own.

use super::{Likelihood, Part};
use crate::inference::likelihood::noise::Filter;
use crate::inference::target::Rejected;
use crate::math::cholesky;

/// `W` with `W' W` the inverse covariance of the noise, prepared at one point.
#[derive(Clone, Debug)]
pub struct Whitening {
    pub(super) blocks: Vec<Block>,
}

/// `W` of some residuals that follow one another.
#[derive(Clone, Debug)]
pub(super) enum Block {
    /// Independent: standard deviations.
    Scales { first: usize, sd: Vec<f64> },
    /// `L` of the covariance.
    Factor { first: usize, size: usize, factor: Vec<f64> },
    /// A sensor over time.
    Series { first: usize, readings: usize, filter: Filter },
}

impl Likelihood {
    /// The whitening at given unknowns.
    ///
    /// # Errors
    /// [`Rejected`] for a covariance that is not positive definite.
    pub fn whitening(&self, unknowns: &[f64]) -> Result<Whitening, Rejected> {
        let mut blocks = Vec::new();
        let unknowns = &*self.at(unknowns);
        for part in &self.parts {
            match part {
                Part::Steady(part) => part.whitening(unknowns, &mut blocks)?,
                Part::Transient(part) => part.whitening(unknowns, &mut blocks)?,
            }
        }
        Ok(Whitening { blocks })
    }
}

impl Whitening {
    /// The filter of a sensor over time, by the position of its first residual.
    pub fn series(&self, first_residual: usize) -> Option<&Filter> {
        self.blocks.iter().find_map(|block| match block {
            Block::Series { first, filter, .. } => (*first == first_residual).then_some(filter),
            Block::Scales { .. } | Block::Factor { .. } => None,
        })
    }

    /// Replaces `d` by `W d`; one entry a residual, in the likelihood's order.
    ///
    /// # Errors
    /// [`Rejected`] for a noise that is not above 0.
    pub fn apply(&self, column: &mut [f64]) -> Result<(), Rejected> {
        for block in &self.blocks {
            match block {
                Block::Scales { first, sd } => {
                    for (value, sd) in column[*first..].iter_mut().zip(sd) {
                        *value /= sd;
                    }
                }
                Block::Factor { first, size, factor } => {
                    cholesky::solve_lower(factor, &mut column[*first..*first + size]);
                }
                Block::Series { first, readings, filter } => filter.apply(&mut column[*first..*first + readings]),
            }
        }
        Ok(())
    }
}
