//! Tests of `src/job/compare/readings.rs`, `collected.rs` and `readings_form.rs`.

use bmv::job::array::{Array, Arrays};
use bmv::job::compare::{Readings, Row};
use serde_json::Value;

fn row(measurement: &str, time_s: f64, sensor: &str) -> Row {
    Row {
        measurement: measurement.into(),
        phase: None,
        time_s: Some(time_s),
        sensor: sensor.into(),
        unit: "K".into(),
        measured: 300.0 + time_s,
        predicted: 300.0 + 1.0 / 3.0,
        predicted_tuned: (sensor != "b").then_some(time_s),
        held_out: time_s > 2.0,
    }
}

/// Gaps, a sensor that comes late, one that stands at another place, two measurements in turn, and phases.
fn irregular() -> Vec<Row> {
    let phase = Row { phase: Some("P".into()), time_s: None, ..row("steady", 0.0, "a") };
    let ampere = Row { unit: "A".into(), ..row("one", 4.0, "a") };
    vec![
        row("one", 1.0, "a"),
        row("one", 1.0, "c"),
        row("one", 2.0, "a"),
        row("one", 2.0, "b"),
        row("one", 2.0, "c"),
        row("one", 3.0, "c"),
        row("one", 3.0, "a"),
        row("one", 3.0, "a"),
        ampere,
        row("two", 1.0, "a"),
        row("one", 5.0, "d"),
        phase.clone(),
        Row { phase: Some("Q".into()), ..phase },
    ]
}

/// So many instants of three sensors, of which the second reads every other time.
fn many(instants: usize) -> Vec<Row> {
    let of = |instant: usize| {
        let sensors = ["a", "b", "c"].into_iter().filter(move |name| *name != "b" || instant.is_multiple_of(2));
        sensors.map(move |name| row("long", instant as f64, name))
    };
    (0..instants).flat_map(of).collect()
}

#[test]
fn a_few_readings_are_a_list_in_their_order() {
    for rows in [Vec::new(), irregular(), many(8000)] {
        let readings: Readings = rows.iter().cloned().collect();
        assert_eq!((readings.len(), readings.is_empty()), (rows.len(), rows.is_empty()));
        assert_eq!(readings.iter().map(Row::to_owned).collect::<Vec<Row>>(), rows);
        let json = serde_json::to_value(&readings).unwrap();
        assert_eq!(json, serde_json::to_value(&rows).unwrap());
        assert_eq!(serde_json::from_value::<Readings>(json).unwrap(), readings);
        assert!(readings.arrays().is_empty());
    }
}

#[test]
fn a_table_has_a_row_a_moment_and_a_column_a_sensor() {
    let readings: Readings = many(4).into_iter().collect();
    let [table] = readings.tables() else { panic!("one measurement") };
    assert_eq!((table.len(), table.channels.len()), (4, 3));
    assert_eq!(table.at(1, 1), None);
    assert_eq!(readings.of("long", "b").map(|row| row.time_s).collect::<Vec<_>>(), [Some(0.0), Some(2.0)]);
    assert_eq!(readings.of("long", "d").count() + readings.of("short", "a").count(), 0);
    let times: Vec<f64> = table.moments_read().filter_map(|moment| moment.time_s).collect();
    assert_eq!(times, [0.0, 1.0, 2.0, 3.0]);
    // By the first reading of each, not by the columns.
    let irregular: Readings = irregular().into_iter().collect();
    let names: Vec<&str> = irregular.tables()[0].channels_read().iter().map(|own| own.sensor.as_str()).collect();
    assert_eq!(names, ["a", "c", "b", "a"]);
}

#[test]
fn many_readings_are_arrays_beside_their_json() {
    let rows = many(9000);
    let readings: Readings = rows.iter().cloned().collect();
    let json = serde_json::to_value(&readings).unwrap();
    let table = &json["tables"][0];
    assert_eq!(table["measured"]["shape"], serde_json::json!([9000, 3]));
    assert_eq!(table["sensors"][1], serde_json::json!({"sensor": "b", "unit": "K"}));
    assert!(json.to_string().len() < 2000, "{json}");
    let arrays: Vec<(String, Array)> = readings.arrays();
    let names: Vec<&str> = arrays.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["time long", "held-out long", "measured long", "predicted long", "tuned long"]);
    let beside: Arrays = arrays.into_iter().map(|(_, array)| array).collect();
    let mut again: Readings = serde_json::from_value(json.clone()).unwrap();
    again.fill(&beside).unwrap();
    assert_eq!(again, readings);
    assert_eq!(again.iter().map(Row::to_owned).collect::<Vec<Row>>(), rows);
    assert_eq!(serde_json::to_value(&again).unwrap(), json);
    // Without its numbers it is none.
    let mut alone: Readings = serde_json::from_value(json.clone()).unwrap();
    assert_eq!(alone.fill(&Arrays::default()).ok(), None);
    // A list is read whatever its length.
    let listed: Readings = serde_json::from_value(serde_json::to_value(&rows).unwrap()).unwrap();
    assert_eq!(listed, readings);
    assert!(serde_json::from_value::<Readings>(Value::from(3)).is_err());
}

#[test]
fn a_reading_costs_a_few_words() {
    // Measured, predicted, tuned: what an entry of a list costs as JSON is a hundred times that.
    let readings: Readings = many(9000).into_iter().collect();
    let numbers: usize = readings.arrays().iter().map(|(_, array)| array.numbers().len()).sum();
    assert_eq!(numbers, 9000 * (3 * 3 + 2));
}
