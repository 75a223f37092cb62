//! The thermal network as a diagram: nodes as boxes, boundaries filled, paths as lines, heat as arrows. `key`: what its
//! marks mean.

mod key;
pub mod places;

use super::canvas::{Anchor, Canvas, Drawing, Lettering, NARROW, SMALL, TEXT, WIDTH, draw_within, fitted, text_width};
use super::palette::{AMBER, BLUE, Colour, GREEN, INK, PAPER, PURPLE, VERMILION, diverging, is_light};
use super::sheet::Entry;
use crate::report::number::signed;
use key::{key, key_rows, paint_key};
use places::Field;

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

/// A rectangle by its centre and size.
type Boxed = ((f64, f64), (f64, f64));

fn overlap(a: &Boxed, b: &Boxed) -> bool {
    (a.0.0 - b.0.0).abs() < 0.5 * (a.1.0 + b.1.0) && (a.0.1 - b.0.1).abs() < 0.5 * (a.1.1 + b.1.1)
}

/// A straight line between two points.
type Segment = ((f64, f64), (f64, f64));

/// Whether a line passes through a rectangle, looked at every few pixels.
fn crosses((from, to): &Segment, rectangle: &Boxed) -> bool {
    (0..=100).any(|i| {
        let share = f64::from(i) / 100.0;
        let at = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
        overlap(rectangle, &(at, (8.0, 8.0)))
    })
}

