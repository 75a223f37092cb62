//! Contours of a surface over two axes, with marked points: from a grid of nodes that may be skewed. Between nodes the surface
//! is linear on triangles, so that no value is drawn that the nodes do not hold.

use super::axis::Axis;
use super::canvas::Drawing;
use super::chart::{Chart, Layer, Patch};
use super::palette::{BLUE, Colour, INK, PAPER, between};
use crate::report::number::fixed;

/// A node of the grid: its place and the surface there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Horizontal place.
    pub x: f64,
    /// Vertical place.
    pub y: f64,
    /// The surface.
    pub value: f64,
}

/// What is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contours {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Rows of nodes, all of one length.
    pub rows: Vec<Vec<Node>>,
    /// Marked points: x, y, and the number that colours them (a deviation).
    pub points: Vec<(f64, f64, f64)>,
    /// What the points are.
    pub points_label: String,
    /// What the colours of the surface are, with unit.
    pub surface_label: String,
}

/// Levels between the surface's ends.
const LEVELS: usize = 12;
/// Shares of a colour at the surface's ends.
const ENDS: [f64; 2] = [0.04, 0.72];

/// Draws the surface in bands between round levels, each level a line with its number, and the points.
pub fn contours(data: &Contours) -> Drawing {
    let values: Vec<f64> =
        data.rows.iter().flatten().map(|node| node.value).filter(|value| value.is_finite()).collect();
    let (levels, decimals) = levels(&values);
    let mut chart = Chart { x: data.x.clone(), y: data.y.clone(), height: 1000, ..Chart::default() };
    let mut patches = Vec::new();
    // All that lies above a level, level by level: no seam between triangles shows the page.
    for (band, level) in [f64::NEG_INFINITY].iter().chain(&levels).enumerate() {
        let colour = colour(band, levels.len());
        let outlines = triangles(&data.rows).map(|triangle| above(&triangle, *level));
        patches.extend(outlines.filter(|outline| outline.len() > 2).map(|outline| Patch { outline, colour }));
    }
    let mut lines = Vec::new();
    let mut labels = Vec::new();
    for &level in &levels {
        let pieces: Vec<[(f64, f64); 2]> =
            triangles(&data.rows).filter_map(|triangle| crossing(&triangle, level)).collect();
        // The piece in the middle carries the number: there the line is longest in sight.
        labels.extend(
            pieces.get(pieces.len() / 2).map(|[a, b]| (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1), fixed(level, decimals))),
        );
        lines.extend(pieces);
    }
    chart.layers.push(Layer::Patches { patches, colour: BLUE, label: data.surface_label.clone() });
    chart.layers.push(Layer::Segments { pieces: lines, colour: INK });
    chart.layers.push(Layer::Labels { labels });
    chart.layers.push(Layer::Deviations { points: data.points.clone(), label: data.points_label.clone() });
    chart.draw()
}

/// Round levels within the values, and the decimals that show them.
fn levels(values: &[f64]) -> (Vec<f64>, usize) {
    let Some(range) = super::axis::range_of(values.iter().copied()) else { return (Vec::new(), 0) };
    let scale = super::axis::Scale::new(range, (0.0, 1.0), LEVELS);
    let levels: Vec<f64> =
        scale.ticks().into_iter().map(|tick| tick.0).filter(|level| *level > range.0 && *level < range.1).collect();
    (levels, scale.decimals())
}

fn colour(band: usize, levels: usize) -> Colour {
    let share = if levels == 0 { 0.5 } else { band as f64 / levels as f64 };
    between(PAPER, BLUE, ENDS[0] + share * (ENDS[1] - ENDS[0]))
}

type Triangle = [Node; 3];

/// Two triangles a cell; a cell with a corner that is no number has none.
pub fn triangles(rows: &[Vec<Node>]) -> impl Iterator<Item = Triangle> + '_ {
    let is_whole = |triangle: &Triangle| {
        triangle.iter().all(|node| node.x.is_finite() && node.y.is_finite() && node.value.is_finite())
    };
    rows.windows(2)
        .flat_map(|pair| pair[0].windows(2).zip(pair[1].windows(2)))
        .flat_map(|(lower, upper)| [[lower[0], lower[1], upper[0]], [lower[1], upper[1], upper[0]]])
        .filter(is_whole)
}

/// The part of a triangle where the surface is not below a level.
pub fn above(triangle: &Triangle, level: f64) -> Vec<(f64, f64)> {
    let mut kept = Vec::with_capacity(4);
    for (position, here) in triangle.iter().enumerate() {
        let next = &triangle[(position + 1) % 3];
        let (own, other) = (here.value - level, next.value - level);
        if own >= 0.0 {
            kept.push((here.x, here.y));
        }
        if (own > 0.0 && other < 0.0) || (own < 0.0 && other > 0.0) {
            kept.push(on_the_way(here, next, own / (own - other)));
        }
    }
    kept
}

fn on_the_way(from: &Node, to: &Node, share: f64) -> (f64, f64) {
    (from.x + share * (to.x - from.x), from.y + share * (to.y - from.y))
}

/// Where a level crosses a triangle.
pub fn crossing(triangle: &Triangle, level: f64) -> Option<[(f64, f64); 2]> {
    let mut ends = Vec::with_capacity(2);
    for (position, here) in triangle.iter().enumerate() {
        let next = &triangle[(position + 1) % 3];
        let (own, other) = (here.value - level, next.value - level);
        // A corner on the level belongs to the upper side, so that no piece is drawn twice or left out.
        if (own >= 0.0) != (other >= 0.0) {
            ends.push(on_the_way(here, next, own / (own - other)));
        }
    }
    match ends.as_slice() {
        [a, b] => Some([*a, *b]),
        _ => None,
    }
}
