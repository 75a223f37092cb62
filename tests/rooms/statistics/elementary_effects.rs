//! Tests of `core/src/statistics/elementary_effects.rs`.

use bmv::random::StreamKey;
use bmv::statistics::elementary_effects::*;

#[test]
fn trajectories_step_every_coordinate_once_and_stay_inside() {
    let key = StreamKey::new(1, "t", "t");
    let mut visits = [0; LEVELS];
    for index in 0..400 {
        let trajectory = Trajectory::new(&key, index, 5);
        let mut order = trajectory.order.clone();
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3, 4]);
        for j in 0..5 {
            let end = trajectory.start[j] + trajectory.step(j);
            assert!(0.0 < end && end < 1.0);
            visits[(trajectory.start[j] * 4.0) as usize] += 1;
        }
    }
    // 2000 visits of four levels: 500 each, five standard deviations 97.
    assert!(visits.iter().all(|&n: &i32| (n - 500).abs() < 97), "{visits:?}");
    assert_eq!(Trajectory::new(&key, 7, 5), Trajectory::new(&key, 7, 5));
}

#[test]
fn a_line_has_one_effect_and_an_interaction_scatter() {
    // f = 3 x + 2 x y: effect of x = 3 + 2 y with y in 1/8, ..., 7/8: mean 4, of y = 2 x: mean 1.
    let key = StreamKey::new(2, "t", "t");
    let f = |x: &[f64]| 3.0 * x[0] + 2.0 * x[0] * x[1];
    let mut effects = [Vec::new(), Vec::new()];
    for index in 0..2000 {
        let trajectory = Trajectory::new(&key, index, 2);
        let mut at = trajectory.start.clone();
        for &j in &trajectory.order {
            let before = f(&at);
            at[j] += trajectory.step(j);
            effects[j].push((f(&at) - before) / trajectory.step(j));
        }
    }
    let [x, y] = effects.map(|effects| ElementaryEffect::of(&effects));
    // Standard deviation of 2 y over the levels: 2 sqrt(5 / 64) = 0.559; five standard errors of 2000: 0.0625.
    assert!((x.mu_star - 4.0).abs() < 0.0625 && (y.mu_star - 1.0).abs() < 0.0625, "{x:?} {y:?}");
    assert!((x.sigma - 0.559).abs() < 0.02 && (x.mu - x.mu_star).abs() < 1e-12);
}
