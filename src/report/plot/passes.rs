//! Error by pass: the first model untuned and tuned, and what each pass made of it.

use super::axis::Axis;
use super::canvas::{Drawing, WIDTH, draw};
use super::chart::{Area, Chart, Layer, Mark, Stroke, chart_columns};
use super::palette::{BLUE, Colour, GREEN, VERMILION};

/// The first pass untuned, the first pass tuned, and each pass tuned; in order of the passes.
pub type Errors = (Option<f64>, Option<f64>, Vec<Option<f64>>);

/// What is drawn. Errors are in kelvin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassCurves {
    /// Names of the passes.
    pub passes: Vec<String>,
    /// Which pass builds upon which: positions of the earlier and of the later.
    pub steps: Vec<(usize, usize)>,
    /// Errors on the readings held out.
    pub held_out: Errors,
    /// Errors on those for fitting.
    pub train: Errors,
    /// What the first pass's states are, untuned and tuned.
    pub first_labels: [String; 2],
    /// Label of the third curve.
    pub tuned_label: String,
}

/// Draws a panel for the readings held out and one below for those for fitting; what has no errors is left out.
pub fn pass_curves(data: &PassCurves) -> Drawing {
    let panels = [("RMSE held-out [K]", &data.held_out), ("RMSE for fitting [K]", &data.train)];
    let panels: Vec<_> = panels.into_iter().filter(|(_, errors)| largest(errors) > 0.0).collect();
    let each = 620.0;
    let height = each * panels.len().max(1) as f64 + 60.0;
    draw(height as u32, |canvas| {
        canvas.columns(chart_columns("pass", "RMSE [K]"));
        for (position, (title, errors)) in panels.iter().enumerate() {
            let lowest = position + 1 == panels.len();
            let top = each * position as f64;
            let bottom = top + each + if lowest { 60.0 } else { 0.0 };
            let area = Area { left: 0.0, top, right: f64::from(WIDTH), bottom };
            let own = chart(data, title, errors, position == 0);
            let frame = own.paint(canvas, area, Some(190.0), lowest);
            chart(data, title, errors, true).record(canvas, &frame, title);
        }
    })
}

fn largest((delivered, tuned, each): &Errors) -> f64 {
    let values = delivered.iter().chain(tuned).chain(each.iter().flatten());
    values.copied().filter(|value| value.is_finite()).fold(0.0, f64::max)
}

fn chart(data: &PassCurves, title: &str, errors: &Errors, has_key: bool) -> Chart {
    let label = |text: &str| if has_key { text.to_owned() } else { String::new() };
    let count = data.passes.len() as f64;
    let mut layers = Vec::new();
    let mut level = |value: Option<f64>, colour: Colour, stroke: Stroke, text: &str| {
        layers.extend(value.map(|value| Layer::Line {
            points: vec![(0.5, value), (count + 0.5, value)],
            colour,
            stroke,
            label: label(text),
        }));
    };
    let first = data.passes.first().map_or("", String::as_str);
    let [untuned, tuned] = &data.first_labels;
    level(errors.0, VERMILION, Stroke::Solid, &format!("{untuned} ({first})"));
    level(errors.1, BLUE, Stroke::Dashed, &format!("{tuned} ({first})"));
    let place = |pass: usize| Some((pass as f64 + 1.0, *errors.2.get(pass)?.as_ref()?));
    for &(from, to) in &data.steps {
        if let (Some(from), Some(to)) = (place(from), place(to)) {
            let points = vec![from, to];
            layers.push(Layer::Line { points, colour: GREEN, stroke: Stroke::Solid, label: String::new() });
        }
    }
    layers.push(Layer::Dots {
        points: (0..data.passes.len()).filter_map(place).collect(),
        colour: GREEN,
        mark: Mark::Disc,
        label: label(&data.tuned_label),
    });
    Chart {
        x: Axis::of_names("pass", data.passes.clone()),
        y: Axis::over(title, 0.0, 1.08 * largest(errors)),
        layers,
        ..Chart::default()
    }
}
