//! Phases cut from a log: which drift, and who says so.

use std::fmt::Write as _;

use bmv::job::ready::Readiness;
use bmv::measurement::Rows;
use bmv::random::StreamKey;

use super::radiator::run;

/// Plateaus of an hour with a row a minute, four sensors with white noise of 0.05 K; each plateau's slope of the last
/// sensor is given, K/h.
fn study(slopes: &[f64]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let mut noise = StreamKey::new(8, "windows", "noise").stream(0);
    let mut log = String::from("time [s],T_if [K],Q [W],a [K],b [K],c [K],d [K]\n");
    let mut windows = Vec::new();
    for (plateau, slope) in slopes.iter().enumerate() {
        let from = plateau * 7200;
        for minute in 0..60 {
            let [a, b, c, d] = std::array::from_fn(|_| 300.0 + 0.05 * noise.normal());
            let drift = slope * f64::from(minute) / 60.0;
            writeln!(log, "{},290,5,{a:.3},{b:.3},{c:.3},{:.3}", from + 60 * minute as usize, d + drift).expect("text");
        }
        windows.push(format!(r#""W{plateau:02}": {{"file": "log.csv", "from": {from}, "to": {}}}"#, from + 3540));
    }
    let model = r#"{"format": "bmv-network/1", "inputs": {"T_if": {"unit": "K", "nominal": 290}, "Q": {"unit": "W", "nominal": 5}},
        "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.3, 0.7]}}},
        "nodes": {"plate": {"boundary": "T_if"}, "box": {"capacity": 900}},
        "conductors": {"bolts": {"between": ["box", "plate"], "conductance": "G"}}, "loads": {"board": {"into": "box", "power": "Q"}}}"#;
    let sensor = r#"{"measures": "box", "sigma": {"value": 0.1, "unit": "K"}}"#;
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "seed": 1, "measurements": {{"balance": {{"steady": {{"windows": {{{}}},
        "sensors": {{"a": {sensor}, "b": {sensor}, "c": {sensor}, "d": {sensor}}}}}}}}},
        "jobs": {{"delivered": {{"compare": {{}}}}, "missing": {{"diagnose": {{"effects": ["heat-load"]}}}}}}}}"#,
        windows.join(", ")
    );
    for (name, text) in [("model.json", model), ("pass-1.json", &pass), ("log.csv", &log)] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn load(folder: &tempfile::TempDir) -> bmv::study::Pass {
    let pass = bmv::job::load(&folder.path().join("pass-1.json"));
    pass.unwrap_or_else(|wrong| panic!("{}", wrong.render(false, 20)))
}

/// A slope from noise of 0.05 K over an hour has a standard error of 0.022 K/h; the largest of four sensors in a hundred
/// plateaus is above 0.06 K/h, so that a limit of 0.05 K/h would be broken by noise alone again and again.
#[test]
fn steady_plateaus_are_not_said_to_drift() {
    let folder = study(&[0.0; 100]);
    let pass = load(&folder);
    let Rows::Steady(phases) = &pass.measurements[0].rows else { panic!("steady") };
    let limit = 0.05 / 3600.0;
    let steady = |phase: &bmv::measurement::Phase| phase.stabilisation.clone().expect("a window");
    let is_above = |slope: &Option<f64>| slope.is_some_and(|slope| slope.abs() > limit);
    let above = phases.iter().filter(|phase| steady(phase).slopes.iter().any(is_above)).count();
    let drifting = phases.iter().filter(|phase| steady(phase).drifting(&[0, 1, 2, 3], limit).is_some()).count();
    assert!(above >= 8, "{above} of 100 have a slope above the limit");
    assert!(drifting <= 3, "{drifting} of 100 drift, 1 expected at 1 %");
    assert!(pass.measurements[0].doubts.is_empty() && pass.warnings.is_empty(), "{:?}", pass.measurements[0].doubts);
}

#[test]
fn a_plateau_that_drifts_is_named_by_plan_compare_and_diagnose() {
    // The default criteria allow 0.2 K/h.
    let folder = study(&[0.0, 0.4, 0.0, 0.15, -0.5, 0.0]);
    let pass = load(&folder);
    let expected = "2 of 6 phases of balance drift faster than 0.2 K/h: W01 (d by 0.";
    let doubts = &pass.measurements[0].doubts;
    assert!(
        doubts.len() == 1 && doubts[0].message.starts_with(expected) && doubts[0].message.contains("W04 (d by -0."),
        "{doubts:?}"
    );
    assert_eq!(pass.warnings.plain()[0].code, "not-stabilised");
    for (name, readiness) in bmv::job::ready(&pass) {
        let Readiness::Ready(job) = readiness else { panic!("{name}") };
        let stated: Vec<String> = if name == "delivered" {
            let output: bmv::job::compare::Output = run(job.as_ref());
            let drifting: Vec<&str> = (output.stabilisation.iter())
                .filter(|check| check.stabilised == Some(false))
                .map(|check| check.phase.as_str())
                .collect();
            assert_eq!(drifting, ["W01", "W04"]);
            output.warnings
        } else {
            let output: bmv::diagnosis::Output = run(job.as_ref());
            assert_eq!(output.doubts, *doubts);
            output.before_the_verdict()
        };
        let is_stated = stated.iter().any(|line| line.contains(&doubts[0].message));
        assert!(is_stated, "{name}: {stated:?}");
    }
}
