//! The inner average of nested Monte Carlo: `ln (1/M) sum_j exp(-|z - g_j|^2 / 2)` over whitened predictions `g_j`.
//!
//! Ryan (2003, J. Comput. Graph. Stat. 12, 585); Huan & Marzouk (2013, J. Comput. Phys. 232, 288). The logarithm of an
//! average over M samples is too low by about a constant over M (Rainforth et al. 2018, ICML); the averages over both
//! halves show that bias (Goda, Hironaka & Iwamoto 2020, SIAM J. Sci. Comput. 42, A286).
//!
//! Predictions are sorted along one reading, and terms below 1e-16 are left out, so that an average costs what lies near
//! `z` and no more.

use crate::math::functions::{exp, ln};

/// Half the squared distance beyond which a term is below 1e-16.
const CUT: f64 = 36.841_361_487_904_73;
/// Terms left out sum to 1e-16 a sample at most: sums above this bound are good to 1e-8 with a million samples.
const LEAST: f64 = 1e-2;

/// An average and those of its halves, in logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogMean {
    /// Over all samples.
    pub whole: f64,
    /// Over each half.
    pub halves: [f64; 2],
    /// Effective number of samples `(sum w)^2 / sum w^2`.
    pub effective: f64,
}

impl LogMean {
    /// From the sums of terms and of their squares over two halves of equal size, scaled by `exp(-shift)`.
    pub fn of_sums(sums: [f64; 2], squares: f64, size: usize, shift: f64) -> Self {
        let half = size.max(1) as f64;
        let sum = sums[0] + sums[1];
        Self {
            whole: shift + ln(sum / (2.0 * half)),
            halves: sums.map(|sum| shift + ln(sum / half)),
            effective: if squares > 0.0 { sum * sum / squares } else { 0.0 },
        }
    }

    /// How much the logarithm rises from half to all samples: never below 0, and the bias that is left where the bias
    /// is inversely proportional to the number of samples.
    pub fn rise(&self) -> f64 {
        self.whole - 0.5 * (self.halves[0] + self.halves[1])
    }
}

/// Whitened predictions in two halves, each sorted along the reading that spreads most.
#[derive(Clone, Debug)]
pub struct Inner {
    readings: usize,
    lead: usize,
    size: usize,
    halves: [Half; 2],
}

#[derive(Clone, Debug, Default)]
struct Half {
    /// The leading reading, ascending.
    lead: Vec<f64>,
    /// The other readings, sample by sample, in the same order.
    others: Vec<f64>,
}

impl Inner {
    /// Sorts `predictions` (`samples x readings`, whitened); the first half of the samples is one half. A sample with a
    /// number that is not finite has no weight, but counts. `None` without two samples.
    pub fn new(predictions: &[f64], readings: usize) -> Option<Self> {
        let size = predictions.len().checked_div(readings)? / 2;
        if size == 0 {
            return None;
        }
        let rows: Vec<&[f64]> = predictions.chunks_exact(readings).take(2 * size).collect();
        let spread = |reading: usize| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for value in rows.iter().map(|row| row[reading]).filter(|value| value.is_finite()) {
                (low, high) = (low.min(value), high.max(value));
            }
            high - low
        };
        let mut lead = 0;
        for reading in 1..readings {
            if spread(reading) > spread(lead) {
                lead = reading;
            }
        }
        let half = |rows: &[&[f64]]| {
            let mut kept: Vec<&[f64]> =
                rows.iter().copied().filter(|row| row.iter().all(|value| value.is_finite())).collect();
            kept.sort_by(|a, b| a[lead].total_cmp(&b[lead]));
            let others = |row: &&[f64]| -> Vec<f64> {
                row.iter().enumerate().filter(|(reading, _)| *reading != lead).map(|(_, value)| *value).collect()
            };
            Half { lead: kept.iter().map(|row| row[lead]).collect(), others: kept.iter().flat_map(others).collect() }
        };
        Some(Self { readings, lead, size, halves: [half(&rows[..size]), half(&rows[size..])] })
    }

    /// The average for one set of whitened readings; `point` is room for as many numbers as readings.
    pub fn log_mean(&self, readings: &[f64], point: &mut [f64]) -> LogMean {
        point[0] = readings[self.lead];
        let others = readings.iter().enumerate().filter(|(reading, _)| *reading != self.lead).map(|(_, value)| value);
        for (slot, value) in point[1..].iter_mut().zip(others) {
            *slot = *value;
        }
        let mut sums = [0.0; 2];
        let mut squares = 0.0;
        for (sum, half) in sums.iter_mut().zip(&self.halves) {
            let (half_sum, half_squares) = half.near(point, self.readings - 1);
            *sum = half_sum;
            squares += half_squares;
        }
        if sums[0] >= LEAST && sums[1] >= LEAST {
            return LogMean::of_sums(sums, squares, self.size, 0.0);
        }
        // No sample lies near: all terms, scaled by the largest.
        let nearest = self.halves.iter().map(|half| half.nearest(point, self.readings - 1));
        let shift = -nearest.fold(f64::INFINITY, f64::min);
        if !shift.is_finite() {
            return LogMean { whole: f64::NEG_INFINITY, halves: [f64::NEG_INFINITY; 2], effective: 0.0 };
        }
        squares = 0.0;
        for (sum, half) in sums.iter_mut().zip(&self.halves) {
            *sum = 0.0;
            for sample in 0..half.lead.len() {
                let term = exp(-shift - half.half_square(sample, point, self.readings - 1));
                *sum += term;
                squares += term * term;
            }
        }
        LogMean::of_sums(sums, squares, self.size, shift)
    }
}

impl Half {
    /// Sum of the terms above 1e-16, and of their squares.
    fn near(&self, point: &[f64], others: usize) -> (f64, f64) {
        let reach = (2.0 * CUT).sqrt();
        let first = self.lead.partition_point(|value| *value < point[0] - reach);
        let end = first + self.lead[first..].partition_point(|value| *value <= point[0] + reach);
        let (mut sum, mut squares) = (0.0, 0.0);
        if others == 0 {
            for value in &self.lead[first..end] {
                let apart = point[0] - value;
                let term = exp(-0.5 * apart * apart);
                sum += term;
                squares += term * term;
            }
            return (sum, squares);
        }
        let rows = self.others[first * others..end * others].chunks_exact(others);
        for (value, row) in self.lead[first..end].iter().zip(rows) {
            let apart = point[0] - value;
            let mut half_square = 0.5 * apart * apart;
            for (value, reading) in row.iter().zip(&point[1..]) {
                half_square += 0.5 * (reading - value) * (reading - value);
                if half_square > CUT {
                    break;
                }
            }
            if half_square <= CUT {
                let term = exp(-half_square);
                sum += term;
                squares += term * term;
            }
        }
        (sum, squares)
    }

    fn half_square(&self, sample: usize, point: &[f64], others: usize) -> f64 {
        let apart = point[0] - self.lead[sample];
        let row = &self.others[sample * others..(sample + 1) * others];
        0.5 * apart * apart + row.iter().zip(&point[1..]).map(|(a, b)| 0.5 * (a - b) * (a - b)).sum::<f64>()
    }

    fn nearest(&self, point: &[f64], others: usize) -> f64 {
        (0..self.lead.len()).map(|sample| self.half_square(sample, point, others)).fold(f64::INFINITY, f64::min)
    }
}
