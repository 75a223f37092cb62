//! What lies where in a picture of a network, so that nothing lies on anything else or outside the frame.

use super::super::canvas::{fitted, text_width};

/// A rectangle by its centre and size.
pub type Boxed = ((f64, f64), (f64, f64));

/// A straight line between two points.
pub type Segment = ((f64, f64), (f64, f64));

/// Distance of everything from the frame, pixels; half a band is within it.
pub use crate::report::plot::layout::FREE as RIM;

/// Whether two rectangles share an area.
pub fn overlap(a: &Boxed, b: &Boxed) -> bool {
    (a.0.0 - b.0.0).abs() < 0.5 * (a.1.0 + b.1.0) && (a.0.1 - b.0.1).abs() < 0.5 * (a.1.1 + b.1.1)
}

/// Whether a line comes within 4 pixels of a rectangle (clipping of Liang and Barsky).
pub fn crosses(&(from, to): &Segment, &(centre, size): &Boxed) -> bool {
    let mut share = (0.0_f64, 1.0_f64);
    for (start, end, middle, whole) in [(from.0, to.0, centre.0, size.0), (from.1, to.1, centre.1, size.1)] {
        let (low, high) = (middle - 0.5 * whole - 4.0, middle + 0.5 * whole + 4.0);
        let along = end - start;
        if along.abs() < 1e-9 {
            if start <= low || start >= high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - start) / along, (high - start) / along);
        share = (share.0.max(a.min(b)), share.1.min(a.max(b)));
    }
    share.0 < share.1
}

/// The frame and what it holds.
#[derive(Clone, Debug, Default)]
pub(super) struct Room {
    /// Width and height, pixels.
    pub frame: (f64, f64),
    /// Boxes, labels and arrows.
    pub taken: Vec<Boxed>,
    /// Lines that a label had better not hide.
    pub lines: Vec<Segment>,
}

impl Room {
    /// Whether a rectangle lies in the frame.
    pub fn is_inside(&self, &(centre, size): &Boxed) -> bool {
        let within =
            |at: f64, size: f64, whole: f64| at - 0.5 * size > RIM - 1e-6 && at + 0.5 * size < whole - RIM + 1e-6;
        within(centre.0, size.0, self.frame.0) && within(centre.1, size.1, self.frame.1)
    }

    /// Whether a rectangle lies in the frame and on nothing else.
    pub fn is_free(&self, own: &Boxed) -> bool {
        self.is_inside(own) && !self.taken.iter().any(|other| overlap(other, own))
    }

    /// Whether a rectangle hides no line.
    pub fn is_off_lines(&self, own: &Boxed) -> bool {
        !self.lines.iter().any(|line| crosses(line, own))
    }
}

/// A text broken into lines of at most a width, at blanks where that is possible.
pub fn lines(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        let joined = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if text_width(&joined, size) <= width {
            line = joined;
            continue;
        }
        if !line.is_empty() {
            out.push(std::mem::take(&mut line));
        }
        for c in word.chars() {
            if !line.is_empty() && text_width(&line, size) + text_width(c.encode_utf8(&mut [0; 4]), size) > width {
                out.push(std::mem::take(&mut line));
            }
            line.push(c);
        }
    }
    if !line.is_empty() || out.is_empty() {
        out.push(line);
    }
    out
}

/// The same in at most some lines, with an ellipsis where something is left off.
pub(super) fn at_most(text: &str, size: f64, width: f64, most: usize) -> Vec<String> {
    let mut out = lines(text, size, width);
    if out.len() > most {
        out.truncate(most);
        if let Some(last) = out.last_mut() {
            *last = fitted(&format!("{last}\u{2026}\u{2026}"), size, width).replace("\u{2026}\u{2026}", "\u{2026}");
        }
    }
    out
}

/// Height of lines of text.
pub(super) fn height(count: usize, size: f64) -> f64 {
    count as f64 * 1.2 * size
}

/// The size of lines of text, with a rim.
pub(super) fn text_size(lines: &[String], size: f64) -> (f64, f64) {
    let width = lines.iter().map(|line| text_width(line, size)).fold(0.0, f64::max);
    (width + 16.0, height(lines.len(), size) + 0.1 * size)
}
