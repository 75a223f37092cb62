//! Noise of readings: white, or Ornstein-Uhlenbeck on irregular instants (`x_k = phi x_(k-1) + s sqrt(1 - phi^2) e_k`,
//! `phi = exp(-dt / tau)`; Uhlenbeck & Ornstein 1930), of the standard deviation that the sensors state.

use super::truth::NoiseTruth;
use crate::math::functions::{exp, exp_m1};
use crate::measurement::total_sd;
use crate::measurement::{Measurement, Rows, Uncertain};
use crate::random::StreamKey;

/// Noise of all readings of a measurement, `rows x sensors`, SI. Sensor `i` of measurement `position` has stream
/// `1000 position + i` of the key, row `k` its words `2 k` and `2 k + 1`.
pub fn noise(measurement: &Measurement, position: u64, truth: NoiseTruth, key: &StreamKey) -> Vec<f64> {
    let (rows, sensors) = (measurement.len(), measurement.sensors.len());
    let mut noise = vec![0.0; rows * sensors];
    let times_s: &[f64] = match &measurement.rows {
        Rows::Transient { inputs, .. } => &inputs.times_s,
        Rows::Steady(_) => &[],
    };
    for (place, sensor) in measurement.sensors.iter().enumerate() {
        let nominal = |value: &Option<Uncertain>| value.as_ref().map(Uncertain::nominal);
        let sigma = nominal(&sensor.sigma).unwrap_or(0.0);
        let white = nominal(&sensor.white).unwrap_or(0.0);
        let (correlated, white, tau_s) = match (truth, nominal(&sensor.correlation_time_s)) {
            (NoiseTruth::AsStated, Some(tau_s)) => (sigma, white, Some(tau_s)),
            (NoiseTruth::AsStated, None) => (0.0, total_sd(sigma, white), None),
            (NoiseTruth::Correlated { correlation_time_s, share }, _) => {
                let total = total_sd(sigma, white);
                (total * share.sqrt(), total * (1.0 - share).sqrt(), Some(correlation_time_s))
            }
        };
        let mut stream = key.stream(1000 * position + place as u64);
        let mut state = 0.0;
        for row in 0..rows {
            let (innovation, other) = (stream.normal(), stream.normal());
            let step = match (row, tau_s) {
                (0, _) | (_, None) => f64::INFINITY,
                (_, Some(tau_s)) if !times_s.is_empty() => (times_s[row] - times_s[row - 1]) / tau_s,
                (_, Some(_)) => f64::INFINITY,
            };
            state = exp(-step) * state + correlated * (-exp_m1(-2.0 * step)).sqrt() * innovation;
            noise[row * sensors + place] = state + white * other;
        }
    }
    noise
}
