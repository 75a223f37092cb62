//! Distributions of one variable. A variate is the quantile of one uniform number, so that Monte Carlo, Latin
//! hypercube and Sobol points are interchangeable.

use serde::{Deserialize, Serialize};

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

impl Distribution {
    /// The value below which a share `u` (in 0..1) of the distribution lies.
    pub fn quantile(&self, _u: f64) -> f64 {
        todo!()
    }
}
