//! Tests of `core/src/statistics/sobol_indices.rs`.

use bmv::random::StreamKey;
use bmv::statistics::sobol_indices::*;

/// `f = x0 + 2 x1 + 3 x0 x2` over independent uniform numbers of variance 1/12 about 0.
fn function(x: &[f64]) -> f64 {
    x[0] + 2.0 * x[1] + 3.0 * x[0] * x[2]
}

fn sums(rows: u64, seed: u64, offset: f64) -> SobolSums {
    let mut stream = StreamKey::new(seed, "t", "t").stream(0);
    let mut sums = SobolSums::new(3, true, offset);
    for _ in 0..rows {
        let a: Vec<f64> = (0..3).map(|_| stream.uniform() - 0.5).collect();
        let b: Vec<f64> = (0..3).map(|_| stream.uniform() - 0.5).collect();
        let f = |x: &[f64]| offset + function(x);
        let mixed = |x: &[f64], y: &[f64], j: usize| {
            let mut z = x.to_vec();
            z[j] = y[j];
            f(&z)
        };
        let ab: Vec<f64> = (0..3).map(|j| mixed(&a, &b, j)).collect();
        let ba: Vec<f64> = (0..3).map(|j| mixed(&b, &a, j)).collect();
        sums.add(f(&a), f(&b), &ab, &ba);
    }
    sums
}

#[test]
fn independent_rows_give_the_exact_indices_within_their_error() {
    // Variances 1/12, 4/12 and 9/144: V = 69/144, S = 12/69, 48/69, 0, S_02 = 9/69.
    let indices = sums(40_000, 1, 300.0).indices().expect("varies");
    let v = 69.0;
    let close = |x: f64, exact: f64| assert!((x - exact / v).abs() < 0.02, "{x}, exact {}", exact / v);
    indices.main.iter().zip([12.0, 48.0, 0.0]).for_each(|(&x, exact)| close(x, exact));
    indices.total.iter().zip([21.0, 48.0, 9.0]).for_each(|(&x, exact)| close(x, exact));
    indices.second.iter().zip([0.0, 9.0, 0.0]).for_each(|(&x, exact)| close(x, exact));
    assert!((indices.mean - 300.0).abs() < 0.02 && (indices.variance - v / 144.0).abs() < 0.02);
}

#[test]
fn a_large_mean_changes_nothing_wherever_the_centre_lies() {
    let plain = sums(500, 3, 0.0).indices().expect("varies");
    let shifted = sums(500, 3, 1000.0).indices().expect("varies");
    for (x, y) in plain.main.iter().chain(&plain.second).zip(shifted.main.iter().chain(&shifted.second)) {
        // The offset costs three digits of each value, six of a product.
        assert!((x - y).abs() < 1e-9, "{x} {y}");
    }
}

#[test]
fn merged_parts_are_the_whole() {
    let (mut first, whole) = (SobolSums::new(2, true, 1.0), {
        let mut sums = SobolSums::new(2, true, 1.0);
        sums.add(1.0, 2.0, &[3.0, 5.0], &[1.5, 0.5]);
        sums.add(4.0, 2.0, &[1.0, 0.0], &[2.5, -2.0]);
        sums
    });
    first.add(1.0, 2.0, &[3.0, 5.0], &[1.5, 0.5]);
    let mut second = SobolSums::new(2, true, 1.0);
    second.add(4.0, 2.0, &[1.0, 0.0], &[2.5, -2.0]);
    first.merge(&second);
    assert_eq!(first, whole);
    assert_eq!((first.rows(), first.range()), (2, Some([-2.0, 5.0])));
}

#[test]
fn what_does_not_vary_has_no_indices() {
    let mut sums = SobolSums::new(1, false, 0.0);
    assert!(sums.indices().is_none());
    for _ in 0..5 {
        sums.add(300.0, 300.0, &[300.0], &[]);
    }
    assert!(sums.is_constant() && sums.indices().is_none());
    sums.add(300.0, 300.0 + 1e-10, &[300.0], &[]);
    assert!(sums.is_constant(), "rounding is no variation");
}

#[test]
fn bounds_hold_for_whatever_the_rows_left_out_were() {
    // The whole has 400 rows; the last ones are left out, whose values lie within the range of the first.
    let whole = sums(400, 5, 0.0);
    let kept = sums(390, 5, 0.0);
    let [low, high] = kept.range().expect("rows");
    assert!(whole.range().expect("rows")[0] >= low && whole.range().expect("rows")[1] <= high);
    let (all, some) = (whole.indices().expect("varies"), kept.indices().expect("varies"));
    for j in 0..3 {
        let [main, total] = kept.bounds(10, some.main[j], some.total[j]).expect("rows");
        assert!(main[0] <= all.main[j] && all.main[j] <= main[1], "{main:?}");
        assert!(total[0] <= all.total[j] && all.total[j] <= total[1], "{total:?}");
    }
    assert_eq!(kept.bounds(0, 0.25, 0.5), Some([[0.25; 2], [0.5; 2]]));
}

#[test]
fn intervals_are_students() {
    // Of 1, 2, 3, 4: mean 2.5, standard error 0.6455, t of 3 degrees of freedom 3.18245.
    let estimate = Estimate::of(&[1.0, 2.0, 3.0, 4.0]);
    assert!((estimate.upper - 2.5 - 3.182_446 * 0.645_497).abs() < 1e-5 && estimate.value == 2.5);
    assert!((estimate.width() - 2.0 * (estimate.upper - 2.5)).abs() < 1e-12);
    assert_eq!(Estimate::of(&[1.0]).upper, f64::INFINITY);
}

#[test]
fn places_leave_open_what_intervals_leave_open() {
    let at = |value: f64, reach: f64| Estimate { value, lower: value - reach, upper: value + reach };
    let ranks = places(&[at(0.1, 0.03), at(0.7, 0.01), at(0.12, 0.01), at(0.0, 0.001)]);
    let place = |best, worst| Place { best, worst };
    assert_eq!(ranks, [place(2, 3), place(1, 1), place(2, 3), place(4, 4)]);
}
