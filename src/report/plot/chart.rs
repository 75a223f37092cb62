//! Charts of two axes: lines, steps, dots, bands, bars, density cells, limits and shaded stretches.

use super::axis::{Axis, Scale, range_of, widened};
use super::canvas::{Anchor, Canvas, Drawing, Lettering, NARROW, SMALL, TEXT, WIDTH, draw_within, fitted, text_width};
use super::palette::{Colour, GRID, INK, MUTED, PAPER, SHADE, between, diverging};
use super::sheet::Entry;
use crate::math::sort::sort_by;

/// Dots of a layer that are drawn, an even choice.
const MOST_DOTS: usize = 500;

/// How a line runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Straight from point to point.
    Solid,
    /// Dashed from point to point.
    Dashed,
    /// Constant from each point to the next.
    Step,
}

/// How a point is marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A disc.
    Disc,
    /// A ring.
    Ring,
}

/// What is drawn; the first layers lie below the later ones. Labels go to the key above the chart; an empty one
/// stays out of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// Shaded between two curves: x, lower, upper.
    Band {
        /// Points.
        points: Vec<(f64, f64, f64)>,
        /// Colour.
        colour: Colour,
        /// Label.
        label: String,
    },
    /// A line.
    Line {
        /// Points.
        points: Vec<(f64, f64)>,
        /// Colour.
        colour: Colour,
        /// How it runs.
        stroke: Stroke,
        /// Label.
        label: String,
    },
    /// Points alone.
    Dots {
        /// Points.
        points: Vec<(f64, f64)>,
        /// Colour.
        colour: Colour,
        /// How they are marked.
        mark: Mark,
        /// Label.
        label: String,
    },
    /// Vertical intervals: x, lower, upper.
    Intervals {
        /// Intervals.
        points: Vec<(f64, f64, f64)>,
        /// Colour.
        colour: Colour,
    },
    /// Bars from zero between edges (one more than heights).
    Bars {
        /// Edges.
        edges: Vec<f64>,
        /// Heights.
        heights: Vec<f64>,
        /// Colour.
        colour: Colour,
        /// Label.
        label: String,
    },
    /// Cells shaded by their value, by bin of x then bin of y.
    Cells {
        /// Edges of the bins of x.
        x_edges: Vec<f64>,
        /// Edges of the bins of y.
        y_edges: Vec<f64>,
        /// Values.
        values: Vec<Vec<f64>>,
        /// Colour of the largest value.
        colour: Colour,
        /// Label.
        label: String,
    },
    /// Filled areas, each of its colour.
    Patches {
        /// Areas.
        patches: Vec<Patch>,
        /// Colour in the key.
        colour: Colour,
        /// Label.
        label: String,
    },
    /// Thin straight pieces, each by its ends.
    Segments {
        /// Pieces.
        pieces: Vec<[(f64, f64); 2]>,
        /// Colour.
        colour: Colour,
    },
    /// Texts at places: x, y, text.
    Labels {
        /// Texts.
        labels: Vec<(f64, f64, String)>,
    },
    /// Points coloured by a deviation, blue below zero and orange above: x, y, deviation.
    Deviations {
        /// Points.
        points: Vec<(f64, f64, f64)>,
        /// Label; the largest deviation stands behind it.
        label: String,
    },
}

/// A filled area.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Its corners.
    pub outline: Vec<(f64, f64)>,
    /// Its colour.
    pub colour: Colour,
}

impl Layer {
    /// Its colour, its label, and what it is.
    fn about(&self) -> (Colour, &str, &'static str) {
        match self {
            Self::Band { colour, label, .. } => (*colour, label, "band"),
            Self::Line { colour, label, .. } => (*colour, label, "line"),
            Self::Dots { colour, label, .. } => (*colour, label, "points"),
            Self::Intervals { colour, .. } => (*colour, "", "intervals"),
            Self::Bars { colour, label, .. } => (*colour, label, "bars"),
            Self::Cells { colour, label, .. } => (*colour, label, "cells"),
            Self::Patches { colour, label, .. } => (*colour, label, "surface"),
            Self::Segments { colour, .. } => (*colour, "", "lines"),
            Self::Labels { .. } => (INK, "", "level"),
            Self::Deviations { label, .. } => (INK, label, "deviations"),
        }
    }
}

/// The axis that a limit belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// A value of x: a vertical line.
    X,
    /// A value of y: a horizontal line.
    Y,
}

