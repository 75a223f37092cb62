//! Steady measurements: a table of phases, or windows of time series.

use crate::document::hash::sha256_hex;
use crate::document::{Map, MapEntry, NameOr, Place, Sense, Spanned, code};
use crate::expression::Dimension;
use crate::measurement::{Measurement, Phase, Rows, Sensor, Stabilisation};
use crate::study::pass::measurement::{
    HeldOutForm, IgnoredIntervalForm, MeasurementForm, SensorForm, SteadyForm, WindowForm,
};
use crate::study::pinned::Pinned;
use crate::study::resolved::IgnoredSensor;
use crate::study::table::{Cells, Header, separator};
use crate::study::window::window;

use super::data::{Columns, Data, Layout, Wanted, columns, data, pin};
use super::measurement::{Outcome, has_content, parted, rows_within, said, said_twice, sensors, test_inputs, wanted};
use super::plausible;
use super::scope::Scope;

/// Most values of inputs over all phases.
const MOST_VALUES: usize = 10_000_000;

/// Resolves a steady measurement.
pub fn steady(
    scope: &mut Scope,
    entry: &MapEntry<MeasurementForm>,
    form: &SteadyForm,
    pins: &mut Vec<Pinned>,
    ignored: &mut Vec<IgnoredSensor>,
) -> Outcome {
    let mut list = sensors(scope, &entry.name, &entry.name_place, &form.sensors, &form.ignore, ignored);
    let outcome = match (&form.file, &form.windows) {
        (Some(file), None) => table(scope, entry, form, file, &mut list, pins),
        (None, Some(windows)) => from_windows(scope, entry, form, windows, &mut list),
        (Some(_), Some(_)) | (None, None) => {
            let message = "a steady measurement has either a `file` or `windows`";
            scope.error(&code::MEASUREMENT_FORM, &entry.name_place, message, "one of the two");
            Outcome::Wrong
        }
    };
    let Outcome::Ready(mut measurements) = outcome else { return outcome };
    let Some(measurement) = measurements.first_mut() else { return Outcome::Wrong };
    if !has_content(scope, measurement, form.file.as_ref().map_or(&entry.name_place, |file| &file.place)) {
        return Outcome::Wrong;
    }
    if let Rows::Steady(phases) = &mut measurement.rows {
        mark(scope, form, phases);
    }
    Outcome::Ready(measurements)
}

/// Marks the phases that are held out or left out; names of others are reported.
fn mark(scope: &mut Scope, form: &SteadyForm, phases: &mut [Phase]) {
    hold_out(scope, form.held_out.as_ref(), phases);
    leave_out(scope, &form.ignore, &form.sensors, phases);
}

