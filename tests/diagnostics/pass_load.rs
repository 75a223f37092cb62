//! A complete study loads, with everything where it belongs; broken ones never panic.

use bmv::job::calibrate::Sampler;
use bmv::job::propagate::Sampling;
use bmv::job::ready::Readiness;
use bmv::measurement::{Initial, Rows, Uncertain};
use bmv::random::Distribution;
use bmv::study::JobSpec;
use bmv::study::rule::Margin;
use bmv::study::variable::Variable;

use crate::diagnostics::pass_study::{BALANCE, PASS, RUN, Study, transient_pass};

#[test]
fn a_complete_study_resolves_to_si_and_indices() {
    let pass = Study::new().load();
    assert!(pass.warnings.is_empty(), "{}", pass.warnings.render(false, 9));
    assert_eq!((pass.seed, pass.file.as_str(), pass.title.as_str()), (7, "pass-1.json", "First"));
    assert_eq!(pass.priors[0], Distribution::Uniform { lower: 0.2, upper: 1.4 });
    assert_eq!(pass.priors[1], Distribution::Fixed(0.04));
    assert_eq!(pass.changes[0].because, "torque not recorded");
    assert_eq!(pass.changes[0].prior[0], Distribution::Uniform { lower: 0.4, upper: 1.2 });
    let requirement = &pass.requirements[0];
    assert_eq!(pass.model.quantities[requirement.quantity].name, "panel");
    assert_eq!(requirement.below, Some(-30.0 + 273.15));
    assert_eq!(pass.environments[0].inputs, [40.0 + 273.15, 5.0, 90.0]);
    let measurement = &pass.measurements[0];
    let Rows::Steady(phases) = &measurement.rows else { panic!("steady") };
    assert_eq!(phases[2].inputs, [40.0 + 273.15, 8.0, 90.0]);
    assert_eq!(phases.iter().map(|phase| phase.held_out).collect::<Vec<_>>(), [false, true, false]);
    assert_eq!(phases[2].ignored.as_deref(), Some("not stabilised"));
    assert_eq!(measurement.reading(0, 1), Some(-20.25 + 273.15));
    assert_eq!(measurement.reading(1, 1), None);
    assert_eq!(measurement.sensors[0].sigma, Some(Uncertain::Known(0.25)));
    assert_eq!((measurement.sensors[1].sigma.clone(), measurement.sensors[1].unit.as_str()), (None, "degC"));
    assert_eq!(measurement.unused_columns, ["note"]);
    assert_eq!(measurement.sha256, bmv::document::hash::sha256_hex(BALANCE.as_bytes()));
    // T_if states its range, and T_s has no column.
    assert_eq!(pass.ranges_from_data, ["Q"]);
    assert_eq!(pass.model.inputs[1].range, Some([5.0, 8.0]));
}