/// Draws the network.
pub fn network(diagram: &Diagram) -> Drawing {
    let count = diagram.nodes.len();
    // Of the model alone: added nodes leave the others where they stood.
    let own = diagram.nodes.iter().filter(|node| !diagram.adopted.contains(&node.0)).count();
    let size = if diagram.is_small && (9..=20).contains(&own) {
        0.82 * TEXT
    } else if own > 20 {
        (TEXT * (20.0 / own as f64).sqrt()).max(18.0)
    } else {
        TEXT
    };
    let field = match own {
        0..=8 if diagram.is_small => 390.0,
        _ if diagram.is_small => 450.0,
        0..=3 => 430.0,
        4..=6 => 640.0,
        7..=12 => 860.0,
        13..=24 => 1080.0,
        _ => 1500.0,
    };
    let canvas_width = if diagram.is_small { NARROW } else { WIDTH };
    let width = f64::from(canvas_width);
    let (side, rim) = if diagram.is_small { (110.0, 60.0) } else { (200.0, 110.0) };
    let is_added = |node: usize| diagram.nodes.get(node).is_some_and(|own| diagram.adopted.contains(&own.0));
    // An added node is called like its effect.
    let name_of =
        |name: &String| if diagram.adopted.contains(name) { name.trim_end_matches(".hidden") } else { name }.to_owned();
    let names: Vec<_> = diagram.nodes.iter().map(|own| fitted(&name_of(&own.0), size, 330.0)).collect();
    let deviation_of = |node: usize| diagram.deviations.get(node).copied().flatten();
    // The colour in numbers, for those who do not see it.
    let numbers: Vec<_> =
        (0..count).map(|node| deviation_of(node).map(|own| signed(own, 1)).unwrap_or_default()).collect();
    let width_of = |(name, number): (&String, &String)| {
        let number = if number.is_empty() { 0.0 } else { text_width(number, NUMBER * size) + 0.4 * size };
        text_width(name, size) + number + 1.3 * size
    };
    let boxes: Vec<_> = names.iter().zip(&numbers).map(|own| (width_of(own), 1.9 * size)).collect();
    let centres = places::centres(diagram, &boxes, &Field { width, height: field, side, rim, gap: 1.6 * size });

    let key = key(diagram);
    let key_height = 38.0 + 46.0 * key_rows(&key, width).len() as f64;
    draw_within((canvas_width, (field + key_height) as u32), |canvas| {
        let mut taken: Vec<Boxed> = centres.iter().copied().zip(boxes.iter().copied()).collect();
        let lanes = lanes(diagram);
        for (path, &lane) in diagram.paths.iter().zip(&lanes).filter(|(path, _)| !diagram.adopted.contains(&path.0)) {
            if let (Some(&from), Some(&to)) = (centres.get(path.2), centres.get(path.3)) {
                let (from, to) = shifted(from, to, lane);
                if diagram.is_adopted(&path.0) {
                    canvas.path(&[from, to], BAND, 24);
                }
                paint_path(canvas, path.1, from, to);
            }
        }
        // Where it was missing, and named like it.
        let adopted: Vec<(Missing, Vec<(f64, f64)>)> = (diagram.paths.iter())
            .filter(|path| diagram.adopted.contains(&path.0))
            .map(|(name, path, from, to)| {
                let label = format!("adopted: {name}");
                let own = Missing { label, path: *path, from: *from, to: *to, is_node: false };
                let points = route(&own, &centres, &boxes);
                (own, points)
            })
            .collect();
        for (own, points) in &adopted {
            canvas.path(points, BAND, 24);
            match own.path {
                Path::Radiation => canvas.dashed(points, colour_of(own.path), 5, 16.0, 12.0),
                Path::Conductor | Path::Flow | Path::Cooler => canvas.path(points, colour_of(own.path), 5),
            }
        }
        let hidden = (text_width(HIDDEN, size) + 1.3 * size, 1.9 * size);
        let mut missing: Vec<Vec<(f64, f64)>> = Vec::new();
        for own in &diagram.missing {
            let at_one = own.is_node && own.from == own.to;
            let host = centres.get(own.from).zip(boxes.get(own.from)).filter(|_| at_one);
            let points = match host {
                Some((&centre, &shape)) => {
                    vec![beside((centre, shape), hidden, &taken, (width, field)), centre]
                }
                None => route(own, &centres, &boxes),
            };
            canvas.path(&points, BAND, 24);
            canvas.dashed(&points, colour_of(own.path), 9, 30.0, 18.0);
            let middle = if own.from == own.to { 0 } else { points.len() / 2 };
            if let Some(&at) = points.get(middle).filter(|_| own.is_node) {
                band_round(canvas, (at, hidden));
                paint_node(canvas, (HIDDEN, ""), (NodeShape::Arithmetic, None), (at, hidden), size);
                taken.push((at, hidden));
            }
            missing.push(points);
        }
        for (position, (_, kind)) in diagram.nodes.iter().enumerate() {
            let colour =
                diagram.deviations.get(position).copied().flatten().map(|own| diverging(own / diagram.full_scale));
            let texts = (names[position].as_str(), numbers[position].as_str());
            if diagram.is_adopted(&diagram.nodes[position].0) {
                band_round(canvas, (centres[position], boxes[position]));
            }
            paint_node(canvas, texts, (*kind, colour), (centres[position], boxes[position]), size);
        }
        let lines: Vec<_> = diagram
            .paths
            .iter()
            .zip(&lanes)
            .filter_map(|(p, &lane)| Some(shifted(*centres.get(p.2)?, *centres.get(p.3)?, lane)))
            .collect();
        // What is missing is named first: it finds the best place.
        for (own, points) in diagram.missing.iter().zip(&missing) {
            label_missing(canvas, own, points, &mut taken, (width, field), true);
        }
        // What leads to an added node is named by it; another name without a free place would cover a box.
        for (own, points) in adopted.iter().filter(|(own, _)| !is_added(own.from) && !is_added(own.to)) {
            label_missing(canvas, own, points, &mut taken, (width, field), false);
        }
        for (name, source, node) in &diagram.sources {
            if let (Some(&centre), Some(&shape)) = (centres.get(*node), boxes.get(*node)) {
                let is_adopted = diagram.is_adopted(name);
                paint_source(canvas, name, (*source, is_adopted), (centre, shape), &mut taken, &lines, (width, field));
            }
        }
        if diagram.paths.len() <= MOST_NAMED {
            let named = diagram.paths.iter().zip(&lanes).filter(|(path, _)| !diagram.adopted.contains(&path.0));
            for (path, &lane) in named {
                if let (Some(&from), Some(&to)) = (centres.get(path.2), centres.get(path.3)) {
                    let (from, to) = shifted(from, to, lane);
                    label_path(canvas, &path.0, path.1, (from, to), &mut taken);
                }
            }
        }
        paint_key(canvas, &key, field + 40.0, width);
        record(canvas, diagram, &centres);
    })
}

