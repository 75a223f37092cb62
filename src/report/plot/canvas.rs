//! The surface on which plots are drawn: the only place that knows `plotters`, so that it can be replaced.
//!
//! Coordinates are pixels from the upper left corner. A coordinate that is no number draws nothing.

use plotters::backend::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};

use crate::document::visible::is_hidden;

use super::palette::Colour;
use super::sheet::{Entry, Numbers, Sheet};

/// Width of the canvas of a drawing that has the width of a page, pixels.
pub const WIDTH: u32 = 1600;
/// Width of the canvas of a drawing that shares the width of a page with another, pixels.
pub const NARROW: u32 = 1000;
/// Size of ordinary text, pixels of the canvas.
pub const TEXT: f64 = 34.0;
/// Size of small text, pixels of the canvas.
pub const SMALL: f64 = 29.0;

/// A finished drawing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawing {
    width: u32,
    height: u32,
    body: String,
    numbers: Numbers,
}

impl Drawing {
    /// Its width and height, pixels of the canvas.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The numbers that it shows.
    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// The drawing as an SVG element. `title` and `description` are what a screen reader says; `id` makes their
    /// names unique in a page. `standalone` adds what a file of its own needs.
    pub fn svg(&self, id: &str, title: &str, description: &str, standalone: bool) -> String {
        let (width, height) = (self.width, self.height);
        let (id, title, description) = (escape(id), escape(title), escape(description));
        let namespace =
            if standalone { " xmlns=\"http://www.w3.org/2000/svg\" width=\"960\"".to_owned() } else { String::new() };
        format!(
            "<svg{namespace} viewBox=\"0 0 {width} {height}\" role=\"img\" aria-labelledby=\"{id}-title {id}-desc\" \
             font-family=\"Inter, 'Segoe UI', 'Helvetica Neue', Arial, 'Liberation Sans', 'DejaVu Sans Condensed', sans-serif\">\n\
             <title id=\"{id}-title\">{title}</title>\n<desc id=\"{id}-desc\">{description}</desc>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#FFFFFF\"/>\n{}</svg>\n",
            self.body
        )
    }
}

/// Text as XML character data or an attribute's value; control characters, which XML forbids, are dropped.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if is_drawable(c) => out.push(c),
            _ => {}
        }
    }
    out
}

fn is_drawable(c: char) -> bool {
    !is_hidden(c) && c != '\u{FFFE}' && c != '\u{FFFF}'
}

/// Where a text stands from its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The point is at the text's start.
    Start,
    /// The point is at its middle.
    Middle,
    /// The point is at its end.
    End,
}

/// How a text looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lettering {
    /// Size, pixels.
    pub size: f64,
    /// Colour.
    pub colour: Colour,
    /// Where it stands; vertically the point is always the middle.
    pub anchor: Anchor,
    /// Bold.
    pub bold: bool,
    /// Reads upwards.
    pub upwards: bool,
}

impl Lettering {
    /// Text of a size and colour that starts at its point.
    pub fn new(size: f64, colour: Colour) -> Self {
        Self { size, colour, anchor: Anchor::Start, bold: false, upwards: false }
    }

    /// The same, anchored otherwise.
    pub fn at(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// The same, bold.
    pub fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// The same, reading upwards.
    pub fn upwards(self) -> Self {
        Self { upwards: true, ..self }
    }
}

/// Estimated width of a text, pixels: no font is read.
pub fn text_width(text: &str, size: f64) -> f64 {
    let units: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'l' | 'j' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | ' ' | '(' | ')' | '[' | ']' | 't' | 'f'
            | 'I' => 0.32,
            'm' | 'w' | 'M' | 'W' | '@' | '%' => 0.88,
            c if c.is_ascii_uppercase() => 0.68,
            c if c.is_ascii() => 0.56,
            c if (c as u32) < 0x2E80 => 0.6,
            _ => 1.0,
        })
        .sum();
    units * size
}

/// A text shortened to at most a width, with an ellipsis where something is left off.
pub fn fitted(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut out = String::new();
    for c in text.chars() {
        out.push(c);
        if text_width(&out, size) + 0.9 * size > width {
            out.pop();
            break;
        }
    }
    format!("{}\u{2026}", out.trim_end())
}

/// A canvas while it is drawn on.
pub struct Canvas<'a> {
    backend: SVGBackend<'a>,
    sheet: Sheet,
}

