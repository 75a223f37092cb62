//! Transient measurements.

use crate::document::{Map, MapEntry, NameOr, Place, Sense, code, suggest};
use crate::expression::Dimension;
use crate::inference::measurement::{Initial, InputColumn, InputTable, Measurement, Rows, Uncertain};
use crate::study::pass::measurement::{InitialForm, MeasurementForm, TransientForm};
use crate::study::pass::uncertain::UncertainForm;
use crate::study::pinned::Pinned;
use crate::study::resolved::IgnoredSensor;
use crate::thermal::NodeKind;

use super::data::{Layout, columns, data, pin, separator};
use super::measurement::{Outcome, base_inputs, has_content, held_out_rows, parted, rows_within, sensors, wanted};
use super::scope::Scope;
use super::steady::time_column;

/// The name that stands for all nodes.
const ALL: &str = "all";

/// Resolves a transient measurement.
pub fn transient(
    scope: &mut Scope,
    entry: &MapEntry<MeasurementForm>,
    form: &TransientForm,
    pins: &mut Vec<Pinned>,
    ignored_sensors: &mut Vec<IgnoredSensor>,
) -> Outcome {
    let mut list = sensors(scope, &entry.name, &entry.name_place, &form.sensors, &form.ignore, ignored_sensors);
    let initial = initial(scope, &form.initial, &entry.name_place);
    let base = base_inputs(scope, &form.inputs);
    let pinned = form.pinned.as_ref().and_then(|pinned| pin(&entry.name, &form.file.value, pinned, scope.diagnostics));
    pins.extend(pinned.clone());
    let separator = separator(scope, form.separator.as_ref());
    let data = match data(scope, &form.file, pinned.as_ref()) {
        Ok(Some(data)) => data,
        Ok(None) => return Outcome::Missing,
        Err(_) => return Outcome::Wrong,
    };
    let names: Vec<String> = scope.resolved.model.inputs.iter().map(|input| input.name.clone()).collect();
    let mut wanted = wanted(scope, &names, &list, &form.file.place);
    wanted.insert(0, time_column(&form.file.place));
    let layout = Layout { columns: &form.columns, separator, key: "time" };
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
    for given in &form.inputs {
        if scope.input(&given.name).is_some_and(|index| parts.inputs.iter().any(|(input, _)| *input == index)) {
            let message = format!("`{}` has a column and a constant value", given.name);
            scope.error(&code::MEASUREMENT_FORM, &given.name_place, message, "one of the two");
        }
    }
    let held_out = held_out_rows(scope, form.held_out.as_ref(), &times_s);
    let ignored = ignored_rows(scope, form, &times_s);
    let mut readings = Vec::with_capacity(times_s.len() * list.len());
    for row in 0..times_s.len() {
        readings.extend(parts.sensors.iter().map(|sensor| sensor.values[row]));
    }
    for ((_, sensor), read) in list.iter_mut().zip(&parts.sensors) {
        sensor.unit.clone_from(&read.unit);
    }
    let hold = |input: usize| form.hold.iter().any(|hold| hold.value == names[input]);
    let table_columns: Vec<InputColumn> =
        (parts.inputs.into_iter()).map(|(input, values)| InputColumn { input, values, hold: hold(input) }).collect();
    let Some(initial) = initial else { return Outcome::Wrong };
    let measurement = Measurement {
        name: entry.name.clone(),
        rows: Rows::Transient {
            inputs: InputTable { times_s, columns: table_columns, base },
            initial,
            held_out,
            ignored,
        },
        sensors: list.into_iter().map(|(_, sensor)| sensor).collect(),
        readings,
        file: form.file.value.clone(),
        sha256: data.sha256,
        unused_columns: columns.unused,
    };
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
                let known: Vec<&str> = form.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
                scope.unknown(&code::MEASUREMENT_FORM, "sensor", &entry.name, &entry.name_place, &known);
            }
        }
    }
    ignored
}

fn initial(scope: &mut Scope, form: &InitialForm, place: &Place) -> Option<Initial> {
    match form {
        InitialForm::Steady(_) => Some(Initial::Steady),
        InitialForm::Periodic(_) => Some(Initial::Periodic),
        InitialForm::Temperatures(map) => temperatures(scope, map, place),
    }
}

fn temperatures(scope: &mut Scope, map: &Map<UncertainForm>, place: &Place) -> Option<Initial> {
    let before = scope.diagnostics.errors();
    let mut all = None;
    let mut named: Vec<Option<Uncertain>> = vec![None; scope.resolved.model.nodes.len()];
    for entry in map {
        let value = scope.uncertain(&entry.value, Dimension::TEMPERATURE, Sense::Absolute, true);
        if entry.name == ALL {
            all = value;
        } else if let Some(node) = scope.resolved.model.nodes.iter().position(|node| node.name == entry.name) {
            named[node] = value;
        } else {
            let known: Vec<String> = (std::iter::once(ALL.to_owned()))
                .chain(scope.resolved.model.nodes.iter().map(|node| node.name.clone()))
                .collect();
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            scope.unknown(&code::UNKNOWN_NAME, "node", &entry.name, &entry.name_place, &known);
        }
    }
    if scope.diagnostics.errors() > before {
        return None;
    }
    for &(node, host) in &scope.hosts {
        if named[node].is_none() {
            named[node] = named[host].clone();
        }
    }
    // What stores no heat as the model is written follows from the others at the start, whatever an effect adds to it.
    let mut balanced: Vec<usize> = (0..named.len())
        .filter(|&node| {
            let kind = scope.resolved.model.nodes[node].kind;
            let stores_nothing = matches!(kind, NodeKind::Arithmetic) || scope.given_storage.contains(&node);
            stores_nothing && named[node].is_none() && all.is_none()
        })
        .collect();
    for &(node, host) in &scope.hosts {
        if balanced.contains(&host) && named[node].is_none() && !balanced.contains(&node) {
            balanced.push(node);
        }
    }
    let lacks = |&node: &usize| {
        let stores = matches!(scope.resolved.model.nodes[node].kind, NodeKind::Diffusion { .. });
        stores && named[node].is_none() && all.is_none() && !balanced.contains(&node)
    };
    let lacking: Vec<&str> =
        (0..named.len()).filter(lacks).map(|node| scope.resolved.model.nodes[node].name.as_str()).collect();
    if !lacking.is_empty() {
        let message = format!("no start temperature of {}", suggest::listed(lacking.iter().copied(), 8));
        let place = map.iter().next().map_or(place, |entry| &entry.name_place).clone();
        scope.error(&code::INITIAL, &place, message, "a temperature for each, or `all`");
        return None;
    }
    // Nodes without storage follow from the others at once; what stands here is where their solution starts.
    let any = all.clone().or_else(|| named.iter().flatten().next().cloned());
    let start = any.map_or(ROOM_K, |value| value.nominal());
    let shared = (0..named.len()).filter(|&node| all.is_some() && named[node].is_none()).collect();
    let values = named.into_iter().map(|own| own.or_else(|| all.clone()).unwrap_or(Uncertain::Known(start))).collect();
    Some(Initial::Temperatures { values, shared, balanced })
}

/// Room temperature, K, where a model has no node that stores heat.
const ROOM_K: f64 = 293.15;
