//! Means and standard deviations of the normal approximation of a density between bounds.
//!
//! About the largest value in the box the density is taken as `exp(-g'd - d'Hd / 2)`, `d` the step from there, cut at the bounds. A
//! variable that is held at a bound still spreads from it by what its gradient allows, and takes along the others that trade for it; so
//! the covariance of the free part alone says too little of them. The moments are taken by importance sampling on Richtmyer's points, in
//! a fixed order and number. Variables that a steep gradient holds (their steps are small, and so is what couples them) are drawn each
//! from its own density along the ray on which the others follow; the rest is normal about the point where its gradient vanishes,
//! and those of it that a bound may cut are drawn by separation of variables (Genz 1992). The points are weighed by what this leaves
//! out. Variables that no bound reaches follow by regression, exactly. Without bounds near, the moments are the point and the
//! covariance of the normal approximation.

use serde::{Deserialize, Serialize};

use crate::inference::estimate::box_probability::{folded, richtmyer_steps};
use crate::inference::estimate::laplace;
use crate::inference::estimate::optimise::Bounds;
use crate::math::cholesky;
use crate::math::functions::{exp, ln_1p};
use crate::math::sort::sort_by;
use crate::math::special::{ln_normal_interval, normal_cdf, normal_quantile};

/// A gradient holds a variable where it is more than so many times the root of the curvature.
const STEEP: f64 = 4.0;
/// Points of the rule; moments are then right to one to three hundredths of the standard deviation.
const POINTS: u32 = 1024;
/// A bound this many standard deviations away cuts nothing.
const FAR: f64 = 8.0;
/// Fewest points that the weights may be worth.
const LEAST_POINTS: f64 = 20.0;

/// Mean and standard deviation of each variable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// Means.
    pub mean: Vec<f64>,
    /// Standard deviations.
    pub sd: Vec<f64>,
}

/// One variable held at a bound: its step from there is drawn from `exp(-gradient t - curvature t^2 / 2)` on 0 to `width`.
struct Held {
    /// 1 at a lower bound, -1 at an upper one.
    inwards: f64,
    gradient: f64,
    curvature: f64,
    width: f64,
}

impl Held {
    /// The step below which a share `u` lies.
    fn quantile(&self, u: f64) -> f64 {
        // So steep that the curvature changes nothing (relative 1 / 1800), or none.
        const ALONE: f64 = 30.0;
        let root = self.curvature.sqrt();
        if self.gradient >= ALONE * root {
            let share = 1.0 - exp(-self.gradient * self.width);
            return if share < 1e-8 { u * self.width } else { -ln_1p(-u * share) / self.gradient };
        }
        let start = self.gradient / root;
        // In the lower tail, where probabilities keep their digits.
        let (below, above) = (normal_cdf(-start - self.width * root), normal_cdf(-start));
        ((-normal_quantile((above - u * (above - below)).max(1e-300)) - start) / root).clamp(0.0, self.width)
    }

    /// A step that is hardly exceeded.
    fn reach(&self) -> f64 {
        self.width.min(9.0 / self.gradient.max(f64::MIN_POSITIVE)).min(5.0 / self.curvature.sqrt())
    }
}

/// The variables, those that a steep gradient holds apart from the rest.
struct Parts {
    held: Vec<usize>,
    rest: Vec<usize>,
    /// Of the rest, row by row.
    covariance: Vec<f64>,
    /// How the rest follows a step of each held one, rest x held.
    follow: Vec<f64>,
    rays: Vec<Held>,
    /// Curvature left along pairs of steps, held x held.
    cross: Vec<f64>,
}

impl Parts {
    fn of(at: &[f64], gradient: &[f64], bounds: &Bounds, curvature: &[f64], free: &[usize]) -> Option<Self> {
        let n = at.len();
        let all_held: Vec<usize> = (0..n).filter(|i| !free.contains(i)).collect();
        let apart = Self::with(at, gradient, bounds, curvature, all_held)?;
        let is_steep = |ray: &Held| ray.gradient > STEEP * ray.curvature.sqrt();
        let steep = apart.held.iter().zip(&apart.rays).filter(|(_, ray)| is_steep(ray));
        let held: Vec<usize> = steep.map(|(&i, _)| i).collect();
        if held.len() == apart.held.len() {
            return Some(apart);
        }
        Self::with(at, gradient, bounds, curvature, held)
    }

