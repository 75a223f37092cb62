//! Sums of floating point numbers in a fixed order.

use super::functions::{exp, ln};

/// Sum in index order.
pub fn ordered(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |sum, value| sum + value)
}

/// A running sum with the rounding errors carried along (Neumaier 1974, Z. Angew. Math. Mech. 54, 39).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    /// Adds a value.
    #[inline]
    pub fn add(&mut self, value: f64) {
        let total = self.sum + value;
        self.lost +=
            if self.sum.abs() >= value.abs() { (self.sum - total) + value } else { (value - total) + self.sum };
        self.sum = total;
    }

    /// Adds another sum's total; the result depends on the order of merging, not on who did it.
    pub fn merge(&mut self, other: &Self) {
        self.add(other.sum);
        self.lost += other.lost;
    }

    /// The sum so far (infinities and NaN as a plain sum would give them).
    #[inline]
    pub fn value(&self) -> f64 {
        if self.sum.is_finite() { self.sum + self.lost } else { self.sum }
    }
}

impl FromIterator<f64> for CompensatedSum {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut sum = Self::default();
        values.into_iter().for_each(|value| sum.add(value));
        sum
    }
}

/// Compensated sum in index order.
pub fn compensated(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().collect::<CompensatedSum>().value()
}

/// `ln(sum of exp(values))` without overflow; minus infinity for no values.
pub fn log_sum_exp(values: &[f64]) -> f64 {
    let largest = values.iter().fold(f64::NEG_INFINITY, |m, &v| if v > m || v.is_nan() { v } else { m });
    if !largest.is_finite() {
        return largest;
    }
    largest + ln(compensated(values.iter().map(|v| exp(v - largest))))
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]
mod tests {
    use super::*;

    #[test]
    fn compensation_keeps_what_plain_sums_lose() {
        let values = [1.0, 1e100, 1.0, -1e100];
        assert_eq!(ordered(&values), 0.0);
        assert_eq!(compensated(values), 2.0);
        // A tenth ten million times: the plain sum is off by 1e-4.
        let sum = compensated(std::iter::repeat_n(0.1, 10_000_000));
        assert!((sum - 1e6).abs() < 1e-9, "{sum}");
        assert_eq!(compensated([f64::INFINITY, 1.0]), f64::INFINITY);
    }

    #[test]
    fn merged_sums_equal_one_sum() {
        let values: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.7).sin() * 1e8 + 1e-8).collect();
        let whole: CompensatedSum = values.iter().copied().collect();
        let mut merged: CompensatedSum = values[..333].iter().copied().collect();
        merged.merge(&values[333..].iter().copied().collect());
        assert!((whole.value() - merged.value()).abs() < 1e-14 * 1e8);
    }

    #[test]
    fn log_sum_exp_survives_large_and_small_terms() {
        assert!((log_sum_exp(&[1000.0, 1000.0]) - 1_000.693_147_180_56).abs() < 1e-12);
        assert!((log_sum_exp(&[-2000.0, -2001.0]) + 1_999.686_738_312_8).abs() < 1e-9);
        assert_eq!(log_sum_exp(&[]), f64::NEG_INFINITY);
        assert_eq!(log_sum_exp(&[f64::NEG_INFINITY; 2]), f64::NEG_INFINITY);
        assert!(log_sum_exp(&[1.0, f64::NAN]).is_nan());
    }
}
