//! Tests of `diagnosis/src/diagnosis/thinned.rs`.

use bmv::diagnosis::thinned::*;
use bmv::document::Diagnostics;
use bmv::effect::Catalogue;
use bmv::inference::likelihood::{FewerRows, Likelihood};
use bmv::inference::target::{LeastSquares, Target};
use bmv::math::functions::{sin, sqrt};
use bmv::measurement::{InputColumn, InputTable, Measurement, Rows};
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::f64::consts::PI;
use std::sync::Arc;

/// A ramp over ten rows in blocks of two: it strays little; a switch strays wholly.
#[test]
fn a_switch_strays_from_its_means_and_a_ramp_does_not() {
    let kept = [0, 2, 4, 6, 8, 9];
    let ramp: Vec<f64> = (0..10).map(f64::from).collect();
    // Squares of 1/2 in four blocks, 0 in the last one and in the last row, over 82.5.
    assert!((strays(&ramp, &kept) - (2.0_f64 / 82.5).sqrt()).abs() < 1e-12);
    let switch: Vec<f64> = (0..10).map(|row| f64::from(row % 2)).collect();
    assert!(strays(&switch, &kept) > 0.8);
    assert_eq!(strays(&[3.0; 10], &kept), 0.0);
}

/// Of a sine, means over a share `w` of its period leave `sqrt(1 - sinc(pi w)^2)` of its standard deviation: 0.30 at six a period, 0.35 at
/// five. Sums over 60 rows are near the integrals.
#[test]
fn six_rows_a_period_follow_a_sine() {
    let sine: Vec<f64> = (0..601).map(|row| sin(2.0 * PI * f64::from(row) / 60.0)).collect();
    for rows in [12_u32, 10] {
        let kept: Vec<usize> = (0..601).step_by(rows as usize).collect();
        let x = PI * f64::from(rows) / 60.0;
        let exact = sqrt(1.0 - (sin(x) / x) * (sin(x) / x));
        assert!((strays(&sine, &kept) - exact).abs() < 0.01, "{rows}: {} {exact}", strays(&sine, &kept));
    }
    assert!(strays(&sine, &(0..601).step_by(10).collect::<Vec<usize>>()) < 0.3);
}

/// Constant values count by their time, the value of a kept row between kept rows; linear ones by their rows about it.
#[test]
fn inputs_become_means_about_the_rows_that_are_kept() {
    let column = |hold| InputColumn { input: 0, values: vec![1.0, 2.0, 4.0, 8.0, 16.0, 32.0], hold };
    let table =
        |hold| InputTable { times_s: vec![0.0, 1.0, 3.0, 4.0, 5.0, 6.0], columns: vec![column(hold)], base: vec![0.0] };
    let held = means(&table(true), &[0, 2, 4, 5]);
    assert_eq!(held.times_s, [0.0, 3.0, 5.0, 6.0]);
    // (1 x 1 + 2 x 2) / 3, (4 + 8) / 2, 16, 32.
    assert_eq!(held.columns[0].values, [5.0 / 3.0, 6.0, 16.0, 32.0]);
    let linear = means(&table(false), &[0, 2, 4, 5]);
    // Weights 1 and 2/3 of rows 0 and 1; 1/3, 1 and 1/2 of rows 1 to 3; 1/2 and 1 of rows 3 and 4; 1 of row 5.
    let expected = [1.4, 52.0 / 11.0, 40.0 / 3.0, 32.0];
    for (value, expected) in linear.columns[0].values.iter().zip(expected) {
        assert!((value - expected).abs() < 1e-12, "{value} for {expected}");
    }
}

/// Of an orbit: derivatives drawn between every third row are those on all rows to a few per cent of each column, residuals are
/// the same.
#[test]
fn derivatives_on_fewer_rows_are_near_those_on_all() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Orbit, InjectionRequest::default());
    let problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    let likelihood = problem.hypothesis(&[], 1.0).unwrap().likelihood(&problem).unwrap();
    let fewer = |measurement: &Measurement| {
        let Rows::Transient { inputs, .. } = &measurement.rows else { return None };
        let last = likelihood.data().iter().map(|datum| datum.row).max()?;
        let rows: Vec<usize> = (0..last).step_by(3).chain([last]).collect();
        Some(FewerRows { inputs: means(inputs, &rows), rows, tolerance: 1.0 })
    };
    let fewer: Vec<Option<FewerRows>> = problem.measurements.iter().map(fewer).collect();
    let unknowns: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    let evaluate = |likelihood: &Likelihood| {
        let (rows, n) = (likelihood.residual_count(), likelihood.dimension());
        let (mut residuals, mut jacobian) = (vec![0.0; rows], vec![0.0; rows * n]);
        let mut memory = likelihood.workspace();
        likelihood.jacobian(&unknowns, &mut memory, &mut residuals, &mut jacobian, &mut vec![0.0; n]).unwrap();
        (residuals, jacobian)
    };
    let (residuals, exact) = evaluate(&likelihood);
    let (same, drawn) = evaluate(&likelihood.clone().with_slopes_on(&fewer));
    assert_eq!(residuals, same);
    assert_ne!(exact, drawn);
    // A course that is known from the value at the same point is the same; at another point it is not used.
    let on_fewer = likelihood.clone().with_slopes_on(&fewer);
    let elsewhere: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.6)).collect();
    let mut memory = on_fewer.workspace();
    let mut of = |at: &[f64]| {
        let (mut value, mut residuals) = (residuals.clone(), residuals.clone());
        let mut jacobian = vec![0.0; exact.len()];
        on_fewer.residuals(at, &mut memory, &mut value).unwrap();
        on_fewer.jacobian(at, &mut memory, &mut residuals, &mut jacobian, &mut vec![0.0; at.len()]).unwrap();
        assert_eq!(value, residuals);
        (residuals, jacobian)
    };
    assert_ne!(of(&elsewhere).0, same);
    assert_eq!(of(&unknowns), (same, drawn.clone()));
    let n = likelihood.dimension();
    for (place, name) in likelihood.names().iter().enumerate() {
        let norm = |value: &dyn Fn(usize) -> f64| {
            (place..exact.len()).step_by(n).map(|at| value(at) * value(at)).sum::<f64>().sqrt()
        };
        let (off, size) = (norm(&|at| drawn[at] - exact[at]), norm(&|at| exact[at]));
        assert!(off < 0.05 * size, "{name}: {off} of {size}");
    }
}
