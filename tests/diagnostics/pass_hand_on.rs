//! Posteriors and files of draws as priors, and predictions: what is refused, where, and what is not.

use bmv::job::ready::Readiness;
use bmv::job::{load, ready};

use crate::diagnostics::pass_study::Study;

/// The first pass with a noise for every sensor, and a second whose prior is the posterior of the first.
fn posterior_priors(extra: &str) -> Study {
    let study = Study::new();
    study.edit("pass-1.json", r#""panel": {"measures": "panel"}"#, r#""panel": {"measures": "panel", "sigma": 0.5}"#);
    study.put(
        "pass-2.json",
        format!(
            r#"{{"format": "bmv-pass/1", "title": "Second", "parent": "pass-1.json",
 "parameters": {{"G": {{"prior": {{"posterior": {{"pass": "pass-1.json", "job": "tuned"}}}}, "because": "handed on"}}}},
 {extra}}}"#
        ),
    );
    study
}

/// The measurement of the first pass with other rows held out.
fn held_out(phases: &str) -> String {
    format!(
        r#""measurements": {{"balance": {{"steady": {{"file": "data/balance.csv",
   "sensors": {{"box": {{"measures": "box", "sigma": 0.25}}, "panel": {{"measures": "panel", "sigma": 0.5}}}},
   "held_out": {{"phases": [{phases}]}}, "ignore": {{"P3": "not stabilised"}}}}}}}},"#
    )
}

