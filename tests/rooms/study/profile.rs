//! Tests of `src/study/profile.rs`.

use bmv::document::Diagnostics;
use bmv::study::profile::*;

#[test]
fn the_programs_own_profiles_are_complete() {
    let mut diagnostics = Diagnostics::new();
    let profiles = load(None, [], &mut diagnostics);
    assert!(diagnostics.is_empty(), "{}", diagnostics.render(false, 10));
    let ecss = &profiles.iter().find(|(profile, _)| profile.name == "ecss").expect("there").0;
    assert_eq!((ecss.each_k, ecss.mean_k, ecss.sd_k), (Some(5.0), Some(2.0), Some(3.0)));
    let smc = &profiles.iter().find(|(profile, _)| profile.name == DEFAULT).expect("the default").0;
    assert_eq!((smc.each_k, smc.mean_k), (Some(3.0), None));
    // 1 K in 5 h.
    let drift = smc.stabilisation_k_per_s.expect("a limit");
    assert!((drift - 1.0 / 18000.0).abs() < 1e-18, "{drift}");
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/src/study/criteria")).expect("the folder");
    assert_eq!(files.count(), EMBEDDED.len(), "every file is in the list");
}
