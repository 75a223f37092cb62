//! Discrepancies: settings with their defaults, names looked up, data that allow one.

use super::Kind;
use super::form::{
    BeforehandForm, DiscrepancyForm, HyperparametersForm, HyperpriorForm, KernelForm, LawForm, ModeForm, TrendForm,
};
use super::output::{Law, Spec};
use crate::document::prior::{LognormalForm, PosteriorForm, PriorForm};
use crate::document::{Diagnostic, NameOr, Place, Sense, Spanned, canonical, code, counted, suggest};
use crate::expression::{Dimension, Unit};
use crate::inference::gaussian_process::hyperparameters::Beforehand;
use crate::inference::gaussian_process::{FEWEST_POINTS, Kernel, Trend};
use crate::job::kind::JobKind;
use crate::math::functions::ln;
use crate::measurement::{Measurement, Rows};
use crate::random::Distribution;
use crate::study::blocked::blocked;
use crate::study::job::{Asked, CALIBRATION, Entry, JobSpec};
use crate::study::resolve::chosen::data;
use crate::study::resolve::plausible::in_own_unit;
use crate::study::resolve::posterior_prior;
use crate::study::resolve::scope::{Scope, unit_of};
use crate::study::resolve::settings::{number, push_new};
use crate::study::resolved::{Blocked, Upstream};

/// Kind of the jobs that seek physical effects.
const DIAGNOSIS: &str = "diagnose";
/// Draws of the calibration where a job says nothing.
const DRAWS: u64 = 200;

/// Resolves the settings of a discrepancy.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &DiscrepancyForm, asked: &mut Asked) -> Option<JobSpec> {
    let (before, offered) = (scope.diagnostics.errors(), asked.offered);
    let joint = form.mode.as_ref().filter(|mode| mode.value == ModeForm::Joint).map(|mode| &mode.place);
    if joint.is_some() {
        settings_of_joint(scope, form);
    }
    let maximum = form.hyperparameters.as_ref().filter(|own| own.value == HyperparametersForm::Maximum);
    if let Some(priors) = form.priors.as_ref().filter(|_| maximum.is_some()) {
        let message = "`priors` do nothing where hyperparameters are those of the highest marginal likelihood";
        scope.error(&code::DISCREPANCY, &priors.place, message, "`\"hyperparameters\": \"sampled\"`, or no `priors`");
    }
    let (mut chosen, missing) = data(scope, entry, form.data.as_ref(), "take residuals of", offered);
    // An erroneous measurement has a position that nothing has.
    chosen.retain(|&position| position < offered.data.len());
    let is_steady = |&position: &usize| matches!(offered.data[position].rows, Rows::Steady(_));
    let places: Vec<Place> = form.data.iter().flatten().map(|name| name.place.clone()).collect();
    let place = places.first().unwrap_or(&entry.name_place).clone();
    if let Some(transient) = chosen.iter().find(|position| !is_steady(position)) {
        if form.data.is_some() || !chosen.iter().any(is_steady) {
            let transient = &offered.data[*transient];
            let message = format!("`{}` is a transient", transient.name);
            let known = transient.sensors.first().map(|sensor| &scope.resolved.model.quantities[sensor.quantity]);
            let size = known.map_or_else(String::new, |quantity| {
                let (name, unit) = (canonical::quoted(&quantity.name), canonical::quoted(&quantity.unit));
                format!(
                    "; or leave this job out, and let predictions add a standard deviation to what the sensors measure: {{\"predict\": \
                     {{\"quantities\": [{name}], \"with\": {{\"discrepancy\": {{{name}: {{\"value\": 1, \"unit\": {unit}}}}}}}}}}}"
                )
            });
            let diagnostic = Diagnostic::error(&code::DISCREPANCY, &place, message)
                .expected("steady phases: residuals of neighbouring instants are no independent ones")
                .help(format!("cut steady phases from it (`windows` of a steady measurement){size}"));
            scope.diagnostics.push(diagnostic);
            return None;
        }
        chosen.retain(is_steady);
    }
    let calibration = calibration(scope, entry, form.from.as_ref(), asked)?;
    let measurements: Vec<&Measurement> = chosen.iter().map(|&position| &offered.data[position]).collect();
    if scope.diagnostics.errors() > before {
        return None;
    }
    if !missing.is_empty() {
        return Some(JobSpec::Waiting { kind: Kind::NAME, measurements: missing, command: offered.command.clone() });
    }
    let sensors = sensors(scope, entry, form, &measurements);
    let inputs = inputs(scope, form, &measurements);
    let beforehand = match &form.priors {
        Some(written) => beforehand(scope, written, &measurements, &sensors, &inputs),
        None => Beforehand::default(),
    };
    let law = form.law.as_ref().and_then(|law| match law.value {
        LawForm::Automatic => None,
        LawForm::None => Some(Law::None),
        LawForm::Constant => Some(Law::Constant),
        LawForm::ResidualLaw => Some(Law::ResidualLaw),
        LawForm::GaussianProcess => Some(Law::GaussianProcess),
    });
    points(scope, entry, form, joint, &measurements, &inputs);
    let draws = number(scope, form.draws.as_ref(), DRAWS, 20, 1000, "draws");
    if scope.diagnostics.errors() > before {
        return None;
    }
    let (upstream, source, blocked) = calibration;
    Some(JobSpec::of(Spec {
        data: chosen,
        calibration: upstream,
        source,
        blocked,
        sensors,
        inputs,
        kernel: match form.kernel {
            Some(KernelForm::Matern52) => Kernel::Matern52,
            Some(KernelForm::SquaredExponential) | None => Kernel::SquaredExponential,
        },
        trend: match form.trend {
            Some(TrendForm::None) => Trend::None,
            Some(TrendForm::Linear) => Trend::Linear,
            None if joint.is_some() => Trend::None,
            Some(TrendForm::Constant) | None => Trend::Constant,
        },
        law,
        sampled: maximum.is_none(),
        beforehand,
        is_joint: joint.is_some(),
        draws,
        diagnosis: asked.forms.of_kind(DIAGNOSIS).first().map(|name| (*name).to_owned()),
    }))
}

