//! Tests of `core/src/inference/information/search.rs`.

use bmv::inference::information::search::*;
use bmv::random::StreamKey;

fn key() -> StreamKey {
    StreamKey::new(1, "search", "test")
}

#[test]
fn the_process_goes_through_its_values_and_knows_where_it_is_sure() {
    let points: Vec<Vec<f64>> = (0..6).map(|k| vec![f64::from(k) / 5.0]).collect();
    let values: Vec<f64> = points.iter().map(|p| 3.0 + (p[0] - 0.3) * (p[0] - 0.3)).collect();
    let process = Process::fit(&points, &values).expect("varies");
    for (point, value) in points.iter().zip(&values) {
        let (mean, sd) = process.at(point);
        assert!((mean - value).abs() < 1e-5 && sd < 1e-3, "{mean} {value} {sd}");
    }
    // Between them a parabola is met to a hundredth of its range, and the process says about as much.
    let (mean, sd) = process.at(&[0.5]);
    assert!((mean - 3.04).abs() < 0.005 && sd < 0.05, "{mean} {sd}");
    assert!(Process::fit(&points, &[1.0; 6]).is_none() && Process::fit(&[], &[]).is_none());
}

#[test]
fn improvement_has_its_closed_form() {
    // Standard normal: E max(0, y) = 1 / sqrt(2 pi); far above it is the difference; without spread the larger of both.
    assert!((expected_improvement(0.0, 1.0, 0.0) - 0.398_942_280_4).abs() < 1e-10);
    assert!((expected_improvement(50.0, 1.0, 0.0) - 50.0).abs() < 1e-12);
    assert_eq!((expected_improvement(1.0, 0.0, 3.0), expected_improvement(3.0, 0.0, 1.0)), (0.0, 2.0));
}

/// Searches from a coarse grid of 4 x 4 in rounds of 4.
fn searched(f: impl Fn(&[f64]) -> f64, excess: impl Fn(&[f64]) -> f64) -> (Vec<f64>, f64) {
    let of = |point: Vec<f64>| Known { value: Some(f(&point)), excess: excess(&point), point };
    let mut evaluated: Vec<Known> = (0..16).map(|k| of(vec![f64::from(k % 4) / 3.0, f64::from(k / 4) / 3.0])).collect();
    for _ in 0..5 {
        let points = next(&evaluated, 4, 1000.0, &key());
        evaluated.extend(points.into_iter().map(&of));
    }
    let allowed = evaluated.iter().filter(|sample| sample.excess <= 0.0);
    let best = allowed.max_by(|a, b| a.value.unwrap_or(0.0).total_cmp(&b.value.unwrap_or(0.0))).expect("one");
    (best.point.clone(), best.value.expect("a value"))
}

#[test]
fn a_known_optimum_is_found_between_the_points_of_the_grid() {
    // Branin & Hoo's function (Dixon & Szego 1978), negative: -0.397887 at (-pi, 12.275), (pi, 2.275), (9.42478, 2.475).
    let branin = |u: &[f64]| {
        let (x, y) = (15.0 * u[0] - 5.0, 15.0 * u[1]);
        let pi = std::f64::consts::PI;
        let a = y - 5.1 / (4.0 * pi * pi) * x * x + 5.0 / pi * x - 6.0;
        -(a * a + 10.0 * (1.0 - 1.0 / (8.0 * pi)) * bmv::math::functions::cos(x) + 10.0)
    };
    let (at, value) = searched(branin, |_| 0.0);
    // The function spans 300: a thousandth of that.
    assert!(value > -0.397_887 - 0.3 && value <= -0.397_887, "{at:?} {value}");
}

#[test]
fn limits_are_kept() {
    // The top of a hill at (0.7, 0.7), of which only u + v <= 1 is allowed: (0.5, 0.5) is best there.
    let hill = |u: &[f64]| -(u[0] - 0.7) * (u[0] - 0.7) - (u[1] - 0.7) * (u[1] - 0.7);
    let (at, value) = searched(hill, |u| u[0] + u[1] - 1.0);
    assert!(at[0] + at[1] <= 1.0 && (value + 0.08).abs() < 0.005, "{at:?} {value}");
}
