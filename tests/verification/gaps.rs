//! A transient with a long gap: in parts it is not carried through what nobody recorded.

use bmv::job::ready::Readiness;
use bmv::measurement::Rows;

use super::radiator::run;

/// A box of 900 J/K on a plate at 290 K by 0.5 W/K, exactly: 10 W for an hour, six hours without rows in which the
/// heater was off and the box cooled, then 4 W for an hour.
fn study(transient: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let balance = |power: f64, start: f64, t: f64| {
        let end = 290.0 + power / 0.5;
        end + (start - end) * bmv::math::functions::exp(-t * 0.5 / 900.0)
    };
    let mut table = String::from("time [s],Q [W],box [K]\n");
    for row in 0..=60 {
        let t = 60.0 * f64::from(row);
        table.push_str(&format!("{t},10,{:.6}\n", balance(10.0, 290.0, t)));
    }
    for row in 0..=60 {
        let t = 60.0 * f64::from(row);
        table.push_str(&format!("{},4,{:.6}\n", 25_200.0 + t, balance(4.0, 291.0, t)));
    }
    let model = r#"{"format": "bmv-network/1", "inputs": {"Q": {"unit": "W", "nominal": 5, "range": [0, 20]}},
        "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.3, 0.7]}}},
        "nodes": {"plate": {"boundary": 290}, "box": {"capacity": 900}},
        "conductors": {"bolts": {"between": ["box", "plate"], "conductance": "G"}}, "loads": {"board": {"into": "box", "power": "Q"}}}"#;
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "seed": 1, "measurements": {{"log": {{"transient": {{"file": "log.csv", {transient},
        "hold": ["Q"], "sensors": {{"box": {{"measures": "box", "sigma": {{"value": 0.1, "unit": "K"}}}}}}}}}}}},
        "jobs": {{"delivered": {{"compare": {{"data": ["log"]}}}}}}}}"#
    );
    for (name, text) in [("model.json", model), ("pass-1.json", &pass), ("log.csv", &table)] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn load(folder: &tempfile::TempDir) -> Result<bmv::study::Pass, String> {
    bmv::job::load(&folder.path().join("pass-1.json")).map_err(|wrong| wrong.render(false, 20))
}

fn rmse(folder: &tempfile::TempDir) -> f64 {
    let pass = load(folder).expect("right");
    let ready = bmv::job::ready(&pass).into_iter().find(|(name, _)| name == "delivered");
    let Some((_, Readiness::Ready(job))) = ready else { panic!("a comparison needs nothing") };
    let output: bmv::job::compare::Output = run(job.as_ref());
    assert_eq!(output.train.count + output.held_out.count, 122, "all parts are compared");
    [output.train, output.held_out].iter().filter(|part| part.count > 0).map(|part| part.rmse).fold(0.0, f64::max)
}

#[test]
fn a_transient_begins_anew_after_a_gap_that_is_too_long() {
    let through = study(r#""initial": {"measured": {}}"#);
    let parted = study(
        r#""initial": {"measured": {}}, "max_gap": {"value": 10, "unit": "min"}, "held_out": {"intervals": [{"from": 26000}]}"#,
    );
    let pass = load(&parted).expect("right");
    let names: Vec<&str> = pass.measurements.iter().map(|measurement| measurement.name.as_str()).collect();
    assert_eq!(names, ["log", "log (part 2)"]);
    for (measurement, held_out) in pass.measurements.iter().zip([0, 47]) {
        let Rows::Transient { inputs, held_out: rows, .. } = &measurement.rows else { panic!("a transient") };
        assert_eq!((inputs.times_s.len(), rows.iter().filter(|row| **row).count()), (61, held_out));
        assert!(measurement.doubts.is_empty(), "{:?}", measurement.doubts);
    }
    // 10 W until the first row after the gap leave the box at 310 K, where it was at 291 K.
    assert!(rmse(&through) > 3.0, "{}", rmse(&through));
    assert!(rmse(&parted) < 1e-3, "{}", rmse(&parted));
}

#[test]
fn what_cannot_begin_anew_is_refused_at_its_place() {
    let stated = study(r#""initial": {"temperatures": {"all": 290}}, "max_gap": {"value": 10, "unit": "min"}"#);
    let said = load(&stated).expect_err("one start, two parts");
    assert!(said.contains("error[initial-temperatures]") && said.contains("pass-1.json:1:"), "{said}");
    let negative = study(r#""initial": {"measured": {}}, "max_gap": {"value": -1, "unit": "s"}"#);
    let said = load(&negative).expect_err("no time");
    assert!(said.contains("a gap of -1 s") && said.contains("a time above 0 s"), "{said}");
    // A limit that no gap exceeds changes nothing.
    let one = study(r#""initial": {"temperatures": {"all": 290}}, "max_gap": {"value": 1, "unit": "d"}"#);
    assert_eq!(load(&one).expect("right").measurements.len(), 1);
}
