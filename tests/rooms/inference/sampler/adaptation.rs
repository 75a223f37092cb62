//! Tests of `core/src/inference/sampler/adaptation.rs`.

use bmv::inference::sampler::adaptation::*;
use bmv::math::functions::exp;

#[test]
fn covariance_of_three_points() {
    let mut running = RunningCovariance::new(2);
    for point in [[1.0, 2.0], [2.0, 4.0], [6.0, 3.0]] {
        running.add(&point);
    }
    let mut covariance = [0.0; 4];
    running.covariance(&mut covariance);
    // By hand: means 3 and 3; deviations (-2,-1), (-1,1), (3,0).
    assert_eq!(running.mean(), &[3.0, 3.0]);
    let expected = [7.0, 0.5, 0.5, 1.0];
    for (estimate, by_hand) in covariance.iter().zip(expected) {
        assert!((estimate - by_hand).abs() < 1e-14);
    }
    assert_eq!(running.count(), 3);
    running.reset();
    assert_eq!(running.count(), 0);
}

#[test]
fn windows_follow_the_published_plan() {
    // Stan's reference manual: 1000 transitions give windows that end at 100, 150, 250, 450 and 950.
    assert_eq!(Windows::new(1000).ends, vec![100, 150, 250, 450, 950]);
    let windows = Windows::new(100);
    assert_eq!(windows.ends, vec![90]);
    assert!(!windows.collects(14) && windows.collects(15) && windows.collects(89) && !windows.collects(90));
    assert!(Windows::new(0).ends.is_empty());
}

#[test]
fn dual_averaging_finds_the_step_with_the_wanted_acceptance() {
    let mut averaging = DualAveraging::new(1.0, 0.8);
    for _ in 0..2000 {
        let acceptance = exp(-averaging.step());
        averaging.update(acceptance);
    }
    // exp(-step) = 0.8 at step = 0.22314; the published gains leave a few per cent after 2000 updates.
    assert!((averaging.averaged() - 0.223_14).abs() < 0.02, "{}", averaging.averaged());
}
