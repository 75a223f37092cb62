//! Tests of `src/job/compare/view.rs`.

use bmv::job::compare::deviation::deviation;
use bmv::job::compare::output::{Deviation, Output, SensorSummary};
use bmv::job::compare::view::*;
use bmv::job::compare::{Kind, Row};
use bmv::job::kind::JobKind;
use bmv::study::profile::Criteria;
use serde_json::{Value, json};

fn row(measurement: &str, deviation: f64, held_out: bool) -> Row {
    Row {
        measurement: measurement.into(),
        phase: Some("P".into()),
        time_s: None,
        sensor: "s".into(),
        unit: "K".into(),
        measured: 300.0 + deviation,
        predicted: 300.0,
        predicted_tuned: None,
        held_out,
    }
}

fn output(units: [&str; 2]) -> Output {
    let rows = vec![row("a", 1.0, false), row("a", 3.0, false), row("b", 5.0, false), row("b", -2.0, true)];
    let summary = |measurement: &str, unit: &str| {
        let of = |held_out: bool| -> Vec<f64> {
            let measurement_rows = rows.iter().filter(|r| r.measurement == measurement && r.held_out == held_out);
            measurement_rows.map(|r| r.measured - r.predicted).collect()
        };
        SensorSummary {
            measurement: measurement.into(),
            sensor: "s".into(),
            unit: unit.into(),
            sigma: Some(0.5),
            train: deviation(&of(false), None),
            held_out: deviation(&of(true), None),
            noise_rmse: Some([0.1, 0.9]),
            missing: 1,
            tuned: None,
        }
    };
    Output {
        state: "nominal".into(),
        parameters: vec![("G".into(), "W/K".into(), 0.5)],
        sensors: vec![summary("a", units[0]), summary("b", units[1])],
        rows: rows.into_iter().collect(),
        phases: vec![],
        train: Deviation::default(),
        held_out: Deviation::default(),
        chi2_per_reading: None,
        criteria: Criteria {
            name: String::new(),
            title: String::new(),
            each_k: None,
            mean_k: None,
            sd_k: None,
            share: None,
            stabilisation_k_per_s: None,
            source: String::new(),
        },
        verdicts: vec![],
        heat: vec![],
        trends: vec![],
        stabilisation: vec![],
        fails: vec!["s: too cold".into()],
        failed: vec![],
        unused_columns: vec![],
        warnings: vec![],
        tuned: None,
        converged: None,
    }
}

#[test]
fn a_sensor_of_two_measurements_is_one_and_each_stands_apart_too() {
    let document = view(&output(["K", "K"]));
    let delivered = &document["sensors"]["s"]["delivered"];
    // By hand: 1, 3, 5 for fits, -2 held out.
    assert_eq!((&delivered["count"], &delivered["mean"], &delivered["sd"]), (&json!(3), &json!(3.0), &json!(2.0)));
    assert_eq!((&delivered["max"], &delivered["rmse_held_out"]), (&json!(5.0), &json!(2.0)));
    assert_eq!(document["measurements"]["a"]["s"]["delivered"]["mean"], 2.0);
    assert_eq!(document["measurements"]["a"]["s"]["delivered"]["rmse_held_out"], Value::Null);
    assert_eq!(document["sensors"]["s"]["missing"], 2);
    assert_eq!(document["sensors"]["s"]["tuned"], json!({}));
    let rows: Vec<Value> = Kind::rows(&output(["K", "K"])).unwrap().collect();
    assert_eq!((rows.len(), &rows[3]["predicted_tuned"]), (4, &Value::Null));
    assert_eq!(document["train"], Value::Null, "no readings, no zeros");
}

#[test]
fn names_with_other_units_stand_apart() {
    let document = view(&output(["K", "W"]));
    let names: Vec<&String> = document["sensors"].as_object().unwrap().keys().collect();
    assert_eq!(names, ["a/s", "b/s"]);
}

#[test]
fn the_noise_range_belongs_to_the_readings_of_the_rmse() {
    let document = view(&output(["K", "K"]));
    let noise = &document["sensors"]["s"]["noise"];
    // sqrt(chi2 quantile / n) of three readings: 0.21580 and 9.34840 (tables), times 0.5.
    assert!((noise["rmse_low"].as_f64().unwrap() - 0.5 * (0.215_795f64 / 3.0).sqrt()).abs() < 1e-5);
    assert!((noise["rmse_high"].as_f64().unwrap() - 0.5 * (9.348_404f64 / 3.0).sqrt()).abs() < 1e-5);
}
