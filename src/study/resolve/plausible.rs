//! What a measurement says of the inputs, and values that it cannot mean.

use crate::document::{Amount, Diagnostic, Map, Place, Sense, WrittenUnit, code, suggest};
use crate::expression::{Dimension, Unit};
use crate::measurement::Sensor;
use crate::statistics::noise::noise;
use crate::study::table::Header;

use super::data::Data;
use super::influence;
use super::measurement::Parted;
use super::scope::Scope;

/// A value of an input that lies more than so many widths of its stated range beyond an end is a wrong unit or a slip.
const FAR_WIDTHS: f64 = 1.0;
/// What rounding may take a value beyond an end, in widths.
const ROUNDING_WIDTHS: f64 = 1e-9;
/// What noise may take a reading beyond an end, in its standard deviations: a dissipation that is off reads a little below 0.
const NOISE_DEVIATIONS: f64 = 5.0;
/// And in widths where one reading a phase tells no noise: the offset of a meter.
const OFFSET_WIDTHS: f64 = 1e-3;
/// Values in another unit are plausible where the largest of them is at least this share of the range's larger end: between
/// units a thousand apart the nearer one is meant.
const NEARER: f64 = 0.0316;
/// Names listed in a message.
const NAMED: usize = 6;

/// A number with up to seven significant digits.
pub(super) fn short(value: f64) -> String {
    // What was written with an exponent is read again.
    format!("{:.6e}", value).parse::<f64>().unwrap_or(value).to_string()
}

/// How many widths of its stated range a value of an input lies beyond it; 0 within it or without a range.
fn beyond(scope: &Scope, input: usize, value: f64) -> f64 {
    let Some([lower, upper]) = scope.resolved.model.inputs[input].range else { return 0.0 };
    let widths = (lower - value).max(value - upper) / (upper - lower);
    if widths > ROUNDING_WIDTHS { widths } else { 0.0 }
}

/// A value of an input in its own unit.
pub fn in_own_unit(scope: &Scope, input: usize, value: f64) -> String {
    match &scope.resolved.input_scales[input].unit {
        Some(unit) => format!("{} {}", short(unit.from_si(value)), unit.text),
        None => short(value),
    }
}

/// What noise and offsets of a meter may take the readings of an input beyond an end of its range, in widths of the range.
/// `series` says whether they follow one another in time, so that they tell their noise.
fn tolerance(scope: &Scope, input: usize, readings: &[f64], series: bool) -> f64 {
    let Some([lower, upper]) = scope.resolved.model.inputs[input].range else { return 0.0 };
    let noise = noise(readings).filter(|_| series).unwrap_or(0.0);
    OFFSET_WIDTHS.max(NOISE_DEVIATIONS * noise / (upper - lower))
}

/// The unit in which all values (SI as they were read) lie in the range of their input, where they are easily written in
/// that one and do not in their own. Zeros are the same in units without an offset.
fn meant(scope: &Scope, input: usize, values: &[f64], unit: &Unit) -> Option<Unit> {
    let [lower, upper] = scope.resolved.model.inputs[input].range?;
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |most: f64, value| most.max(value.abs()));
    unit.easily_mistaken().into_iter().find(|other| {
        let is_scaled = !(unit.has_offset() || other.has_offset());
        let read = |value: &f64| other.to_si(unit.from_si(*value));
        let fits = |value: &f64| (is_scaled && *value == 0.0) || beyond(scope, input, read(value)) == 0.0;
        let is_near = || largest(&mut values.iter().map(read)) >= NEARER * lower.abs().max(upper.abs());
        values.iter().all(fits) && (!is_scaled || is_near())
    })
}

/// The finding that a value lies outside the range of its input: an error where it is far outside. Where another unit than
/// the one that is stated explains the values it stands at that unit.
fn outside(
    scope: &Scope,
    input: usize,
    value: f64,
    place: &Place,
    more: usize,
    mistaken: Option<(&WrittenUnit, Unit)>,
) -> Diagnostic {
    let name = &scope.resolved.model.inputs[input].name;
    let [lower, upper] = scope.resolved.model.inputs[input].range.unwrap_or_default();
    let far = beyond(scope, input, value) > FAR_WIDTHS;
    let rows = match more {
        0 => String::new(),
        1 => "; it is outside in another row too".to_owned(),
        more => format!("; it is outside in {more} other rows too"),
    };
    let shown = in_own_unit(scope, input, value);
    let outside = format!(
        "{}outside its range, {} to {}{rows}",
        if far { "far " } else { "" },
        in_own_unit(scope, input, lower),
        in_own_unit(scope, input, upper),
    );
    let finding = if far { Diagnostic::error } else { Diagnostic::warning };
    if let Some((WrittenUnit { unit, place: at }, other)) = mistaken {
        let message =
            format!("`{name}` is {shown}, {outside}: its unit is most likely `{}`, not `{}`", other.text, unit.text);
        return finding(&code::INPUT_RANGE, at, message)
            .expected(format!("most likely `{}`", other.text))
            .related(place, format!("{shown} here"))
            .help(format!(
                "write `{}`; if `{}` is right, widen the `range` of `{name}` in the model",
                other.text, unit.text
            ));
    }
    let help = format!("check the unit; if the value is right, widen the `range` of `{name}` in the model");
    let finding = finding(&code::INPUT_RANGE, place, format!("`{name}` is {shown} here: {outside}")).help(help);
    if far { finding.expected("at most one width of the range beyond an end") } else { finding }
}

