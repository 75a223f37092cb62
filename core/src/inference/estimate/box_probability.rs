//! Probability of a box under a multivariate normal density, by separation of variables (Genz 1992) over Richtmyer's
//! points, in a fixed order, until doubling their number changes little: the same box always gets the same answer.

use crate::math::cholesky;
use crate::math::functions::ln;
use crate::math::special::{normal_cdf, normal_quantile};

/// Most points of the rule; the relative error of a probability is then of order 1e-3 in a few dimensions.
const POINTS: u32 = 4096;
/// Points after which it is first looked at.
const LEAST_POINTS: u32 = 256;
/// Relative change by twice the points that is little.
const LITTLE: f64 = 3e-4;

/// Natural logarithm of the probability that a normal vector of mean zero and this covariance (n x n) lies between
/// bounds (infinite where there are none). `None` where the covariance is not positive definite.
pub fn log_box_probability(covariance: &[f64], lower: &[f64], upper: &[f64]) -> Option<f64> {
    // A variable whose bounds are eight deviations away changes nothing in double precision.
    const FAR: f64 = 8.0;
    let n = lower.len();
    let near: Vec<usize> = (0..n)
        .filter(|&i| {
            let sd = covariance[i * n + i].sqrt();
            !(lower[i] <= -FAR * sd && upper[i] >= FAR * sd)
        })
        .collect();
    let k = near.len();
    let mut factor: Vec<f64> = near.iter().flat_map(|&i| near.iter().map(move |&j| covariance[i * n + j])).collect();
    cholesky::factor(&mut factor, k).ok()?;
    if k == 0 {
        return Some(0.0);
    }
    let steps: Vec<f64> = richtmyer_steps(k);
    let mut sum = 0.0;
    let mut drawn = vec![0.0; k];
    let points = if k == 1 { 1 } else { POINTS };
    let mut before = f64::NAN;
    for point in 0..points {
        if point >= LEAST_POINTS && point.is_power_of_two() {
            let now = sum / f64::from(point);
            if (now - before).abs() <= LITTLE * now {
                return Some(ln(now));
            }
            before = now;
        }
        let mut product = 1.0;
        for i in 0..k {
            let conditional_mean: f64 = (0..i).map(|j| factor[i * k + j] * drawn[j]).sum();
            let sd = factor[i * k + i];
            let (a, b) = ((lower[near[i]] - conditional_mean) / sd, (upper[near[i]] - conditional_mean) / sd);
            // Above the mean the complements keep the digits.
            let mirrored = a > 0.0;
            let (a, b) = if mirrored { (-b, -a) } else { (a, b) };
            let (below, above) = (normal_cdf(a), normal_cdf(b));
            product *= above - below;
            if i + 1 < k {
                let u = folded(point, steps[i]);
                let z = normal_quantile((below + u * (above - below)).clamp(1e-300, 1.0 - 1e-16));
                drawn[i] = if mirrored { -z } else { z };
            }
        }
        sum += product;
    }
    Some(ln(sum / f64::from(points)))
}

/// Richtmyer's point of a number along one variable, folded (Genz & Bretz 2009), which makes the integrand periodic.
pub(super) fn folded(point: u32, step: f64) -> f64 {
    let fraction = ((f64::from(point) + 1.0) * step).fract();
    (2.0 * fraction - 1.0).abs()
}

/// Fractions of the roots of the first primes.
pub(super) fn richtmyer_steps(count: usize) -> Vec<f64> {
    let mut steps = Vec::with_capacity(count);
    let mut candidate: u32 = 2;
    while steps.len() < count {
        if (2..candidate).take_while(|d| d * d <= candidate).all(|d| !candidate.is_multiple_of(d)) {
            steps.push(f64::from(candidate).sqrt().fract());
        }
        candidate += 1;
    }
    steps
}
