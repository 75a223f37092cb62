//! A sensor that follows the truth with a time constant: `tau ds/dt = truth - s`, started at the truth; exact for a
//! truth that is linear between rows, and so is its derivative.

use crate::math::functions::exp;

/// Replaces the truth at instants `times_s` by the readings of a sensor with time constant `lag_s` (s; 0: none). `slope`, where given, receives the derivative of the readings with respect to
/// the time constant (SI unit of the reading a second). The map is linear in the truth, so that derivatives of the truth
/// pass through it in the same way.
pub fn apply(times_s: &[f64], values: &mut [f64], lag_s: f64, mut slope: Option<&mut [f64]>) {
    if let Some(slope) = slope.as_deref_mut() {
        slope.fill(0.0);
    }
    if lag_s <= 0.0 || values.is_empty() {
        return;
    }
    let mut before = values[0];
    for row in 1..values.len() {
        let step_s = times_s[row] - times_s[row - 1];
        let step = Step::new(step_s, lag_s, [before, values[row]], values[row - 1]);
        if let Some(slope) = slope.as_deref_mut() {
            let Step { ramp, decay, behind } = step;
            slope[row] = -ramp + (slope[row - 1] + ramp) * decay + behind * decay * step_s / (lag_s * lag_s);
        }
        before = values[row];
        values[row] = step.reading(before, lag_s);
    }
}

/// The reading at the end of a step in which the truth goes from the first value to the second, from the reading at its start.
pub fn after_step(step_s: f64, lag_s: f64, truth: [f64; 2], reading: f64) -> f64 {
    if lag_s <= 0.0 { truth[1] } else { Step::new(step_s, lag_s, truth, reading).reading(truth[1], lag_s) }
}

/// Solution for a ramp: the reading runs behind it by ramp x tau, which an initial difference decays to.
struct Step {
    ramp: f64,
    decay: f64,
    behind: f64,
}

impl Step {
    fn new(step_s: f64, lag_s: f64, [before, after]: [f64; 2], reading: f64) -> Self {
        let ramp = (after - before) / step_s;
        Self { ramp, decay: exp(-step_s / lag_s), behind: reading - (before - ramp * lag_s) }
    }

    fn reading(&self, truth: f64, lag_s: f64) -> f64 {
        truth - self.ramp * lag_s + self.behind * self.decay
    }
}
