//! A sensor that follows the truth with a time constant: `tau ds/dt = truth - s`, started at the truth; exact for a
//! truth that is linear between rows, and so is its derivative.

use crate::math::functions::exp;

/// Readings of a sensor with time constant `lag_s` (s; 0: none) for the truth at instants `times_s`.
pub fn reading(times_s: &[f64], truth: &[f64], lag_s: f64) -> Vec<f64> {
    let mut readings = truth.to_vec();
    apply(times_s, &mut readings, lag_s, None);
    readings
}

/// Replaces the truth by the readings. `slope`, where given, receives the derivative of the readings with respect to
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
        let ramp = (values[row] - before) / step_s;
        // Solution for a ramp: it runs behind the ramp by ramp x tau, which an initial difference decays to.
        let decay = exp(-step_s / lag_s);
        let behind = values[row - 1] - (before - ramp * lag_s);
        if let Some(slope) = slope.as_deref_mut() {
            slope[row] = -ramp + (slope[row - 1] + ramp) * decay + behind * decay * step_s / (lag_s * lag_s);
        }
        before = values[row];
        values[row] = before - ramp * lag_s + behind * decay;
    }
}