/// What a network shows has names and kinds; where it lies tells nothing.
fn record(canvas: &mut Canvas<'_>, diagram: &Diagram, centres: &[(f64, f64)]) {
    canvas.columns(["name", "kind", "node", "other node", "mark", DEVIATION]);
    let name = |node: usize| diagram.nodes.get(node).map_or("", |own| own.0.as_str());
    let place = |node: usize| centres.get(node).copied().unwrap_or((f64::NAN, f64::NAN));
    let adopted = |own: &String| Entry::mark("adopted", diagram.is_adopted(own));
    for (node, (own, shape)) in diagram.nodes.iter().enumerate() {
        let deviation = diagram.deviations.get(node).copied().flatten().map_or(Entry::Empty, Entry::from);
        let nothing = [Entry::Empty, Entry::Empty];
        let nothing = nothing.into_iter().chain([adopted(own)]);
        let row =
            canvas.record([own.as_str().into(), shape.words().into()].into_iter().chain(nothing).chain([deviation]));
        canvas.seen(row, place(node));
    }
    for ((own, kind, from, to), lane) in diagram.paths.iter().zip(lanes(diagram)) {
        let row = canvas.record([
            own.as_str().into(),
            path_words(*kind).into(),
            name(*from).into(),
            name(*to).into(),
            adopted(own),
        ]);
        let (from, to) = shifted(place(*from), place(*to), lane);
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

/// A band round a box.
fn band_round(canvas: &mut Canvas<'_>, (centre, shape): Boxed) {
    let half = (shape.0 / 2.0 + 12.0, shape.1 / 2.0 + 12.0);
    canvas.fill((centre.0 - half.0, centre.1 - half.1), (centre.0 + half.0, centre.1 + half.1), BAND, 1.0);
}

/// Where a box finds room beside a node, inside the field and clear of the others; above it where there is none.
fn beside((centre, shape): Boxed, own: (f64, f64), taken: &[Boxed], (width, field): (f64, f64)) -> (f64, f64) {
    let (dx, dy) = (0.5 * (shape.0 + own.0) + 60.0, 0.5 * (shape.1 + own.1) + 60.0);
    let inside = |(x, y): (f64, f64)| {
        let (half_x, half_y) = (own.0 / 2.0 + 14.0, own.1 / 2.0 + 14.0);
        (x.clamp(half_x, (width - half_x).max(half_x)), y.clamp(half_y, (field - half_y).max(half_y)))
    };
    let sides = [(0.0, -1.0), (0.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (-1.0, 0.0)];
    let places = sides.map(|(sx, sy)| inside((centre.0 + sx * dx, centre.1 + sy * dy)));
    let is_free = |at: &&(f64, f64)| !taken.iter().any(|other| overlap(other, &(**at, own)));
    places.iter().find(is_free).copied().unwrap_or(places[0])
}

/// The line of a missing path: straight, or bent round the boxes that stand between; at one node a line from above or below.
fn route(own: &Missing, centres: &[(f64, f64)], boxes: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let (Some(&from), Some(&to)) = (centres.get(own.from), centres.get(own.to)) else { return Vec::new() };
    if own.from == own.to {
        let half = boxes.get(own.from).map_or(30.0, |size| size.1 / 2.0);
        let away = if from.1 > 160.0 { -half - 90.0 } else { half + 90.0 };
        return vec![(from.0 + 40.0, from.1 + away), (from.0 + 40.0, from.1)];
    }
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = (dx * dx + dy * dy).sqrt().max(1e-9);
    let bent = |by: f64| -> Vec<(f64, f64)> {
        let control = (0.5 * (from.0 + to.0) - dy / length * by, 0.5 * (from.1 + to.1) + dx / length * by);
        (0..=24)
            .map(|step| {
                let t = f64::from(step) / 24.0;
                let (a, b, c) = ((1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t);
                (a * from.0 + b * control.0 + c * to.0, a * from.1 + b * control.1 + c * to.1)
            })
            .collect()
    };
    let is_free = |points: &[(f64, f64)]| {
        let others = centres.iter().zip(boxes).enumerate().filter(|(node, _)| *node != own.from && *node != own.to);
        let others: Vec<Boxed> = others.map(|(_, (&centre, &size))| (centre, size)).collect();
        points.windows(2).all(|pair| !others.iter().any(|other| crosses(&(pair[0], pair[1]), other)))
    };
    let bends = [0.0, 110.0, -110.0, 220.0, -220.0, 330.0, -330.0];
    bends.into_iter().map(bent).find(|points| is_free(points)).unwrap_or_else(|| vec![from, to])
}

/// The name of what is missing, on its line where that is free.
fn label_missing(
    canvas: &mut Canvas<'_>,
    own: &Missing,
    points: &[(f64, f64)],
    taken: &mut Vec<Boxed>,
    (width, field): (f64, f64),
    must_stand: bool,
) {
    let name = fitted(&own.label, SMALL, 620.0);
    let label = (text_width(&name, SMALL) + 16.0, 1.3 * SMALL);
    let half = label.0 / 2.0;
    let inside =
        |at: (f64, f64)| (at.0.clamp(half + 4.0, (width - half - 4.0).max(half + 4.0)), at.1.min(field - 24.0));
    let on_line = points.iter().copied();
    let beside = points.iter().flat_map(|&(x, y)| {
        [44.0, 80.0, 120.0].into_iter().flat_map(move |by| {
            [(x, y - by), (x, y + by), (x - half, y - by), (x + half, y - by), (x - half, y + by), (x + half, y + by)]
        })
    });
    // From the middle outwards.
    let mut places: Vec<(f64, f64)> = on_line.chain(beside).map(inside).filter(|at| at.1 > 24.0).collect();
    let middle = points.get(points.len() / 2).copied().unwrap_or((width / 2.0, 60.0));
    let distance = |at: &(f64, f64)| (at.0 - middle.0).abs() + (at.1 - middle.1).abs();
    places.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let free = places.iter().find(|at| !taken.iter().any(|other| overlap(other, &(**at, label))));
    if let Some(&at) = free.or(places.first().filter(|_| must_stand)) {
        taken.push((at, label));
        canvas.text_on_paper(&name, at, Lettering::new(SMALL, colour_of(own.path)).bold().at(Anchor::Middle));
    }
}

/// Sideways place of each path, so that several between the same nodes lie beside one another.
fn lanes(diagram: &Diagram) -> Vec<f64> {
    let pair = |p: &(String, Path, usize, usize)| (p.2.min(p.3), p.2.max(p.3));
    let mut out = Vec::with_capacity(diagram.paths.len());
    for (position, path) in diagram.paths.iter().enumerate() {
        let joined_nodes = pair(path);
        let all = diagram.paths.iter().filter(|p| pair(p) == joined_nodes).count();
        let before = diagram.paths[..position].iter().filter(|p| pair(p) == joined_nodes).count();
        let lane = 44.0 * (before as f64 - 0.5 * (all as f64 - 1.0));
        // The normal turns with the direction of the path.
        out.push(if path.2 <= path.3 { lane } else { -lane });
    }
    out
}

fn shifted(from: (f64, f64), to: (f64, f64), lane: f64) -> ((f64, f64), (f64, f64)) {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = (dx * dx + dy * dy).sqrt().max(1e-9);
    let (nx, ny) = (-dy / length * lane, dx / length * lane);
    ((from.0 + nx, from.1 + ny), (to.0 + nx, to.1 + ny))
}

fn colour_of(path: Path) -> Colour {
    match path {
        Path::Conductor => INK,
        Path::Radiation => VERMILION,
        Path::Flow => PURPLE,
        Path::Cooler => BLUE,
    }
}

fn paint_path(canvas: &mut Canvas<'_>, path: Path, from: (f64, f64), to: (f64, f64)) {
    let colour = colour_of(path);
    match path {
        Path::Conductor => canvas.path(&[from, to], colour, 5),
        Path::Radiation => canvas.dashed(&[from, to], colour, 5, 16.0, 12.0),
        Path::Flow | Path::Cooler => {
            canvas.path(&[from, to], colour, if path == Path::Cooler { 12 } else { 4 });
            let along = |share: f64| (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            let head = (0.4 * (dx * dx + dy * dy).sqrt()).min(38.0);
            canvas.arrow_head(from, along(0.74), colour, head);
        }
    }
}

/// A box with its name and, in a colour that tells the same, its deviation.
fn paint_node(
    canvas: &mut Canvas<'_>,
    (name, number): (&str, &str),
    (kind, colour): (NodeShape, Option<Colour>),
    (centre, shape): Boxed,
    size: f64,
) {
    let ink_on = |colour: Option<Colour>| if colour.is_none_or(is_light) { INK } else { PAPER };
    let (a, b) =
        ((centre.0 - shape.0 / 2.0, centre.1 - shape.1 / 2.0), (centre.0 + shape.0 / 2.0, centre.1 + shape.1 / 2.0));
    let ink = match kind {
        NodeShape::Boundary => {
            canvas.fill(a, b, INK, 1.0);
            PAPER
        }
        NodeShape::Diffusion => {
            canvas.fill(a, b, colour.unwrap_or((231, 242, 250)), 1.0);
            canvas.outline(a, b, BLUE, 5);
            ink_on(colour)
        }
        NodeShape::Arithmetic => {
            canvas.fill(a, b, colour.unwrap_or(PAPER), 1.0);
            canvas.dashed(&[a, (b.0, a.1), b, (a.0, b.1), a], BLUE, 4, 12.0, 8.0);
            ink_on(colour)
        }
    };
    let beside = if number.is_empty() { 0.0 } else { text_width(number, NUMBER * size) + 0.4 * size };
    let middle = (centre.0 - beside / 2.0, centre.1);
    canvas.text(name, middle, Lettering::new(size, ink).bold().at(Anchor::Middle));
    let end = (centre.0 + shape.0 / 2.0 - 0.35 * size, centre.1);
    canvas.text(number, end, Lettering::new(NUMBER * size, ink).at(Anchor::End));
}

/// An arrow from the side where its name finds room.
fn paint_source(
    canvas: &mut Canvas<'_>,
    name: &str,
    (source, is_adopted): (Source, bool),
    (centre, shape): Boxed,
    taken: &mut Vec<Boxed>,
    lines: &[Segment],
    field: (f64, f64),
) {
    let colour = if source == Source::Load { GREEN } else { AMBER };
    let name = fitted(name, SMALL, 280.0);
    let label = (text_width(&name, SMALL) + 14.0, 1.3 * SMALL);
    let (half_x, half_y) = (shape.0 / 2.0, shape.1 / 2.0);
    let mut best = None;
    let mut is_named = false;
    let ends = |at: (f64, f64), (sx, sy): (f64, f64)| {
        let level = (centre.0 + sx * half_x, centre.1);
        let tip = if sy == 0.0 { level } else { (centre.0 + 0.5 * sx * half_x, centre.1 + sy * half_y) };
        let tail = if sy == 0.0 { (at.0 - sx * label.0 / 2.0, at.1) } else { (at.0, at.1 - sy * label.1 / 2.0) };
        (tip, tail)
    };
    let covers = |shaft: &Segment| taken.iter().any(|other| other.0 != centre && crosses(shaft, other));
    let reaches = [(66.0, false), (100.0, false), (66.0, true), (100.0, true), (140.0, true)];
    // First a place that no line crosses, then any that is free, and an arrow over another box last.
    let tries = [false, true].into_iter().flat_map(|may_cover| reaches.map(|(reach, cross)| (reach, cross, may_cover)));
    'search: for (reach, may_cross, may_cover) in tries {
        let (far_x, far_y) = (half_x + reach + label.0 / 2.0, half_y + reach + label.1 / 2.0);
        for (sx, sy) in
            [(0.0, -1.0), (0.0, 1.0), (-0.55, -1.0), (0.55, -1.0), (1.0, 0.0), (-1.0, 0.0), (-0.55, 1.0), (0.55, 1.0)]
        {
            let at = (centre.0 + sx * far_x, centre.1 + sy * far_y);
            let fits = at.0 - label.0 / 2.0 > 0.0
                && at.0 + label.0 / 2.0 < field.0
                && at.1 - label.1 / 2.0 > 0.0
                && at.1 + label.1 / 2.0 < field.1;
            let candidate = (at, (sx, sy));
            best.get_or_insert(candidate);
            let is_free = !taken.iter().any(|t| overlap(t, &(at, label)));
            let is_off_lines = may_cross || !lines.iter().any(|l| crosses(l, &(at, label)));
            if fits && is_free && is_off_lines && (may_cover || !covers(&ends(at, (sx, sy)))) {
                best = Some(candidate);
                is_named = true;
                break 'search;
            }
        }
    }
    if let Some((at, (sx, sy))) = best {
        let (tip, tail) = ends(at, (sx, sy));
        let shaft = ((tail.0 - tip.0).abs() + 24.0, (tail.1 - tip.1).abs());
        taken.push((((tail.0 + tip.0) / 2.0, (tail.1 + tip.1) / 2.0), shaft));
        if is_adopted {
            canvas.path(&[tail, tip], BAND, 24);
        }
        canvas.path(&[tail, tip], colour, 6);
        canvas.arrow_head(tail, tip, colour, 28.0);
        // A name without a free place would cover another; the table has it.
        if is_named {
            taken.push((at, label));
            canvas.text_on_paper(&name, at, Lettering::new(SMALL, colour).at(Anchor::Middle));
        }
    }
}

/// The name of a path where it covers nothing, or nowhere.
fn label_path(
    canvas: &mut Canvas<'_>,
    name: &str,
    path: Path,
    (from, to): ((f64, f64), (f64, f64)),
    taken: &mut Vec<Boxed>,
) {
    let name = fitted(name, SMALL, 380.0);
    let label = (text_width(&name, SMALL) + 12.0, 1.2 * SMALL);
    for share in [0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74] {
        let at = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
        if !taken.iter().any(|t| overlap(t, &(at, label))) {
            taken.push((at, label));
            canvas.text_on_paper(&name, at, Lettering::new(SMALL, colour_of(path)).at(Anchor::Middle));
            return;
        }
    }
}
