//! What stands where in a picture of a network: boxes, lines, arrows and names, all within the frame; no name lies on a box or
//! another name. What finds no room for its name has a number there, and its name below the picture.

use super::super::canvas::{NARROW, SMALL, TEXT, WIDTH, text_width};
use super::super::palette::{Colour, INK};
use super::paint::source_colour;
use super::places::{Field, centres, free};
use super::room::{Boxed, RIM, Room, Segment, at_most, crosses, height, lines, text_size};
use super::{Diagram, HIDDEN, MOST_NAMED, NUMBER, Path, Source, colour_of};
use crate::document::counted;
use crate::math::sort::sort_by;
use crate::report::number::signed;

/// Width of a line of a node's name, pixels.
const NAME: f64 = 330.0;
/// Lines of a name in the picture, and of one below it.
const MOST_LINES: usize = 3;
const MOST_LISTED: usize = 5;
/// Names below the picture from which on none of what the model has is added; half of that below a narrow one.
const MOST_OWN: usize = 8;

/// A name in the picture, or the number under which it stands below.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Its lines.
    pub lines: Vec<String>,
    /// Where it stands.
    pub area: Boxed,
    /// Its colour.
    pub colour: Colour,
    /// Whether it is bold.
    pub is_bold: bool,
    /// Whether it is a number.
    pub is_number: bool,
}

/// A name below the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Listed {
    /// Its lines.
    pub lines: Vec<String>,
    /// Its colour.
    pub colour: Colour,
}

/// What stands where, pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrangement {
    /// Width and height of the picture without what stands below it.
    pub frame: (f64, f64),
    /// Size of the nodes' names.
    pub size: f64,
    /// Boxes of the nodes.
    pub boxes: Vec<Boxed>,
    /// Names of the nodes in lines.
    pub names: Vec<Vec<String>>,
    /// Deviations of the nodes: the colour in numbers, for those who do not see it.
    pub numbers: Vec<String>,
    /// Lines of the model's own paths; `None` of one that is adopted or joins a box to itself.
    pub lines: Vec<Option<Segment>>,
    /// Lines of adopted paths.
    pub adopted: Vec<(usize, Vec<(f64, f64)>)>,
    /// Boxes of missing nodes.
    pub hidden: Vec<Option<Boxed>>,
    /// Lines of what is missing; empty where there is no room for one.
    pub missing: Vec<Vec<(f64, f64)>>,
    /// Arrows of sources, from tail to tip.
    pub arrows: Vec<Option<Segment>>,
    /// Names in the picture.
    pub labels: Vec<Label>,
    /// Names below it.
    pub listed: Vec<Listed>,
}

impl Arrangement {
    /// Height of what is listed below the picture.
    pub(super) fn listed_height(&self) -> f64 {
        let rows: usize = self.listed.iter().map(|entry| entry.lines.len()).sum();
        if rows == 0 { 0.0 } else { height(rows, SMALL) + 24.0 }
    }

    /// Puts a name below the picture; gives its number.
    fn list(&mut self, text: &str, colour: Colour) -> String {
        self.listed.push(Listed { lines: at_most(text, SMALL, self.frame.0 - 100.0, MOST_LISTED), colour });
        self.listed.len().to_string()
    }
}

/// A name that is to be placed: as it is, or as a number.
struct Name {
    text: String,
    lines: Vec<String>,
    colour: Colour,
    /// Of what is adopted or missing; else of what the model has.
    is_bold: bool,
}

impl Name {
    fn new(text: &str, colour: Colour, width: f64) -> Self {
        Self { text: text.to_owned(), lines: lines(text, SMALL, width), colour, is_bold: true }
    }

    /// Of something that the model has.
    fn own(text: &str, colour: Colour, width: f64) -> Self {
        Self { is_bold: false, ..Self::new(text, colour, width) }
    }