/// Draws on a new canvas of the standard width.
pub fn draw(height: u32, paint: impl FnOnce(&mut Canvas<'_>)) -> Drawing {
    draw_within((WIDTH, height), paint)
}

/// Draws on a new canvas of a width and height.
pub fn draw_within((width, height): (u32, u32), paint: impl FnOnce(&mut Canvas<'_>)) -> Drawing {
    let mut text = String::new();
    let mut canvas = Canvas { backend: SVGBackend::with_string(&mut text, (width, height)), sheet: Sheet::default() };
    paint(&mut canvas);
    // Writing to a string cannot fail.
    let _ = canvas.backend.present();
    let numbers = std::mem::take(&mut canvas.sheet).finish();
    drop(canvas);
    let start = text.find('>').map_or(0, |at| at + 1);
    let end = text.rfind("</svg>").unwrap_or(text.len());
    // A quote in a text is escaped, so these patterns are attributes and nothing else.
    let needless = [" font-family=\"sans-serif\"", " opacity=\"1\"", " stroke=\"none\" stroke-width=\"1\""];
    let body = needless.iter().fold(text[start..end].trim_start().to_owned(), |body, part| body.replace(part, ""));
    Drawing { width, height, body, numbers }
}

fn shape(colour: Colour, opacity: f64, width: u32) -> ShapeStyle {
    ShapeStyle { color: RGBColor(colour.0, colour.1, colour.2).mix(opacity), filled: true, stroke_width: width }
}

fn pixel((x, y): (f64, f64)) -> Option<(i32, i32)> {
    if x.is_nan() || y.is_nan() {
        return None;
    }
    let whole = |v: f64| v.clamp(-20_000.0, 20_000.0).round() as i32;
    Some((whole(x), whole(y)))
}

impl Canvas<'_> {
    /// Names the columns of the numbers that are drawn.
    pub(super) fn columns<T: Into<String>>(&mut self, columns: impl IntoIterator<Item = T>) {
        self.sheet.name(columns);
    }

    /// Records a row of the numbers that are drawn; gives its number.
    pub(super) fn record(&mut self, cells: impl IntoIterator<Item = Entry>) -> usize {
        self.sheet.row(cells)
    }

    /// Says where a recorded row is seen.
    pub(super) fn seen(&mut self, row: usize, at: (f64, f64)) {
        if let Some(at) = pixel(at) {
            self.sheet.place(at, row);
        }
    }

    /// A line through points; it breaks where a coordinate is no number.
    pub fn path(&mut self, points: &[(f64, f64)], colour: Colour, width: u32) {
        for piece in points.split(|p| pixel(*p).is_none()) {
            let thinned = thinned(piece);
            if thinned.len() > 1 {
                // Writing to a string cannot fail, here and below.
                let _ = self.backend.draw_path(thinned, &shape(colour, 1.0, width));
            }
        }
    }

    /// A dashed line through points.
    pub fn dashed(&mut self, points: &[(f64, f64)], colour: Colour, width: u32, dash: f64, gap: f64) {
        // Length left of the present dash (positive) or gap (negative).
        let mut left = dash;
        for pair in points.windows(2) {
            let ((mut x, mut y), (to_x, to_y)) = (pair[0], pair[1]);
            loop {
                let (dx, dy) = (to_x - x, to_y - y);
                let length = (dx * dx + dy * dy).sqrt();
                if !length.is_finite() || length < 1e-9 {
                    break;
                }
                let step = length.min(left.abs());
                let next = (x + dx * step / length, y + dy * step / length);
                if left > 0.0 {
                    self.path(&[(x, y), next], colour, width);
                }
                (x, y) = next;
                if step < left.abs() {
                    left -= step * left.signum();
                    break;
                }
                left = if left > 0.0 { -gap } else { dash };
            }
        }
    }

    /// A filled rectangle between two corners.
    pub fn fill(&mut self, corner: (f64, f64), opposite: (f64, f64), colour: Colour, opacity: f64) {
        let (Some(a), Some(b)) = (pixel(corner), pixel(opposite)) else { return };
        let (low, high) = ((a.0.min(b.0), a.1.min(b.1)), (a.0.max(b.0), a.1.max(b.1)));
        let _ = self.backend.draw_rect(low, high, &shape(colour, opacity, 1), true);
    }

    /// The outline of a rectangle.
    pub fn outline(&mut self, (x0, y0): (f64, f64), (x1, y1): (f64, f64), colour: Colour, width: u32) {
        self.path(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], colour, width);
    }

    /// A filled polygon.
    pub fn polygon(&mut self, points: &[(f64, f64)], colour: Colour, opacity: f64) {
        let points: Vec<_> = points.iter().filter_map(|&p| pixel(p)).collect();
        if points.len() > 2 {
            let _ = self.backend.fill_polygon(points, &shape(colour, opacity, 1));
        }
    }

    /// A disc.
    pub fn disc(&mut self, centre: (f64, f64), radius: u32, colour: Colour, opacity: f64) {
        if let Some(centre) = pixel(centre) {
            let _ = self.backend.draw_circle(centre, radius, &shape(colour, opacity, 1), true);
        }
    }

    /// A circle.
    pub fn circle(&mut self, centre: (f64, f64), radius: u32, colour: Colour, width: u32) {
        if let Some(centre) = pixel(centre) {
            let _ = self.backend.draw_circle(centre, radius, &shape(colour, 1.0, width), false);
        }
    }

    /// An arrow head at `tip`, coming from `from`.
    pub fn arrow_head(&mut self, from: (f64, f64), tip: (f64, f64), colour: Colour, size: f64) {
        let (dx, dy) = (tip.0 - from.0, tip.1 - from.1);
        let length = (dx * dx + dy * dy).sqrt();
        if length > 1e-9 {
            let (ux, uy) = (dx / length * size, dy / length * size);
            let base = (tip.0 - ux, tip.1 - uy);
            self.polygon(
                &[tip, (base.0 - 0.5 * uy, base.1 + 0.5 * ux), (base.0 + 0.5 * uy, base.1 - 0.5 * ux)],
                colour,
                1.0,
            );
        }
    }

    /// A text.
    pub fn text(&mut self, text: &str, at: (f64, f64), lettering: Lettering) {
        let Some(at) = pixel(at) else { return };
        let text: String = text.chars().filter(|&c| is_drawable(c)).collect();
        let h_pos = match lettering.anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let style = if lettering.bold { FontStyle::Bold } else { FontStyle::Normal };
        // The backend writes a font size of 1/1.24 of what it is given.
        let mut font = ("sans-serif", lettering.size * 1.24, style).into_font();
        if lettering.upwards {
            font = font.transform(FontTransform::Rotate270);
        }
        let colour = RGBColor(lettering.colour.0, lettering.colour.1, lettering.colour.2);
        let style = TextStyle::from(font).color(&colour).pos(Pos::new(h_pos, VPos::Center));
        let _ = self.backend.draw_text(&text, &style, at);
    }

    /// A text on a white ground, legible over lines.
    pub fn text_on_paper(&mut self, text: &str, at: (f64, f64), lettering: Lettering) {
        let width = text_width(text, lettering.size) + 8.0;
        let left = match lettering.anchor {
            Anchor::Start => at.0 - 4.0,
            Anchor::Middle => at.0 - width / 2.0,
            Anchor::End => at.0 + 4.0 - width,
        };
        let half = 0.6 * lettering.size;
        self.fill((left, at.1 - half), (left + width, at.1 + half), super::palette::PAPER, 0.86);
        self.text(text, at, lettering);
    }
}

