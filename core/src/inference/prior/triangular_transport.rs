//! A triangular transport: coordinates sheared along a normal approximation, in which a narrow ridge stays straight beside a bound.
//!
//! The maps of `transform` stretch what lies near a bound. A ridge of correlated parameters that is straight in the
//! parameters is curved by them, and no one metric suits a curved ridge: trajectories need steps as short as its narrowest
//! place asks for, and diverge with longer ones. So the parameters are taken in order, those whose map bends most first,
//! and a coordinate `w_j` is what is left of `z_j` when its regression on the parameters before it is taken off:
//! `x_j = T_j(w_j + sum_i b_ji (x_i - m_i))`, `b_j = C_pp^-1 C_pj / T_j'`, with the approximation's mode `m` and
//! covariance `C`, `p` the parameters before. That is a triangular map (Rosenblatt 1952; Parno & Marzouk 2018 for chains)
//! with the maps of the bounds inside; the transport itself changes no volume.
//!
//! Parameters that the data hardly determine, or that are held at a bound, keep their own map and shear nothing.

use serde::{Deserialize, Serialize};

use crate::inference::prior::transform::{Image, Transform};
use crate::math::cholesky;
use crate::math::sort::sort_by;
use crate::random::Distribution;

/// A parameter is determined when its standard deviation is at most this share of its prior's.
const DETERMINED: f64 = 0.5;
/// Added to the variances of the regression, of which those that are left over are never less.
const RIDGE: f64 = 1e-9;

/// A normal distribution that describes a posterior roughly, such as Laplace's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NormalApproximation {
    /// Its mode, SI.
    pub mode: Vec<f64>,
    /// Its covariance, SI, n x n; 0 in the row and the column of a parameter of which it says nothing.
    pub covariance: Vec<f64>,
}

impl NormalApproximation {
    /// Maps of the bounds at the mode.
    fn images(&self, transforms: &[Transform]) -> Vec<Image> {
        transforms.iter().zip(&self.mode).map(|(transform, &value)| transform.at(transform.coordinate(value))).collect()
    }
}

/// A triangular transport of coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Transport {
    /// Parameters, those that move others first.
    order: Vec<usize>,
    /// `b`, n x n: how far a parameter's coordinate (row) moves with another parameter (column).
    factors: Vec<f64>,
    mode: Vec<f64>,
}

impl Transport {
    /// The transport of an approximation; `None` where fewer than two parameters are determined, or numbers are missing.
    pub fn new(transforms: &[Transform], priors: &[Distribution], normal: &NormalApproximation) -> Option<Self> {
        let n = transforms.len();
        if normal.mode.len() != n || normal.covariance.len() != n * n || priors.len() != n {
            return None;
        }
        let images = normal.images(transforms);
        let sd: Vec<f64> = (0..n).map(|i| normal.covariance[i * n + i].sqrt()).collect();
        let determined = |i: usize| {
            // NaN and 0 determine nothing.
            sd[i] > 0.0 && sd[i] <= DETERMINED * priors[i].sd() && images[i].slope.abs() > 0.0
        };
        // Relative change of the map's slope over a standard deviation.
        let bend = |i: usize| sd[i] * (images[i].log_slope_slope / images[i].slope).abs();
        let mut order: Vec<usize> = (0..n).filter(|&i| determined(i)).collect();
        sort_by(&mut order, |&a, &b| bend(b).total_cmp(&bend(a)));
        if order.len() < 2 {
            return None;
        }
        let mut factors = vec![0.0; n * n];
        for place in 1..order.len() {
            let (before, j) = (&order[..place], order[place]);
            let correlation = |a: usize, b: usize| normal.covariance[a * n + b] / (sd[a] * sd[b]);
            let mut matrix: Vec<f64> = before
                .iter()
                .flat_map(|&a| before.iter().map(move |&b| (a, b)))
                .map(|(a, b)| correlation(a, b))
                .collect();
            for k in 0..place {
                matrix[k * place + k] += RIDGE;
            }
            cholesky::factor(&mut matrix, place).ok()?;
            let mut slopes: Vec<f64> = before.iter().map(|&i| correlation(i, j)).collect();
            cholesky::solve(&matrix, &mut slopes);
            for (&i, slope) in before.iter().zip(&slopes) {
                factors[j * n + i] = slope * sd[j] / (sd[i] * images[j].slope);
            }
        }
        if factors.iter().any(|factor| !factor.is_finite()) {
            return None;
        }
        order.extend((0..n).filter(|&i| !determined(i)));
        Some(Self { order, factors, mode: normal.mode.clone() })
    }

    /// The parameter at a place of the order.
    #[inline]
    pub fn parameter(&self, place: usize) -> usize {
        self.order[place]
    }

    /// How far the parameters before it move the coordinate of the parameter at a place.
    #[inline]
    pub fn shift(&self, place: usize, parameters: &[f64]) -> f64 {
        let row = &self.factors[self.order[place] * self.mode.len()..];
        let mut sum = 0.0;
        for &i in &self.order[..place] {
            sum += row[i] * (parameters[i] - self.mode[i]);
        }
        sum
    }

    /// What the parameters after it return to the derivative with respect to the parameter at a place: `sum_k b_ki g_k`
    /// with the gradient `g` over their coordinates.
    #[inline]
    pub fn returned(&self, place: usize, gradient: &[f64]) -> f64 {
        let (i, n) = (self.order[place], self.mode.len());
        let mut sum = 0.0;
        for &k in &self.order[place + 1..] {
            sum += self.factors[k * n + i] * gradient[k];
        }
        sum
    }
}

/// The approximation's covariance over the coordinates, n x n, to first order at its mode.
pub fn covariance_of_coordinates(
    transforms: &[Transform],
    transport: Option<&Transport>,
    normal: &NormalApproximation,
) -> Vec<f64> {
    let n = transforms.len();
    let images = normal.images(transforms);
    // dw/dx, row by row.
    let mut slopes = vec![0.0; n * n];
    for j in 0..n {
        for i in 0..n {
            slopes[j * n + i] = match transport {
                _ if i == j => 1.0 / images[j].slope,
                Some(transport) => -transport.factors[j * n + i],
                None => 0.0,
            };
        }
    }
    let product = |left: &[f64], right: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        let entry = |i: usize, j: usize| (0..n).map(|k| left[i * n + k] * right(k, j)).sum();
        (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect()
    };
    let half = product(&slopes, &|k, j| normal.covariance[k * n + j]);
    product(&half, &|k, j| slopes[j * n + k])
}
