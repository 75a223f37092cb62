//! Tests of `src/cli/output.rs`.

use bmv::cli::output::*;

#[test]
fn nothing_but_colours_steers_the_terminal() {
    let styled = "\u{1b}[1;31merror:\u{1b}[0m a\n\u{1b}[94mb\u{1b}[m";
    assert_eq!(safe(styled), styled);
    for (wild, shown) in [
        ("a\u{1b}[2Jb", "a\\u{1b}[2Jb"),
        ("\u{1b}[8mhidden\u{1b}[0m", "\\u{1b}[8mhidden\u{1b}[0m"),
        ("\u{1b}]0;title\u{7}", "\\u{1b}]0;title\\u{7}"),
        ("\u{1b}[31", "\\u{1b}[31"),
        ("\u{9b}2J\u{202e}\0\r", "\\u{9b}2J\\u{202e}\\u{0}\\r"),
    ] {
        assert_eq!(safe(wild), shown);
    }
}

#[test]
fn columns_are_as_wide_as_their_widest_cell() {
    let row = |a: &str, b: &str| vec![a.to_owned(), b.to_owned()];
    assert_eq!(table(&[row("job", "kind"), row("größer", "x")], None), "job     kind\ngrößer  x\n");
    assert_eq!(table(&[], None), "");
}

#[test]
fn on_a_terminal_the_last_column_is_broken_below_its_beginning() {
    let rows = [vec!["gas-conduction".to_owned(), "Conduction by residual gas".to_owned()]];
    assert_eq!(table(&rows, Some(40)), "gas-conduction  Conduction by residual\n                gas\n");
    assert_eq!(table(&rows, Some(30)), "gas-conduction  Conduction by residual gas\n", "no room is left");
    assert_eq!(folded("  a: ", "b c", Some(80)), "  a: b c\n");
}
