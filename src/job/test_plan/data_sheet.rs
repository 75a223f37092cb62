//! The sheet on which a test's readings are written: a CSV of steady phases with empty cells, and the measurement that reads it.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::output::{Instrument, Output};
use crate::expression::Unit;

/// Decimals of a set point, in its unit: enough for any setting, and without the last digits of a conversion from SI.
const DECIMALS: f64 = 1e9;

/// A cell, in quotes where it needs them (RFC 4180).
fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// A header, `NAME [unit]`.
fn header(name: &str, unit: &str) -> String {
    cell(&if unit.is_empty() || unit == "1" { name.to_owned() } else { format!("{name} [{unit}]") })
}

/// The unit in which a sensor's readings are written: degrees Celsius for temperatures.
fn reading_unit(sensor: &Instrument) -> &str {
    if sensor.is_temperature { "degC" } else { &sensor.unit }
}

/// The sheet: a header, then a row a phase with its set points, readings left empty.
pub fn csv(output: &Output) -> String {
    let mut text = String::from("phase");
    for input in &output.inputs {
        let _ = write!(text, ",{}", header(&input.name, &input.unit));
    }
    for sensor in &output.sensors {
        let _ = write!(text, ",{}", header(&sensor.name, reading_unit(sensor)));
    }
    text.push('\n');
    for phase in &output.phases {
        text.push_str(&cell(&phase.name));
        for (input, si) in output.inputs.iter().zip(&phase.set_points) {
            let value = Unit::parse(&input.unit).map_or(*si, |unit| unit.from_si(*si));
            let rounded = (value * DECIMALS).round() / DECIMALS;
            // A number too large to be rounded so is written as it is.
            let _ = write!(text, ",{}", if rounded.is_finite() { rounded } else { value });
        }
        text.push_str(&",".repeat(output.sensors.len()));
        text.push('\n');
    }
    text
}

/// The measurement of a pass that reads the sheet from a file, as it stands under `measurements`.
pub fn measurement(output: &Output, file: &str) -> Value {
    let mut sensors = serde_json::Map::new();
    for sensor in &output.sensors {
        let unit = if sensor.is_temperature { "K" } else { &sensor.unit };
        let mut entry = json!({"measures": sensor.quantity, "sigma": {"value": sensor.sigma, "unit": unit}});
        if let Some(sd) = sensor.bias_sd {
            entry["bias"] = json!({"prior": {"normal": {"mean": 0, "sd": sd}}});
        }
        sensors.insert(sensor.name.clone(), entry);
    }
    json!({"steady": {"file": file, "sensors": sensors}})
}
