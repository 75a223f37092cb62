//! Draws of several unknowns against one another: small multiples, a histogram of each on the diagonal and clouds of
//! points below it.

use super::axis::{Scale, range_of, widened};
use super::canvas::{Anchor, Drawing, Lettering, SMALL, TEXT, WIDTH, draw, fitted};
use super::palette::{BLUE, INK, MUTED, SKY, VERMILION};

/// Points of all clouds together, and most of one.
const POINTS: (usize, usize) = (1800, 300);
/// Bins of a histogram.
const BINS: usize = 16;

/// An unknown of the plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairAxis {
    /// Name with unit.
    pub title: String,
    /// Draws; those of all unknowns stand in the same order.
    pub draws: Vec<f64>,
    /// A value to mark.
    pub marked: Option<f64>,
}

/// Draws the plot; clouds have an even choice of the draws. Ticks stand at the left of the lowest row's clouds and under every column.
pub fn pairs(unknowns: &[PairAxis]) -> Drawing {
    let count = unknowns.len().max(1);
    let most = (POINTS.0 / (count * (count - 1) / 2).max(1)).min(POINTS.1);
    let every = unknowns.first().map_or(1, |unknown| unknown.draws.len().div_ceil(most)).max(1);
    let (left, top, gap, foot) = (150.0, 10.0, 22.0, 110.0);
    let cell = (f64::from(WIDTH) - left - 12.0 - gap * (count - 1) as f64) / count as f64;
    // Few unknowns need no square cells as large as the page.
    let tall = cell.min(420.0);
    let height = top + count as f64 * tall + (count - 1) as f64 * gap + foot;
    let corner = |row: usize, column: usize| (left + column as f64 * (cell + gap), top + row as f64 * (tall + gap));
    let ranges: Vec<(f64, f64)> = unknowns
        .iter()
        .map(|unknown| {
            let values = unknown.draws.iter().copied().chain(unknown.marked).filter(|value| value.is_finite());
            widened(range_of(values).unwrap_or((0.0, 1.0)), 0.04)
        })
        .collect();
    draw(height as u32, |canvas| {
        canvas.columns(unknowns.iter().map(|unknown| unknown.title.as_str()));
        for draw in 0..unknowns.iter().map(|unknown| unknown.draws.len()).max().unwrap_or(0) {
            canvas.record(unknowns.iter().map(|unknown| unknown.draws.get(draw).copied().unwrap_or(f64::NAN).into()));
        }
        for (row, vertical) in unknowns.iter().enumerate() {
            for (column, horizontal) in unknowns.iter().enumerate().take(row + 1) {
                let (x0, y0) = corner(row, column);
                let (x1, y1) = (x0 + cell, y0 + tall);
                let across = Scale::new(ranges[column], (x0, x1), 3);
                if row == column {
                    let mut bins = [0_u32; BINS];
                    for &value in horizontal.draws.iter().filter(|value| value.is_finite()) {
                        let share = (across.at(value) - x0) / cell;
                        bins[((share * BINS as f64) as usize).min(BINS - 1)] += 1;
                    }
                    let most = f64::from(bins.iter().copied().max().unwrap_or(0).max(1));
                    // Room for the name above the bars.
                    let room = tall - 1.6 * TEXT;
                    for (bin, &number) in bins.iter().enumerate() {
                        let from = x0 + cell * bin as f64 / BINS as f64;
                        let to = x0 + cell * (bin + 1) as f64 / BINS as f64;
                        canvas.fill((from, y1 - room * f64::from(number) / most), (to, y1), SKY, 0.6);
                    }
                    let title = fitted(&horizontal.title, TEXT, cell - 8.0);
                    canvas.text(
                        &title,
                        (0.5 * (x0 + x1), y0 + 0.7 * TEXT),
                        Lettering::new(TEXT, INK).at(Anchor::Middle),
                    );
                } else {
                    let along = Scale::new(ranges[row], (y1, y0), 3);
                    for (draw, (&x, &y)) in horizontal.draws.iter().zip(&vertical.draws).enumerate().step_by(every) {
                        canvas.disc((across.at(x), along.at(y)), 4, BLUE, 0.35);
                        canvas.seen(draw, (across.at(x), along.at(y)));
                    }
                    if let (Some(x), Some(y)) = (horizontal.marked, vertical.marked) {
                        let (x, y) = (across.at(x), along.at(y));
                        canvas.path(&[(x - 14.0, y), (x + 14.0, y)], VERMILION, 5);
                        canvas.path(&[(x, y - 14.0), (x, y + 14.0)], VERMILION, 5);
                    }
                    if column == 0 {
                        for (value, label) in along.ticks() {
                            let at = (x0 - 10.0, along.at(value));
                            canvas.path(&[(x0 - 6.0, at.1), (x0, at.1)], MUTED, 2);
                            let label = fitted(&label, SMALL, left - 14.0);
                            canvas.text(&label, at, Lettering::new(SMALL, MUTED).at(Anchor::End));
                        }
                    }
                }
                canvas.outline((x0, y0), (x1, y1), MUTED, 2);
                if row + 1 == count {
                    for (value, label) in across.ticks() {
                        let x = across.at(value);
                        canvas.path(&[(x, y1), (x, y1 + 6.0)], MUTED, 2);
                        canvas.text(&label, (x, y1 + 28.0), Lettering::new(SMALL, MUTED).at(Anchor::Middle));
                    }
                    let title = fitted(&horizontal.title, TEXT, cell);
                    canvas.text(&title, (0.5 * (x0 + x1), y1 + 76.0), Lettering::new(TEXT, INK).at(Anchor::Middle));
                }
            }
        }
    })
}
