//! Tests of `src/job/calibrate/block.rs`.

use bmv::inference::sampler::chains::Chain;
use bmv::job::calibrate::block::*;
use bmv::job::stored::Block;

#[test]
fn chains_come_back_from_bytes_and_damage_is_seen() {
    let chain = Chain {
        dimension: 2,
        draws: vec![1.0, f64::MIN_POSITIVE, 0.1, -0.0],
        log_likelihoods: vec![0.3, 1e300],
        ..Chain::default()
    };
    comes_back(&Partial::Chain(chain));
}

#[test]
fn predictions_come_back_from_bytes_and_damage_is_seen() {
    let predicted = Predicted { readings: vec![1.5, -0.0], pointwise: vec![2.5], squares: vec![300.0, 1.0] };
    comes_back(&Partial::Predicted(predicted));
}

fn comes_back(partial: &Partial) {
    let bytes = partial.clone().into_bytes().expect("bytes");
    assert_eq!(Partial::from_bytes(&bytes, "s").as_ref(), Ok(partial));
    for cut in 0..bytes.len() {
        assert!(Partial::from_bytes(&bytes[..cut], "s").is_err(), "cut at {cut}");
    }
}
