//! Tests of `src/report/section/propagation.rs`.

mod brief;

use bmv::job::propagate::Probability;
use bmv::report::section::propagation::probability_stated;

#[test]
fn a_probability_of_which_all_samples_agree_is_a_bound() {
    let stated = |value, lower, upper| probability_stated(&Probability { value, lower, upper });
    assert_eq!(stated(1.0, 0.996, 1.0), "\u{2265} 0.996");
    assert_eq!(stated(0.0, 0.0, 0.004), "\u{2264} 0.004");
    assert_eq!(stated(0.93, 0.91, 0.95), "0.930");
}
