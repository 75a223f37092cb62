//! Quantities over the sweep of a design variable.

use crate::job::propagate::{Distributed, Output};
use crate::math::sort::sort_by;
use crate::report::number::Shown;
use crate::report::page::{Block, Figure};
use crate::report::plot::{Along, Axis, Chart, Layer, Limit, Stroke, palette};

/// Ends of the band among the values of a distribution function at 0.005, 0.015, ...: of 95 %.
const ENDS: [usize; 2] = [2, 97];

/// The figures, folded away; nothing without a sweep.
pub(in crate::report::section) fn block(output: &Output, job: &str) -> Option<Block> {
    let figures: Vec<Block> = figures(output, job).into_iter().map(Block::Figure).collect();
    (!figures.is_empty()).then(|| Block::Details(format!("Quantities along the sweep ({})", figures.len()), figures))
}

/// Each quantity against the design variable: median and 95 % band, environment by environment.
fn figures(output: &Output, job: &str) -> Vec<Figure> {
    let Some(design) = &output.design_variable else { return Vec::new() };
    let x = Shown::written(&output.design_unit);
    let environments = super::environments(output);
    let Some(first) = output.cases.iter().find(|case| case.design_value.is_some()) else { return Vec::new() };
    let figure = |own: &Distributed| {
        let y = Shown::quantity(&own.unit, own.is_temperature);
        let mut chart =
            Chart { x: Axis::new(x.title(design)), y: Axis::new(y.title(&own.name)), height: 760, ..Chart::default() };
        for (position, environment) in environments.iter().enumerate() {
            let mut points: Vec<[f64; 4]> = Vec::new();
            for case in output.cases.iter().filter(|case| case.environment == *environment) {
                let Some(at) = case.design_value else { continue };
                let Some(found) = case.quantities.iter().find(|found| found.name == own.name) else { continue };
                let Some([low, high]) = ends(found) else { continue };
                points.push([x.value(at), super::quantile(found, 0.5), low, high]);
            }
            sort_by(&mut points, |a, b| a[0].total_cmp(&b[0]));
            let colour = palette::series(position);
            let label = if environments.len() > 1 { (*environment).to_owned() } else { String::new() };
            let band = points.iter().map(|[at, _, low, high]| (*at, y.value(*low), y.value(*high))).collect();
            let line = points.iter().map(|[at, median, ..]| (*at, y.value(*median))).collect();
            chart.layers.push(Layer::Band { points: band, colour, label: String::new() });
            chart.layers.push(Layer::Line { points: line, colour, stroke: Stroke::Solid, label });
        }
        let limits = first.requirements.iter().filter(|met| met.quantity == own.name);
        for limit in limits.flat_map(|met| [met.below, met.above]).flatten() {
            let colour = palette::VERMILION;
            chart.limits.push(Limit { along: Along::Y, value: y.value(limit), label: "limit".into(), colour });
        }
        let caption = format!("{} against {design}: median and 95 % band.", own.name);
        Figure {
            id: format!("{job}-{}-along-{design}", own.name),
            drawing: chart.draw(),
            alternative: caption.clone(),
            caption: caption.into(),
        }
    };
    first.quantities.iter().map(figure).collect()
}

/// The 95 % band of a quantity.
fn ends(own: &Distributed) -> Option<[f64; 2]> {
    Some([*own.cdf.get(ENDS[0])?, *own.cdf.get(ENDS[1])?])
}