/// A labelled line across the chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Its axis.
    pub along: Along,
    /// Value.
    pub value: f64,
    /// Label, written beside it.
    pub label: String,
    /// Colour.
    pub colour: Colour,
}

/// A shaded stretch of x.
#[derive(Clone, Debug, PartialEq)]
pub struct Shade {
    /// From.
    pub from: f64,
    /// To.
    pub to: f64,
}

impl Shade {
    /// Whether it covers a value of x.
    pub(super) fn holds(&self, x: f64) -> bool {
        (self.from..=self.to).contains(&x)
    }
}

/// The columns in which [`Chart::record`] writes.
pub(super) fn chart_columns(x: &str, y: &str) -> [String; 9] {
    let of = |title: &str, what: &str| format!("{title} {what}").trim_start().to_owned();
    [
        "panel".into(),
        "series".into(),
        x.into(),
        of(x, "to"),
        y.into(),
        of(y, "lower"),
        of(y, "upper"),
        of(y, "to"),
        "value".into(),
    ]
}

/// A chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is drawn.
    pub layers: Vec<Layer>,
    /// Lines across.
    pub limits: Vec<Limit>,
    /// Shaded stretches.
    pub shades: Vec<Shade>,
    /// What the shade means; empty without one.
    pub shade_label: String,
    /// Height of the canvas in pixels; 0 for the usual one.
    pub height: u32,
    /// Whether it shares the width of the page with another picture.
    pub is_small: bool,
}

