//! How a sensor's residual goes with time and with each input.

use super::output::Trend;
use super::readings::{Row, Table};
use crate::math::sort::sort_by;
use crate::measurement::{Measurement, Rows};
use crate::statistics::moments::correlation;
use crate::statistics::regression::Line;
use crate::thermal::Model;

/// Trends of every sensor against time (of a transient) and every input that varies.
pub fn trends(measurement: &Measurement, model: &Model, table: &Table) -> Vec<Trend> {
    let mut trends = Vec::new();
    for (position, sensor) in measurement.sensors.iter().enumerate() {
        let sensor_rows: Vec<Row<&str>> = table.column(position).collect();
        let residuals: Vec<f64> = sensor_rows.iter().map(Row::deviation).collect();
        for (against, unit, values) in abscissae(measurement, model, &sensor_rows) {
            let Some(line) = Line::fit(&values, &residuals) else { continue };
            let left = line.residuals(&values, &residuals);
            let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
            trends.push(Trend {
                measurement: measurement.name.clone(),
                sensor: sensor.name.clone(),
                against,
                unit,
                slope: line.slope,
                slope_error: line.slope_standard_error_autocorrelated(&left),
                correlation: Some(correlation(&values, &residuals)).filter(|r| r.is_finite()).unwrap_or(0.0),
                change: line.slope * (high - low),
            });
        }
    }
    strongest_first(&mut trends);
    trends
}

/// Sorts trends by the magnitude of their correlation, names deciding between equals.
pub fn strongest_first(trends: &mut [Trend]) {
    sort_by(trends, |a, b| {
        b.correlation
            .abs()
            .total_cmp(&a.correlation.abs())
            .then_with(|| (&a.sensor, &a.against).cmp(&(&b.sensor, &b.against)))
    });
}

/// What residuals may go with: name, SI unit, one value a row.
fn abscissae(measurement: &Measurement, model: &Model, rows: &[Row<&str>]) -> Vec<(String, String, Vec<f64>)> {
    let si =
        |unit: &str| crate::expression::Unit::parse(unit).map_or_else(|_| unit.to_owned(), |u| u.dimension.to_string());
    match &measurement.rows {
        Rows::Steady(phases) => {
            let phase_of = |row: &Row<&str>| phases.iter().find(|p| Some(p.name.as_str()) == row.phase);
            (0..model.inputs.len())
                .map(|input| {
                    let values = rows.iter().filter_map(|row| Some(phase_of(row)?.inputs[input])).collect();
                    (model.inputs[input].name.clone(), si(&model.inputs[input].unit), values)
                })
                .collect()
        }
        Rows::Transient { inputs, .. } => {
            let times: Vec<f64> = rows.iter().filter_map(|row| row.time_s).collect();
            let row_of = |time_s: f64| inputs.times_s.partition_point(|&t| t < time_s);
            let mut abscissae: Vec<(String, String, Vec<f64>)> = inputs
                .columns
                .iter()
                .map(|column| {
                    let values = times.iter().map(|&t| column.values[row_of(t)]).collect();
                    let input = &model.inputs[column.input];
                    (input.name.clone(), si(&input.unit), values)
                })
                .collect();
            abscissae.insert(0, ("time".to_owned(), "s".to_owned(), times));
            abscissae
        }
    }
}
