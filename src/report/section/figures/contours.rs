//! A quantity of a prediction as contours over two axes, with the phases of the test and what the fit leaves there.

use crate::job::propagate::{Case, Output};
use crate::job::{predict, propagate};
use crate::math::sort::sort_by;
use crate::measurement::Measurement;
use crate::report::number::Shown;
use crate::report::page::Figure;
use crate::report::plot::{Axis, Contours as Surface, SurfaceNode, contours};
use crate::report::section::propagation::quantile;
use crate::report::view::PassReport;
use crate::study::figure::{Contours, Coordinate};

use super::{phases, predicted, spread};

/// The figure, or why there is none.
pub(super) fn figure(report: &PassReport<'_>, name: &str, own: &Contours) -> Result<Figure, String> {
    let output = output(report, &own.job)
        .ok_or_else(|| format!("job {} is no propagation or prediction with a result", own.job))?;
    let mut environments: Vec<&str> = Vec::new();
    for case in output.cases.iter().filter(|case| case.design_value.is_some()) {
        if !environments.contains(&case.environment.as_str()) {
            environments.push(&case.environment);
        }
    }
    let [x, y] = [0, 1].map(|axis| shown(report, output, &own.over[axis]));
    let mut value_shown = None;
    let mut sds: Vec<f64> = Vec::new();
    let mut rows: Vec<Vec<SurfaceNode>> = Vec::new();
    for environment in environments {
        let mut row: Vec<(f64, SurfaceNode)> = Vec::new();
        for case in output.cases.iter().filter(|case| case.environment == environment) {
            let Some(at) = case.design_value else { continue };
            let found = case.quantities.iter().find(|found| found.name == own.quantity);
            let found = found.ok_or_else(|| format!("job {} has no quantity {}", own.job, own.quantity))?;
            let shown = value_shown.get_or_insert_with(|| Shown::quantity(&found.unit, found.is_temperature));
            let [across, up] = [0, 1].map(|axis| coordinate(report, output, case, &own.over[axis]));
            let (across, up) = (across?, up?);
            sds.push(found.sd);
            let value = shown.value(quantile(found, 0.5));
            row.push((at, SurfaceNode { x: x.value(across), y: y.value(up), value }));
        }
        sort_by(&mut row, |a, b| a.0.total_cmp(&b.0));
        rows.push(row.into_iter().map(|(_, node)| node).collect());
    }
    // Neighbours in the picture are neighbours in the grid.
    let first = |row: &Vec<SurfaceNode>| row.first().map_or((0.0, 0.0), |node| (node.y, node.x));
    sort_by(&mut rows, |a, b| first(a).0.total_cmp(&first(b).0).then(first(a).1.total_cmp(&first(b).1)));
    let columns = rows.first().map_or(0, Vec::len);
    let is_grid = rows.len() > 1 && columns > 1 && rows.iter().all(|row| row.len() == columns);
    let Some(shown) = value_shown.filter(|_| is_grid) else {
        return Err(format!("job {} is not swept over a design variable in at least two environments", own.job));
    };
    let points = test_points(report, own);
    let deviations: Vec<f64> = points.iter().map(|point| point.2).collect();
    let points: Vec<(f64, f64, f64)> =
        points.into_iter().map(|(across, up, deviation)| (x.value(across), y.value(up), deviation)).collect();
    let difference = shown.difference();
    let left = spread(&deviations);
    let surface = Surface {
        x: Axis::new(x.title(&axis_name(report, &own.over[0]))),
        y: Axis::new(y.title(&axis_name(report, &own.over[1]))),
        rows,
        points,
        points_label: left.map_or(String::new(), |[_, largest]| {
            format!("measured \u{2212} fitted, \u{2212}{0} to +{0}", difference.text(largest))
        }),
        surface_label: format!("{}, median", shown.title(&own.quantity)),
    };
    let [least, most] = sds.iter().fold([f64::INFINITY, 0.0_f64], |[least, most], sd| [least.min(*sd), most.max(*sd)]);
    let error = left.map_or(String::new(), |[rms, largest]| {
        format!(
            " Points: phases of the test at their readings; measured minus fitted {} root mean square, {} at most.",
            difference.text(rms),
            difference.text(largest)
        )
    });
    let caption = format!(
        "{} over {} and {}, medians of job {}; its standard deviation on the grid is {} to {}.{error}",
        own.quantity,
        axis_name(report, &own.over[0]),
        axis_name(report, &own.over[1]),
        own.job,
        difference.number(least),
        difference.text(most),
    );
    Ok(Figure {
        id: format!("figure-{name}"),
        drawing: contours(&surface),
        alternative: format!("Contours. {caption}"),
        caption: caption.into(),
    })
}

