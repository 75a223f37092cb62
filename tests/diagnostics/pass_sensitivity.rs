//! What is said of the settings of `sensitivity` and `goal`.

use super::pass_study::Study;

/// What a pass is stated whose job `spread` has other settings.
fn said(job: &str) -> String {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"propagate": {"samples": 1024}}"#, job);
    study.said("pass-1.json")
}

#[test]
fn settings_have_defaults_and_quantities_follow_the_requirements() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"propagate": {"samples": 1024}}"#, r#"{"sensitivity": {}}"#);
    study.edit(
        "pass-1.json",
        r#"{"conventional": {}}"#,
        r#"{"goal": {"discrepancy": {"panel": {"value": 1.5, "unit": "K"}}}}"#,
    );
    let pass = study.load();
    let Some(spec) = pass.jobs[0].spec.get::<bmv::job::sensitivity::Spec>() else { panic!("sensitivity") };
    assert_eq!((spec.samples, spec.scrambles, spec.trajectories, spec.methods.len()), (4096, 8, 64, 4));
    assert_eq!((spec.second_order, spec.precision, spec.environments.len()), (false, None, 1));
    assert_eq!(pass.model.quantities[spec.quantities[0]].name, "panel");
    let Some(spec) = pass.jobs[2].spec.get::<bmv::job::goal::Spec>() else { panic!("goal") };
    assert_eq!((spec.samples, spec.discrepancy[0].sd, spec.requirements.len()), (4096, 1.5, 1));
    // The pass's one entry under `design`.
    assert_eq!(spec.design.as_ref().map(|design| design.values.as_slice()), Some([0.01, 0.1].as_slice()));
}

#[test]
fn wrong_settings_are_reported_at_their_place() {
    for (job, expected) in [
        (r#"{"sensitivity": {"samples": 1000}}"#, "1000 Sobol points are rounded up to 1024"),
        (r#"{"sensitivity": {"samples": 1}}"#, "1 sample"),
        (r#"{"sensitivity": {"scrambles": 1}}"#, "an integer from 2 to 64"),
        (r#"{"sensitivity": {"precision": 0}}"#, "the width of an interval, above 0 and at most 1"),
        (r#"{"sensitivity": {"methods": ["sobl"]}}"#, "`sobol`"),
        (r#"{"sensitivity": {"quantities": ["pannel"]}}"#, "unknown quantity or node `pannel`"),
        (r#"{"sensitivity": {"sampels": 5}}"#, "samples"),
        (r#"{"goal": {"samples": 512}}"#, "too few to tell main effects"),
        (r#"{"goal": {"parameters": ["A"]}}"#, "the prior of `A` is fixed"),
        (r#"{"goal": {"parameters": ["H"]}}"#, "unknown parameter `H`"),
        (r#"{"goal": {"design_variable": "B"}}"#, "`B`"),
        (r#"{"goal": {"requirements": ["hot"]}}"#, "unknown requirement `hot`"),
        (r#"{"goal": {"discrepancy": {"panel": -1}}}"#, "a standard deviation, 0 or above"),
        (r#"{"goal": {"discrepancy": {"panel": {"value": 1, "unit": "W"}}}}"#, "W"),
    ] {
        let said = said(job);
        assert!(said.contains(expected) && said.contains("study/pass-1.json:9:"), "{job}: {said}");
    }
}
