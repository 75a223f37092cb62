//! Tests of `src/import/resolution.rs`.

use bmv::import::resolution::*;

fn step(values: &[f64], to_k: impl Fn(f64) -> f64) -> f64 {
    step_k(values.iter().map(|value| to_k(*value)))
}

#[test]
fn the_step_is_that_of_the_scale_that_was_printed() {
    assert_eq!(step(&[293.2, 301.7], |kelvin| kelvin), 0.1);
    assert_eq!(step(&[20.31, -5.0], |celsius| celsius + 273.15), 0.01);
    // In kelvin these have two decimals.
    assert_eq!(step(&[20.3, -5.0], |celsius| celsius + 273.15), 0.1);
    let fahrenheit = step(&[68.3, 41.1], |fahrenheit| (fahrenheit + 459.67) / 1.8);
    assert!((fahrenheit - 0.1 / 1.8).abs() < 1e-15, "{fahrenheit}");
    assert_eq!(step(&[300.1234567890123, 1.0 / 3.0], |kelvin| kelvin), 1e-6);
    // 2^-15 K is the distance of 32-bit numbers between 256 and 512.
    assert_eq!(step(&[301.234567891, 299.876543219], |kelvin: f64| f64::from(kelvin as f32)), 1.0 / 32768.0);
}