    /// Places it by a search for room of a size: its own first, where it has few lines, then that of a number. What was found
    /// is given; below the picture it stands with or without a number there.
    fn place<T>(
        &self,
        out: &mut Arrangement,
        room: &mut Room,
        search: impl Fn(&Room, (f64, f64)) -> Option<(T, (f64, f64))>,
    ) -> Option<T> {
        let size = text_size(&self.lines, SMALL);
        let most = if self.is_bold { MOST_LINES } else { MOST_LINES - 1 };
        let whole = if self.lines.len() <= most { search(room, size) } else { None };
        let (found, lines, size) = match whole {
            Some(found) => (found, self.lines.clone(), size),
            None => {
                let number = vec![(out.listed.len() + 1).to_string()];
                let size = text_size(&number, SMALL);
                let is_full = out.listed.len() >= if out.frame.0 > f64::from(NARROW) { MOST_OWN } else { MOST_OWN / 2 };
                let found = if !self.is_bold && is_full { None } else { search(room, size) };
                if found.is_none() && !self.is_bold {
                    // What the model has stands in the table too.
                    return None;
                }
                out.list(&self.text, self.colour);
                (found?, number, size)
            }
        };
        let area = (found.1, size);
        room.taken.push(area);
        let is_number = self.lines != lines;
        out.labels.push(Label { lines, area, colour: self.colour, is_bold: self.is_bold || is_number, is_number });
        Some(found.0)
    }
}

/// Arranges a network.
pub fn arrange(diagram: &Diagram) -> Arrangement {
    let (mut out, mut room) = with_boxes(diagram);
    with_lines(diagram, &mut out, &mut room);
    with_missing(diagram, &mut out, &mut room);
    let width = label_width(diagram);
    let is_added = |node: usize| diagram.nodes.get(node).is_some_and(|own| diagram.adopted.contains(&own.0));
    for (path, points) in out.adopted.clone() {
        let (name, kind, from, to) = &diagram.paths[path];
        // What leads to an added node is named by it.
        if !is_added(*from) && !is_added(*to) {
            let name = Name::new(&format!("adopted: {name}"), colour_of(*kind), width);
            name.place(&mut out, &mut room, |room, size| along(room, &points, size).map(|at| ((), at)));
        }
    }
    with_sources(diagram, &mut out, &mut room);
    if diagram.paths.len() <= MOST_NAMED {
        for (position, (name, kind, ..)) in diagram.paths.iter().enumerate() {
            // Where it would cover something it is left to the table.
            if let Some(line) = out.lines[position] {
                Name::own(name, colour_of(*kind), 380.0)
                    .place(&mut out, &mut room, |room, size| on_line(room, &line, size).map(|at| ((), at)));
            }
        }
    }
    out
}

/// Width of a line of a label, pixels.
fn label_width(diagram: &Diagram) -> f64 {
    if diagram.is_small { 330.0 } else { 460.0 }
}

/// The boxes of the nodes, which the rest of the picture does not move.
fn with_boxes(diagram: &Diagram) -> (Arrangement, Room) {
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
    let height = match own {
        0..=8 if diagram.is_small => 390.0,
        _ if diagram.is_small => 450.0,
        0..=3 => 430.0,
        4..=6 => 640.0,
        7..=12 => 860.0,
        13..=24 => 1080.0,
        _ => 1500.0,
    };
    let width = f64::from(if diagram.is_small { NARROW } else { WIDTH });
    let (side, rim) = if diagram.is_small { (110.0, 60.0) } else { (200.0, 110.0) };
    let mut out = Arrangement { frame: (width, height), size, ..Arrangement::default() };
    for (name, _) in &diagram.nodes {
        // An added node is called like its effect.
        let is_effect = |own: &&str| diagram.adopted.contains(name) && diagram.adopted.iter().any(|other| other == own);
        let name = name.rsplit_once('.').map(|(effect, _)| effect).filter(is_effect).unwrap_or(name);
        let broken = lines(name, size, NAME);
        let shown = if broken.len() > MOST_LINES { vec![out.list(name, INK)] } else { broken };
        out.names.push(shown);
    }
    let number = |node: usize| diagram.deviations.get(node).copied().flatten().map(|own| signed(own, 1));
    out.numbers = (0..count).map(|node| number(node).unwrap_or_default()).collect();
    let box_of = |name: &Vec<String>, number: &str| {
        let number = if number.is_empty() { 0.0 } else { text_width(number, NUMBER * size) + 0.4 * size };
        let name_width = name.iter().map(|line| text_width(line, size)).fold(0.0, f64::max);
        (name_width + number + 1.3 * size, 1.9 * size + super::room::height(name.len().saturating_sub(1), size))
    };
    // Room for a number is kept where there is none yet, so that readings move no box.
    let reserved: Vec<(f64, f64)> = (out.names.iter().zip(&out.numbers))
        .map(|(name, number)| {
            let (least, own) = (box_of(name, "\u{2212}00.0"), box_of(name, number));
            (least.0.max(own.0), own.1)
        })
        .collect();
    let field = Field { width, height, side, rim, gap: 1.6 * size };
    let (places, height) = centres(diagram, &reserved, &field);
    out.frame.1 = height;
    let sizes = out.names.iter().zip(&out.numbers).map(|(name, number)| box_of(name, number));
    out.boxes = places.iter().copied().zip(sizes).collect();
    let room = Room { frame: out.frame, taken: places.into_iter().zip(reserved).collect(), lines: Vec::new() };
    (out, room)
}

