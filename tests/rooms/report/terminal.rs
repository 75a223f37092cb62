//! Tests of `src/report/terminal.rs`.

mod table;

use bmv::report::page::{Block, Cell, Column, Section, Status, Table, Text, Tone};
use bmv::report::terminal::*;

fn shown(blocks: Vec<Block>, width: usize) -> String {
    let section = Section { id: "x", title: "Title".into(), blocks };
    render(&[section], Layout { width, is_coloured: false })
}

#[test]
fn text_wraps_lists_hang_and_numbers_stay_with_their_units() {
    let text = shown(
        vec![
            Block::callout(Tone::Warning, "one two three"),
            Block::List(vec!["the error is \u{2212}1.5\u{A0}K here".into(), Text::default().code("a b")]),
        ],
        16,
    );
    insta::assert_snapshot!(text, @"
    Title
    =====

    Warning: one two
    three

    - the error is
      -1.5 K here
    - `a b`
    ");
}

#[test]
fn tables_mark_what_fails_and_drop_columns_that_say_nothing() {
    let table = Table {
        caption: "Sizes.".into(),
        columns: vec![
            Column::text("Rule"),
            Column::number("Standard deviation", "K"),
            Column::number("Never there", ""),
            Column::text("Source"),
        ],
        rows: vec![
            vec![
                Cell::code("a"),
                Cell::marked("12.5", Status::Fail),
                Cell::from("\u{2014}"),
                "a handbook of many pages".into(),
            ],
            vec![Cell::code("long name"), "\u{2212}1.0".into(), Cell::default(), Cell::default()],
        ],
    };
    insta::assert_snapshot!(shown(vec![Block::Table(table)], 40), @"
    Title
    =====

    Sizes.
    Rule            Standard   Source
               deviation [K]
    ---------  --------------  -------------
    a                   12.5!  a handbook of
                               many pages
    long name           -1.0
    (! not kept)
    ");
}

#[test]
fn a_table_that_cannot_be_so_narrow_becomes_a_list_of_its_rows() {
    let columns = vec![Column::text("Unbreakable"), Column::number("Number", "W")];
    let rows = vec![vec!["abcdefghijkl".into(), "123456789".into()]];
    let text = shown(vec![Block::Table(Table { caption: "Narrow.".into(), columns, rows })], 15);
    assert!(text.ends_with("Unbreakable:\n  abcdefghijkl\nNumber [W]:\n  123456789\n"), "{text}");
}

#[test]
fn a_study_cannot_steer_the_terminal() {
    let text = shown(vec![Block::paragraph("\u{1b}[2Jx\u{202E}y\nz")], 80);
    assert!(text.ends_with("\n\\u{1b}[2Jx\\u{202e}y z\n"), "{text:?}");
}
