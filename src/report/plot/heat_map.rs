//! A map of numbers by row and column with diverging colours, their scale, and the numbers printed where they have room.

use super::canvas::{Anchor, Canvas, Drawing, Lettering, NARROW, SMALL, TEXT, WIDTH, draw_within, fitted, text_width};
use super::palette::{INK, MUTED, PAPER, diverging, is_light};
use super::sheet::Entry;
use crate::math::sort::sort_by;
use crate::report::number::{fixed, signed, significant};

/// What is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Rows: name, whether it is marked (held out), and a number a column.
    pub rows: Vec<(String, bool, Vec<Option<f64>>)>,
    /// Magnitude that gets the full colour; 0: the largest.
    pub full_scale: f64,
    /// Magnitude that should not be exceeded: marked on the scale, and cells beyond it have a frame.
    pub limit: Option<f64>,
    /// What the numbers are, with unit, and what the signs mean.
    pub legend: String,
    /// What the mark of a row means.
    pub mark_label: String,
    /// Decimals printed.
    pub decimals: usize,
    /// Numbers that are never below 0, printed without their sign.
    pub is_unsigned: bool,
    /// Whether it shares the width of the page with another picture.
    pub is_small: bool,
}

/// Rows above which they stand closer together.
const MANY_ROWS: usize = 24;
/// Smallest numbers that can be read where the picture has the width of a page.
const SMALLEST: f64 = 21.0;
/// Free on both sides of a number together.
pub const AROUND: f64 = 14.0;

/// Texts of a map's numbers.
pub fn text_of(map: &HeatMap, value: f64, decimals: usize) -> String {
    if map.is_unsigned { fixed(value, decimals) } else { signed(value, decimals) }
}

/// Decimals and size with which no number touches its neighbour; `None` where the cells are too small for any.
pub fn lettering(map: &HeatMap, width: f64, height: f64) -> Option<(usize, f64)> {
    (0..=map.decimals).rev().find_map(|decimals| {
        let numbers = map.rows.iter().flat_map(|row| &row.2).flatten();
        let widest = numbers.map(|&value| text_width(&text_of(map, value, decimals), 1.0)).fold(0.1, f64::max);
        let size = ((width - AROUND) / widest).min(SMALL).min(0.8 * height);
        // Whole numbers alone say little of small ones.
        let says_enough = decimals > 0 || map.decimals == 0 || map.full_scale >= 10.0;
        (size >= SMALLEST && says_enough).then_some((decimals, size))
    })
}

