//! Tests of `src/runner/external/output.rs`.

use bmv::runner::external::output::*;
use bmv::study::external::{Separator, Table};
use serde_json::Value;

fn table(column: &str, row: Option<u64>, condition: &[(&str, &str)], separator: Separator) -> Table {
    Table {
        column: column.to_owned(),
        row,
        condition: condition.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect(),
        separator,
        skip: 0,
        header: true,
    }
}

#[test]
fn rows_are_found_by_number_by_condition_or_last() {
    let text = "node,T\n12,1.5D+02\n\n\"13\", -7\n14,nonsense\n";
    let comma = Separator::Character(',');
    let at = |row: Option<u64>, condition: &[(&str, &str)]| in_table(text, &table("T", row, condition, comma));
    assert_eq!(at(Some(1), &[]), Ok(150.0));
    assert_eq!(at(None, &[("node", "13")]), Ok(-7.0));
    assert_eq!(at(None, &[]), Err("\"nonsense\" is no number".to_owned()));
    assert_eq!(at(Some(4), &[]), Err("there is no row 4".to_owned()));
    assert_eq!(at(None, &[("node", "15")]), Err("there is no such row".to_owned()));
    assert_eq!(in_table(text, &table("2", Some(2), &[], comma)), Ok(-7.0));
    assert_eq!(in_table(text, &table("x", None, &[], comma)), Err("there is no column `x`".to_owned()));
    assert_eq!(in_table("a  b\n 1   2 \n", &table("b", None, &[], Separator::Blanks)), Ok(2.0));
    let bare = Table { skip: 1, header: false, ..table("2", None, &[], Separator::Blanks) };
    assert_eq!(in_table("a title\n 1 2\n", &bare), Ok(2.0));
}

#[test]
fn a_number_that_is_none_is_named() {
    let said = |text: &str| {
        let error = serde_json::from_str::<Value>(text).expect_err("no JSON");
        no_json(text.as_bytes(), &error)
    };
    for (text, word) in
        [("{\"T\": NaN}", "NaN"), ("{\n \"T\": -Infinity}", "-Infinity"), ("[1, nan]", "nan"), ("inf", "inf")]
    {
        assert!(said(text).starts_with(&format!("{word} is not JSON (line ")), "{text}: {}", said(text));
    }
    assert!(said("{\"nan\": x}").starts_with("it is no JSON: "), "{}", said("{\"nan\": x}"));
}

#[test]
fn pointers_find_numbers_alone() {
    let value = serde_json::json!({"nodes": {"a/b": [1, 2.5, "x", null]}});
    assert_eq!(at_pointer(&value, "/nodes/a~1b/1"), Ok(2.5));
    assert!(at_pointer(&value, "/nodes/a~1b/2").is_err_and(|why| why.ends_with("which is no number")));
    assert!(at_pointer(&value, "/nodes/c").is_err());
}