fn table(
    scope: &mut Scope,
    entry: &MapEntry<MeasurementForm>,
    form: &SteadyForm,
    file: &Spanned<String>,
    list: &mut [(&MapEntry<SensorForm>, Sensor)],
    pins: &mut Vec<Pinned>,
) -> Outcome {
    let pinned = form.pinned.as_ref().and_then(|pinned| pin(&entry.name, &file.value, pinned, scope.diagnostics));
    pins.extend(pinned.clone());
    let separator = separator(form.separator.as_ref(), scope.diagnostics);
    let data = match data(scope, file, separator, pinned.as_ref()) {
        Ok(Some(data)) => data,
        Ok(None) => return Outcome::Missing,
        Err(_) => return Outcome::Wrong,
    };
    let names: Vec<String> = scope.resolved.model.inputs.iter().map(|input| input.name.clone()).collect();
    let wanted = wanted(scope, &names, list, &file.place);
    let layout = Layout { columns: &form.columns, sensors: form.sensors.names().collect(), key: "phase" };
    let Ok(mut columns) = columns(scope, &data, &layout, &wanted) else { return Outcome::Wrong };
    let parts = parted(&mut columns, names.len());
    // Every phase has values of all inputs, those without a column too.
    if columns.phases.len().saturating_mul(names.len()) > MOST_VALUES {
        let message = format!("{} phases of {} inputs", columns.phases.len(), names.len());
        scope.error(&code::TOO_LARGE, &file.place, message, &format!("at most {MOST_VALUES} values"));
        return Outcome::Wrong;
    }
    let base = scope.nominal_inputs();
    let base = test_inputs(scope, base, &form.inputs);
    said_twice(scope, &form.inputs, &parts);
    let is_used = |row: usize| form.ignore.get(&columns.phases[row]).is_none();
    let sensors: Vec<&Sensor> = list.iter().map(|(_, sensor)| sensor).collect();
    plausible::cells(scope, &data, &parts, &sensors, &is_used, &is_used, false);
    let given = [(String::new(), said(scope, &parts, &[&form.inputs]))];
    plausible::unsaid(scope, &entry.name, &entry.name_place, &given, &sensors, &columns.spare);
    let mut phases = Vec::new();
    let mut readings = Vec::new();
    for (row, name) in columns.phases.iter().enumerate() {
        let mut inputs = base.clone();
        for (input, values) in &parts.inputs {
            inputs[*input] = values[row];
        }
        phases.push(Phase { name: name.clone(), inputs, held_out: false, ignored: None, stabilisation: None });
        readings.extend(parts.sensors.iter().map(|sensor| sensor.values[row]));
    }
    for ((_, sensor), read) in list.iter_mut().zip(&parts.sensors) {
        sensor.unit.clone_from(&read.origin.unit.unit.text);
    }
    Outcome::Ready(vec![Measurement {
        name: entry.name.clone(),
        rows: Rows::Steady(phases),
        sensors: list.iter().map(|(_, sensor)| sensor.clone()).collect(),
        readings,
        file: file.value.clone(),
        sha256: data.sha256,
        unused_columns: columns.unused,
        time_zero_s: None,
        follows_gap: false,
        doubts: Vec::new(),
    }])
}

/// A time series that windows are cut from.
struct Series {
    file: String,
    data: Data,
    /// Rows that a phase is made of.
    used: Vec<bool>,
    times_s: Vec<f64>,
    parts: super::measurement::Parted,
    unused: Vec<String>,
    spare: Vec<Header>,
}

fn series(
    scope: &mut Scope,
    form: &SteadyForm,
    file: &Spanned<String>,
    list: &[(&MapEntry<SensorForm>, Sensor)],
) -> Option<Series> {
    let separator = separator(form.separator.as_ref(), scope.diagnostics);
    let data = data(scope, file, separator, None).ok().flatten()?;
    let names: Vec<String> = scope.resolved.model.inputs.iter().map(|input| input.name.clone()).collect();
    let mut wanted = wanted(scope, &names, list, &file.place);
    wanted.insert(0, time_column(&file.place));
    let layout = Layout { columns: &form.columns, sensors: form.sensors.names().collect(), key: "time" };
    let mut columns = columns(scope, &data, &layout, &wanted).ok()?;
    let times_s: Vec<f64> = columns.read.remove(0)?.values.into_iter().flatten().collect();
    let parts = parted(&mut columns, names.len());
    said_twice(scope, &form.inputs, &parts);
    let used = vec![false; times_s.len()];
    let Columns { unused, spare, .. } = columns;
    Some(Series { file: file.value.clone(), data, used, times_s, parts, unused, spare })
}

/// The column of instants.
pub fn time_column(place: &Place) -> Wanted<'_> {
    Wanted {
        name: "time",
        place,
        dimension: Some(Dimension::TIME),
        sense: Sense::Difference,
        cells: Cells::Times,
        required: true,
    }
}

