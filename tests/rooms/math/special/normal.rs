//! Tests of `core/src/math/special/normal.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::math::special::normal::*;

fn assert_close(value: f64, expected: f64, relative: f64, what: f64) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{value} against {expected} at {what}");
}

#[test]
fn probabilities_agree_with_forty_digit_values() {
    // From erfc evaluated with 40 digits.
    for (x, expected, ln_expected) in [
        (-37.5, 4.605_353_009_581_955e-308, -707.668_989_317_507_2),
        (-20.0, 2.753_624_118_606_233_7e-89, -203.917_155_371_097_26),
        (-8.3, 5.205_569_744_890_254e-17, -37.494_217_423_748_25),
        (-5.0, 2.866_515_718_791_939e-7, -15.064_998_393_988_726),
        (-1.5, 0.066_807_201_268_858_07, -2.705_944_400_823_89),
        (-0.3, 0.382_088_577_811_047_4, -0.962_102_818_168_850_7),
        (0.7, 0.758_036_347_776_927, -0.277_023_942_277_131_3),
        (3.0, 0.998_650_101_968_369_9, -0.001_350_809_964_748_193_8),
    ] {
        assert_close(normal_cdf(x), expected, 2e-15, x);
        if x.abs() > 0.0 {
            assert_close(ln_normal_cdf(x), ln_expected, 4e-16, x);
        }
    }
    for (x, expected) in [(-40.0, -804.608_442_013_753_8), (-200.0, -20_006.217_280_898_19)] {
        assert_close(ln_normal_cdf(x), expected, 3e-16, x);
    }
    assert_close(ln_normal_cdf(-37.5), -707.668_989_317_507_2, 3e-16, -37.5);
    assert_eq!((normal_cdf(f64::INFINITY), normal_cdf(-50.0)), (1.0, 0.0));
    assert_close(normal_density(1.0), 0.241_970_724_519_143_35, 2e-16, 1.0);
}

#[test]
fn quantiles_agree_with_forty_digit_values() {
    for (p, expected) in [
        (1e-300, -37.047_096_299_361_2),
        (1e-100, -21.273_453_560_965_326),
        (1e-20, -9.262_340_089_798_408),
        (1e-12, -7.034_483_825_301_132),
        (1e-7, -5.199_337_582_192_817),
        (1e-3, -3.090_232_306_167_813_5),
        (0.024_25, -1.972_961_051_311_884_8),
        (0.074, -1.446_632_067_158_979),
        (0.076, -1.432_502_720_825_811_6),
        (0.1, -1.281_551_565_544_600_4),
        (0.25, -0.674_489_750_196_081_7),
        (0.4, -0.253_347_103_135_799_7),
        (0.499_99, -0.000_025_066_282_748_960_009),
    ] {
        // Near 0.5 the argument's own rounding shows, which the reference includes.
        assert_close(normal_quantile(p), expected, 5e-16, p);
    }
    assert_eq!(normal_quantile(0.75), -normal_quantile(0.25));
    assert_close(normal_quantile_centred(1e-20), 2.506_628_274_631_000_5e-20, 5e-16, 1e-20);
}

#[test]
fn quantiles_rise_also_across_the_seams() {
    for seam in [0.075, (-25.0_f64).exp(), 0.925, 0.5] {
        let mut last = f64::NEG_INFINITY;
        for step in -2000..2000 {
            let x = normal_quantile(seam * (1.0 + f64::from(step) * 1e-13));
            assert!(x >= last, "falls at {seam} step {step}");
            last = x;
        }
    }
}

#[test]
fn ln_quantiles_invert_ln_probabilities() {
    for x in [-5.0, -30.0, -36.9, -37.6, -60.0, -1e4] {
        assert_close(normal_quantile_of_ln(ln_normal_cdf(x)), x, 1e-14, x);
    }
}

#[test]
fn interval_probabilities_keep_their_digits() {
    // Narrow intervals against density times width; wide ones against differences of published probabilities.
    assert_close(ln_normal_interval(-1.0, 1.0), 0.682_689_492_137_085_9_f64.ln(), 1e-14, 1.0);
    assert_close(ln_normal_interval(3.0, f64::INFINITY), 0.001_349_898_031_630_094_5_f64.ln(), 1e-14, 3.0);
    for (lower, upper) in [(2.0, 2.0004), (2.0, 2.0006), (-50.001, -50.0), (10.0, 10.000_09)] {
        // Simpson's rule on the density, relative to its value at the middle.
        let middle: f64 = 0.5 * (lower + upper);
        let shape = |x: f64| (-(x - middle) * (x + middle) * 0.5).exp();
        let steps = 200;
        let h = (upper - lower) / f64::from(steps);
        let sum: f64 = (0..=steps)
            .map(|k| {
                let weight = if k == 0 || k == steps { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
                weight * shape(lower + f64::from(k) * h)
            })
            .sum();
        let expected = (sum * h / 3.0).ln() - 0.5 * middle * middle - LN_SQRT_TWO_PI;
        assert_close(ln_normal_interval(lower, upper), expected, 1e-12, lower);
    }
    assert_eq!(ln_normal_interval(1.0, 1.0), f64::NEG_INFINITY);
}
