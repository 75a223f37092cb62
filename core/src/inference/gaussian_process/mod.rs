//! Gaussian processes through noisy values: regression of what a model leaves unexplained.
//!
//! A value at a point `x` is `h(x)' beta + f(x) + s + e`: a trend with coefficients of which nothing is known beforehand, a
//! process `f` with a stationary covariance, scatter `s` (independent from point to point, of inferred size) and noise `e` of
//! known size. Each part may be left out, so that a constant, or a residual law (constant and scatter), is a special case and
//! is scored as the process is.
//!
//! `kernel`: covariances and their slopes. `marginal`: likelihood with the function and the trend integrated out, with exact
//! gradient. `descent`: its maximum between bounds. `fit`: the best of several starts. `process`: prediction, draws, values
//! left out. `cross_validation`: scores for which hyperparameters are fitted without the scored values. `hyperparameters`:
//! draws of their posterior. `emulator`: in a model's place, at many points, with slopes. `triangular`: factors, fast. `tested_range`: where a prediction leaves what was tested. `confounding`: what a
//! free discrepancy would make of the parameters.
//!
//! Rasmussen & Williams (2006), Gaussian Processes for Machine Learning, chapters 2, 4 and 5; trend integrated out: section
//! 2.7; values left out with a trend: Dubrule (1983), Math. Geol. 15, 687.

pub mod confounding;
pub mod cross_validation;
pub mod descent;
pub mod emulator;
pub mod fit;
pub mod hyperparameters;
pub mod kernel;
pub mod marginal;
pub mod process;
pub mod tested_range;
pub mod triangular;

use thiserror::Error;

pub use kernel::Kernel;

/// Fewest points through which a process is laid.
pub const FEWEST_POINTS: usize = 5;

/// Values that no process fits.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GaussianProcessError {
    /// Fewer points than a process needs.
    #[error("{points} points are too few for a Gaussian process, which needs {FEWEST_POINTS}")]
    TooFew {
        /// Number of points.
        points: usize,
    },
    /// Numbers that do not belong together.
    #[error("{what} has {found} numbers instead of {expected}")]
    Shape {
        /// What is of the wrong length.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length that it should have.
        expected: usize,
    },
    /// A number that is not finite, or a variance below 0.
    #[error("{what} number {index} is {value}")]
    Number {
        /// What it belongs to.
        what: &'static str,
        /// Its place.
        index: usize,
        /// The number.
        value: f64,
    },
    /// Two points at the same place, whose values differ without noise or scatter that would let them.
    #[error("points {first} and {second} are the same, and there is neither noise nor scatter")]
    SamePoint {
        /// Place of the first, from 0.
        first: usize,
        /// Place of the second, from 0.
        second: usize,
    },
    /// Values that do not vary, so that they say nothing of a process.
    #[error("all values are {value}, which says nothing about a Gaussian process")]
    Constant {
        /// The value.
        value: f64,
    },
    /// More coefficients of the trend than values can tell.
    #[error(
        "the trend's coefficients cannot be told apart from {points} points, since some of them coincide or lie in line"
    )]
    Trend {
        /// Number of points.
        points: usize,
    },
    /// A covariance that rounding leaves indefinite.
    #[error("the covariance of the points is not positive definite")]
    Indefinite,
}

/// Trend of a process, whose coefficients are integrated out under a flat prior.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Trend {
    /// None: the mean is 0.
    None,
    /// A constant.
    Constant,
    /// A constant, and a slope in each input.
    Linear,
}

impl Trend {
    /// Number of coefficients over inputs of this number.
    pub fn coefficients(self, inputs: usize) -> usize {
        match self {
            Self::None => 0,
            Self::Constant => 1,
            Self::Linear => 1 + inputs,
        }
    }

    /// The functions `h` at a point.
    pub fn at(self, point: &[f64]) -> Vec<f64> {
        let mut basis = Vec::with_capacity(self.coefficients(point.len()));
        if self != Self::None {
            basis.push(1.0);
        }
        if self == Self::Linear {
            basis.extend_from_slice(point);
        }
        basis
    }
}

/// Which parts a process has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Form {
    /// Covariance of the smooth part; `None` for none.
    pub kernel: Option<Kernel>,
    /// Trend.
    pub trend: Trend,
    /// Whether values scatter beyond their known noise.
    pub scatter: bool,
}

impl Form {
    /// Number of hyperparameters over inputs of this number. They are logarithms, in this order: variance of the smooth part,
    /// its length in each input, variance of the scatter.
    pub fn hyperparameters(&self, inputs: usize) -> usize {
        self.kernel.map_or(0, |_| 1 + inputs) + usize::from(self.scatter)
    }

