//! Tests of `src/report/section/propagation/brief.rs`.

use bmv::job::propagate::{Met, Probability};
use bmv::report::section::propagation::brief::*;

#[test]
fn what_the_samples_leave_open_is_not_met() {
    let standing = |lower, value, upper| {
        let met = Met {
            requirement: "detector".into(),
            probability: Probability { value, lower, upper },
            required: 0.99,
            below: Some(140.0),
            above: None,
            unit: "K".into(),
            quantity: "detector temperature".into(),
        };
        of_requirement("nominal", &met)
    };
    assert!(standing(0.991, 0.995, 0.998).is_met);
    let open = standing(0.985, 0.992, 0.996);
    assert_eq!(
        (open.is_met, open.words.as_str()),
        (false, "P(detector) = 0.992 in nominal, required 0.990: undecided with these samples")
    );
    assert!(!standing(0.5, 0.6, 0.7).is_met);
}
