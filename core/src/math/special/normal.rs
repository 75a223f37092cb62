//! The standard normal distribution: density, probabilities, quantiles, accurate far in both tails.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::math::functions::{erfc, exp, exp_m1, ln, ln_1p};

/// `ln(2 pi) / 2`.
const LN_SQRT_TWO_PI: f64 = 0.918_938_533_204_672_7;
/// `1 / sqrt(2 pi)`.
const DENSITY_AT_ZERO: f64 = 0.398_942_280_401_432_7;
/// `1 / sqrt(2) - FRAC_1_SQRT_2`, what the constant lost in rounding.
const FRAC_1_SQRT_2_REST: f64 = -4.833_646_656_726_457e-17;
/// `2 / sqrt(pi)`.
const TWO_OVER_SQRT_PI: f64 = std::f64::consts::FRAC_2_SQRT_PI;

/// Density of the standard normal distribution.
pub fn normal_density(x: f64) -> f64 {
    DENSITY_AT_ZERO * exp_minus_half_square(x)
}

/// Logarithm of [`normal_density`].
pub fn ln_normal_density(x: f64) -> f64 {
    -0.5 * x * x - LN_SQRT_TWO_PI
}

/// `exp(-x^2 / 2)`; the square is split so that its rounding does not grow in the tails.
fn exp_minus_half_square(x: f64) -> f64 {
    let (square, rest) = product_exact(x, x);
    if square > 1500.0 { 0.0 } else { exp(-0.5 * square) * (1.0 - 0.5 * rest) }
}

/// A product and its rounding error (Dekker 1971), without fused operations.
fn product_exact(a: f64, b: f64) -> (f64, f64) {
    let split = |x: f64| {
        let shifted = 134_217_729.0 * x;
        let high = shifted - (shifted - x);
        (high, x - high)
    };
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
}

/// Probability that a standard normal variable is below x; relative error about 1e-15 down to x = -37.
pub fn normal_cdf(x: f64) -> f64 {
    if x.is_nan() || x.abs() > 40.0 {
        return if x.is_nan() { x } else { f64::from(x > 0.0) };
    }
    let (scaled, rest) = product_exact(-x, FRAC_1_SQRT_2);
    let correction = rest - x * FRAC_1_SQRT_2_REST;
    0.5 * (erfc(scaled) - correction * TWO_OVER_SQRT_PI * exp(-scaled * scaled))
}

/// Logarithm of [`normal_cdf`], without underflow for any finite x.
pub fn ln_normal_cdf(x: f64) -> f64 {
    if x > 1.0 {
        return ln_1p(-normal_cdf(-x));
    }
    if x > -20.0 {
        return ln(normal_cdf(x));
    }
    // Asymptotic series 1 - 1/x^2 + 3/x^4 - ... (Abramowitz & Stegun 26.2.12): at x = -20 ten terms give full precision.
    let (mut series, mut term) = (1.0, 1.0);
    for k in 0..10 {
        term *= -f64::from(2 * k + 1) / (x * x);
        series += term;
    }
    -0.5 * x * x - LN_SQRT_TWO_PI - ln(-x) + ln(series)
}

/// Logarithm of the probability that a standard normal variable is between `lower` and `upper`; minus infinity when empty.
pub fn ln_normal_interval(lower: f64, upper: f64) -> f64 {
    if lower.is_nan() || upper.is_nan() || lower >= upper {
        return f64::NEG_INFINITY;
    }
    // The half line that holds the smaller tail, so that the difference keeps its digits.
    let (a, b) = if lower + upper > 0.0 { (-upper, -lower) } else { (lower, upper) };
    let (middle, width) = (0.5 * (a + b), b - a);
    if width * middle.abs().max(1.0) < 1e-3 {
        // Taylor about the middle; the next term is of order width^4 / 1920.
        let curvature = (middle * middle - 1.0) * width * width / 24.0;
        return -0.5 * middle * middle - LN_SQRT_TWO_PI + ln(width) + ln_1p(curvature);
    }
    let top = ln_normal_cdf(b);
    if a == f64::NEG_INFINITY { top } else { top + ln(-exp_m1(ln_normal_cdf(a) - top)) }
}

/// The x below which a standard normal variable lies with the given probability in (0, 1)
/// (Wichura 1988, algorithm AS 241, PPND16: relative error about 1e-16; exactly odd about 0.5).
pub fn normal_quantile(probability: f64) -> f64 {
    let centred = probability - 0.5;
    if centred.abs() <= CENTRAL {
        normal_quantile_centred(centred)
    } else if centred < 0.0 {
        -tail((-ln(probability)).sqrt())
    } else {
        tail((-ln(1.0 - probability)).sqrt())
    }
}

