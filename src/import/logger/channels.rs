//! What the user says of the channels: `channel,name,unit,measures`, a line a channel. A line without a name leaves its
//! channel out; channels without a line keep their own name.

use std::sync::Arc;

use super::dialect::{name_and_unit, unit_of};
use super::record::Record;
use crate::document::suggest::listed;
use crate::document::{Diagnostic, Diagnostics, Place, Source, Span, code};
use crate::study::table::{Cells, Problems, Table};

/// A line of the map.
pub(super) struct Line {
    channel: String,
    place: Place,
    name: String,
    unit: Option<String>,
    measures: Option<String>,
}

/// The lines of a map.
pub(super) fn read(source: &Arc<Source>, diagnostics: &mut Diagnostics) -> Vec<Line> {
    let mut problems = Problems::default();
    let text = source.text();
    let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let separator = if first.contains(';') { b';' } else { b',' };
    let mut lines = Vec::new();
    if let Some(table) = Table::new(text, separator, &mut problems) {
        let find = |name: &str| table.headers().iter().position(|header| header.name == name);
        if let (Some(channel), Some(name)) = (find("channel"), find("name")) {
            let (unit, measures) = (find("unit"), find("measures"));
            // Read once as names, so that a channel that stands twice is said at its place.
            table.read(&[(channel, Cells::Names)], &mut problems);
            table.rows(0, &mut Problems::default(), |cells, _| {
                let cell = |at: Option<usize>| {
                    at.map(|at| table.text(&cells[at]).into_owned()).filter(|text| !text.is_empty())
                };
                lines.push(Line {
                    channel: table.text(&cells[channel]).into_owned(),
                    place: Place::in_text(source, Span::new(cells[channel].start, cells[channel].end)),
                    name: cell(Some(name)).unwrap_or_default(),
                    unit: cell(unit),
                    measures: cell(measures),
                });
            });
        } else {
            let range = table.headers().first().map_or(0..0, |header| header.range.clone());
            let help = "the header `channel,name`, and with it `unit` and `measures` where these are to be said";
            problems.add(&code::TABLE_SHAPE, range, "a map of channels has other columns", Some(help));
        }
    }
    problems.report(source, diagnostics);
    lines
}

/// Names that a message lists.
const MOST_NAMES: usize = 12;

/// Applies the map.
pub(super) fn apply(lines: &[Line], record: &mut Record, diagnostics: &mut Diagnostics) {
    let mut names: Vec<(usize, &str)> = Vec::new();
    for line in lines {
        // A heading copied whole, with its unit, names the channel as well.
        let of_name = |name: &str| record.channels.iter().position(|channel| channel.name == name);
        let Some(at) = of_name(&line.channel).or_else(|| of_name(&name_and_unit(&line.channel).0)) else {
            let names: Vec<&str> = record.channels.iter().map(|channel| channel.name.as_str()).collect();
            let nearest = diagnostics.nearest(&line.channel, names.iter().copied());
            let message = format!("no file has a channel `{}`", line.channel);
            let diagnostic = Diagnostic::error(&code::TABLE_CELL, &line.place, message).suggest(nearest);
            diagnostics.push(diagnostic.expected(format!("one of {}", listed(names, MOST_NAMES))));
            continue;
        };
        let channel = &mut record.channels[at];
        if let Some(written) = &line.unit {
            channel.unit = unit_of(written);
            if channel.unit.is_none() {
                let wrong = Diagnostic::error(&code::TABLE_CELL, &line.place, format!("`{written}` is no unit"));
                diagnostics.push(wrong.expected("a unit such as degC, K, W or V"));
            }
        }
        channel.measures.clone_from(&line.measures);
        if line.name.is_empty() {
            channel.left_out = Some("is left out by the map".to_owned());
        } else {
            names.push((at, &line.name));
        }
    }
    // All channels are found by their old names before the first has a new one.
    for (at, name) in names {
        record.channels[at].name = name.to_owned();
    }
}