/// Points above which a line is drawn from columns of [`COARSE`] pixels.
const DENSE: usize = 2000;
/// Width of such a column, pixels: as wide as a line.
const COARSE: i32 = 5;

/// Points in whole pixels; of a run in the same column only the first, lowest, highest and last are kept, which
/// draws the same line. Of a very long line the lowest and highest of each column are kept, where they come.
pub fn thinned(points: &[(f64, f64)]) -> Vec<(i32, i32)> {
    let is_dense = points.len() > DENSE;
    let column_of = |point: &(i32, i32)| if is_dense { point.0.div_euclid(COARSE) } else { point.0 };
    let mut out: Vec<(i32, i32)> = Vec::new();
    let mut column: Vec<(i32, i32)> = Vec::new();
    let mut flush = |column: &mut Vec<(i32, i32)>| {
        if column.len() <= if is_dense { 2 } else { 4 } {
            out.append(column);
            return;
        }
        let low = column.iter().enumerate().min_by_key(|(_, p)| p.1).map_or(0, |(at, _)| at);
        let high = column.iter().enumerate().max_by_key(|(_, p)| p.1).map_or(0, |(at, _)| at);
        let kept = if is_dense { vec![low.min(high), low.max(high)] } else { vec![0, low, high, column.len() - 1] };
        out.extend(kept.iter().filter_map(|&at| column.get(at)).copied());
        column.clear();
    };
    for point in points.iter().filter_map(|&p| pixel(p)) {
        if column.last().is_some_and(|last| column_of(last) != column_of(&point)) {
            flush(&mut column);
        }
        if column.last() != Some(&point) {
            column.push(point);
        }
    }
    flush(&mut column);
    out
}
