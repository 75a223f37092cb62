//! Distributions of one variable. A variate is the quantile of one uniform number, so that Monte Carlo, Latin
//! hypercube and Sobol points are interchangeable.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::truncated::TruncatedNormal;
use crate::math::functions::{erf, exp, exp_m1, ln, sinh};
use crate::math::special::{
    ln_normal_density, ln_normal_interval, normal_cdf, normal_quantile, normal_quantile_centred,
};

/// A distribution of one variable, in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// A known value.
    Fixed(f64),
    /// Equal density between two bounds.
    Uniform {
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// Normal, cut off at bounds where given.
    Normal {
        /// Mean before the cut.
        mean: f64,
        /// Standard deviation before the cut.
        sd: f64,
        /// Lower bound.
        lower: Option<f64>,
        /// Upper bound.
        upper: Option<f64>,
    },
    /// Normal in the logarithm.
    LogNormal {
        /// Median.
        median: f64,
        /// `exp` of the logarithm's standard deviation.
        factor: f64,
    },
    /// Uniform in the logarithm.
    LogUniform {
        /// Lower bound, above 0.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// Magnitude of a normal variable of mean 0.
    HalfNormal {
        /// Standard deviation of the normal variable.
        scale: f64,
    },
    /// Triangular.
    Triangular {
        /// Lower bound.
        lower: f64,
        /// Most probable value.
        mode: f64,
        /// Upper bound.
        upper: f64,
    },
}

/// Parameters that make no distribution.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DistributionError {
    /// A parameter that is infinite or not a number.
    #[error("{name} is {value}, but it must be a finite number")]
    NotFinite {
        /// Parameter.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A parameter that must be above a limit.
    #[error("{name} is {value}, but it must be above {limit}")]
    TooSmall {
        /// Parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// Bounds in the wrong order.
    #[error("the lower bound {lower} must be below the upper bound {upper}")]
    EmptyRange {
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A mode outside the bounds.
    #[error("mode is {mode}, but it must be between the bounds {lower} and {upper}")]
    ModeOutside {
        /// Most probable value.
        mode: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
}

impl Distribution {
    /// Whether the parameters make a distribution. The other methods take this for granted.
    ///
    /// # Errors
    /// The first parameter that does not fit, with the range it must keep.
    pub fn validate(&self) -> Result<(), DistributionError> {
        match *self {
            Self::Fixed(value) => finite("value", value),
            Self::Uniform { lower, upper } => range(lower, upper),
            Self::Normal { mean, sd, lower, upper } => {
                finite("mean", mean)?;
                above("sd", sd, 0.0)?;
                lower.map_or(Ok(()), |lower| finite("lower bound", lower))?;
                upper.map_or(Ok(()), |upper| finite("upper bound", upper))?;
                match (lower, upper) {
                    (Some(lower), Some(upper)) => range(lower, upper),
                    _ => Ok(()),
                }
            }
            Self::LogNormal { median, factor } => {
                above("median", median, 0.0)?;
                above("factor", factor, 1.0)
            }
            Self::LogUniform { lower, upper } => {
                above("lower bound", lower, 0.0)?;
                range(lower, upper)
            }
            Self::HalfNormal { scale } => above("scale", scale, 0.0),
            Self::Triangular { lower, mode, upper } => {
                range(lower, upper)?;
                finite("mode", mode)?;
                if lower <= mode && mode <= upper {
                    Ok(())
                } else {
                    Err(DistributionError::ModeOutside { mode, lower, upper })
                }
            }
        }
    }

    /// Whether this is a known value.
    pub fn is_fixed(&self) -> bool {
        matches!(self, Self::Fixed(_))
    }

    /// Lower and upper end of the values that can occur, infinite where there is none.
    pub fn support(&self) -> (f64, f64) {
        match *self {
            Self::Fixed(value) => (value, value),
            Self::Uniform { lower, upper }
            | Self::LogUniform { lower, upper }
            | Self::Triangular { lower, upper, .. } => (lower, upper),
            Self::Normal { lower, upper, .. } => (lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY)),
            Self::LogNormal { .. } | Self::HalfNormal { .. } => (0.0, f64::INFINITY),
        }
    }

    /// The value below which a share `u` (in 0..1) of the distribution lies; rises with `u` and stays in the support.
    pub fn quantile(&self, u: f64) -> f64 {
        let value = match *self {
            Self::Fixed(value) => return value,
            Self::Uniform { lower, upper } => lower * (1.0 - u) + upper * u,
            Self::Normal { mean, sd, lower: None, upper: None } => return mean + sd * normal_quantile(u),
            Self::Normal { .. } => self.truncated().map_or(f64::NAN, |t| t.quantile(u)),
            Self::LogNormal { median, factor } => return median * exp(ln(factor) * normal_quantile(u)),
            Self::LogUniform { lower, upper } => lower * exp(u * ln(upper / lower)),
            // The share (1 + u) / 2 of the normal variable; the form keeps the digits of a small u.
            Self::HalfNormal { scale } if u < 0.5 => scale * normal_quantile_centred(0.5 * u),
            Self::HalfNormal { scale } => -scale * normal_quantile(0.5 * (1.0 - u)),
            Self::Triangular { lower, mode, upper } => {
                let width = upper - lower;
                if u * width < mode - lower {
                    lower + (u * width * (mode - lower)).sqrt()
                } else {
                    upper - ((1.0 - u) * width * (upper - mode)).sqrt()
                }
            }
        };
        let (lower, upper) = self.support();
        value.max(lower).min(upper)
    }

    /// Replaces probabilities by their quantiles: the bits of [`Self::quantile`] one by one.
    pub fn quantiles(&self, values: &mut [f64]) {
        match *self {
            // The common one, in a loop without a branch.
            Self::Uniform { lower, upper } => {
                for value in values {
                    *value = (lower * (1.0 - *value) + upper * *value).max(lower).min(upper);
                }
            }
            _ => values.iter_mut().for_each(|value| *value = self.quantile(*value)),
        }
    }

    /// Probability of a value at or below x.
    pub fn cdf(&self, x: f64) -> f64 {
        let (lower, upper) = self.support();
        if x < lower {
            return 0.0;
        }
        if x >= upper {
            return 1.0;
        }
        match *self {
            Self::Fixed(value) => f64::from(x >= value),
            Self::Uniform { lower, upper } => (x - lower) / (upper - lower),
            Self::Normal { mean, sd, lower: None, upper: None } => normal_cdf((x - mean) / sd),
            Self::Normal { .. } => self.truncated().map_or(f64::NAN, |t| t.cdf(x)),
            Self::LogNormal { median, factor } => normal_cdf(ln(x / median) / ln(factor)),
            Self::LogUniform { lower, upper } => ln(x / lower) / ln(upper / lower),
            Self::HalfNormal { scale } => erf(x / scale * std::f64::consts::FRAC_1_SQRT_2),
            Self::Triangular { lower, mode, upper } => {
                let width = upper - lower;
                if x < mode {
                    (x - lower) * (x - lower) / (width * (mode - lower))
                } else {
                    1.0 - (upper - x) * (upper - x) / (width * (upper - mode))
                }
            }
        }
    }

    /// Logarithm of the density at x; minus infinity outside the support. A known value has 0 at itself.
    pub fn log_density(&self, x: f64) -> f64 {
        let (lower, upper) = self.support();
        if !(lower <= x && x <= upper) {
            return f64::NEG_INFINITY;
        }
        match *self {
            Self::Fixed(_) => 0.0,
            Self::Uniform { lower, upper } => -ln(upper - lower),
            Self::Normal { mean, sd, lower: None, upper: None } => ln_normal_density((x - mean) / sd) - ln(sd),
            Self::Normal { mean, sd, .. } => self.truncated().map_or(f64::NAN, |t| {
                ln_normal_density((x - mean) / sd) - ln(sd) - ln_normal_interval(t.lower, t.upper)
            }),
            Self::LogNormal { .. } if x == 0.0 => f64::NEG_INFINITY,
            Self::LogNormal { median, factor } => {
                let s = ln(factor);
                ln_normal_density(ln(x / median) / s) - ln(s) - ln(x)
            }
            Self::LogUniform { lower, upper } => -ln(x) - ln(ln(upper / lower)),
            Self::HalfNormal { scale } => ln_normal_density(x / scale) - ln(scale) + std::f64::consts::LN_2,
            Self::Triangular { lower, mode, upper } => {
                let height = 2.0 / (upper - lower);
                let share = if x < mode {
                    (x - lower) / (mode - lower)
                } else if x > mode {
                    (upper - x) / (upper - mode)
                } else {
                    1.0
                };
                ln(height * share)
            }
        }
    }

    /// Derivative of [`Distribution::log_density`]; 0 outside the support, for a known value and at a triangle's tip.
    pub fn log_density_derivative(&self, x: f64) -> f64 {
        let (lower, upper) = self.support();
        if !(lower <= x && x <= upper) {
            return 0.0;
        }
        match *self {
            Self::Fixed(_) | Self::Uniform { .. } => 0.0,
            Self::Normal { mean, sd, .. } => (mean - x) / sd / sd,
            Self::LogNormal { .. } if x == 0.0 => 0.0,
            Self::LogNormal { median, factor } => {
                let s = ln(factor);
                -(1.0 + ln(x / median) / (s * s)) / x
            }
            Self::LogUniform { .. } => -1.0 / x,
            Self::HalfNormal { scale } => -x / scale / scale,
            Self::Triangular { lower, mode, upper } => {
                if x < mode {
                    1.0 / (x - lower)
                } else if x > mode {
                    -1.0 / (upper - x)
                } else {
                    0.0
                }
            }
        }
    }

    /// Mean.
    pub fn mean(&self) -> f64 {
        match *self {
            Self::Fixed(value) => value,
            Self::Uniform { lower, upper } => 0.5 * lower + 0.5 * upper,
            Self::Normal { mean, lower: None, upper: None, .. } => mean,
            Self::Normal { .. } => self.truncated().map_or(f64::NAN, |t| t.mean_and_sd().0),
            Self::LogNormal { median, factor } => {
                let s = ln(factor);
                median * exp(0.5 * s * s)
            }
            Self::LogUniform { lower, upper } => (upper - lower) / ln(upper / lower),
            Self::HalfNormal { scale } => scale * (2.0 / std::f64::consts::PI).sqrt(),
            Self::Triangular { lower, mode, upper } => (lower + mode + upper) / 3.0,
        }
    }

    /// Standard deviation.
    pub fn sd(&self) -> f64 {
        match *self {
            Self::Fixed(_) => 0.0,
            Self::Uniform { lower, upper } => (upper - lower) / 12_f64.sqrt(),
            Self::Normal { sd, lower: None, upper: None, .. } => sd,
            Self::Normal { .. } => self.truncated().map_or(f64::NAN, |t| t.mean_and_sd().1),
            Self::LogNormal { factor, .. } => {
                let s = ln(factor);
                self.mean() * exp_m1(s * s).sqrt()
            }
            Self::LogUniform { lower, upper } => {
                let width = ln(upper / lower);
                let square = width * width;
                // Variance over lower * upper; the series where the difference would lose its digits.
                let variance = if width < 0.1 {
                    square * (1.0 / 12.0 + square * (1.0 / 180.0 + square * (1.0 / 6720.0 + square / 453_600.0)))
                } else {
                    let half = sinh(0.5 * width) / (0.5 * width);
                    sinh(width) / width - half * half
                };
                (lower * variance.sqrt()) * (upper / lower).sqrt()
            }
            Self::HalfNormal { scale } => scale * (1.0 - 2.0 / std::f64::consts::PI).sqrt(),
            Self::Triangular { lower, mode, upper } => {
                let (a, b) = (mode - lower, upper - mode);
                ((a * a + a * b + b * b) / 18.0).sqrt()
            }
        }
    }

    fn truncated(&self) -> Option<TruncatedNormal> {
        match *self {
            Self::Normal { mean, sd, .. } => {
                let (lower, upper) = self.support();
                Some(TruncatedNormal { mean, sd, lower: (lower - mean) / sd, upper: (upper - mean) / sd })
            }
            _ => None,
        }
    }
}

fn finite(name: &'static str, value: f64) -> Result<(), DistributionError> {
    if value.is_finite() { Ok(()) } else { Err(DistributionError::NotFinite { name, value }) }
}

fn above(name: &'static str, value: f64, limit: f64) -> Result<(), DistributionError> {
    finite(name, value)?;
    if value > limit { Ok(()) } else { Err(DistributionError::TooSmall { name, value, limit }) }
}

fn range(lower: f64, upper: f64) -> Result<(), DistributionError> {
    finite("lower bound", lower)?;
    finite("upper bound", upper)?;
    if lower < upper { Ok(()) } else { Err(DistributionError::EmptyRange { lower, upper }) }
}
