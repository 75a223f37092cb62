//! Adopted effects: looked up, placed, given their parameters, and applied to the model and to the measurements.

use crate::document::{Diagnostics, Map, MapEntry, Place, Sense, code};
use crate::effect::{
    Applied, Bound, Catalogue, Effect, Instance, PlaceKind, REFERENCE_K, SensorChange, SensorPlace, apply,
};
use crate::expression::unit::CELSIUS_ZERO_K;
use crate::expression::{Dimension, Unit};
use crate::measurement::{Measurement, Rows, sensor_places};
use crate::random::Distribution;
use crate::study::folder::Folder;
use crate::study::inherit::unnamed_file_diagnostic;
use crate::study::model::Scale;
use crate::study::pass::PassForm;
use crate::study::pass::adopt::{Adopted, EffectUse};
use crate::study::pass::measurement::{MeasurementForm, SensorForm};
use crate::study::requirement::Environment;
use crate::study::resolved::{AdoptedEffect, Evidence};
use crate::thermal::Input;

use super::adopt_parameter::parameters;
use super::adopt_place::{Placed, bound, place};
use super::parts::belongs_to;
use super::scope::Scope;

/// Folder of a study's own effects.
const FOLDER: &str = "effects";

/// The program's effects and the study's own, which replace those of the same name; beside them the JSON of the
/// study's own, which is part of its definition.
pub fn catalogue(folder: &Folder, diagnostics: &mut Diagnostics) -> (Catalogue, Vec<(String, serde_json::Value)>) {
    let mut catalogue = Catalogue::embedded(diagnostics);
    let mut study_effects = Vec::new();
    for name in folder.json_names(FOLDER) {
        let file = own_file(&name);
        let bytes = match folder.read(&file) {
            Ok(bytes) => bytes,
            Err(error) => {
                diagnostics.push(unnamed_file_diagnostic(folder, &file, &error));
                continue;
            }
        };
        let node = catalogue.read(&name, &folder.shown_name(&file), &bytes, diagnostics);
        study_effects.extend(node.map(|node| (name, node.to_json())));
    }
    catalogue.check(diagnostics);
    (catalogue, study_effects)
}

/// The file of a study's own effect within the study.
pub fn own_file(name: &str) -> String {
    format!("{FOLDER}/{name}.json")
}

/// What has been adopted.
#[derive(Debug, Default)]
pub struct Adoption {
    /// Effects in the order in which they were applied.
    pub adopted: Vec<AdoptedEffect>,
    /// Priors of their parameters, SI, in the model's order.
    pub priors: Vec<Distribution>,
    /// Inputs that are 1 where an effect is there: index, and the names of measurements and environments.
    switches: Vec<(usize, Vec<String>)>,
}

/// Applies the effects that act on the model. Those on sensors wait for the measurements.
pub fn adopt(scope: &mut Scope, form: &PassForm, catalogue: &Catalogue) -> Adoption {
    let mut adoption = Adoption::default();
    if let (Some(entry), Some(_)) = (form.adopt.iter().next(), &scope.resolved.external) {
        let message = "effects act on nodes and elements, and this model is asked outside";
        scope.error(&code::EXTERNAL_MODEL, &entry.name_place, message, "a pass without `adopt`");
        return adoption;
    }
    for entry in &form.adopt {
        scope.reason(&entry.value.because);
        check_evidence(scope, &entry.value);
        check_applies_to(scope, form, &entry.value);
        let Some((effect, usage)) = effect(scope, entry, catalogue) else { continue };
        if !of_sensors(effect) {
            let applied = adoption.adopt_one(scope, entry, effect, usage, &[]);
            note_starts(scope, form, entry, applied.as_ref());
        } else if let Some(start) = entry.value.starts.iter().next() {
            adds_no_node(scope, &entry.name, &start.name_place);
        }
    }
    adoption
}

/// Whether an adopted effect depends on when readings were taken.
pub fn depends_on_time(folder: &Folder, form: &PassForm) -> bool {
    let (catalogue, _) = catalogue(folder, &mut Diagnostics::new());
    let mut used = form.adopt.iter().flat_map(|entry| entry.value.effect.iter());
    used.any(|usage| catalogue.get(&usage.name).is_some_and(Effect::depends_on_time))
}

/// Whether an effect acts on sensors, and on no node or element.
pub fn of_sensors(effect: &Effect) -> bool {
    effect.places.iter().any(|place| matches!(place, PlaceKind::Sensor | PlaceKind::SensorPair))
}

