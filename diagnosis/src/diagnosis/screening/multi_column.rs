//! Directions of several columns, and what directions are after the refit.
//!
//! Several columns (a curve by its knots) have amplitudes drawn from normal distributions with the plausible sizes `t`: the
//! fall of the penalised sum of squares, `r' G~ (G~'G~ + diag(t)^-2)^-1 G~' r = sum of w_i x_i^2`, has the weights
//! `w = l / (1 + l)`, `l` the eigenvalues of `diag(t) G~'G~ diag(t)`, on independent standard normal `x`; its tail is exact
//! ([`crate::math::special::weighted_chi_square_sf`]) and the sum of `w` is its effective freedom.

use nalgebra::DMatrix;

use crate::diagnosis::Direction;
use crate::diagnosis::screening::score::{Column, Prepared, SMALLEST_SHARE, Score};
use crate::inference::null_maximum::Side;
use crate::math::dense::dot_of_columns as dot;
use crate::math::functions::sqrt;
use crate::math::scalar_products::{add_scaled, project_out};
use crate::math::sort::sort_by;
use crate::math::special::{normal_quantile, weighted_chi_square_sf};

/// Weights of a penalised fit below this count as none.
const SMALLEST_WEIGHT: f64 = 1e-6;

/// What a direction is after the refit.
#[derive(Clone, Debug)]
pub(crate) enum Projected {
    /// `g~` and its length.
    Single { column: Vec<f64>, norm: f64, side: Side },
    /// Orthonormal columns, and the weight of the square of the component along each.
    Several { columns: Vec<f64>, weights: Vec<f64> },
    /// Nothing that the data see.
    Unseen,
}

#[derive(Default)]
struct Spectrum {
    weights: Vec<f64>,
    /// Orthonormal, in rows.
    columns: Vec<f64>,
    /// Eigenvectors over the amplitudes.
    vectors: Vec<f64>,
    eigenvalues: Vec<f64>,
}

impl Prepared {
    /// The score of a direction of several columns.
    pub(crate) fn score_several(&self, direction: &Direction) -> Score {
        let k = direction.amplitudes();
        let total: f64 = direction.columns.iter().map(|x| x * x).sum();
        let projected: Vec<Vec<f64>> = (0..k).map(|a| self.project(direction.column(a))).collect();
        let share = if total > 0.0 { projected.iter().map(|g| dot(g, g)).sum::<f64>() / total } else { 0.0 };
        let Spectrum { weights, columns, vectors, eigenvalues } = self.spectrum(direction, &projected);
        if !(share >= SMALLEST_SHARE) || weights.is_empty() {
            return Score::unseen(direction, share);
        }
        let components: Vec<f64> = columns.chunks_exact(self.rows).map(|u| dot(u, &self.residuals)).collect();
        let free_ratio: f64 = weights.iter().zip(&components).map(|(w, x)| w * x * x).sum();
        let (mut amplitudes, mut sds) = (vec![0.0; k], vec![0.0; k]);
        for a in 0..k {
            let t = direction.plausible[a];
            // What no eigenvector covers keeps its prior.
            let mut variance = 1.0;
            for (i, &l) in eigenvalues.iter().enumerate() {
                let v = vectors[i * k + a];
                amplitudes[a] += t * v * sqrt(l) / (1.0 + l) * components[i];
                variance -= v * v * weights[i];
            }
            sds[a] = t * sqrt(variance.max(0.0));
        }
        let added: Vec<Column<'_>> = (0..k)
            .map(|a| Column {
                values: direction.column(a),
                lower: direction.lower[a],
                upper: direction.upper[a],
                precision: 1.0 / (direction.plausible[a] * direction.plausible[a]),
            })
            .collect();
        let likelihood_ratio = self.fit(&added).fall;
        let p = weighted_chi_square_sf(likelihood_ratio.min(free_ratio), &weights, None);
        Score {
            candidate: direction.candidate,
            seen: true,
            share,
            likelihood_ratio,
            free_ratio,
            z: sqrt(free_ratio),
            amplitudes,
            sds,
            freedom: weights.iter().sum(),
            p,
            equivalent: -normal_quantile(p.clamp(1e-300, 1.0 - 1e-16)),
        }
    }

    /// Of several columns that were projected.
    fn spectrum(&self, direction: &Direction, projected: &[Vec<f64>]) -> Spectrum {
        let k = projected.len();
        let t = &direction.plausible;
        let mut found = Spectrum::default();
        let gram = DMatrix::from_fn(k, k, |i, j| t[i] * t[j] * dot(&projected[i], &projected[j]));
        if !gram.iter().all(|x| x.is_finite()) {
            return found;
        }
        let eigen = gram.symmetric_eigen();
        let mut order: Vec<usize> = (0..k).collect();
        sort_by(&mut order, |&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]).then(i.cmp(&j)));
        let largest = order.first().map_or(0.0, |&i| eigen.eigenvalues[i]);
        if !(self.largest * self.largest * largest >= 1.0) {
            return found;
        }
        for i in order {
            let l = eigen.eigenvalues[i];
            // Below this share an eigenvalue is rounding.
            if !(l > 1e-13 * largest) || l / (1.0 + l) < SMALLEST_WEIGHT {
                break;
            }
            let mut u = vec![0.0; self.rows];
            for a in 0..k {
                add_scaled(&mut u, t[a] * eigen.eigenvectors[(a, i)] / sqrt(l), &projected[a]);
            }
            // Of length 1 but for rounding; next to those before.
            project_out(&mut u, &found.columns);
            let norm = sqrt(dot(&u, &u));
            u.iter_mut().for_each(|x| *x /= norm);
            found.columns.extend_from_slice(&u);
            found.vectors.extend((0..k).map(|a| eigen.eigenvectors[(a, i)]));
            found.eigenvalues.push(l);
            found.weights.push(l / (1.0 + l));
        }
        found
    }

    /// A direction after the refit.
    pub(crate) fn projected(&self, direction: &Direction) -> Projected {
        if direction.amplitudes() == 1 {
            let g = direction.column(0);
            let column = self.project(g);
            let left = dot(&column, &column);
            let norm = sqrt(left);
            let seen = left >= SMALLEST_SHARE * dot(g, g) && self.largest * direction.plausible[0] * norm >= 1.0;
            if !(seen && norm.is_finite()) {
                return Projected::Unseen;
            }
            return Projected::Single { column, norm, side: Side::of(direction.lower[0], direction.upper[0]) };
        }
        let total: f64 = direction.columns.iter().map(|x| x * x).sum();
        let projected: Vec<Vec<f64>> = (0..direction.amplitudes()).map(|a| self.project(direction.column(a))).collect();
        let left: f64 = projected.iter().map(|g| dot(g, g)).sum();
        let Spectrum { weights, columns, .. } = self.spectrum(direction, &projected);
        if weights.is_empty() || !(left >= SMALLEST_SHARE * total) {
            return Projected::Unseen;
        }
        Projected::Several { columns, weights }
    }
}
