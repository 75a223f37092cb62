//! Horizontal bars with labels, values and intervals.

use super::axis::{Axis, Scale, range_of};
use super::canvas::{Anchor, Drawing, Lettering, TEXT, WIDTH, draw, fitted, text_width};
use super::palette::{Colour, GRID, INK, MUTED};
use super::sheet::Entry;

/// A bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// What it stands for.
    pub label: String,
    /// Where it begins; usually 0.
    pub from: f64,
    /// Where it ends; no number draws no bar, only the text.
    pub value: f64,
    /// Interval of the end.
    pub interval: Option<[f64; 2]>,
    /// What is written at its end.
    pub text: String,
    /// Colour.
    pub colour: Colour,
}

/// Draws the bars from above in the order given. `marker` is a labelled value across all bars.
pub fn bar_chart(axis: &Axis, bars: &[Bar], marker: Option<(f64, &str)>) -> Drawing {
    let row = 66.0;
    let top = if marker.is_some() { 70.0 } else { 24.0 };
    let height = top + row * bars.len().max(1) as f64 + 130.0;
    let widest = bars.iter().map(|b| text_width(&b.label, TEXT)).fold(0.0, f64::max).min(720.0);
    let left = widest + 34.0;
    let right = f64::from(WIDTH) - 40.0;
    let ends = bars.iter().map(|b| text_width(&b.text, TEXT)).fold(0.0, f64::max) + 24.0;
    let values = bars.iter().flat_map(|b| [b.from, b.value].into_iter().chain(b.interval.into_iter().flatten()));
    let (low, high) = axis.range.or_else(|| range_of(values.chain(marker.map(|m| m.0)))).unwrap_or((0.0, 1.0));
    let (low, high) = axis.within((low, high));
    // Room for the texts at the bars' ends.
    let share = (ends / (right - left)).min(0.6);
    let scale = Scale::new((low, high + (high - low) * share / (1.0 - share)), (left, right), 7);
    let bottom = top + row * bars.len().max(1) as f64;
    draw(height as u32, |canvas| {
        let title = &axis.title;
        canvas.columns(["bar", "from", title, "lower", "upper", "text"]);
        for (value, label) in scale.ticks().into_iter().filter(|tick| axis.most.is_none_or(|most| tick.0 <= most)) {
            let at = scale.at(value);
            canvas.path(&[(at, top), (at, bottom)], GRID, 2);
            canvas.text(&label, (at, bottom + 34.0), Lettering::new(TEXT, INK).at(Anchor::Middle));
        }
        if let Some((value, label)) = marker.filter(|m| scale.holds(m.0)) {
            let at = scale.at(value);
            canvas.dashed(&[(at, bottom), (at, top - 10.0)], MUTED, 4, 16.0, 10.0);
            let half = text_width(label, TEXT) / 2.0;
            let x = at.clamp(half + 4.0, (f64::from(WIDTH) - half - 4.0).max(half + 4.0));
            canvas.text(label, (x, top - 36.0), Lettering::new(TEXT, MUTED).at(Anchor::Middle));
            canvas.record([label.into(), Entry::Empty, value.into()]);
        }
        for (position, bar) in bars.iter().enumerate() {
            let middle = top + row * (position as f64 + 0.5);
            let label = fitted(&bar.label, TEXT, widest + 1.0);
            canvas.text(&label, (left - 16.0, middle), Lettering::new(TEXT, INK).at(Anchor::End));
            let mut end = scale.at(bar.from);
            if bar.value.is_finite() {
                canvas.fill((end, middle - 20.0), (scale.at(bar.value), middle + 20.0), bar.colour, 0.85);
                end = end.max(scale.at(bar.value));
            }
            if let Some([a, b]) = bar.interval.filter(|i| i[0].is_finite() && i[1].is_finite()) {
                let (a, b) = (scale.at(a), scale.at(b));
                canvas.path(&[(a, middle), (b, middle)], INK, 4);
                for x in [a, b] {
                    canvas.path(&[(x, middle - 10.0), (x, middle + 10.0)], INK, 4);
                }
                end = end.max(b);
            }
            let from = if bar.from == 0.0 { Entry::Empty } else { bar.from.into() };
            let [lower, upper] = bar.interval.unwrap_or([f64::NAN; 2]);
            let label = bar.label.as_str().into();
            let row =
                canvas.record([label, from, bar.value.into(), lower.into(), upper.into(), bar.text.as_str().into()]);
            canvas.seen(row, (end, middle));
            canvas.text_on_paper(&bar.text, (end + 16.0, middle), Lettering::new(TEXT, INK).bold());
        }
        canvas.path(&[(scale.at(0.0_f64.max(low)), top), (scale.at(0.0_f64.max(low)), bottom)], INK, 3);
        canvas.text(&axis.title, ((left + right) / 2.0, bottom + 90.0), Lettering::new(TEXT, INK).at(Anchor::Middle));
    })
}