/// A part of the canvas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Chart {
    /// Draws the chart on a canvas of its own.
    pub fn draw(&self) -> Drawing {
        let (width, usual) = if self.is_small { (NARROW, 620) } else { (WIDTH, 900) };
        let height = if self.height == 0 { usual } else { self.height };
        draw_within((width, height), |canvas| {
            let area = Area { left: 0.0, top: 0.0, right: f64::from(width), bottom: f64::from(height) };
            let frame = self.paint(canvas, area, None, true);
            canvas.columns(chart_columns(&self.x.title, &self.y.title));
            self.record(canvas, &frame, "");
        })
    }

    /// Records what a painted chart shows, in the columns of [`chart_columns`]; `panel` tells charts of one canvas apart.
    pub(super) fn record(&self, canvas: &mut Canvas<'_>, frame: &Frame, panel: &str) {
        let panel = Entry::from(panel);
        let at_name = |x: f64| {
            let position = self.x.names.iter().enumerate().find(|(position, _)| x == *position as f64 + 1.0);
            position.map_or_else(|| x.into(), |(_, name)| name.as_str().into())
        };
        for layer in &self.layers {
            let series = Entry::from(self.series(layer).as_str());
            let mut add = |[x, x_to, y, lower, upper, y_to, value]: [f64; 7], place: (f64, f64)| {
                let numbers = [y, lower, upper, y_to, value].map(Entry::from);
                let row =
                    canvas.record([panel.clone(), series.clone(), at_name(x), x_to.into()].into_iter().chain(numbers));
                canvas.seen(row, frame.at(place));
            };
            const NONE: f64 = f64::NAN;
            match layer {
                Layer::Band { points, .. } | Layer::Intervals { points, .. } => {
                    points.iter().for_each(|&(x, low, high)| add([x, NONE, NONE, low, high, NONE, NONE], (x, high)));
                }
                Layer::Line { points, .. } | Layer::Dots { points, .. } => {
                    points.iter().for_each(|&(x, y)| add([x, NONE, y, NONE, NONE, NONE, NONE], (x, y)));
                }
                Layer::Bars { edges, heights, .. } => {
                    for (pair, &height) in edges.windows(2).zip(heights) {
                        let middle = 0.5 * (pair[0] + pair[1]);
                        add([pair[0], pair[1], height, NONE, NONE, NONE, NONE], (middle, height));
                    }
                }
                Layer::Cells { x_edges, y_edges, values, .. } => {
                    for (columns, of_column) in x_edges.windows(2).zip(values) {
                        for (rows, &value) in y_edges.windows(2).zip(of_column) {
                            let middle = (0.5 * (columns[0] + columns[1]), 0.5 * (rows[0] + rows[1]));
                            add([columns[0], columns[1], rows[0], NONE, NONE, rows[1], value], middle);
                        }
                    }
                }
                Layer::Deviations { points, .. } => {
                    points.iter().for_each(|&(x, y, deviation)| add([x, NONE, y, NONE, NONE, NONE, deviation], (x, y)));
                }
                // Their labels say what lines of a surface are.
                Layer::Labels { labels } => {
                    for (x, y, text) in labels {
                        let row = canvas.record([
                            panel.clone(),
                            text.as_str().into(),
                            at_name(*x),
                            Entry::Empty,
                            (*y).into(),
                        ]);
                        canvas.seen(row, frame.at((*x, *y)));
                    }
                }
                Layer::Patches { .. } | Layer::Segments { .. } => {}
            }
        }
        for limit in self.limits.iter().filter(|limit| !limit.label.is_empty()) {
            let (x, y) = if limit.along == Along::X { (limit.value, f64::NAN) } else { (f64::NAN, limit.value) };
            canvas.record([panel.clone(), limit.label.as_str().into(), x.into(), Entry::Empty, y.into()]);
        }
        let shade = if self.shade_label.is_empty() { "shaded" } else { &self.shade_label };
        for own in &self.shades {
            canvas.record([panel.clone(), shade.into(), own.from.into(), own.to.into()]);
        }
    }

    /// What a layer is called: its label; without one that of a layer of the same colour, and what it is.
    fn series(&self, layer: &Layer) -> String {
        let (colour, label, what) = layer.about();
        if !label.is_empty() {
            return label.to_owned();
        }
        let other = self.layers.iter().map(Layer::about).find(|(own, label, _)| *own == colour && !label.is_empty());
        match other {
            Some((_, label, _)) => format!("{label}, {what}"),
            None if self.layers.len() > 1 => what.to_owned(),
            None => String::new(),
        }
    }

    /// Draws the chart into a part of a canvas. `left` fixes the width of the left margin, so that charts above one
    /// another line up; the lowest shows the title of x. Gives where the axes lie.
    pub(super) fn paint(&self, canvas: &mut Canvas<'_>, area: Area, left: Option<f64>, lowest: bool) -> Frame {
        let key_rows = self.key_rows(area.right - area.left - 60.0);
        let key_height = 46.0 * key_rows.len() as f64;
        let inner_top = area.top
            + 24.0
            + key_height
            + match self.limits.iter().filter(|l| l.along == Along::X && !l.label.is_empty()).count() {
                0 => 12.0,
                1 => 46.0,
                _ => 84.0,
            };
        let inner_bottom = area.bottom - if lowest { 122.0 } else { 58.0 };
        let y_range = self.y.range.unwrap_or_else(|| {
            let (low, high) = widened(self.extent(Along::Y).unwrap_or((0.0, 1.0)), 0.06);
            // Bars stand on the axis.
            if self.layers.iter().any(|l| matches!(l, Layer::Bars { .. })) { (0.0, high) } else { (low, high) }
        });
        let y_range = self.y.within(y_range);
        let upright = (inner_bottom, inner_top.min(inner_bottom - 10.0));
        let y = if self.y.is_probability {
            Scale::of_probability(upright)
        } else {
            Scale::new(y_range, upright, if inner_bottom - inner_top < 300.0 { 3 } else { 6 })
        };
        let y_ticks = y.ticks();
        let widest = y_ticks.iter().map(|t| text_width(&t.1, TEXT)).fold(0.0, f64::max);
        let inner_left = area.left + left.unwrap_or(widest + 104.0);
        let inner_right = area.right - 36.0;
        let x_range = self.x.range.unwrap_or_else(|| {
            let extent = self.extent(Along::X).unwrap_or((0.0, 1.0));
            let is_filled = self
                .layers
                .iter()
                .any(|l| matches!(l, Layer::Bars { .. } | Layer::Cells { .. } | Layer::Patches { .. }));
            if is_filled { extent } else { widened(extent, 0.02) }
        });
        let x = Scale::new(x_range, (inner_left, inner_right), 8);
        let frame =
            Frame { x, y, area: Area { left: inner_left, top: inner_top, right: inner_right, bottom: inner_bottom } };

        for shade in &self.shades {
            let (from, to) = (frame.x.at(shade.from), frame.x.at(shade.to));
            let to = if to - from < 3.0 { from + 3.0 } else { to };
            canvas.fill((from, inner_top), (to, inner_bottom), SHADE, 1.0);
        }
        for (value, label) in &y_ticks {
            let at = frame.y.at(*value);
            canvas.path(&[(inner_left, at), (inner_right, at)], GRID, 2);
            canvas.text(label, (inner_left - 14.0, at), Lettering::new(TEXT, INK).at(Anchor::End));
        }
        for (value, label) in self.x.ticks(&frame.x) {
            let at = frame.x.at(value);
            canvas.path(&[(at, inner_top), (at, inner_bottom)], GRID, 2);
            canvas.path(&[(at, inner_bottom), (at, inner_bottom + 8.0)], INK, 3);
            if lowest {
                canvas.text(&label, (at, inner_bottom + 34.0), Lettering::new(TEXT, INK).at(Anchor::Middle));
            }
        }
        for layer in &self.layers {
            frame.layer(canvas, layer);
        }
        canvas.path(&[(inner_left, inner_top), (inner_left, inner_bottom), (inner_right, inner_bottom)], INK, 3);
        self.paint_limits(canvas, &frame);
        if lowest {
            let title = fitted(&self.x.title, TEXT, inner_right - inner_left);
            canvas.text(
                &title,
                ((inner_left + inner_right) / 2.0, inner_bottom + 88.0),
                Lettering::new(TEXT, INK).at(Anchor::Middle),
            );
        }
        let title = fitted(&self.y.title, TEXT, inner_bottom - inner_top + 110.0);
        let middle = ((inner_top + inner_bottom) / 2.0).max(area.top + text_width(&title, TEXT) / 2.0);
        canvas.text(&title, (area.left + 30.0, middle), Lettering::new(TEXT, INK).at(Anchor::Middle).upwards());
        self.paint_key(canvas, &key_rows, (inner_left, area.top + 34.0));
        frame
    }

    /// Range of the data along an axis, limits included.
    fn extent(&self, along: Along) -> Option<(f64, f64)> {
        let mut values = Vec::new();
        let x = along == Along::X;
        for layer in &self.layers {
            match layer {
                Layer::Band { points, .. } | Layer::Intervals { points, .. } => {
                    for &(a, low, high) in points {
                        if x { values.push(a) } else { values.extend([low, high]) }
                    }
                }
                Layer::Line { points, .. } | Layer::Dots { points, .. } => {
                    values.extend(points.iter().map(|p| if x { p.0 } else { p.1 }));
                }
                Layer::Bars { edges, heights, .. } => {
                    if x {
                        values.extend(edges)
                    } else {
                        values.extend(heights.iter().chain(&[0.0]))
                    }
                }
                Layer::Cells { x_edges, y_edges, .. } => values.extend(if x { x_edges } else { y_edges }),
                Layer::Patches { patches, .. } => {
                    values.extend(patches.iter().flat_map(|own| &own.outline).map(|p| if x { p.0 } else { p.1 }));
                }
                Layer::Segments { pieces, .. } => {
                    values.extend(pieces.iter().flatten().map(|p| if x { p.0 } else { p.1 }));
                }
                Layer::Deviations { points, .. } => values.extend(points.iter().map(|p| if x { p.0 } else { p.1 })),
                Layer::Labels { .. } => {}
            }
        }
        values.extend(self.limits.iter().filter(|l| l.along == along).map(|l| l.value));
        range_of(values)
    }

    fn paint_limits(&self, canvas: &mut Canvas<'_>, frame: &Frame) {
        let area = frame.area;
        let mut ends = [f64::NEG_INFINITY; 2];
        let mut upright: Vec<&Limit> =
            self.limits.iter().filter(|l| l.along == Along::X && frame.x.holds(l.value)).collect();
        sort_by(&mut upright, |a, b| a.value.total_cmp(&b.value));
        for limit in upright {
            let at = frame.x.at(limit.value);
            let width = text_width(&limit.label, SMALL) + 16.0;
            let left = (at - width / 2.0).clamp(area.left, (area.right - width).max(area.left));
            // Two rows of labels: the lower one if there is room, otherwise the upper one.
            let row = if left >= ends[0] || ends[0] <= ends[1] { 0 } else { 1 };
            ends[row] = left + width;
            let y = area.top - 20.0 - 38.0 * row as f64;
            canvas.dashed(&[(at, area.bottom), (at, y + 18.0)], limit.colour, 4, 18.0, 10.0);
            canvas.text_on_paper(&limit.label, (left + 8.0, y), Lettering::new(SMALL, limit.colour));
        }
        for limit in self.limits.iter().filter(|l| l.along == Along::Y && frame.y.holds(l.value)) {
            let at = frame.y.at(limit.value);
            canvas.dashed(&[(area.left, at), (area.right, at)], limit.colour, 4, 18.0, 10.0);
            let above = if at - 24.0 < area.top { 24.0 } else { -24.0 };
            canvas.text_on_paper(&limit.label, (area.left + 14.0, at + above), Lettering::new(SMALL, limit.colour));
        }
    }

    /// Entries of the key, broken into rows of a width.
    fn key_rows(&self, width: f64) -> Vec<Vec<(KeyMark, String)>> {
        let mut entries: Vec<(KeyMark, String)> = Vec::new();
        for layer in &self.layers {
            let (mark, label) = match layer {
                Layer::Band { colour, label, .. } => (KeyMark::Patch(*colour, 0.22), label),
                Layer::Bars { colour, label, .. } => (KeyMark::Patch(*colour, 0.75), label),
                Layer::Cells { colour, label, .. } => (KeyMark::Patch(*colour, 0.6), label),
                Layer::Line { colour, label, stroke, .. } => (KeyMark::Line(*colour, *stroke == Stroke::Dashed), label),
                Layer::Dots { colour, label, mark, .. } => (KeyMark::Dot(*colour, *mark), label),
                Layer::Patches { colour, label, .. } => (KeyMark::Patch(*colour, 0.4), label),
                Layer::Deviations { label, .. } => (KeyMark::Deviations, label),
                Layer::Intervals { .. } | Layer::Segments { .. } | Layer::Labels { .. } => continue,
            };
            if !label.is_empty() {
                entries.push((mark, label.clone()));
            }
        }
        if !self.shades.is_empty() && !self.shade_label.is_empty() {
            entries.push((KeyMark::Patch(SHADE, 1.0), self.shade_label.clone()));
        }
        let mut rows: Vec<Vec<(KeyMark, String)>> = Vec::new();
        let mut used = f64::INFINITY;
        for (mark, label) in entries {
            let label = fitted(&label, SMALL, width - 120.0);
            let needed = 110.0 + text_width(&label, SMALL);
            if used + needed > width - 120.0 {
                rows.push(Vec::new());
                used = 0.0;
            }
            used += needed;
            if let Some(row) = rows.last_mut() {
                row.push((mark, label));
            }
        }
        rows
    }

    fn paint_key(&self, canvas: &mut Canvas<'_>, rows: &[Vec<(KeyMark, String)>], (left, top): (f64, f64)) {
        for (number, row) in rows.iter().enumerate() {
            let y = top + 46.0 * number as f64;
            let mut x = left;
            for (mark, label) in row {
                match *mark {
                    KeyMark::Patch(colour, opacity) => {
                        canvas.fill((x, y - 13.0), (x + 52.0, y + 13.0), colour, opacity);
                        canvas.outline((x, y - 13.0), (x + 52.0, y + 13.0), between(colour, MUTED, 0.3), 2);
                    }
                    KeyMark::Line(colour, true) => canvas.dashed(&[(x, y), (x + 52.0, y)], colour, 6, 14.0, 8.0),
                    KeyMark::Line(colour, false) => canvas.path(&[(x, y), (x + 52.0, y)], colour, 6),
                    KeyMark::Dot(colour, mark) => paint_mark(canvas, (x + 26.0, y), colour, mark, 9),
                    KeyMark::Deviations => {
                        for (at, share) in [(6.0, -1.0), (26.0, 0.0), (46.0, 1.0)] {
                            paint_deviation(canvas, (x + at, y), share, 9);
                        }
                    }
                }
                canvas.text(label, (x + 64.0, y), Lettering::new(SMALL, INK));
                x += 110.0 + text_width(label, SMALL);
            }
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum KeyMark {
    Patch(Colour, f64),
    Line(Colour, bool),
    Dot(Colour, Mark),
    Deviations,
}

/// A point whose colour tells its deviation as a share of the largest.
fn paint_deviation(canvas: &mut Canvas<'_>, at: (f64, f64), share: f64, radius: u32) {
    canvas.disc(at, radius, diverging(share), 1.0);
    canvas.circle(at, radius, INK, 3);
}

fn paint_mark(canvas: &mut Canvas<'_>, at: (f64, f64), colour: Colour, mark: Mark, radius: u32) {
    match mark {
        Mark::Disc => canvas.disc(at, radius, colour, 1.0),
        Mark::Ring => {
            canvas.disc(at, radius, PAPER, 1.0);
            canvas.circle(at, radius, colour, 3);
        }
    }
}

/// Where the axes of a painted chart lie.
pub(super) struct Frame {
    x: Scale,
    y: Scale,
    area: Area,
}

impl Frame {
    /// Where a point lies, pixels.
    pub(super) fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.at(x), self.y.at(y))
    }

    fn layer(&self, canvas: &mut Canvas<'_>, layer: &Layer) {
        match layer {
            Layer::Band { points, colour, .. } => {
                let finite: Vec<_> =
                    points.iter().filter(|p| p.0.is_finite() && p.1.is_finite() && p.2.is_finite()).collect();
                let lower = finite.iter().map(|p| self.at((p.0, p.1)));
                let upper = finite.iter().rev().map(|p| self.at((p.0, p.2)));
                let outline: Vec<_> = lower.chain(upper).collect();
                canvas.polygon(&outline, *colour, 0.22);
            }
            Layer::Line { points, colour, stroke, .. } => {
                let mut line: Vec<(f64, f64)> = points.iter().map(|&p| self.at(p)).collect();
                match stroke {
                    Stroke::Dashed => canvas.dashed(&line, *colour, 5, 16.0, 10.0),
                    Stroke::Solid => canvas.path(&line, *colour, 5),
                    Stroke::Step => {
                        let mut steps = Vec::with_capacity(2 * line.len());
                        for pair in line.windows(2) {
                            steps.extend([pair[0], (pair[1].0, pair[0].1)]);
                        }
                        steps.extend(line.pop());
                        canvas.path(&steps, *colour, 5);
                    }
                }
            }
            Layer::Dots { points, colour, mark, .. } => {
                let radius = if points.len() > 200 {
                    5
                } else if points.len() > 60 {
                    7
                } else {
                    9
                };
                // Dots five pixels large that lie closer cover one another.
                let stride = points.len().div_ceil(MOST_DOTS).max(1);
                for &point in points.iter().step_by(stride).filter(|p| p.0.is_finite() && p.1.is_finite()) {
                    paint_mark(canvas, self.at(point), *colour, *mark, radius);
                }
            }
            Layer::Intervals { points, colour } => {
                for &(x, low, high) in points.iter().filter(|p| p.0.is_finite() && p.1.is_finite() && p.2.is_finite()) {
                    let ((x, low), high) = (self.at((x, low)), self.y.at(high));
                    canvas.path(&[(x, low), (x, high)], *colour, 4);
                    for end in [low, high] {
                        canvas.path(&[(x - 9.0, end), (x + 9.0, end)], *colour, 4);
                    }
                }
            }
            Layer::Bars { edges, heights, colour, .. } => {
                for (pair, &height) in edges.windows(2).zip(heights) {
                    if height.is_finite() && height != 0.0 {
                        let (left, right) = (self.x.at(pair[0]), self.x.at(pair[1]));
                        let right = if right - left > 4.0 { right - 2.0 } else { right.max(left + 2.0) };
                        canvas.fill((left, self.y.at(0.0)), (right, self.y.at(height)), *colour, 0.75);
                    }
                }
            }
            Layer::Patches { patches, .. } => {
                for patch in patches {
                    let outline: Vec<(f64, f64)> = patch.outline.iter().map(|&p| self.at(p)).collect();
                    canvas.polygon(&outline, patch.colour, 1.0);
                }
            }
            Layer::Segments { pieces, colour } => {
                for [a, b] in pieces {
                    canvas.path(&[self.at(*a), self.at(*b)], *colour, 2);
                }
            }
            Layer::Labels { labels } => {
                for (x, y, text) in labels {
                    let (x, y) = self.at((*x, *y));
                    canvas.text_on_paper(text, (x - 0.5 * text_width(text, SMALL), y), Lettering::new(SMALL, INK));
                }
            }
            Layer::Deviations { points, .. } => {
                let largest = points.iter().map(|p| p.2.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
                for &(x, y, deviation) in points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()) {
                    paint_deviation(canvas, self.at((x, y)), deviation / largest.max(1e-300), 11);
                }
            }
            Layer::Cells { x_edges, y_edges, values, colour, .. } => {
                let largest = values.iter().flatten().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
                for (columns, row) in x_edges.windows(2).zip(values) {
                    for (rows, &value) in y_edges.windows(2).zip(row) {
                        if value > 0.0 && largest > 0.0 {
                            let shade = between(between(PAPER, *colour, 0.08), *colour, (value / largest).sqrt());
                            canvas.fill(self.at((columns[0], rows[0])), self.at((columns[1], rows[1])), shade, 1.0);
                        }
                    }
                }
            }
        }
    }
}
