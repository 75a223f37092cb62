//! Figures of a study's own: names looked up, points in SI.

use crate::document::quantity::report_dimension;
use crate::document::{Diagnostic, Map, MapEntry, Sense, Spanned, code};
use crate::expression::Dimension;
use crate::measurement::{Measurement, Rows};
use crate::study::figure::{Contours, Coordinate, Drawn, Estimate, Figure, Readings, Source};
use crate::study::job::Forms;
use crate::study::pass::figure::{ContoursForm, EstimateForm, FigureForm, ReadingsForm};

use super::scope::Scope;
use super::settings::{Offered, measurement};

/// The figures, in the order of the file; one whose measurement waits for its data is left out.
pub fn figures(scope: &mut Scope, written: &Map<FigureForm>, offered: &Offered, forms: &Forms) -> Vec<Figure> {
    let mut figures = Vec::new();
    for entry in written {
        let (drawn, description) = match &entry.value {
            FigureForm::Readings(form) => (readings(scope, form, offered).map(Drawn::Readings), &form.description),
            FigureForm::Contours(form) => (contours(scope, form, forms).map(Drawn::Contours), &form.description),
        };
        figures.extend(drawn.map(|drawn| Figure { name: entry.name.clone(), description: description.clone(), drawn }));
    }
    figures
}

fn readings(scope: &mut Scope, form: &ReadingsForm, offered: &Offered) -> Option<Readings> {
    let position = measurement(scope, &form.data.value, &form.data.place, offered)??;
    let measured = offered.data.get(position)?;
    if !matches!(measured.rows, Rows::Steady(_)) {
        let message = format!("`{}` is a record in time", measured.name);
        scope.error(&code::FIGURE, &form.data.place, message, "a measurement of steady phases");
        return None;
    }
    let sensor = sensor(measured, &form.of.value);
    if sensor.is_none() {
        let names: Vec<&str> = measured.sensors.iter().map(|own| own.name.as_str()).collect();
        scope.unknown(&code::FIGURE, "sensor", &form.of.value, &form.of.place, &names);
    }
    let against = source(scope, measured, &form.against);
    let minus = form.minus.as_ref().map(|own| source(scope, measured, own));
    let by = form.by.as_ref().map(|own| scope.known_input(&own.value, &own.place));
    let (sensor, against) = (sensor?, against?);
    let minus = match minus {
        Some(minus) => Some(minus?),
        None => None,
    };
    let by = match by {
        Some(by) => Some(by?),
        None => None,
    };
    if let (Some(own), Some(written)) = (minus, &form.minus)
        && dimension(scope, measured, own) != dimension(scope, measured, Source::Sensor(sensor))
    {
        let message = format!("`{}` has another dimension than `{}`", written.value, form.of.value);
        scope.error(&code::FIGURE, &written.place, message, "a sensor or an input of the sensor's dimension");
        return None;
    }
    let sense = if minus.is_some() { Sense::Difference } else { Sense::Absolute };
    let dimensions = [against, Source::Sensor(sensor)].map(|own| dimension(scope, measured, own));
    let estimates: Vec<Option<Estimate>> =
        form.estimates.iter().map(|entry| estimate(scope, entry, dimensions, sense)).collect();
    let estimates = estimates.into_iter().collect::<Option<_>>()?;
    Some(Readings { measurement: measured.name.clone(), sensor, minus, against, by, estimates })
}

fn sensor(measured: &Measurement, name: &str) -> Option<usize> {
    measured.sensors.iter().position(|own| own.name == name)
}

/// An input or a sensor of the measurement.
fn source(scope: &mut Scope, measured: &Measurement, name: &Spanned<String>) -> Option<Source> {
    if let Some(sensor) = sensor(measured, &name.value) {
        return Some(Source::Sensor(sensor));
    }
    if let Some(input) = scope.input(&name.value) {
        return Some(Source::Input(input));
    }
    let inputs: Vec<String> = scope.resolved.model.inputs.iter().map(|input| input.name.clone()).collect();
    let names = inputs.iter().map(String::as_str).chain(measured.sensors.iter().map(|own| own.name.as_str()));
    scope.unknown(&code::FIGURE, "input or sensor", &name.value, &name.place, &names.collect::<Vec<_>>());
    None
}

