//! Unconstrained coordinates: a smooth, monotone map of each parameter's support onto the whole line, scaled so that the
//! prior's spread is of order one.
//!
//! | support | prior | parameter `x` at coordinate `z` |
//! |---|---|---|
//! | line | normal | `mean + sd z` |
//! | half-line | log-normal | `median factor^z` |
//! | half-line | half-normal, normal cut on one side | `bound +- sd e^z` |
//! | interval | uniform, triangular, normal cut on both sides | `lower + (upper - lower) / (1 + e^-z)` |
//! | interval | log-uniform | the same in `ln x` |
//!
//! The density of `z` is the density of `x` times `|dx/dz|`.

use thiserror::Error;

use crate::math::functions::{exp, ln, ln_1p};
use crate::random::Distribution;

/// A prior that cannot be sampled.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TransformError {
    /// A fixed value is no parameter.
    #[error("the parameter {index} has the fixed value {value}; only parameters with a spread can be inferred")]
    Fixed {
        /// Place of the parameter.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// Bounds or scale without extent.
    #[error(
        "the prior of the parameter {index} has no extent ({lower} to {upper}); the lower end must lie below the upper"
    )]
    Empty {
        /// Place of the parameter.
        index: usize,
        /// Lower end of the support.
        lower: f64,
        /// Upper end of the support.
        upper: f64,
    },
}

/// A parameter at an unconstrained coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image {
    /// The parameter, SI.
    pub value: f64,
    /// `dx/dz`; below 0 for a parameter with an upper bound only.
    pub slope: f64,
    /// `ln |dx/dz|`.
    pub log_slope: f64,
    /// `d ln |dx/dz| / dz`.
    pub log_slope_slope: f64,
}

/// The map of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// `x = centre + scale z`.
    Line {
        /// Parameter at `z = 0`.
        centre: f64,
        /// Spread, above 0.
        scale: f64,
    },
    /// `ln x = centre + scale z`.
    LogLine {
        /// Logarithm of the parameter at `z = 0`.
        centre: f64,
        /// Spread of the logarithm, above 0.
        scale: f64,
    },
    /// `x = bound + scale e^z`; a negative scale for an upper bound (then `x` falls with `z`).
    HalfLine {
        /// The bound.
        bound: f64,
        /// Distance from the bound at `z = 0`, signed.
        scale: f64,
    },
    /// `x = lower + width / (1 + e^-z)`.
    Interval {
        /// Lower bound.
        lower: f64,
        /// Width, above 0.
        width: f64,
        /// Upper bound, which rounding must not pass.
        upper: f64,
    },
    /// `ln x = lower + width / (1 + e^-z)`.
    LogInterval {
        /// Logarithm of the lower bound.
        lower: f64,
        /// Width in the logarithm, above 0.
        width: f64,
        /// Both bounds of the parameter, which rounding must not pass.
        bounds: [f64; 2],
    },
}

impl Transform {
    /// The map that suits a prior; `index` is the parameter's place, for messages.
    ///
    /// # Errors
    /// [`TransformError`] for a fixed value or a support without extent.
    pub fn new(prior: &Distribution, index: usize) -> Result<Self, TransformError> {
        let extent = |lower: f64, upper: f64| {
            if upper > lower && (upper - lower).is_finite() {
                Ok(upper - lower)
            } else {
                Err(TransformError::Empty { index, lower, upper })
            }
        };
        match *prior {
            Distribution::Fixed(value) => Err(TransformError::Fixed { index, value }),
            Distribution::Uniform { lower, upper } | Distribution::Triangular { lower, upper, .. } => {
                Ok(Self::Interval { lower, width: extent(lower, upper)?, upper })
            }
            Distribution::Normal { mean, sd, lower, upper } => {
                extent(0.0, sd)?;
                match (lower, upper) {
                    (None, None) => Ok(Self::Line { centre: mean, scale: sd }),
                    (Some(bound), None) => Ok(Self::HalfLine { bound, scale: sd }),
                    (None, Some(bound)) => Ok(Self::HalfLine { bound, scale: -sd }),
                    (Some(lower), Some(upper)) => Ok(Self::Interval { lower, width: extent(lower, upper)?, upper }),
                }
            }
            Distribution::LogNormal { median, factor } => {
                extent(1.0, factor)?;
                Ok(Self::LogLine { centre: ln(median), scale: ln(factor) })
            }
            Distribution::LogUniform { lower, upper } => {
                extent(lower, upper)?;
                Ok(Self::LogInterval { lower: ln(lower), width: ln(upper) - ln(lower), bounds: [lower, upper] })
            }
            Distribution::HalfNormal { scale } => {
                extent(0.0, scale)?;
                Ok(Self::HalfLine { bound: 0.0, scale })
            }
        }
    }

