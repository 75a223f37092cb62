//! Wrong entries of a pass.

use crate::diagnostics::pass_study::Study;

#[test]
fn unknown_field() {
    let study = Study::new();
    study.edit("pass-1.json", r#""seed": 7"#, r#""sede": 7"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[unknown-field]: unknown field `sede`
     --> study/pass-1.json:1:83
      |
    1 | {"format": "bmv-pass/1", "title": "First", "parent": null, "model": "model.json", "sede": 7,
      |                                                                                   ^^^^^^
      |
      = note: at $.sede
      = help: did you mean `seed`?
    "##);
}

#[test]
fn a_format_of_another_file() {
    let study = Study::new();
    study.edit("pass-1.json", r#"bmv-pass/1"#, r#"bmv-network/1"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[format-version]: this is a file of format `bmv-network/1`
     --> study/pass-1.json:1:12
      |
    1 | {"format": "bmv-network/1", "title": "First", "parent": null, "model": "model.json", "seed": 7,
      |            ^^^^^^^^^^^^^^^ `bmv-pass/1`
      |
      = note: at $.format
    "##);
}

#[test]
fn a_seed_beyond_exact_integers() {
    let study = Study::new();
    study.edit("pass-1.json", r#""seed": 7"#, r#""seed": 9007199254740992"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[out-of-range]: the seed 9007199254740992 is above 2^53 - 1
     --> study/pass-1.json:1:91
      |
    1 | {"format": "bmv-pass/1", "title": "First", "parent": null, "model": "model.json", "seed": 9007199254740992,
      |                                                                                           ^^^^^^^^^^^^^^^^ an integer from 0 to 9007199254740991
      |
      = note: at $.seed
    "##);
}

#[test]
fn an_unknown_parameter() {
    let study = Study::new();
    study.edit("pass-1.json", r#""parameters": {"G""#, r#""parameters": {"H""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[unknown-name]: unknown parameter `H`
     --> study/pass-1.json:2:17
      |
    2 |  "parameters": {"H": {"prior": {"uniform": [0.2, 1.4]}, "because": "torque not recorded"}},
      |                 ^^^ one of `G` and `A`
      |
      = note: at $.parameters.H
      = help: did you mean `G`?
    "##);
}

#[test]
fn a_changed_prior_without_a_reason() {
    let study = Study::new();
    study.edit("pass-1.json", r#", "because": "torque not recorded""#, r#""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[because-missing]: `G` is changed without a reason
     --> study/pass-1.json:2:17
      |
    2 |  "parameters": {"G": {"prior": {"uniform": [0.2, 1.4]}}},
      |                 ^^^ "because": "..."
      |
      = note: at $.parameters.G
    "##);
}

#[test]
fn a_blank_reason() {
    let study = Study::new();
    study.edit("pass-1.json", r#""torque not recorded""#, r#"" ""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[because-missing]: the reason is blank
     --> study/pass-1.json:2:68
      |
    2 |  "parameters": {"G": {"prior": {"uniform": [0.2, 1.4]}, "because": " "}},
      |                                                                    ^^^ a reason in words
      |
      = note: at $.parameters.G.because
    "##);
}

#[test]
fn a_prior_upside_down() {
    let study = Study::new();
    study.edit("pass-1.json", r#"[0.2, 1.4]"#, r#"[1.4, 0.2]"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[invalid-prior]: the prior's lower bound 1.4 is above its upper bound 0.2
     --> study/pass-1.json:2:44
      |
    2 |  "parameters": {"G": {"prior": {"uniform": [1.4, 0.2]}, "because": "torque not recorded"}},
      |                                            ^^^^^^^^^^ [lower, upper]
      |
      = note: at $.parameters.G.prior.uniform
      = help: write [0.2, 1.4]
    "##);
}

#[test]
fn a_posterior_prior() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#"{"uniform": [0.2, 1.4]}"#,
        r#"{"posterior": {"pass": "pass-0.json", "job": "tuned"}}"#,
    );
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[file-missing]: the file `pass-0.json` does not exist in the study's folder
     --> study/pass-1.json:2:46
      |
    2 |  "parameters": {"G": {"prior": {"posterior": {"pass": "pass-0.json", "job": "tuned"}}, "because": "torque not recorded"}},
      |                                              ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
      |
      = note: at $.parameters.G.prior.posterior
    "##);
}

#[test]
fn a_requirement_of_an_unknown_quantity() {
    let study = Study::new();
    study.edit("pass-1.json", r#""quantity": "panel""#, r#""quantity": "pannel""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[unknown-name]: unknown quantity or node `pannel`
     --> study/pass-1.json:3:40
      |
    3 |  "requirements": {"cold": {"quantity": "pannel", "below": {"value": -30, "unit": "degC"}, "probability": 0.99}},
      |                                        ^^^^^^^^ one of `leak`, `plate`, `shroud`, `box` and `panel`
      |
      = note: at $.requirements.cold.quantity
      = help: did you mean `panel`?
    "##);
}

#[test]
fn a_requirement_in_a_wrong_unit() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"value": -30, "unit": "degC"}"#, r#"{"value": -30, "unit": "W"}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[wrong-dimension]: the unit `W` does not fit here
     --> study/pass-1.json:3:81
      |
    3 |  "requirements": {"cold": {"quantity": "panel", "below": {"value": -30, "unit": "W"}, "probability": 0.99}},
      |                                                                                 ^^^ a unit of K
      |
      = note: at $.requirements.cold.below.unit
    "##);
}

#[test]
fn a_requirement_without_a_limit() {
    let study = Study::new();
    study.edit("pass-1.json", r#""below": {"value": -30, "unit": "degC"}, "#, r#""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[requirement]: the requirement `cold` has no limit
     --> study/pass-1.json:3:19
      |
    3 |  "requirements": {"cold": {"quantity": "panel", "probability": 0.99}},
      |                   ^^^^^^ `below`, `above` or both
      |
      = note: at $.requirements.cold
    "##);
}

#[test]
fn an_impossible_probability() {
    let study = Study::new();
    study.edit("pass-1.json", r#"0.99"#, r#"1.5"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[requirement]: a required probability of 1.5
     --> study/pass-1.json:3:105
      |
    3 |  "requirements": {"cold": {"quantity": "panel", "below": {"value": -30, "unit": "degC"}, "probability": 1.5}},
      |                                                                                                         ^^^ above 0 and at most 1
      |
      = note: at $.requirements.cold.probability
    "##);
}

#[test]
fn an_environment_of_an_unknown_input() {
    let study = Study::new();
    study.edit("pass-1.json", r#""hot": {"T_if""#, r#""hot": {"T_fi""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[unknown-name]: unknown input `T_fi`
     --> study/pass-1.json:4:27
      |
    4 |  "environments": {"hot": {"T_fi": {"value": 40, "unit": "degC"}}},
      |                           ^^^^^^ one of `T_if`, `Q` and `T_s`
      |
      = note: at $.environments.hot.T_fi
      = help: did you mean `T_if`?
    "##);
}

#[test]
fn a_bare_number_for_an_input_in_celsius() {
    let study = Study::new();
    study.edit("pass-1.json", r#""hot": {"T_if": {"value": 40, "unit": "degC"}}"#, r#""hot": {"T_if": 313.15}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    warning[bare-number]: the bare number 313.15 is taken in K; the model states `T_if` in degC
     --> study/pass-1.json:4:35
      |
    4 |  "environments": {"hot": {"T_if": 313.15}},
      |                                   ^^^^^^
      |
      = note: at $.environments.hot.T_if
      = help: write {"value": 313.15, "unit": "degC"}, or state K
    "##);
}

#[test]
fn an_unknown_kind_of_job() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"compare": {}}"#, r#"{"comprae": {}}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[unknown-kind]: unknown kind `comprae` of a job
     --> study/pass-1.json:9:65
      |
    9 |  "jobs": {"spread": {"propagate": {"samples": 1024}}, "match": {"comprae": {}}, "size": {"conventional": {}},
      |                                                                 ^^^^^^^^^ one of `propagate`, `sensitivity`, `goal`, `design`, `calibrate`, `compare`, `diagnose`, `discrepancy`, `predict`, `test-plan`, `correlate`, `conventional`, `margins-from-history` and `surrogate`
      |
      = note: at $.jobs.match.comprae
      = help: did you mean `compare`?
    "##);
}

#[test]
fn samples_rounded_up() {
    let study = Study::new();
    study.edit("pass-1.json", r#""samples": 1024"#, r#""samples": 1000"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    warning[samples-rounded]: 1000 Sobol points are rounded up to 1024
     --> study/pass-1.json:9:47
      |
    9 |  "jobs": {"spread": {"propagate": {"samples": 1000}}, "match": {"compare": {}}, "size": {"conventional": {}},
      |                                               ^^^^
      |
      = note: at $.jobs.spread.propagate.samples
      = help: write a power of two
    "##);
}

#[test]
fn no_samples() {
    let study = Study::new();
    study.edit("pass-1.json", r#""samples": 1024"#, r#""samples": 0"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[job-setting]: 0 samples
     --> study/pass-1.json:9:47
      |
    9 |  "jobs": {"spread": {"propagate": {"samples": 0}}, "match": {"compare": {}}, "size": {"conventional": {}},
      |                                               ^ an integer from 2 to 1073741824
      |
      = note: at $.jobs.spread.propagate.samples
    "##);
}

#[test]
fn a_sweep_that_is_not_in_order() {
    let study = Study::new();
    study.edit("pass-1.json", r#""samples": 1024"#, r#""sweep": {"A": [0.05, 0.04, 0.06]}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[sweep]: the values of a sweep are not in order
     --> study/pass-1.json:9:51
      |
    9 |  "jobs": {"spread": {"propagate": {"sweep": {"A": [0.05, 0.04, 0.06]}}}, "match": {"compare": {}}, "size": {"conventional": {}},
      |                                                   ^^^^^^^^^^^^^^^^^^ at least one value, each above the one before, or each below it
      |
      = note: at $.jobs.spread.propagate.sweep.A
    "##);
}

#[test]
fn a_job_with_unknown_data() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"data": ["balance"]}"#, r#"{"data": ["balence"]}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[job-reference]: unknown measurement `balence`
      --> study/pass-1.json:10:44
       |
    10 |           "tuned": {"calibrate": {"data": ["balence"]}}}}
       |                                            ^^^^^^^^^ one of `balance`
       |
       = note: at $.jobs.tuned.calibrate.data[0]
       = help: did you mean `balance`?
    "##);
}

#[test]
fn a_calibration_with_settings_that_do_not_fit() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#"{"data": ["balance"]}"#,
        r#"{"data": ["balance"], "parameters": ["A", "g"], "chains": 1, "sampler": "smc", "warmup": 5}"#,
    );
    let said = study.said("pass-1.json");
    for part in [
        "the prior of `A` is fixed",
        "unknown parameter `g`",
        "1 chains",
        "an integer from 2 to 64",
        "`smc` has no warm-up",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn unknown_criteria() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"compare": {}}"#, r#"{"compare": {"criteria": "esa"}}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[job-reference]: unknown criteria profile `esa`
     --> study/pass-1.json:9:89
      |
    9 |  "jobs": {"spread": {"propagate": {"samples": 1024}}, "match": {"compare": {"criteria": "esa"}}, "size": {"conventional": {}},
      |                                                                                         ^^^^^ one of `smc-3k`, `ecss`, `gsfc-5k` and `precision-1k`
      |
      = note: at $.jobs.match.compare.criteria
    "##);
}

#[test]
fn parameters_of_a_job_that_is_no_calibration() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"compare": {}}"#, r#"{"compare": {"from": "spread"}}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[job-reference]: `spread` is a `propagate` job
     --> study/pass-1.json:9:85
      |
    9 |  "jobs": {"spread": {"propagate": {"samples": 1024}}, "match": {"compare": {"from": "spread"}}, "size": {"conventional": {}},
      |                                                                                     ^^^^^^^^ `nominal`, or a `calibrate` job
      |
      = note: at $.jobs.match.compare.from
    "##);
}

#[test]
fn an_unknown_rule() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"conventional": {}}"#, r#"{"conventional": {"rules": ["military-12k"]}}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[job-reference]: unknown margin rule `military-12k`
     --> study/pass-1.json:9:117
      |
    9 |  "jobs": {"spread": {"propagate": {"samples": 1024}}, "match": {"compare": {}}, "size": {"conventional": {"rules": ["military-12k"]}},
      |                                                                                                                     ^^^^^^^^^^^^^^ one of `none`, `nasa-gsfc-5k`, `military-11k`, `military-17k` and `heat-load-25`
      |
      = note: at $.jobs.size.conventional.rules[0]
      = help: did you mean `military-11k`?
    "##);
}

#[test]
fn a_rule_that_says_nothing_of_the_requirement() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#"{"quantity": "panel", "below": {"value": -30, "unit": "degC"}"#,
        r#"{"quantity": "leak", "below": 5"#,
    );
    study.edit("pass-1.json", r#"{"conventional": {}}"#, r#"{"conventional": {"rules": ["none", "military-11k"]}}"#);
    let said = study.said("pass-1.json");
    for part in [
        "the rule `military-11k` is a margin of temperature, and the requirement `cold` is about a quantity in W",
        "`requirements` about temperatures",
        "pass-1.json:9:",
    ] {
        assert!(said.contains(part), "{part}\n{said}");
    }
    let study = Study::new();
    study.edit("model.json", r#""Q": {"unit": "W", "nominal": 5}"#, r#""Q": {"nominal": 5}"#);
    study.edit("pass-1.json", r#"{"conventional": {}}"#, r#"{"conventional": {"rules": ["heat-load-25"]}}"#);
    let said = study.said("pass-1.json");
    assert!(said.contains("the rule `heat-load-25` changes heat loads, and no parameter or input is in W"), "{said}");
    // A limit on each side, 20 K apart, and 11 K asked for at each.
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#""below": {"value": -30, "unit": "degC"}"#,
        r#""below": {"value": -30, "unit": "degC"}, "above": {"value": -50, "unit": "degC"}"#,
    );
    study.edit(
        "pass-1.json",
        r#"{"conventional": {}}"#,
        r#"{"conventional": {"rules": ["nasa-gsfc-5k", "military-11k"]}}"#,
    );
    let said = study.said("pass-1.json");
    for part in
        ["no design passes the rule `military-11k` for the requirement `cold`", "20.0000 K apart", "`below` alone"]
    {
        assert!(said.contains(part), "{part}\n{said}");
    }
    assert!(!said.contains("`nasa-gsfc-5k`"), "{said}");
}

#[test]
fn a_design_variable_without_a_range() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"conventional": {}}"#, r#"{"conventional": {"design_variable": "T_s"}}"#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[sweep]: no range is known in which `T_s` could be sought
     --> study/pass-1.json:9:126
      |
    9 |  "jobs": {"spread": {"propagate": {"samples": 1024}}, "match": {"compare": {}}, "size": {"conventional": {"design_variable": "T_s"}},
      |                                                                                                                              ^^^^^ {"T_s": {"from": ..., "to": ...}}
      |
      = note: at $.jobs.size.conventional.design_variable
    "##);
}

#[test]
fn a_removal_of_nothing() {
    let study = Study::new();
    study.edit("pass-1.json", r#""environments": {"hot""#, r#""environments": {"cold": null, "hot""#);
    insta::assert_snapshot!(study.said("pass-1.json"), @r##"
    error[nothing-to-remove]: no parent has `cold` under `environments`
     --> study/pass-1.json:4:19
      |
    4 |  "environments": {"cold": null, "hot": {"T_if": {"value": 40, "unit": "degC"}}},
      |                   ^^^^^^ `null` removes what a parent has
      |
      = note: at $.environments.cold
    "##);
}

#[test]
fn a_field_that_a_sibling_job_has_is_called_by_its_name_here() {
    for (job, written, advice) in [
        ("calibrate", "samples", "did you mean `draws`?"),
        ("calibrate", "iterations", "did you mean `draws`?"),
        ("calibrate", "burn_in", "did you mean `warmup`?"),
        ("propagate", "draws", "did you mean `samples`?"),
        ("propagate", "n", "did you mean `samples`?"),
        ("sensitivity", "sampler", "did you mean `methods`?"),
        ("propagate", "chains", "`calibrate` has `chains`; here the fields are"),
        ("compare", "seed", "a pass has one `seed`, beside `jobs`"),
        // What is spelt alike is still found.
        ("calibrate", "drwas", "did you mean `draws`?"),
    ] {
        let study = Study::new();
        let entry = format!(r#""jobs": {{"own": {{"{job}": {{"{written}": 8}}}}, "#);
        study.edit("pass-1.json", r#""jobs": {"#, &entry);
        let said = study.said("pass-1.json");
        assert!(said.contains(&format!("unknown field `{written}`")) && said.contains(advice), "{advice}: {said}");
    }
    // Outside of jobs only the object's own fields are named.
    let study = Study::new();
    study.edit("model.json", r#""A": {"unit": "m2""#, r#""A": {"chains": 3, "unit": "m2""#);
    assert!(!study.said("pass-1.json").contains("calibrate"), "{}", study.said("pass-1.json"));
}
