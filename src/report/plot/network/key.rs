//! The key below a network: a mark of each kind that the picture holds, with its name.

use super::super::canvas::{Anchor, Canvas, Lettering, SMALL, text_width};
use super::super::palette::{GRID, INK, MUTED, diverging};
use super::arrangement::Arrangement;
use super::room::height;
use super::{
    BAND, Diagram, HEATER, LOAD, MOST_NAMED, NodeShape, Path, Source, paint_arrow, paint_node, paint_path, path_words,
};
use crate::report::number::significant;

/// An entry of the key: a mark and what it means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Key {
    Node(NodeShape),
    Path(Path),
    Source(Source),
    Deviation(f64),
    Missing,
    Adopted,
    Unnamed,
}

impl Key {
    fn words(self) -> String {
        match self {
            Self::Node(kind) => kind.words().into(),
            Self::Path(path) => path_words(path).into(),
            Self::Source(Source::Load) => LOAD.into(),
            Self::Source(_) => HEATER.into(),
            Self::Deviation(full) => {
                let full = significant(full, 2);
                format!("largest meas. \u{2212} pred., \u{2212}{full} to +{full} K")
            }
            Self::Missing => "missing".into(),
            Self::Adopted => "adopted".into(),
            Self::Unnamed => "names of the paths: see the table".into(),
        }
    }

    /// Width of its mark with what is free behind it.
    fn mark_width(self) -> f64 {
        if matches!(self, Self::Deviation(_)) { 136.0 } else { 76.0 }
    }

    fn paint(self, canvas: &mut Canvas<'_>, (x, y): (f64, f64)) {
        match self {
            Self::Node(kind) => paint_node(canvas, (&[], ""), (kind, None), ((x + 30.0, y), (56.0, 32.0)), SMALL),
            Self::Path(kind) => paint_path(canvas, kind, (x, y), (x + 62.0, y)),
            Self::Source(kind) => paint_arrow(canvas, kind, false, ((x, y), (x + 62.0, y))),
            Self::Deviation(_) => {
                for step in 0..=10 {
                    let (left, share) = (x + 11.0 * f64::from(step), f64::from(step) / 5.0 - 1.0);
                    canvas.fill((left, y - 13.0), (left + 12.0, y + 13.0), diverging(share), 1.0);
                }
                canvas.outline((x, y - 13.0), (x + 122.0, y + 13.0), MUTED, 2);
            }
            Self::Missing | Self::Adopted => {
                canvas.path(&[(x, y), (x + 66.0, y)], BAND, 22);
                if self == Self::Missing {
                    canvas.dashed(&[(x, y), (x + 66.0, y)], INK, 9, 26.0, 14.0);
                } else {
                    canvas.path(&[(x, y), (x + 66.0, y)], INK, 5);
                }
            }
            Self::Unnamed => canvas.path(&[(x, y), (x + 60.0, y)], MUTED, 2),
        }
    }
}

/// What the picture holds, in the order of its key.
pub(super) fn key(diagram: &Diagram) -> Vec<Key> {
    let nodes = [NodeShape::Diffusion, NodeShape::Arithmetic, NodeShape::Boundary]
        .into_iter()
        .filter(|kind| diagram.nodes.iter().any(|node| node.1 == *kind));
    let paths = [Path::Conductor, Path::Radiation, Path::Flow, Path::Cooler]
        .into_iter()
        .filter(|kind| diagram.paths.iter().any(|path| path.1 == *kind));
    let sources = [Source::Load, Source::Heater]
        .into_iter()
        .filter(|kind| diagram.sources.iter().any(|source| source.1 == *kind));
    let has_deviations = diagram.deviations.iter().any(Option::is_some);
    let marks = [
        has_deviations.then_some(Key::Deviation(diagram.full_scale)),
        (!diagram.missing.is_empty()).then_some(Key::Missing),
        (!(diagram.adopted.is_empty() && diagram.changed.is_empty())).then_some(Key::Adopted),
        (diagram.paths.len() > MOST_NAMED).then_some(Key::Unnamed),
    ];
    nodes
        .map(Key::Node)
        .chain(paths.map(Key::Path))
        .chain(sources.map(Key::Source))
        .chain(marks.into_iter().flatten())
        .collect()
}

/// The key broken into rows of a width.
pub(super) fn key_rows(key: &[Key], width: f64) -> Vec<Vec<Key>> {
    let mut rows: Vec<Vec<Key>> = vec![Vec::new()];
    let mut x = 20.0;
    for own in key {
        let needed = own.mark_width() + text_width(&own.words(), SMALL);
        if x + needed > width {
            x = 20.0;
            rows.push(Vec::new());
        }
        x += needed + 34.0;
        rows.last_mut().into_iter().for_each(|row| row.push(*own));
    }
    rows
}

pub(super) fn paint_key(canvas: &mut Canvas<'_>, key: &[Key], y: f64, width: f64) {
    canvas.path(&[(0.0, y - 30.0), (width, y - 30.0)], GRID, 2);
    for (number, row) in key_rows(key, width).iter().enumerate() {
        let (mut x, y) = (20.0, y + 8.0 + 46.0 * number as f64);
        for own in row {
            own.paint(canvas, (x, y));
            x += own.mark_width();
            canvas.text(&own.words(), (x, y), Lettering::new(SMALL, INK));
            x += text_width(&own.words(), SMALL) + 34.0;
        }
    }
}

/// What stands in the picture as a number, or found no place there.
pub(super) fn paint_listed(canvas: &mut Canvas<'_>, placed: &Arrangement, top: f64) {
    let step = height(1, SMALL);
    let mut y = top + 0.5 * step;
    for (number, entry) in placed.listed.iter().enumerate() {
        let lettering = Lettering::new(SMALL, entry.colour);
        canvas.text(&(number + 1).to_string(), (62.0, y), lettering.bold().at(Anchor::End));
        for line in &entry.lines {
            canvas.text(line, (84.0, y), lettering);
            y += step;
        }
    }
}