/// Refuses what the mode `joint` does not take.
fn settings_of_joint(scope: &mut Scope, form: &DiscrepancyForm) {
    if let Some(NameOr::Other(from)) = &form.from {
        let message = "the mode `joint` infers the parameters of its calibration anew, and this one is of another pass";
        scope.error(&code::DISCREPANCY, &from.place, message, "a `calibrate` job of this pass");
    }
    if let Some(own) = form.hyperparameters.as_ref().filter(|own| own.value == HyperparametersForm::Maximum) {
        let message = "the mode `joint` draws hyperparameters together with the parameters";
        scope.error(&code::DISCREPANCY, &own.place, message, "no `hyperparameters`, or `\"sampled\"`");
    }
    if let Some(law) = form.law.as_ref().filter(|law| law.value == LawForm::None) {
        let message = "without a discrepancy there is nothing to infer together with the parameters";
        scope.error(
            &code::DISCREPANCY,
            &law.place,
            message,
            "`\"gaussian-process\"`, `\"residual-law\"` or `\"constant\"`",
        );
    }
}

/// What is known beforehand, in SI and in widths of the range of each input over the phases that are fitted.
fn beforehand(
    scope: &mut Scope,
    written: &Spanned<BeforehandForm>,
    measurements: &[&Measurement],
    sensors: &[String],
    inputs: &[usize],
) -> Beforehand {
    let BeforehandForm { standard_deviation, lengths, scatter } = &written.value;
    let of_sensors = measurements.iter().flat_map(|measurement| &measurement.sensors);
    // A sensor a unit, in the order of the sensors.
    let mut units: Vec<(&str, Unit)> = Vec::new();
    for sensor in of_sensors.filter(|sensor| sensors.contains(&sensor.name)) {
        let unit = unit_of(&scope.resolved.model.quantities[sensor.quantity].unit);
        if units.iter().all(|(_, other)| other.dimension != unit.dimension) {
            units.push((&sensor.name, unit));
        }
    }
    let unit = match units.as_slice() {
        [(_, unit)] => unit,
        // Without sensors something else is wrong, which has been reported.
        [] => return Beforehand::default(),
        [(first, unit), (second, other), ..] => {
            let message = format!(
                "`{first}` is measured in {} and `{second}` in {}: they have no prior of a discrepancy in common",
                unit.text, other.text
            );
            let diagnostic = Diagnostic::error(&code::DISCREPANCY, &written.place, message)
                .expected("sensors of one unit")
                .help(format!("name those of one unit under `sensors`, such as [\"{first}\"], and the others in a job of their own"));
            scope.diagnostics.push(diagnostic);
            return Beforehand::default();
        }
    };
    // Of the variance: twice that of the standard deviation.
    let dimension = unit.dimension;
    let mut variance = |form: &Option<HyperpriorForm>| {
        let HyperpriorForm::Lognormal(form) = form.as_ref()?;
        logarithm(scope, form, None, dimension).map(|[mean, sd]| [2.0 * mean, 2.0 * sd])
    };
    let (variance, scatter) = (variance(standard_deviation), variance(scatter));
    let mut known = Beforehand { variance, lengths: vec![None; inputs.len()], scatter };
    for length in lengths.iter().flatten() {
        let Some(input) = scope.known_input(&length.name, &length.name_place) else { continue };
        let Some(place) = inputs.iter().position(|own| *own == input) else {
            let message = format!(
                "the discrepancy does not depend on `{}`: {}",
                length.name,
                why_not(scope, input, measurements)
            );
            let expected = one_that_varies(scope, inputs);
            scope.error(&code::DISCREPANCY, &length.name_place, message, &expected);
            continue;
        };
        let unit = unit_of(&scope.resolved.model.inputs[input].unit);
        let phases = measurements.iter().flat_map(|measurement| fitted_phases(measurement));
        let [low, high] = phases
            .map(|(_, inputs)| inputs[input])
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
        let HyperpriorForm::Lognormal(form) = &length.value;
        let own = logarithm(scope, form, Some(&unit), unit.dimension);
        known.lengths[place] = own.map(|[mean, sd]| [mean - ln(high - low), sd]);
    }
    known
}

