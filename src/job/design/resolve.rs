//! Designs of experiments: conditions, sensors and parameters looked up, settings with their defaults.

use super::form::{ConditionsForm, DesignForm, EstimatorForm, LimitsForm, SensorsForm};
use super::{DesignSensor, ErringInput, Estimator, Phase, Spec, Varied};
use crate::document::prior::Prior;
use crate::document::{Diagnostic, Map, MapEntry, Place, Sense, Spanned, code, counted};
use crate::measurement::{Sensor, Uncertain};
use crate::random::Distribution;
use crate::study::job::Entry;
use crate::study::pass::measurement::SensorForm;
use crate::study::pass::variable::SweepForm;
use crate::study::resolve::chosen::{errors, parameters, uncertain, with_errors};
use crate::study::resolve::design_variable::spaced;
use crate::study::resolve::plausible;
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::{Offered, environments, push_new};

/// Outer samples, inner samples, and draws where a job says nothing.
const OUTER: u64 = 4096;
const INNER: u64 = 1024;
const DRAWS: u64 = 32;
/// Most samples.
const MOST_SAMPLES: u64 = 1 << 20;
/// Probability of leaving red limits where a job says nothing.
const RED: f64 = 0.01;
/// Most candidates: all their readings are kept until they are judged.
const MOST_CANDIDATES: usize = 2000;
/// Most phases of a search.
const MOST_SEARCHED: u64 = 200;
/// Most phases of an experiment.
const MOST_PHASES: u64 = 20;

