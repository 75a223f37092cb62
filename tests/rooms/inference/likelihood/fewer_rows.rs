//! Tests of `core/src/inference/likelihood/fewer_rows.rs`.

use bmv::inference::likelihood::fewer_rows::*;
use bmv::measurement::InputTable;

fn fewer(rows: &[usize], times_s: &[f64]) -> FewerRows {
    let inputs = InputTable { times_s: rows.iter().map(|&row| times_s[row]).collect(), ..InputTable::default() };
    FewerRows { inputs, rows: rows.to_vec(), tolerance: 1.0 }
}

#[test]
fn columns_are_drawn_straight_between_kept_rows() {
    let times_s = [0.0, 1.0, 4.0, 5.0, 6.0];
    let drawn = Drawn::new(fewer(&[0, 2, 4], &times_s), &times_s, 5).unwrap();
    let mut column = [0.0; 5];
    drawn.draw(|place| [8.0, 0.0, 3.0][place], &mut column);
    assert_eq!(column, [8.0, 6.0, 0.0, 1.5, 3.0]);
}

/// A clock that is off may show rows beyond those that are used.
#[test]
fn columns_stay_beyond_the_last_kept_row() {
    let times_s = [0.0, 1.0, 4.0, 5.0, 6.0];
    let drawn = Drawn::new(fewer(&[0, 2], &times_s), &times_s, 3).unwrap();
    let mut column = [0.0; 5];
    drawn.draw(|place| [8.0, 4.0][place], &mut column);
    assert_eq!(column, [8.0, 7.0, 4.0, 4.0, 4.0]);
}

#[test]
fn kept_rows_that_end_early_are_refused() {
    let times_s = [0.0, 1.0, 4.0, 5.0, 6.0];
    assert!(Drawn::new(fewer(&[0, 2], &times_s), &times_s, 5).is_none());
    assert!(Drawn::new(fewer(&[2, 4], &times_s), &times_s, 5).is_none());
}
