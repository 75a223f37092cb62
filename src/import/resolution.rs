//! How finely the temperatures of a record were printed: the step between two neighbouring values.

use crate::expression::unit::CELSIUS_ZERO_K;

/// Steps in a degree that are looked for; finer values count as exact.
const STEPS: [f64; 7] = [1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6];
/// How far a printed value may lie from a multiple of its step, in steps: what conversion to K in 64 bits leaves of six
/// decimals of some hundred degrees is a thousandth of this.
const NEAR: f64 = 1e-4;
/// 0 K in degF.
const FAHRENHEIT_AT_0_K: f64 = -459.67;

/// A scale of temperature.
struct Scale {
    /// The value on it of a temperature in K.
    value: fn(f64) -> f64,
    /// Its degree, K.
    degree_k: f64,
}

/// The coarsest decimal step, in K, of which all temperatures are multiples in kelvin, degrees Celsius or Fahrenheit; else
/// that of 32-bit numbers where they are such; else the finest step that is looked for.
pub fn step_k(temperatures_k: impl Iterator<Item = f64> + Clone) -> f64 {
    let scales: [Scale; 3] = [
        Scale { value: |kelvin| kelvin, degree_k: 1.0 },
        Scale { value: |kelvin| kelvin - CELSIUS_ZERO_K, degree_k: 1.0 },
        Scale { value: |kelvin| kelvin * 1.8 + FAHRENHEIT_AT_0_K, degree_k: 1.0 / 1.8 },
    ];
    let finite = temperatures_k.filter(|kelvin| kelvin.is_finite());
    for steps in STEPS {
        for scale in &scales {
            let is_multiple = |kelvin: f64| {
                let counted = (scale.value)(kelvin) * steps;
                (counted - counted.round()).abs() < NEAR
            };
            if finite.clone().all(is_multiple) {
                return scale.degree_k / steps;
            }
        }
    }
    let is_single = |scale: &Scale| {
        // Conversion to K leaves 64-bit rounding, far below the step of a 32-bit number.
        let is_near = |value: f64| (value - f64::from(value as f32)).abs() < 1e-9;
        finite.clone().all(|kelvin| is_near((scale.value)(kelvin)))
    };
    if scales[..2].iter().any(is_single) {
        let largest = finite.fold(0.0, f64::max) as f32;
        return f64::from(f32::from_bits(largest.to_bits().saturating_add(1)) - largest);
    }
    1.0 / STEPS[STEPS.len() - 1]
}
