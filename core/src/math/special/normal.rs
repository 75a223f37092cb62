//! The standard normal distribution: density, probabilities, quantiles, accurate far in both tails.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::math::functions::{erfc, exp, exp_m1, ln, ln_1p};

/// `ln(2 pi) / 2`.
pub const LN_SQRT_TWO_PI: f64 = 0.918_938_533_204_672_7;
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
