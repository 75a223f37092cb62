//! Tests of `core/src/random/distribution.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::random::distribution::*;
use statrs::distribution::{Continuous, ContinuousCDF, LogNormal, Normal, Triangular, Uniform};

const ALL: [Distribution; 12] = [
    Distribution::Uniform { lower: -1.0, upper: 3.0 },
    Distribution::Normal { mean: 2.0, sd: 0.5, lower: None, upper: None },
    Distribution::Normal { mean: 2.0, sd: 0.5, lower: Some(1.8), upper: None },
    Distribution::Normal { mean: 2.0, sd: 0.5, lower: None, upper: Some(1.1) },
    Distribution::Normal { mean: 2.0, sd: 0.5, lower: Some(1.0), upper: Some(4.0) },
    Distribution::Normal { mean: 2.0, sd: 0.5, lower: Some(12.0), upper: Some(12.5) },
    Distribution::Normal { mean: 0.0, sd: 1.0, lower: Some(100.0), upper: None },
    Distribution::LogNormal { median: 3.0, factor: 1.7 },
    Distribution::LogUniform { lower: 0.01, upper: 10.0 },
    Distribution::HalfNormal { scale: 0.4 },
    Distribution::Triangular { lower: 1.0, mode: 1.5, upper: 4.0 },
    Distribution::Triangular { lower: 1.0, mode: 1.0, upper: 4.0 },
];

#[test]
fn quantile_and_probability_are_inverse() {
    for d in ALL {
        let (lower, upper) = d.support();
        let mut last = f64::NEG_INFINITY;
        for k in 1..400 {
            let u = f64::from(k) / 400.0;
            let x = d.quantile(u);
            assert!(lower <= x && x <= upper && x > last, "{d:?} at {u}: {x}");
            let mut several = [0.5, u];
            d.quantiles(&mut several);
            assert_eq!(several[1].to_bits(), x.to_bits());
            last = x;
            // At 100 standard deviations a unit in the last place of x moves the probability by 1e-12.
            assert!((d.cdf(x) - u).abs() < 3e-12, "{d:?} at {u}: {}", d.cdf(x));
        }
        for u in [1e-16, 1.0 - 1e-16] {
            let x = d.quantile(u);
            assert!(lower <= x && x <= upper && x.is_finite(), "{d:?} at {u}: {x}");
        }
    }
}

#[test]
fn densities_are_derivatives_of_probabilities_and_their_logarithms_have_the_stated_slope() {
    for d in ALL {
        for u in [0.03, 0.2, 0.5, 0.77, 0.98] {
            let x = d.quantile(u);
            let h = 0.01 * (d.quantile(u + 0.01) - d.quantile(u - 0.01));
            let slope = (d.cdf(x + h) - d.cdf(x - h)) / (2.0 * h);
            assert!((slope / d.log_density(x).exp() - 1.0).abs() < 1e-4, "{d:?} at {u}");
            let slope = (d.log_density(x + h) - d.log_density(x - h)) / (2.0 * h);
            let stated = d.log_density_derivative(x);
            assert!(
                (slope - stated).abs() * d.sd() < 1e-4 * (1.0 + stated.abs() * d.sd()),
                "{d:?} at {u}: {slope} against {stated}"
            );
        }
    }
}

#[test]
fn mean_and_sd_are_those_of_the_quantiles() {
    // Midpoint rule over the quantile, an independent integral; its error at the open ends allows 0.3 %.
    for d in ALL {
        let n = 20_000;
        let values: Vec<f64> = (0..n).map(|k| d.quantile((f64::from(k) + 0.5) / f64::from(n))).collect();
        let mean = values.iter().sum::<f64>() / f64::from(n);
        let sd = (values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / f64::from(n)).sqrt();
        assert!((mean - d.mean()).abs() < 1e-3 * d.sd(), "{d:?}: {mean} against {}", d.mean());
        assert!((sd / d.sd() - 1.0).abs() < 3e-3, "{d:?}: {sd} against {}", d.sd());
    }
}

#[test]
fn truncated_normal_far_in_the_tail_follows_its_expansion() {
    // Beyond a bound of 100 sd the excess is nearly exponential: mean 1/a (1 - 2/a^2 + 10/a^4 ...),
    // variance 1/a^2 (1 - 6/a^2 + 50/a^4 ...) (from Mills' ratio).
    let d = Distribution::Normal { mean: 0.0, sd: 1.0, lower: Some(100.0), upper: None };
    let (a, s) = (100.0_f64, 1e-4_f64);
    assert!((d.mean() - 100.0 - (1.0 - 2.0 * s + 10.0 * s * s) / a).abs() < 1e-11);
    assert!((d.sd() * a - (1.0 - 6.0 * s + 50.0 * s * s).sqrt()).abs() < 1e-9);
    // The median excess solves t (a + t / 2) = ln 2 up to terms of order 1/a^3.
    assert!((d.quantile(0.5) - 100.0 - 0.006_930_7).abs() < 2e-6, "{}", d.quantile(0.5));
    // Symmetric pairs are mirror images.
    let left = Distribution::Normal { mean: 0.0, sd: 1.0, lower: None, upper: Some(-100.0) };
    assert_eq!(left.quantile(0.25), -d.quantile(0.75));
}

