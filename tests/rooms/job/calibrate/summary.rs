//! Tests of `src/job/calibrate/summary.rs`.

use bmv::inference::sampler::chains::{Chain, Chains};
use bmv::job::calibrate::summary::*;

fn chains() -> Chains {
    let chain = |from: f64| Chain {
        dimension: 2,
        draws: (0..4).flat_map(|k| [from + f64::from(k), -2.0 * (from + f64::from(k))]).collect(),
        log_likelihoods: (0..4).map(f64::from).collect(),
        ..Chain::default()
    };
    Chains { names: vec!["a".into(), "b".into()], chains: vec![chain(0.0), chain(10.0)] }
}

#[test]
fn weights_of_chains_weigh_their_draws() {
    let chains = chains();
    let equal = Weighted::new(&chains, None);
    assert!((equal.mean(0) - 6.5).abs() < 1e-12);
    let first = Weighted::new(&chains, Some(&[1.0, 0.0]));
    assert!((first.mean(0) - 1.5).abs() < 1e-12);
    assert!((first.covariance(0, 0) - 1.25).abs() < 1e-12, "0, 1, 2, 3");
    assert_eq!(first.correlations(2), [[1.0, -1.0], [-1.0, 1.0]]);
    assert_eq!(first.quantiles(0, &[0.5, 1.0]), [1.0, 3.0]);
    assert_eq!(first.kept(2).index, [[0, 0], [0, 2]]);
    assert_eq!(equal.kept(100).values.len(), 8);
    assert_eq!(equal.kept(100).values[5], [11.0, -22.0]);
}
