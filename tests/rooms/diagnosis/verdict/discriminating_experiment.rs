//! Tests of `diagnosis/src/diagnosis/verdict/discriminating_experiment.rs`.

use bmv::diagnosis::verdict::discriminating_experiment::*;

#[test]
fn a_phase_that_is_little_better_than_a_coin_is_not_proposed() {
    // 55.7 % against the 50 % of any guess.
    assert!(
        !is_useful(0.557) && !is_useful(distinguishing_probability(0.0)) && is_useful(distinguishing_probability(1.0))
    );
    // One wrong answer in five is the most that a test of its own may have.
    assert!(!is_worth_a_test(0.79) && is_worth_a_test(0.81));
}
