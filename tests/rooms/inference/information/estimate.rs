//! Tests of `core/src/inference/information/estimate.rs`.

use bmv::inference::information::estimate::*;

fn replicate(mean: f64, rise: f64) -> Replicate {
    let count = 10;
    Replicate { count, sum: 10.0 * mean, marginal_rise: 10.0 * rise, ..Replicate::default() }
}

#[test]
fn bias_is_taken_out_and_stated() {
    let estimate = Estimate::of(&[replicate(1.0, 0.1), replicate(1.2, 0.1)]).expect("samples");
    assert!((estimate.value - 1.0).abs() < 1e-15 && (estimate.bias_bound - 0.1).abs() < 1e-15);
    // Of two replicates: 0.1, times a third of the quantile tan(pi (p - 1/2)) of Student's distribution with one
    // degree of freedom, 235.80. Of many it is the plain one.
    assert!((estimate.standard_error / 7.860 - 1.0).abs() < 1e-3, "{}", estimate.standard_error);
    let many: Vec<Replicate> = (0..1000).map(|k| replicate(1.0 + 0.01 * f64::from(k % 2), 0.0)).collect();
    let estimate = Estimate::of(&many).expect("samples");
    assert!((estimate.standard_error / (0.005_002_5 / 1000_f64.sqrt()) - 1.0).abs() < 0.005);
    assert!(!estimate.is_within_noise());
    assert!(Estimate::of(&[replicate(0.2, 0.0), replicate(0.0, 0.0)]).expect("samples").is_within_noise());
    assert_eq!(Estimate::of(&[Replicate::default()]), None);
    assert_eq!(Estimate::of(&[]), None);
}

#[test]
fn trust_goes_by_the_bias_and_the_samples_that_are_near() {
    let of = |rise: f64, effective: f64, few: u64| {
        let sample = |mean: f64| Replicate { effective: 10.0 * effective, few, ..replicate(mean + rise, rise) };
        let many: Vec<Replicate> = (0..16).map(|k| sample(3.0 + 0.001 * f64::from(k % 2))).collect();
        Estimate::of(&many).expect("samples").trust()
    };
    assert_eq!((of(0.01, 50.0, 0), of(0.05, 50.0, 0), of(0.01, 50.0, 3)), (Trust::Good, Trust::Rough, Trust::Rough));
    // A small bias says nothing where one sample stands for all, and a wide scatter excuses no large one.
    assert_eq!((of(0.01, 1.2, 10), of(0.5, 50.0, 0)), (Trust::No, Trust::No));
    let wild = |mean: f64| Replicate { effective: 100.0, ..replicate(mean, 5.0) };
    assert_eq!(Estimate::of(&[wild(900.0), wild(1100.0)]).expect("samples").trust(), Trust::No);
    assert!(Trust::No < Trust::Rough && Trust::Rough < Trust::Good);
}

#[test]
fn common_random_numbers_cancel_in_differences() {
    let (a, b) = ([replicate(1.0, 0.0), replicate(2.0, 0.0)], [replicate(0.5, 0.0), replicate(1.5, 0.0)]);
    assert_eq!(difference(&a, &b), Some((0.5, 0.0)));
}
