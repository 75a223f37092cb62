//! Tests of `src/report/terminal/table.rs`.

use bmv::report::page::Status;
use bmv::report::terminal::Layout;
use bmv::report::terminal::table::*;

#[test]
fn wrapping_breaks_at_blanks_and_within_words_that_are_too_long() {
    assert_eq!(wrapped("aa bb ccccc d", 5), ["aa bb", "ccccc", "d"]);
    assert_eq!(wrapped("abcdefgh", 3), ["abc", "def", "gh"]);
    assert_eq!(wrapped("conductive-path:a:b", 14), ["conductive-", "path:a:b"]);
    assert_eq!(wrapped("1.5\u{A0}K x", 5), ["1.5 K", "x"]);
    assert_eq!(wrapped("", 5), [""]);
}

#[test]
fn marks_colour_a_cell_and_not_the_blanks_around_it() {
    let cell = |text: &str, status| Entry { text: text.into(), status };
    let rows = [vec![cell("a", None), cell("1.0", Some(Status::Fail))], vec![cell("b", None), cell("10.0", None)]];
    let layout = Layout { width: 40, is_coloured: true };
    let text = lay_out(&["n".into(), "v".into()], &rows, &[false, true], layout);
    assert_eq!(text, "n     v\n-  -----\na   \u{1b}[31m1.0!\u{1b}[0m\nb  10.0\n(! not kept)\n");
}
