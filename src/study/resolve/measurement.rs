//! Measurements: sensors, inputs, what is held out and left out, and the data themselves.

use crate::document::{Amount, Map, MapEntry, NameOr, Place, Sense, Spanned, code};
use crate::expression::Dimension;
use crate::measurement::{Doubt, Measurement, Rows, Sensor};
use crate::study::pass::measurement::{HeldOutForm, IgnoredIntervalForm, IntervalForm, MeasurementForm, SensorForm};
use crate::study::pinned::Pinned;
use crate::study::resolved::IgnoredSensor;
use crate::study::table::Cells;

use super::data::{Columns, Origin, Read, Wanted};
use super::plausible;
use super::scope::Scope;

/// What became of a measurement.
pub enum Outcome {
    /// It is there: a transient with `max_gap` in parts, everything else as one.
    Ready(Vec<Measurement>),
    /// Its pinned data are not there.
    Missing,
    /// It has errors.
    Wrong,
}

/// Resolves a measurement; its pin and its ignored sensors go to the lists.
pub fn measurement(
    scope: &mut Scope,
    entry: &MapEntry<MeasurementForm>,
    pinned: &mut Vec<Pinned>,
    ignored: &mut Vec<IgnoredSensor>,
) -> Outcome {
    let (before, doubts) = (scope.diagnostics.errors(), scope.doubts.len());
    if let (MeasurementForm::Transient(_), Some(_)) = (&entry.value, &scope.resolved.external) {
        let message =
            format!("`{}` is a transient, and the model is asked outside for steady states alone", entry.name);
        scope.error(&code::EXTERNAL_MODEL, &entry.name_place, message, "a `steady` measurement");
        return Outcome::Wrong;
    }
    let mut outcome = match &entry.value {
        MeasurementForm::Steady(form) => super::steady::steady(scope, entry, form, pinned, ignored),
        MeasurementForm::Transient(form) => super::transient::transient(scope, entry, form, pinned, ignored),
    };
    if scope.diagnostics.errors() > before {
        return Outcome::Wrong;
    }
    if let Outcome::Ready(measurements) = &mut outcome
        && let Some(measurement) = measurements.first_mut()
    {
        measurement.doubts = scope.doubts[doubts..].iter().map(Doubt::from).collect();
    }
    outcome
}

/// The sensors that are used; those under `ignore` go to the list.
pub fn sensors<'a>(
    scope: &mut Scope,
    measurement: &str,
    place: &Place,
    forms: &'a Map<SensorForm>,
    ignore: &Map<NameOr<IgnoredIntervalForm>>,
    ignored: &mut Vec<IgnoredSensor>,
) -> Vec<(&'a MapEntry<SensorForm>, Sensor)> {
    let mut sensors = Vec::new();
    for entry in forms {
        if let Some(index) = scope.input(&entry.name) {
            let input = &scope.resolved.model.inputs[index].name;
            let message = format!("`{input}` is an input of the model and a sensor here: its column would be both");
            scope.error(&code::NAME_UNUSABLE, &entry.name_place, message, "another name");
            continue;
        }
        let form = &entry.value;
        let Some(quantity) = scope.quantity(&form.measures) else { continue };
        let (dimension, _) = scope.quantity_form(quantity);
        let mut value = |form: &Option<_>, dimension, above_zero| {
            form.as_ref().and_then(|form| scope.uncertain(form, dimension, Sense::Difference, above_zero))
        };
        let sigma = value(&form.sigma, dimension, true);
        let bias = value(&form.bias, dimension, false);
        let lag_s = value(&form.lag, Dimension::TIME, true);
        let behind_s = value(&form.clock_behind, Dimension::TIME, false).into_iter().collect();
        let correlation_time_s = value(&form.correlation_time, Dimension::TIME, true);
        let white = value(&form.white, dimension, true);
        if let Some(NameOr::Name(reason)) = ignore.get(&entry.name).map(|entry| &entry.value) {
            if scope.reason(reason) {
                let (measurement, sensor) = (measurement.to_owned(), entry.name.clone());
                ignored.push(IgnoredSensor { measurement, sensor, because: reason.value.clone() });
            }
            continue;
        }
        let name = entry.name.clone();
        let unit = String::new();
        sensors.push((entry, Sensor { name, quantity, unit, sigma, bias, lag_s, behind_s, correlation_time_s, white }));
    }
    if forms.is_empty() {
        let message = format!("the measurement `{measurement}` has no sensors");
        scope.error(&code::MEASUREMENT_FORM, place, message, "at least one sensor");
    }
    sensors
}