/// The propagation, or the posterior's of a prediction.
fn output<'r>(report: &'r PassReport<'_>, job: &str) -> Option<&'r Output> {
    let predicted = report.outputs::<predict::Kind>().map(|(name, output)| (name, &output.posterior));
    let all = report.outputs::<propagate::Kind>().chain(predicted);
    all.filter(|(name, _)| *name == job).map(|(_, output)| output).next()
}

fn axis_name(report: &PassReport<'_>, axis: &Coordinate) -> String {
    match axis {
        Coordinate::Input(index) => report.model.inputs.get(*index).map(|own| own.name.clone()).unwrap_or_default(),
        Coordinate::Quantity(name) => name.clone(),
    }
}

fn shown(report: &PassReport<'_>, output: &Output, axis: &Coordinate) -> Shown {
    match axis {
        Coordinate::Input(index) => {
            Shown::written(report.model.inputs.get(*index).map_or("1", |own| own.unit.as_str()))
        }
        Coordinate::Quantity(name) => {
            let mut all = output.cases.iter().flat_map(|case| &case.quantities);
            let found = all.find(|own| own.name == *name);
            found.map_or_else(|| Shown::si(""), |own| Shown::quantity(&own.unit, own.is_temperature))
        }
    }
}

/// A coordinate of a case, SI.
fn coordinate(report: &PassReport<'_>, output: &Output, case: &Case, axis: &Coordinate) -> Result<f64, String> {
    match axis {
        Coordinate::Input(index) => {
            let name = axis_name(report, axis);
            if output.design_variable.as_ref() == Some(&name) {
                return case.design_value.ok_or_else(|| format!("a case has no {name}"));
            }
            let environment = report.environments.iter().find(|own| own.name == case.environment);
            let value = environment.and_then(|own| own.inputs.get(*index)).copied();
            value.ok_or_else(|| format!("environment {} is not among the pass's", case.environment))
        }
        Coordinate::Quantity(name) => {
            let found = case.quantities.iter().find(|own| own.name == *name);
            found.map(|own| quantile(own, 0.5)).ok_or_else(|| format!("the job has no quantity {name}"))
        }
    }
}

/// The phases whose readings give both coordinates and the quantity, SI, each with measured minus predicted.
fn test_points(report: &PassReport<'_>, own: &Contours) -> Vec<(f64, f64, f64)> {
    let mut points = Vec::new();
    for measured in report.measurements {
        let Some(of) = sensor_of(report, measured, &own.quantity) else { continue };
        for (row, phase) in phases(measured) {
            let reading =
                |sensor: usize| measured.readings.get(row * measured.sensors.len() + sensor).copied().flatten();
            let [across, up] = [0, 1].map(|axis| match &own.over[axis] {
                Coordinate::Input(index) => phase.inputs.get(*index).copied(),
                Coordinate::Quantity(name) => sensor_of(report, measured, name).and_then(reading),
            });
            let fitted = predicted(report, &measured.name, &measured.sensors[of].name, &phase.name);
            if let (Some(across), Some(up), Some(read), Some((fitted, _))) = (across, up, reading(of), fitted) {
                points.push((across, up, read - fitted));
            }
        }
    }
    points
}

/// The sensor that measures a quantity, whatever that is called.
fn sensor_of(report: &PassReport<'_>, measured: &Measurement, quantity: &str) -> Option<usize> {
    let quantities = &report.model.quantities;
    let asked = quantities.iter().find(|own| own.name == quantity)?.value;
    measured.sensors.iter().position(|own| quantities.get(own.quantity).is_some_and(|other| other.value == asked))
}
