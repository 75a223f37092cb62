//! Drawing numbers that people could have written: three significant digits.

use crate::math::functions::{exp, ln};
use crate::random::{Stream, StreamKey};

/// A stream of draws.
#[derive(Clone, Debug)]
pub struct Draw {
    stream: Stream,
}

impl Draw {
    /// The draws of a purpose for one case.
    pub fn new(seed: u64, purpose: &str, case: u64) -> Self {
        Self { stream: StreamKey::new(seed, "laboratory", purpose).stream(case) }
    }

    /// A share in 0 to 1.
    pub fn share(&mut self) -> f64 {
        self.stream.uniform()
    }

    /// A standard normal number.
    pub fn normal(&mut self) -> f64 {
        self.stream.normal()
    }

    /// Whether something of this probability happens.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.stream.uniform() < probability
    }

    /// A position in a list of this length (0 where it is empty).
    pub fn position(&mut self, length: usize) -> usize {
        self.stream.below(length)
    }

    /// A whole number between two, both included.
    pub fn whole(&mut self, least: usize, most: usize) -> usize {
        least + self.stream.below(most.saturating_sub(least) + 1)
    }

    /// A number between two, three digits.
    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        let u = self.stream.uniform();
        short(lower + u * (upper - lower))
    }

    /// A number between two above 0, uniform in the logarithm, three digits.
    pub fn scale(&mut self, lower: f64, upper: f64) -> f64 {
        let u = self.stream.uniform();
        short(exp(ln(lower) + u * ln(upper / lower)))
    }
}

/// A number with three significant digits.
pub fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// A number with so many decimals.
pub fn decimals(value: f64, count: usize) -> f64 {
    format!("{value:.count$}").parse().unwrap_or(value)
}