/// The effect that an entry names.
fn effect<'c, 'f>(
    scope: &mut Scope,
    entry: &'f MapEntry<Adopted>,
    catalogue: &'c Catalogue,
) -> Option<(&'c Effect, &'f MapEntry<EffectUse>)> {
    let mut named = entry.value.effect.iter();
    let (Some(usage), None) = (named.next(), named.next()) else {
        let message = format!("`{}` adopts {} effects", entry.name, entry.value.effect.len());
        scope.error(&code::ONE_KIND, &entry.place, message, "an object with one key, the effect's name");
        return None;
    };
    let effect = catalogue.get(&usage.name);
    // What is wrong with a file of the study's own was said at its place.
    if effect.is_none() && !scope.folder.has_file(&own_file(&usage.name)) {
        let effect_names: Vec<&str> = catalogue.names().collect();
        scope.unknown(&code::UNKNOWN_EFFECT, "effect", &usage.name, &usage.name_place, &effect_names);
    }
    Some((effect?, usage))
}

/// Reference temperature of an effect, K. `None` after an error.
fn reference_k(scope: &mut Scope, effect: &Effect, usage: &EffectUse) -> Option<f64> {
    let Some(written) = &usage.reference else { return Some(REFERENCE_K) };
    if !effect.has_reference() {
        let message = format!("the law of `{}` has no reference temperature", effect.name);
        scope.error(&code::EFFECT_PARAMETER, &written.place, message, "no `reference`");
        return None;
    }
    let kelvin = Unit::si(Dimension::TEMPERATURE);
    let reference_k = written.si(kelvin.dimension, Some(&kelvin), Sense::Absolute, scope.diagnostics)?;
    if reference_k > 0.0 {
        return Some(reference_k);
    }
    let message = format!("a reference temperature of {reference_k} K");
    let expected = "a temperature above 0 K, such as {\"value\": 20, \"unit\": \"degC\"}";
    scope.error(&code::OUT_OF_RANGE, &written.place, message, expected);
    None
}

/// A reference temperature in degC, to a hundredth.
pub fn in_celsius(reference_k: f64) -> f64 {
    (100.0 * (reference_k - CELSIUS_ZERO_K)).round() / 100.0
}

/// An effect's equation, with the reference temperature if it has one.
fn equation(effect: &Effect, reference_k: f64) -> String {
    let law = effect.form.equation.clone().unwrap_or_default();
    if law.is_empty() || !effect.has_reference() {
        return law;
    }
    format!("{law}, Tr = {} degC", in_celsius(reference_k))
}

fn check_evidence(scope: &mut Scope, form: &Adopted) {
    let Some(evidence) = &form.evidence else { return };
    if let Err(error) = scope.folder.read(&evidence.pass.value) {
        let diagnostic = super::folder_diagnostic_at(&error, &evidence.pass.place);
        scope.diagnostics.push(diagnostic);
    }
    if let Some(probability) = evidence.probability.as_ref().filter(|own| !(0.0..=1.0).contains(&own.value)) {
        let message = format!("a probability of {}", probability.value);
        scope.error(&code::OUT_OF_RANGE, &probability.place, message, "a number from 0 to 1");
    }
}

/// What supports an adopted effect.
fn evidence(form: &Adopted) -> Option<Evidence> {
    form.evidence.as_ref().map(|own| Evidence {
        pass: own.pass.value.clone(),
        job: own.job.value.clone(),
        probability: own.probability.as_ref().map(|probability| probability.value),
        sd: own.sd.iter().map(|entry| (entry.name.clone(), entry.value)).collect(),
    })
}

/// The start temperatures of the nodes that an effect adds.
fn note_starts(scope: &mut Scope, form: &PassForm, entry: &MapEntry<Adopted>, applied: Option<&Applied>) {
    for start in &entry.value.starts {
        let transients: Vec<&str> = (form.measurements.iter())
            .filter(|one| matches!(one.value, MeasurementForm::Transient(_)))
            .map(|one| one.name.as_str())
            .collect();
        if !transients.contains(&start.name.as_str()) {
            scope.unknown(&code::UNKNOWN_NAME, "transient measurement", &start.name, &start.name_place, &transients);
            continue;
        }
        let applies =
            entry.value.applies_to.as_ref().is_none_or(|names| names.iter().any(|own| own.value == start.name));
        if !applies {
            let message = format!("`{}` does not apply to `{}`", entry.name, start.name);
            scope.error(&code::INITIAL, &start.name_place, message, "a measurement under `applies_to`");
        }
        let value = scope.uncertain(&start.value, Dimension::TEMPERATURE, Sense::Absolute, true);
        let (Some(value), Some(applied)) = (value, applied) else { continue };
        if applied.nodes.is_empty() {
            adds_no_node(scope, &entry.name, &start.name_place);
        }
        scope.starts.extend(applied.nodes.iter().map(|&(node, _)| (start.name.clone(), node, value.clone())));
    }
}

