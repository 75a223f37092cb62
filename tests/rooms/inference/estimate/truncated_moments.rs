//! Tests of `core/src/inference/estimate/truncated_moments.rs`.

use bmv::inference::estimate::optimise::Bounds;
use bmv::inference::estimate::truncated_moments::*;
use bmv::math::functions::exp;
use bmv::math::quadrature::gauss_legendre;

/// Moments by quadrature over a box of two variables.
fn by_quadrature(gradient: [f64; 2], h: [f64; 3], lower: [f64; 2], upper: [f64; 2]) -> Moments {
    let rule = gauss_legendre(400);
    let integral = |of: &dyn Fn(f64, f64) -> f64| {
        rule.integrate(lower[0], upper[0], |x| {
            rule.integrate(lower[1], upper[1], |y| {
                let fall = gradient[0] * x + gradient[1] * y + 0.5 * (h[0] * x * x + h[2] * y * y) + h[1] * x * y;
                of(x, y) * exp(-fall)
            })
        })
    };
    let all = integral(&|_, _| 1.0);
    let mean = [integral(&|x, _| x) / all, integral(&|_, y| y) / all];
    let square = [integral(&|x, _| x * x) / all, integral(&|_, y| y * y) / all];
    Moments { mean: mean.to_vec(), sd: (0..2).map(|i| (square[i] - mean[i] * mean[i]).sqrt()).collect() }
}

fn compare(gradient: [f64; 2], h: [f64; 3], lower: [f64; 2], upper: [f64; 2], free: &[usize]) {
    let bounds = Bounds { lower: lower.to_vec(), upper: upper.to_vec() };
    let approximate = moments(&[0.0; 2], &gradient, &bounds, &[h[0], h[1], h[1], h[2]], free).expect("moments");
    let exact = by_quadrature(gradient, h, lower, upper);
    for i in 0..2 {
        // The points leave 0.011 of an exponential density in one variable and 0.022 of two that trade; 4096 of them 0.01.
        assert!((approximate.mean[i] - exact.mean[i]).abs() < 0.03 * exact.sd[i], "{i} {approximate:?} {exact:?}");
        assert!((approximate.sd[i] / exact.sd[i] - 1.0).abs() < 0.03, "{i} {approximate:?} {exact:?}");
    }
}

/// A conductor held at its bound by a gentle gradient, and the amplitude of a path beside it that trades for it: the free part
/// alone would give the amplitude a standard deviation of 0.1.
#[test]
fn what_trades_for_a_held_variable_is_as_uncertain() {
    compare([0.5, 0.0], [100.0, 99.0, 100.0], [0.0, -9.0], [3.0, 9.0], &[1]);
    compare([0.0, -40.0], [4.0, 1.0, 3.0], [-9.0, -2.0], [9.0, 0.0], &[0]);
    let bounds = Bounds { lower: vec![0.0, -9.0], upper: vec![3.0, 9.0] };
    let approximate = moments(&[0.0; 2], &[0.5, 0.0], &bounds, &[100.0, 99.0, 99.0, 100.0], &[1]).expect("moments");
    assert!(approximate.sd[1] > 0.3, "{approximate:?}");
}

#[test]
fn free_variables_near_their_bounds_are_cut() {
    compare([0.0; 2], [1.0, 0.6, 2.0], [-0.3, -9.0], [5.0, 9.0], &[0, 1]);
    compare([0.0; 2], [1.0, -0.6, 2.0], [-0.3, -0.1], [5.0, 0.4], &[0, 1]);
}

/// Two that a gentle gradient holds at opposite bounds and at the same, far apart along a ridge.
#[test]
fn held_variables_that_trade_spread_along_their_ridge() {
    for r in [0.7, 0.9, 0.99] {
        compare([0.5, -0.5], [100.0, 100.0 * r, 100.0], [0.0, -9.0], [9.0, 0.0], &[]);
        compare([0.5, 0.5], [100.0, -100.0 * r, 100.0], [0.0, 0.0], [9.0, 9.0], &[]);
        compare([60.0, 0.5], [100.0, -100.0 * r, 100.0], [0.0, 0.0], [9.0, 9.0], &[]);
    }
}

#[test]
fn two_held_variables_trade() {
    compare([0.3, 0.1], [4.0, 2.0, 3.0], [0.0; 2], [2.0, 9.0], &[]);
    compare([0.3, -2.0], [4.0, 2.0, 3.0], [0.0, -1.0], [2.0, 0.0], &[]);
    compare([200.0, 0.0], [4.0, 2.0, 3.0], [0.0, 0.0], [0.3, 2.0], &[]);
    compare([1e-12, 0.4], [0.0, 0.0, 3.0], [0.0, 0.0], [0.3, 2.0], &[]);
}

#[test]
fn without_bounds_near_it_is_the_normal_approximation() {
    let bounds = Bounds { lower: vec![-99.0; 2], upper: vec![99.0; 2] };
    let approximate = moments(&[1.0, 2.0], &[0.0; 2], &bounds, &[2.0, 1.0, 1.0, 2.0], &[0, 1]).expect("moments");
    assert_eq!(approximate.mean, [1.0, 2.0]);
    assert!(approximate.sd.iter().all(|sd| (sd * sd - 2.0 / 3.0).abs() < 1e-12), "{approximate:?}");
    // Nothing limits the second.
    let open = Bounds { lower: vec![-99.0, 0.0], upper: vec![99.0, f64::INFINITY] };
    assert_eq!(moments(&[0.0; 2], &[0.0; 2], &open, &[2.0, 0.0, 0.0, 0.0], &[0]), None);
}
