//! Coordinates in which a prior is standard normal: `x = F^-1(Phi(u))`. A bounded prior has no bounds there, so that a
//! normal approximation never leaves its support.

use crate::math::functions::exp;
use crate::math::special::{ln_normal_density, normal_cdf};
use crate::random::Distribution;

/// Beyond this the normal distribution function is 0 or 1 to the last bit.
const FARTHEST: f64 = 8.0;

/// The parameter (SI) at a coordinate.
pub fn value(prior: &Distribution, coordinate: f64) -> f64 {
    prior.quantile(normal_cdf(coordinate.clamp(-FARTHEST, FARTHEST)))
}

/// Derivative of the parameter (SI) with respect to the coordinate: `phi(u) / f(x)`; 0 for a fixed prior and where the
/// prior has no density.
pub fn slope(prior: &Distribution, coordinate: f64) -> f64 {
    if prior.is_fixed() {
        return 0.0;
    }
    let u = coordinate.clamp(-FARTHEST, FARTHEST);
    let slope = exp(ln_normal_density(u) - prior.log_density(value(prior, u)));
    if slope.is_finite() { slope } else { 0.0 }
}
