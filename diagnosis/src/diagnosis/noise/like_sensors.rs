//! White noise of like sensors over a few steady phases.
//!
//! Sensors of one measurement with one prior are of one kind: their noise is alike, so that each is most probable about a common
//! size, and that size under the prior. A handful of phases tells little of a sensor alone: a model that is wrong at one place
//! would show there as noise many times that of its neighbours, and the effect that explains it as nothing.

use crate::math::functions::{exp, ln};
use crate::random::Distribution;

/// Standard deviation of the logarithms of like sensors' sizes about the common one.
pub const ALIKE: f64 = 0.3;
/// Probability beyond each end of a prior that is not looked at.
const PRIOR_END: f64 = 1e-4;
/// How many times beyond the sensors' own sizes the common one is sought without a prior.
const BEYOND: f64 = 3.0;
/// Steps of a search: to a millionth of its range.
const STEPS: usize = 30;

/// Errors of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Their number.
    pub count: f64,
    /// The sum of their squares, SI, as if the fit took none.
    pub square: f64,
}

impl Errors {
    /// Their size alone, SI.
    fn size(&self) -> f64 {
        (self.square / self.count.max(1.0)).sqrt().max(f64::MIN_POSITIVE.sqrt())
    }

    /// The most probable size about a common one, and the log posterior density there but for a constant.
    pub fn about(&self, common: f64) -> (f64, f64) {
        let log_posterior = |log_size: f64| {
            let (size, deviate) = (exp(log_size), (log_size - ln(common)) / ALIKE);
            -self.count * log_size - 0.5 * self.square / (size * size) - 0.5 * deviate * deviate
        };
        let [a, b] = [ln(self.size()), ln(common)];
        let log_size = highest(log_posterior, [a.min(b), a.max(b)]);
        (exp(log_size), log_posterior(log_size))
    }
}

/// The most probable sizes of like sensors, SI, whose common size has a prior.
pub fn sizes(sensors: &[Errors], prior: Option<&Distribution>) -> Vec<f64> {
    let own = sensors.iter().map(Errors::size);
    let (least, most) = own.fold((f64::INFINITY, 0.0_f64), |(least, most), size| (least.min(size), most.max(size)));
    if !(least <= most) {
        return Vec::new();
    }
    let ends = prior.map_or([least / BEYOND, most * BEYOND], |prior| {
        [PRIOR_END, 1.0 - PRIOR_END].map(|share| prior.quantile(share).max(f64::MIN_POSITIVE.sqrt()))
    });
    let log_posterior = |log_common: f64| {
        let common = exp(log_common);
        let of_prior = prior.map_or(0.0, |prior| prior.log_density(common) + log_common);
        of_prior + sensors.iter().map(|sensor| sensor.about(common).1).sum::<f64>()
    };
    let common = exp(highest(log_posterior, ends.map(ln)));
    sensors.iter().map(|sensor| sensor.about(common).0).collect()
}

/// Where a function with one maximum is highest between two ends, by golden section (Kiefer 1953, Proc. Am. Math. Soc. 4, 502).
fn highest(value: impl Fn(f64) -> f64, [mut from, mut to]: [f64; 2]) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    for _ in 0..STEPS {
        let (low, high) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
        if value(low) >= value(high) {
            to = high;
        } else {
            from = low;
        }
    }
    0.5 * (from + to)
}
