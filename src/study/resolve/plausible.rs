//! What a measurement says of the inputs, and values that it cannot mean.

use crate::document::{Amount, Diagnostic, Map, Place, Sense, code, suggest};
use crate::expression::Dimension;
use crate::inference::measurement::Sensor;

use super::data::Data;
use super::influence;
use super::measurement::Parted;
use super::scope::Scope;

/// A value of an input that lies more than so many widths of its stated range beyond an end is a wrong unit or a slip.
const FAR_WIDTHS: f64 = 1.0;
/// What rounding may take a value beyond an end, in widths.
const ROUNDING_WIDTHS: f64 = 1e-9;
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
fn in_own_unit(scope: &Scope, input: usize, value: f64) -> String {
    match &scope.resolved.input_scales[input].unit {
        Some(unit) => format!("{} {}", short(unit.from_si(value)), unit.text),
        None => short(value),
    }
}

/// The finding that a value lies outside the range of its input: an error where it is far outside.
fn outside(scope: &Scope, input: usize, value: f64, place: &Place, more: usize) -> Diagnostic {
    let name = &scope.resolved.model.inputs[input].name;
    let [lower, upper] = scope.resolved.model.inputs[input].range.unwrap_or_default();
    let far = beyond(scope, input, value) > FAR_WIDTHS;
    let rows = match more {
        0 => String::new(),
        1 => ", and another row is".to_owned(),
        more => format!(", and {more} other rows are"),
    };
    let message = format!(
        "`{name}` is {} here: {}outside its range, {} to {}{rows}",
        in_own_unit(scope, input, value),
        if far { "far " } else { "" },
        in_own_unit(scope, input, lower),
        in_own_unit(scope, input, upper),
    );
    let help = format!("check the unit; if the value is right, widen the `range` of `{name}` in the model");
    if far {
        let expected = "at most one width of the range beyond an end";
        Diagnostic::error(&code::INPUT_RANGE, place, message).expected(expected).help(help)
    } else {
        Diagnostic::warning(&code::INPUT_RANGE, place, message).help(help)
    }
}

fn tell(scope: &mut Scope, finding: Diagnostic) {
    match finding.severity {
        crate::document::Severity::Error => scope.diagnostics.push(finding),
        crate::document::Severity::Warning => scope.doubts.push(finding),
    }
}

/// Checks constant values of inputs against their ranges.
pub fn constants(scope: &mut Scope, given: &Map<Amount>, base: &[f64]) {
    for entry in given {
        let Some(input) = scope.input(&entry.name) else { continue };
        if beyond(scope, input, base[input]) > 0.0 {
            let finding = outside(scope, input, base[input], &entry.value.place, 0);
            tell(scope, finding);
        }
    }
}

/// Checks the cells of a file: inputs against their ranges in the rows that drive the model, temperatures against
/// absolute zero in those that are read. One finding a column, at its first cell that is an error, else at its worst.
pub fn cells(
    scope: &mut Scope,
    data: &Data,
    parts: &Parted,
    sensors: &[&Sensor],
    drives: &dyn Fn(usize) -> bool,
    is_read: &dyn Fn(usize) -> bool,
) {
    for ((input, values), read) in parts.inputs.iter().zip(&parts.input_columns) {
        let is_absolute = scope.resolved.input_scales[*input].unit.as_ref().is_some_and(|unit| unit.has_offset());
        let rows: Vec<usize> = (0..values.len()).filter(|&row| drives(row)).collect();
        let cold: Vec<usize> =
            rows.iter().copied().filter(|&row| (is_absolute || read.1) && values[row] < 0.0).collect();
        if !cold.is_empty() {
            let name = scope.resolved.model.inputs[*input].name.clone();
            below_zero(scope, data, read.0, &name, &cold, values[cold[0]]);
            continue;
        }
        let out: Vec<usize> = rows.into_iter().filter(|&row| beyond(scope, *input, values[row]) > 0.0).collect();
        let far = out.iter().copied().find(|&row| beyond(scope, *input, values[row]) > FAR_WIDTHS);
        let worst = out.iter().copied().max_by(|&a, &b| {
            beyond(scope, *input, values[a]).total_cmp(&beyond(scope, *input, values[b])).then(b.cmp(&a))
        });
        let Some(row) = far.or(worst) else { continue };
        let finding = outside(scope, *input, values[row], &data.cell(row, read.0), out.len() - 1);
        tell(scope, finding);
    }
    for (sensor, read) in sensors.iter().zip(&parts.sensors) {
        if scope.quantity_form(sensor.quantity) != (Dimension::TEMPERATURE, Sense::Absolute) {
            continue;
        }
        let is_cold = |row: usize| read.values[row].is_some_and(|value| value <= 0.0);
        let cold: Vec<usize> = (0..read.values.len()).filter(|&row| is_read(row) && is_cold(row)).collect();
        if let Some(&row) = cold.first() {
            below_zero(scope, data, read.column, &sensor.name, &cold, read.values[row].unwrap_or_default());
        }
    }
}

fn below_zero(scope: &mut Scope, data: &Data, column: usize, name: &str, rows: &[usize], kelvin: f64) {
    let more = match rows.len() {
        0 | 1 => String::new(),
        2 => "; another row is so too".to_owned(),
        many => format!("; {} other rows are so too", many - 1),
    };
    let message = format!("`{name}` is {} K here, not above absolute zero{more}", short(kelvin));
    let place = data.cell(rows[0], column);
    let help = "check the unit of the column; leave the cell of a missing reading empty";
    scope.diagnostics.push(Diagnostic::error(&code::TABLE_CELL, &place, message).help(help));
}

/// Tells which inputs that move its sensors a measurement says nothing of: `given` has the phases (or the one transient),
/// each with whether it says the value of each input. What `test_sets` is an error, else the nominal value stands in, with
/// a warning.
pub fn unsaid(scope: &mut Scope, measurement: &str, place: &Place, given: &[(String, Vec<bool>)], sensors: &[&Sensor]) {
    let is_unsaid = |input: &usize| given.iter().any(|(_, own)| !own[*input]);
    let mut unsaid: Vec<usize> = (0..scope.resolved.test_sets.len()).filter(is_unsaid).collect();
    if unsaid.is_empty() {
        return;
    }
    let moves = influence::inputs(&scope.resolved.model, sensors);
    unsaid.retain(|&input| moves[input]);
    let mut sentences = Vec::new();
    let mut help = None;
    for input in unsaid {
        let lacking: Vec<&str> = given.iter().filter(|(_, own)| !own[input]).map(|(phase, _)| phase.as_str()).collect();
        let (name, nominal) = {
            let own = &scope.resolved.model.inputs[input];
            (own.name.clone(), own.nominal)
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
        let own_help = format!("give it a column `{name} [{unit}]`, or say that its value is meant: {declare}");
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
        help.get_or_insert(own_help);
    }
    let Some(help) = help else { return };
    let (last, before) = (sentences.len() - 1, sentences[..sentences.len() - 1].join(", "));
    let listed = if last == 0 { sentences[0].clone() } else { format!("{before} and {}", sentences[last]) };
    let (them, values) =
        if last == 0 { ("it", "the nominal value stands") } else { ("them", "the nominal values stand") };
    let message = format!("`{measurement}` does not say what {listed} was: {values} for {them}");
    scope.doubts.push(Diagnostic::warning(&code::INPUT_MISSING, place, message).help(help));
}
