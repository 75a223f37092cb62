//! Tests of `src/import/logger/dead.rs`.

use bmv::import::logger::dead::*;
use bmv::import::logger::{Channel, Record};

/// A hundred rows of two temperatures that swing, and of one of its own.
fn record(own: impl Fn(usize) -> Option<f64>) -> Record {
    let swings = |row: usize| Some(20.0 + (row % 9) as f64 + 0.1 * (row % 7) as f64);
    let channel = |name: &str, readings: &dyn Fn(usize) -> Option<f64>| Channel {
        name: name.into(),
        unit: Some("degC".into()),
        readings: (0..100).map(readings).collect(),
        ..Channel::default()
    };
    let mut record = Record::default();
    record.times_s = (0..100).map(|row| 10.0 * f64::from(row)).collect();
    record.channels = vec![channel("a", &swings), channel("own", &own), channel("b", &swings)];
    record
}

fn moving(row: usize) -> f64 {
    30.0 + 0.1 * (row % 5) as f64
}

#[test]
fn a_channel_without_readings_from_a_row_on_is_dead_from_there() {
    let record = record(|row| (row < 60).then(|| moving(row)));
    assert_eq!(end(&record, 1), Some(End::Missing(60)));
    assert_eq!(end(&record, 0), None);
    let (same, notes) = without(&record, &[]);
    assert_eq!(same.channels, record.channels, "what it read before stays");
    assert!(
        notes[0].contains("`own` has no reading from 600 s") && notes[0].contains("in the last 40 rows"),
        "{notes:?}"
    );
    assert!(notes[0].contains(r#""ignore": {"own": "died at 600 s"}"#), "{notes:?}");
}

#[test]
fn a_temperature_that_stays_while_the_others_move_is_stuck() {
    let record = record(|row| Some(if row < 60 { moving(row) } else { 23.4 }));
    assert_eq!(end(&record, 1), Some(End::Stuck(60, 23.4)));
    let (cut, notes) = without(&record, &[]);
    assert_eq!(cut.channels[1].readings.iter().flatten().count(), 60);
    assert!(notes[0].contains("`own` stays at 23.4 from 600 s") && notes[0].contains("--keep 'own'"), "{notes:?}");
    let (kept, notes) = without(&record, &["own".to_owned()]);
    assert!(kept.channels == record.channels && notes.is_empty(), "{notes:?}");
}

#[test]
fn what_stays_often_or_with_all_others_and_what_misses_often_is_not_dead() {
    assert_eq!(end(&record(|row| (row % 4 == 0).then(|| moving(row))), 1), None);
    assert_eq!(
        end(
            &record(|row| Some(if row < 30 {
                20.0
            } else if row < 70 {
                25.0
            } else {
                30.0
            })),
            1
        ),
        None
    );
    let mut quiet = record(|row| Some(if row < 60 { moving(row) } else { 23.4 }));
    for at in [0, 2] {
        quiet.channels[at].readings[60..].fill(Some(21.0));
    }
    assert_eq!(end(&quiet, 1), None);
}