fn adds_no_node(scope: &mut Scope, name: &str, place: &Place) {
    let message = format!("`{name}` adds no node that could start at a temperature");
    scope.error(&code::INITIAL, place, message, "no `starts`");
}

fn check_applies_to(scope: &mut Scope, form: &PassForm, adopted: &Adopted) {
    let listed_names: Vec<&str> = form.measurements.names().chain(form.environments.names()).collect();
    for name in adopted.applies_to.iter().flatten() {
        if !listed_names.contains(&name.value.as_str()) {
            scope.unknown(&code::UNKNOWN_NAME, "measurement or environment", &name.value, &name.place, &listed_names);
        }
    }
}

impl Adoption {
    /// Applies an effect to the model.
    fn adopt_one(
        &mut self,
        scope: &mut Scope,
        entry: &MapEntry<Adopted>,
        effect: &Effect,
        usage: &MapEntry<EffectUse>,
        sensors: &[SensorPlace],
    ) -> Option<Applied> {
        scope.drawn.clear();
        let placed = place(scope, effect, usage, sensors)?;
        let bound = bound(scope, effect, usage, placed.node.as_ref())?;
        let reference_k = reference_k(scope, effect, &usage.value)?;
        let parameters = parameters(scope, effect, &usage.value, &bound)?;
        let applies_to = entry.value.applies_to.as_ref();
        let switch = match applies_to {
            Some(names) if !of_sensors(effect) => {
                let index = add_switch(scope, &entry.name);
                self.switches.push((index, names.iter().map(|name| name.value.clone()).collect()));
                Some(index)
            }
            _ => None,
        };
        let inputs = effect.form.inputs.iter().zip(&bound).filter(|(entry, _)| entry.value.clock().is_none());
        let inputs = inputs.map(|(entry, bound)| (entry.name.clone(), bound.name(&scope.resolved.model).to_owned()));
        let inputs: Vec<(String, String)> = inputs.collect();
        let id = id(effect, &placed, &bound, &inputs);
        let instance =
            Instance { name: &entry.name, effect, site: placed.site, bound, parameters, reference_k, switch };
        let applied = match apply(&mut scope.resolved.model, &instance) {
            Ok(applied) => applied,
            Err(error) => {
                scope.error(&code::EFFECT_PLACE, &usage.name_place, error.to_string(), "");
                return None;
            }
        };
        let parameters = instance.parameters;
        scope.resolved.note_additions(parameters.iter().map(|parameter| (parameter.unit.clone(), parameter.prior)));
        for (name, drawn) in std::mem::take(&mut scope.drawn) {
            if let Some(place) = parameters.iter().position(|parameter| parameter.name == name) {
                scope.resolved.priors[applied.first_parameter + place] = drawn;
            }
        }
        scope.hosts.extend(&applied.nodes);
        scope.given_storage.extend(&applied.given_storage);
        self.priors.extend(parameters.iter().map(|parameter| parameter.prior));
        self.adopted.push(AdoptedEffect {
            name: entry.name.clone(),
            id,
            effect: effect.name.clone(),
            title: effect.form.title.clone(),
            equation: equation(effect, reference_k),
            source: crate::document::source_text(&effect.form.source, effect.form.evidence),
            file: None,
            place: placed.names,
            inputs,
            parameters: applied.first_parameter..applied.first_parameter + parameters.len(),
            because: entry.value.because.value.clone(),
            evidence: evidence(&entry.value),
            applies_to: applies_to.into_iter().flatten().map(|name| name.value.clone()).collect(),
            is_of_readings: of_sensors(effect),
        });
        Some(applied)
    }