    /// The parameter at a coordinate.
    #[inline]
    pub fn at(&self, z: f64) -> Image {
        match *self {
            Self::Line { centre, scale } => {
                Image { value: centre + scale * z, slope: scale, log_slope: ln(scale), log_slope_slope: 0.0 }
            }
            Self::LogLine { centre, scale } => {
                let log_value = centre + scale * z;
                let value = exp(log_value);
                Image { value, slope: scale * value, log_slope: ln(scale) + log_value, log_slope_slope: scale }
            }
            Self::HalfLine { bound, scale } => {
                let distance = exp(z);
                Image {
                    value: bound + scale * distance,
                    slope: scale * distance,
                    log_slope: ln(scale.abs()) + z,
                    log_slope_slope: 1.0,
                }
            }
            Self::Interval { lower, width, upper } => {
                let (share, log_share_slope, share_slope, bend) = logistic(z);
                Image {
                    value: (lower + width * share).min(upper),
                    slope: width * share_slope,
                    log_slope: ln(width) + log_share_slope,
                    log_slope_slope: bend,
                }
            }
            Self::LogInterval { lower, width, bounds } => {
                let (share, log_share_slope, share_slope, bend) = logistic(z);
                let log_value = lower + width * share;
                let value = exp(log_value).max(bounds[0]).min(bounds[1]);
                let log_rate = width * share_slope;
                Image {
                    value,
                    slope: value * log_rate,
                    log_slope: log_value + ln(width) + log_share_slope,
                    log_slope_slope: bend + log_rate,
                }
            }
        }
    }

    /// A parameter moved away from its bounds by this share of the interval (of the scale on a half-line).
    pub fn inner(&self, value: f64, share: f64) -> f64 {
        let least = ln(share);
        let z = self.coordinate(value);
        let inner = match self {
            Self::Line { .. } | Self::LogLine { .. } => z,
            Self::HalfLine { .. } => z.max(least),
            Self::Interval { .. } | Self::LogInterval { .. } => z.max(least).min(-least),
        };
        self.at(inner).value
    }

    /// The coordinate of a parameter. A value at or beyond a bound is taken to the coordinate of a point within the bound
    /// by a share 1e-9 of the interval (of the scale), so that every start has a finite coordinate.
    pub fn coordinate(&self, value: f64) -> f64 {
        const INSIDE: f64 = 1e-9;
        let logit = |share: f64| {
            let share = share.clamp(INSIDE, 1.0 - INSIDE);
            ln(share) - ln_1p(-share)
        };
        match *self {
            Self::Line { centre, scale } => (value - centre) / scale,
            Self::LogLine { centre, scale } => (ln(value.max(f64::MIN_POSITIVE)) - centre) / scale,
            Self::HalfLine { bound, scale } => ln(((value - bound) / scale).max(INSIDE)),
            Self::Interval { lower, width, .. } => logit((value - lower) / width),
            Self::LogInterval { lower, width, .. } => logit((ln(value.max(f64::MIN_POSITIVE)) - lower) / width),
        }
    }
}

/// `s = 1 / (1 + e^-z)`, `ln(ds/dz)`, `ds/dz` and `d ln(ds/dz) / dz`, without overflow.
#[inline]
fn logistic(z: f64) -> (f64, f64, f64, f64) {
    let decay = exp(-z.abs());
    let larger = 1.0 / (1.0 + decay);
    let smaller = decay * larger;
    let share = if z >= 0.0 { larger } else { smaller };
    let sign = if z >= 0.0 { -1.0 } else { 1.0 };
    (share, -z.abs() - 2.0 * ln_1p(decay), larger * smaller, sign * (larger - smaller))
}