fn from_windows(
    scope: &mut Scope,
    entry: &MapEntry<MeasurementForm>,
    form: &SteadyForm,
    windows: &Map<WindowForm>,
    list: &mut [(&MapEntry<SensorForm>, Sensor)],
) -> Outcome {
    if let Some(pinned) = &form.pinned {
        let message = "`pinned` belongs to a measurement with one `file`";
        scope.error(&code::MEASUREMENT_FORM, &pinned.sha256.place, message, "no `pinned` beside `windows`");
    }
    if windows.is_empty() {
        let message = format!("the measurement `{}` has no windows", entry.name);
        scope.error(&code::MEASUREMENT_FORM, &entry.name_place, message, "at least one entry under `windows`");
        return Outcome::Wrong;
    }
    let mut all: Vec<Series> = Vec::new();
    // What is wrong with a file is said once.
    let mut wrong: Vec<&str> = Vec::new();
    let base = scope.nominal_inputs();
    let base = test_inputs(scope, base, &form.inputs);
    let mut given = Vec::new();
    // A window that cannot be read keeps its name, so that what names it is not reported too.
    let unread = |entry: &MapEntry<WindowForm>| Phase {
        name: entry.name.clone(),
        inputs: Vec::new(),
        held_out: false,
        ignored: None,
        stabilisation: None,
    };
    let mut phases: Vec<Phase> = windows.iter().map(unread).collect();
    let mut readings = Vec::new();
    for (phase, MapEntry { name, value, place, .. }) in phases.iter_mut().zip(windows) {
        if !all.iter().any(|series| series.file == value.file.value) {
            if wrong.contains(&value.file.value.as_str()) {
                continue;
            }
            match series(scope, form, &value.file, list) {
                Some(series) => all.push(series),
                None => {
                    wrong.push(&value.file.value);
                    continue;
                }
            }
        }
        let mut inputs = test_inputs(scope, base.clone(), &value.inputs);
        let Some(series) = all.iter_mut().find(|series| series.file == value.file.value) else { continue };
        let rows = rows_within(scope, &series.times_s, value.from.as_ref(), value.to.as_ref(), place);
        let Some(rows) = rows else { continue };
        if form.ignore.get(name).is_none() {
            for (used, within) in series.used.iter_mut().zip(&rows) {
                *used |= within;
            }
        }
        let inside = |values: &[f64]| -> Vec<f64> {
            values.iter().zip(&rows).filter(|(_, within)| **within).map(|(value, _)| *value).collect()
        };
        let times_s = inside(&series.times_s);
        said_twice(scope, &value.inputs, &series.parts);
        given.push((name.clone(), said(scope, &series.parts, &[&form.inputs, &value.inputs])));
        for (input, values) in &series.parts.inputs {
            if let Some(statistics) = window(&times_s, &inside(values)) {
                inputs[*input] = statistics.mean;
            }
        }
        let mut steadiness = Stabilisation {
            from_s: times_s.first().copied().unwrap_or(0.0),
            to_s: times_s.last().copied().unwrap_or(0.0),
            slopes: Vec::new(),
            slope_errors: Vec::new(),
            chances: Vec::new(),
            mean_errors: Vec::new(),
        };
        for sensor in &series.parts.sensors {
            let (times_s, values): (Vec<f64>, Vec<f64>) = (sensor.values.iter().zip(&series.times_s).zip(&rows))
                .filter(|(_, within)| **within)
                .filter_map(|((value, time), _)| value.map(|value| (*time, value)))
                .unzip();
            let statistics = window(&times_s, &values);
            readings.push(statistics.map(|statistics| statistics.mean));
            steadiness.slopes.push(statistics.and_then(|statistics| statistics.slope));
            steadiness.slope_errors.push(statistics.and_then(|statistics| statistics.slope_error));
            steadiness.chances.push(statistics.and_then(|statistics| statistics.chance));
            steadiness.mean_errors.push(statistics.and_then(|statistics| statistics.mean_error));
        }
        (phase.inputs, phase.stabilisation) = (inputs, Some(steadiness));
    }
    let sensors: Vec<&Sensor> = list.iter().map(|(_, sensor)| sensor).collect();
    for series in &all {
        let is_used = |row: usize| series.used[row];
        plausible::cells(scope, &series.data, &series.parts, &sensors, &is_used, &is_used, true);
    }
    let spare: Vec<Header> = all.iter_mut().flat_map(|series| std::mem::take(&mut series.spare)).collect();
    plausible::unsaid(scope, &entry.name, &entry.name_place, &given, &sensors, &spare);
    if phases.iter().any(|phase| phase.stabilisation.is_none()) {
        // What is wrong with a window has been reported.
        mark(scope, form, &mut phases);
        return Outcome::Wrong;
    }
    if let Some(series) = all.first() {
        for ((_, sensor), read) in list.iter_mut().zip(&series.parts.sensors) {
            sensor.unit.clone_from(&read.origin.unit.unit.text);
        }
    }
    let mut unused_columns: Vec<String> = Vec::new();
    for series in &all {
        for header in &series.unused {
            if !unused_columns.contains(header) {
                unused_columns.push(header.clone());
            }
        }
    }
    let files: Vec<&str> = all.iter().map(|series| series.file.as_str()).collect();
    let sha256 = match all.as_slice() {
        [one] => one.data.sha256.clone(),
        several => {
            let hashes: Vec<&str> = several.iter().map(|series| series.data.sha256.as_str()).collect();
            sha256_hex(hashes.join("\n").as_bytes())
        }
    };
    Outcome::Ready(vec![Measurement {
        name: entry.name.clone(),
        rows: Rows::Steady(phases),
        sensors: list.iter().map(|(_, sensor)| sensor.clone()).collect(),
        readings,
        file: files.join(", "),
        sha256,
        unused_columns,
        time_zero_s: None,
        follows_gap: false,
        doubts: Vec::new(),
    }])
}

