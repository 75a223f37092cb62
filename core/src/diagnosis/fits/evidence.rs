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
use crate::math::special::ln_normal_interval;

/// Log probability of the box below which it is not accurate: the rule for it has no points far in a tail.
const LEAST_INSIDE: f64 = -12.0;

/// A column whose amplitude is normal about 0, cut at bounds.
#[derive(Clone, Copy, Debug)]
pub struct Amplitude<'a> {
    /// By row.
    pub values: &'a [f64],
    /// Standard deviation before the cut, above 0.
    pub sd: f64,
    /// Lower bound, at most 0: 0 for a half-normal amplitude, minus infinity for a normal one.
    pub lower: f64,
    /// Upper bound, at least 0.
    pub upper: f64,
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

    /// Logarithm of the evidence of the model with columns added: the density of the whitened residuals, that of the rows of
    /// normal priors for standardised parameters (the same constant for all models of a problem). A parameter without a bound
    /// on one side and without a prior's row has the improper density 1. `None` where the integral is not finite.
    ///
    /// Exact where at most one bound matters; else to the 1e-3 of the box probability, for variables that press against
    /// bounds to about one over the square of the decay lengths. Cost: columns^3 / 3.
    pub fn log_evidence(&self, added: &[Amplitude<'_>]) -> Option<f64> {
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
        for (k, amplitude) in added.iter().enumerate() {
            let row = p + k;
            for (i, column) in self.columns.iter().enumerate() {
                let product = dot(column, amplitude.values);
                (a[row * n + i], a[i * n + row]) = (product, product);
            }
            for (other, second) in added[..=k].iter().enumerate() {
                let product = dot(amplitude.values, second.values);
                (a[row * n + p + other], a[(p + other) * n + row]) = (product, product);
            }
            a[row * n + row] += 1.0 / (amplitude.sd * amplitude.sd);
            b.push(dot(amplitude.values, &self.linear.residuals));
            lower.push(amplitude.lower);
            upper.push(amplitude.upper);
            log -= 0.5 * ln(2.0 * std::f64::consts::PI) + ln(amplitude.sd);
            log -= ln_normal_interval(amplitude.lower / amplitude.sd, amplitude.upper / amplitude.sd);
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

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::diagnosis::screening::fixture::{columns, problem, random_direction, stream};
    use crate::math::functions::exp;
    use crate::math::quadrature::gauss_legendre;
    use crate::math::special::normal_cdf;

    const INFINITE: f64 = f64::INFINITY;

    fn normal<'a>(values: &'a [f64], sd: f64) -> Amplitude<'a> {
        Amplitude { values, sd, lower: -INFINITE, upper: INFINITE }
    }

    /// Density of `r` for the covariance `1 + sum of sd^2 c c'`.
    fn dense(r: &[f64], columns: &[(&[f64], f64)]) -> f64 {
        let covariance = DMatrix::from_fn(r.len(), r.len(), |i, j| {
            f64::from(u8::from(i == j)) + columns.iter().map(|(c, sd)| sd * sd * c[i] * c[j]).sum::<f64>()
        });
        let r = DVector::from_column_slice(r);
        let solved = covariance.clone().lu().solve(&r).unwrap();
        -0.5 * (r.dot(&solved) + ln(covariance.determinant()) + r.len() as f64 * ln(2.0 * std::f64::consts::PI))
    }

    /// Two parameters with normal priors as rows, a curve of three columns, against the dense normal density.
    #[test]
    fn normal_amplitudes_have_the_density_of_their_covariance() {
        let mut stream = stream("evidence", 0);
        let readings = 10;
        let mut linear = problem(readings, 2, &mut stream);
        let j = columns(&linear);
        let sds = [0.7, 20.0];
        linear.rows += 2;
        linear.jacobian.extend([1.0 / sds[0], 0.0, 0.0, 1.0 / sds[1]]);
        linear.residuals.extend([0.0, 0.0]);
        let g = random_direction(0, readings, 3, &mut stream);
        let padded: Vec<Vec<f64>> = (0..3).map(|k| [g.column(k), &[0.0, 0.0]].concat()).collect();
        let evidence = Evidence::new(&linear);
        let added: Vec<Amplitude<'_>> = padded.iter().zip([0.1, 1.0, 5.0]).map(|(c, sd)| normal(c, sd)).collect();
        let all = [
            (j[0].as_slice(), sds[0]),
            (j[1].as_slice(), sds[1]),
            (g.column(0), 0.1),
            (g.column(1), 1.0),
            (g.column(2), 5.0),
        ];
        let r = &linear.residuals[..readings];
        // Standardised parameters: the rows of the priors leave out their sds.
        let constant = ln(sds[0] * sds[1]);
        assert!((evidence.log_evidence(&added).unwrap() - constant - dense(r, &all)).abs() < 1e-9);
        assert!((evidence.log_evidence(&[]).unwrap() - constant - dense(r, &all[..2])).abs() < 1e-9);
    }

    #[test]
    fn a_half_normal_amplitude_has_twice_the_probability_of_its_sign() {
        let mut stream = stream("half", 0);
        let linear = problem(8, 0, &mut stream);
        let g = random_direction(0, 8, 1, &mut stream);
        let evidence = Evidence::new(&linear);
        for sd in [0.1, 1.0, 30.0] {
            let half = Amplitude { lower: 0.0, ..normal(&g.columns, sd) };
            let precision = dot(&g.columns, &g.columns) + 1.0 / (sd * sd);
            let mean_over_sd = dot(&g.columns, &linear.residuals) / sqrt(precision);
            let expected = dense(&linear.residuals, &[(&g.columns, sd)]) + ln(2.0 * normal_cdf(mean_over_sd));
            assert!((evidence.log_evidence(&[half]).unwrap() - expected).abs() < 1e-9, "{sd}");
        }
    }

    /// One uniform parameter, which the data press against its bound, and a half-normal amplitude: by quadrature.
    #[test]
    fn uniform_parameters_at_a_bound_are_integrated() {
        let mut stream = stream("uniform", 0);
        let mut linear = problem(6, 1, &mut stream);
        (linear.lower[0], linear.upper[0]) = (0.0, 2.0);
        let j = columns(&linear);
        linear.residuals.iter_mut().zip(&j[0]).for_each(|(r, j)| *r -= 1.5 * j);
        let g = random_direction(0, 6, 1, &mut stream);
        let sd = 0.8;
        let rule = gauss_legendre(120);
        let density = |d: f64, a: f64| {
            let square: f64 = (0..6)
                .map(|row| {
                    let left = linear.residuals[row] - j[0][row] * d - g.columns[row] * a;
                    left * left
                })
                .sum();
            exp(-0.5 * square - 3.0 * ln(2.0 * std::f64::consts::PI))
        };
        let evidence = Evidence::new(&linear);
        let alone = ln(0.5 * rule.integrate(0.0, 2.0, |d| density(d, 0.0)));
        assert!((evidence.log_evidence(&[]).unwrap() - alone).abs() < 1e-6);
        let prior = |a: f64| 2.0 * exp(-0.5 * a * a / (sd * sd)) / (sd * sqrt(2.0 * std::f64::consts::PI));
        let both = ln(0.5 * rule.integrate(0.0, 2.0, |d| rule.integrate(0.0, 8.0, |a| density(d, a) * prior(a))));
        let half = Amplitude { lower: 0.0, ..normal(&g.columns, sd) };
        // The box probability's own error.
        assert!((evidence.log_evidence(&[half]).unwrap() - both).abs() < 5e-3, "{both}");
        // A parameter that the data do not see changes nothing.
        let mut blind = linear.clone();
        blind.jacobian = linear.jacobian.iter().flat_map(|x| [*x, 0.0]).collect();
        blind.lower.push(-3.0);
        blind.upper.push(1.0);
        assert!((Evidence::new(&blind).log_evidence(&[]).unwrap() - alone).abs() < 5e-3);
        blind.upper[1] = INFINITE;
        assert!(Evidence::new(&blind).log_evidence(&[]).is_none());
    }

    /// Two uniform parameters that the data press against their bounds with 40 standard deviations, which is where a baseline
    /// model without a strong effect stands: by quadrature relative to the corner.
    #[test]
    fn parameters_pressed_hard_are_integrated() {
        let mut stream = stream("pressed", 0);
        let mut linear = problem(6, 2, &mut stream);
        (linear.lower, linear.upper) = (vec![0.0; 2], vec![2.0; 2]);
        let j = columns(&linear);
        let dots = [dot(&j[0], &j[0]), dot(&j[0], &j[1]), dot(&j[1], &j[1])];
        for (row, r) in linear.residuals.iter_mut().enumerate() {
            *r -= 40.0 * (j[0][row] + j[1][row]);
        }
        let b = [dot(&j[0], &linear.residuals), dot(&j[1], &linear.residuals)];
        assert!(b[0] < -10.0 && b[1] < -10.0, "{b:?} press both");
        let rule = gauss_legendre(60);
        let fall =
            |d: f64, e: f64| b[0] * d + b[1] * e - 0.5 * (dots[0] * d * d + 2.0 * dots[1] * d * e + dots[2] * e * e);
        let reach = [2.0_f64.min(-30.0 / b[0]), 2.0_f64.min(-30.0 / b[1])];
        let volume = rule.integrate(0.0, reach[0], |d| rule.integrate(0.0, reach[1], |e| exp(fall(d, e))));
        let constant = -3.0 * ln(2.0 * std::f64::consts::PI) - 0.5 * dot(&linear.residuals, &linear.residuals);
        let log_evidence = Evidence::new(&linear).log_evidence(&[]).unwrap();
        // The parameters' correlation at the corner is left out: relative 1 / (40 x 40).
        assert!(
            (log_evidence - constant - ln(0.25 * volume)).abs() < 2e-3,
            "{log_evidence} {}",
            constant + ln(0.25 * volume)
        );
    }
}
