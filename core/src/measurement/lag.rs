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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lagging_sensor_follows_a_ramp_one_time_constant_behind() {
        let times: Vec<f64> = (0..200).map(f64::from).collect();
        let truth: Vec<f64> = times.iter().map(|t| 0.5 * t).collect();
        let read = reading(&times, &truth, 14.0);
        // s(t) = a (t - tau) + a tau exp(-t / tau), the closed form.
        for (t, s) in times.iter().zip(&read) {
            let expected = 0.5 * (t - 14.0) + 0.5 * 14.0 * exp(-t / 14.0);
            assert!((s - expected).abs() < 1e-10, "{t}: {s} {expected}");
        }
    }

    #[test]
    fn no_lag_reads_the_truth() {
        assert_eq!(reading(&[0.0, 1.0], &[3.0, 4.0], 0.0), [3.0, 4.0]);
    }

    #[test]
    fn the_derivative_is_that_of_the_readings() {
        let times = [0.0, 1.0, 3.5, 4.0, 9.0];
        let truth = [300.0, 303.0, 299.0, 299.5, 310.0];
        let mut values = truth;
        let mut slope = [0.0; 5];
        apply(&times, &mut values, 3.0, Some(&mut slope));
        let (high, low) = (reading(&times, &truth, 3.0 + 1e-5), reading(&times, &truth, 3.0 - 1e-5));
        for row in 0..5 {
            let difference = (high[row] - low[row]) / 2e-5;
            assert!((difference - slope[row]).abs() < 1e-7, "{row}: {difference} {}", slope[row]);
        }
    }
}
