//! Tests of `src/import/logger/dialect.rs`.

use bmv::import::logger::dialect::*;

#[test]
fn the_separator_is_the_one_that_makes_columns_of_most_lines() {
    let german = "Logger 7\nSerie;A12\n\nZeit;T1;T2\n;\u{B0}C;\u{B0}C\n0;1,5;2,25\n10;1,6;2,5\n";
    assert_eq!(dialect(german), Some(Dialect { separator: b';', header: 3, has_comma: true }));
    let plain = "time,T1\n0,1.5\n1,2.5\n";
    assert_eq!(dialect(plain), Some(Dialect { separator: b',', header: 0, has_comma: false }));
    assert_eq!(dialect("one\ntwo\n"), None);
}

#[test]
fn cells_are_numbers_or_nothing_or_text() {
    assert_eq!(reading("1.234,5", true), Reading::Number(1234.5));
    assert_eq!(reading("-2,5e-3", true), Reading::Number(-2.5e-3));
    assert_eq!(reading("9.9E37", false), Reading::Missing);
    assert_eq!(reading("OVER", false), Reading::Missing);
    assert_eq!(reading("1,5", false), Reading::Text);
    assert_eq!(name_and_unit("TC 1 (\u{B0}C)"), ("TC 1".to_owned(), Some("degC".to_owned())));
    assert_eq!(name_and_unit("plate (left)"), ("plate (left)".to_owned(), None));
}
