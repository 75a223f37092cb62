//! Tests of `src/report/section/summary/ladder.rs`.

use bmv::report::ladder::Standing;
use bmv::report::number::NONE;
use bmv::report::page::Table;
use bmv::report::section::summary::ladder::*;

#[test]
fn rows_that_chose_the_effects_have_a_column_of_their_own() {
    let standing = |held_out| Standing { fitted: Some(0.5), held_out, ..Standing::default() };
    let delivered = Rung { state: "As delivered".into(), standing: standing(Some(2.0)), unseen: None };
    let proposed = Rung { state: "Tuned with".into(), standing: standing(None), unseen: Some(0.25) };
    let texts = |table: &Table, row: usize| -> Vec<String> {
        table.rows[row].iter().map(|cell| cell.text.in_plain_words()).collect()
    };
    let (table, notes) = laid_out(&[delivered, proposed], "K", None);
    assert_eq!(table.columns[2].title, "Unseen");
    assert_eq!(texts(&table, 0)[1..4], ["0.50", NONE, "2.00"]);
    assert_eq!(texts(&table, 1)[1..4], ["0.50", "0.25", NONE]);
    assert!(notes.in_plain_words().contains("readings that no fit saw"));
    let (plain, _) = laid_out(&[Rung { standing: standing(None), ..Rung::default() }], "K", None);
    assert!(plain.columns.iter().all(|column| column.title != "Unseen"));
}
