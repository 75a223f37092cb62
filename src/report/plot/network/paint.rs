//! How the marks of a network are painted.

use super::super::canvas::{Anchor, Canvas, Lettering, SMALL, text_width};
use super::super::palette::{AMBER, BLUE, Colour, GREEN, INK, PAPER, is_light};
use super::arrangement::Label;
use super::room::{Boxed, Segment, height};
use super::{BAND, NUMBER, NodeShape, Path, Source, colour_of};

/// A band round a box.
pub(super) fn band_round(canvas: &mut Canvas<'_>, (centre, shape): Boxed) {
    let half = (shape.0 / 2.0 + 12.0, shape.1 / 2.0 + 12.0);
    canvas.fill((centre.0 - half.0, centre.1 - half.1), (centre.0 + half.0, centre.1 + half.1), BAND, 1.0);
}

/// A path of the model.
pub(super) fn paint_path(canvas: &mut Canvas<'_>, path: Path, from: (f64, f64), to: (f64, f64)) {
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
pub(super) fn paint_node(
    canvas: &mut Canvas<'_>,
    (name, number): (&[String], &str),
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
    write(canvas, name, middle, Lettering::new(size, ink).bold().at(Anchor::Middle));
    let end = (centre.0 + shape.0 / 2.0 - 0.35 * size, centre.1);
    canvas.text(number, end, Lettering::new(NUMBER * size, ink).at(Anchor::End));
}

/// Lines of text round a point.
fn write(canvas: &mut Canvas<'_>, lines: &[String], at: (f64, f64), lettering: Lettering) {
    let step = height(1, lettering.size);
    let top = at.1 - 0.5 * step * (lines.len() as f64 - 1.0);
    for (number, line) in lines.iter().enumerate() {
        canvas.text(line, (at.0, top + step * number as f64), lettering);
    }
}

/// A name, or the number under which it stands below the picture.
pub(super) fn paint_label(canvas: &mut Canvas<'_>, label: &Label) {
    let (centre, (width, height)) = label.area;
    let (a, b) = ((centre.0 - width / 2.0, centre.1 - height / 2.0), (centre.0 + width / 2.0, centre.1 + height / 2.0));
    let lettering = Lettering::new(SMALL, label.colour).at(Anchor::Middle);
    canvas.fill(a, b, PAPER, if label.is_number { 1.0 } else { 0.86 });
    if label.is_number {
        canvas.outline(a, b, label.colour, 3);
    }
    write(canvas, &label.lines, centre, if label.is_bold { lettering.bold() } else { lettering });
}

/// The arrow of a source from its tail to its tip.
pub(super) fn paint_arrow(canvas: &mut Canvas<'_>, source: Source, is_adopted: bool, (tail, tip): Segment) {
    let colour = source_colour(source);
    if is_adopted {
        canvas.path(&[tail, tip], BAND, 24);
    }
    canvas.path(&[tail, tip], colour, 6);
    canvas.arrow_head(tail, tip, colour, 28.0);
}

/// The colour of a source and its name.
pub(super) fn source_colour(source: Source) -> Colour {
    if source == Source::Load { GREEN } else { AMBER }
}