fn hold_out(scope: &mut Scope, form: Option<&HeldOutForm>, phases: &mut [Phase]) {
    match form {
        None => {}
        Some(HeldOutForm::All(_)) => phases.iter_mut().for_each(|phase| phase.held_out = true),
        Some(HeldOutForm::Phases(names)) => {
            for name in names {
                match phases.iter_mut().find(|phase| phase.name == name.value) {
                    Some(phase) => phase.held_out = true,
                    None => unknown_phase(scope, "phase", &name.value, &name.place, phases, &[]),
                }
            }
        }
        Some(HeldOutForm::Intervals(intervals)) => {
            if let Some(interval) = intervals.first() {
                let message = "a steady measurement has no intervals to hold out";
                scope.error(&code::MEASUREMENT_FORM, &interval.place, message, "`phases` or `all`");
            }
        }
    }
}

fn leave_out(
    scope: &mut Scope,
    ignore: &Map<NameOr<IgnoredIntervalForm>>,
    sensors: &Map<SensorForm>,
    phases: &mut [Phase],
) {
    for entry in ignore {
        let reason = match &entry.value {
            NameOr::Name(reason) => reason,
            NameOr::Other(_) => {
                let message = "a steady measurement has no stretches of time to leave out";
                scope.error(&code::MEASUREMENT_FORM, &entry.place, message, "the reason as a string");
                continue;
            }
        };
        match phases.iter_mut().find(|phase| phase.name == entry.name) {
            Some(phase) => {
                if scope.reason(reason) {
                    phase.ignored = Some(reason.value.clone());
                }
            }
            None if sensors.get(&entry.name).is_some() => {}
            None => {
                let sensor_names: Vec<&str> = sensors.iter().map(|entry| entry.name.as_str()).collect();
                unknown_phase(scope, "phase or sensor", &entry.name, &entry.name_place, phases, &sensor_names);
            }
        }
    }
}

fn unknown_phase(scope: &mut Scope, what: &str, name: &str, place: &Place, phases: &[Phase], more: &[&str]) {
    let mut listed_names: Vec<&str> = phases.iter().map(|phase| phase.name.as_str()).collect();
    listed_names.extend(more);
    scope.unknown(&code::MEASUREMENT_FORM, what, name, place, &listed_names);
}
