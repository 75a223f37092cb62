//! Tests of `src/report/csv.rs`.

use bmv::report::csv::*;

#[test]
fn numbers_read_back_and_what_is_none_is_empty() {
    for value in [0.1, -1e-300, 1.0 / 3.0, 0.0] {
        assert_eq!(number(value).parse::<f64>().expect("a number").to_bits(), value.to_bits());
    }
    assert_eq!(number(f64::NAN), "");
}

#[test]
fn no_cell_begins_as_a_formula_or_ends_before_its_end() {
    for formula in ["=1+1", "+1+1", "-1+1", "@SUM(A1)", " =1", "\t=1", "\r=1", "=cmd|' /C calc'!A0", "\u{FF1D}1", "-x"]
    {
        let cell = text(formula);
        assert!(cell.starts_with('\'') || cell.starts_with("\"'") || cell.starts_with('\\'), "{formula:?}: {cell}");
        assert!(!cell.contains(['\t', '\r', '\n']), "{cell:?}");
    }
    for (plain, cell) in
        [("TC 1", "TC 1"), ("-5", "-5"), ("a\"b,c", "\"a\"\"b,c\""), ("a\nb", "a\\nb"), ("\u{2212}3 K", "\u{2212}3 K")]
    {
        assert_eq!(text(plain), cell);
    }
    assert_eq!(text("=HYPERLINK(\"a\",\"b\")"), "\"'=HYPERLINK(\"\"a\"\",\"\"b\"\")\"");
}
