//! From replicates to an estimate with its standard error and its bias.

use serde::{Deserialize, Serialize};

use crate::math::special::student_t_quantile;
use crate::statistics::moments::Moments;

/// Effective inner samples below which an average is poor.
pub const FEW: f64 = 10.0;
/// Share of outer samples with a poor average up to which an estimate is good.
const GOOD_FEW: f64 = 0.1;
/// Mean number of effective inner samples from which on halving them shows the bias.
const LEAST_EFFECTIVE: f64 = 5.0;
/// A bias is small within this, and beyond it within three standard errors up to the next, nats.
const SMALL_BIAS: f64 = 0.02;
const LARGE_BIAS: f64 = 0.1;
/// The largest bias with which an estimate is still of use, nats.
const GREATEST_BIAS: f64 = 0.2;
/// Probability below three standard deviations of a normal distribution.
const THREE_SIGMA: f64 = 0.998_650_101_968_369_9;

/// Standard error of a mean, widened so that three of it cover as much as three of a normal distribution would: few
/// replicates know their own scatter badly (Student 1908, Biometrika 6, 1).
fn standard_error(moments: &Moments, count: usize) -> f64 {
    if count < 2 {
        return f64::INFINITY;
    }
    moments.mean_standard_error() * student_t_quantile(THREE_SIGMA, (count - 1) as f64) / 3.0
}

/// Sums over the outer samples of one replicate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Replicate {
    /// Outer samples with a solution.
    pub count: u64,
    /// Sum of `ln p(z | theta) - ln p(z)`.
    pub sum: f64,
    /// Sum of the rise of `ln p(z)` from half to all inner samples.
    pub marginal_rise: f64,
    /// The same of `ln p(z | theta)`.
    pub conditional_rise: f64,
    /// Outer samples with fewer than [`FEW`] effective inner samples for most of their noises.
    pub few: u64,
    /// Sum of the effective inner samples.
    pub effective: f64,
}

impl Replicate {
    /// Takes in an outer sample whose sums are over `noises` of its readings: their mean.
    pub fn add_mean(&mut self, sample: &Self, noises: u32) {
        let n = f64::from(noises);
        self.count += 1;
        self.sum += sample.sum / n;
        self.marginal_rise += sample.marginal_rise / n;
        self.conditional_rise += sample.conditional_rise / n;
        self.effective += sample.effective / n;
        self.few += u64::from(2 * sample.few > u64::from(noises));
    }

    /// The mean, each logarithm's bias taken out once: `2 U_M - U_(M/2)`; `None` without samples.
    pub fn corrected(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.sum - self.marginal_rise + self.conditional_rise) / self.count as f64)
    }
}

/// How far an estimate can be relied on, by its own diagnostics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Trust {
    /// Not at all: so few inner samples lie near a reading that the bias is large, and its bound is none.
    No,
    /// The bias is beyond the random error, and its bound holds.
    Rough,
    /// The bias is within the random error or small.
    Good,
}

/// An estimate of information.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Value, nats.
    pub value: f64,
    /// Standard error, from the scatter of the replicates, with Student's factor.
    pub standard_error: f64,
    /// Bound of the bias that is left: what was taken out of both logarithms. The rest is smaller where the bias falls
    /// at least as the inverse of the number of inner samples.
    pub bias_bound: f64,
    /// Mean effective number of inner samples.
    pub effective: f64,
    /// Share of the outer samples with fewer than [`FEW`] of them.
    pub few: f64,
}

impl Estimate {
    /// Of all replicates; `None` where one has no sample.
    pub fn of(replicates: &[Replicate]) -> Option<Self> {
        let values: Vec<f64> = replicates.iter().map(Replicate::corrected).collect::<Option<_>>()?;
        if values.is_empty() {
            return None;
        }
        let moments = Moments::of(&values);
        let count: u64 = replicates.iter().map(|replicate| replicate.count).sum();
        let rises: f64 =
            replicates.iter().map(|replicate| replicate.marginal_rise.abs() + replicate.conditional_rise.abs()).sum();
        let standard_error = standard_error(&moments, values.len());
        Some(Self {
            value: moments.mean(),
            standard_error,
            bias_bound: rises / count as f64,
            effective: replicates.iter().map(|replicate| replicate.effective).sum::<f64>() / count as f64,
            few: replicates.iter().map(|replicate| replicate.few).sum::<u64>() as f64 / count as f64,
        })
    }

    /// How far it can be relied on, where its inner integrals are averages over samples.
    pub fn trust(&self) -> Trust {
        let small = (3.0 * self.standard_error).clamp(SMALL_BIAS, LARGE_BIAS);
        if !(self.bias_bound <= GREATEST_BIAS && self.effective >= LEAST_EFFECTIVE) {
            Trust::No
        } else if self.bias_bound <= small && self.few <= GOOD_FEW {
            Trust::Good
        } else {
            Trust::Rough
        }
    }

    /// The ends of three standard errors and the bias.
    pub fn range(&self) -> [f64; 2] {
        let margin = 3.0 * self.standard_error + self.bias_bound;
        [self.value - margin, self.value + margin]
    }

    /// Whether the value lies within three standard errors and the bias of 0.
    pub fn is_within_noise(&self) -> bool {
        !(self.range()[0] > 0.0)
    }
}

/// Mean and standard error of the difference `a - b` of two candidates on the same random numbers.
pub fn difference(a: &[Replicate], b: &[Replicate]) -> Option<(f64, f64)> {
    let differences: Vec<f64> =
        a.iter().zip(b).map(|(a, b)| Some(a.corrected()? - b.corrected()?)).collect::<Option<_>>()?;
    let moments = Moments::of(&differences);
    (differences.len() > 1).then(|| (moments.mean(), standard_error(&moments, differences.len())))
}
