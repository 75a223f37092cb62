//! Where the boxes of a network stand: those of the model first, as if nothing were adopted; nodes that adopted effects add
//! then find free places, so that a network looks the same from pass to pass.

use super::{Boxed, Diagram, NodeShape, Segment, crosses, overlap};
use crate::report::plot::layout::{positions, push_apart};

/// Distance of the places that are tried for an added node, pixels.
const STEP: f64 = 18.0;
/// Distance from the canvas's rim, pixels.
const RIM: f64 = 8.0;

/// The canvas and what is kept free on it, pixels.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
    /// Free at the left and the right, for what hangs on the outermost boxes.
    pub side: f64,
    /// Free above and below.
    pub rim: f64,
    /// Between two boxes.
    pub gap: f64,
}

/// Centres of the nodes' boxes of these sizes, in the order of the diagram.
pub fn centres(diagram: &Diagram, sizes: &[(f64, f64)], field: &Field) -> Vec<(f64, f64)> {
    let is_added = |node: &usize| diagram.nodes.get(*node).is_some_and(|own| diagram.adopted.contains(&own.0));
    let (added, own): (Vec<usize>, Vec<usize>) = (0..diagram.nodes.len()).partition(is_added);
    let place = |node: usize| own.iter().position(|other| *other == node);
    let modelled = diagram.paths.iter().filter(|path| !diagram.adopted.contains(&path.0));
    let links: Vec<(usize, usize)> = modelled.filter_map(|path| place(path.2).zip(place(path.3))).collect();
    let sinks: Vec<bool> = own.iter().map(|&node| diagram.nodes[node].1 == NodeShape::Boundary).collect();
    let of_own: Vec<(f64, f64)> = own.iter().map(|&node| sizes[node]).collect();
    let mut found: Vec<(f64, f64)> = positions(own.len(), &links, &sinks)
        .into_iter()
        .map(|(x, y)| {
            let (width, height) = (field.width - 2.0 * field.side, field.height - 2.0 * field.rim);
            (field.side + x * width, field.rim + y * height)
        })
        .collect();
    push_apart(&mut found, &of_own, field.gap, (field.width, field.height));
    let mut taken: Vec<Boxed> = found.iter().copied().zip(of_own).collect();
    let mut centres = vec![(field.width / 2.0, field.height / 2.0); diagram.nodes.len()];
    own.iter().zip(&found).for_each(|(&node, &centre)| centres[node] = centre);
    let lines: Vec<Segment> = links.iter().map(|&(from, to)| (found[from], found[to])).collect();
    let mut is_placed: Vec<bool> = (0..centres.len()).map(|node| place(node).is_some()).collect();
    for node in added {
        let other = |path: &(String, _, usize, usize)| match (path.2 == node, path.3 == node) {
            (true, false) => Some(path.3),
            (false, true) => Some(path.2),
            _ => None,
        };
        let joined: Vec<(f64, f64)> =
            diagram.paths.iter().filter_map(other).filter(|other| is_placed[*other]).map(|at| centres[at]).collect();
        let count = joined.len() as f64;
        let wanted = match joined.as_slice() {
            [] => centres[node],
            several => {
                (several.iter().map(|at| at.0).sum::<f64>() / count, several.iter().map(|at| at.1).sum::<f64>() / count)
            }
        };
        let at = free(wanted, sizes[node], &taken, &lines, field);
        centres[node] = at;
        is_placed[node] = true;
        taken.push((at, sizes[node]));
    }
    centres
}

/// The place nearest to the wanted one where a box covers no other, and if possible no line; the emptiest where all is taken.
fn free(wanted: (f64, f64), size: (f64, f64), taken: &[Boxed], lines: &[Segment], field: &Field) -> (f64, f64) {
    let (half_x, half_y) = (size.0 / 2.0 + RIM, size.1 / 2.0 + RIM);
    let steps = |half: f64, whole: f64| {
        let room = (whole - 2.0 * half).max(0.0);
        let count = (room / STEP) as usize;
        (0..=count).map(move |step| half + (step as f64 * STEP).min(room))
    };
    let rows: Vec<f64> = steps(half_y, field.height).collect();
    let mut places: Vec<(f64, f64)> =
        steps(half_x, field.width).flat_map(|x| rows.iter().map(move |&y| (x, y))).collect();
    let distance = |at: &(f64, f64)| {
        let (dx, dy) = (at.0 - wanted.0, at.1 - wanted.1);
        dx * dx + dy * dy
    };
    places.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let with = |gap: f64| (size.0 + 2.0 * gap, size.1 + 2.0 * gap);
    let is_clear = |at: &&(f64, f64), gap: f64| !taken.iter().any(|other| overlap(other, &(**at, with(gap))));
    let is_off_lines = |at: &&(f64, f64)| !lines.iter().any(|line| crosses(line, &(**at, size)));
    let found = (places.iter().find(|at| is_clear(at, field.gap) && is_off_lines(at)))
        .or_else(|| places.iter().find(|at| is_clear(at, field.gap / 3.0) && is_off_lines(at)))
        .or_else(|| places.iter().find(|at| is_clear(at, field.gap / 3.0)))
        .or_else(|| places.iter().find(|at| is_clear(at, 0.0)));
    found.copied().unwrap_or_else(|| {
        let covered = |at: &(f64, f64)| {
            let shared = |(centre, own): &Boxed| {
                let x = 0.5 * (own.0 + size.0) - (centre.0 - at.0).abs();
                let y = 0.5 * (own.1 + size.1) - (centre.1 - at.1).abs();
                x.max(0.0) * y.max(0.0)
            };
            taken.iter().map(shared).sum::<f64>()
        };
        places.iter().min_by(|a, b| covered(a).total_cmp(&covered(b))).copied().unwrap_or(wanted)
    })
}
