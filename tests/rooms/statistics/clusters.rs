//! Tests of `core/src/statistics/clusters.rs`.

use bmv::random::StreamKey;
use bmv::statistics::clusters::*;

#[test]
fn the_design_effect_is_that_of_the_means_scatter() {
    // Values = a shared by 8 samples + b of each: rho = 0.5, effect 4.5; the mean's variance over 400 replicates,
    // whose own relative standard error is sqrt(2 / 400) = 0.07: five of them.
    let key = StreamKey::new(1, "clusters", "test");
    let (count, size) = (50, 8);
    let of: Vec<usize> = (0..count * size).map(|i| i / size).collect();
    let clusters = Clusters { of, count, effective: count as f64 };
    let (mut squares, mut effects) = (0.0, 0.0);
    for replicate in 0..400 {
        let mut stream = key.stream(replicate);
        let shared: Vec<f64> = (0..count).map(|_| stream.normal()).collect();
        let values: Vec<f64> = clusters.of.iter().map(|&cluster| shared[cluster] + stream.normal()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        squares += mean * mean / 400.0;
        effects += clusters.design_effect(&values) / 400.0;
    }
    let expected = 2.0 * effects / (count * size) as f64;
    assert!((effects - 4.5).abs() < 0.1, "{effects}");
    assert!((squares / expected - 1.0).abs() < 0.35, "{squares} {expected}");
}

#[test]
fn what_cannot_be_told_counts_as_one_a_cluster() {
    let clusters = Clusters { of: vec![0, 0, 1, 1], count: 2, effective: 2.0 };
    assert_eq!(effective_samples(std::slice::from_ref(&clusters), &[1.0; 4]), 2.0);
    assert_eq!(effective_samples(&[], &[1.0; 4]), 4.0);
    // Clusters that say nothing.
    assert!(effective_samples(&[clusters], &[1.0, -1.0, 1.0, -1.0]) > 3.9);
}
