//! Poincare constants of one variable, which bound total effects by mean squared derivatives.
//!
//! For a variable with density p, `Var f <= C E[f'^2]` for every smooth f; so the total effect of coordinate j is at most
//! `C_j E[(df/dx_j)^2] / V` (Sobol & Kucherenko 2009, theorems 2 and 4: `C = (b - a)^2 / pi^2` for a uniform, `C = sd^2` for a
//! normal variable). A density with `p'' p <= p'^2` (log-concave) on an interval of length L has `C <= L^2 / pi^2` (Payne &
//! Weinberger 1960), and one that is a normal density times such a function, a truncated normal among them, has `C <= sd^2` of
//! that normal (Brascamp & Lieb 1976). Where the logarithm of the variable is one of these, the derivative is taken along it.

use crate::math::functions::ln;
use crate::random::Distribution;

/// What a squared derivative is multiplied with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Poincare {
    /// The constant, in the square of the variable's unit, or of no unit along the logarithm.
    pub constant: f64,
    /// Whether the derivative is one along the variable's logarithm, `x df/dx`.
    pub along_logarithm: bool,
}

impl Poincare {
    /// The best constant that is known for a distribution; 0 for a known value.
    pub fn of(distribution: &Distribution) -> Self {
        let interval = |length: f64| length * length / (std::f64::consts::PI * std::f64::consts::PI);
        let along = |constant: f64| Self { constant, along_logarithm: false };
        match *distribution {
            Distribution::Fixed(_) => along(0.0),
            Distribution::Uniform { lower, upper } | Distribution::Triangular { lower, upper, .. } => {
                along(interval(upper - lower))
            }
            Distribution::Normal { sd, lower, upper, .. } => {
                let bounded = lower.zip(upper).map_or(f64::INFINITY, |(lower, upper)| interval(upper - lower));
                along(bounded.min(sd * sd))
            }
            Distribution::HalfNormal { scale } => along(scale * scale),
            Distribution::LogNormal { factor, .. } => Self { constant: ln(factor) * ln(factor), along_logarithm: true },
            Distribution::LogUniform { lower, upper } => {
                Self { constant: interval(ln(upper / lower)), along_logarithm: true }
            }
        }
    }

    /// The squared derivative at `x` that is averaged, times the constant: in the square of the quantity's unit.
    pub fn weighted_square(&self, x: f64, derivative: f64) -> f64 {
        let slope = if self.along_logarithm { x * derivative } else { derivative };
        self.constant * slope * slope
    }
}