/// Why a discrepancy does not depend on an input: it has one value in all fitted phases, or `inputs` does not name it.
fn why_not(scope: &Scope, input: usize, measurements: &[&Measurement]) -> String {
    let mut values =
        measurements.iter().flat_map(|measurement| fitted_phases(measurement)).map(|(_, inputs)| inputs[input]);
    match values.next() {
        Some(first) if values.all(|value| value == first) => {
            format!("it is {} in all phases that are fitted", in_own_unit(scope, input, first))
        }
        _ => "it is not among its `inputs`".to_owned(),
    }
}

/// The inputs that a discrepancy can depend on.
fn one_that_varies(scope: &Scope, inputs: &[usize]) -> String {
    let names: Vec<&str> = inputs.iter().map(|&input| scope.resolved.model.inputs[input].name.as_str()).collect();
    match names.as_slice() {
        [] => "an input that the phases vary; none does".to_owned(),
        names => format!("one that the phases vary: {}", suggest::listed(names.iter().copied(), 12)),
    }
}

/// Mean and standard deviation of the logarithm, SI.
fn logarithm(
    scope: &mut Scope,
    form: &Spanned<LognormalForm>,
    unit: Option<&Unit>,
    dimension: Dimension,
) -> Option<[f64; 2]> {
    let prior = PriorForm::Lognormal(form.clone()).resolve(unit, dimension, Sense::Difference, scope.diagnostics)?;
    match prior.distribution()? {
        Distribution::LogNormal { median, factor } => Some([ln(*median), ln(*factor)]),
        _ => None,
    }
}

