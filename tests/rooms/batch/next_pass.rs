//! Tests of `src/batch/next_pass/mod.rs`.

mod name;
mod text;

use bmv::batch::next_pass::renumbered;

#[test]
fn a_title_has_the_new_number_where_it_had_the_old_one() {
    for (title, expected) in [
        ("Pass 2: the model against the log", "Pass 3: the model against the log"),
        ("Bench, pass 2: as delivered", "Bench, pass 3: as delivered"),
        ("Pass 20 of the bench", "Pass 20 of the bench"),
        ("Compass 2", "Compass 2"),
        ("\u{C9}tude, pass 2", "\u{C9}tude, pass 3"),
    ] {
        assert_eq!(renumbered(title, 2, 3), expected);
    }
}
