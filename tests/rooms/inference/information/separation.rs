//! Tests of `core/src/inference/information/separation.rs`.

use bmv::inference::information::separation::*;
use bmv::random::StreamKey;

const SIGMA: f64 = 0.5;

/// Old inputs of a straight line against a constant.
const OLD: [f64; 4] = [0.0, 1.0, 2.0, 3.0];

/// The rival `y = c`, fitted to noise-free readings of `y = 1 + 0.2 x` at the old inputs: c = 1.3, variance
/// sigma^2 / 4; at x it predicts 1.3.
fn constant(new: &[f64]) -> Separation {
    let truth: Vec<f64> = new.iter().map(|x| 1.0 + 0.2 * x).collect();
    let c = covariance(&[0.0], &[1.0; 4], &[SIGMA; 4], 1).expect("regular");
    assert!((c[0] - SIGMA * SIGMA / 4.0).abs() < 1e-15);
    let mean = vec![1.3; new.len()];
    let derivatives = vec![1.0; new.len()];
    let rival = Rival { mean: &mean, derivatives: &derivatives, covariance: &c, parameters: 1 };
    let n = new.len();
    let noise: Vec<f64> = (0..n * n).map(|k| if k % (n + 1) == 0 { SIGMA * SIGMA } else { 0.0 }).collect();
    from_truth(&truth, &rival, &noise).expect("regular")
}

/// Rise of the rival's least sum of squares from the old readings to all, by fitting anew.
fn rise(new: &[f64]) -> f64 {
    let squares = |inputs: &[f64]| {
        let values: Vec<f64> = inputs.iter().map(|x| 1.0 + 0.2 * x).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / (SIGMA * SIGMA)
    };
    let all: Vec<f64> = OLD.iter().chain(new).copied().collect();
    squares(&all) - squares(&OLD)
}

#[test]
fn the_distance_is_the_rise_of_the_refitted_rivals_misfit() {
    for new in [&[10.0][..], &[10.0, 12.0], &[0.0], &OLD] {
        let separation = constant(new);
        assert!((separation.distance_squared - rise(new)).abs() < 1e-12, "{new:?}");
    }
    // Repeating the middle tells less than going far.
    assert!(constant(&[1.0]).probability < constant(&[10.0]).probability);
}

#[test]
fn the_probability_is_that_of_the_best_test_between_two_normal_distributions() {
    // Readings about mu_1 or mu_2 with covariance S = Sigma + F C F'; the likelihood ratio decides. 40 000 draws: four
    // standard errors are 0.008.
    let (c, d): (f64, f64) = (0.3, 0.9);
    let rival = Rival { mean: &[d, -d], derivatives: &[1.0, 2.0], covariance: &[c], parameters: 1 };
    let separation = from_truth(&[0.0, 0.0], &rival, &[0.25, 0.0, 0.0, 0.25]).expect("regular");
    let s = [0.25 + c, 2.0 * c, 0.25 + 4.0 * c];
    let determinant = s[0] * s[2] - s[1] * s[1];
    let w = [(s[2] * d + s[1] * d) / determinant, (-s[1] * d - s[0] * d) / determinant];
    let square = w[0] * d - w[1] * d;
    assert!((separation.distance_squared - square).abs() < 1e-12);
    let l = [s[0].sqrt(), s[1] / s[0].sqrt(), (determinant / s[0]).sqrt()];
    let mut stream = StreamKey::new(3, "separation", "test").stream(0);
    let mut right = 0;
    for k in 0..40_000 {
        let (a, b) = (stream.normal(), stream.normal());
        let noise = [l[0] * a, l[1] * a + l[2] * b];
        let is_second = k % 2 == 1;
        let shift = if is_second { d } else { 0.0 };
        let z = [noise[0] + shift, noise[1] - shift];
        let says_second = w[0] * z[0] + w[1] * z[1] > 0.5 * square;
        right += u32::from(says_second == is_second);
    }
    assert!((f64::from(right) / 40_000.0 - separation.probability).abs() < 0.008);
}

#[test]
fn rivals_that_agree_are_not_told_apart() {
    let rival = Rival { mean: &[1.0], derivatives: &[2.0], covariance: &[0.1], parameters: 1 };
    let fixed = Rival { mean: &[2.0], derivatives: &[], covariance: &[], parameters: 0 };
    assert_eq!(between(&rival, &rival, &[1.0]).expect("regular").probability, 0.5);
    // Whichever is right: against the rival that can adapt.
    let least_of = between(&rival, &fixed, &[1.0]).expect("regular");
    assert!((least_of.distance_squared - 1.0 / 1.4).abs() < 1e-15);
    let (separation, pair) = least(&[rival, fixed, rival], &[1.0]).expect("regular").expect("pairs");
    assert_eq!((separation.probability, pair), (0.5, [0, 2]));
    assert_eq!(least(&[rival], &[1.0]), Ok(None));
}

#[test]
fn shapes_and_covariances_are_checked() {
    let rival = Rival { mean: &[1.0], derivatives: &[2.0], covariance: &[0.1], parameters: 1 };
    assert!(matches!(from_truth(&[1.0, 2.0], &rival, &[1.0]), Err(SeparationError::Shape { .. })));
    assert_eq!(from_truth(&[1.0], &rival, &[-1.0]), Err(SeparationError::Covariance));
    assert_eq!(from_truth(&[f64::NAN], &rival, &[1.0]), Err(SeparationError::Covariance));
    assert!(covariance(&[0.0], &[0.0], &[1.0], 1).is_err());
}