#[test]
fn truncated_moments_follow_the_closed_form_where_it_is_sound() {
    let d = Distribution::Normal { mean: 1.0, sd: 2.0, lower: Some(0.0), upper: Some(4.0) };
    let (a, b) = (-0.5_f64, 1.5_f64);
    let n = Normal::new(0.0, 1.0).unwrap();
    let mass = n.cdf(b) - n.cdf(a);
    let shift = (n.pdf(a) - n.pdf(b)) / mass;
    let variance = 1.0 + (a * n.pdf(a) - b * n.pdf(b)) / mass - shift * shift;
    assert!((d.mean() - (1.0 + 2.0 * shift)).abs() < 1e-10);
    assert!((d.sd() - 2.0 * variance.sqrt()).abs() < 1e-10);
    // The cut stretches the density by the mass inside.
    assert!((d.log_density(1.0) - (n.pdf(0.0) / 2.0 / mass).ln()).abs() < 1e-10);
}

#[test]
fn agrees_with_statrs() {
    fn compare<D: Continuous<f64, f64> + ContinuousCDF<f64, f64>>(ours: Distribution, theirs: &D) {
        for u in [0.01, 0.3, 0.6, 0.95] {
            let x = ours.quantile(u);
            assert!((theirs.cdf(x) - ours.cdf(x)).abs() < 1e-10, "{ours:?}");
            assert!((theirs.ln_pdf(x) - ours.log_density(x)).abs() < 1e-10, "{ours:?}");
        }
    }
    compare(ALL[0], &Uniform::new(-1.0, 3.0).unwrap());
    compare(ALL[1], &Normal::new(2.0, 0.5).unwrap());
    compare(ALL[7], &LogNormal::new(3_f64.ln(), 1.7_f64.ln()).unwrap());
    compare(ALL[10], &Triangular::new(1.0, 4.0, 1.5).unwrap());
}

#[test]
fn log_uniform_sd_keeps_its_digits_for_narrow_ranges() {
    // Narrow: nearly uniform. At the seam of the two forms: equal.
    let narrow = Distribution::LogUniform { lower: 2.0, upper: 2.0 * (1.0 + 1e-6) };
    assert!((narrow.sd() / (2e-6 / 12_f64.sqrt()) - 1.0).abs() < 1e-6);
    let (a, b) = (0.099_999_9_f64.exp(), 0.100_000_1_f64.exp());
    let below = Distribution::LogUniform { lower: 1.0, upper: a };
    let above = Distribution::LogUniform { lower: 1.0, upper: b };
    assert!((above.sd() / below.sd() - 1.0 - 2e-6 * 1.05).abs() < 1e-7);
}

#[test]
fn outside_the_support_there_is_nothing() {
    let d = Distribution::Uniform { lower: 1.0, upper: 2.0 };
    assert_eq!(d.log_density(2.1), f64::NEG_INFINITY);
    assert_eq!((d.cdf(0.0), d.cdf(3.0)), (0.0, 1.0));
    assert_eq!(Distribution::LogNormal { median: 1.0, factor: 2.0 }.log_density(0.0), f64::NEG_INFINITY);
    let fixed = Distribution::Fixed(4.0);
    assert_eq!((fixed.quantile(0.3), fixed.log_density(4.0), fixed.sd()), (4.0, 0.0, 0.0));
    assert_eq!((fixed.log_density(4.1), fixed.cdf(3.9), fixed.cdf(4.0)), (f64::NEG_INFINITY, 0.0, 1.0));
    assert!(fixed.is_fixed() && !d.is_fixed());
}

#[test]
fn wrong_parameters_are_named() {
    let message = |d: Distribution| d.validate().unwrap_err().to_string();
    assert!(ALL.iter().all(|d| d.validate().is_ok()));
    assert_eq!(
        message(Distribution::Uniform { lower: 2.0, upper: 2.0 }),
        "the lower bound 2 must be below the upper bound 2"
    );
    assert_eq!(message(Distribution::LogNormal { median: 1.0, factor: 1.0 }), "factor is 1, but it must be above 1");
    assert_eq!(
        message(Distribution::Normal { mean: f64::NAN, sd: 1.0, lower: None, upper: None }),
        "mean is NaN, but it must be a finite number"
    );
    assert_eq!(
        message(Distribution::Triangular { lower: 0.0, mode: 2.0, upper: 1.0 }),
        "mode is 2, but it must be between the bounds 0 and 1"
    );
    assert_eq!(message(Distribution::HalfNormal { scale: -1.0 }), "scale is -1, but it must be above 0");
}
