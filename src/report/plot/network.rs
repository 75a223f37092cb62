//! The thermal network as a diagram: nodes as boxes, boundaries filled, paths as lines, heat as arrows. `arrangement`: what
//! stands where; `key`: what its marks mean.

pub mod arrangement;
mod key;
mod paint;
pub mod places;
pub mod room;

use super::canvas::{Canvas, Drawing, draw_within};
use super::palette::{BLUE, Colour, INK, PURPLE, VERMILION, diverging};
use super::sheet::Entry;
use arrangement::{Arrangement, arrange};
use key::{key, key_rows, paint_key, paint_listed};
use paint::{band_round, paint_arrow, paint_label, paint_node, paint_path};

pub use crate::thermal::element::{Path, Source};

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeShape {
    /// Stores heat.
    Diffusion,
    /// Stores none.
    Arithmetic,
    /// Has a given temperature.
    Boundary,
}

impl NodeShape {
    fn words(self) -> &'static str {
        match self {
            Self::Diffusion => "stores heat",
            Self::Arithmetic => "no storage",
            Self::Boundary => "given temperature",
        }
    }
}

/// The shape of a network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagram {
    /// Nodes: name and kind.
    pub nodes: Vec<(String, NodeShape)>,
    /// Paths: name, kind, the two nodes.
    pub paths: Vec<(String, Path, usize, usize)>,
    /// Sources: name, kind, node.
    pub sources: Vec<(String, Source, usize)>,
    /// Names of the nodes, paths and sources that adopted effects add. They do not move the boxes, which so stand where they
    /// stood before.
    pub adopted: Vec<String>,
    /// Names of those that adopted effects change.
    pub changed: Vec<String>,
    /// What is missing.
    pub missing: Vec<Missing>,
    /// Largest measured minus predicted at each node; `None` where nothing is measured. Empty: nodes keep their plain colour.
    pub deviations: Vec<Option<f64>>,
    /// Magnitude of a deviation that gets the full colour.
    pub full_scale: f64,
    /// Whether it shares the width of the page with another picture.
    pub is_small: bool,
}

impl Diagram {
    /// Whether an adopted effect adds or changes what has this name.
    fn is_adopted(&self, name: &String) -> bool {
        self.adopted.contains(name) || self.changed.contains(name)
    }
}

/// A path that is missing between two nodes, or was adopted there; heat at one where both are the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// What it is called.
    pub label: String,
    /// Kind.
    pub path: Path,
    /// One node.
    pub from: usize,
    /// The other.
    pub to: usize,
    /// Whether it is a node of its own, which hangs on the one node or stands between the two.
    pub is_node: bool,
}

/// Paths that have their names in the picture; of more the table has them.
const MOST_NAMED: usize = 30;

/// Size of a node's deviation, of its name's.
const NUMBER: f64 = 0.8;

/// Band under what is missing or adopted.
const BAND: Colour = (250, 214, 112);

/// Draws the network.
pub fn network(diagram: &Diagram) -> Drawing {
    let placed = arrange(diagram);
    let (width, field) = placed.frame;
    let key = key(diagram);
    let listed = placed.listed_height();
    let below = 38.0 + 46.0 * key_rows(&key, width).len() as f64 + listed;
    draw_within((width as u32, (field + below) as u32), |canvas| {
        paint_lines(canvas, diagram, &placed);
        for (own, area) in diagram.missing.iter().zip(&placed.hidden) {
            if let (true, Some(area)) = (own.is_node, area) {
                band_round(canvas, *area);
                let name = [HIDDEN.to_owned()];
                paint_node(canvas, (&name, ""), (NodeShape::Arithmetic, None), *area, placed.size);
            }
        }
        for (position, (name, kind)) in diagram.nodes.iter().enumerate() {
            let deviation = diagram.deviations.get(position).copied().flatten();
            let colour = deviation.map(|own| diverging(own / diagram.full_scale));
            let texts = (placed.names[position].as_slice(), placed.numbers[position].as_str());
            if diagram.is_adopted(name) {
                band_round(canvas, placed.boxes[position]);
            }
            paint_node(canvas, texts, (*kind, colour), placed.boxes[position], placed.size);
        }
        for ((name, source, _), arrow) in diagram.sources.iter().zip(&placed.arrows) {
            if let Some((tail, tip)) = arrow {
                paint_arrow(canvas, *source, diagram.is_adopted(name), (*tail, *tip));
            }
        }
        placed.labels.iter().for_each(|label| paint_label(canvas, label));
        paint_listed(canvas, &placed, field + 10.0);
        paint_key(canvas, &key, field + listed + 40.0, width);
        record(canvas, diagram, &placed);
    })
}

