//! Minimum of a smooth function between bounds: quasi-Newton steps with the update of Broyden, Fletcher, Goldfarb and Shanno
//! (Nocedal & Wright 2006, eq. 6.17), projected on the bounds; variables that the slope holds at a bound rest there.

/// Longest step in each variable.
const LONGEST: f64 = 3.0;
/// Share of the predicted decrease that a step must bring (Armijo).
const LEAST_SHARE: f64 = 1e-4;
/// Halvings of a step.
const HALVINGS: u32 = 25;

/// Where a descent ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Descended {
    /// The point.
    pub x: Vec<f64>,
    /// The function there.
    pub value: f64,
    /// Its slopes there.
    pub gradient: Vec<f64>,
    /// Inverse of its curvature as learned on the way (n x n).
    pub curvature: Vec<f64>,
    /// Evaluations of the function with its slopes.
    pub evaluations: u64,
}

/// Descends from a start (moved into the bounds) until what is predicted to be gained is below `least_gain`. `curvature` is a
/// first guess of the inverse curvature. `function` writes the slopes and gives the value, `None` where there is none.
/// `None` where the start has no value.
pub fn descend(
    mut function: impl FnMut(&[f64], &mut [f64]) -> Option<f64>,
    start: &[f64],
    bounds: &[[f64; 2]],
    curvature: Option<&[f64]>,
    least_gain: f64,
    most_evaluations: u64,
) -> Option<Descended> {
    let n = start.len();
    let mut x: Vec<f64> = start.iter().zip(bounds).map(|(x, [lower, upper])| x.max(*lower).min(*upper)).collect();
    let mut gradient = vec![0.0; n];
    let mut value = function(&x, &mut gradient)?;
    let mut evaluations = 1;
    let identity = |scale: f64| -> Vec<f64> { (0..n * n).map(|k| if k / n == k % n { scale } else { 0.0 }).collect() };
    let steepest = |gradient: &[f64]| {
        let size = gradient.iter().fold(0.0, |most: f64, g| most.max(g.abs()));
        identity(if size > 0.0 { 0.5 / size } else { 1.0 })
    };
    let mut inverse = curvature.map_or_else(|| steepest(&gradient), <[f64]>::to_vec);
    let mut is_fresh = curvature.is_none();
    while evaluations < most_evaluations {
        let held =
            |i: usize| (x[i] <= bounds[i][0] && gradient[i] > 0.0) || (x[i] >= bounds[i][1] && gradient[i] < 0.0);
        let free: Vec<usize> = (0..n).filter(|&i| !held(i)).collect();
        let mut direction = vec![0.0; n];
        for &i in &free {
            direction[i] = -free.iter().map(|&j| inverse[i * n + j] * gradient[j]).sum::<f64>();
        }
        let slope: f64 = direction.iter().zip(&gradient).map(|(d, g)| d * g).sum();
        if !(slope < 0.0) {
            if is_fresh {
                break;
            }
            (inverse, is_fresh) = (steepest(&gradient), true);
            continue;
        }
        let longest = direction.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        if longest > LONGEST {
            direction.iter_mut().for_each(|d| *d *= LONGEST / longest);
        }
        let mut share = 1.0;
        let mut accepted = None;
        for _ in 0..HALVINGS {
            let trial: Vec<f64> =
                (0..n).map(|i| (x[i] + share * direction[i]).max(bounds[i][0]).min(bounds[i][1])).collect();
            let predicted: f64 = trial.iter().zip(&x).zip(&gradient).map(|((t, x), g)| (t - x) * g).sum();
            if -predicted < least_gain || evaluations >= most_evaluations {
                break;
            }
            let mut slopes = vec![0.0; n];
            evaluations += 1;
            let found = function(&trial, &mut slopes);
            if let Some(found) = found.filter(|found| *found <= value + LEAST_SHARE * predicted) {
                accepted = Some((trial, found, slopes));
                break;
            }
            // The minimum of the parabola through what is known of the line, kept from the ends.
            share *= match found {
                Some(found) => (0.5 * -predicted / (found - value - predicted)).clamp(0.1, 0.5),
                None => 0.25,
            };
        }
        let Some((trial, found, slopes)) = accepted else {
            if is_fresh {
                break;
            }
            (inverse, is_fresh) = (steepest(&gradient), true);
            continue;
        };
        let step: Vec<f64> = trial.iter().zip(&x).map(|(t, x)| t - x).collect();
        let turned: Vec<f64> = slopes.iter().zip(&gradient).map(|(after, before)| after - before).collect();
        let gained = value - found;
        (x, value, gradient) = (trial, found, slopes);
        if learn(&mut inverse, &step, &turned, is_fresh) {
            is_fresh = false;
        }
        if gained < least_gain && !is_fresh {
            let predicted: f64 = (0..n).map(|i| inverse[i * n + i] * gradient[i] * gradient[i]).sum();
            if predicted < least_gain {
                break;
            }
        }
    }
    Some(Descended { x, value, gradient, curvature: inverse, evaluations })
}

/// Learns the inverse curvature from a step; whether the step shows any.
fn learn(inverse: &mut [f64], step: &[f64], turned: &[f64], is_fresh: bool) -> bool {
    let n = step.len();
    let along: f64 = step.iter().zip(turned).map(|(s, y)| s * y).sum();
    let size: f64 = turned.iter().map(|y| y * y).sum();
    let length: f64 = step.iter().map(|s| s * s).sum();
    if !(along > 1e-10 * (size * length).sqrt()) {
        return false;
    }
    if is_fresh {
        // Nocedal & Wright, eq. 6.20: the scale of the curvature before the first update.
        for k in 0..n * n {
            inverse[k] = if k / n == k % n { along / size } else { 0.0 };
        }
    }
    let product: Vec<f64> = (0..n).map(|i| (0..n).map(|j| inverse[i * n + j] * turned[j]).sum()).collect();
    let curvature_change: f64 = turned.iter().zip(&product).map(|(y, p)| y * p).sum();
    for i in 0..n {
        for j in 0..n {
            inverse[i * n + j] += (1.0 + curvature_change / along) * step[i] * step[j] / along
                - (product[i] * step[j] + step[i] * product[j]) / along;
        }
    }
    true
}