/// The columns of the inputs (each if it is there) and of the sensors (each must be there).
pub fn wanted<'a>(
    scope: &Scope,
    inputs: &'a [String],
    sensors: &'a [(&'a MapEntry<SensorForm>, Sensor)],
    place: &'a Place,
) -> Vec<Wanted<'a>> {
    let input = |(index, name): (usize, &'a String)| Wanted {
        name,
        place,
        dimension: scope.resolved.input_scales[index].dimension(),
        sense: Sense::Absolute,
        cells: Cells::Numbers,
        required: false,
    };
    let sensor = |(entry, sensor): &'a (&'a MapEntry<SensorForm>, Sensor)| {
        let (dimension, sense) = scope.quantity_form(sensor.quantity);
        Wanted {
            name: &entry.name,
            place: &entry.name_place,
            dimension: Some(dimension),
            sense,
            cells: Cells::Readings,
            required: true,
        }
    };
    inputs.iter().enumerate().map(input).chain(sensors.iter().map(sensor)).collect()
}

/// Columns of a file as inputs (position and values) and sensors.
pub struct Parted {
    /// Position of an input, and its values, SI.
    pub inputs: Vec<(usize, Vec<f64>)>,
    /// Where each of these stands.
    pub input_columns: Vec<Origin>,
    /// Unit and readings of each sensor, SI.
    pub sensors: Vec<Read>,
}

/// Parts the columns that were read for [`wanted`].
pub fn parted(columns: &mut Columns, inputs: usize) -> Parted {
    let mut parted = Parted { inputs: Vec::new(), input_columns: Vec::new(), sensors: Vec::new() };
    for (position, read) in columns.read.drain(..).enumerate() {
        let Some(read) = read else { continue };
        if position < inputs {
            parted.input_columns.push(read.origin);
            // An empty cell of an input was an error.
            parted.inputs.push((position, read.values.into_iter().flatten().collect()));
        } else {
            parted.sensors.push(read);
        }
    }
    parted
}

/// Constant values of inputs over the nominal ones.
pub fn base_inputs(scope: &mut Scope, given: &Map<Amount>) -> Vec<f64> {
    let nominal = scope.nominal_inputs();
    inputs_over(scope, nominal, given)
}

/// Constant values of inputs of a measurement, checked against their ranges, over others.
pub fn test_inputs(scope: &mut Scope, base: Vec<f64>, given: &Map<Amount>) -> Vec<f64> {
    let base = inputs_over(scope, base, given);
    plausible::constants(scope, given, &base);
    base
}

fn inputs_over(scope: &mut Scope, mut base: Vec<f64>, given: &Map<Amount>) -> Vec<f64> {
    for entry in given {
        let Some(index) = scope.known_input(&entry.name, &entry.name_place) else { continue };
        if let Some(value) = scope.input_value(index, &entry.value) {
            base[index] = value;
        }
    }
    base
}

/// Reports inputs that have a column and a constant value too.
pub fn said_twice(scope: &mut Scope, given: &Map<Amount>, parts: &Parted) {
    for given in given {
        if scope.input(&given.name).is_some_and(|index| parts.inputs.iter().any(|(input, _)| *input == index)) {
            let message = format!("`{}` has a column and a constant value", given.name);
            scope.error(&code::MEASUREMENT_FORM, &given.name_place, message, "one of the two");
        }
    }
}

