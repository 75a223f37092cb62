//! Tests of `diagnosis/src/diagnosis/verdict/still.rs`.

use bmv::diagnosis::verdict::still::*;

#[test]
fn a_channel_at_the_end_of_its_range_stands_still_and_coarse_steps_do_not() {
    let model: Vec<f64> = (0..100).map(|row| 300.0 + 0.2 * f64::from(row)).collect();
    let clipped: Vec<Option<f64>> = model.iter().map(|value| Some(value.min(310.0))).collect();
    let found = still(&clipped, &model, 0.1).expect("it stands still");
    assert_eq!((found.rows, found.reading), ([50, 99], 310.0));
    assert!((found.moves - 9.8).abs() < 1e-9);
    // Steps of 2 K: ten readings each.
    let coarse: Vec<Option<f64>> = model.iter().map(|value| Some((value / 2.0).round() * 2.0)).collect();
    assert_eq!(still(&coarse, &model, 0.1), None);
    let gaps: Vec<Option<f64>> = clipped.iter().enumerate().map(|(row, own)| own.filter(|_| row < 55)).collect();
    assert_eq!(still(&gaps, &model, 0.1), None, "five readings are too few");
}
