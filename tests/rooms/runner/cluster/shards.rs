//! Tests of `src/runner/cluster/shards.rs`.

use bmv::runner::cluster::scheduler::Limits;
use bmv::runner::cluster::shards::*;

#[test]
fn runs_cover_every_block_once_and_are_of_equal_length() {
    for (blocks, shards) in [(1, 1), (7, 7), (40, 7), (1000, 999), (3, 40)] {
        let runs = runs(blocks, shards);
        let all: Vec<usize> = runs.iter().cloned().flatten().collect();
        assert_eq!(all, (0..blocks).collect::<Vec<_>>());
        let lengths: Vec<usize> = runs.iter().map(ExactSizeIterator::len).collect();
        assert!(lengths.iter().max().unwrap() - lengths.iter().min().unwrap() <= 1, "{lengths:?}");
    }
}

#[test]
fn their_number_follows_slots_and_limits() {
    let limits = Limits { array: Some(1001), jobs: Some(10_000), processors: Some(6), keeps_accounts: None };
    assert_eq!(count(500, None, 1, &limits), Ok(24));
    assert_eq!(count(500, None, 2, &limits), Ok(12));
    assert_eq!(count(5, None, 1, &limits), Ok(5));
    assert_eq!(count(500, Some(40), 1, &limits), Ok(40));
    assert_eq!(count(500_000, None, 1, &Limits { processors: Some(100_000), ..limits }), Ok(1000));
    assert_eq!(count(500_000, None, 1, &Limits { array: Some(200), ..limits }).unwrap(), 24);
    let refused = count(5000, Some(1002), 1, &limits).unwrap_err();
    assert!(refused.contains("at most 1001"), "{refused}");
    assert_eq!(count(5000, Some(1001), 1, &limits), Ok(1001));
}
