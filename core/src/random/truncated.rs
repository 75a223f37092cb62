//! A normal distribution between two bounds, accurate however far in a tail they lie.

use crate::math::functions::{exp, exp_m1, ln};
use crate::math::quadrature::gauss_legendre;
use crate::math::special::{ln_normal_cdf, normal_cdf, normal_quantile, normal_quantile_of_ln};

/// Below this logarithm of a probability the work is done in logarithms.
const SMALLEST_LN: f64 = -600.0;

/// A normal distribution cut at bounds that are given in standard deviations from the mean (either may be infinite).
#[derive(Clone, Copy, Debug)]
pub(super) struct TruncatedNormal {
    /// Mean before the cut.
    pub mean: f64,
    /// Standard deviation before the cut.
    pub sd: f64,
    /// Lower bound, standardised.
    pub lower: f64,
    /// Upper bound, standardised.
    pub upper: f64,
}

impl TruncatedNormal {
    /// Whether more of the range is above the mean, so that the mirror image is the more accurate one.
    fn mirrored(&self) -> bool {
        self.lower + self.upper > 0.0
    }

    /// Bounds in the half where probabilities are small.
    fn small_side(&self) -> (f64, f64) {
        if self.mirrored() { (-self.upper, -self.lower) } else { (self.lower, self.upper) }
    }

    pub fn quantile(&self, u: f64) -> f64 {
        let mirrored = self.mirrored();
        let (a, b) = self.small_side();
        let (at_a, at_b) = if mirrored { (u, 1.0 - u) } else { (1.0 - u, u) };
        let top = ln_normal_cdf(b);
        let z = if top > SMALLEST_LN {
            normal_quantile(at_a * normal_cdf(a) + at_b * normal_cdf(b))
        } else {
            normal_quantile_of_ln(top + ln(at_b + at_a * exp(ln_normal_cdf(a) - top)))
        };
        let z = z.max(a).min(b);
        self.mean + self.sd * if mirrored { -z } else { z }
    }

    pub fn cdf(&self, x: f64) -> f64 {
        let (a, b) = self.small_side();
        let mirrored = self.mirrored();
        let z = (x - self.mean) / self.sd;
        let z = if mirrored { -z } else { z };
        let (at_a, at_z, at_b) = (ln_normal_cdf(a), ln_normal_cdf(z), ln_normal_cdf(b));
        let below = if a == f64::NEG_INFINITY {
            exp(at_z - at_b)
        } else {
            exp_m1(at_a - at_z) / exp_m1(at_a - at_b) * exp(at_z - at_b)
        };
        if mirrored { 1.0 - below } else { below }
    }

    /// Mean and standard deviation by quadrature about the densest point: the closed forms cancel in the tails.
    pub fn mean_and_sd(&self) -> (f64, f64) {
        const PANELS: u32 = 16;
        let densest = 0.0_f64.max(self.lower).min(self.upper);
        // Where the density has fallen by e^-40 beside its largest value.
        let reach = (densest * densest + 80.0).sqrt();
        let (start, end) = (self.lower.max(-reach) - densest, self.upper.min(reach) - densest);
        // The side towards the mean falls at least as fast as exp(-|densest| t).
        let step = (end - start) / f64::from(PANELS);
        let rule = gauss_legendre(16);
        let moment = |power: u32, centre: f64| {
            let mut total = 0.0;
            for panel in 0..PANELS {
                let from = start + step * f64::from(panel);
                total += rule.integrate(from, from + step, |t| {
                    let weight = exp(-t * (densest + 0.5 * t));
                    match power {
                        0 => weight,
                        1 => weight * t,
                        _ => weight * (t - centre) * (t - centre),
                    }
                });
            }
            total
        };
        let mass = moment(0, 0.0);
        let centre = moment(1, 0.0) / mass;
        let variance = moment(2, centre) / mass;
        (self.mean + self.sd * (densest + centre), self.sd * variance.sqrt())
    }
}