    /// Applies the effects that act on sensors.
    pub fn adopt_at_sensors(
        &mut self,
        scope: &mut Scope,
        form: &PassForm,
        catalogue: &Catalogue,
        measurements: &mut [Measurement],
    ) {
        let is_resolved = |name: &str| measurements.iter().any(|measurement| measurement.name == name);
        let absent = form.measurements.iter().filter(|entry| !is_resolved(&entry.name));
        let absent: Vec<&Map<SensorForm>> = absent.map(|entry| entry.value.sensors()).collect();
        for entry in &form.adopt {
            // What is wrong with its name was said before.
            let used_effect =
                entry.value.effect.iter().next().and_then(|usage| Some((catalogue.get(&usage.name)?, usage)));
            let Some((effect, usage)) = used_effect.filter(|(effect, _)| of_sensors(effect)) else { continue };
            let has = |name: &str| match &entry.value.applies_to {
                Some(names) => names.iter().any(|wanted| belongs_to(name, &wanted.value)),
                None => true,
            };
            let sensors = sensor_places(measurements.iter().filter(|measurement| has(&measurement.name)));
            if sensors.is_empty() && !form.measurements.is_empty() && measurements.len() < form.measurements.len() {
                // The data of a measurement are missing or wrong, and its sensors with them.
                continue;
            }
            let is_here = |name: &str| sensors.iter().any(|sensor| sensor.name == name);
            let is_absent = |name: &str| !is_here(name) && absent.iter().any(|form| form.get(name).is_some());
            if usage.value.names().any(is_absent) {
                continue;
            }
            let Some(applied) = self.adopt_one(scope, entry, effect, usage, &sensors) else { continue };
            for measurement in measurements.iter_mut().filter(|measurement| has(&measurement.name)) {
                for change in &applied.sensors {
                    change_sensors(scope, measurement, change, &usage.name_place);
                }
            }
        }
    }

    /// Sets the inputs that say where effects are there.
    pub fn switch_on(&self, measurements: &mut [Measurement], environments: &mut [Environment]) {
        for (input, names) in &self.switches {
            let has = |measurement: &&mut Measurement| names.iter().any(|name| belongs_to(&measurement.name, name));
            for measurement in measurements.iter_mut().filter(has) {
                match &mut measurement.rows {
                    Rows::Steady(phases) => phases.iter_mut().for_each(|phase| phase.inputs[*input] = 1.0),
                    Rows::Transient { inputs, .. } => inputs.base[*input] = 1.0,
                }
            }
            for environment in environments.iter_mut().filter(|environment| names.contains(&environment.name)) {
                environment.inputs[*input] = 1.0;
            }
        }
    }
}

/// The id of [`crate::effect::Candidate`] for the same effect at the same place.
fn id(effect: &Effect, placed: &Placed, bound: &[Bound], inputs: &[(String, String)]) -> String {
    let mut names = placed.names.clone();
    if placed.node.is_some() {
        names.truncate(1);
    }
    if names.len() == 2 {
        names.sort();
    }
    let bound_names = inputs.iter().map(|(_, name)| name.as_str());
    if of_sensors(effect) && matches!(bound, [Bound::Node(_)]) {
        names.extend(bound_names.map(str::to_owned));
    } else if !inputs.is_empty() {
        names.push(bound_names.collect::<Vec<_>>().join("*"));
    }
    names.insert(0, effect.name.clone());
    names.join(":")
}

/// An input that is 1 where an effect is there.
fn add_switch(scope: &mut Scope, name: &str) -> usize {
    let input = Input {
        name: format!("{name}.applies"),
        unit: "1".to_owned(),
        nominal: 0.0,
        range: Some([0.0, 1.0]),
        settable: false,
        description: format!("1 where the adopted effect {name} is there"),
    };
    let switch = scope.resolved.add_input(input, Scale { unit: Some(Unit::si(Dimension::NONE)) });
    scope.resolved.model.switches.push(switch);
    switch
}

/// Changes the sensors of a measurement.
fn change_sensors(scope: &mut Scope, measurement: &mut Measurement, change: &SensorChange, place: &Place) {
    let nominal = change.time().map_or(0.0, |parameter| scope.resolved.model.parameters[parameter].nominal);
    if let SensorChange::Lag { sensor, .. } = change
        && measurement.sensors.iter().any(|declared| declared.name == *sensor && declared.lag_s.is_some())
    {
        let message = format!("the sensor `{sensor}` of `{}` has a lag already", measurement.name);
        scope.error(&code::EFFECT_PLACE, place, message, "a sensor without `lag`");
    }
    measurement.change_sensors(change, nominal);
}
