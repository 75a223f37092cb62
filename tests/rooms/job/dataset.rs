//! Tests of `src/job/dataset.rs`.

use bmv::job::dataset::*;

#[test]
fn names_that_no_file_holds_are_changed_and_stay_apart() {
    let mut group = Group::new("posterior", vec![Dimension::of_places("chain", 2, 1)]);
    for name in ["a/b", "a_b", "chain", " ", "G"] {
        group.numbers(name, name, None, vec![0.0; 2]);
    }
    let names: Vec<&str> = group.variables.iter().map(|variable| variable.name.as_str()).collect();
    assert_eq!(names, ["a_b", "a_b_", "chain_", "unnamed", "G"]);
    assert_eq!(Dimension::of_places("draw", 5, 2).labels, Labels::Places(vec![0, 2, 4]));
}
