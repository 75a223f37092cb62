//! Test plans and margins from history: what is refused, where, and with what to write instead.

use crate::diagnostics::pass_study::Study;

const DESIGN: &str = r#""choose": {"design": {"conditions": {"Q": [2, 8]}, "outer": 256, "inner": 64, "sensors": {"box": {"measures": "box", "sigma": 0.5}}}}"#;

fn study(jobs: &str) -> Study {
    let study = Study::new();
    study.edit("pass-1.json", r#""size": {"conventional": {}}"#, jobs);
    study
}

#[test]
fn what_cannot_be_planned_is_refused_at_its_place() {
    let second = DESIGN.replace("choose", "other");
    let cases = [
        (
            r#""plan": {"test-plan": {}}"#.to_owned(),
            &["does not say `from` which design, and the pass has 0", "a job of kind `design`"][..],
        ),
        (format!(r#"{DESIGN}, {second}, "plan": {{"test-plan": {{}}}}"#), &["the pass has 2", "one of choose, other"]),
        (format!(r#"{DESIGN}, "plan": {{"test-plan": {{"from": "chose"}}}}"#), &["unknown design `chose`", "`choose`"]),
        (
            format!(r#"{DESIGN}, "plan": {{"test-plan": {{"from": "match"}}}}"#),
            &["`match` is a `compare` job", "a `design` job"],
        ),
        (
            format!(r#"{DESIGN}, "plan": {{"test-plan": {{"criteria": "smc"}}}}"#),
            &["unknown criteria profile `smc`", "smc-3k"],
        ),
        (format!(r#"{DESIGN}, "plan": {{"test-plan": {{"samples": 100}}}}"#), &["100 samples", "a power of two"]),
        (
            format!(r#"{DESIGN}, "plan": {{"test-plan": {{"transients": 2}}}}"#),
            &["2 transients", "an integer from 8 to 4096"],
        ),
        (
            format!(r#"{DESIGN}, "plan": {{"test-plan": {{"hold": -1}}}}"#),
            &["a duration of -1 s", "a duration, 0 or above"],
        ),
        (
            format!(r#"{DESIGN}, "plan": {{"test-plan": {{"longest": 0}}}}"#),
            &["a duration of 0 s", "a duration above 0"],
        ),
        (format!(r#"{DESIGN}, "plan": {{"test-plan": {{"start": {{"Qx": 1}}}}}}"#), &["unknown input `Qx`"]),
    ];
    for (jobs, parts) in cases {
        let said = study(&jobs).said("pass-1.json");
        for part in parts {
            assert!(said.contains(part), "{part}\n{said}");
        }
        assert!(said.contains("pass-1.json:"), "{said}");
    }
    // Criteria of the pass that say nothing of steady phases.
    let study = study(&format!(r#"{DESIGN}, "plan": {{"test-plan": {{"criteria": "own"}}}}"#));
    study.edit(
        "pass-1.json",
        r#""design": {"A""#,
        r#""criteria": {"own": {"title": "Own", "each": 2, "source": "made up"}}, "design": {"A""#,
    );
    let said = study.said("pass-1.json");
    assert!(
        said.contains("the criteria `own` do not say when a phase is steady") && said.contains("`stabilisation`"),
        "{said}"
    );
}

#[test]
fn a_history_that_says_too_little_is_refused_at_its_place() {
    let good = "program,class,predicted [degC],measured [degC]\nA,x,1,2\nA,x,2,2\nB,y,3,5\nB,y,4,4\nC,z,5,4\n";
    let cases: [(&str, String, &[&str]); 8] = [
        (r#""file": "data/no.csv""#, good.to_owned(), &["data/no.csv"]),
        (r#""file": "data/h.csv", "capture": 1"#, good.to_owned(), &["a share of 1", "a share from 0.5 to 0.9999"]),
        (
            r#""file": "data/h.csv", "rules": ["heat-load-25"]"#,
            good.to_owned(),
            &["`heat-load-25` is no margin of temperature"],
        ),
        (r#""file": "data/h.csv", "rules": ["military"]"#, good.to_owned(), &["unknown margin rule `military`"]),
        (r#""file": "data/h.csv""#, good.replace("measured", "seen"), &["measured"]),
        (
            r#""file": "data/h.csv""#,
            good.replace("B,y,4,4\n", "B,y,4,\n"),
            &["`measured` has no value in this row", "h.csv:5"],
        ),
        (
            r#""file": "data/h.csv""#,
            good.replace("B,y,4,4\n", "B,,4,4\n"),
            &["the `class` of this row is empty", "h.csv:5"],
        ),
        (r#""file": "data/h.csv""#, good.replace("C,z,5,4\n", ""), &["has 4 comparisons", "5 rows or more"]),
    ];
    for (settings, file, parts) in cases {
        let study = study(&format!(r#""history": {{"margins-from-history": {{{settings}}}}}"#));
        study.put("data/h.csv", file);
        let said = study.said("pass-1.json");
        for part in parts {
            assert!(said.contains(part), "{part}\n{said}");
        }
    }
    let study = study(r#""history": {"margins-from-history": {"file": "data/h.csv"}}"#);
    study.put("data/h.csv", good);
    study.load();
}

#[test]
fn a_correlation_that_cannot_be_made_is_refused_at_its_place() {
    let cases = [
        (r#""fit": {"correlate": {"criteria": "smc"}}"#, &["unknown criteria profile `smc`", "smc-3k"][..]),
        (r#""fit": {"correlate": {"parameters": ["no"]}}"#, &["unknown parameter `no`"]),
        (
            r#""fit": {"correlate": {"ranges": {"Q": {"from": 1, "to": 9}}}}"#,
            &["`Q` is not changed by this correlation", "one of its `parameters`"],
        ),
        (r#""size": {"conventional": {"from": "match"}}"#, &["`match` is a `compare` job", "a `correlate` job"]),
        (r#""size": {"conventional": {"from": "fit"}}"#, &["unknown correlation `fit`"]),
        (r#""size": {"conventional": {"priors_of": "pass-9.json"}}"#, &["pass-9.json"]),
    ];
    for (jobs, parts) in cases {
        let said = study(jobs).said("pass-1.json");
        for part in parts {
            assert!(said.contains(part), "{part}\n{said}");
        }
        assert!(said.contains("pass-1.json:"), "{said}");
    }
}

/// A phase or a start that is proposed is held against the ranges as one that is measured.
#[test]
fn a_proposed_phase_outside_the_range_of_an_input_is_said_when_it_is_proposed() {
    let design = |inputs: &str| DESIGN.replace(r#""outer""#, &format!(r#""inputs": {{"T_s": {inputs}}}, "outer""#));
    let planned = |design: &str, start: &str| {
        let study = study(&format!(r#"{design}, "plan": {{"test-plan": {{"start": {{"T_s": {start}}}}}}}"#));
        study.edit("model.json", r#""nominal": 90"#, r#""nominal": 90, "range": [70, 110]"#);
        study.said("pass-1.json")
    };
    let count = |said: &str| said.matches("warning[input-range]: `T_s` is").count();
    let within = planned(&design("100"), "80");
    let before = count(&within);
    let phase = planned(&design("120"), "80");
    assert_eq!(count(&phase), before + 1, "{phase}");
    assert!(phase.contains("`T_s` is 120 K here: outside its range, 70 K to 110 K"), "{phase}");
    let start = planned(&design("100"), "60");
    assert!(count(&start) == before + 1 && start.contains("`T_s` is 60 K here"), "{start}");
}