/// Whether each input has a column or a constant value.
pub fn said(scope: &Scope, parts: &Parted, constants: &[&Map<Amount>]) -> Vec<bool> {
    (scope.resolved.model.inputs.iter().enumerate())
        .map(|(index, input)| {
            parts.inputs.iter().any(|(given_input, _)| *given_input == index)
                || constants.iter().any(|given| given.get(&input.name).is_some())
        })
        .collect()
}

/// Which rows lie in an interval, both ends included; reported where it is empty or holds none.
pub fn rows_within(
    scope: &mut Scope,
    times_s: &[f64],
    from: Option<&Amount>,
    to: Option<&Amount>,
    place: &Place,
) -> Option<Vec<bool>> {
    let from_s = from.map_or(Some(f64::NEG_INFINITY), |amount| scope.seconds(amount))?;
    let to_s = to.map_or(Some(f64::INFINITY), |amount| scope.seconds(amount))?;
    if from_s >= to_s {
        let message = format!("the interval from {from_s} s to {to_s} s is empty");
        scope.error(&code::INTERVAL, place, message, "an end after the beginning");
        return None;
    }
    let within: Vec<bool> = times_s.iter().map(|time| (from_s..=to_s).contains(time)).collect();
    if !within.contains(&true) {
        let bound = |value: Option<&f64>| value.copied().unwrap_or(f64::NAN);
        let (first, last) = (bound(times_s.first()), bound(times_s.last()));
        let message = "no row of the data lies in this interval".to_owned();
        scope.error(&code::INTERVAL, place, message, &format!("the data run from {first} s to {last} s"));
        return None;
    }
    Some(within)
}

/// Rows of a transient that are held out.
pub fn held_out_rows(scope: &mut Scope, form: Option<&HeldOutForm>, times_s: &[f64]) -> Vec<bool> {
    let mut held_out = vec![false; times_s.len()];
    match form {
        None => {}
        Some(HeldOutForm::All(_)) => held_out.fill(true),
        Some(HeldOutForm::Intervals(intervals)) => {
            for Spanned { value: IntervalForm { from, to }, place } in intervals {
                let within = rows_within(scope, times_s, from.as_ref(), to.as_ref(), place);
                for (held_out, within) in held_out.iter_mut().zip(within.unwrap_or_default()) {
                    *held_out |= within;
                }
            }
        }
        Some(HeldOutForm::Phases(phases)) => {
            if let Some(phase) = phases.first() {
                let message = "a transient has no phases to hold out";
                scope.error(&code::MEASUREMENT_FORM, &phase.place, message, "`intervals` or `all`");
            }
        }
    }
    held_out
}

/// Whether there are rows and readings; reported where not.
pub fn has_content(scope: &mut Scope, measurement: &Measurement, place: &Place) -> bool {
    let (lacking, expected) = if measurement.is_empty() {
        ("rows", "at least one row below the headers")
    } else if !measurement.readings.iter().any(Option::is_some) {
        ("reading of any sensor", "at least one reading")
    } else {
        return true;
    };
    let message = format!("`{}` has no {lacking}", measurement.file);
    scope.error(&code::TABLE_EMPTY, place, message, expected);
    false
}

/// Smallest and largest value of each input in the data, where it has a column.
pub fn widen_ranges(measurement: &Measurement, ranges: &mut [Option<[f64; 2]>]) {
    let mut widen = |input: usize, value: f64| {
        let range = ranges[input].get_or_insert([value, value]);
        range[0] = range[0].min(value);
        range[1] = range[1].max(value);
    };
    match &measurement.rows {
        Rows::Steady(phases) => {
            for phase in phases {
                for (input, value) in phase.inputs.iter().enumerate() {
                    widen(input, *value);
                }
            }
        }
        Rows::Transient { inputs, .. } => {
            for column in &inputs.columns {
                for value in &column.values {
                    widen(column.input, *value);
                }
            }
        }
    }
}
