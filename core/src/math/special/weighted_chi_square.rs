//! Tails of a weighted sum of squares of standard normal variables, also over an estimated variance.
//!
//! The tail is an integral of the moment generating function along a path round its pole (Rice 1980, SIAM J. Sci. Stat.
//! Comput. 1, 438), here along a parabola through the saddle point (Helstrom 1983, IEEE Trans. Aerosp. Electron. Syst. 19,
//! 428), on which the integrand falls so fast that a plain sum of equal steps gives it to all but rounding.

use crate::math::functions::{atan2, cos, exp, ln, sin, sqrt};

/// Probability that `sum of weight_i x_i^2` exceeds `value`, with independent standard normal `x`: relative error below 1e-8
/// however far in the tail. With `degrees` d the `x` are divided by the root of a common, independent chi-square over d.
/// Weights below 0 or not finite count as 0; without weights above 0 the sum is 0.
pub fn weighted_chi_square_sf(value: f64, weights: &[f64], degrees: Option<f64>) -> f64 {
    if value.is_nan() {
        return f64::NAN;
    }
    let largest = weights.iter().copied().filter(|w| w.is_finite()).fold(0.0, f64::max);
    if !(value > 0.0) {
        return 1.0;
    }
    if largest == 0.0 || value == f64::INFINITY {
        return 0.0;
    }
    let sum = Sum {
        weights: weights.iter().filter(|w| **w > 1e-14 * largest && w.is_finite()).map(|w| w / largest).collect(),
        value: value / largest,
        degrees,
    };
    sum.tail()
}

/// The value that the sum exceeds with a probability in (0, 1).
pub fn weighted_chi_square_upper(probability: f64, weights: &[f64], degrees: Option<f64>) -> f64 {
    if !(0.0 < probability && probability < 1.0) {
        return f64::NAN;
    }
    let target = ln(probability);
    let excess = |x: f64| ln(weighted_chi_square_sf(x, weights, degrees).max(1e-320)) - target;
    let (mut lower, mut upper) = (0.0, weights.iter().sum::<f64>());
    if !(upper > 0.0) {
        return 0.0;
    }
    let (mut at_lower, mut at_upper) = (-target, excess(upper));
    for _ in 0..400 {
        if at_upper <= 0.0 {
            break;
        }
        (lower, at_lower) = (upper, at_upper);
        upper *= 2.0;
        at_upper = excess(upper);
    }
    // False position with halved ends (Dowell & Jarratt 1971): the logarithm of the tail is nearly straight.
    for _ in 0..100 {
        let x = (lower * at_upper - upper * at_lower) / (at_upper - at_lower);
        let at = excess(x);
        if at.abs() < 1e-10 || !(upper - lower > 1e-13 * upper) {
            return x;
        }
        if at > 0.0 {
            (lower, at_lower) = (x, at);
            at_upper *= 0.5;
        } else {
            (upper, at_upper) = (x, at);
            at_lower *= 0.5;
        }
    }
    0.5 * (lower + upper)
}

struct Sum {
    /// The largest is 1.
    weights: Vec<f64>,
    value: f64,
    degrees: Option<f64>,
}

impl Sum {
    /// Derivatives one to three, on the real axis, of `ln M(t) - ln |t|`, M being that of the sum less the value.
    fn derivatives(&self, t: f64) -> [f64; 3] {
        let (mut first, mut second, mut third) = (-1.0 / t, 1.0 / (t * t), -2.0 / (t * t * t));
        for w in &self.weights {
            let ratio = w / (1.0 - 2.0 * t * w);
            first += ratio;
            second += 2.0 * ratio * ratio;
            third += 8.0 * ratio * ratio * ratio;
        }
        if let Some(d) = self.degrees {
            let ratio = self.value / d / (1.0 + 2.0 * t * self.value / d);
            first -= d * ratio;
            second += 2.0 * d * ratio * ratio;
            third -= 8.0 * d * ratio * ratio * ratio;
        } else {
            first -= self.value;
        }
        [first, second, third]
    }

    /// `M(t) / t` times `exp(-top)` at a complex t above the real axis. Each root is the principal one: its radicand lies
    /// on one side of the real axis all along the path.
    fn integrand(&self, (re, im): (f64, f64), top: f64) -> (f64, f64) {
        let mut product = (1.0, 0.0);
        for w in &self.weights {
            product = times(product, root((1.0 - 2.0 * w * re, -2.0 * w * im)));
        }
        let (a, b) = times(product, (re, im));
        // ln and angle of what is left.
        let (size, angle) = match self.degrees {
            Some(d) => {
                let share = 2.0 * self.value / d;
                let (x, y) = (1.0 + share * re, share * im);
                (-0.25 * d * ln(x * x + y * y) - top, -0.5 * d * atan2(y, x))
            }
            None => (-self.value * re - top, -self.value * im),
        };
        let size = exp(size) / (a * a + b * b);
        times((a, -b), (size * cos(angle), size * sin(angle)))
    }

    /// `ln M(t) - ln |t|` on the real axis, between the poles.
    fn exponent(&self, t: f64) -> f64 {
        let roots: f64 = self.weights.iter().map(|w| ln(1.0 - 2.0 * w * t)).sum();
        let rest = match self.degrees {
            Some(d) => 0.5 * d * ln(1.0 + 2.0 * t * self.value / d),
            None => self.value * t,
        };
        -ln(t.abs()) - 0.5 * roots - rest
    }

    fn tail(&self) -> f64 {
        // The mean lies at the pole: on its far side the complement is the sum of like terms.
        let mean: f64 = self.weights.iter().sum();
        let above = self.value >= mean;
        let (mut left, mut right) =
            if above { (0.0, 0.5) } else { (self.degrees.map_or(f64::NEG_INFINITY, |d| -0.5 * d / self.value), 0.0) };
        if left == f64::NEG_INFINITY {
            left = -1.0;
            while self.derivatives(left)[0] > 0.0 {
                left *= 2.0;
            }
        }
        for _ in 0..200 {
            let middle = 0.5 * (left + right);
            if middle == left || middle == right {
                break;
            }
            if self.derivatives(middle)[0] > 0.0 { right = middle } else { left = middle }
        }
        let saddle = 0.5 * (left + right);
        let [_, second, third] = self.derivatives(saddle);
        let width = 1.0 / sqrt(second);
        let bend = (third / (3.0 * second)).max(0.2 / width);
        let top = self.exponent(saddle);
        // Trapezium rule; the middle counts half as the two halves of the path are conjugate.
        let step = 0.1 * width;
        let mut sum = 0.5 * if above { 1.0 } else { -1.0 };
        for k in 1..4000 {
            let y = f64::from(k) * step;
            let (real, imaginary) = self.integrand((saddle + 0.5 * bend * y * y, y), top);
            sum += real + bend * y * imaginary;
            if (real.abs() + imaginary.abs()) * (1.0 + bend * y) < 1e-17 {
                break;
            }
        }
        let integral = sum * step * exp(top) / std::f64::consts::PI;
        (if above { integral } else { 1.0 + integral }).clamp(0.0, 1.0)
    }
}

/// Product of two complex numbers.
fn times((a, b): (f64, f64), (c, d): (f64, f64)) -> (f64, f64) {
    (a * c - b * d, a * d + b * c)
}

/// Principal root of a complex number that is not 0.
fn root((re, im): (f64, f64)) -> (f64, f64) {
    let long = sqrt(0.5 * (sqrt(re * re + im * im) + re.abs()));
    let short = 0.5 * im / long;
    if re >= 0.0 { (long, short) } else { (short.abs(), if im < 0.0 { -long } else { long }) }
}
