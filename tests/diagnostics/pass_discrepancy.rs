//! Discrepancies: what is refused, where, and with what to write instead.

use crate::diagnostics::pass_study::Study;

/// A study with so many phases; `deck` gives the inputs of each.
fn study(phases: usize, deck: impl Fn(usize) -> (f64, f64), jobs: &str) -> Study {
    let study = Study::new();
    let rows: String = (0..phases)
        .map(|phase| {
            let (t_if, q) = deck(phase);
            format!("P{phase},{t_if},{q},{},{}\n", t_if + q, t_if - 30.0)
        })
        .collect();
    study.put("data/balance.csv", format!("phase,T_if [degC],Q [W],box [degC],panel [degC]\n{rows}"));
    study.edit("pass-1.json", r#""panel": {"measures": "panel"}"#, r#""panel": {"measures": "panel", "sigma": 0.5}"#);
    study.edit("pass-1.json", r#""held_out": {"phases": ["P2"]}, "ignore": {"P3": "not stabilised"}, "#, "");
    study.edit(
        "pass-1.json",
        r#""tuned": {"calibrate": {"data": ["balance"]}}"#,
        &format!(r#""tuned": {{"calibrate": {{"data": ["balance"]}}}}, {jobs}"#),
    );
    study
}

#[test]
fn what_allows_no_discrepancy_is_refused_at_its_place() {
    let vary = |phase: usize| (10.0 * phase as f64 - 20.0, 5.0);
    let cases = [
        (
            3,
            r#""rest": {"discrepancy": {}}"#,
            &["no sensor has more than 3 readings in phases that are fitted", "5 readings of a sensor or more"][..],
        ),
        (3, r#""rest": {"discrepancy": {"sensors": ["box"]}}"#, &["`box` has 3 readings in phases that are fitted"]),
        (
            7,
            r#""rest": {"discrepancy": {"mode": "joint", "law": "none", "hyperparameters": "maximum"}}"#,
            &["nothing to infer together with the parameters", "the mode `joint` draws hyperparameters"],
        ),
        (
            7,
            r#""rest": {"discrepancy": {"priors": {"lengths": {"Q": {"lognormal": {"median": 1, "factor": 2}}}}}}"#,
            &[
                "the discrepancy does not depend on `Q`: it is 5 W in all phases that are fitted",
                "one that the phases vary: `T_if`",
            ],
        ),
        (
            7,
            r#""rest": {"discrepancy": {"hyperparameters": "maximum", "priors": {"scatter": {"lognormal": {"median": 1, "factor": 1}}}}}"#,
            &["`priors` do nothing where hyperparameters are those"],
        ),
        (
            7,
            r#""rest": {"discrepancy": {"priors": {"scatter": {"lognormal": {"median": 1, "factor": 1}}}}}"#,
            &["factor 1 is not above 1"],
        ),
        (7, r#""rest": {"discrepancy": {"sensors": ["bx"]}}"#, &["unknown sensor of these data `bx`", "`box`"]),
        (
            7,
            r#""rest": {"discrepancy": {"inputs": ["Q"]}}"#,
            &["`Q` cannot explain a discrepancy: it is 5 W in all phases that are fitted"],
        ),
        (7, r#""rest": {"discrepancy": {"from": "match"}}"#, &["`match` is a `compare` job", "a `calibrate` job"]),
        (7, r#""rest": {"discrepancy": {"kernel": "rbf"}}"#, &["squared-exponential", "matern-5/2"]),
        (7, r#""rest": {"discrepancy": {"draws": 3}}"#, &["3 draws", "an integer from 20 to 1000"]),
        (
            7,
            r#""fly": {"predict": {"with": {"discrepancy": "match"}}}"#,
            &["`match` is a `compare` job", "a `discrepancy` job"],
        ),
        (7, r#""fly": {"predict": {"with": {"discrepancy": "rest"}}}"#, &["unknown discrepancy job `rest`"]),
        (
            7,
            r#""other": {"calibrate": {}}, "rest": {"discrepancy": {"from": "other"}}, "fly": {"predict": {"from": "tuned", "with": {"discrepancy": "rest"}}}"#,
            &["`rest` has the residuals of `other`", "a discrepancy after `tuned`"],
        ),
        (
            7,
            r#""rest": {"discrepancy": {"sensors": ["box"]}}, "fly": {"predict": {"with": {"discrepancy": "rest"}}}"#,
            &["no quantity of this prediction is measured by a sensor of `rest`"],
        ),
    ];
    for (phases, jobs, parts) in cases {
        let said = study(phases, vary, jobs).said("pass-1.json");
        for part in parts {
            assert!(said.contains(part), "{part}\n{said}");
        }
        assert!(said.contains("pass-1.json:"), "{said}");
    }
}

#[test]
fn phases_with_the_same_inputs_are_repetitions_and_too_few_others_carry_no_process() {
    let same = |phase: usize| (10.0 * (phase % 4) as f64, 5.0);
    let said = study(8, same, r#""rest": {"discrepancy": {"law": "gaussian-process"}}"#).said("pass-1.json");
    for part in
        ["the phases have 4 different sets of the inputs: `P0` and `P4` have the same", "5 different ones or more"]
    {
        assert!(said.contains(part), "{part}\n{said}");
    }
    let study = study(8, same, r#""rest": {"discrepancy": {}}"#);
    let pass = bmv::job::load(&study.path("pass-1.json")).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
    let warned = pass.warnings.render(false, 9);
    assert!(
        warned.contains("the phases `P0` and `P4` have the same values of the inputs of the discrepancy"),
        "{warned}"
    );
}

#[test]
fn a_process_needs_an_input_that_varies_and_the_inputs_are_named() {
    for mode in [r#""law": "gaussian-process""#, r#""mode": "joint""#] {
        let said = study(6, |_| (20.0, 5.0), &format!(r#""rest": {{"discrepancy": {{{mode}}}}}"#)).said("pass-1.json");
        for part in [
            "no input varies over the phases of `balance` that are fitted: in every phase `T_if` is 20 degC, `Q` is 5 W",
            "5 different ones or more for a Gaussian process",
            "\"law\": \"residual-law\"",
        ] {
            assert!(said.contains(part), "{part}\n{said}");
        }
    }
}

#[test]
fn priors_of_sensors_in_different_units_are_refused_by_their_names() {
    let own = study(
        7,
        |phase| (10.0 * phase as f64, 5.0),
        r#""rest": {"discrepancy": {"priors": {"scatter": {"lognormal": {"median": 1, "factor": 2}}}}}"#,
    );
    own.edit(
        "pass-1.json",
        r#""panel": {"measures": "panel", "sigma": 0.5}"#,
        r#""panel": {"measures": "heat", "sigma": 0.5}"#,
    );
    own.edit("data/balance.csv", "panel [degC]", "panel [W]");
    own.edit(
        "pass-1.json",
        r#""jobs": {"#,
        r#""quantities": {"heat": {"expression": {"of": "Q", "unit": "W"}}}, "jobs": {"#,
    );
    let said = own.said("pass-1.json");
    for part in ["`box` is measured in K and `panel` in W", "sensors of one unit", "such as [\"box\"]"] {
        assert!(said.contains(part), "{part}\n{said}");
    }
}

#[test]
fn a_transient_has_no_discrepancy() {
    let study = Study::new();
    study.edit("pass-1.json", r#""size": {"conventional": {}}"#, r#""rest": {"discrepancy": {"data": ["run"]}}"#);
    study.edit(
        "pass-1.json",
        r#""measurements": {"#,
        &format!(r#""measurements": {{"run": {},"#, crate::diagnostics::pass_study::TRANSIENT),
    );
    let said = study.said("pass-1.json");
    assert!(said.contains("`run` is a transient") && said.contains("cut steady phases from it"), "{said}");
    // Both ways out are accepted as they stand there.
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    let job = &said[said.find(r#"{"predict""#).expect("a job")..];
    study.edit("pass-1.json", r#""rest": {"discrepancy": {"data": ["run"]}}"#, &format!(r#""rest": {job}"#));
    assert!(!study.said("pass-1.json").contains("error["), "{}", study.said("pass-1.json"));
    let windows = r#"{"steady": {"windows": {"A": {"file": "data/run.csv", "to": 60}, "B": {"file": "data/run.csv", "from": 120}},
        "sensors": {"box": {"measures": "box", "sigma": {"value": 0.3, "unit": "K"}}}, "inputs": {"T_if": {"value": 20, "unit": "degC"}, "T_s": 90}}}"#;
    study.edit("pass-1.json", crate::diagnostics::pass_study::TRANSIENT, windows);
    study.edit("pass-1.json", &format!(r#""rest": {job}"#), r#""rest": {"discrepancy": {"data": ["run"]}}"#);
    assert!(!study.said("pass-1.json").contains("is a transient"), "{}", study.said("pass-1.json"));
}
