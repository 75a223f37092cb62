//! Tests of `core/src/thermal/transient/inputs.rs`.

use bmv::thermal::transient::inputs::*;

fn table() -> InputTable {
    InputTable {
        times_s: vec![0.0, 10.0, 20.0, 30.0],
        columns: vec![
            InputColumn { input: 0, values: vec![0.0, 1.0, 2.0, 0.0], hold: false },
            InputColumn { input: 1, values: vec![5.0, 5.0, 7.0, 7.0], hold: true },
        ],
        base: vec![0.0, 0.0, 3.0],
    }
}

#[test]
fn corners_are_where_a_slope_or_a_held_value_changes() {
    let table = table();
    let reader = InputReader::new(&table);
    assert_eq!(reader.next_corner(-1.0), Some(0.0));
    assert_eq!(reader.next_corner(0.0), Some(20.0));
    assert_eq!(reader.next_corner(20.0), Some(30.0));
    assert_eq!(reader.next_corner(30.0), None);
    assert_eq!([0.0, 10.0, 20.0, 30.0, 21.0].map(|t| reader.steps_at(t)), [false, false, true, false, false]);
}

#[test]
fn held_columns_change_on_entering_linear_ones_follow_time() {
    let table = table();
    let mut reader = InputReader::new(&table);
    let mut out = table.base.clone();
    reader.enter(0.0);
    reader.read(20.0, &mut out);
    assert_eq!(out, [2.0, 5.0, 3.0]);
    reader.enter(20.0);
    reader.read(25.0, &mut out);
    assert_eq!(out, [1.0, 7.0, 3.0]);
    reader.read(99.0, &mut out);
    assert_eq!(out[0], 0.0);
    reader.read(-1.0, &mut out);
    assert_eq!(out[0], 0.0);
    reader.read(15.0, &mut out);
    assert_eq!(out[0], 1.5);
}
