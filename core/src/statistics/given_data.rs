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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{PointKind, Points, StreamKey};

    /// Main effects of the Ishigami function from so many points.
    fn effects(kind: PointKind, samples: usize, seed: u64) -> Vec<Estimate> {
        let points = Points::new(kind, StreamKey::new(seed, "t", "t"), samples, 3).expect("points");
        let mut rows = vec![0.0; 3 * samples];
        points.fill_rows(0, &mut rows);
        let angle = |u: f64| std::f64::consts::PI * (2.0 * u - 1.0);
        let sin = crate::math::functions::sin;
        let values: Vec<f64> = rows
            .chunks(3)
            .map(|u| {
                let (x, y, z) = (angle(u[0]), sin(angle(u[1])), angle(u[2]));
                sin(x) + 7.0 * y * y + 0.1 * z * z * z * z * sin(x)
            })
            .collect();
        let column = |j: usize| -> Vec<f64> { rows.iter().skip(j).step_by(3).copied().collect() };
        (0..3).map(|j| main_effect(&column(j), &values).expect("varies")).collect()
    }

    #[test]
    fn the_intervals_hold_the_exact_main_effects() {
        // Intervals of 95 % over 40 seeds and three effects; 120 intervals of which 105 hold with a probability above 0.999
        // (binomial) if they cover 95 %.
        let exact = [0.313_905_191_1, 0.442_411_144_8, 0.0];
        for kind in [PointKind::MonteCarlo, PointKind::Sobol] {
            let mut held = 0;
            for seed in 0..40 {
                for (estimate, exact) in effects(kind, 4096, seed).iter().zip(exact) {
                    held += u32::from(estimate.lower <= exact && exact <= estimate.upper);
                    assert!((estimate.value - exact).abs() < 0.06, "{estimate:?}");
                }
            }
            assert!(held >= 105, "{kind:?}: {held} of 120");
        }
    }

    #[test]
    fn the_noise_of_the_classes_is_taken_off() {
        // The third coordinate alone has no effect; uncorrected it would have 31 / 4096 = 0.008.
        let mean = (0..20).map(|seed| effects(PointKind::MonteCarlo, 4096, seed)[2].value).sum::<f64>() / 20.0;
        assert!(mean.abs() < 0.002, "{mean}");
    }

    #[test]
    fn too_few_samples_and_constants_have_no_effect() {
        assert_eq!(main_effect(&[0.5; 100], &[1.0; 100]), None);
        let u: Vec<f64> = (0..1024).map(|i| (f64::from(i) + 0.5) / 1024.0).collect();
        assert_eq!(main_effect(&u, &[300.0; 1024]), None);
        let missing: Vec<f64> = u.iter().map(|&u| if u < 0.1 { f64::NAN } else { 2.0 * u }).collect();
        // A quantity that is missing somewhere still follows its parameter.
        let shuffled = |values: &[f64]| (0..1024).map(|i| values[i * 389 % 1024]).collect::<Vec<f64>>();
        assert!(main_effect(&shuffled(&u), &shuffled(&missing)).expect("varies").value > 0.99);
    }
}
