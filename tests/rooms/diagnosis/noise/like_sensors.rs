//! Tests of `diagnosis/src/diagnosis/noise/like_sensors.rs`.

use bmv::diagnosis::noise::like_sensors::*;
use bmv::math::functions::{exp, ln};
use bmv::random::Distribution;

fn errors(count: f64, size: f64) -> Errors {
    Errors { count, square: count * size * size }
}

/// With one size and no prior nothing is shared; the closed form of the mode about a common size: with `u` the logarithm of
/// the size over the common one, `n (s^2 e^-2u / c^2 - 1) = u / a^2`.
#[test]
fn sizes_are_the_modes_about_the_common_one() {
    let same = sizes(&[errors(6.0, 0.2), errors(6.0, 0.2)], None);
    assert!(same.iter().all(|size| (size / 0.2 - 1.0).abs() < 1e-4), "{same:?}");
    let (size, _) = errors(6.0, 0.1).about(1.0);
    let u = ln(size);
    let slope = 6.0 * (0.01 * exp(-2.0 * u) - 1.0) - u / (ALIKE * ALIKE);
    assert!(slope.abs() < 1e-3, "{slope}");
}

/// Few phases: a sensor with thirty times the errors of the others stays within a few times their noise; many: it is as it is.
#[test]
fn few_phases_do_not_make_noise_of_what_one_sensor_shows() {
    let of = |count: f64| {
        let all = [0.1, 0.1, 0.1, 3.0].map(|size| errors(count, size));
        let found = sizes(&all, None);
        found[3] / found[0]
    };
    assert!(of(6.0) < 12.0, "{}", of(6.0));
    assert!(of(200.0) > 25.0, "{}", of(200.0));
}

/// What is far beyond the prior is no noise.
#[test]
fn the_common_size_has_the_prior() {
    let prior = Distribution::LogUniform { lower: 0.05, upper: 0.5 };
    let found = sizes(&[errors(4.0, 5.0)], Some(&prior));
    assert!(found[0] < 3.0, "{found:?}");
}
