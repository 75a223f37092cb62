//! Main effects from samples that are there already: the share of a quantity's variance that lies between classes of a
//! parameter (the correlation ratio of Pearson 1905), no new solves.
//!
//! Samples are sorted into M classes of equal probability. The variance between the classes' means holds, beside the main effect,
//! their noise, which is taken off. How large it is depends on the point set: independent points have the variance within a class by its
//! size, evenly spread ones far less. So it is read off the means themselves: of neighbouring classes the second differences of
//! a smooth effect are small, those of noise have six times its variance (Gasser, Sroka & Jennen-Steinmetz 1986). The
//! interval comes from the scatter of the estimate over equal consecutive parts of the sample, wide for evenly spread points.

use super::sobol_indices::Estimate;
use crate::math::sum::CompensatedSum;

/// Parts whose scatter gives the interval.
const PARTS: usize = 8;
/// Most classes.
const MOST_CLASSES: usize = 64;
/// Fewest classes.
const FEWEST_CLASSES: usize = 8;
/// Samples of a class in a part, on average at least.
const SAMPLES_A_CLASS: usize = 16;
/// A standard deviation below this share of the largest magnitude is rounding, not variation.
const ROUNDING: f64 = 1e-10;

/// The estimate of one set of samples; `None` without variation or with too few classes.
fn ratio(probabilities: &[f64], values: &[f64], classes: usize) -> Option<f64> {
    let mut count = vec![0_u64; classes];
    let mut sum = vec![CompensatedSum::default(); classes];
    let pairs = || probabilities.iter().zip(values).filter(|(_, value)| value.is_finite());
    let class_of = |u: f64| ((u * classes as f64) as usize).min(classes - 1);
    let (mut total, mut samples, mut largest) = (CompensatedSum::default(), 0_u64, 0.0_f64);
    for (&u, &value) in pairs() {
        let class = class_of(u);
        count[class] += 1;
        sum[class].add(value);
        total.add(value);
        samples += 1;
        largest = largest.max(value.abs());
    }
    // A class is empty where all of its samples are missing.
    let filled: Vec<usize> = (0..classes).filter(|&class| count[class] > 0).collect();
    if filled.len() < FEWEST_CLASSES {
        return None;
    }
    let mean = total.value() / samples as f64;
    let means: Vec<f64> = filled.iter().map(|&class| sum[class].value() / count[class] as f64).collect();
    let mut all = CompensatedSum::default();
    for (_, &value) in pairs() {
        all.add((value - mean) * (value - mean));
    }
    let variance = all.value() / samples as f64;
    if !(variance.sqrt() > ROUNDING * largest) {
        return None;
    }
    let squares = means.iter().zip(&filled).map(|(m, &class)| count[class] as f64 * (m - mean) * (m - mean));
    let between = squares.sum::<f64>() / samples as f64;
    let differences = means.windows(3).map(|m| m[0] - 2.0 * m[1] + m[2]);
    let noise = differences.map(|d| d * d).sum::<f64>() / (6 * (means.len() - 2)) as f64;
    // Within a class an effect of slope s (a class) has the variance s^2 / 12.
    let slopes = means.windows(3).map(|m| 0.5 * (m[2] - m[0]));
    let within = slopes.map(|slope| slope * slope).sum::<f64>() / (means.len() - 2) as f64 / 12.0;
    let share = (means.len() - 1) as f64 / means.len() as f64;
    Some((between - share * noise + within - noise / 24.0) / variance)
}

/// Main effect of a parameter on a quantity from samples: `probabilities` holds the share of the parameter's prior below
/// each sample, `values` the quantity (not finite where it is missing). `None` where the quantity does not vary, or with too few
/// samples.
///
/// What a class flattens is made up for by the slope between its neighbours.
pub fn main_effect(probabilities: &[f64], values: &[f64]) -> Option<Estimate> {
    let part = values.len() / PARTS;
    let classes = MOST_CLASSES.min(part / SAMPLES_A_CLASS);
    if classes < FEWEST_CLASSES {
        return None;
    }
    let value = ratio(probabilities, values, classes)?;
    let parts: Option<Vec<f64>> = (0..PARTS)
        .map(|i| ratio(&probabilities[i * part..(i + 1) * part], &values[i * part..(i + 1) * part], classes))
        .collect();
    let reach = 0.5 * Estimate::of(&parts?).width();
    Some(Estimate { value, lower: value - reach, upper: value + reach })
}