fn tell(scope: &mut Scope, finding: Diagnostic) {
    match finding.severity {
        crate::document::Severity::Error => scope.diagnostics.push(finding),
        crate::document::Severity::Warning => scope.doubts.push(finding),
    }
}

/// Of warnings that one input leaves its range in several measurements the first is kept, and names the other places.
pub fn said_once(doubts: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let mut kept: Vec<Diagnostic> = Vec::new();
    let help = |finding: &Diagnostic| finding.help.clone();
    for doubt in doubts {
        // The help names the input, and the unit that is meant.
        let is_same = |own: &&mut Diagnostic| own.code == doubt.code && help(own) == help(&doubt);
        match kept.iter_mut().find(is_same).filter(|_| doubt.code == &code::INPUT_RANGE) {
            Some(first) => {
                if first.related.len() < NAMED {
                    first.related.push((doubt.place, "and here".to_owned()));
                }
            }
            None => kept.push(doubt),
        }
    }
    kept
}

/// Checks constant values of inputs against their ranges.
pub fn constants(scope: &mut Scope, given: &Map<Amount>, base: &[f64]) {
    for entry in given {
        let Some(input) = scope.input(&entry.name) else { continue };
        let value = base[input];
        if beyond(scope, input, value) > 0.0 {
            let amount = &entry.value;
            let mistaken =
                amount.unit.as_ref().and_then(|written| Some((written, meant(scope, input, &[value], &written.unit)?)));
            let finding = outside(scope, input, value, &amount.place, 0, mistaken);
            tell(scope, finding);
        }
    }
}

/// Checks the cells of a file: inputs against their ranges in the rows that drive the model, temperatures against
/// absolute zero in those that are read. `series` says that the rows follow one another in time. One finding a column, at its first cell that is an error, else at its worst.
pub fn cells(
    scope: &mut Scope,
    data: &Data,
    parts: &Parted,
    sensors: &[&Sensor],
    drives: &dyn Fn(usize) -> bool,
    is_read: &dyn Fn(usize) -> bool,
    series: bool,
) {
    for ((input, values), read) in parts.inputs.iter().zip(&parts.input_columns) {
        let is_absolute = scope.resolved.input_scales[*input].unit.as_ref().is_some_and(|unit| unit.has_offset());
        let rows: Vec<usize> = (0..values.len()).filter(|&row| drives(row)).collect();
        let WrittenUnit { unit, .. } = &read.unit;
        let is_absolute = is_absolute || unit.has_offset();
        let cold: Vec<usize> = rows.iter().copied().filter(|&row| is_absolute && values[row] < 0.0).collect();
        if !cold.is_empty() {
            let name = scope.resolved.model.inputs[*input].name.clone();
            below_zero(scope, data, read.column, &name, &cold, values[cold[0]]);
            continue;
        }
        let tolerance = tolerance(scope, *input, &rows.iter().map(|&row| values[row]).collect::<Vec<_>>(), series);
        let is_out = |row: &usize| beyond(scope, *input, values[*row]) > tolerance;
        let out: Vec<usize> = rows.iter().copied().filter(is_out).collect();
        let far = out.iter().copied().find(|&row| beyond(scope, *input, values[row]) > FAR_WIDTHS);
        let worst = out.iter().copied().max_by(|&a, &b| {
            beyond(scope, *input, values[a]).total_cmp(&beyond(scope, *input, values[b])).then(b.cmp(&a))
        });
        let Some(row) = far.or(worst) else { continue };
        let used: Vec<f64> = rows.iter().map(|&row| values[row]).collect();
        let mistaken = meant(scope, *input, &used, unit).map(|other| (&read.unit, other));
        let finding = outside(scope, *input, values[row], &data.cell(row, read.column), out.len() - 1, mistaken);
        tell(scope, finding);
    }
    for (sensor, read) in sensors.iter().zip(&parts.sensors) {
        if scope.quantity_form(sensor.quantity) != (Dimension::TEMPERATURE, Sense::Absolute) {
            continue;
        }
        let is_cold = |row: usize| read.values[row].is_some_and(|value| value <= 0.0);
        let cold: Vec<usize> = (0..read.values.len()).filter(|&row| is_read(row) && is_cold(row)).collect();
        if let Some(&row) = cold.first() {
            below_zero(scope, data, read.origin.column, &sensor.name, &cold, read.values[row].unwrap_or_default());
        }
    }
}

