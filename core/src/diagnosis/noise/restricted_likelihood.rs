//! What a fit has taken of the readings, and what that is worth under other noise.
//!
//! A fit takes up the slow part of correlated noise rather than the fast one, so that what it leaves looks too white. The restricted
//! likelihood (Patterson & Thompson 1971, Biometrika 58, 545) corrects for that: with the columns `X` of the fit and its errors `e`,
//! whitened by the noise that is tried, it is the likelihood of the errors with `b' A^-1 b / 2 - log |A| / 2` added,
//! `A = X'X`, `b = X'e`: the fit is made anew under that noise, and integrated over.

use crate::diagnosis::noise::estimate::{EstimatedNoise, SensorRows};
use crate::math::cholesky;
use crate::math::lanes::dot;

/// Share of a column's square that is added to it: far above rounding, far below what data tell.
const RIDGE: f64 = 1e-12;

/// A fit's columns and errors, by row: readings of open sensors in SI, all else in standard deviations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Taken {
    /// Of each parameter and effect that the fit left free.
    pub columns: Vec<Vec<f64>>,
    /// What the fit left.
    pub errors: Vec<f64>,
}

impl Taken {
    /// What is to be added to the log likelihood of the errors where the sensors have these noises, but for a constant; 0 where a column
    /// is nothing.
    pub fn correction(&self, series: &[SensorRows], noises: &[EstimatedNoise]) -> f64 {
        let k = self.columns.len();
        let whitened = |column: &[f64]| {
            let mut column = column.to_vec();
            for (series, noise) in series.iter().zip(noises) {
                let mut sensor_values: Vec<f64> = series.rows.iter().map(|&row| column[row]).collect();
                noise.whiten(&series.times_s, &mut sensor_values);
                for (&row, value) in series.rows.iter().zip(sensor_values) {
                    column[row] = value;
                }
            }
            column
        };
        let errors = whitened(&self.errors);
        let columns: Vec<Vec<f64>> = self.columns.iter().map(|column| whitened(column)).collect();
        let mut matrix = vec![0.0; k * k];
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns[..=i].iter().enumerate() {
                let product = dot(a, b);
                (matrix[i * k + j], matrix[j * k + i]) = (product, product);
            }
        }
        // Columns of very different size would spoil the factor.
        let scales: Vec<f64> = (0..k).map(|i| matrix[i * k + i].sqrt()).collect();
        if scales.iter().any(|scale| !(*scale > 0.0)) {
            return 0.0;
        }
        let mut scaled: Vec<f64> =
            (0..k * k).map(|place| matrix[place] / (scales[place / k] * scales[place % k])).collect();
        // Columns that act only together would have a factor under one noise and none under the next.
        (0..k).for_each(|i| scaled[i * k + i] += RIDGE);
        if cholesky::factor(&mut scaled, k).is_err() {
            return 0.0;
        }
        let mut b: Vec<f64> = columns.iter().zip(&scales).map(|(column, scale)| dot(column, &errors) / scale).collect();
        cholesky::solve_lower(&scaled, &mut b);
        let log_scales: f64 = scales.iter().map(|scale| crate::math::functions::ln(*scale)).sum();
        0.5 * dot(&b, &b) - 0.5 * cholesky::log_determinant(&scaled, k) - log_scales
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::random::StreamKey;

    /// Of the errors of a white fit the restricted likelihood under correlated noise, against the dense formula.
    #[test]
    fn it_is_the_restricted_likelihood() {
        let (rows, columns) = (40, 3);
        let times_s: Vec<f64> = (0..rows).map(|row| 60.0 * f64::from(row as u32)).collect();
        let mut stream = StreamKey::new(5, "taken", "test").stream(0);
        // 1, t and t^2.
        let x = DMatrix::from_fn(rows, columns, |row, column| (0..column).map(|_| row as f64 / 40.0).product());
        let y = DVector::from_fn(rows, |_, _| stream.normal());
        let fitted = (x.transpose() * &x).lu().solve(&(x.transpose() * &y)).expect("independent columns");
        let errors = &y - &x * fitted;
        let series = SensorRows { measurement: 0, sensor: 0, rows: (0..rows).collect(), times_s: times_s.clone() };
        let taken = Taken {
            columns: (0..columns).map(|column| x.column(column).iter().copied().collect()).collect(),
            errors: errors.iter().copied().collect(),
        };
        let mut sums = Vec::new();
        for noise in [
            EstimatedNoise::white(1.3),
            EstimatedNoise { sigma: 0.9, correlation_time_s: Some(400.0), white: Some(0.4) },
            EstimatedNoise { sigma: 1.1, correlation_time_s: Some(150.0), white: None },
        ] {
            let mut whitened = taken.errors.clone();
            let scales = noise.whiten(&times_s, &mut whitened);
            let restricted = scales - 0.5 * dot(&whitened, &whitened)
                + taken.correction(std::slice::from_ref(&series), std::slice::from_ref(&noise));
            let covariance = DMatrix::from_fn(rows, rows, |a, b| {
                let slow = noise
                    .correlation_time_s
                    .map_or(f64::from(u8::from(a == b)), |time| libm::exp(-(times_s[a] - times_s[b]).abs() / time));
                let white = noise.white.unwrap_or(0.0);
                noise.sigma * noise.sigma * slow + if a == b { white * white } else { 0.0 }
            });
            let inverse = covariance.clone().try_inverse().expect("positive");
            let information = x.transpose() * &inverse * &x;
            let fit = information.clone().lu().solve(&(x.transpose() * &inverse * &y)).expect("independent columns");
            let left = &y - &x * fit;
            let dense = -0.5 * libm::log(covariance.determinant())
                - 0.5 * libm::log(information.determinant())
                - 0.5 * (left.transpose() * &inverse * &left)[(0, 0)];
            sums.push(restricted - dense);
        }
        assert!(sums.iter().all(|sum| (sum - sums[0]).abs() < 1e-8), "{sums:?}");
    }
}
