//! Tests of `src/report/plot/sheet.rs`.

use bmv::report::plot::sheet::*;

#[test]
fn columns_without_values_are_left_out_and_numbers_are_in_full() {
    let mut sheet = Sheet::default();
    sheet.name(["sensor", "time [s]", "none", "T [\u{b0}C]"]);
    let row = sheet.row(["=TC\t1".into(), 0.1.into(), Entry::Empty, (-1.0 / 3.0).into()]);
    sheet.place((4, 5), row);
    sheet.row(["b".into(), 1.0.into(), f64::NAN.into(), f64::INFINITY.into()]);
    let numbers = sheet.finish();
    assert_eq!(numbers.csv, "sensor,time [s],T [\u{b0}C]\n'=TC\\t1,0.1,-0.3333333333333333\nb,1,\n");
    assert_eq!(numbers.values, "sensor\ttime [s]\tT [\u{b0}C]\n4 5\t=TC 1\t0.1\t\u{2212}0.333333");
}

#[test]
fn of_very_many_places_an_even_choice_is_shown() {
    let mut sheet = Sheet::default();
    sheet.name(["x"]);
    for at in 0..10_000 {
        let row = sheet.row([f64::from(at).into()]);
        sheet.place((at, 0), row);
    }
    let numbers = sheet.finish();
    assert_eq!(numbers.csv.lines().count(), 10_001);
    assert!(numbers.values.len() < MOST_BYTES + 10 && numbers.values.lines().count() > 1000);
}
