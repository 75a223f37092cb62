//! What would have shown: by kind of effect, from which size on.

use std::collections::BTreeMap;

use crate::diagnosis::Verdict;
use crate::diagnosis::output::Output;
use crate::document::counted;
use crate::report::number::{significant, stated, with_unit};
use crate::report::page::{Block, Cell, Column, Table};

/// Kinds in the table.
const MOST_KINDS: usize = 40;

/// Sizes of a kind of effect, each with its place.
struct Kind<'o> {
    places: usize,
    least: (f64, &'o str),
    most: (f64, &'o str),
}

/// The table; where something is missing, that is stated instead.
pub(super) fn table(output: &Output) -> Option<Block> {
    if output.verdict != Verdict::Adequate || output.detectable.is_empty() {
        return None;
    }
    let mut kinds: BTreeMap<(&str, &str), Kind<'_>> = BTreeMap::new();
    for (id, amount) in &output.detectable {
        let (effect, place) = id.split_once(':').unwrap_or((id, ""));
        let here = (amount.value.abs(), place);
        let kind = kinds.entry((effect, amount.unit.as_str())).or_insert(Kind { places: 0, least: here, most: here });
        kind.places += 1;
        if here.0 < kind.least.0 {
            kind.least = here;
        }
        if here.0 > kind.most.0 {
            kind.most = here;
        }
    }
    let more = kinds.len().saturating_sub(MOST_KINDS);
    let more = if more > 0 {
        format!(" {}: bmv diagnose --json lists all.", counted(more, "more kind"))
    } else {
        String::new()
    };
    let rows = kinds.into_iter().take(MOST_KINDS).map(|((effect, unit), kind)| {
        let shown = |value: f64| {
            let (times, unit) = stated(unit, value);
            with_unit(&significant(times * value, 2), &unit)
        };
        vec![
            Cell::code(effect),
            kind.places.to_string().into(),
            shown(kind.least.0).into(),
            Cell::code(kind.least.1),
            shown(kind.most.0).into(),
            Cell::code(kind.most.1),
        ]
    });
    Some(Block::Table(Table {
        caption: format!(
            "What would have shown in nine of ten cases: by kind of effect, the size above which it would, at the place \
             where these data see it best and at the one where they see it worst.{more}"
        )
        .into(),
        columns: vec![
            Column::text("Effect"),
            Column::number("Places", ""),
            Column::number("Best", ""),
            Column::text("at"),
            Column::number("Worst", ""),
            Column::text("at"),
        ],
        rows: rows.collect(),
    }))
}