    /// The hyperparameters by name.
    pub fn named(&self, hyperparameters: &[f64]) -> Named {
        let exp = crate::math::functions::exp;
        let (smooth, scatter) = hyperparameters.split_at(hyperparameters.len() - usize::from(self.scatter));
        Named {
            variance: if self.kernel.is_some() { smooth.first().map_or(0.0, |v| exp(*v)) } else { 0.0 },
            lengths: smooth.iter().skip(1).map(|length| exp(*length)).collect(),
            scatter: scatter.first().map_or(0.0, |v| exp(*v)),
        }
    }
}

/// Hyperparameters by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Variance of the smooth part, squared unit of the values; 0 without one.
    pub variance: f64,
    /// Its lengths, in units of the inputs; none without one.
    pub lengths: Vec<f64>,
    /// Variance of the scatter, squared unit of the values; 0 without one.
    pub scatter: f64,
}

/// Points with values.
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    /// Number of inputs.
    inputs: usize,
    /// Points, row after row (`points x inputs`).
    points: Vec<f64>,
    values: Vec<f64>,
    /// Known variance of each value's noise.
    noise: Vec<f64>,
    /// Squared differences of each input over the pairs `(i, j < i)`, row after row: as kernels need them.
    squares: Vec<Vec<f64>>,
}

impl Training {
    /// Points (`points x inputs`, row after row, best of order 1), their values, and the known variance of each value's noise.
    ///
    /// # Errors
    /// Lists of the wrong length, numbers that are not finite, variances below 0.
    pub fn new(
        inputs: usize,
        points: Vec<f64>,
        values: Vec<f64>,
        noise: Vec<f64>,
    ) -> Result<Self, GaussianProcessError> {
        let n = values.len();
        for (what, found, expected) in [("the list of points", points.len(), n * inputs), ("the noise", noise.len(), n)]
        {
            if found != expected {
                return Err(GaussianProcessError::Shape { what, found, expected });
            }
        }
        for (what, list) in [("point", &points), ("value", &values), ("noise", &noise)] {
            if let Some(index) = list.iter().position(|value| !value.is_finite()) {
                return Err(GaussianProcessError::Number { what, index, value: list[index] });
            }
        }
        if let Some(index) = noise.iter().position(|variance| *variance < 0.0) {
            return Err(GaussianProcessError::Number { what: "noise", index, value: noise[index] });
        }
        let mut squares = vec![Vec::with_capacity(n * n.saturating_sub(1) / 2); inputs];
        for (input, squares) in squares.iter_mut().enumerate() {
            for i in 0..n {
                squares.extend((0..i).map(|j| {
                    let difference = points[i * inputs + input] - points[j * inputs + input];
                    difference * difference
                }));
            }
        }
        Ok(Self { inputs, points, values, noise, squares })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// A point.
    pub fn point(&self, index: usize) -> &[f64] {
        &self.points[index * self.inputs..(index + 1) * self.inputs]
    }

    /// The values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Known variance of each value's noise.
    pub fn noise(&self) -> &[f64] {
        &self.noise
    }

    /// Puts other values at the same points.
    ///
    /// # Errors
    /// A list of the wrong length, a number that is not finite.
    pub fn set_values(&mut self, values: &[f64]) -> Result<(), GaussianProcessError> {
        if values.len() != self.len() {
            let (what, found, expected) = ("the list of values", values.len(), self.len());
            return Err(GaussianProcessError::Shape { what, found, expected });
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(GaussianProcessError::Number { what: "value", index, value: values[index] });
        }
        self.values.copy_from_slice(values);
        Ok(())
    }

    /// Some of the points, by their places.
    pub fn some(&self, places: &[usize]) -> Self {
        let d = self.inputs;
        let pair = |i: usize, j: usize| i * (i.max(1) - 1) / 2 + j;
        let of_pairs = |squares: &Vec<f64>| {
            let mut kept = Vec::with_capacity(places.len() * places.len() / 2);
            for (row, &i) in places.iter().enumerate() {
                kept.extend(places[..row].iter().map(|&j| {
                    if i > j {
                        squares[pair(i, j)]
                    } else if i < j {
                        squares[pair(j, i)]
                    } else {
                        0.0
                    }
                }));
            }
            kept
        };
        Self {
            inputs: d,
            points: places.iter().flat_map(|&place| self.point(place).iter().copied()).collect(),
            values: places.iter().map(|&place| self.values[place]).collect(),
            noise: places.iter().map(|&place| self.noise[place]).collect(),
            squares: self.squares.iter().map(of_pairs).collect(),
        }
    }

    /// Two points at the same place, if there are any: places from 0.
    pub fn same_points(&self) -> Option<[usize; 2]> {
        (0..self.len()).find_map(|i| (0..i).find(|&j| self.point(i) == self.point(j)).map(|j| [j, i]))
    }

    /// Mean square of the values about their mean, or about 0 where the form has no trend.
    pub fn mean_square(&self, trend: Trend) -> f64 {
        let n = self.len().max(1) as f64;
        let mean = if trend == Trend::None { 0.0 } else { self.values.iter().sum::<f64>() / n };
        self.values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n
    }
}