/// Paths, those of the model below those that are adopted or missing.
fn paint_lines(canvas: &mut Canvas<'_>, diagram: &Diagram, placed: &Arrangement) {
    for ((name, kind, ..), line) in diagram.paths.iter().zip(&placed.lines) {
        if let Some((from, to)) = line {
            if diagram.is_adopted(name) {
                canvas.path(&[*from, *to], BAND, 24);
            }
            paint_path(canvas, *kind, *from, *to);
        }
    }
    for (path, points) in &placed.adopted {
        let kind = diagram.paths[*path].1;
        canvas.path(points, BAND, 24);
        match kind {
            Path::Radiation => canvas.dashed(points, colour_of(kind), 5, 16.0, 12.0),
            Path::Conductor | Path::Flow | Path::Cooler => canvas.path(points, colour_of(kind), 5),
        }
    }
    for (own, points) in diagram.missing.iter().zip(&placed.missing) {
        canvas.path(points, BAND, 24);
        canvas.dashed(points, colour_of(own.path), 9, 30.0, 18.0);
    }
}

/// What a network shows has names and kinds; where it lies tells nothing.
fn record(canvas: &mut Canvas<'_>, diagram: &Diagram, placed: &Arrangement) {
    canvas.columns(["name", "kind", "node", "other node", "mark", DEVIATION]);
    let name = |node: usize| diagram.nodes.get(node).map_or("", |own| own.0.as_str());
    let place = |node: usize| placed.boxes.get(node).map_or((f64::NAN, f64::NAN), |own| own.0);
    let adopted = |own: &String| Entry::mark("adopted", diagram.is_adopted(own));
    for (node, (own, shape)) in diagram.nodes.iter().enumerate() {
        let deviation = diagram.deviations.get(node).copied().flatten().map_or(Entry::Empty, Entry::from);
        let nothing = [Entry::Empty, Entry::Empty];
        let nothing = nothing.into_iter().chain([adopted(own)]);
        let row =
            canvas.record([own.as_str().into(), shape.words().into()].into_iter().chain(nothing).chain([deviation]));
        canvas.seen(row, place(node));
    }
    for ((own, kind, from, to), line) in diagram.paths.iter().zip(&placed.lines) {
        let row = canvas.record([
            own.as_str().into(),
            path_words(*kind).into(),
            name(*from).into(),
            name(*to).into(),
            adopted(own),
        ]);
        let (from, to) = line.unwrap_or((place(*from), place(*to)));
        canvas.seen(row, (0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1)));
    }
    for (own, kind, node) in &diagram.sources {
        let kind = if *kind == Source::Load { LOAD } else { HEATER };
        canvas.record([own.as_str().into(), kind.into(), name(*node).into(), Entry::Empty, adopted(own)]);
    }
    for own in &diagram.missing {
        let to = if own.from == own.to { "" } else { name(own.to) };
        canvas.record([
            own.label.as_str().into(),
            (if own.is_node { "hidden node" } else { path_words(own.path) }).into(),
            name(own.from).into(),
            to.into(),
            "missing".into(),
        ]);
    }
}

/// What the colour of a node says.
const DEVIATION: &str = "largest measured \u{2212} predicted";

/// What sources are called.
const LOAD: &str = "heat load";
const HEATER: &str = "heater";

fn path_words(path: Path) -> &'static str {
    match path {
        Path::Conductor => "conduction",
        Path::Radiation => "radiation",
        Path::Flow => "other heat flow",
        Path::Cooler => "cooler, cold to hot",
    }
}

/// What the box of a missing node says.
const HIDDEN: &str = "hidden node";

fn colour_of(path: Path) -> Colour {
    match path {
        Path::Conductor => INK,
        Path::Radiation => VERMILION,
        Path::Flow => PURPLE,
        Path::Cooler => BLUE,
    }
}
