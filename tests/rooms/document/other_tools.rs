//! Tests of `core/src/document/other_tools.rs`.

use bmv::document::other_tools::*;

#[test]
fn fields_of_sibling_jobs_are_told_apart() {
    let calibrate = ["data", "parameters", "sampler", "chains", "warmup", "draws"];
    for (field, expected) in [
        ("samples", "draws"),
        ("iterations", "draws"),
        ("n", "draws"),
        ("burn_in", "warmup"),
        ("warm_up", "warmup"),
        ("walkers", "chains"),
        ("method", "sampler"),
        ("Measurements", "data"),
    ] {
        assert_eq!(same_field(field, &calibrate), Some(expected), "{field}");
    }
    assert_eq!(same_field("draws", &["samples", "sampling"]), Some("samples"));
    assert_eq!((same_field("chains", &["samples"]), who_has("chains")), (None, Some("`calibrate` has `chains`")));
    assert_eq!((same_field("colour", &calibrate), who_has("colour")), (None, None));
}

#[test]
fn words_of_either_case_and_capital_letters_are_known() {
    let meant = |word| other_word(word).map(|entry| entry.word);
    assert_eq!([meant("gl"), meant("QI"), meant("qi"), meant("D")], [Some("GL"), Some("QI"), Some("QI"), Some("D")]);
    // The small letters are ends of a pair more often than nodes.
    assert_eq!([meant("a"), meant("b"), meant("wattage")], [None; 3]);
    assert_eq!(meant("Diffusion"), Some("D"));
    assert!(advice("type", Some("B")).is_some_and(|advice| advice.contains("`boundary`")));
    assert_eq!(advice("type", Some("other")), None);
}