/// Resolves the settings of a design.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &DesignForm, offered: &Offered) -> Option<Spec> {
    let before = scope.diagnostics.errors();
    let all = uncertain(offered.priors).into_iter();
    let learn = match &form.learn {
        Some(names) => parameters(scope, names, offered.priors),
        None => {
            let named = form.nuisance.iter().flatten().filter_map(|name| scope.resolved.parameter(&name.value));
            let named: Vec<usize> = named.collect();
            // A surrogate's error is no parameter that an experiment could teach.
            let errors = errors(scope);
            all.clone().filter(|index| !named.contains(index) && !errors.contains(index)).collect()
        }
    };
    let nuisance = match &form.nuisance {
        Some(names) => {
            let chosen = parameters(scope, names, offered.priors);
            with_errors(scope, chosen, offered.priors)
        }
        None => all.filter(|index| !learn.contains(index)).collect(),
    };
    for name in form.nuisance.iter().flatten() {
        if form.learn.is_some() && scope.resolved.parameter(&name.value).is_some_and(|index| learn.contains(&index)) {
            let message = format!("`{}` is to be learnt and a nuisance", name.value);
            scope.error(&code::JOB_REFERENCE, &name.place, message, "it under `learn` or under `nuisance`");
        }
    }
    if learn.is_empty() && scope.diagnostics.errors() == before {
        let message = format!("`{}` has no parameter to learn", entry.name);
        scope.error(&code::JOB_REFERENCE, &entry.name_place, message, "a parameter whose prior is not fixed");
    }
    let base = match &form.environment {
        Some(name) => environments(scope, Some(&vec![name.clone()]), offered)
            .first()
            .map(|environment| environment.inputs.clone()),
        None => Some(scope.nominal_inputs()),
    };
    let base = base.map(|mut base| {
        for entry in &form.inputs {
            let Some(input) = scope.known_input(&entry.name, &entry.name_place) else { continue };
            if let Some(value) = scope.input_value(input, &entry.value) {
                base[input] = value;
            }
        }
        plausible::constants(scope, &form.inputs, &base);
        base
    });
    let conditions = base.and_then(|base| conditions(scope, &form.conditions, &base, offered));
    let sensors = sensors(scope, entry, form.sensors.as_ref(), offered);
    let choose_sensors = form.choose_sensors.as_ref().map(|wanted| {
        between(scope, wanted, 1, sensors.len().max(1) as u64, "sensors to choose");
        wanted.value
    });
    let outer = samples(scope, form.outer.as_ref(), OUTER, 256, MOST_SAMPLES, "outer samples");
    let inner = samples(scope, form.inner.as_ref(), INNER.min(outer / 2), 4, outer / 2, "inner samples");
    let draws = samples(scope, form.draws.as_ref(), DRAWS, 16, 1 << 12, "draws");
    let [red, yellow] = limits(scope, form.limits.as_ref());
    let pick = form.pick.as_ref().map_or(1, |pick| {
        between(scope, pick, 1, MOST_PHASES, "phases");
        pick.value
    });
    let search = form.search.as_ref().map_or(0, |search| {
        between(scope, search, 0, MOST_SEARCHED, "phases of a search");
        let is_range = conditions.as_ref().is_none_or(|given| {
            // What could not be read has been reported.
            given.is_grid && given.varied.iter().any(|axis| axis.values.len() > 1)
        });
        if search.value > 0 && !is_range {
            let message = "there is nothing between the candidates to search";
            let expected = "`conditions` as a grid with at least two values of an input";
            scope.error(&code::DESIGN_CONDITIONS, &search.place, message, expected);
        }
        search.value
    });
    let input_errors = (scope.resolved.input_errors.iter().enumerate())
        .filter_map(|(input, error)| {
            let bias = match &error.bias {
                Some(Prior::Distribution(prior)) => Some(*prior).filter(|prior| !prior.is_fixed()),
                _ => None,
            };
            let sigma = error.sigma.filter(|sigma| *sigma > 0.0);
            (sigma.is_some() || bias.is_some()).then_some(ErringInput { input, sigma, bias })
        })
        .collect();
    let estimator = match form.estimator {
        None | Some(EstimatorForm::Automatic) => Estimator::Automatic,
        Some(EstimatorForm::Nested) => Estimator::Nested,
        Some(EstimatorForm::Importance) => Estimator::Importance,
        Some(EstimatorForm::Laplace) => Estimator::Laplace,
        Some(EstimatorForm::Linear) => Estimator::Linear,
    };
    if scope.diagnostics.errors() > before {
        return None;
    }
    let Conditions { varied, candidates, is_grid } = conditions?;
    Some(Spec {
        learn,
        nuisance,
        varied,
        candidates,
        is_grid,
        sensors,
        input_errors,
        estimator,
        search,
        outer,
        inner,
        draws,
        red,
        yellow,
        pick,
        choose_sensors,
    })
}

struct Conditions {
    varied: Vec<Varied>,
    candidates: Vec<Phase>,
    is_grid: bool,
}

fn conditions(
    scope: &mut Scope,
    form: &Spanned<ConditionsForm>,
    base: &[f64],
    offered: &Offered,
) -> Option<Conditions> {
    let before = scope.diagnostics.errors();
    let conditions = match &form.value {
        ConditionsForm::Grid(axes) => grid(scope, axes, base, offered, &form.place),
        ConditionsForm::Phases(phases) => listed(scope, phases, base, offered),
    };
    let count = match &form.value {
        ConditionsForm::Grid(_) => conditions.candidates.len(),
        ConditionsForm::Phases(phases) => phases.len(),
    };
    if scope.diagnostics.errors() > before {
        return None;
    }
    if count == 0 || count > MOST_CANDIDATES {
        let message = counted(count, "candidate phase");
        let expected = format!("from 1 to {MOST_CANDIDATES} candidates");
        scope.error(&code::DESIGN_CONDITIONS, &form.place, message, &expected);
        return None;
    }
    Some(conditions)
}

