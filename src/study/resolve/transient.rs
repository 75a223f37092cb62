//! Transient measurements.

use crate::document::{MapEntry, NameOr, code};
use crate::measurement::{InputColumn, InputTable, Measurement, Rows, Sensor};
use crate::study::pass::measurement::{MeasurementForm, TransientForm};
use crate::study::pinned::Pinned;
use crate::study::resolved::IgnoredSensor;
use crate::study::table::separator;

use super::data::{Layout, columns, data, pin};
use super::gaps;
use super::initial::{self, FirstRows, Stated};
use super::measurement::{
    Outcome, has_content, held_out_rows, parted, rows_within, said, said_twice, sensors, test_inputs, wanted,
};
use super::plausible;
use super::scope::Scope;
use super::steady::time_column;

/// Resolves a transient measurement.
pub fn transient(
    scope: &mut Scope,
    entry: &MapEntry<MeasurementForm>,
    form: &TransientForm,
    pins: &mut Vec<Pinned>,
    ignored_sensors: &mut Vec<IgnoredSensor>,
) -> Outcome {
    let mut list = sensors(scope, &entry.name, &entry.name_place, &form.sensors, &form.ignore, ignored_sensors);
    let stated = initial::stated(scope, &form.initial, &entry.name_place);
    let base = scope.nominal_inputs();
    let base = test_inputs(scope, base, &form.inputs);
    let pinned = form.pinned.as_ref().and_then(|pinned| pin(&entry.name, &form.file.value, pinned, scope.diagnostics));
    pins.extend(pinned.clone());
    let separator = separator(form.separator.as_ref(), scope.diagnostics);
    let data = match data(scope, &form.file, separator, pinned.as_ref()) {
        Ok(Some(data)) => data,
        Ok(None) => return Outcome::Missing,
        Err(_) => return Outcome::Wrong,
    };
    let names: Vec<String> = scope.resolved.model.inputs.iter().map(|input| input.name.clone()).collect();
    let mut wanted = wanted(scope, &names, &list, &form.file.place);
    wanted.insert(0, time_column(&form.file.place));
    let layout = Layout { columns: &form.columns, sensors: form.sensors.names().collect(), key: "time" };
    let Ok(mut columns) = columns(scope, &data, &layout, &wanted) else { return Outcome::Wrong };
    let times_s: Vec<f64> = match columns.read.remove(0) {
        Some(read) => read.values.into_iter().flatten().collect(),
        None => return Outcome::Wrong,
    };
    let parts = parted(&mut columns, names.len());
    for hold in &form.hold {
        let Some(index) = scope.known_input(&hold.value, &hold.place) else { continue };
        if !parts.inputs.iter().any(|(input, _)| *input == index) {
            let message = format!("`{}` has no column to hold", hold.value);
            scope.error(&code::MEASUREMENT_FORM, &hold.place, message, "an input with a column");
        }
    }
    said_twice(scope, &form.inputs, &parts);
    let given = [(String::new(), said(scope, &parts, &[&form.inputs]))];
    let held_out = held_out_rows(scope, form.held_out.as_ref(), &times_s);
    let ignored = ignored_rows(scope, form, &times_s);
    let used: Vec<&Sensor> = list.iter().map(|(_, sensor)| sensor).collect();
    plausible::unsaid(scope, &entry.name, &entry.name_place, &given, &used, &columns.spare);
    plausible::cells(scope, &data, &parts, &used, &|_| true, &|row| ignored[row].is_none());
    let mut readings = Vec::with_capacity(times_s.len() * list.len());
    for row in 0..times_s.len() {
        readings.extend(parts.sensors.iter().map(|sensor| sensor.values[row]));
    }
    for ((_, sensor), read) in list.iter_mut().zip(&parts.sensors) {
        sensor.unit.clone_from(&read.origin.unit.unit.text);
    }
    let hold = |input: usize| form.hold.iter().any(|hold| hold.value == names[input]);
    let table_columns: Vec<InputColumn> =
        (parts.inputs.into_iter()).map(|(input, values)| InputColumn { input, values, hold: hold(input) }).collect();
    let Some(stated) = stated else { return Outcome::Wrong };
    let mut first_inputs = base.clone();
    for column in &table_columns {
        if let (Some(slot), Some(value)) = (first_inputs.get_mut(column.input), column.values.first()) {
            *slot = *value;
        }
    }
    let first = FirstRows { inputs: &first_inputs, times_s: &times_s, ignored: &ignored, readings: &readings };
    let sensors: Vec<Sensor> = list.into_iter().map(|(_, sensor)| sensor).collect();
    let initial = match stated {
        Stated::Known(initial) => initial,
        Stated::Measured(form) => {
            let whose = (entry.name.as_str(), &entry.name_place);
            match initial::measured(scope, form, &first, &sensors, whose) {
                Some(initial) => initial,
                None => return Outcome::Wrong,
            }
        }
    };
    initial::compare(scope, &entry.name, &entry.name_place, &initial, &first, &sensors);
    let mut measurement = Measurement {
        name: entry.name.clone(),
        rows: Rows::Transient {
            inputs: InputTable { times_s, columns: table_columns, base },
            initial,
            held_out,
            ignored,
        },
        sensors,
        readings,
        file: form.file.value.clone(),
        sha256: data.sha256,
        unused_columns: columns.unused,
        doubts: Vec::new(),
    };
    gaps::doubts(scope, &mut measurement, &entry.name_place);
    if has_content(scope, &measurement, &form.file.place) {
        Outcome::Ready(Box::new(measurement))
    } else {
        Outcome::Wrong
    }
}

fn ignored_rows(scope: &mut Scope, form: &TransientForm, times_s: &[f64]) -> Vec<Option<String>> {
    let mut ignored: Vec<Option<String>> = vec![None; times_s.len()];
    for entry in &form.ignore {
        match &entry.value {
            NameOr::Other(interval) => {
                let within = rows_within(scope, times_s, interval.from.as_ref(), interval.to.as_ref(), &entry.place);
                if scope.reason(&interval.because) {
                    for (ignored, within) in ignored.iter_mut().zip(within.unwrap_or_default()) {
                        if within && ignored.is_none() {
                            *ignored = Some(interval.because.value.clone());
                        }
                    }
                }
            }
            NameOr::Name(_) if form.sensors.get(&entry.name).is_some() => {}
            NameOr::Name(_) => {
                let sensor_names: Vec<&str> = form.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
                scope.unknown(&code::MEASUREMENT_FORM, "sensor", &entry.name, &entry.name_place, &sensor_names);
            }
        }
    }
    ignored
}