/// The calibration, in words, and why it does not run where it is another pass's.
fn calibration(
    scope: &mut Scope,
    entry: &Entry,
    written: Option<&NameOr<crate::document::Spanned<PosteriorForm>>>,
    asked: &mut Asked,
) -> Option<(Upstream, String, Option<Blocked>)> {
    let own = |name: &str| {
        let upstream = Upstream { file: asked.offered.file.to_owned(), job: name.to_owned() };
        Some((upstream, format!("`{name}`"), None))
    };
    let calibrations = asked.forms.of_kind(CALIBRATION);
    match written {
        Some(NameOr::Other(from)) => {
            let PosteriorForm { pass: file, job } = &from.value;
            let pass = asked.upstreams.pass(scope, &file.value, &file.place)?;
            posterior_prior::calibration(scope, &pass, &job.value, &job.place)?;
            let upstream = Upstream { file: pass.file.clone(), job: job.value.clone() };
            Some((upstream, format!("`{}` of `{}`", job.value, pass.file), blocked(&pass, &job.value)))
        }
        Some(NameOr::Name(name)) if calibrations.contains(&name.value.as_str()) => own(&name.value),
        Some(NameOr::Name(name)) => {
            match asked.forms.kind(&name.value) {
                Some(other) => {
                    let message = format!("`{}` is a `{other}` job", name.value);
                    scope.error(&code::DISCREPANCY, &name.place, message, "a `calibrate` job");
                }
                None => scope.unknown(&code::DISCREPANCY, "calibration", &name.value, &name.place, &calibrations),
            }
            None
        }
        None => match calibrations.as_slice() {
            [only] => own(only),
            several => {
                let count = several.len();
                let message =
                    format!("`{}` does not say `from` which calibration, and the pass has {count}", entry.name);
                let expected = match several {
                    [] => "\"from\": {\"pass\": \"pass-1.json\", \"job\": ...}".to_owned(),
                    several => format!("\"from\": one of {}", several.join(", ")),
                };
                scope.error(&code::DISCREPANCY, &entry.name_place, message, &expected);
                None
            }
        },
    }
}

/// Phases that calibration and law may use.
fn fitted_phases(measurement: &Measurement) -> impl Iterator<Item = (usize, &[f64])> {
    let phases = match &measurement.rows {
        Rows::Steady(phases) => phases.as_slice(),
        Rows::Transient { .. } => &[],
    };
    phases
        .iter()
        .enumerate()
        .filter(move |(row, _)| measurement.is_fitted(*row))
        .map(|(row, phase)| (row, phase.inputs.as_slice()))
}

/// The sensors asked for, each with enough readings.
fn sensors(scope: &mut Scope, entry: &Entry, form: &DiscrepancyForm, measurements: &[&Measurement]) -> Vec<String> {
    let readings = |name: &str| -> usize {
        let of = |measurement: &&Measurement| {
            let position = measurement.sensors.iter().position(|sensor| sensor.name == name);
            position.map_or(0, |position| {
                fitted_phases(measurement).filter(|(row, _)| measurement.reading(*row, position).is_some()).count()
            })
        };
        measurements.iter().map(of).sum()
    };
    let mut known: Vec<&str> = Vec::new();
    for sensor in measurements.iter().flat_map(|measurement| &measurement.sensors) {
        if !known.contains(&sensor.name.as_str()) {
            known.push(&sensor.name);
        }
    }
    let Some(names) = &form.sensors else {
        let enough: Vec<String> =
            known.iter().filter(|name| readings(name) >= FEWEST_POINTS).map(|name| (*name).to_owned()).collect();
        if enough.is_empty() {
            let most = known.iter().map(|name| readings(name)).max().unwrap_or(0);
            let message = format!("no sensor has more than {} in phases that are fitted", counted(most, "reading"));
            let expected =
                format!("{FEWEST_POINTS} readings of a sensor or more: with fewer nothing is said of a discrepancy");
            scope.error(&code::DISCREPANCY, &entry.name_place, message, &expected);
        }
        return enough;
    };
    let mut chosen: Vec<String> = Vec::new();
    for name in names {
        if !known.contains(&name.value.as_str()) {
            scope.unknown(&code::DISCREPANCY, "sensor of these data", &name.value, &name.place, &known);
        } else if readings(&name.value) < FEWEST_POINTS {
            let count = counted(readings(&name.value), "reading");
            let message = format!("`{}` has {count} in phases that are fitted", name.value);
            let expected = format!("{FEWEST_POINTS} or more: with fewer nothing is said of a discrepancy");
            scope.error(&code::DISCREPANCY, &name.place, message, &expected);
        } else if !chosen.contains(&name.value) {
            chosen.push(name.value.clone());
        }
    }
    chosen
}