fn grid(scope: &mut Scope, axes: &Map<SweepForm>, base: &[f64], offered: &Offered, place: &Place) -> Conditions {
    let mut varied: Vec<Varied> = Vec::new();
    for axis in axes {
        let Some(input) = settable(scope, &axis.name, &axis.name_place) else { continue };
        let scale = scope.resolved.input_scales[input].clone();
        let values: Vec<f64> = match &axis.value {
            SweepForm::List(list) => {
                // More are refused, once they are counted.
                let list = list.iter().take(MOST_CANDIDATES + 1);
                list.filter_map(|amount| scale.si(amount, Sense::Absolute, scope.diagnostics)).collect()
            }
            SweepForm::Steps(steps) => {
                let (from, to) = (&steps.from, &steps.to);
                let from = scale.si(from, Sense::Absolute, scope.diagnostics);
                let to = scale.si(to, Sense::Absolute, scope.diagnostics);
                let count = steps.steps.value;
                if !(2..=MOST_CANDIDATES).contains(&count) {
                    let message = format!("{} of `{}`", counted(count, "value"), axis.name);
                    let expected = format!("from 2 to {MOST_CANDIDATES} values");
                    scope.error(&code::DESIGN_CONDITIONS, &steps.steps.place, message, &expected);
                    continue;
                }
                from.zip(to).map(|(from, to)| spaced(from, to, count)).unwrap_or_default()
            }
        };
        for value in &values {
            within(scope, input, *value, offered, &axis.place);
        }
        if let Some(twice) = (1..values.len()).find(|&k| values[..k].contains(&values[k])) {
            let message = format!("value {} of `{}` stands twice", twice + 1, axis.name);
            scope.error(&code::DESIGN_CONDITIONS, &axis.place, message, "every value once");
        }
        if values.is_empty() {
            let message = format!("`{}` has no value", axis.name);
            scope.error(&code::DESIGN_CONDITIONS, &axis.place, message, "at least one value");
        }
        varied.push(Varied { input, values });
    }
    let count = varied.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.len()));
    if count.is_none_or(|count| count > MOST_CANDIDATES) {
        let expected = format!("at most {MOST_CANDIDATES} candidates");
        scope.error(&code::DESIGN_CONDITIONS, place, "the grid has too many candidate phases", &expected);
        return Conditions { varied, candidates: Vec::new(), is_grid: true };
    }
    let mut candidates = vec![Phase { inputs: base.to_vec() }];
    for axis in &varied {
        let with = |phase: &Phase, value: f64| {
            let mut phase = phase.clone();
            phase.inputs[axis.input] = value;
            phase
        };
        candidates =
            candidates.iter().flat_map(|phase| axis.values.iter().map(move |value| with(phase, *value))).collect();
    }
    if varied.is_empty() {
        candidates.clear();
    }
    Conditions { varied, candidates, is_grid: true }
}

fn listed(
    scope: &mut Scope,
    phases: &[Spanned<Map<crate::document::Amount>>],
    base: &[f64],
    offered: &Offered,
) -> Conditions {
    let (mut inputs, mut candidates): (Vec<usize>, Vec<Phase>) = (Vec::new(), Vec::new());
    // More are refused, once they are counted.
    for form in phases.iter().take(MOST_CANDIDATES + 1) {
        let mut phase = Phase { inputs: base.to_vec() };
        for entry in &form.value {
            let Some(input) = settable(scope, &entry.name, &entry.name_place) else { continue };
            push_new(&mut inputs, input);
            let scale = scope.resolved.input_scales[input].clone();
            if let Some(value) = scale.si(&entry.value, Sense::Absolute, scope.diagnostics) {
                within(scope, input, value, offered, &entry.value.place);
                phase.inputs[input] = value;
            }
        }
        if candidates.contains(&phase) {
            scope.error(&code::DESIGN_CONDITIONS, &form.place, "this phase stands twice", "every candidate once");
        }
        candidates.push(phase);
    }
    let varied = inputs.into_iter().map(|input| Varied { input, values: Vec::new() }).collect();
    Conditions { varied, candidates, is_grid: false }
}

