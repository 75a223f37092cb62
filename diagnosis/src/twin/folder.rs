//! A case as the files of a study: the program can be run on it from outside.

use serde_json::{Value, json};

use super::case::Case;
use super::specification::object;
use crate::measurement::{Initial, Measurement, Rows};
use crate::thermal::{Input, Model};

/// The files of a case: name within the folder, and text.
pub fn files(case: &Case) -> Vec<(String, String)> {
    let truth = serde_json::to_string_pretty(&case.truth).unwrap_or_default();
    let mut files = vec![
        ("model.json".to_owned(), case.specification.text()),
        ("pass-1.json".to_owned(), pass(case)),
        ("truth.json".to_owned(), format!("{truth}\n")),
    ];
    files.extend(
        case.problem
            .measurements
            .iter()
            .map(|measured| (measured.file.clone(), table(written(&case.problem.model), measured))),
    );
    files
}

/// The inputs that a file states.
pub(super) fn written(model: &Model) -> &[Input] {
    &model.inputs[..model.clocks.first().unwrap_or(model.inputs.len())]
}

/// A measurement as a table: inputs and readings in SI.
pub fn table(inputs: &[Input], measurement: &Measurement) -> String {
    let columns: Vec<usize> = match &measurement.rows {
        Rows::Steady(_) => (0..inputs.len()).collect(),
        Rows::Transient { inputs, .. } => inputs.columns.iter().map(|column| column.input).collect(),
    };
    let mut text = match &measurement.rows {
        Rows::Steady(_) => "phase".to_owned(),
        Rows::Transient { .. } => "time [s]".to_owned(),
    };
    for &input in &columns {
        text.push_str(&format!(",{} [{}]", inputs[input].name, inputs[input].unit));
    }
    for sensor in &measurement.sensors {
        text.push_str(&format!(",{} [{}]", sensor.name, sensor.unit));
    }
    for row in 0..measurement.len() {
        text.push('\n');
        let value = |input: usize| match &measurement.rows {
            Rows::Steady(phases) => phases[row].inputs[input],
            Rows::Transient { inputs, .. } => inputs.in_row(row, input),
        };
        match &measurement.rows {
            Rows::Steady(phases) => text.push_str(&phases[row].name),
            Rows::Transient { inputs, .. } => text.push_str(&inputs.times_s[row].to_string()),
        }
        for &input in &columns {
            text.push_str(&format!(",{}", value(input)));
        }
        for sensor in 0..measurement.sensors.len() {
            let reading = measurement.reading(row, sensor).map(|value| value.to_string()).unwrap_or_default();
            text.push_str(&format!(",{reading}"));
        }
    }
    text.push('\n');
    text
}

fn pass(case: &Case) -> String {
    let names: Vec<&String> = case.problem.measurements.iter().map(|measurement| &measurement.name).collect();
    let measurements: Vec<String> = case
        .problem
        .measurements
        .iter()
        .map(|measured| format!("  {}: {}", json!(measured.name), measurement(written(&case.problem.model), measured)))
        .collect();
    let title = json!(case.specification.title);
    let jobs = json!({"tuned": {"calibrate": {"data": names}}, "missing": {"diagnose": {"data": names}}});
    format!(
        "{{\n\"format\": \"bmv-pass/1\",\n\"title\": {title},\n\"parent\": null,\n\"model\": \"model.json\",\n\"seed\": 7,\n\
         \"measurements\": {{\n{}\n}},\n\"jobs\": {jobs}\n}}\n",
        measurements.join(",\n")
    )
}

fn measurement(inputs: &[Input], measured: &Measurement) -> String {
    let sensors = object(measured.sensors.iter().map(|sensor| {
        let sigma = sensor.sigma.as_ref().map(crate::measurement::Uncertain::nominal);
        (&sensor.name, json!({"measures": sensor.name, "sigma": {"value": sigma, "unit": "K"}}))
    }));
    let file = json!(measured.file);
    match &measured.rows {
        Rows::Steady(phases) => {
            let held: Vec<&str> =
                phases.iter().filter(|phase| phase.held_out).map(|phase| phase.name.as_str()).collect();
            let held_out = json!({"phases": held});
            format!("{{\"steady\": {{\"file\": {file}, \"sensors\": {sensors}, \"held_out\": {held_out}}}}}")
        }
        Rows::Transient { inputs: table, initial, held_out, .. } => {
            let hold: Vec<&str> = (table.columns.iter())
                .filter(|column| column.hold)
                .map(|column| inputs[column.input].name.as_str())
                .collect();
            let from = held_out.iter().position(|held| *held).map(|row| table.times_s[row]);
            let held_out = match from {
                Some(from) => json!({"intervals": [{"from": {"value": from, "unit": "s"}}]}),
                None => Value::Null,
            };
            let initial = match initial {
                Initial::Steady => json!({"steady": {}}),
                Initial::Periodic => json!({"periodic": {}}),
                Initial::Temperatures { values, .. } => {
                    let all = values.first().map(crate::measurement::Uncertain::nominal);
                    json!({"temperatures": {"all": {"value": all, "unit": "K"}}})
                }
            };
            let mut rest = json!({"initial": initial, "held_out": held_out});
            if !hold.is_empty() {
                rest["hold"] = json!(hold);
            }
            let rest = rest.to_string();
            // The rest without its opening brace follows the sensors.
            format!("{{\"transient\": {{\"file\": {file}, \"sensors\": {sensors}, {}}}", &rest[1..])
        }
    }
}
