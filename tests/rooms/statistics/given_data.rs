//! Tests of `core/src/statistics/given_data.rs`.

use bmv::random::{PointKind, Points, StreamKey};
use bmv::statistics::given_data::*;
use bmv::statistics::sobol_indices::Estimate;

/// Main effects of the Ishigami function from so many points.
fn effects(kind: PointKind, samples: usize, seed: u64) -> Vec<Estimate> {
    let points = Points::new(kind, StreamKey::new(seed, "t", "t"), samples, 3).expect("points");
    let mut rows = vec![0.0; 3 * samples];
    points.fill_rows(0, &mut rows);
    let angle = |u: f64| std::f64::consts::PI * (2.0 * u - 1.0);
    let sin = bmv::math::functions::sin;
    let values: Vec<f64> = rows
        .chunks(3)
        .map(|u| {
            let (x, y, z) = (angle(u[0]), sin(angle(u[1])), angle(u[2]));
            sin(x) + 7.0 * y * y + 0.1 * z * z * z * z * sin(x)
        })
        .collect();
    let column = |j: usize| -> Vec<f64> { rows.iter().skip(j).step_by(3).copied().collect() };
    (0..3).map(|j| main_effect(&column(j), &values).expect("varies")).collect()
}

#[test]
fn the_intervals_hold_the_exact_main_effects() {
    // Intervals of 95 % over 40 seeds and three effects; 120 intervals of which 105 hold with a probability above 0.999
    // (binomial) if they cover 95 %.
    let exact = [0.313_905_191_1, 0.442_411_144_8, 0.0];
    for kind in [PointKind::MonteCarlo, PointKind::Sobol] {
        let mut held = 0;
        for seed in 0..40 {
            for (estimate, exact) in effects(kind, 4096, seed).iter().zip(exact) {
                held += u32::from(estimate.lower <= exact && exact <= estimate.upper);
                assert!((estimate.value - exact).abs() < 0.06, "{estimate:?}");
            }
        }
        assert!(held >= 105, "{kind:?}: {held} of 120");
    }
}

#[test]
fn the_noise_of_the_classes_is_taken_off() {
    // The third coordinate alone has no effect; uncorrected it would have 31 / 4096 = 0.008.
    let mean = (0..20).map(|seed| effects(PointKind::MonteCarlo, 4096, seed)[2].value).sum::<f64>() / 20.0;
    assert!(mean.abs() < 0.002, "{mean}");
}

#[test]
fn too_few_samples_and_constants_have_no_effect() {
    assert_eq!(main_effect(&[0.5; 100], &[1.0; 100]), None);
    let u: Vec<f64> = (0..1024).map(|i| (f64::from(i) + 0.5) / 1024.0).collect();
    assert_eq!(main_effect(&u, &[300.0; 1024]), None);
    let missing: Vec<f64> = u.iter().map(|&u| if u < 0.1 { f64::NAN } else { 2.0 * u }).collect();
    // A quantity that is missing somewhere still follows its parameter.
    let shuffled = |values: &[f64]| (0..1024).map(|i| values[i * 389 % 1024]).collect::<Vec<f64>>();
    assert!(main_effect(&shuffled(&u), &shuffled(&missing)).expect("varies").value > 0.99);
}