/// The inputs asked for, each of which must vary; all that vary where none are named.
fn inputs(scope: &mut Scope, form: &DiscrepancyForm, measurements: &[&Measurement]) -> Vec<usize> {
    let varies = |input: usize| {
        let mut values =
            measurements.iter().flat_map(|measurement| fitted_phases(measurement)).map(|(_, inputs)| inputs[input]);
        let first = values.next();
        values.any(|value| Some(value) != first)
    };
    let Some(names) = &form.inputs else {
        let model = &scope.resolved.model;
        return (0..model.inputs.len()).filter(|&input| !model.clocks.has(input) && varies(input)).collect();
    };
    let varying: Vec<usize> = (0..scope.resolved.model.inputs.len()).filter(|&input| varies(input)).collect();
    let mut chosen = Vec::new();
    for name in names {
        let Some(input) = scope.known_input(&name.value, &name.place) else { continue };
        if varying.contains(&input) {
            push_new(&mut chosen, input);
        } else {
            let message =
                format!("`{}` cannot explain a discrepancy: {}", name.value, why_not(scope, input, measurements));
            let expected = one_that_varies(scope, &varying);
            scope.error(&code::DISCREPANCY, &name.place, message, &expected);
        }
    }
    chosen
}

/// That no input varies, with the value of each.
fn nothing_varies(scope: &Scope, measurements: &[&Measurement]) -> String {
    let names: Vec<&str> = measurements.iter().map(|measurement| measurement.name.as_str()).collect();
    let mut phases = measurements.iter().flat_map(|measurement| fitted_phases(measurement));
    let first = phases.next().map(|(_, inputs)| inputs).unwrap_or_default();
    let values: Vec<String> = (first.iter().zip(&scope.resolved.model.inputs).enumerate())
        .map(|(input, (value, own))| format!("`{}` is {}", own.name, in_own_unit(scope, input, *value)))
        .collect();
    let several = if phases.next().is_some() { "every phase" } else { "the only phase" };
    format!(
        "no input varies over the phases of {} that are fitted: in {several} {}",
        suggest::listed(names.iter().copied(), 4),
        values.join(", ")
    )
}

/// Says where phases coincide, and refuses a Gaussian process that is asked for and has too few places.
fn points(
    scope: &mut Scope,
    entry: &Entry,
    form: &DiscrepancyForm,
    joint: Option<&Place>,
    measurements: &[&Measurement],
    inputs: &[usize],
) {
    let mut places: Vec<(Vec<f64>, String)> = Vec::new();
    let mut same = None;
    for measurement in measurements {
        let Rows::Steady(phases) = &measurement.rows else { continue };
        for (row, values) in fitted_phases(measurement) {
            let at: Vec<f64> = inputs.iter().map(|&input| values[input]).collect();
            match places.iter().find(|(other, _)| *other == at) {
                Some((_, first)) => same = same.or_else(|| Some([first.clone(), phases[row].name.clone()])),
                None => places.push((at, phases[row].name.clone())),
            }
        }
    }
    let asked_for = match &form.law {
        Some(law) if law.value == LawForm::GaussianProcess => Some(&law.place),
        Some(law) if law.value == LawForm::Automatic => joint,
        Some(_) => None,
        None => joint,
    };
    if let Some(place) = asked_for.filter(|_| places.len() < FEWEST_POINTS || inputs.is_empty()) {
        let message = match same {
            _ if inputs.is_empty() => nothing_varies(scope, measurements),
            Some([first, second]) => format!(
                "the phases have {} of the inputs: `{first}` and `{second}` have the same",
                counted(places.len(), "different set")
            ),
            None => format!("the fit has {}", counted(places.len(), "phase")),
        };
        let diagnostic = Diagnostic::error(&code::DISCREPANCY, place, message)
            .expected(format!("{FEWEST_POINTS} different ones or more for a Gaussian process"))
            .help("with fewer write \"law\": \"residual-law\", scatter that no input explains, or \"constant\"");
        scope.diagnostics.push(diagnostic);
    } else if let Some([first, second]) = same.filter(|_| !inputs.is_empty()) {
        let message =
            format!("the phases `{first}` and `{second}` have the same values of the inputs of the discrepancy");
        let help = "they count as repetitions, whose difference only noise and scatter explain: name a further input if they \
                    differ in one";
        let place = form.inputs.as_ref().and_then(|names| names.first()).map_or(&entry.name_place, |name| &name.place);
        scope.diagnostics.push(Diagnostic::warning(&code::DISCREPANCY, place, message).help(help));
    }
}