    fn with(at: &[f64], gradient: &[f64], bounds: &Bounds, curvature: &[f64], held: Vec<usize>) -> Option<Self> {
        let n = at.len();
        let rest: Vec<usize> = (0..n).filter(|i| !held.contains(i)).collect();
        let (k, m) = (rest.len(), held.len());
        let covariance = cholesky::inverse(&laplace::factor(at, bounds, curvature, &rest)?, k);
        let follow: Vec<f64> = (0..k * m)
            .map(|place| {
                let pull = |j: usize| covariance[place / m * k + j] * curvature[rest[j] * n + held[place % m]];
                -(0..k).map(pull).sum::<f64>()
            })
            .collect();
        let left = |a: usize, b: usize| {
            let coupled: f64 = (0..k).map(|j| curvature[held[a] * n + rest[j]] * follow[j * m + b]).sum();
            curvature[held[a] * n + held[b]] + coupled
        };
        let rays: Vec<Held> = (0..m)
            .map(|a| Held {
                inwards: if at[held[a]] <= bounds.lower[held[a]] { 1.0 } else { -1.0 },
                gradient: gradient[held[a]].abs(),
                curvature: left(a, a).max(0.0),
                width: bounds.upper[held[a]] - bounds.lower[held[a]],
            })
            .collect();
        let cross = (0..m * m)
            .map(|place| left(place / m, place % m) * rays[place / m].inwards * rays[place % m].inwards)
            .collect();
        Some(Self { held, rest, covariance, follow, rays, cross })
    }
}

