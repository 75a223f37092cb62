//! Transient measurements.

use crate::document::calendar::dated;
use crate::document::{MapEntry, NameOr, Sense, code};
use crate::expression::Dimension;
use crate::measurement::{Initial, InputColumn, InputTable, Measurement, Rows, Sensor};
use crate::study::pass::measurement::{MeasurementForm, TransientForm};
use crate::study::pinned::Pinned;
use crate::study::resolved::IgnoredSensor;
use crate::study::table::separator;

use super::clocks;
use super::data::{Layout, columns, data, pin};
use super::gaps;
use super::initial::{self, FirstRows, Stated};
use super::measurement::{
    Outcome, has_content, held_out_rows, parted, rows_within, said, said_twice, sensors, test_inputs, wanted,
};
use super::parts::{part_name, rows_of_parts};
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
    let stated = initial::stated(scope, &form.initial, (&entry.name, &entry.name_place));
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
    plausible::cells(scope, &data, &parts, &used, &|_| true, &|row| ignored[row].is_none(), true);
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
    let sensors: Vec<Sensor> = list.into_iter().map(|(_, sensor)| sensor).collect();
    let Ok(max_gap_s) = max_gap(scope, form) else { return Outcome::Wrong };
    let Ok(time_zero_s) = time_zero(scope, form) else { return Outcome::Wrong };
    let parts = rows_of_parts(&times_s, max_gap_s);
    if parts.len() > 1 && matches!(stated, Stated::Known(Initial::Temperatures { .. })) {
        let place = form.max_gap.as_ref().map_or(&entry.name_place, |longest| &longest.place);
        let message = format!("`{}` has {} parts, and `initial` states how the first begins", entry.name, parts.len());
        scope.error(&code::INITIAL, place, message, "\"initial\": {\"measured\": {}}, which each part can begin with");
        return Outcome::Wrong;
    }
    let mut measurements = Vec::new();
    for (part, rows) in parts.into_iter().enumerate() {
        let name = part_name(&entry.name, part);
        let times_s = times_s[rows.clone()].to_vec();
        let ignored = ignored[rows.clone()].to_vec();
        let mut readings = readings[rows.start * sensors.len()..rows.end * sensors.len()].to_vec();
        clocks::leave_out_unknown(&times_s, &sensors, &mut readings);
        let columns_of_part = table_columns.iter().map(|column| {
            let values = column.values[rows.clone()].to_vec();
            InputColumn { input: column.input, values, hold: column.hold }
        });
        let table = InputTable { times_s, columns: columns_of_part.collect(), base: base.clone() };
        let mut first_inputs = base.clone();
        for column in &table.columns {
            if let (Some(slot), Some(value)) = (first_inputs.get_mut(column.input), column.values.first()) {
                *slot = *value;
            }
        }
        let shown = clocks::by_time_of_inputs(&table.times_s, &ignored, &sensors, &readings);
        let first = FirstRows { inputs: &first_inputs, times_s: &table.times_s, ignored: &ignored, readings: &shown };
        let shows_nothing = sensors.iter().any(clocks::is_off) && readings.iter().all(Option::is_none);
        if part > 0 && (first.are_all_ignored() || shows_nothing) {
            continue;
        }
        let initial = match &stated {
            Stated::Known(initial) => initial.clone(),
            Stated::Measured(form) => {
                match initial::measured(scope, form, &first, &sensors, (&name, &entry.name_place)) {
                    Some(initial) => initial,
                    None => return Outcome::Wrong,
                }
            }
        };
        initial::compare(scope, &name, &entry.name_place, &initial, &first, &sensors);
        let held_out = held_out[rows.clone()].to_vec();
        let mut measurement = Measurement {
            name,
            rows: Rows::Transient { inputs: table, initial, held_out, ignored },
            sensors: sensors.clone(),
            readings,
            file: form.file.value.clone(),
            sha256: data.sha256.clone(),
            unused_columns: columns.unused.clone(),
            time_zero_s,
            follows_gap: part > 0,
            doubts: Vec::new(),
        };
        gaps::doubts(scope, &mut measurement, &entry.name_place);
        measurements.push(measurement);
    }
    let mut has_content = measurements.iter().map(|measurement| has_content(scope, measurement, &form.file.place));
    if has_content.all(|has| has) { Outcome::Ready(measurements) } else { Outcome::Wrong }
}

/// The longest time between two rows of a part, s; `None` where none is stated, an error where it is no time above 0.
fn max_gap(scope: &mut Scope, form: &TransientForm) -> Result<Option<f64>, ()> {
    let Some(amount) = &form.max_gap else { return Ok(None) };
    let longest = amount.value.si(Dimension::TIME, None, Sense::Difference, scope.diagnostics).ok_or(())?;
    if longest > 0.0 {
        return Ok(Some(longest));
    }
    scope.error(&code::OUT_OF_RANGE, &amount.place, format!("a gap of {longest} s"), "a time above 0 s");
    Err(())
}

/// When the file's time is 0, s since 1970-01-01; an error where it is no date.
fn time_zero(scope: &mut Scope, form: &TransientForm) -> Result<Option<f64>, ()> {
    let Some(text) = &form.time_zero else { return Ok(None) };
    if let Some(seconds) = dated(&text.value).filter(|seconds| seconds.is_finite()) {
        return Ok(Some(seconds));
    }
    let message = format!("`{}` is no date and time", text.value);
    scope.error(&code::OUT_OF_RANGE, &text.place, message, "such as 2026-03-14T06:00:00");
    Err(())
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