/// [`normal_quantile`] at probability `0.5 + centred`, accurate for the smallest `centred`.
pub fn normal_quantile_centred(centred: f64) -> f64 {
    if centred.abs() > CENTRAL {
        return normal_quantile(0.5 + centred);
    }
    let r = CENTRAL * CENTRAL - centred * centred;
    centred * ratio(&CENTRAL_NUMERATOR, &CENTRAL_DENOMINATOR, r)
}

/// [`normal_quantile`] of a probability given by its logarithm (below 0), for probabilities too small to write down.
pub fn normal_quantile_of_ln(ln_probability: f64) -> f64 {
    if ln_probability > -700.0 {
        return normal_quantile(exp(ln_probability));
    }
    // Newton's method on the logarithm, which is nearly -x^2 / 2 here; Mills' ratio is x / (1 - 1 / x^2 ...) to 1e-6.
    let mut x = -(-2.0 * ln_probability).sqrt();
    for _ in 0..8 {
        let slope = -x - 1.0 / x;
        x -= (ln_normal_cdf(x) - ln_probability) / slope;
    }
    x
}

/// Half width of the central range of probabilities.
const CENTRAL: f64 = 0.425;

/// The upper tail's quantile from `r = sqrt(-ln(tail probability))`.
fn tail(r: f64) -> f64 {
    if r <= 5.0 {
        ratio(&NEAR_NUMERATOR, &NEAR_DENOMINATOR, r - 1.6)
    } else {
        ratio(&FAR_NUMERATOR, &FAR_DENOMINATOR, r - 5.0)
    }
}

fn ratio(numerator: &[f64; 8], denominator: &[f64; 8], r: f64) -> f64 {
    let polynomial =
        |c: &[f64; 8]| ((((((c[7] * r + c[6]) * r + c[5]) * r + c[4]) * r + c[3]) * r + c[2]) * r + c[1]) * r + c[0];
    polynomial(numerator) / polynomial(denominator)
}

const CENTRAL_NUMERATOR: [f64; 8] = [
    3.387_132_872_796_366_5,
    1.331_416_678_917_843_8e2,
    1.971_590_950_306_551_3e3,
    1.373_169_376_550_946e4,
    4.592_195_393_154_987e4,
    6.726_577_092_700_87e4,
    3.343_057_558_358_813e4,
    2.509_080_928_730_122_7e3,
];
const CENTRAL_DENOMINATOR: [f64; 8] = [
    1.0,
    4.231_333_070_160_091e1,
    6.871_870_074_920_579e2,
    5.394_196_021_424_751e3,
    2.121_379_430_158_659_7e4,
    3.930_789_580_009_271e4,
    2.872_908_573_572_194_3e4,
    5.226_495_278_852_854e3,
];
const NEAR_NUMERATOR: [f64; 8] = [
    1.423_437_110_749_683_5,
    4.630_337_846_156_546,
    5.769_497_221_460_691,
    3.647_848_324_763_204_5,
    1.270_458_252_452_368_4,
    2.417_807_251_774_506e-1,
    2.272_384_498_926_918_4e-2,
    7.745_450_142_783_414e-4,
];
const NEAR_DENOMINATOR: [f64; 8] = [
    1.0,
    2.053_191_626_637_759,
    1.676_384_830_183_803_8,
    6.897_673_349_851e-1,
    1.481_039_764_274_800_8e-1,
    1.519_866_656_361_645_7e-2,
    5.475_938_084_995_345e-4,
    1.050_750_071_644_416_9e-9,
];
const FAR_NUMERATOR: [f64; 8] = [
    6.657_904_643_501_103,
    5.463_784_911_164_114,
    1.784_826_539_917_291_3,
    2.965_605_718_285_048_7e-1,
    2.653_218_952_657_612_4e-2,
    1.242_660_947_388_078_4e-3,
    2.711_555_568_743_487_6e-5,
    2.010_334_399_292_288_1e-7,
];
const FAR_DENOMINATOR: [f64; 8] = [
    1.0,
    5.998_322_065_558_879e-1,
    1.369_298_809_227_358e-1,
    1.487_536_129_085_061_5e-2,
    7.868_691_311_456_133e-4,
    1.846_318_317_510_054_8e-5,
    1.421_511_758_316_446e-7,
    2.044_263_103_389_939_8e-15,
];

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]
mod tests {
    use super::*;

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
}
