//! Tests of `src/job/correlate/search.rs`.

use bmv::job::correlate::search::*;

/// Deviations of a linear model, `d = b - A x`.
fn linear(values: &[f64]) -> Vec<f64> {
    let rows = [([1.0, 1.0], 3.0), ([1.0, -1.0], 1.0), ([2.0, 1.0], 4.0)];
    rows.iter().map(|([a, b], target)| target - a * values[0] - b * values[1]).collect()
}

fn search<'s>(ranges: Vec<[f64; 2]>, met: &'s dyn Fn(&[f64]) -> bool) -> Search<'s> {
    Search { ranges, deviations: &linear, met }
}

#[test]
fn least_squares_solves_the_normal_equations() {
    let never = |_: &[f64]| false;
    let steps = search(vec![[-10.0, 10.0]; 2], &never).least_squares(&[0.0, 0.0]);
    // A'A = [6 2; 2 3], A'b = [12 6]: x = (12/7, 6/7).
    let values = &steps.last().expect("a step").values;
    assert!((values[0] - 12.0 / 7.0).abs() < 1e-9 && (values[1] - 6.0 / 7.0).abs() < 1e-9, "{values:?}");
}

#[test]
fn a_parameter_at_its_end_stays_there_and_the_other_is_the_best_beside_it() {
    let never = |_: &[f64]| false;
    for steps in [
        search(vec![[-1.0, 1.0], [-10.0, 10.0]], &never).least_squares(&[0.0, 0.0]),
        search(vec![[-1.0, 1.0], [-10.0, 10.0]], &never).one_at_a_time(&[0.0, 0.0]),
    ] {
        // With x0 = 1: x1 = (6 - 2) / 3.
        let values = &steps.last().expect("a step").values;
        assert!((values[0] - 1.0).abs() < 1e-9 && (values[1] - 4.0 / 3.0).abs() < 1e-2, "{values:?}");
    }
}

#[test]
fn one_at_a_time_takes_the_most_effective_first_and_stops_when_it_is_met() {
    let met = |own: &[f64]| own.iter().all(|d| d.abs() <= 1.1);
    let steps = search(vec![[-10.0, 10.0]; 2], &met).one_at_a_time(&[0.0, 0.0]);
    // Alone x0 = 2 leaves (1, -1, 0): sum of squares 2; x1 = 2 leaves 14.
    assert_eq!((steps.len(), steps[0].parameter), (1, Some(0)));
    assert!((steps[0].values[0] - 2.0).abs() < 1e-6);
    assert_eq!(steps[0].values[1], 0.0);
}
