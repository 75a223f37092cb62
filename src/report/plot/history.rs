//! Measured against predicted over time, with the residual below.

use super::axis::Axis;
use super::canvas::{Drawing, NARROW, WIDTH, draw_within};
use super::chart::{Along, Area, Chart, Layer, Limit, Mark, Shade, Stroke};
use super::palette::{BLUE, INK, MUTED, VERMILION};
use super::sheet::Entry;

/// What is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    /// Title of the axis of time, or of the list of phases.
    pub x_title: String,
    /// Title of the quantity with unit.
    pub y_title: String,
    /// Title of the residual with unit.
    pub residual_title: String,
    /// Instant, measured, predicted; lines break where these are no numbers.
    pub points: Vec<(f64, f64, f64)>,
    /// Stretches held out.
    pub held_out: Vec<Shade>,
    /// Limit of the residual's magnitude, if any.
    pub limit: Option<f64>,
    /// Whether it shares the width of the page with another picture.
    pub is_small: bool,
}

/// Draws dots for the readings, a line for the prediction and the residual in a panel below.
pub fn history(data: &History) -> Drawing {
    let (width, height, middle) = if data.is_small { (NARROW, 640.0, 400.0) } else { (WIDTH, 1120.0, 705.0) };
    let upper = Chart {
        x: Axis::new(""),
        y: Axis::new(data.y_title.clone()),
        layers: vec![
            Layer::Dots {
                points: data.points.iter().map(|p| (p.0, p.1)).collect(),
                colour: MUTED,
                mark: if data.points.len() > 200 { Mark::Disc } else { Mark::Ring },
                label: "measured".into(),
            },
            Layer::Line {
                points: data.points.iter().map(|p| (p.0, p.2)).collect(),
                colour: BLUE,
                stroke: Stroke::Solid,
                label: "predicted".into(),
            },
        ],
        shades: data.held_out.clone(),
        shade_label: "held out".into(),
        ..Chart::default()
    };
    let mut limits = vec![Limit { along: Along::Y, value: 0.0, label: String::new(), colour: INK }];
    if let Some(limit) = data.limit {
        limits.extend([limit, -limit].map(|value| Limit {
            along: Along::Y,
            value,
            label: String::new(),
            colour: VERMILION,
        }));
    }
    let residuals = data.points.iter().map(|p| (p.0, p.1 - p.2)).collect();
    let lower = Chart {
        x: Axis::new(data.x_title.clone()),
        y: Axis::new(data.residual_title.clone()),
        layers: vec![Layer::Line { points: residuals, colour: VERMILION, stroke: Stroke::Solid, label: String::new() }],
        shades: data.held_out.clone(),
        limits,
        ..Chart::default()
    };
    draw_within((width, height as u32), |canvas| {
        let right = f64::from(width);
        let frame = upper.paint(canvas, Area { left: 0.0, top: 0.0, right, bottom: middle + 25.0 }, Some(190.0), false);
        lower.paint(canvas, Area { left: 0.0, top: middle - 25.0, right, bottom: height }, Some(190.0), true);
        let predicted = format!("predicted {}", data.y_title);
        canvas.columns(
            [&data.x_title, &format!("measured {}", data.y_title), &predicted, &data.residual_title, "held out"]
                .map(String::from),
        );
        for &(x, measured, predicted) in data.points.iter().filter(|point| point.0.is_finite()) {
            let held_out = Entry::mark("held out", data.held_out.iter().any(|shade| shade.holds(x)));
            let residual = (measured - predicted).into();
            let row = canvas.record([x.into(), measured.into(), predicted.into(), residual, held_out]);
            canvas.seen(row, frame.at((x, measured)));
        }
    })
}
