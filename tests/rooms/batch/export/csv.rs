//! Tests of `src/batch/export/csv.rs`.

use bmv::batch::export::csv::*;
use bmv::job::dataset::{Dimension, Group};

#[test]
fn a_group_is_a_table_with_a_row_for_each_of_its_places() {
    let mut group =
        Group::new("posterior", vec![Dimension::of_places("chain", 2, 1), Dimension::of_places("draw", 3, 2)]);
    group.numbers("G", "conductance", Some("W/K".to_owned()), vec![0.1, 1e-300, f64::NAN, 4.0]);
    let across = Dimension::of_names("reading", vec!["a, b".to_owned(), "c".to_owned()]);
    group.across("readings", "readings", across, (0..8).map(f64::from).collect());
    let text = table(&group);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "chain,draw,G [W/K],\"readings(a, b)\",readings(c)");
    assert_eq!(lines[1], "0,0,0.1,0,1");
    assert_eq!(lines[3], "1,0,,4,5");
    let tiny: f64 = lines[2].split(',').nth(2).expect("a cell").parse().expect("a number");
    assert_eq!(tiny, 1e-300);
}