/// Draws the map. A missing number is a grey cell.
pub fn heat_map(map: &HeatMap) -> Drawing {
    let largest =
        map.rows.iter().flat_map(|r| &r.2).flatten().map(|v| v.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let full = if map.full_scale > 0.0 { map.full_scale } else { largest.max(1e-300) };
    let names =
        map.rows.iter().map(|r| text_width(&r.0, TEXT) + if r.1 { 34.0 } else { 0.0 }).fold(0.0, f64::max).min(520.0);
    let left = names + 30.0;
    let canvas_width = if map.is_small { NARROW } else { WIDTH };
    let right = f64::from(canvas_width) - 12.0;
    let columns = map.columns.len().max(1) as f64;
    let width = ((right - left) / columns).min(250.0);
    let right = left + width * columns;
    let longest = map.columns.iter().map(|c| text_width(c, TEXT)).fold(0.0, f64::max);
    let is_upright = longest > width - 10.0;
    let head = if is_upright { longest.min(300.0) + 20.0 } else { 56.0 };
    let row_height = match map.rows.len() {
        // Names that stand upright take their room from the rows.
        rows if map.is_small => ((392.0 - head) / rows.max(1) as f64).clamp(28.0, 50.0),
        rows if rows > MANY_ROWS => 38.0,
        _ => 50.0,
    };
    let top = 64.0 + head;
    let bottom = top + row_height * map.rows.len() as f64;
    let letters = lettering(map, width, row_height);
    let name_size = TEXT.min(0.85 * row_height);
    draw_within((canvas_width, (bottom + if map.is_small { 104.0 } else { 124.0 }) as u32), |canvas| {
        // What the signs mean stands behind a colon.
        let title = map.legend.split(':').next().unwrap_or_default();
        canvas.columns(["row", "column", title, "mark"]);
        let legend = fitted(&map.legend, TEXT, f64::from(canvas_width) - 20.0);
        canvas.text(&legend, (10.0, 30.0), Lettering::new(TEXT, INK));
        for (position, name) in map.columns.iter().enumerate() {
            let x = left + width * (position as f64 + 0.5);
            if is_upright {
                canvas.text(&fitted(name, TEXT, 300.0), (x, top - 12.0), Lettering::new(TEXT, INK).upwards());
            } else {
                canvas.text(name, (x, top - 28.0), Lettering::new(TEXT, INK).at(Anchor::Middle));
            }
        }
        for (number, (name, marked, values)) in map.rows.iter().enumerate() {
            let y = top + row_height * number as f64;
            let whole_name = name.as_str();
            let name = fitted(name, name_size, if *marked { names - 34.0 } else { names } + 1.0);
            canvas.text(&name, (left - 14.0, y + row_height / 2.0), Lettering::new(name_size, INK).at(Anchor::End));
            if *marked {
                canvas.circle((left - 32.0 - text_width(&name, name_size), y + row_height / 2.0), 8, MUTED, 4);
            }
            for position in 0..map.columns.len() {
                let x = left + width * position as f64;
                let value = values.get(position).copied().flatten();
                paint_cell(canvas, map, value, full, ((x, y), (x + width, y + row_height)), letters);
                let (column, mark) = (map.columns[position].as_str(), Entry::mark(&map.mark_label, *marked));
                let row = canvas.record([whole_name.into(), column.into(), value.unwrap_or(f64::NAN).into(), mark]);
                canvas.seen(row, (x + width / 2.0, y + row_height / 2.0));
            }
        }
        canvas.path(&[(left, bottom), (right, bottom)], INK, 2);
        paint_scale(canvas, map, full, left.min(if map.is_small { 60.0 } else { 200.0 }), bottom + 34.0);
    })
}

fn paint_cell(
    canvas: &mut Canvas<'_>,
    map: &HeatMap,
    value: Option<f64>,
    full: f64,
    (a, b): ((f64, f64), (f64, f64)),
    letters: Option<(usize, f64)>,
) {
    let colour = diverging(value.map_or(f64::NAN, |v| v / full));
    canvas.fill(a, b, colour, 1.0);
    canvas.outline(a, b, PAPER, 3);
    let ink = if is_light(colour) { INK } else { PAPER };
    if value.zip(map.limit).is_some_and(|(value, limit)| value.abs() > limit) {
        canvas.outline((a.0 + 5.0, a.1 + 5.0), (b.0 - 5.0, b.1 - 5.0), ink, 2);
    }
    let middle = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
    match (value, letters) {
        (Some(value), Some((decimals, size))) => {
            canvas.text(&text_of(map, value, decimals), middle, Lettering::new(size, ink).at(Anchor::Middle));
        }
        (None, _) => canvas.text("\u{2014}", middle, Lettering::new(SMALL.min(b.1 - a.1), ink).at(Anchor::Middle)),
        (Some(_), None) => {}
    }
}

/// The colours with their numbers and the limit, then what the mark of a row and the frame of a cell mean.
fn paint_scale(canvas: &mut Canvas<'_>, map: &HeatMap, full: f64, left: f64, y: f64) {
    const STEPS: usize = 40;
    let (width, height) = (if map.is_small { 380.0 } else { 620.0 }, 26.0);
    let low = if map.is_unsigned { 0.0 } else { -1.0 };
    let place = |share: f64| left + width * (share - low) / (1.0 - low);
    for step in 0..STEPS {
        let share = |at: usize| low + (1.0 - low) * at as f64 / STEPS as f64;
        let middle = 0.5 * (share(step) + share(step + 1));
        // A pixel over the next: no seam shows.
        canvas.fill((place(share(step)), y), (place(share(step + 1)) + 1.0, y + height), diverging(middle), 1.0);
    }
    canvas.outline((left, y), (left + width, y + height), MUTED, 2);
    let limit = map.limit.filter(|limit| *limit < full);
    let mut ticks = vec![low, 0.0, 1.0];
    ticks.extend(limit.iter().flat_map(|limit| [-limit / full, limit / full]).filter(|share| *share > low));
    sort_by(&mut ticks, f64::total_cmp);
    ticks.dedup();
    let mut written = f64::NEG_INFINITY;
    for share in ticks {
        let is_limit = limit.is_some_and(|limit| share.abs() == limit / full);
        let reach = if is_limit { 10.0 } else { 0.0 };
        canvas.path(&[(place(share), y - reach), (place(share), y + height + 6.0)], INK, if is_limit { 5 } else { 2 });
        let number = significant(share * full, 2);
        let text = if share > 0.0 && !map.is_unsigned { format!("+{number}") } else { number };
        // A number that would cover the one before it is left out; the line stands.
        let half = 0.5 * text_width(&text, SMALL);
        if place(share) - half > written {
            canvas.text(&text, (place(share), y + height + 26.0), Lettering::new(SMALL, INK).at(Anchor::Middle));
            written = place(share) + half + 6.0;
        }
    }
    let (apart, from_text) = if map.is_small { (44.0, 26.0) } else { (70.0, 40.0) };
    let mut x = left + width + apart;
    let middle = y + height / 2.0;
    if map.rows.iter().any(|row| row.1) {
        canvas.circle((x, middle), 8, MUTED, 4);
        canvas.text(&map.mark_label, (x + 20.0, middle), Lettering::new(SMALL, MUTED));
        x += 20.0 + text_width(&map.mark_label, SMALL) + from_text;
    }
    if map.limit.is_some() {
        canvas.outline((x, middle - 14.0), (x + 44.0, middle + 14.0), INK, 2);
        canvas.text("beyond the criterion", (x + 58.0, middle), Lettering::new(SMALL, MUTED));
    }
}
