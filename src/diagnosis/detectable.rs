//! What would have been seen: the amplitude of each direction that the family's test finds with a given power.
//!
//! A direction is found where its statistic exceeds the critical value `c` of the family, which is that of a member's own
//! probability ([`Family::critical`]). The score of the amplitude `a` is normal about `a |g~|` with standard deviation 1, so
//! that `a = (c + 1.2816) / |g~|` is found nine times in ten (for two-sided tests the far tail is left out: it adds less than
//! 1e-6). Bounds of parameters that come into play lower the power. Of several columns, amplitudes are drawn from normal
//! distributions with `a` times the plausible sizes: the weights of the squares become `w (1 + a^2 l)`.

use super::Direction;
use super::family::Family;
use super::null_maximum::Sampling;
use super::score::{Prepared, Side};
use super::several::Projected;
use crate::math::functions::{exp, ln};
use crate::math::special::{normal_quantile, student_t_quantile, weighted_chi_square_sf, weighted_chi_square_upper};

/// What each direction would have to be to be found.
#[derive(Clone, Debug, PartialEq)]
pub struct Detectable {
    /// The level of the family.
    pub level: f64,
    /// The probability of a member below which the family finds something.
    pub critical_p: f64,
    /// By direction: the amplitude, SI (of several columns: in plausible sizes). `None` where no plausible one is seen.
    pub amplitudes: Vec<Option<f64>>,
}

/// The amplitudes detectable at a level with a power (0.9, say).
pub fn detectable(
    prepared: &Prepared,
    directions: &[Direction],
    family: &Family,
    level: f64,
    power: f64,
    sampling: &Sampling,
    degrees: Option<f64>,
) -> Detectable {
    let critical_p = family.critical(level, sampling);
    let amplitudes =
        directions.iter().map(|direction| amplitude(prepared, direction, critical_p, power, degrees)).collect();
    Detectable { level, critical_p, amplitudes }
}

/// The amplitude of one direction at a member's critical probability.
pub fn amplitude(
    prepared: &Prepared,
    direction: &Direction,
    critical_p: f64,
    power: f64,
    degrees: Option<f64>,
) -> Option<f64> {
    let quantile = |p: f64| match degrees {
        None => -normal_quantile(p),
        Some(d) => -student_t_quantile(p, d),
    };
    match prepared.projected(direction) {
        Projected::Unseen => None,
        Projected::Single { norm, side, .. } => {
            let c = quantile(if side == Side::Two { 0.5 * critical_p } else { critical_p });
            Some((c + normal_quantile(power)) / norm)
        }
        Projected::Several { weights, eigenvalues, .. } => {
            let c = weighted_chi_square_upper(critical_p, &weights, degrees);
            let found = |ln_a: f64| {
                let square = exp(2.0 * ln_a);
                let now: Vec<f64> = weights.iter().zip(&eigenvalues).map(|(w, l)| w * (1.0 + square * l)).collect();
                weighted_chi_square_sf(c, &now, degrees) >= power
            };
            // From a thousandth of the plausible size to a million times it.
            let (mut lower, mut upper) = (ln(1e-3), ln(1e6));
            if !found(upper) {
                return None;
            }
            for _ in 0..40 {
                let middle = 0.5 * (lower + upper);
                if found(middle) { upper = middle } else { lower = middle }
            }
            Some(exp(upper))
        }
    }
}
