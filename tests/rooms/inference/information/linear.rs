//! Tests of `core/src/inference/information/linear.rs`.

use bmv::inference::information::linear::*;
use bmv::math::functions::ln;

#[test]
fn one_reading_of_one_parameter() {
    // 1/2 ln(1 + a^2 s_t^2 / s_e^2) with a s_t / s_e = 3.
    let u = information(&[3.0], 1, 1).expect("finite");
    assert!((u - 0.5 * ln(10.0)).abs() < 1e-15);
    // A nuisance of the same strength: 1/2 ln(19 / 10).
    let u = information(&[3.0, 3.0], 2, 1).expect("finite");
    assert!((u - 0.5 * ln(1.9)).abs() < 1e-15);
    assert_eq!(information(&[0.0, 3.0], 2, 1).expect("finite"), 0.0);
    assert!(information(&[f64::NAN], 1, 1).is_err());
}

#[test]
fn information_adds_up_by_the_chain_rule() {
    // I(u, v) = I(u) + I(v | u): the latter by leaving u's column out. Random 3 x 4 matrix.
    let j = [0.3, -1.2, 2.0, 0.4, 1.1, 0.2, -0.7, 0.9, -0.5, 1.6, 0.8, 0.1];
    let rest: Vec<f64> = j.chunks(4).flat_map(|row| row[1..].to_vec()).collect();
    let (all, first, then) = (information(&j, 4, 4), information(&j, 4, 1), information(&rest, 3, 3));
    assert!((all.expect("all") - first.expect("first") - then.expect("then")).abs() < 1e-14);
}

#[test]
fn the_divergence_averages_to_the_information() {
    // One reading z = a u + e: precision 1 + a^2, mean a z / (1 + a^2), z of variance 1 + a^2: the mean's square is
    // a^2 / (1 + a^2) on average, which cancels tr C - 1.
    let a: f64 = 3.0;
    let precision = 1.0 + a * a;
    let d = divergence(&[precision.sqrt()], &[(a * a / precision).sqrt()], 1).expect("regular");
    assert!((d - 0.5 * ln(precision)).abs() < 1e-14);
}
