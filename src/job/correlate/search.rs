//! How parameters are changed: one at a time, or all together to the least sum of squares.

use crate::math::cholesky;

/// Values of a parameter that are tried over its range.
const GRID: usize = 33;
/// Steps of a golden section after that: 1/32 of the range by 1e-8.
const SECTIONS: usize = 40;
/// Golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Most changes of one parameter.
const MOST_CHANGES: usize = 60;
/// Share by which a change must lower the root mean square to be made.
const LEAST_GAIN: f64 = 1e-3;
/// Most steps of least squares.
const MOST_STEPS: usize = 200;
/// Share of the sum of squares below which a step of least squares is the last.
const LAST_GAIN: f64 = 1e-13;
/// Distance of differences, as a share of the range.
const DIFFERENCE: f64 = 1e-5;
/// Damping beyond which no step is sought (Marquardt 1963).
const MOST_DAMPING: f64 = 1e12;

/// What is searched.
pub struct Search<'s> {
    /// Between which values each parameter may be changed.
    pub ranges: Vec<[f64; 2]>,
    /// Measured minus predicted at values of the parameters; not finite where there is no prediction.
    pub deviations: &'s dyn Fn(&[f64]) -> Vec<f64>,
    /// Whether deviations keep the criteria.
    pub met: &'s dyn Fn(&[f64]) -> bool,
}

/// A change that was made.
#[derive(Clone, Debug)]
pub struct Step {
    /// The parameter that was changed; `None`: all.
    pub parameter: Option<usize>,
    /// The values after it.
    pub values: Vec<f64>,
    /// The deviations after it.
    pub deviations: Vec<f64>,
}

fn squares(deviations: &[f64]) -> f64 {
    let sum: f64 = deviations.iter().map(|own| own * own).sum();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

impl Search<'_> {
    fn misfit(&self, values: &[f64]) -> f64 {
        squares(&(self.deviations)(values))
    }

    /// The value of one parameter with the least misfit, the others as they are.
    fn along(&self, values: &[f64], place: usize) -> (f64, f64) {
        let [lower, upper] = self.ranges[place];
        let mut own = values.to_vec();
        let mut misfit_at = |value: f64| {
            own[place] = value;
            self.misfit(&own)
        };
        let at = |index: usize| lower + (upper - lower) * index as f64 / (GRID - 1) as f64;
        let grid: Vec<f64> = (0..GRID).map(|index| misfit_at(at(index))).collect();
        let least = (0..GRID).fold(0, |least, index| if grid[index] < grid[least] { index } else { least });
        let (mut from, mut to) = (at(least.saturating_sub(1)), at((least + 1).min(GRID - 1)));
        let (mut left, mut right) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
        let (mut at_left, mut at_right) = (misfit_at(left), misfit_at(right));
        for _ in 0..SECTIONS {
            if at_left < at_right {
                (to, right, at_right) = (right, left, at_left);
                left = to - GOLDEN * (to - from);
                at_left = misfit_at(left);
            } else {
                (from, left, at_left) = (left, right, at_right);
                right = from + GOLDEN * (to - from);
                at_right = misfit_at(right);
            }
        }
        let inner = if at_left < at_right { (left, at_left) } else { (right, at_right) };
        if grid[least] < inner.1 { (at(least), grid[least]) } else { inner }
    }

    /// Changes always that parameter which alone lowers the misfit most, to its best value, until the criteria are met or
    /// no change lowers the root mean square by a thousandth.
    pub fn one_at_a_time(&self, start: &[f64]) -> Vec<Step> {
        let mut steps: Vec<Step> = Vec::new();
        let mut values = start.to_vec();
        let mut misfit = self.misfit(&values);
        for _ in 0..MOST_CHANGES {
            let mut best: Option<(usize, f64, f64)> = None;
            for place in 0..values.len() {
                let (value, own) = self.along(&values, place);
                if best.is_none_or(|(_, _, least)| own < least) {
                    best = Some((place, value, own));
                }
            }
            let Some((place, value, own)) = best else { break };
            if !(own.sqrt() < (1.0 - LEAST_GAIN) * misfit.sqrt()) {
                break;
            }
            values[place] = value;
            misfit = own;
            let deviations = (self.deviations)(&values);
            let is_met = (self.met)(&deviations);
            steps.push(Step { parameter: Some(place), values: values.clone(), deviations });
            if is_met {
                break;
            }
        }
        steps
    }

    /// Derivatives of the deviations with the parameters as shares of their ranges, by differences within the ranges.
    fn jacobian(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let column = |place: usize| {
            let [lower, upper] = self.ranges[place];
            let width = upper - lower;
            let (mut low, mut high) = (values.to_vec(), values.to_vec());
            low[place] = (values[place] - DIFFERENCE * width).max(lower);
            high[place] = (values[place] + DIFFERENCE * width).min(upper);
            let apart = (high[place] - low[place]) / width;
            let (at_low, at_high) = ((self.deviations)(&low), (self.deviations)(&high));
            at_high.iter().zip(&at_low).map(|(high, low)| (high - low) / apart).collect()
        };
        (0..values.len()).map(column).collect()
    }

    /// The least sum of squares within the ranges, by damped Gauss-Newton steps (Levenberg 1944, Marquardt 1963); parameters
    /// at an end of their range that the misfit presses outwards stay there.
    pub fn least_squares(&self, start: &[f64]) -> Vec<Step> {
        let mut steps: Vec<Step> = Vec::new();
        let mut values = start.to_vec();
        let mut deviations = (self.deviations)(&values);
        let mut damping = 1e-3;
        for _ in 0..MOST_STEPS {
            let misfit = squares(&deviations);
            let columns = self.jacobian(&values);
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            // Downhill, as shares of the ranges.
            let downhill: Vec<f64> = columns.iter().map(|column| -dot(column, &deviations)).collect();
            let is_free = |place: &usize| {
                let [lower, upper] = self.ranges[*place];
                !(values[*place] <= lower && downhill[*place] < 0.0
                    || values[*place] >= upper && downhill[*place] > 0.0)
            };
            let free: Vec<usize> = (0..values.len()).filter(is_free).collect();
            let count = free.len();
            let mut accepted = None;
            while count > 0 && damping < MOST_DAMPING {
                let mut normal = vec![0.0; count * count];
                for (i, &a) in free.iter().enumerate() {
                    for (j, &b) in free.iter().enumerate() {
                        normal[i * count + j] = dot(&columns[a], &columns[b]);
                    }
                    normal[i * count + i] *= 1.0 + damping;
                }
                let mut change: Vec<f64> = free.iter().map(|&place| downhill[place]).collect();
                if cholesky::factor(&mut normal, count).is_ok() {
                    cholesky::solve(&normal, &mut change);
                    let mut tried = values.clone();
                    for (&place, change) in free.iter().zip(&change) {
                        let [lower, upper] = self.ranges[place];
                        tried[place] = (values[place] + change * (upper - lower)).clamp(lower, upper);
                    }
                    let own = (self.deviations)(&tried);
                    if squares(&own) < misfit {
                        accepted = Some((tried, own));
                        break;
                    }
                }
                damping *= 10.0;
            }
            let Some((tried, own)) = accepted else { break };
            damping = (damping * 0.1).max(1e-12);
            let gain = misfit - squares(&own);
            (values, deviations) = (tried, own);
            steps.push(Step { parameter: None, values: values.clone(), deviations: deviations.clone() });
            if gain <= LAST_GAIN * misfit {
                break;
            }
        }
        steps
    }
}
