//! Tests of `diagnosis/src/diagnosis/fits/evidence.rs`.

use crate::rooms::diagnosis::screening::fixture::{columns, problem, random_direction, stream};
use bmv::diagnosis::fits::evidence::*;
use bmv::math::dense::dot_of_columns as dot;
use bmv::math::functions::{exp, ln, sqrt};
use bmv::math::quadrature::gauss_legendre;
use bmv::math::special::normal_cdf;
use nalgebra::{DMatrix, DVector};

const INFINITE: f64 = f64::INFINITY;

fn normal<'a>(values: &'a [f64], sd: f64) -> Amplitude<'a> {
    Amplitude { values, prior: Cut { sd, lower: -INFINITE, upper: INFINITE } }
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
        let half = Amplitude { values: &g.columns, prior: Cut { sd, lower: 0.0, upper: INFINITE } };
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
    let half = Amplitude { values: &g.columns, prior: Cut { sd, lower: 0.0, upper: INFINITE } };
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
    let fall = |d: f64, e: f64| b[0] * d + b[1] * e - 0.5 * (dots[0] * d * d + 2.0 * dots[1] * d * e + dots[2] * e * e);
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
