//! Residuals over time, a strip for each sensor on one scale.

use super::axis::Axis;
use super::canvas::{Drawing, Lettering, TEXT, WIDTH, draw, fitted};
use super::chart::{Along, Area, Chart, Layer, Limit, Shade, Stroke};
use super::palette::{INK, series};
use super::sheet::Entry;

/// A sensor's residuals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strip {
    /// Sensor.
    pub label: String,
    /// Instant and residual.
    pub points: Vec<(f64, f64)>,
}

/// Draws the strips below one another with a common scale; `held_out` is shaded.
pub fn residual_strips(x_title: &str, y_title: &str, strips: &[Strip], held_out: &[Shade]) -> Drawing {
    let largest =
        strips.iter().flat_map(|s| &s.points).map(|p| p.1.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let largest = if largest > 0.0 { 1.1 * largest } else { 1.0 };
    let extent = super::axis::range_of(strips.iter().flat_map(|s| &s.points).map(|p| p.0)).unwrap_or((0.0, 1.0));
    let each = 270.0;
    let height = each * strips.len().max(1) as f64 + 110.0;
    draw(height as u32, |canvas| {
        canvas.columns(["sensor", x_title, y_title, "held out"]);
        for (position, strip) in strips.iter().enumerate() {
            let top = each * position as f64;
            let lowest = position + 1 == strips.len();
            let chart = Chart {
                x: Axis::over(x_title, extent.0, extent.1),
                y: Axis::over(y_title, -largest, largest),
                layers: vec![Layer::Line {
                    points: strip.points.clone(),
                    colour: series(position),
                    stroke: Stroke::Solid,
                    label: String::new(),
                }],
                limits: vec![Limit { along: Along::Y, value: 0.0, label: String::new(), colour: INK }],
                shades: held_out.to_vec(),
                ..Chart::default()
            };
            let bottom = top + each + if lowest { 110.0 } else { 46.0 };
            let frame = chart.paint(
                canvas,
                Area { left: 0.0, top: top + 34.0, right: f64::from(WIDTH), bottom },
                Some(190.0),
                lowest,
            );
            let name = fitted(&strip.label, TEXT, 1200.0);
            canvas.text(&name, (190.0, top + 44.0), Lettering::new(TEXT, series(position)).bold());
            for &(x, y) in &strip.points {
                let mark = Entry::mark("held out", held_out.iter().any(|shade| shade.holds(x)));
                let row = canvas.record([strip.label.as_str().into(), x.into(), y.into(), mark]);
                canvas.seen(row, frame.at((x, y)));
            }
        }
    })
}
