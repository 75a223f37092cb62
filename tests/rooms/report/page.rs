//! Tests of `src/report/page.rs`.

use bmv::report::page::*;

#[test]
fn names_between_backticks_are_names() {
    assert_eq!(Text::with_names("`R_c` is pressed"), Text::default().code("R_c").plain(" is pressed"));
    assert_eq!(Text::with_names("the joint `G`"), Text::new("the joint ").code("G"));
    assert_eq!(Text::with_names("a ` alone"), Text::new("a ` alone"));
}

#[test]
fn a_link_leads_to_a_page_below_and_to_no_other_scheme() {
    let text = Text::default().link("a", &["..", "javascript:alert(1)", "\"><b", "report"]);
    let page = "../javascript%3Aalert%281%29/%22%3E%3Cb/report".to_owned();
    assert_eq!(text.0, [Inline::Link { text: "a".into(), page, anchor: String::new() }]);
}

#[test]
fn slugs_are_safe_names() {
    assert_eq!(slug("../../etc/passwd"), "etc-passwd");
    assert_eq!(slug("<img src=x>"), "img-src-x");
    assert_eq!(slug("\u{4F60}"), "figure");
    assert!(slug(&"x".repeat(500)).len() <= 60);
}

#[test]
fn a_long_table_keeps_its_worst_rows_worst_first() {
    let table = |count: u32| Table {
        columns: vec![Column::text("Sensor")],
        rows: (0..count).map(|at| vec![Cell::code(format!("s{at}"))]).collect(),
        ..Table::default()
    };
    let sizes: Vec<f64> = (0..126).map(|at| f64::from((at * 37) % 126)).collect();
    let cut = table(126).cut(&sizes);
    assert_eq!(cut.rows.len(), 20);
    // 37 * 109 = 32 * 126 + 1, so that 109 * 125 = 13625 = 108 * 126 + 17 is the place of 125.
    assert_eq!(cut.rows[0], [Cell::code("s17")]);
    assert!(cut.caption.0.contains(&Inline::Plain(" The worst 20 of 126 rows; all are in ".into())));
    assert_eq!(table(30).cut(&sizes[..30]), table(30));
}
