//! What samplers learn while they warm up: the covariance of the draws, and a step size.

use serde::{Deserialize, Serialize};

use crate::math::functions::{exp, ln, pow};

/// Running mean and covariance (Welford 1962).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunningCovariance {
    count: u64,
    mean: Vec<f64>,
    products: Vec<f64>,
    before: Vec<f64>,
}

impl RunningCovariance {
    /// Nothing seen, of this dimension.
    pub fn new(dimension: usize) -> Self {
        Self {
            count: 0,
            mean: vec![0.0; dimension],
            products: vec![0.0; dimension * dimension],
            before: vec![0.0; dimension],
        }
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.count = 0;
        self.mean.fill(0.0);
        self.products.fill(0.0);
    }

    /// Takes in a point.
    #[inline]
    pub fn add(&mut self, point: &[f64]) {
        let n = point.len();
        self.count += 1;
        let share = 1.0 / self.count as f64;
        for i in 0..n {
            self.before[i] = point[i] - self.mean[i];
            self.mean[i] += share * self.before[i];
        }
        for i in 0..n {
            let after = point[i] - self.mean[i];
            for j in 0..=i {
                self.products[i * n + j] += after * self.before[j];
            }
        }
    }

    /// Points seen.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean of the points.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Writes the covariance (divisor count - 1), symmetric. Needs two points.
    pub fn covariance(&self, covariance: &mut [f64]) {
        let n = self.mean.len();
        let scale = 1.0 / (self.count.max(2) - 1) as f64;
        for i in 0..n {
            for j in 0..=i {
                let value = scale * self.products[i * n + j];
                covariance[i * n + j] = value;
                covariance[j * n + i] = value;
            }
        }
    }
}

/// Step size by dual averaging (Hoffman & Gelman 2014, section 3.2: gamma 0.05, t0 10, kappa 0.75).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DualAveraging {
    target: f64,
    anchor: f64,
    count: f64,
    error: f64,
    log_step: f64,
    log_averaged: f64,
}

impl DualAveraging {
    /// Begins at a step size, aiming at an acceptance.
    pub fn new(step: f64, target: f64) -> Self {
        Self { target, anchor: ln(10.0 * step), count: 0.0, error: 0.0, log_step: ln(step), log_averaged: 0.0 }
    }

    /// Takes in the mean acceptance probability of a transition.
    pub fn update(&mut self, acceptance: f64) {
        self.count += 1.0;
        let weight = 1.0 / (self.count + 10.0);
        self.error += weight * (self.target - acceptance - self.error);
        self.log_step = self.anchor - self.error * self.count.sqrt() / 0.05;
        let decay = pow(self.count, -0.75);
        self.log_averaged += decay * (self.log_step - self.log_averaged);
    }

    /// Step size while adapting.
    pub fn step(&self) -> f64 {
        exp(self.log_step)
    }

    /// Step size to keep.
    pub fn averaged(&self) -> f64 {
        if self.count > 0.0 { exp(self.log_averaged) } else { self.step() }
    }
}

/// Where the windows of a warm-up end: an opening for the step size, windows that double for the covariance, a close for
/// the step size (the plan of Stan's reference manual: 75, 25, 50, doubled; scaled to 15 %, 75 %, 10 % of a short one).
#[derive(Clone, Debug)]
pub struct Windows {
    opening: u64,
    close_from: u64,
    /// The transitions at which they end, ascending.
    pub ends: Vec<u64>,
}

impl Windows {
    /// The plan of a warm-up of so many transitions.
    pub fn new(warm_up: u64) -> Self {
        let (opening, first, close) = if warm_up >= 150 {
            (75, 25, 50)
        } else {
            let opening = warm_up * 15 / 100;
            let close = warm_up / 10;
            (opening, warm_up - opening - close, close)
        };
        let close_from = warm_up - close;
        let mut ends = Vec::new();
        let mut end = opening;
        let mut size = first.max(1);
        while end < close_from {
            // A last window takes in what would be too short for the next, doubled one.
            let next_size = 2 * size;
            end = if end + size + next_size > close_from { close_from } else { end + size };
            ends.push(end);
            size = next_size;
        }
        Self { opening, close_from, ends }
    }

    /// Whether the state after this transition (counted from 0) belongs to a covariance window.
    pub fn collects(&self, transition: u64) -> bool {
        transition >= self.opening && transition < self.close_from
    }

    /// Whether a covariance window ends with this transition.
    pub fn ends(&self, transition: u64) -> bool {
        self.ends.contains(&(transition + 1))
    }
}
