//! Evidence of linear models with normal noise, in closed form.
//!
//! With steps `d` of the parameters, uniform between their bounds (those with normal priors have rows of their own), and
//! amplitudes `a` that are normal about 0 and cut at their bounds, the likelihood times the priors is the exponential of a
//! quadratic form in `x = (d, a)` with the matrix `A = C'C + diag(0, sd^-2)`, `C` the columns, and the slope `b = C'r`. Its
//! integral over the bounds is `exp(b' A^-1 b / 2) (2 pi)^(n/2) |A|^(-1/2)` times the probability of the bounds under the normal
//! distribution of mean `A^-1 b` and covariance `A^-1` ([`crate::inference::estimate::box_probability`]); of a half-normal amplitude
//! alone this is the well-known `2 Phi(mean / sd)` with the factor 2 of its prior. Where the bounds lie far from the mean, as
//! where a strong effect is lacking, it is taken about its largest value between them ([`crate::inference::estimate::laplace`]).
//!
//! Columns with normal amplitudes also stand for a covariance `G S G'` of the residuals: independent heat at every node and
//! phase, an offset of every sensor ("something else").

use crate::diagnosis::Linear;
use crate::diagnosis::linearisation::bounded::{Place, minimise};
use crate::inference::estimate::box_probability::log_box_probability;
use crate::inference::estimate::laplace::Laplace;
use crate::inference::estimate::optimise::Bounds;
use crate::math::cholesky;
use crate::math::dense::dot_of_columns as dot;
use crate::math::functions::{ln, sqrt};
use crate::math::scalar_products::products_between;
use crate::math::special::ln_normal_interval;

/// Log probability of the box below which it is not accurate: the rule for it has no points far in a tail.
const LEAST_INSIDE: f64 = -12.0;

/// A column whose amplitude is normal about 0, cut at bounds.
#[derive(Clone, Copy, Debug)]
pub struct Amplitude<'a> {
    /// By row.
    pub values: &'a [f64],
    /// The amplitude beforehand.
    pub prior: Cut,
}

/// A normal distribution about 0, cut at bounds.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Standard deviation before the cut, above 0.
    pub sd: f64,
    /// Lower bound, at most 0: 0 for a half-normal amplitude, minus infinity for a normal one.
    pub lower: f64,
    /// Upper bound, at least 0.
    pub upper: f64,
}

impl Cut {
    /// A normal distribution without bounds.
    pub fn nowhere(sd: f64) -> Self {
        Self { sd, lower: f64::NEG_INFINITY, upper: f64::INFINITY }
    }
}

/// Products of a column.
#[derive(Clone, Debug)]
pub struct Products {
    /// With the columns of the parameters.
    parameters: Vec<f64>,
    /// With the residuals.
    residuals: f64,
}

/// A linear problem, prepared for many models.
#[derive(Clone, Debug)]
pub struct Evidence<'a> {
    linear: &'a Linear,
    columns: Vec<Vec<f64>>,
    normal: Vec<f64>,
    slope: Vec<f64>,
    square: f64,
}

impl<'a> Evidence<'a> {
    /// Takes the products. Cost: rows x parameters^2.
    pub fn new(linear: &'a Linear) -> Self {
        let p = linear.parameters();
        let columns: Vec<Vec<f64>> =
            (0..p).map(|k| (0..linear.rows).map(|row| linear.jacobian[row * p + k]).collect()).collect();
        let normal = columns.iter().flat_map(|a| columns.iter().map(move |b| dot(a, b))).collect();
        let slope = columns.iter().map(|a| dot(a, &linear.residuals)).collect();
        Self { linear, columns, normal, slope, square: dot(&linear.residuals, &linear.residuals) }
    }

    /// Products of columns with those of the parameters, and with the residuals: what they take part in whatever is beside them.
    pub fn products(&self, columns: &[&[f64]]) -> Vec<Products> {
        let own: Vec<&[f64]> =
            self.columns.iter().map(Vec::as_slice).chain([self.linear.residuals.as_slice()]).collect();
        let split = |mut parameters: Vec<f64>| Products { residuals: parameters.pop().unwrap_or(0.0), parameters };
        products_between(columns, &own).into_iter().map(split).collect()
    }

