//! Tests of `src/job/compare/stretch.rs`.

use bmv::job::compare::stretch::*;
use bmv::measurement::{Initial, InputColumn, InputTable, Measurement, Rows};

fn transient(hold: bool, values: Vec<f64>, held_out: Vec<bool>) -> Measurement {
    let rows = values.len();
    Measurement {
        name: "test".into(),
        rows: Rows::Transient {
            inputs: InputTable {
                times_s: (0..rows).map(|i| i as f64 * 10.0).collect(),
                columns: vec![InputColumn { input: 0, values, hold }],
                base: vec![0.0],
            },
            initial: Initial::Steady,
            ignored: vec![None; rows],
            held_out,
        },
        sensors: vec![],
        readings: vec![],
        file: String::new(),
        sha256: String::new(),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    }
}

#[test]
fn steps_and_held_out_rows_cut() {
    let m = transient(true, vec![0.0, 0.0, 1.0, 1.0, 1.0], vec![false, false, false, false, true]);
    let cut: Vec<_> = stretches(&m).iter().map(|s| (s.from, s.to, s.held_out)).collect();
    assert_eq!(cut, [(0, 2, false), (2, 4, false), (4, 5, true)]);
}

#[test]
fn linear_inputs_give_equal_parts_that_cover_every_row_once() {
    let m = transient(false, (0..37).map(f64::from).collect(), vec![false; 37]);
    let cut = stretches(&m);
    assert_eq!(cut.len(), 10);
    assert_eq!((cut[0].from, cut[9].to), (0, 37));
    assert!(cut.windows(2).all(|pair| pair[0].to == pair[1].from));
}

#[test]
fn the_worst_stretch_of_a_sensor_is_where_its_own_error_is_largest() {
    // Three held levels: errors of 0.1, then 2, then one spike of 3 among zeros, of which the root mean square is 1.3.
    let levels = (0..15).map(|row| f64::from(row / 5)).collect();
    let m = transient(true, levels, vec![false; 15]);
    let error = |row: usize| [0.1, 2.0, if row == 12 { 3.0 } else { 0.0 }][row / 5];
    let deviations: Vec<(f64, f64)> = (0..15).map(|row| (10.0 * row as f64, error(row))).collect();
    assert_eq!(worst(&m, &deviations).as_deref(), Some("50 to 90 s"));
    assert_eq!(worst(&m, &[]), None);
}

#[test]
fn stretches_of_long_records_are_named_in_days() {
    let mut m = transient(false, (0..45).map(f64::from).collect(), vec![false; 45]);
    let Rows::Transient { inputs, .. } = &mut m.rows else { panic!("a transient") };
    inputs.times_s = (0..45).map(|day| 86_400.0 * f64::from(day)).collect();
    let deviations: Vec<(f64, f64)> = (0..45).map(|day| (86_400.0 * f64::from(day), f64::from(day))).collect();
    assert_eq!(worst(&m, &deviations).as_deref(), Some("40 to 44 d"));
}
