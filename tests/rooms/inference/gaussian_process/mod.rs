//! Tests of `core/src/inference/gaussian_process/mod.rs`.

mod confounding;
mod cross_validation;
mod descent;
mod process;
mod reference;
mod tested_range;
mod triangular;

use bmv::inference::gaussian_process::*;

#[test]
fn lists_that_do_not_belong_together_are_refused() {
    let new = |points: Vec<f64>, values: Vec<f64>, noise: Vec<f64>| {
        Training::new(1, points, values, noise).unwrap_err().to_string()
    };
    assert_eq!(new(vec![1.0], vec![1.0, 2.0], vec![0.0; 2]), "the list of points has 1 numbers instead of 2");
    assert_eq!(new(vec![1.0], vec![f64::NAN], vec![0.0]), "value number 0 is NaN");
    assert_eq!(new(vec![1.0], vec![1.0], vec![-1.0]), "noise number 0 is -1");
}

#[test]
fn some_of_the_points_are_those_points() {
    let training =
        Training::new(2, vec![0.0, 1.0, 2.0, 5.0, 3.0, 7.0], vec![1.0, 2.0, 3.0], vec![0.1, 0.2, 0.3]).expect("points");
    let some = training.some(&[2, 0]);
    assert_eq!(some, Training::new(2, vec![3.0, 7.0, 0.0, 1.0], vec![3.0, 1.0], vec![0.3, 0.1]).expect("points"));
    assert_eq!(training.same_points(), None);
    assert_eq!(training.some(&[1, 0, 1]).same_points(), Some([0, 2]));
}
