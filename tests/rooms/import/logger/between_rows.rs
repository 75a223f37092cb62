//! Tests of `src/import/logger/between_rows.rs`.

use bmv::import::logger::between_rows::between_rows;
use bmv::math::functions::exp;
use bmv::math::special::normal_quantile;

/// A series of 400 rows, with noise of a standard deviation: quantiles of a normal distribution in an order without pattern.
fn series(noise: f64, value: impl Fn(usize) -> f64) -> Vec<Option<f64>> {
    let normal = |row: usize| normal_quantile(((row * row * 37 + row * 101 + 13) % 401) as f64 / 401.0 + 0.5 / 401.0);
    (0..400).map(|row| Some(value(row) + noise * normal(row))).collect()
}

#[test]
fn what_is_set_is_held_whatever_its_noise_and_what_moves_steadily_is_not() {
    let steps = |row: usize| [0.0, 8.0, 3.0, 3.5][row / 100];
    let ramp = |row: usize| 0.05 * row as f64;
    let settling = |row: usize| if row < 50 { 0.0 } else { 20.0 * (1.0 - exp(-((row - 50) as f64) / 20.0)) };
    let drift = |row: usize| steps(row) + 0.01 * (row % 100) as f64;
    let held = |noise: f64, value: &dyn Fn(usize) -> f64| between_rows(&series(noise, value), "W");
    // Without noise, and with noise of mW to a sixteenth of the smallest step.
    for noise in [0.0, 0.002, 0.03] {
        assert!(held(noise, &steps).is_held, "steps with {noise}: {:?}", held(noise, &steps));
        for (name, value) in [("ramp", &ramp as &dyn Fn(usize) -> f64), ("settling", &settling), ("drift", &drift)] {
            assert!(!held(noise, value).is_held, "{name} with {noise}: {:?}", held(noise, value));
        }
    }
    let said = held(0.002, &steps).because;
    assert!(said.contains("3 steps") && said.contains("noise of 0.0019 W"), "{said}");
    // Noise alone steps nowhere; an averaging logger shows a step in two rows; noise may stand in one level alone.
    assert!(!held(0.002, &|_| 5.0).is_held);
    assert!(held(0.002, &|row| if row == 100 { 4.0 } else { steps(row) }).is_held);
    let switched: Vec<Option<f64>> = (series(0.002, steps).iter().enumerate())
        .map(|(row, value)| if row < 100 { Some(0.0) } else { *value })
        .collect();
    assert!(between_rows(&switched, "W").is_held);
    assert!(!between_rows(&switched[..5], "W").is_held);
}
