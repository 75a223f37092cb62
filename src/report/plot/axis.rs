//! Axes: ranges, ticks at round numbers, and their labels.

use crate::math::functions::{ln, pow};
use crate::report::number::fixed;

/// An axis: what stands beside it and, if wanted, its range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Title with unit, such as `time [s]`.
    pub title: String,
    /// Range; otherwise it follows from the data.
    pub range: Option<(f64, f64)>,
    /// What stands at 1, 2, ... instead of numbers; empty for numbers.
    pub names: Vec<String>,
    /// Largest value that there can be, such as 1 of a share: neither the range of the data nor a tick goes beyond.
    pub most: Option<f64>,
    /// Whether it is one of probabilities near 1.
    pub is_probability: bool,
}

impl Axis {
    /// An axis whose range follows from the data.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// An axis of a given range.
    pub fn over(title: impl Into<String>, from: f64, to: f64) -> Self {
        Self { title: title.into(), range: Some((from, to)), ..Self::default() }
    }

    /// The same axis, which ends at the largest value that there can be.
    pub fn up_to(self, most: f64) -> Self {
        Self { most: Some(most), ..self }
    }

    /// A range as far as there can be values.
    pub fn within(&self, (low, high): (f64, f64)) -> (f64, f64) {
        (low, self.most.map_or(high, |most| high.min(most)))
    }

    /// An axis of probabilities, on which each nine more has the same room: 0.9, 0.99, 0.999.
    pub fn of_probability(title: impl Into<String>) -> Self {
        Self { is_probability: true, ..Self::over(title, 0.0, 1.0) }
    }

    /// An axis of names, the first at 1, with half a step of room at either end.
    pub fn of_names(title: impl Into<String>, names: Vec<String>) -> Self {
        Self { title: title.into(), range: Some((0.5, names.len() as f64 + 0.5)), names, ..Self::default() }
    }

    /// The ticks of a horizontal axis with this scale.
    pub fn ticks(&self, scale: &Scale) -> Vec<(f64, String)> {
        if self.names.is_empty() {
            return scale.ticks();
        }
        let room = (scale.to - scale.from).abs() / self.names.len() as f64 - 20.0;
        let names = self.names.iter().enumerate();
        names
            .map(|(position, name)| (position as f64 + 1.0, super::canvas::fitted(name, super::canvas::TEXT, room)))
            .collect()
    }
}

/// Probabilities nearer to 1 than this are drawn as 1.
const NEAREST_TO_1: f64 = 1e-4;
/// Ticks of an axis of probabilities.
const PROBABILITIES: [(f64, &str); 5] = [(0.0, "0"), (0.9, "0.9"), (0.99, "0.99"), (0.999, "0.999"), (1.0, "1")];

/// A map of a range of values to pixels, with ticks: linear, but for probabilities.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    from: f64,
    to: f64,
    step: f64,
    is_probability: bool,
}

impl Scale {
    /// A scale of `low..high` on the pixels `from..to` with about `ticks` ticks. A range that is empty or no number
    /// becomes one of width 1 about its middle, or about zero.
    pub fn new((low, high): (f64, f64), (from, to): (f64, f64), ticks: usize) -> Self {
        let (mut low, mut high) = if low.is_finite() && high.is_finite() { (low, high) } else { (0.0, 1.0) };
        let least = 1e-12 * low.abs().max(high.abs());
        if high - low <= least || !(high - low).is_finite() {
            let half = if low == 0.0 { 0.5 } else { (0.01 * low.abs()).clamp(1e-9, 0.5) };
            let middle = low;
            (low, high) = (middle - half, middle + half);
        }
        let step = round_step((high - low) / ticks.max(1) as f64);
        Self { low, high, from, to, step, is_probability: false }
    }

    /// A scale of probabilities from 0 to 1 on pixels.
    pub fn of_probability(pixels: (f64, f64)) -> Self {
        Self { is_probability: true, ..Self::new((0.0, 1.0), pixels, 1) }
    }

    /// Where a value lies, pixels; kept within the scale.
    pub fn at(&self, value: f64) -> f64 {
        if value.is_nan() {
            return f64::NAN;
        }
        let share = if self.is_probability {
            // Nines: the logarithm of what is lacking to 1.
            ln((1.0 - value).clamp(NEAREST_TO_1, 1.0)) / ln(NEAREST_TO_1)
        } else {
            ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
        };
        self.from + share * (self.to - self.from)
    }

    /// Whether a value lies on the scale.
    pub fn holds(&self, value: f64) -> bool {
        let slack = 1e-9 * (self.high - self.low);
        value >= self.low - slack && value <= self.high + slack
    }

    /// Decimals that show the ticks in full.
    pub fn decimals(&self) -> usize {
        decimals_of(self.step)
    }

    /// Ticks and their labels.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        if self.is_probability {
            return PROBABILITIES.map(|(value, label)| (value, label.to_owned())).into();
        }
        let first = (self.low / self.step - 1e-6).ceil();
        let count = (((self.high / self.step + 1e-6).floor() - first).max(0.0) as usize).min(40);
        let decimals = decimals_of(self.step);
        let scale = self.low.abs().max(self.high.abs());
        (0..=count)
            .map(|i| {
                let value = (first + i as f64) * self.step;
                let label = if scale >= 1e6 || (scale < 1e-4 && scale > 0.0) {
                    crate::report::number::significant(value, 3)
                } else {
                    fixed(value, decimals)
                };
                (value, label)
            })
            .collect()
    }
}

/// The next of 1, 2, 5 times a power of ten that is not below `raw`.
fn round_step(raw: f64) -> f64 {
    if raw <= 0.0 || !raw.is_finite() {
        return 1.0;
    }
    let power = pow(10.0, (ln(raw) / ln(10.0)).floor());
    for factor in [1.0, 2.0, 2.5, 5.0, 10.0] {
        if factor * power >= raw * 0.999 {
            return factor * power;
        }
    }
    10.0 * power
}

/// Decimals that show a step in full.
fn decimals_of(step: f64) -> usize {
    let mut shown = step;
    for decimals in 0..9 {
        if (shown - shown.round()).abs() < 1e-6 * shown.abs() {
            return decimals;
        }
        shown *= 10.0;
    }
    9
}

/// Smallest range that holds all finite values; `None` without any.
pub fn range_of(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().filter(|v| v.is_finite()).fold(None, |range, v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

/// A range widened by a share of its width on both sides.
pub fn widened((low, high): (f64, f64), share: f64) -> (f64, f64) {
    let margin = share * (high - low);
    (low - margin, high + margin)
}