    /// Logarithm of the evidence of the model with columns added: the density of the whitened residuals, that of the rows of
    /// normal priors for standardised parameters (the same constant for all models of a problem). A parameter without a bound
    /// on one side and without a prior's row has the improper density 1. `None` where the integral is not finite.
    ///
    /// Exact where at most one bound matters; else to the 1e-3 of the box probability, for variables that press against
    /// bounds to about one over the square of the decay lengths. Cost: columns^3 / 3, beside the products.
    pub fn log_evidence(&self, added: &[Amplitude<'_>]) -> Option<f64> {
        let columns: Vec<&[f64]> = added.iter().map(|amplitude| amplitude.values).collect();
        let products = self.products(&columns);
        let priors: Vec<(Cut, &Products)> = added.iter().map(|amplitude| amplitude.prior).zip(&products).collect();
        self.log_evidence_by_products(&priors, &|one, other| dot(columns[one], columns[other]))
    }

    /// The same of columns whose products are known; `between` are those of two of them.
    pub fn log_evidence_by_products(
        &self,
        added: &[(Cut, &Products)],
        between: &dyn Fn(usize, usize) -> f64,
    ) -> Option<f64> {
        let (p, n) = (self.columns.len(), self.columns.len() + added.len());
        let mut a = vec![0.0; n * n];
        let mut b = self.slope.clone();
        let (mut lower, mut upper) = (self.linear.lower.clone(), self.linear.upper.clone());
        let mut log = -0.5 * self.linear.rows as f64 * ln(2.0 * std::f64::consts::PI) - 0.5 * self.square;
        // A parameter that cannot move is none.
        let held: Vec<bool> = (0..n).map(|i| i < p && lower[i] == upper[i]).collect();
        for i in 0..p {
            a[i * n..i * n + p].copy_from_slice(&self.normal[i * p..(i + 1) * p]);
            let width = upper[i] - lower[i];
            if width.is_finite() && width > 0.0 {
                log -= ln(width);
                // What the data do not see stays integrable; flat to 1e-8 over the box.
                a[i * n + i] += 1e-8 / (width * width);
            }
        }
        for (k, (cut, products)) in added.iter().enumerate() {
            let row = p + k;
            for (i, &product) in products.parameters.iter().enumerate() {
                (a[row * n + i], a[i * n + row]) = (product, product);
            }
            for other in 0..=k {
                let product = between(k, other);
                (a[row * n + p + other], a[(p + other) * n + row]) = (product, product);
            }
            a[row * n + row] += 1.0 / (cut.sd * cut.sd);
            b.push(products.residuals);
            lower.push(cut.lower);
            upper.push(cut.upper);
            log -= 0.5 * ln(2.0 * std::f64::consts::PI) + ln(cut.sd);
            log -= ln_normal_interval(cut.lower / cut.sd, cut.upper / cut.sd);
        }
        let kept: Vec<usize> = (0..n).filter(|&i| !held[i]).collect();
        let of_kept = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&i| values[i]).collect() };
        let curvature: Vec<f64> =
            kept.iter().flat_map(|&i| kept.iter().map(|&j| a[i * n + j]).collect::<Vec<_>>()).collect();
        let (b, bounds) = (of_kept(&b), Bounds { lower: of_kept(&lower), upper: of_kept(&upper) });
        let near = whole_box(&curvature, &b, &bounds).or_else(|| from_corner(&curvature, &b, &bounds));
        Some(log + near?).filter(|log| log.is_finite())
    }
}

/// Logarithm of the integral of `exp(b'x - x'Ax/2)` over a box, from its mean without bounds; `None` where that is too far
/// from the box for its probability to be accurate, or nowhere.
fn whole_box(curvature: &[f64], b: &[f64], bounds: &Bounds) -> Option<f64> {
    let k = b.len();
    let scale: Vec<f64> = (0..k).map(|i| 1.0 / sqrt(curvature[i * k + i])).collect();
    if !scale.iter().all(|s| s.is_finite() && *s > 0.0) {
        return None;
    }
    let mut factor: Vec<f64> = (0..k * k).map(|place| curvature[place] * scale[place / k] * scale[place % k]).collect();
    cholesky::factor(&mut factor, k).ok()?;
    let mut mean: Vec<f64> = b.iter().zip(&scale).map(|(b, s)| b * s).collect();
    cholesky::solve_lower(&factor, &mut mean);
    let square = dot(&mean, &mean);
    cholesky::solve_lower_transposed(&factor, &mut mean);
    let room = |ends: &[f64]| -> Vec<f64> { (0..k).map(|i| ends[i] / scale[i] - mean[i]).collect() };
    let inside = log_box_probability(&cholesky::inverse(&factor, k), &room(&bounds.lower), &room(&bounds.upper))?;
    let volume = 0.5 * k as f64 * ln(2.0 * std::f64::consts::PI) - 0.5 * cholesky::log_determinant(&factor, k)
        + scale.iter().map(|s| ln(*s)).sum::<f64>();
    (inside > LEAST_INSIDE).then_some(0.5 * square + volume + inside)
}

/// The same from the largest value in the box.
fn from_corner(curvature: &[f64], b: &[f64], bounds: &Bounds) -> Option<f64> {
    let k = b.len();
    let mode = minimise(curvature, b, &bounds.lower, &bounds.upper, &vec![Place::Free; k]);
    let gradient: Vec<f64> = (0..k).map(|i| dot(&curvature[i * k..(i + 1) * k], &mode.x) - b[i]).collect();
    let free: Vec<usize> = (0..k).filter(|&i| mode.places[i] == Place::Free).collect();
    let volume = Laplace::new(&mode.x, &gradient, bounds, curvature, &free)?.log_volume?;
    Some(0.5 * mode.fall + volume)
}
