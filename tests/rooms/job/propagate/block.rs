//! Tests of `src/job/propagate/block.rs`.

use bmv::job::propagate::block::*;
use bmv::job::propagate::output::FailedSample;
use bmv::job::stored::Block;

#[test]
fn bytes_come_back() {
    let block = BlockOutput {
        values: vec![1.5, -0.0, f64::MIN_POSITIVE, 300.1],
        failures: vec![FailedSample { index: 7, parameters: vec![("a".into(), 0.1)], reason: "no".into() }],
        failed: 1,
    };
    let bytes = block.clone().into_bytes().expect("bytes");
    assert_eq!(BlockOutput::from_bytes(&bytes, "samples").expect("block"), block);
    for cut in 0..bytes.len() {
        let short = BlockOutput::from_bytes(&bytes[..cut], "samples");
        assert!(short.is_err() || short.is_ok_and(|b| b != block), "cut at {cut}");
    }
}
