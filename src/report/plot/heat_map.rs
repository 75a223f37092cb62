//! A map of numbers by row and column with diverging colours and the numbers printed.

use super::canvas::{Anchor, Drawing, Lettering, SMALL, TEXT, WIDTH, draw, fitted, text_width};
use super::palette::{INK, MUTED, PAPER, diverging, is_light};
use crate::report::number::{fixed, signed};

/// What is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Rows: name, whether it is marked (held out), and a number a column.
    pub rows: Vec<(String, bool, Vec<Option<f64>>)>,
    /// Magnitude that gets the full colour; 0: the largest.
    pub full_scale: f64,
    /// What the numbers are, with unit, and what the signs mean.
    pub legend: String,
    /// What the mark of a row means.
    pub mark_label: String,
    /// Decimals printed.
    pub decimals: usize,
    /// Numbers that are never below 0, printed without their sign.
    pub is_unsigned: bool,
}

/// Draws the map. A missing number is a grey cell.
pub fn heat_map(map: &HeatMap) -> Drawing {
    let largest =
        map.rows.iter().flat_map(|r| &r.2).flatten().map(|v| v.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let full = if map.full_scale > 0.0 { map.full_scale } else { largest.max(1e-300) };
    let names =
        map.rows.iter().map(|r| text_width(&r.0, TEXT) + if r.1 { 34.0 } else { 0.0 }).fold(0.0, f64::max).min(520.0);
    let left = names + 30.0;
    let right = f64::from(WIDTH) - 12.0;
    let columns = map.columns.len().max(1) as f64;
    let width = ((right - left) / columns).min(250.0);
    let right = left + width * columns;
    let longest = map.columns.iter().map(|c| text_width(c, TEXT)).fold(0.0, f64::max);
    let is_upright = longest > width - 10.0;
    let head = if is_upright { longest.min(300.0) + 20.0 } else { 56.0 };
    let row_height = 50.0;
    let top = 64.0 + head;
    let bottom = top + row_height * map.rows.len() as f64;
    let has_marks = map.rows.iter().any(|r| r.1);
    let height = bottom + if has_marks { 70.0 } else { 16.0 };
    let size = if width < 74.0 { (width / 74.0 * SMALL).max(18.0) } else { SMALL };
    draw(height as u32, |canvas| {
        canvas.text(&fitted(&map.legend, TEXT, f64::from(WIDTH) - 20.0), (10.0, 30.0), Lettering::new(TEXT, INK));
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
            let name = fitted(name, TEXT, if *marked { names - 34.0 } else { names } + 1.0);
            canvas.text(&name, (left - 14.0, y + row_height / 2.0), Lettering::new(TEXT, INK).at(Anchor::End));
            if *marked {
                canvas.circle((left - 32.0 - text_width(&name, TEXT), y + row_height / 2.0), 8, MUTED, 4);
            }
            for position in 0..map.columns.len() {
                let x = left + width * position as f64;
                let value = values.get(position).copied().flatten();
                let colour = diverging(value.map_or(f64::NAN, |v| v / full));
                canvas.fill((x, y), (x + width, y + row_height), colour, 1.0);
                canvas.outline((x, y), (x + width, y + row_height), PAPER, 3);
                let ink = if is_light(colour) { INK } else { PAPER };
                let text = value.map_or_else(
                    || "\u{2014}".to_owned(),
                    |v| {
                        if map.is_unsigned { fixed(v, map.decimals) } else { signed(v, map.decimals) }
                    },
                );
                canvas.text(
                    &text,
                    (x + width / 2.0, y + row_height / 2.0),
                    Lettering::new(size, ink).at(Anchor::Middle),
                );
            }
        }
        canvas.path(&[(left, bottom), (right, bottom)], INK, 2);
        if has_marks {
            canvas.circle((left + 8.0, bottom + 38.0), 8, MUTED, 4);
            canvas.text(&map.mark_label, (left + 28.0, bottom + 38.0), Lettering::new(SMALL, MUTED));
        }
    })
}