/// An input that a test can set.
fn settable(scope: &mut Scope, name: &str, place: &Place) -> Option<usize> {
    if scope.resolved.parameter(name).is_some() {
        let message = format!("`{name}` is a parameter: an experiment sets inputs");
        scope.error(&code::DESIGN_CONDITIONS, place, message, "an input of the model");
        return None;
    }
    let input = scope.known_input(name, place)?;
    if !scope.resolved.model.inputs[input].settable {
        let message = format!("`{name}` is an input that a test cannot set");
        scope.error(&code::DESIGN_CONDITIONS, place, message, "an input without `\"settable\": false`");
        return None;
    }
    Some(input)
}

/// Reports a value outside the input's stated range.
fn within(scope: &mut Scope, input: usize, value: f64, offered: &Offered, place: &Place) {
    let model_input = &scope.resolved.model.inputs[input];
    let from_data = offered.ranges_from_data.contains(&model_input.name);
    if let Some([low, high]) = model_input.range.filter(|_| !from_data)
        && !(low..=high).contains(&value)
    {
        let unit = scope.resolved.input_scales[input].unit.clone();
        let shown = |si: f64| unit.as_ref().map_or(si, |unit| unit.from_si(si));
        let text = unit.as_ref().map_or("SI", |unit| unit.text.as_str());
        let message = format!("{} {text} lies outside the range of `{}`", shown(value), model_input.name);
        let expected = format!("from {} to {} {text}", shown(low), shown(high));
        scope.error(&code::DESIGN_CONDITIONS, place, message, &expected);
    }
}

fn sensors(
    scope: &mut Scope,
    entry: &Entry,
    form: Option<&Spanned<SensorsForm>>,
    offered: &Offered,
) -> Vec<DesignSensor> {
    let mut chosen = Vec::new();
    match form.map(|form| &form.value) {
        None => {
            for (_, sensor) in of_measurements(offered) {
                if !chosen.iter().any(|chosen_sensor: &DesignSensor| chosen_sensor.name == sensor.name) {
                    chosen.extend(known(scope, sensor, &entry.name_place, offered.priors));
                }
            }
            if chosen.is_empty() && scope.diagnostics.errors() == 0 {
                let message =
                    format!("`{}` has no sensors, and the pass has no measurement to take them from", entry.name);
                let expected =
                    "\"sensors\": {NAME: {\"measures\": NODE, \"sigma\": {\"value\": ..., \"unit\": \"K\"}}}";
                scope.error(&code::DESIGN_SENSOR, &entry.name_place, message, expected);
            }
        }
        Some(SensorsForm::Names(names)) => {
            for (place, name) in names.iter().enumerate() {
                if names[..place].iter().any(|other| other.value == name.value) {
                    let message = format!("the sensor `{}` stands twice", name.value);
                    scope.error(&code::DESIGN_SENSOR, &name.place, message, "every sensor once");
                    continue;
                }
                match of_measurements(offered).find(|(_, sensor)| sensor.name == name.value) {
                    Some((_, sensor)) => chosen.extend(known(scope, sensor, &name.place, offered.priors)),
                    None => {
                        let sensor_names: Vec<&str> =
                            of_measurements(offered).map(|(_, sensor)| sensor.name.as_str()).collect();
                        scope.unknown(&code::JOB_REFERENCE, "sensor", &name.value, &name.place, &sensor_names);
                    }
                }
            }
            if names.is_empty()
                && let Some(form) = form
            {
                scope.error(&code::DESIGN_SENSOR, &form.place, "an experiment without sensors", "at least one sensor");
            }
        }
        Some(SensorsForm::Own(sensors)) => {
            for sensor in sensors {
                chosen.extend(own(scope, sensor, offered.priors));
            }
            if sensors.is_empty()
                && let Some(form) = form
            {
                scope.error(&code::DESIGN_SENSOR, &form.place, "an experiment without sensors", "at least one sensor");
            }
        }
    }
    chosen
}

