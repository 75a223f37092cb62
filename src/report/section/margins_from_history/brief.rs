//! Margins from history in brief.

use crate::document::counted;
use crate::job::margins_from_history::{Group, Kind, Output};
use crate::report::number::{NONE, percent};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

use super::{kelvin, named};

/// Margins from history in brief.
pub(in crate::report::section) struct MarginsFromHistory;

fn line(output: &Output, group: &Group) -> String {
    let margin = group.margin_k.map_or_else(|| NONE.to_owned(), kelvin);
    let bound = group.bound_k.map_or_else(|| NONE.to_owned(), kelvin);
    format!(
        "{}: {margin} hold {} of {}, at most {bound} with confidence {}",
        named(group),
        percent(output.capture, 0),
        counted(group.comparisons as usize, "difference"),
        percent(output.confidence, 0)
    )
}

impl Brief for MarginsFromHistory {
    type Kind = Kind;

    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        output.groups.iter().take(1).map(|group| line(output, group)).collect()
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let margin = |group: &Group| {
            (format!("margin of {}", named(group)), group.margin_k.map_or_else(|| NONE.to_owned(), kelvin))
        };
        output.groups.iter().map(margin).collect()
    }
}
