//! Where the boxes of a network stand: those of the model first, as if nothing were adopted; nodes that adopted effects add
//! then find free places, so that a network looks the same from pass to pass. No box lies on another: where there is no room,
//! the field grows downwards, which moves no box that stands.

use super::room::{Boxed, RIM, Room};
use super::{Diagram, NodeShape};
use crate::math::sort::sort_by;
use crate::report::plot::layout::{positions, push_apart};

/// Distance of the places that are tried for a box, pixels.
const STEP: f64 = 18.0;
/// Area of the field over that of the boxes with their gaps, at least.
const SPARSE: f64 = 2.2;

/// The canvas and what is kept free on it, pixels.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Width.
    pub width: f64,
    /// Height, of a network that is not crowded.
    pub height: f64,
    /// Free at the left and the right, for what hangs on the outermost boxes.
    pub side: f64,
    /// Free above and below.
    pub rim: f64,
    /// Between two boxes.
    pub gap: f64,
}

/// Centres of the nodes' boxes of these sizes, in the order of the diagram, and the height of the field that holds them.
pub fn centres(diagram: &Diagram, sizes: &[(f64, f64)], field: &Field) -> (Vec<(f64, f64)>, f64) {
    let is_added = |node: &usize| diagram.nodes.get(*node).is_some_and(|own| diagram.adopted.contains(&own.0));
    let (added, own): (Vec<usize>, Vec<usize>) = (0..diagram.nodes.len()).partition(is_added);
    let place = |node: usize| own.iter().position(|other| *other == node);
    let modelled = diagram.paths.iter().filter(|path| !diagram.adopted.contains(&path.0));
    let links: Vec<(usize, usize)> = modelled.filter_map(|path| place(path.2).zip(place(path.3))).collect();
    let sinks: Vec<bool> = own.iter().map(|&node| diagram.nodes[node].1 == NodeShape::Boundary).collect();
    let of_own: Vec<(f64, f64)> = own.iter().map(|&node| sizes[node]).collect();
    let area: f64 = of_own.iter().map(|size| (size.0 + field.gap) * (size.1 + field.gap)).sum();
    let frame = (field.width, field.height.max(SPARSE * area / field.width));
    let mut wanted: Vec<(f64, f64)> = positions(own.len(), &links, &sinks)
        .into_iter()
        .map(|(x, y)| {
            let (width, height) = (frame.0 - 2.0 * field.side, frame.1 - 2.0 * field.rim);
            (field.side + x * width, field.rim + y * height)
        })
        .collect();
    push_apart(&mut wanted, &of_own, field.gap, frame);
    let mut room = Room { frame, ..Room::default() };
    let mut centres = vec![(field.width / 2.0, field.height / 2.0); diagram.nodes.len()];
    for (&node, &at) in own.iter().zip(&wanted) {
        let stands = room.is_free(&(at, sizes[node]));
        centres[node] = if stands { at } else { free(&mut room, at, sizes[node], field.gap / 3.0) };
        room.taken.push((centres[node], sizes[node]));
    }
    room.lines = links.iter().map(|&(from, to)| (centres[own[from]], centres[own[to]])).collect();
    let mut is_placed: Vec<bool> = (0..centres.len()).map(|node| place(node).is_some()).collect();
    for node in added {
        let other = |path: &(String, _, usize, usize)| match (path.2 == node, path.3 == node) {
            (true, false) => Some(path.3),
            (false, true) => Some(path.2),
            _ => None,
        };
        let joined: Vec<(f64, f64)> = (diagram.paths.iter())
            .filter_map(other)
            .filter(|other| is_placed.get(*other) == Some(&true))
            .map(|at| centres[at])
            .collect();
        let wanted = middle(&joined).unwrap_or(centres[node]);
        let at = free(&mut room, wanted, sizes[node], field.gap);
        centres[node] = at;
        is_placed[node] = true;
        room.taken.push((at, sizes[node]));
    }
    (centres, room.frame.1)
}

/// The mean of some points.
fn middle(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    (!points.is_empty()).then(|| (mean(|at| at.0), mean(|at| at.1)))
}

/// The place nearest to the wanted one where a box covers no other, and if possible no line, with a gap if possible; below all
/// others, where the frame then grows, if there is none.
pub(super) fn free(room: &mut Room, wanted: (f64, f64), size: (f64, f64), gap: f64) -> (f64, f64) {
    let steps = |size: f64, whole: f64| {
        let room = (whole - size - 2.0 * RIM).max(0.0);
        (0..=(room / STEP) as usize).map(move |step| RIM + 0.5 * size + step as f64 * STEP)
    };
    let rows: Vec<f64> = steps(size.1, room.frame.1).collect();
    let mut places: Vec<(f64, f64)> =
        steps(size.0, room.frame.0).flat_map(|x| rows.iter().map(move |&y| (x, y))).collect();
    let distance = |at: &(f64, f64)| {
        let (dx, dy) = (at.0 - wanted.0, at.1 - wanted.1);
        dx * dx + dy * dy
    };
    sort_by(&mut places, |a, b| distance(a).total_cmp(&distance(b)));
    let clear = |gap: f64| -> Vec<(f64, f64)> {
        let with = (size.0 + 2.0 * gap, size.1 + 2.0 * gap);
        let is_clear = |at: &(f64, f64)| {
            room.is_inside(&(*at, size)) && !room.taken.iter().any(|other| super::room::overlap(other, &(*at, with)))
        };
        places.iter().copied().filter(is_clear).collect()
    };
    let is_off_lines = |at: &&(f64, f64)| room.is_off_lines(&(**at, size));
    let (wide, narrow) = (clear(gap), clear(gap / 3.0));
    let found = (wide.iter().find(is_off_lines)).or_else(|| narrow.iter().find(is_off_lines)).or(narrow.first());
    if let Some(&at) = found {
        return at;
    }
    let low = room.taken.iter().map(|(centre, size): &Boxed| centre.1 + 0.5 * size.1).fold(RIM, f64::max);
    let at = (
        wanted.0.clamp(RIM + 0.5 * size.0, (room.frame.0 - RIM - 0.5 * size.0).max(RIM + 0.5 * size.0)),
        low + gap / 3.0 + 0.5 * size.1,
    );
    room.frame.1 = room.frame.1.max(at.1 + 0.5 * size.1 + RIM + gap / 3.0);
    at
}
