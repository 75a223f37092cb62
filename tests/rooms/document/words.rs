//! Tests of `core/src/document/words.rs`.

use bmv::document::words::*;

#[test]
fn a_probability_that_is_all_but_certain_is_a_bound() {
    let said = [0.99999, 0.175, 2e-5].map(percent);
    assert_eq!(said, ["over 99.9 %", "17.5 %", "below 0.1 %"]);
}

#[test]
fn one_of_a_thing_is_no_plural() {
    let said = [counted(1_u64, "block"), counted(2_usize, "block"), counted(0_u64, "held-out reading")];
    assert_eq!(said, ["1 block", "2 blocks", "0 held-out readings"]);
    assert_eq!([counted(1_u64, "trajectory"), counted(3_u64, "trajectory")], ["1 trajectory", "3 trajectories"]);
    assert_eq!(counted(2_u64, "day"), "2 days");
    assert_eq!(counted(2_u64, "box"), "2 boxes");
}

#[test]
fn a_p_value_is_never_0() {
    let said = [0.0, 2e-288, 9.9e-7, 1e-6, 6.54e-5, 0.0029, 0.012, 0.05, 0.96, 1.0].map(p_value);
    let wanted = ["< 1e-6", "< 1e-6", "< 1e-6", "1.0e-6", "6.5e-5", "0.0029", "0.012", "0.050", "0.96", "1.00"];
    assert_eq!(said, wanted);
    assert_eq!([0.0, 0.96, f64::NAN].map(p_stated), ["p < 1e-6", "p = 0.96", "p = unknown"]);
}

#[test]
fn large_counts_have_a_comma_at_each_thousand() {
    assert_eq!(counted(9999_u64, "pair"), "9999 pairs");
    assert_eq!(counted(12_345_u64, "pair"), "12,345 pairs");
    assert_eq!(counted(12_941_328_u64, "trajectory"), "12,941,328 trajectories");
    assert_eq!((grouped(100_000), grouped(-12_345)), ("100,000".to_owned(), "-12345".to_owned()));
}
