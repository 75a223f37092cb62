//! Tests of `src/study/table.rs`.

use bmv::document::code;
use bmv::study::table::*;

fn read(text: &str, wanted: &[(usize, Cells)]) -> (Vec<Column>, Problems) {
    let mut problems = Problems::default();
    let columns = match Table::new(text, b',', &mut problems) {
        Some(table) => table.read(wanted, &mut problems),
        None => Vec::new(),
    };
    (columns, problems)
}

fn messages(text: &str, wanted: &[(usize, Cells)]) -> Vec<(String, String)> {
    let (_, problems) = read(text, wanted);
    problems.kept.into_iter().map(|p| (text[p.range].to_owned(), p.message)).collect()
}

#[test]
fn headers_keep_name_unit_and_place() {
    let text = "\u{feff}phase, T_if [degC] ,\"a, b [W]\"\r\nP1,2,3\r\n";
    let mut problems = Problems::default();
    let table = Table::new(text, b',', &mut problems).expect("headers");
    let seen: Vec<_> = table.headers().iter().map(|h| (h.name.as_str(), h.unit.as_deref())).collect();
    assert_eq!(seen, [("phase", None), ("T_if", Some("degC")), ("a, b", Some("W"))]);
    assert_eq!(&text[table.headers()[1].range.clone()], "T_if [degC]");
    assert!(problems.is_empty());
}

#[test]
fn cells_are_trimmed_and_empty_ones_missing() {
    let text = "phase,a,b\r\n P1 , 1.5 ,\r\n\r\n,,\r\nP2,-2e-3, \"3\" ";
    let (columns, problems) = read(text, &[(0, Cells::Names), (1, Cells::Numbers), (2, Cells::Readings)]);
    assert!(problems.is_empty(), "{problems:?}");
    assert_eq!(columns[0].names(), ["P1", "P2"]);
    assert_eq!(columns[1].numbers(), [Some(1.5), Some(-2e-3)]);
    assert_eq!(columns[2].numbers(), [None, Some(3.0)]);
}

#[test]
fn what_is_not_a_number_has_its_place() {
    let text = "phase,a\nP1,NaN\nP2,inf\nP3,abc\nP4,1e999\nP5,0x10\n";
    let problems = messages(text, &[(1, Cells::Readings)]);
    let cells: Vec<_> = problems.iter().map(|(cell, _)| cell.as_str()).collect();
    assert_eq!(cells, ["NaN", "inf", "abc", "1e999", "0x10"]);
    assert_eq!(problems[0].1, "`NaN` is not a finite number");
    assert_eq!(problems[2].1, "`abc` is not a number");
}

#[test]
fn what_nothing_uses_is_no_problem() {
    let (columns, problems) = read("phase,note,a\nP1,vented,1\n", &[(2, Cells::Readings)]);
    assert!(problems.is_empty());
    assert_eq!(columns[0].numbers(), [Some(1.0)]);
}

#[test]
fn ragged_rows_times_and_names_are_checked() {
    assert_eq!(
        messages("time,a\n0,1\n1\n2,3,4\n", &[(0, Cells::Times)]),
        [
            ("1".to_owned(), "this row has 1 cells, the line of headers has 2".to_owned()),
            ("2,3,4".to_owned(), "this row has 3 cells, the line of headers has 2".to_owned())
        ]
    );
    assert_eq!(
        messages("time,a\n0,1\n0,1\n-1,1\n,1\n", &[(0, Cells::Times)]).iter().map(|m| &*m.1).collect::<Vec<_>>(),
        [
            "time 0 is not after 0, the time of the row before",
            "time -1 is not after 0, the time of the row before",
            "`time` has no value in this row"
        ]
    );
    assert_eq!(
        messages("phase,a\nP1,1\nP1,2\n,3\n", &[(0, Cells::Names)]).iter().map(|m| &*m.1).collect::<Vec<_>>(),
        ["`P1` stands twice under `phase`", "the `phase` of this row is empty"]
    );
}

