//! Tests of `core/src/statistics/poincare.rs`.

use bmv::math::functions::{cos, exp, ln};
use bmv::random::Distribution;
use bmv::statistics::poincare::*;

/// Variance of f and the bound on it, by the midpoint rule over probabilities.
fn variance_and_bound(distribution: &Distribution, f: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64) -> [f64; 2] {
    let n = 20_000;
    let points: Vec<f64> = (0..n).map(|i| distribution.quantile((f64::from(i) + 0.5) / f64::from(n))).collect();
    let mean = |g: &dyn Fn(f64) -> f64| points.iter().map(|&x| g(x)).sum::<f64>() / f64::from(n);
    let centre = mean(&f);
    let poincare = Poincare::of(distribution);
    [mean(&|x| (f(x) - centre) * (f(x) - centre)), mean(&|x| poincare.weighted_square(x, slope(x)))]
}

#[test]
fn the_bound_is_reached_by_the_extremal_functions() {
    // cos(pi x / L) for a uniform, a line for a normal variable, its logarithm for a lognormal one.
    let uniform = Distribution::Uniform { lower: 2.0, upper: 5.0 };
    let w = std::f64::consts::PI / 3.0;
    let [v, bound] =
        variance_and_bound(&uniform, |x| cos(w * (x - 2.0)), |x| -w * bmv::math::functions::sin(w * (x - 2.0)));
    assert!((v / bound - 1.0).abs() < 1e-6, "{v} {bound}");
    let normal = Distribution::Normal { mean: 1.0, sd: 2.0, lower: None, upper: None };
    let [v, bound] = variance_and_bound(&normal, |x| 3.0 * x, |_| 3.0);
    // The rule cuts the tails beyond 1 / 40000.
    assert!((v / bound - 1.0).abs() < 1e-3, "{v} {bound}");
    let lognormal = Distribution::LogNormal { median: 3.0, factor: 2.0 };
    let [v, bound] = variance_and_bound(&lognormal, ln, |x| 1.0 / x);
    assert!((v / bound - 1.0).abs() < 1e-3, "{v} {bound}");
}

#[test]
fn the_bound_holds_for_every_kind() {
    for distribution in [
        Distribution::Uniform { lower: -1.0, upper: 2.0 },
        Distribution::Normal { mean: 0.5, sd: 1.0, lower: Some(0.0), upper: None },
        Distribution::Normal { mean: 0.5, sd: 4.0, lower: Some(0.0), upper: Some(1.0) },
        Distribution::LogNormal { median: 1.0, factor: 1.5 },
        Distribution::LogUniform { lower: 0.1, upper: 10.0 },
        Distribution::HalfNormal { scale: 0.7 },
        Distribution::Triangular { lower: 0.0, mode: 0.1, upper: 1.0 },
    ] {
        for rate in [0.3, -1.0] {
            let [v, bound] = variance_and_bound(&distribution, |x| exp(rate * x), |x| rate * exp(rate * x));
            assert!(v <= bound, "{distribution:?}: {v} above {bound}");
        }
        let [v, bound] = variance_and_bound(&distribution, |x| x, |_| 1.0);
        assert!(v <= bound, "{distribution:?}: {v} above {bound}");
    }
    assert_eq!(Poincare::of(&Distribution::Fixed(3.0)).constant, 0.0);
}