/// Moments of the density whose negative logarithm has this gradient and curvature (n x n) at a point where the variables that are not
/// `free` stand at a bound. `None` where the curvature is negative or nothing limits a variable, or where the points are too few.
///
/// Cost: n^3, and points x n^2 where bounds are near.
pub fn moments(at: &[f64], gradient: &[f64], bounds: &Bounds, curvature: &[f64], free: &[usize]) -> Option<Moments> {
    let n = at.len();
    let parts = Parts::of(at, gradient, bounds, curvature, free)?;
    let Parts { held, rest, covariance, follow, rays, cross } = &parts;
    let (k, m) = (rest.len(), held.len());
    // Where the gradient of the rest vanishes; that of free variables does at the point.
    let slope: Vec<f64> = rest.iter().map(|&i| if free.contains(&i) { 0.0 } else { gradient[i] }).collect();
    let centre: Vec<f64> =
        (0..k).map(|i| at[rest[i]] - (0..k).map(|j| covariance[i * k + j] * slope[j]).sum::<f64>()).collect();
    if rays.iter().any(|ray| ray.reach().is_infinite()) {
        return None;
    }
    let sd: Vec<f64> = (0..k).map(|i| covariance[i * k + i].max(0.0).sqrt()).collect();
    let room = |i: usize| (bounds.lower[rest[i]] - centre[i], bounds.upper[rest[i]] - centre[i]);
    let mut near: Vec<usize> = (0..k)
        .filter(|&i| {
            let moved: f64 = rays.iter().enumerate().map(|(a, ray)| (follow[i * m + a] * ray.reach()).abs()).sum();
            let (lower, upper) = room(i);
            lower > -FAR * sd[i] - moved || upper < FAR * sd[i] + moved
        })
        .collect();
    if m + near.len() == 0 {
        return Some(Moments { mean: at.to_vec(), sd });
    }
    // What is cut most is drawn first, which leaves the least to the weights (Gibson, Glasbey & Elston 1994).
    let share = |i: usize| ln_normal_interval(room(i).0 / sd[i], room(i).1 / sd[i]);
    sort_by(&mut near, |&a, &b| share(a).total_cmp(&share(b)).then(a.cmp(&b)));
    let c = near.len();
    let mut factor: Vec<f64> =
        near.iter().flat_map(|&i| near.iter().map(move |&j| (i, j))).map(|(i, j)| covariance[i * k + j]).collect();
    cholesky::factor(&mut factor, c).ok()?;

    // First and second moments of (steps of the held, deviations of the near from where they follow to).
    let size = m + c;
    let (mut sum, mut squares, mut first, mut second) = (0.0, 0.0, vec![0.0; size], vec![0.0; size * size]);
    let mut drawn = vec![0.0; size];
    let mut standard = vec![0.0; c];
    let steps = richtmyer_steps(size);
    for point in 0..POINTS {
        let mut weight = 1.0;
        for (a, ray) in rays.iter().enumerate() {
            drawn[a] = ray.quantile(folded(point, steps[a]));
        }
        for a in 0..m {
            for b in 0..a {
                weight *= exp(-cross[a * m + b] * drawn[a] * drawn[b]);
            }
        }
        for (place, &i) in near.iter().enumerate() {
            let followed: f64 = (0..m).map(|a| follow[i * m + a] * rays[a].inwards * drawn[a]).sum();
            let conditional_mean: f64 = (0..place).map(|j| factor[place * c + j] * standard[j]).sum();
            let conditional_sd = factor[place * c + place];
            let (lower, upper) = room(i);
            let (a, b) = (
                (lower - followed - conditional_mean) / conditional_sd,
                (upper - followed - conditional_mean) / conditional_sd,
            );
            let mirrored = a > 0.0;
            let (a, b) = if mirrored { (-b, -a) } else { (a, b) };
            let (below, above) = (normal_cdf(a), normal_cdf(b));
            weight *= above - below;
            let u = folded(point, steps[m + place]);
            let z = normal_quantile((below + u * (above - below)).clamp(1e-300, 1.0 - 1e-16));
            standard[place] = if mirrored { -z } else { z };
            drawn[m + place] = conditional_mean + conditional_sd * standard[place];
        }
        if !weight.is_finite() {
            return None;
        }
        sum += weight;
        squares += weight * weight;
        for a in 0..size {
            first[a] += weight * drawn[a];
            for b in 0..=a {
                second[a * size + b] += weight * drawn[a] * drawn[b];
            }
        }
    }
    if !(sum > 0.0 && sum * sum >= LEAST_POINTS * squares) {
        return None;
    }
    let mean: Vec<f64> = first.iter().map(|v| v / sum).collect();
    let spread = |a: usize, b: usize| second[a.max(b) * size + a.min(b)] / sum - mean[a] * mean[b];
    let mut moments = Moments { mean: at.to_vec(), sd: vec![0.0; n] };
    for (&i, centre) in rest.iter().zip(&centre) {
        moments.mean[i] = *centre;
    }
    for (a, &i) in held.iter().enumerate() {
        moments.mean[i] += rays[a].inwards * mean[a];
        moments.sd[i] = spread(a, a).max(0.0).sqrt();
    }
    let mut onto = vec![0.0; size];
    for i in 0..k {
        for (a, ray) in rays.iter().enumerate() {
            onto[a] = follow[i * m + a] * ray.inwards;
        }
        // Regression on the near ones; of those themselves it is the identity.
        let mut regression: Vec<f64> = near.iter().map(|&j| covariance[i * k + j]).collect();
        cholesky::solve_lower(&factor, &mut regression);
        let explained: f64 = regression.iter().map(|v| v * v).sum();
        cholesky::solve_lower_transposed(&factor, &mut regression);
        onto[m..].copy_from_slice(&regression);
        let remaining_variance = if near.contains(&i) { 0.0 } else { (covariance[i * k + i] - explained).max(0.0) };
        let carried: f64 = (0..size).map(|a| (0..size).map(|b| onto[a] * spread(a, b) * onto[b]).sum::<f64>()).sum();
        moments.mean[rest[i]] += onto.iter().zip(&mean).map(|(o, v)| o * v).sum::<f64>();
        moments.sd[rest[i]] = (remaining_variance + carried).max(0.0).sqrt();
    }
    let finite = moments.mean.iter().chain(&moments.sd).all(|v| v.is_finite());
    finite.then_some(moments)
}