/// The lines of paths, straight, those of adopted ones round what stands between.
fn with_lines(diagram: &Diagram, out: &mut Arrangement, room: &mut Room) {
    for (path, lane) in diagram.paths.iter().zip(lanes(diagram, 1.3 * out.size)) {
        let ends = out.boxes.get(path.2).zip(out.boxes.get(path.3)).filter(|_| path.2 != path.3);
        let is_own = !diagram.adopted.contains(&path.0);
        out.lines.push(ends.filter(|_| is_own).map(|(from, to)| shifted(from.0, to.0, lane)));
    }
    room.lines.extend(out.lines.iter().flatten());
    for (position, (name, _, from, to)) in diagram.paths.iter().enumerate() {
        if diagram.adopted.contains(name) && from != to {
            let points = route(diagram, (*from, *to), &out.boxes, room.frame);
            if !points.is_empty() {
                out.adopted.push((position, points));
            }
        }
    }
}

/// What is missing: boxes and lines between two nodes first, then names and what hangs at one node.
fn with_missing(diagram: &Diagram, out: &mut Arrangement, room: &mut Room) {
    let size = out.size;
    let hidden = (text_width(HIDDEN, size) + 1.3 * size, 1.9 * size);
    for own in &diagram.missing {
        let ends = out.boxes.get(own.from).copied().zip(out.boxes.get(own.to).copied()).filter(|_| own.is_node);
        let area = ends.map(|(from, to)| {
            let above = if own.from == own.to { 0.5 * (from.1.1 + hidden.1) + 60.0 } else { 0.0 };
            let wanted = (0.5 * (from.0.0 + to.0.0), 0.5 * (from.0.1 + to.0.1) - above);
            (free(room, wanted, (hidden.0 + 24.0, hidden.1 + 24.0), 36.0), hidden)
        });
        room.taken.extend(area.map(|(at, size)| (at, (size.0 + 24.0, size.1 + 24.0))));
        out.missing.push(match (area, ends) {
            (Some((at, _)), Some((from, _))) if own.from == own.to => vec![at, from.0],
            (Some((at, _)), Some((from, to))) => vec![from.0, at, to.0],
            _ if own.from == own.to => Vec::new(),
            _ => route(diagram, (own.from, own.to), &out.boxes, room.frame),
        });
        out.hidden.push(area);
    }
    out.frame = room.frame;
    let routes = out.missing.iter().chain(out.adopted.iter().map(|own| &own.1));
    room.lines.extend(routes.flat_map(|points| points.windows(2)).map(|pair| (pair[0], pair[1])));
    for (position, own) in diagram.missing.iter().enumerate() {
        let name = Name::new(&own.label, colour_of(own.path), label_width(diagram));
        let hangs = !own.is_node && own.from == own.to;
        match out.boxes.get(own.from).copied().filter(|_| hangs) {
            Some(host) => {
                let found = name.place(out, room, |room, size| hanging(room, host, size));
                if let Some((tail, tip)) = found.or_else(|| hanging(room, host, BARE).map(|found| found.0)) {
                    room.taken.push(shaft((tail, tip)));
                    out.missing[position] = vec![tail, tip];
                }
            }
            None => {
                let points = out.missing[position].clone();
                name.place(out, room, |room, size| along(room, &points, size).map(|at| ((), at)));
            }
        }
    }
}

/// Room for an arrow without a name.
const BARE: (f64, f64) = (30.0, 8.0);

