//! Tests of `src/job/discrepancy/residuals.rs`.

use bmv::job::discrepancy::residuals::*;

#[test]
fn linear_residuals_have_their_slopes_and_draws_without_a_solution_are_left_out() {
    let draws: Vec<Vec<f64>> = (0..40).map(|i| vec![f64::from(i % 7), 1e-4 * f64::from((3 * i) % 11), 5.0]).collect();
    let mut residuals: Vec<Vec<f64>> = draws.iter().map(|d| vec![1.0 + 2.0 * d[0] - 3e4 * d[1], 7.0]).collect();
    residuals[4][0] = f64::NAN;
    let found = Residuals::new(vec![3.0, 5e-4, 5.0], vec![0.5, 7.0], &draws, &residuals);
    assert!((found.slopes[0][0] - 2.0).abs() < 1e-6 && (found.slopes[0][1] + 3e4).abs() < 1e-1, "{found:?}");
    assert_eq!((found.slopes[0][2], found.draws), (0.0, [39, 1]));
    assert!(found.nonlinear[0] < 1e-5 && found.sds[1] == 0.0);
}
