//! Tests of `core/src/statistics/tolerance.rs`.

use bmv::math::special::normal_cdf;
use bmv::random::StreamKey;
use bmv::statistics::tolerance::*;

#[test]
fn howes_factor_is_that_of_the_handbook() {
    // NIST/SEMATECH e-Handbook of Statistical Methods, 7.2.6.3: 43 values, 90 % with confidence 99 %, printed to 1e-3.
    let factor = howe_factor(43, 0.90, 0.99).expect("two values or more");
    assert!((factor - 2.217).abs() < 6e-4, "{factor}");
    assert_eq!(howe_factor(1, 0.95, 0.95), None);
    // Of very many values it is the normal quantile.
    let many = howe_factor(100_000_000, 0.95, 0.95).expect("many");
    assert!((many - 1.959_964).abs() < 3e-4, "{many}");
}

#[test]
fn a_symmetric_margin_holds_its_share() {
    assert!((symmetric_normal_margin(0.0, 2.0, 0.95) - 2.0 * 1.959_963_984_540_054).abs() < 1e-9);
    for (mean, sd) in [(1.0, 2.0), (-3.0, 0.5), (0.2, 9.0), (50.0, 0.1)] {
        let margin = symmetric_normal_margin(mean, sd, 0.95);
        let inside = normal_cdf((margin - mean) / sd) - normal_cdf((-margin - mean) / sd);
        assert!((inside - 0.95).abs() < 1e-9, "{mean} {sd}: {inside}");
    }
    assert_eq!(symmetric_normal_margin(-3.0, 0.0, 0.95), 3.0);
}

#[test]
fn ranks_are_those_of_the_binomial_distribution() {
    // The well-known 59: the largest of 59 values is above 95 % of any population with confidence 95 %, that of 58 is not.
    assert_eq!(order_statistic(58, 0.95, 0.95), None);
    assert_eq!(order_statistic(59, 0.95, 0.95), Some(59));
    assert_eq!(fewest_for_order_statistic(0.95, 0.95), 59);
    // The next to largest from 93 on (Wilks 1941 and any table of 95/95 limits).
    assert_eq!(order_statistic(92, 0.95, 0.95), Some(92));
    assert_eq!(order_statistic(93, 0.95, 0.95), Some(92));
    assert_eq!(order_statistic(0, 0.95, 0.95), None);
}

/// 4000 samples of 20 normal values each: mean +/- k s must hold 95 % in 95 % of them (Howe is good to a tenth of a per cent or
/// so), and |mean| + k s, which is a wider interval about 0, in no fewer.
#[test]
fn limits_hold_with_the_stated_confidence() {
    let (count, runs, mean, sd) = (20, 4000, 1.0, 2.0);
    let factor = howe_factor(count, 0.95, 0.95).expect("two values or more");
    let key = StreamKey::new(1, "tolerance", "sample");
    let (mut held, mut held_about_zero) = (0, 0);
    for run in 0..runs {
        let mut stream = key.stream(run);
        let values: Vec<f64> = (0..count).map(|_| mean + sd * stream.normal()).collect();
        let own = bmv::statistics::Moments::of(&values);
        let share = |[low, high]: [f64; 2]| normal_cdf((high - mean) / sd) - normal_cdf((low - mean) / sd);
        let reach = factor * own.sd();
        held += u32::from(share([own.mean() - reach, own.mean() + reach]) >= 0.95);
        let margin = own.mean().abs() + reach;
        held_about_zero += u32::from(share([-margin, margin]) >= 0.95);
    }
    // 99.9 % binomial interval of 95 % of 4000: 3754 to 3844, and Howe's own error of half a per cent on either side.
    assert!((3735..=3865).contains(&held), "{held}");
    assert!(held_about_zero >= held, "{held_about_zero} {held}");
}