/// Dimension of a source, where it is known.
fn dimension(scope: &Scope, measured: &Measurement, source: Source) -> Option<Dimension> {
    match source {
        Source::Input(index) => scope.resolved.input_scales[index].dimension(),
        Source::Sensor(index) => Some(scope.quantity_form(measured.sensors[index].quantity).0),
    }
}

fn estimate(
    scope: &mut Scope,
    entry: &MapEntry<EstimateForm>,
    dimensions: [Option<Dimension>; 2],
    sense: Sense,
) -> Option<Estimate> {
    let form = &entry.value;
    let mut is_right = true;
    for (written, expected) in form.units.iter().zip(dimensions) {
        if let Some(expected) = expected.filter(|own| *own != written.unit.dimension) {
            report_dimension(&written.unit, &written.place, expected, scope.diagnostics);
            is_right = false;
        }
    }
    if form.points.value.is_empty() {
        let message = format!("the estimate `{}` has no points", entry.name);
        scope.error(&code::FIGURE, &form.points.place, message, "at least one, such as [[0.5, 12.0], [1.0, -8.5]]");
        is_right = false;
    }
    if form.source.value.trim().is_empty() {
        let message = format!("the estimate `{}` does not say where it comes from", entry.name);
        let diagnostic = Diagnostic::error(&code::FIGURE, &form.source.place, message)
            .expected("its source")
            .help("numbers that are not the source's own are marked with \"reconstructed\": \"how\"");
        scope.diagnostics.push(diagnostic);
        is_right = false;
    }
    let [x, y] = &form.units;
    let value = |y: f64, unit: &crate::expression::Unit| match sense {
        Sense::Absolute => unit.to_si(y),
        Sense::Difference => unit.difference_to_si(y),
    };
    let points = form.points.value.iter().map(|[at, own]| (x.unit.to_si(*at), value(*own, &y.unit))).collect();
    is_right.then(|| Estimate {
        name: entry.name.clone(),
        points,
        source: form.source.value.clone(),
        reconstructed: form.reconstructed.clone(),
    })
}

fn contours(scope: &mut Scope, form: &ContoursForm, forms: &Forms) -> Option<Contours> {
    let before = scope.diagnostics.errors();
    let is_quantity =
        |scope: &Scope, name: &str| scope.resolved.quantity(name).is_some() || scope.resolved.node(name).is_some();
    let names = |scope: &Scope| -> Vec<String> {
        let model = &scope.resolved.model;
        model.quantities.iter().map(|own| own.name.clone()).collect()
    };
    if !is_quantity(scope, &form.of.value) {
        let names = names(scope);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        scope.unknown(&code::FIGURE, "quantity", &form.of.value, &form.of.place, &names);
    }
    if forms.kind(&form.from.value).is_none() {
        let names: Vec<&str> = forms.entries().map(|entry| entry.name.as_str()).collect();
        scope.unknown(&code::FIGURE, "job of this pass", &form.from.value, &form.from.place, &names);
    }
    let mut coordinate = |name: &Spanned<String>| {
        if let Some(input) = scope.input(&name.value) {
            return Some(Coordinate::Input(input));
        }
        if is_quantity(scope, &name.value) {
            return Some(Coordinate::Quantity(name.value.clone()));
        }
        let names: Vec<String> =
            scope.resolved.model.inputs.iter().map(|input| input.name.clone()).chain(names(scope)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        scope.unknown(&code::FIGURE, "input or quantity", &name.value, &name.place, &names);
        None
    };
    let [x, y] = &form.over;
    let (across, up) = (coordinate(x), coordinate(y));
    if x.value == y.value {
        let message = format!("both axes are `{}`", x.value);
        scope.error(&code::FIGURE, &y.place, message, "two axes, such as [\"V\", \"T_deck\"]");
    }
    if scope.diagnostics.errors() > before {
        return None;
    }
    Some(Contours { quantity: form.of.value.clone(), job: form.from.value.clone(), over: [across?, up?] })
}