fn below_zero(scope: &mut Scope, data: &Data, column: usize, name: &str, rows: &[usize], kelvin: f64) {
    let more = match rows.len() {
        0 | 1 => String::new(),
        2 => "; neither is it in another row".to_owned(),
        many => format!("; neither is it in {} other rows", many - 1),
    };
    let message = format!("`{name}` is {} K here, not above absolute zero{more}", short(kelvin));
    let place = data.cell(rows[0], column);
    let help = "check the unit of the column; leave the cell of a missing reading empty";
    scope.diagnostics.push(Diagnostic::error(&code::TABLE_CELL, &place, message).help(help));
}

/// Tells which inputs that move its sensors a measurement says nothing of: `given` has the phases (or the one transient),
/// each with whether it says the value of each input. What `test_sets` is an error, else the nominal value stands in, with
/// a warning. `spare` has the columns that nothing uses: one of nearly an input's name is most likely its own.
pub fn unsaid(
    scope: &mut Scope,
    measurement: &str,
    place: &Place,
    given: &[(String, Vec<bool>)],
    sensors: &[&Sensor],
    spare: &[Header],
) {
    let is_unsaid = |input: &usize| given.iter().any(|(_, given_inputs)| !given_inputs[*input]);
    let mut unsaid: Vec<usize> = (0..scope.resolved.test_sets.len()).filter(is_unsaid).collect();
    if unsaid.is_empty() {
        return;
    }
    let moves = influence::inputs(&scope.resolved.model, sensors);
    unsaid.retain(|&input| moves[input]);
    let mut sentences = Vec::new();
    // Of a misspelt column first.
    let (mut help, mut near_help) = (None, None);
    for input in unsaid {
        let lacking: Vec<&str> =
            given.iter().filter(|(_, given_inputs)| !given_inputs[input]).map(|(phase, _)| phase.as_str()).collect();
        let (name, nominal) = {
            let model_input = &scope.resolved.model.inputs[input];
            (model_input.name.clone(), model_input.nominal)
        };
        let (value, unit) = match &scope.resolved.input_scales[input].unit {
            Some(unit) => (short(unit.from_si(nominal)), unit.text.clone()),
            None => (short(nominal), String::new()),
        };
        let phases = if lacking.len() == given.len() {
            String::new()
        } else {
            format!(" in {}", suggest::listed(lacking.iter().copied(), NAMED))
        };
        let declare = if unit.is_empty() {
            format!("\"inputs\": {{\"{name}\": {value}}}")
        } else {
            format!("\"inputs\": {{\"{name}\": {{\"value\": {value}, \"unit\": \"{unit}\"}}}}")
        };
        let near = scope.diagnostics.nearest(&name, spare.iter().map(|header| header.name.as_str()));
        let near = near.and_then(|near| spare.iter().find(|header| header.name == near));
        let own_help = match near {
            Some(near) => misspelt(&name, &unit, near),
            None => format!("give it a column `{name} [{unit}]`, or say that its value is meant: {declare}"),
        };
        if scope.resolved.test_sets[input] {
            let message = format!("`{measurement}` does not say what `{name}` was{phases}, which every test sets");
            let diagnostic = Diagnostic::error(&code::INPUT_MISSING, place, message)
                .expected(format!("a column, or a constant value of `{name}`"))
                .help(own_help);
            scope.diagnostics.push(diagnostic);
            continue;
        }
        let space = if unit.is_empty() { "" } else { " " };
        sentences.push(format!("`{name}` ({value}{space}{unit}{phases})"));
        if near.is_some() { &mut near_help } else { &mut help }.get_or_insert(own_help);
    }
    let Some(help) = near_help.or(help) else { return };
    let (last, before) = (sentences.len() - 1, sentences[..sentences.len() - 1].join(", "));
    let listed = if last == 0 { sentences[0].clone() } else { format!("{before} and {}", sentences[last]) };
    let (them, values) =
        if last == 0 { ("it", "the nominal value stands") } else { ("them", "the nominal values stand") };
    let message = format!("`{measurement}` does not say what {listed} was: {values} for {them}");
    scope.doubts.push(Diagnostic::warning(&code::INPUT_MISSING, place, message).help(help));
}

/// What to do with an unused column of nearly an input's name.
fn misspelt(name: &str, unit: &str, near: &Header) -> String {
    let own_unit = if near.unit.is_none() { format!(", \"unit\": \"{unit}\"") } else { String::new() };
    format!(
        "the file has an unused column `{}`: rename it `{name}`, or declare it: \"columns\": {{\"{name}\": {{\"header\": \"{}\"{own_unit}}}}}",
        near.name, near.text
    )
}