#[test]
fn a_wrong_separator_is_noticed() {
    assert_eq!(messages("phase;a\nP1;1\n", &[]).len(), 1);
    let mut problems = Problems::default();
    assert!(Table::new("phase;a\nP1;1,5\n", b';', &mut problems).is_some());
    assert!(problems.is_empty());
    assert_eq!(messages("", &[]), [(String::new(), "the file has no line of headers".to_owned())]);
}

#[test]
fn problems_that_repeat_down_a_column_are_counted() {
    let text = format!("a,b\n{}", "x,\n".repeat(100));
    let (_, problems) = read(&text, &[(0, Cells::Readings), (1, Cells::Numbers)]);
    let seen: Vec<(&str, usize)> = problems.kept.iter().map(|p| (p.message.as_str(), p.alike)).collect();
    let (wrong, empty) = ("`x` is not a number", "`b` has no value in this row");
    assert_eq!(seen, [(wrong, 0), (empty, 0), (wrong, 0), (empty, 0), (wrong, 97), (empty, 97)]);
    assert_eq!(problems.more, 0);
}

#[test]
fn problems_are_counted_beyond_a_cap() {
    let columns: Vec<String> = (0..30).map(|column| format!("c{column}")).collect();
    let text = format!("{}\n{}", columns.join(","), format!("{}x\n", "x,".repeat(29)).repeat(5));
    let wanted: Vec<(usize, Cells)> = (0..30).map(|column| (column, Cells::Readings)).collect();
    let (_, problems) = read(&text, &wanted);
    let alike: usize = problems.kept.iter().map(|problem| problem.alike).sum();
    assert_eq!((problems.kept.len(), problems.kept.len() + problems.more + alike), (20, 150));
}

#[test]
fn a_decimal_comma_is_answered_with_the_number_it_means() {
    let help = |text: &str, separator| {
        let mut problems = Problems::default();
        let table = Table::new(text, separator, &mut problems).expect("headers");
        table.read(&[(1, Cells::Readings)], &mut problems);
        problems.kept.first().and_then(|problem| problem.help.clone()).unwrap_or_default()
    };
    assert_eq!(help("p;a\nP1;0,6\n", b';'), "a decimal is written with a point: write 0.6");
    assert_eq!(help("p;a\nP1;-1.234,5e3\n", b';'), "a decimal is written with a point: write -1234.5e3");
    assert_eq!(help("p,a\nP1,\"0,6\"\n", b','), "a decimal is written with a point: write 0.6");
    assert!(help("p,a\nP1,0,6\n", b',').contains("0.6"));
    assert_eq!(help("p;a\nP1;1,2,3\n", b';'), "leave the cell of a missing reading empty");
}

#[test]
#[ignore = "thorough"]
fn a_table_of_too_many_cells_is_not_read_to_its_end() {
    let text = format!("a\n{}", "1\n".repeat(MOST_CELLS + 2));
    let (columns, problems) = read(&text, &[(0, Cells::Readings)]);
    assert_eq!(columns[0].numbers().len(), MOST_CELLS);
    assert_eq!(problems.kept[0].code, &code::TOO_LARGE);
}

#[test]
fn a_quote_may_hold_separators_quotes_and_lines() {
    let text = "n,a\n\"x, \"\"y\"\"\nz\",1\n\"open,2\n";
    let (columns, problems) = read(text, &[(0, Cells::Names), (1, Cells::Readings)]);
    assert_eq!(columns[0].names(), ["x, \"y\"\nz"]);
    assert_eq!(problems.kept[0].message, "this quote is not closed");
}

#[test]
fn truncation_anywhere_never_panics() {
    let text = "\u{feff}time [s],\"a \"\"é\" [degC],b\r\n0,1,2\r\n1,\"2\",\n2,°,3\n";
    for end in (0..=text.len()).filter(|end| text.is_char_boundary(*end)) {
        let mut problems = Problems::default();
        if let Some(table) = Table::new(&text[..end], b',', &mut problems) {
            let wanted: Vec<_> = (0..table.headers().len()).map(|i| (i, Cells::Times)).collect();
            table.read(&wanted, &mut problems);
        }
    }
}