/// Arrows of heat from the side where their names find room.
fn with_sources(diagram: &Diagram, out: &mut Arrangement, room: &mut Room) {
    let mut left_out = 0;
    for (name, source, node) in &diagram.sources {
        let is_adopted = diagram.is_adopted(name);
        let Some(host) = out.boxes.get(*node).copied() else {
            out.arrows.push(None);
            continue;
        };
        let colour = source_colour(*source);
        let name = match is_adopted {
            true => Name { text: format!("adopted: {name}"), ..Name::new(name, colour, 280.0) },
            false => Name::own(name, colour, 280.0),
        };
        let arrow = name.place(out, room, |room, size| hanging(room, host, size));
        // Without a free place for a number either the table has it.
        let arrow = arrow.or_else(|| hanging(room, host, BARE).map(|found| found.0));
        room.taken.extend(arrow.map(shaft));
        left_out += usize::from(arrow.is_none());
        out.arrows.push(arrow);
    }
    if left_out > 0 {
        let words = format!("no room for {} of heat: see the table", counted(left_out, "arrow"));
        out.list(&words, source_colour(Source::Load));
    }
}

/// What an arrow or a stub takes.
fn shaft((tail, tip): Segment) -> Boxed {
    let size = ((tail.0 - tip.0).abs() + 24.0, (tail.1 - tip.1).abs());
    (((tail.0 + tip.0) / 2.0, (tail.1 + tip.1) / 2.0), size)
}

/// A line from the side of a box outwards, from its tail to its tip, and a place for a name at its tail.
fn hanging(room: &Room, (centre, shape): Boxed, label: (f64, f64)) -> Option<(Segment, (f64, f64))> {
    let (half_x, half_y) = (shape.0 / 2.0, shape.1 / 2.0);
    let ends = |at: (f64, f64), (sx, sy): (f64, f64)| {
        let level = (centre.0 + sx * half_x, centre.1);
        let tip = if sy == 0.0 { level } else { (centre.0 + 0.5 * sx * half_x, centre.1 + sy * half_y) };
        let tail = if sy == 0.0 { (at.0 - sx * label.0 / 2.0, at.1) } else { (at.0, at.1 - sy * label.1 / 2.0) };
        (tail, tip)
    };
    let covers = |line: &Segment| {
        let apart = |other: &&Boxed| other.0 != centre;
        room.taken.iter().filter(apart).any(|other| crosses(line, other) || super::room::overlap(&shaft(*line), other))
    };
    let sides =
        [(0.0, -1.0), (0.0, 1.0), (-0.55, -1.0), (0.55, -1.0), (1.0, 0.0), (-1.0, 0.0), (-0.55, 1.0), (0.55, 1.0)];
    // First a place that hides no line, then any that is free.
    let reaches = [(66.0, false), (100.0, false), (66.0, true), (100.0, true), (140.0, true), (40.0, true)];
    reaches.into_iter().find_map(|(reach, may_hide)| {
        let (far_x, far_y) = (half_x + reach + label.0 / 2.0, half_y + reach + label.1 / 2.0);
        sides.into_iter().find_map(|side| {
            let at = (centre.0 + side.0 * far_x, centre.1 + side.1 * far_y);
            let line = ends(at, side);
            let fits = room.is_free(&(at, label)) && (may_hide || room.is_off_lines(&(at, label)));
            (fits && !covers(&line)).then_some((line, at))
        })
    })
}

/// A place for a name on a straight line, from its middle outwards, where it hides no other line; else close beside it.
fn on_line(room: &Room, line: &Segment, size: (f64, f64)) -> Option<(f64, f64)> {
    let (from, to) = *line;
    let at = |share: f64| (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
    let hides = |at: (f64, f64)| room.lines.iter().any(|other| other != line && crosses(other, &(at, size)));
    let places = [0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74].map(at);
    let on = places.into_iter().find(|&at| room.is_free(&(at, size)) && !hides(at));
    on.or_else(|| {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = (dx * dx + dy * dy).sqrt().max(1e-9);
        let normal = (-dy / length, dx / length);
        let off = 0.5 * (normal.0.abs() * size.0 + normal.1.abs() * size.1) + 10.0;
        let beside =
            places.into_iter().flat_map(|at| [off, -off].map(|by| (at.0 + by * normal.0, at.1 + by * normal.1)));
        beside.into_iter().find(|&at| room.is_free(&(at, size)) && room.is_off_lines(&(at, size)))
    })
}

/// A place for a name on a line or beside it, from its middle outwards.
fn along(room: &Room, points: &[(f64, f64)], (width, height): (f64, f64)) -> Option<(f64, f64)> {
    let middle = match points {
        [] => return None,
        [from, to] => (0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1)),
        more => more[more.len() / 2],
    };
    let half = width / 2.0;
    let inside = |at: (f64, f64)| {
        let (low, high) = (half + RIM, room.frame.0 - half - RIM);
        (at.0.clamp(low, high.max(low)), at.1)
    };
    let beside = |(x, y): (f64, f64)| {
        [0.0, 44.0, 80.0, 120.0].into_iter().flat_map(move |by| {
            let by = if by > 0.0 { by - 20.0 + 0.5 * height } else { 0.0 };
            [(x, y - by), (x, y + by), (x - half, y - by), (x + half, y - by), (x - half, y + by), (x + half, y + by)]
        })
    };
    let mut places: Vec<(f64, f64)> = points.iter().copied().chain([middle]).flat_map(beside).map(inside).collect();
    let distance = |at: &(f64, f64)| (at.0 - middle.0).abs() + (at.1 - middle.1).abs();
    sort_by(&mut places, |a, b| distance(a).total_cmp(&distance(b)));
    places.into_iter().find(|&at| room.is_free(&(at, (width, height))))
}