#[test]
fn the_same_rows_are_refused_and_named() {
    for job in [r#"{"calibrate": {}}"#, r#"{"diagnose": {}}"#, r#"{"diagnose": {"data": ["balance"]}}"#] {
        let said = posterior_priors(&format!(r#""jobs": {{"again": {job}}}"#)).said("pass-2.json");
        for part in [
            "error[data-used-twice]",
            "on readings that stand behind its prior: `tuned` of `pass-1.json` was fitted to phase P1 of `balance`",
            "study/pass-2.json:3:11",
            "the posterior of `tuned` of `pass-1.json`",
            "\"held_out\": {\"phases\": [...]}",
            "give `G` the prior that `tuned` of `pass-1.json` began with",
        ] {
            assert!(said.contains(part), "{part}\n{said}");
        }
    }
}

#[test]
fn what_takes_distributions_does_not_run_with_draws() {
    for job in [r#"{"goal": {"design_variable": {"A": {"from": 0.01, "to": 0.1}}}}"#, r#"{"sensitivity": {}}"#] {
        let study = posterior_priors(&format!(r#"{} "jobs": {{"next": {job}}}"#, held_out(r#""P1""#)));
        let pass = load(&study.path("pass-2.json")).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
        let jobs = ready(&pass);
        let Readiness::Refused(why) = &jobs[0].1 else { panic!("{job} runs with the original prior") };
        let plain = why[0].diagnostic.plain();
        assert!(plain.message.contains("`G` has the draws of `tuned` of `pass-1.json`"), "{}", plain.message);
        assert_eq!((plain.code.as_str(), plain.path.as_str()), ("job-refused", "$.jobs.next"));
    }
}

#[test]
fn a_diagnosis_waits_for_the_posterior_that_is_its_prior() {
    let study = posterior_priors(&format!(r#"{} "jobs": {{"next": {{"diagnose": {{}}}}}}"#, held_out(r#""P1""#)));
    let pass = load(&study.path("pass-2.json")).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
    let jobs = ready(&pass);
    let Readiness::After(waiting) = &jobs[0].1 else { panic!("after the calibration of the first pass") };
    assert_eq!((waiting.from[0].file.as_str(), waiting.from[0].job.as_str()), ("pass-1.json", "tuned"));
    // Of a parameter that is not inferred nothing enters.
    let study = posterior_priors(r#""jobs": {"next": {"diagnose": {"parameters": []}}}"#);
    let pass = load(&study.path("pass-2.json")).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
    assert!(matches!(ready(&pass)[0].1, Readiness::Ready(_)));
}

#[test]
fn other_rows_of_the_same_file_are_allowed() {
    let study = posterior_priors(&format!(r#"{} "jobs": {{"again": {{"calibrate": {{}}}}}}"#, held_out(r#""P1""#)));
    let pass = load(&study.path("pass-2.json")).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
    assert_eq!(pass.posterior_priors.len(), 1);
    assert_eq!(
        (pass.posterior_priors[0].draws.names.as_slice(), pass.posterior_priors[0].behind.len()),
        (&["G".to_owned()][..], 1)
    );
    // Scores are taken by the prior that the calibration began with.
    assert_eq!(pass.priors[0], bmv::random::Distribution::Uniform { lower: 0.2, upper: 1.4 });
    let jobs = ready(&pass);
    let Readiness::After(waiting) = &jobs[0].1 else { panic!("after the calibration of the first pass") };
    assert_eq!((waiting.from[0].file.as_str(), waiting.from[0].job.as_str()), ("pass-1.json", "tuned"));
}

#[test]
fn data_behind_a_posterior_s_own_prior_count_too() {
    let study = posterior_priors(&format!(r#"{} "jobs": {{"again": {{"calibrate": {{}}}}}}"#, held_out(r#""P1""#)));
    study.put(
        "pass-3.json",
        format!(
            r#"{{"format": "bmv-pass/1", "title": "Third", "parent": "pass-1.json",
 "parameters": {{"G": {{"prior": {{"posterior": {{"pass": "pass-2.json", "job": "again"}}}}, "because": "handed on"}}}},
 {} "jobs": {{"third": {{"calibrate": {{}}}}}}}}"#,
            held_out("")
        ),
    );
    let said = study.said("pass-3.json");
    assert!(said.contains("`tuned` of `pass-1.json` was fitted to phase P1 of `balance`"), "{said}");
    assert!(said.contains("`again` of `pass-2.json` was fitted to phase P2 of `balance`"), "{said}");
}

#[test]
fn a_parameter_that_is_not_calibrated_may_have_any_posterior() {
    // Nothing of the posterior enters: A alone is inferred.
    let extra = r#""jobs": {"again": {"calibrate": {"parameters": ["A"]}}}"#;
    let study = posterior_priors(extra);
    study.edit("pass-2.json", r#"{"G""#, r#"{"A": {"prior": {"uniform": [0.03, 0.05]}, "because": "paint"}, "G""#);
    let pass = load(&study.path("pass-2.json")).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
    assert!(matches!(ready(&pass)[0].1, Readiness::Ready(_)));
}

#[test]
fn posteriors_that_are_not_there() {
    let said = |from: &str, to: &str| {
        let study = posterior_priors(r#""jobs": {"spread": {"propagate": {}}}"#);
        study.edit("pass-2.json", from, to);
        study.said("pass-2.json")
    };
    let text = said(r#""job": "tuned""#, r#""job": "match""#);
    assert!(
        text.contains("`match` of `pass-1.json` is a `compare` job") && text.contains("a `calibrate` job"),
        "{text}"
    );
    let text = said(r#""job": "tuned""#, r#""job": "tund""#);
    assert!(
        text.contains("unknown calibration of `pass-1.json` `tund`") && text.contains("did you mean `tuned`?"),
        "{text}"
    );
    let text = said(r#"{"pass": "pass-1.json""#, r#"{"pass": "pass-2.json""#);
    assert!(text.contains("`pass-2.json` cannot take its own posterior as a prior"), "{text}");
    let text = said(r#"{"pass": "pass-1.json""#, r#"{"pass": "../pass-1.json""#);
    assert!(text.contains("path-refused"), "{text}");
    let text = said(r#"{"G": {"prior""#, r#"{"A": {"prior""#);
    assert!(text.contains("`tuned` of `pass-1.json` did not infer `A`") && text.contains("it inferred `G`"), "{text}");
}

#[test]
fn posteriors_in_a_circle() {
    let study = posterior_priors(r#""jobs": {"again": {"calibrate": {}}}"#);
    study.edit(
        "pass-1.json",
        r#"{"uniform": [0.2, 1.4]}"#,
        r#"{"posterior": {"pass": "pass-2.json", "job": "again"}}"#,
    );
    let said = study.said("pass-1.json");
    assert!(said.contains("the posteriors run in a circle: pass-1.json -> pass-2.json -> pass-1.json"), "{said}");
}

#[test]
fn files_of_draws() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"uniform": [0.2, 1.4]}"#, r#"{"draws": {"file": "data/draws.csv"}}"#);
    study.put("data/draws.csv", "draw,G [W/K]\n1,0.4\n2,0.5\n3,0.62\n");
    let pass = study.load();
    assert_eq!(pass.posterior_priors[0].draws.draws, [[0.4], [0.5], [0.62]]);
    let jobs = ready(&pass);
    assert!(matches!(jobs[0].1, Readiness::Ready(_)), "draws of a file wait for nothing");
    for (text, part) in [
        ("G [W/K]\n0.4\n", "has 1 draw"),
        ("H [W/K]\n0.4\n0.5\n", "has no column `G`"),
        ("G [K]\n0.4\n0.5\n", "study/data/draws.csv:1:1"),
        ("G [W/K]\n0.4\n\n0.5\nx\n", "table-cell"),
    ] {
        study.put("data/draws.csv", text);
        let said = study.said("pass-1.json");
        assert!(said.contains(part), "{part}\n{said}");
    }
}

#[test]
fn draws_are_no_prior_of_a_noise() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#""panel": {"measures": "panel"}"#,
        r#""panel": {"measures": "panel", "sigma": {"prior": {"posterior": {"pass": "pass-0.json", "job": "x"}}}}"#,
    );
    assert!(study.said("pass-1.json").contains("error[prior-not-read]: draws cannot be the prior of what is inferred"));
}

#[test]
fn predictions_name_a_calibration() {
    let said = |job: &str| posterior_priors(&format!(r#""jobs": {{"flight": {job}}}"#)).said("pass-2.json");
    let text = said(r#"{"predict": {}}"#);
    assert!(text.contains("`flight` does not say `from` which calibration, and the pass has 0"), "{text}");
    let text = said(r#"{"predict": {"from": "tuned"}}"#);
    assert!(text.contains("unknown calibration `tuned`"), "{text}");
    let text = said(r#"{"predict": {"from": {"pass": "pass-1.json", "job": "tuned"}, "with": {"discrepancy": "gp"}}}"#);
    assert!(text.contains("unknown discrepancy job `gp`"), "{text}");
    let text = said(r#"{"predict": {"from": {"pass": "pass-1.json", "job": "tuned"}, "with": {"discrepancy": 7}}}"#);
    assert!(text.contains("an object of names, each a number"), "{text}");
    let study =
        posterior_priors(r#""jobs": {"flight": {"predict": {"from": {"pass": "pass-1.json", "job": "tuned"}}}}"#);
    let pass = load(&study.path("pass-2.json")).unwrap_or_else(|e| panic!("{}", e.render(false, 9)));
    let Some(spec) = pass.jobs[0].spec.get::<bmv::job::predict::Prediction>() else { panic!("predict") };
    assert_eq!(spec.posterior.draws.parameters, [0]);
    assert_eq!(spec.priors, [(0, bmv::random::Distribution::Uniform { lower: 0.2, upper: 1.4 })]);
}

#[test]
fn a_sensor_without_noise_stops_its_calibration_alone() {
    let study = Study::new();
    let pass = study.load();
    assert!(pass.warnings.is_empty());
    let plain = pass.refused[0].diagnostic.plain();
    assert_eq!((plain.code.as_str(), plain.line, pass.refused[0].job.as_str()), ("no-sigma", 6, "tuned"));
    assert!(plain.message.contains("sensor `panel` of `balance` has no `sigma`"), "{}", plain.message);
    assert!(plain.help.is_some_and(|help| help.contains(r#"write "sigma": {"value": ..., "unit": "K"}"#)));
    let jobs = ready(&pass);
    assert!(matches!(&jobs[1].1, Readiness::Ready(job) if job.kind() == "compare"), "without the tuned state");
    assert!(matches!(&jobs[3].1, Readiness::Refused(why) if why[0].reason.contains("has no `sigma`")));
}

#[test]
fn data_with_errors_of_their_own_are_behind_no_prior_twice() {
    // The one measurement is wrong, so that none is there; and beside another one, which is not taken for it.
    for other in [
        "",
        r#""measurements": {"before": {"steady": {"file": "data/before.csv", "sensors": {"box": {"measures": "box", "sigma": 0.25}}}}},"#,
    ] {
        let study =
            posterior_priors(&format!(r#"{} "jobs": {{"again": {{"calibrate": {{"data": ["balance"]}}}}}}"#, other));
        study.put("data/before.csv", "phase,T_if [degC],Q [W],T_s [K],box [degC]\nP1,20,5,90,24.5\n");
        study.edit("data/balance.csv", "P1,20,5,24.5", "P1,20,x,24.5");
        let said = study.said("pass-2.json");
        assert!(said.contains("`x` is not a number") && !said.contains("data-used-twice"), "{said}");
    }
}