/// Trajectories ask for gradients of all rows: where nothing is said, a long record takes one likelihood a draw.
#[test]
fn the_sampler_of_a_calibration_suits_the_length_of_its_record() {
    let sampler = |rows: usize, settings: &str| {
        let study = Study::transient();
        let log: String = (0..rows).map(|row| format!("{},5,2{}.5\n", 60 * row, row % 7)).collect();
        study.put("data/run.csv", format!("time [s],Q [W],box [degC]\n{log}"));
        study.edit("pass-1.json", r#"{"data": ["balance"]}"#, settings);
        let pass = study.load();
        let Some(tuned) = pass.jobs[3].spec.get::<bmv::job::calibrate::Spec>() else { panic!("calibrate") };
        (tuned.sampler, tuned.draws)
    };
    assert_eq!(sampler(199, "{}"), (Sampler::Nuts, 1000));
    assert_eq!(sampler(200, "{}"), (Sampler::IndependenceMetropolis, 2000));
    assert_eq!(sampler(200, r#"{"sampler": "nuts"}"#), (Sampler::Nuts, 1000));
    // Only trajectories aim at an acceptance.
    assert_eq!(sampler(200, r#"{"acceptance": 0.95}"#), (Sampler::Nuts, 1000));
}

#[test]
fn jobs_have_their_defaults() {
    let pass = Study::new().load();
    let kinds: Vec<_> = pass.jobs.iter().map(|job| (job.name.as_str(), job.spec.kind())).collect();
    assert_eq!(
        kinds,
        [("spread", "propagate"), ("match", "compare"), ("size", "conventional"), ("tuned", "calibrate")]
    );
    let Some(spread) = pass.jobs[0].spec.get::<bmv::job::propagate::Spec>() else { panic!("propagate") };
    assert_eq!((spread.samples, spread.sampling, spread.failure_limit), (1024, Sampling::Sobol, 0.01));
    assert_eq!(spread.quantities, [pass.requirements[0].quantity]);
    assert_eq!(spread.environments[0].name, "hot");
    let Some(compare) = pass.jobs[1].spec.get::<bmv::job::compare::Spec>() else { panic!("compare") };
    assert_eq!(
        (compare.data.as_slice(), compare.criteria.name.as_str(), compare.from.as_str()),
        (&[0][..], "smc-3k", "nominal")
    );
    let Some(size) = pass.jobs[2].spec.get::<bmv::job::conventional::Spec>() else { panic!("conventional") };
    assert_eq!((size.design.variable, size.design.values.as_slice()), (Variable::Parameter(1), &[0.01, 0.1][..]));
    assert_eq!(size.heat_loads, [Variable::Input(1)]);
    assert_eq!(size.rules.last().map(|rule| rule.margin), Some(Margin::HeatLoad(0.25)));
    let Some(tuned) = pass.jobs[3].spec.get::<bmv::job::calibrate::Spec>() else { panic!("calibrate") };
    assert_eq!(tuned.data, [0]);
    assert_eq!(tuned.parameters, [0], "A has no prior");
    assert_eq!((tuned.sampler, tuned.chains, tuned.warmup, tuned.draws), (Sampler::Nuts, 4, 500, 1000));
    assert_eq!(compare.calibration.as_deref(), Some("tuned"), "the comparison shows the calibration on its data");
}

#[test]
fn a_comparison_from_nominal_shows_no_calibration() {
    let study = Study::new();
    study.edit("pass-1.json", r#"{"compare": {}}"#, r#"{"compare": {"from": "nominal"}}"#);
    let pass = study.load();
    let Some(compare) = pass.jobs[1].spec.get::<bmv::job::compare::Spec>() else { panic!("compare") };
    assert_eq!(compare.calibration, None);
}

#[test]
fn a_comparison_waits_for_its_calibration() {
    let study = Study::new();
    study.edit("pass-1.json", r#""panel": {"measures": "panel"}"#, r#""panel": {"measures": "panel", "sigma": 0.5}"#);
    let jobs = bmv::job::ready(&study.load());
    let Readiness::After(waiting) = &jobs[1].1 else { panic!("after the calibration") };
    assert_eq!((waiting.from.len(), waiting.from[0].job.as_str()), (1, "tuned"));
    let result = |json| [std::sync::Arc::new(json)];
    assert!(waiting.prepare(&result(serde_json::json!({"tuned": [["G", 0.7]], "converged": true}))).is_ok());
    assert!(waiting.prepare(&result(serde_json::json!({}))).is_err());
}

#[test]
fn settings_of_jobs_are_taken_in_the_variables_own_unit() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#"{"samples": 1024}"#,
        r#"{"quantities": ["leak", "box"], "sampling": "latin-hypercube", "samples": 1000, "environments": ["nominal"],
            "sweep": {"T_if": {"from": -10, "to": 30, "steps": 5}}, "joint": [["box", "leak"]]}"#,
    );
    let pass = study.load();
    let Some(spec) = pass.jobs[0].spec.get::<bmv::job::propagate::Spec>() else { panic!("propagate") };
    let sweep = spec.sweep.as_ref().expect("a sweep");
    assert_eq!(sweep.values, [263.15, 273.15, 283.15, 293.15, 303.15]);
    assert_eq!((sweep.unit.as_str(), spec.samples), ("degC", 1000));
    let names: Vec<_> = spec.quantities.iter().map(|index| pass.model.quantities[*index].name.as_str()).collect();
    assert_eq!(names, ["leak", "box", "panel"]);
    assert_eq!(spec.joint, [[1, 0]]);
    assert_eq!(spec.environments[0].inputs, [293.15, 5.0, 90.0]);
}

#[test]
fn a_transient_has_its_start_its_steps_and_its_intervals() {
    let study = Study::transient();
    study.edit("pass-1.json", r#""hold""#, r#""ignore": {"start": {"to": 30, "because": "door open"}}, "hold""#);
    let pass = study.load();
    let Rows::Transient { inputs, initial, held_out, ignored } = &pass.measurements[0].rows else {
        panic!("transient")
    };
    assert_eq!(inputs.times_s, [0.0, 60.0, 120.0, 180.0]);
    assert_eq!((inputs.columns.len(), inputs.columns[0].hold), (1, true));
    assert_eq!(inputs.columns[0].values, [5.0, 5.0, 0.0, 0.0]);
    let Initial::Temperatures { values: temperatures, .. } = initial else { panic!("temperatures") };
    assert_eq!(temperatures[2], Uncertain::Known(293.15));
    assert_eq!(held_out, &[false, false, true, true]);
    assert_eq!(ignored[0].as_deref(), Some("door open"));
    assert_eq!(ignored[1], None);
}

#[test]
fn windows_give_means_and_steadiness() {
    let study = Study::new();
    study.edit(
        "pass-1.json",
        r#""file": "data/balance.csv","#,
        r#""windows": {"P1": {"file": "data/series.csv", "from": 0, "to": {"value": 2, "unit": "min"}, "inputs": {"T_if": {"value": 20, "unit": "degC"}}},
           "P2": {"file": "data/series.csv", "from": {"value": 3, "unit": "min"}}, "P3": {"file": "data/series.csv"}},"#,
    );
    let mut series = "time [min],Q [W],box [degC],panel [degC]\n".to_owned();
    for minute in 0..6 {
        let box_c = 20.0 + 0.5 * f64::from(minute);
        series.push_str(&format!("{minute},{},{box_c},\n", if minute < 3 { 5 } else { 8 }));
    }
    study.put("data/series.csv", series);
    let pass = study.load();
    let measurement = &pass.measurements[0];
    let Rows::Steady(phases) = &measurement.rows else { panic!("steady") };
    assert_eq!((phases[0].inputs[1], phases[1].inputs[1]), (5.0, 8.0));
    // Means of 20, 20.5, 21 and of 21.5, 22, 22.5 degC; a drift of 0.5 K a minute.
    assert!((measurement.reading(0, 0).expect("a mean") - 293.65).abs() < 1e-12);
    assert!((measurement.reading(1, 0).expect("a mean") - 295.15).abs() < 1e-12);
    assert_eq!(measurement.reading(0, 1), None);
    let steadiness = phases[0].stabilisation.as_ref().expect("a window");
    assert_eq!((steadiness.from_s, steadiness.to_s), (0.0, 120.0));
    assert!((steadiness.slopes[0].expect("a slope") - 0.5 / 60.0).abs() < 1e-12);
    assert!(steadiness.mean_errors[0].expect("an error") < 1e-9);
    assert_eq!(steadiness.slopes[1], None);
    assert!(phases[1].held_out && phases[2].ignored.is_some());
}

#[test]
fn declared_columns_another_separator_and_crlf_are_read() {
    let study = Study::new();
    study.put(
        "data/balance.csv",
        "\u{feff}Phase name;Box (degC);panel [degC]\r\n P1 ; 24.5 ;-20\r\nP2;5.5;\r\nP3;1;2\r\n",
    );
    study.edit(
        "pass-1.json",
        r#""held_out""#,
        r#""separator": ";", "columns": {"phase": {"header": "Phase name"}, "box": {"header": "Box (degC)", "unit": "degC"}}, "held_out""#,
    );
    let pass = study.load();
    assert_eq!(pass.measurements[0].reading(0, 0), Some(24.5 + 273.15));
    assert_eq!(pass.measurements[0].len(), 3);
}

#[test]
fn a_pass_inherits_and_changes_what_it_names() {
    let study = Study::new();
    study.put(
        "pass-2.json",
        r#"{"format": "bmv-pass/1", "parent": "pass-1.json", "parameters": {"G": null}, "requirements": {"cold": null},
            "jobs": {"spread": {"propagate": {}}}}"#,
    );
    let first = study.load();
    let second = bmv::job::load(&study.path("pass-2.json")).expect("loads");
    assert_eq!(second.parents, ["pass-1.json"]);
    assert_eq!((second.seed, second.measurements.len()), (7, 1));
    let names: Vec<_> = second.jobs.iter().map(|job| job.name.as_str()).collect();
    assert_eq!(names, ["spread", "comparison"], "jobs are not inherited; measurements are compared at least");
    assert!(second.requirements.is_empty() && second.changes.is_empty());
    assert_eq!(second.priors[0], Distribution::Uniform { lower: 0.4, upper: 1.2 });
    assert_ne!(first.definition_sha256, second.definition_sha256);
    // The model's one named quantity, as no requirement asks for others.
    let Some(spec) = second.jobs[0].spec.get::<bmv::job::propagate::Spec>() else { panic!("propagate") };
    assert_eq!((spec.quantities.as_slice(), spec.samples), (&[0][..], 4096));
    // White space is no part of the definition.
    study.put("pass-1.json", PASS.replace(": {", ":  {"));
    assert_eq!(study.load().definition_sha256, first.definition_sha256);
}

#[test]
fn missing_pinned_data_leave_their_jobs_waiting() {
    let study = Study::new();
    let sha256 = bmv::document::hash::sha256_hex(BALANCE.as_bytes());
    let pinned = format!(r#""pinned": {{"sha256": "{sha256}", "licence": "CC0"}}, "held_out""#);
    study.edit("pass-1.json", r#""held_out""#, &pinned);
    assert!(study.load().missing.is_empty());
    std::fs::remove_file(study.path("data/balance.csv")).expect("removed");
    let pass = study.load();
    let (_, stated) = bmv::study::resolve::pinned(&study.path("pass-1.json")).expect("read");
    assert_eq!((&stated, stated[0].sha256.as_str()), (&pass.missing, sha256.as_str()));
    assert_eq!((pass.measurements.len(), pass.missing.len()), (0, 1));
    let JobSpec::Waiting { kind, measurements, command } = &pass.jobs[1].spec else { panic!("waits") };
    assert_eq!((*kind, measurements.as_slice()), ("compare", &["balance".to_owned()][..]));
    assert_eq!(command, &format!("bmv data get {}", study.path("").display().to_string().trim_end_matches('/')));
    assert!(pass.jobs[0].spec.get::<bmv::job::propagate::Spec>().is_some(), "the other jobs run");
}

#[test]
fn a_circle_of_parents_and_a_pass_that_is_not_there() {
    let study = Study::new();
    study.edit("pass-1.json", r#""parent": null"#, r#""parent": "pass-2.json""#);
    study.put("pass-2.json", r#"{"format": "bmv-pass/1", "parent": "pass-1.json"}"#);
    assert!(study.said("pass-1.json").contains("pass-1.json -> pass-2.json -> pass-1.json"));
    assert!(study.said("pass-9.json").contains("the file `pass-9.json` does not exist"));
    assert!(study.said("nowhere/pass-1.json").contains("cannot be read"));
}

/// Broken off anywhere, a file gives an error or loads, and never panics.
#[test]
#[ignore = "thorough"]
fn files_broken_off_at_every_third_byte_never_panic() {
    load_broken_off(3);
}

fn load_broken_off(every: usize) {
    let study = Study::new();
    for (name, text) in [("pass-1.json", PASS), ("data/balance.csv", BALANCE)] {
        for end in (0..text.len()).step_by(every) {
            study.put(name, &text.as_bytes()[..end]);
            let result = bmv::job::load(&study.path("pass-1.json"));
            // The files end in a brace and a line feed, or in an empty cell of a note.
            assert!(result.is_err() || end + 10 >= text.len() || name.ends_with("csv"), "{name} {end}");
        }
        study.put(name, text);
    }
    let study = Study::transient();
    let pass = transient_pass();
    for (name, text) in [("pass-1.json", pass.as_str()), ("data/run.csv", RUN)] {
        for end in (0..text.len()).step_by(every) {
            study.put(name, &text.as_bytes()[..end]);
            if let Err(diagnostics) = bmv::job::load(&study.path("pass-1.json")) {
                assert!(!diagnostics.render(false, 5).is_empty());
            }
        }
        study.put(name, text);
    }
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly"]
    fn files_broken_off_anywhere_never_panic() {
        load_broken_off(1);
    }
}