fn of_measurements<'a>(offered: &'a Offered) -> impl Iterator<Item = (&'a str, &'a Sensor)> {
    offered
        .data
        .iter()
        .flat_map(|measurement| measurement.sensors.iter().map(|sensor| (measurement.name.as_str(), sensor)))
}

fn bias(value: Option<&Uncertain>, priors: &[Distribution]) -> Option<Distribution> {
    match value? {
        Uncertain::Known(_) => None,
        Uncertain::Inferred(prior) | Uncertain::InferredFrom { prior, .. } => Some(*prior),
        Uncertain::Parameter { index, .. } => priors.get(*index).copied(),
    }
}

/// A sensor of a measurement.
fn known(scope: &mut Scope, sensor: &Sensor, place: &Place, priors: &[Distribution]) -> Option<DesignSensor> {
    let Some(sigma) = sensor.sigma.as_ref().map(Uncertain::nominal) else {
        no_sigma(scope, &sensor.name, place);
        return None;
    };
    let bias = bias(sensor.bias.as_ref(), priors);
    Some(DesignSensor { name: sensor.name.clone(), quantity: sensor.quantity, sigma, bias })
}

/// A sensor of the job.
fn own(scope: &mut Scope, entry: &MapEntry<SensorForm>, priors: &[Distribution]) -> Option<DesignSensor> {
    let form = &entry.value;
    let quantity = scope.quantity(&form.measures)?;
    let (dimension, _) = scope.quantity_form(quantity);
    let Some(written) = &form.sigma else {
        no_sigma(scope, &entry.name, &entry.name_place);
        return None;
    };
    let sigma = scope.uncertain(written, dimension, Sense::Difference, true)?.nominal();
    let error = match &form.bias {
        Some(form) => bias(scope.uncertain(form, dimension, Sense::Difference, false).as_ref(), priors),
        None => None,
    };
    Some(DesignSensor { name: entry.name.clone(), quantity, sigma, bias: error })
}

fn no_sigma(scope: &mut Scope, name: &str, place: &Place) {
    let message = format!("the sensor `{name}` has no `sigma`: without its noise nobody knows what it tells");
    scope.error(&code::DESIGN_SENSOR, place, message, "\"sigma\": {\"value\": 0.5, \"unit\": \"K\"}");
}

fn between(scope: &mut Scope, written: &Spanned<u64>, least: u64, most: u64, what: &str) -> bool {
    let fits = (least..=most).contains(&written.value);
    if !fits {
        let expected = format!("an integer from {least} to {most}");
        scope.error(&code::JOB_SETTING, &written.place, format!("{} {what}", written.value), &expected);
    }
    fits
}

/// A number of samples, rounded up to a power of two.
fn samples(scope: &mut Scope, written: Option<&Spanned<u64>>, default: u64, least: u64, most: u64, what: &str) -> u64 {
    let Some(written) = written else { return default };
    if !between(scope, written, least, most, what) {
        return default;
    }
    let rounded = written.value.next_power_of_two();
    if rounded != written.value {
        let message = format!("{} {what} are rounded up to {rounded}", written.value);
        let warning = Diagnostic::warning(&code::ROUNDED_SAMPLES, &written.place, message);
        scope.diagnostics.push(warning.help("write a power of two"));
    }
    rounded
}

fn limits(scope: &mut Scope, form: Option<&LimitsForm>) -> [Option<f64>; 2] {
    let Some(form) = form else { return [Some(RED), None] };
    let mut bound = |written: Option<&Spanned<f64>>| {
        written.map(|written| {
            if !(0.0..=1.0).contains(&written.value) {
                let message = format!("a probability of {}", written.value);
                scope.error(&code::JOB_SETTING, &written.place, message, "a probability from 0 to 1");
            }
            written.value
        })
    };
    [bound(form.red.as_ref()).or(Some(RED)), bound(form.yellow.as_ref())]
}
