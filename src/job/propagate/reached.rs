//! Where, along a swept design variable, a probability reaches what is required.

use super::output::{Met, Probability, Reached};
use crate::math::special::normal_quantile;

/// A probability's place on the probit scale, on which it is nearly straight along a design variable. Kept off 0 and
/// 1 by half a sample.
fn probit(probability: f64, samples: u64) -> f64 {
    let half = 0.5 / samples.max(1) as f64;
    normal_quantile(probability.clamp(half, 1.0 - half))
}

/// The design value from which on, towards the sweep's end, the probability stays at or above `required`, by straight
/// lines on the probit scale between the swept values (rising or falling, with their probabilities): the smallest one in a
/// rising sweep, the largest in a falling. `None` where the sweep's end does not reach it.
pub fn crossing(points: &[(f64, f64)], required: f64, samples: u64) -> Option<f64> {
    let below = points.iter().rposition(|&(_, p)| p < required);
    match below {
        None => points.first().map(|&(x, _)| x),
        Some(index) if index + 1 == points.len() => None,
        Some(index) => {
            let ((x0, p0), (x1, p1)) = (points[index], points[index + 1]);
            let (z0, z1, z) = (probit(p0, samples), probit(p1, samples), probit(required, samples));
            let at = x0 + (x1 - x0) * (z - z0) / (z1 - z0);
            if z1 > z0 { Some(at.clamp(x0.min(x1), x0.max(x1))) } else { Some(x1) }
        }
    }
}

/// The design value at which one requirement reaches its probability, with the interval that the probabilities'
/// intervals give. `sweep` holds the design values in their order with that requirement's outcome.
pub fn reached(environment: &str, sweep: &[(f64, &Met)], samples: u64) -> Option<Reached> {
    let (_, first) = sweep.first()?;
    let at = |pick: fn(&Probability) -> f64| -> Option<f64> {
        let points: Vec<(f64, f64)> = sweep.iter().map(|(x, met)| (*x, pick(&met.probability))).collect();
        crossing(&points, first.required, samples)
    };
    let (early, late) = (at(|p| p.upper), at(|p| p.lower));
    Some(Reached {
        environment: environment.to_owned(),
        requirement: first.requirement.clone(),
        probability: first.required,
        design_value: at(|p| p.value),
        interval: early.zip(late).map(|(a, b)| [a.min(b), a.max(b)]),
    })
}
