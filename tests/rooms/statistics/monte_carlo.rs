//! Tests of `core/src/statistics/monte_carlo.rs`.

use bmv::random::StreamKey;
use bmv::statistics::monte_carlo::*;

#[test]
fn the_degrees_of_freedom_are_those_of_satterthwaite() {
    let error = |s, degrees| StandardError::new(s, degrees).unwrap();
    let difference = error(3.0, Some(4.0)).of_difference(error(4.0, Some(9.0)));
    assert_eq!(difference.standard_error, 5.0);
    assert!((difference.degrees_of_freedom.unwrap() - 625.0 / (81.0 / 4.0 + 256.0 / 9.0)).abs() < 1e-12);
    assert_eq!(error(3.0, None).of_difference(error(4.0, None)).degrees_of_freedom, None);
    assert_eq!(error(1.0, Some(1e9)).degrees_of_freedom, None);
    assert!([f64::NAN, -1.0, f64::INFINITY].iter().all(|&s| StandardError::new(s, None).is_none()));
    assert!(StandardError::new(1.0, Some(0.0)).is_none());
}

#[test]
fn p_is_that_of_student() {
    // Table of Student's distribution: t = 2.776 at 4 degrees of freedom is the two-sided 5 %.
    let error = StandardError::new(1.0, Some(4.0)).unwrap();
    assert!((error.two_sided_p(2.776_445) - 0.05).abs() < 1e-6);
    assert!((StandardError::new(2.0, None).unwrap().two_sided_p(-3.919_928) - 0.05).abs() < 1e-6);
    let exact = StandardError::new(0.0, None).unwrap();
    assert_eq!(Comparison::of((2.0, exact), (2.0, exact)).p, 1.0);
    assert_eq!(Comparison::of((2.0, exact), (2.0 + 1e-10, exact)).p, 1.0, "rounding");
    assert_eq!(Comparison::of((2.0, exact), (2.1, exact)).p, 0.0);
}

#[test]
fn intervals_give_their_errors_back() {
    let interval = bmv::statistics::Interval::normal(10.0, 2.0, 0.95);
    let error = StandardError::of_interval(interval.lower, interval.upper).unwrap();
    assert!((error.standard_error - 2.0).abs() < 1e-12);
    let replicates = [1.0, 2.0, 3.0, 4.0];
    let estimate = bmv::statistics::sobol_indices::Estimate::of(&replicates);
    let error = StandardError::of_replicates(estimate.lower, estimate.upper, 4).unwrap();
    assert!((error.standard_error - (5.0_f64 / 12.0).sqrt()).abs() < 1e-12);
    assert_eq!(error.degrees_of_freedom, Some(3.0));
    assert!(StandardError::of_replicates(0.0, 1.0, 1).is_none());
}

#[test]
fn holm_steps_down() {
    // 0.01 * 4 and 0.013 * 3 pass at 0.05, 0.03 * 2 does not, nor what follows.
    assert_eq!(holm(&[0.03, 0.01, 0.04, 0.013], 0.05), [false, true, false, true]);
    assert_eq!(holm(&[], 0.05), [false; 0]);
    assert_eq!(holm(&[f64::NAN, 0.001], 0.05), [false, true], "what has no p is not found to differ");
}

#[test]
fn what_is_detectable_is_found_with_the_power_stated() {
    // Means of 8 normal numbers with the error from their scatter. Two errors of the share of 20000: 0.0042.
    let key = StreamKey::new(3, "monte carlo", "test");
    let mean = |index, shift: f64| {
        let mut stream = key.stream(index);
        let x: Vec<f64> = (0..8).map(|_| stream.normal() + shift).collect();
        let mean = x.iter().sum::<f64>() / 8.0;
        let square = x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 7.0 / 8.0;
        (mean, StandardError::new(square.sqrt(), Some(7.0)).unwrap())
    };
    let known = StandardError::new(0.5, None).unwrap();
    let (mut found, mut wrong) = (0, 0);
    let (level, pairs) = (0.01, 20_000);
    for pair in 0..pairs {
        let shift = known.detectable(level, 0.9);
        let difference = key.stream(1_000_000 + pair).normal() * 0.5 + shift;
        found += u32::from(known.two_sided_p(difference) <= level);
        let comparison = Comparison::of(mean(2 * pair, 0.0), mean(2 * pair + 1, 0.0));
        wrong += u32::from(comparison.p <= level);
    }
    let share = |count: u32| f64::from(count) / pairs as f64;
    assert!((share(found) - 0.9).abs() < 0.0085, "{found}");
    assert!((share(wrong) - level).abs() < 0.0028, "{wrong}");
}
