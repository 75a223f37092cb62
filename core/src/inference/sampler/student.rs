//! A multivariate t density about a point, to propose from: its tails cover those of posteriors that are nearly normal.

use crate::math::cholesky;
use crate::math::functions::{ln, ln_1p, ln_gamma};
use crate::random::Stream;

/// A multivariate t density.
pub struct StudentProposal {
    centre: Vec<f64>,
    /// Lower Cholesky factor of the scale, row by row.
    factor: Vec<f64>,
    degrees: u32,
    /// Logarithm of the density at the centre.
    log_constant: f64,
    normals: Vec<f64>,
}

impl StudentProposal {
    /// About a centre, with the lower Cholesky factor of its scale and 1 degree of freedom or more.
    pub fn new(centre: Vec<f64>, factor: Vec<f64>, degrees: u32) -> Self {
        let n = centre.len();
        let (freedom, dimension) = (f64::from(degrees), n as f64);
        let log_constant = ln_gamma(0.5 * (freedom + dimension))
            - ln_gamma(0.5 * freedom)
            - 0.5 * dimension * ln(freedom * core::f64::consts::PI)
            - 0.5 * cholesky::log_determinant(&factor, n);
        Self { centre, factor, degrees, log_constant, normals: vec![0.0; n] }
    }

    /// Draws a point; returns the log density there.
    pub fn draw(&mut self, stream: &mut Stream, point: &mut [f64]) -> f64 {
        for value in &mut self.normals {
            *value = stream.normal();
        }
        let chi_square: f64 = (0..self.degrees)
            .map(|_| {
                let z = stream.normal();
                z * z
            })
            .sum();
        let stretch = (f64::from(self.degrees) / chi_square).sqrt();
        let distance: f64 = self.normals.iter().map(|u| u * u).sum::<f64>() * stretch * stretch;
        cholesky::multiply(&self.factor, &self.normals, point);
        for (z, centre) in point.iter_mut().zip(&self.centre) {
            *z = centre + stretch * *z;
        }
        self.at_distance(distance)
    }

    /// The log density at a point.
    pub fn log_density(&self, point: &[f64]) -> f64 {
        let mut apart: Vec<f64> = point.iter().zip(&self.centre).map(|(z, centre)| z - centre).collect();
        cholesky::solve_lower(&self.factor, &mut apart);
        self.at_distance(apart.iter().map(|u| u * u).sum())
    }

    /// The log density at a squared distance, in units of the scale.
    fn at_distance(&self, distance: f64) -> f64 {
        let freedom = f64::from(self.degrees);
        self.log_constant - 0.5 * (freedom + self.centre.len() as f64) * ln_1p(distance / freedom)
    }
}