/// A line between two nodes: straight, or bent round the boxes that stand between and off a line that joins the same nodes, all
/// of it in the frame.
fn route(diagram: &Diagram, (from, to): (usize, usize), boxes: &[Boxed], frame: (f64, f64)) -> Vec<(f64, f64)> {
    let (Some(&(start, _)), Some(&(end, _))) = (boxes.get(from), boxes.get(to)) else { return Vec::new() };
    let (dx, dy) = (end.0 - start.0, end.1 - start.1);
    let length = (dx * dx + dy * dy).sqrt().max(1e-9);
    let bent = |by: f64| -> Vec<(f64, f64)> {
        let control = (0.5 * (start.0 + end.0) - dy / length * by, 0.5 * (start.1 + end.1) + dx / length * by);
        (0..=24)
            .map(|step| {
                let t = f64::from(step) / 24.0;
                let (a, b, c) = ((1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t);
                (a * start.0 + b * control.0 + c * end.0, a * start.1 + b * control.1 + c * end.1)
            })
            .collect()
    };
    let others: Vec<&Boxed> =
        boxes.iter().enumerate().filter(|(node, _)| *node != from && *node != to).map(|(_, own)| own).collect();
    let is_inside = |points: &[(f64, f64)]| {
        let within = |at: f64, whole: f64| at >= RIM && at <= whole - RIM;
        points.iter().all(|at| within(at.0, frame.0) && within(at.1, frame.1))
    };
    let is_free = |points: &[(f64, f64)]| {
        points.windows(2).all(|pair| !others.iter().any(|own| crosses(&(pair[0], pair[1]), own)))
    };
    let is_joined = diagram.paths.iter().any(|path| {
        !diagram.adopted.contains(&path.0) && ((path.2, path.3) == (from, to) || (path.3, path.2) == (from, to))
    });
    let straight = if is_joined { None } else { Some(0.0) };
    let bends = straight.into_iter().chain([110.0, -110.0, 220.0, -220.0, 330.0, -330.0, 0.0]);
    bends.map(bent).find(|points| is_inside(points) && is_free(points)).unwrap_or_else(|| vec![start, end])
}

/// Sideways place of each path of the model, so that several between the same nodes lie beside one another, at most `most` from
/// the middle.
fn lanes(diagram: &Diagram, most: f64) -> Vec<f64> {
    let pair = |path: &(String, Path, usize, usize)| {
        (!diagram.adopted.contains(&path.0)).then(|| (path.2.min(path.3), path.2.max(path.3)))
    };
    let pairs: Vec<Option<(usize, usize)>> = diagram.paths.iter().map(pair).collect();
    let lane = |(position, path): (usize, &(String, Path, usize, usize))| {
        let all = pairs.iter().filter(|own| **own == pairs[position]).count() as f64;
        let before = pairs[..position].iter().filter(|own| **own == pairs[position]).count() as f64;
        let step = if all > 3.0 { 2.0 * most / (all - 1.0) } else { most };
        let lane = step * (before - 0.5 * (all - 1.0));
        // The normal turns with the direction of the path.
        if path.2 <= path.3 { lane } else { -lane }
    };
    diagram.paths.iter().enumerate().map(lane).collect()
}

fn shifted(from: (f64, f64), to: (f64, f64), lane: f64) -> Segment {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = (dx * dx + dy * dy).sqrt().max(1e-9);
    let (nx, ny) = (-dy / length * lane, dx / length * lane);
    ((from.0 + nx, from.1 + ny), (to.0 + nx, to.1 + ny))
}
