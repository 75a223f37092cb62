//! Adopted effects: looked up, placed, given their parameters, and applied to the model and to the measurements.

use crate::document::{Diagnostics, MapEntry, NameOr, OneOrMany, Place, Spanned, code, suggest};
use crate::effect::{Applied, Bound, Catalogue, Effect, Instance, PlaceKind, SensorChange, SensorPlace, Site, apply};
use crate::expression::{Dimension, Unit};
use crate::inference::measurement::{Measurement, Rows, Uncertain};
use crate::job::requirement::Environment;
use crate::random::Distribution;
use crate::study::folder::Folder;
use crate::study::model::{Members, Scale};
use crate::study::pass::PassForm;
use crate::study::pass::adopt::{Adopted, EffectUse, GroupForm};
use crate::study::resolved::AdoptedEffect;
use crate::thermal::{Input, NodeKind};

use super::adopt_parameter::parameters;
use super::scope::Scope;

/// Folder of a study's own effects.
const FOLDER: &str = "effects";

/// The program's effects and the study's own, which replace those of the same name; beside them the JSON of the
/// study's own, which is part of its definition.
pub fn catalogue(folder: &Folder, diagnostics: &mut Diagnostics) -> (Catalogue, Vec<(String, serde_json::Value)>) {
    let mut catalogue = Catalogue::embedded(diagnostics);
    let mut own = Vec::new();
    for name in folder.json_names(FOLDER) {
        let file = own_file(&name);
        let Ok(bytes) = folder.read(&file) else { continue };
        let node = catalogue.read(&name, &folder.shown_name(&file), &bytes, diagnostics);
        own.extend(node.map(|node| (name, node.to_json())));
    }
    catalogue.check(diagnostics);
    (catalogue, own)
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
    for entry in &form.adopt {
        scope.reason(&entry.value.because);
        check_evidence(scope, &entry.value);
        check_applies_to(scope, form, &entry.value);
        let Some((effect, usage)) = effect(scope, entry, catalogue) else { continue };
        if !of_sensors(effect) {
            adoption.adopt_one(scope, entry, effect, usage, &[]);
        }
    }
    adoption
}

fn of_sensors(effect: &Effect) -> bool {
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
    let found = catalogue.get(&usage.name);
    if found.is_none() {
        let known: Vec<&str> = catalogue.names().collect();
        scope.unknown(&code::UNKNOWN_EFFECT, "effect", &usage.name, &usage.name_place, &known);
    }
    Some((found?, usage))
}

fn check_evidence(scope: &mut Scope, form: &Adopted) {
    if let Some(evidence) = &form.evidence
        && let Err(error) = scope.folder.read(&evidence.pass.value)
    {
        let diagnostic = super::folder_diagnostic_at(&error, &evidence.pass.place);
        scope.diagnostics.push(diagnostic);
    }
}

fn check_applies_to(scope: &mut Scope, form: &PassForm, adopted: &Adopted) {
    let known: Vec<&str> = form.measurements.names().chain(form.environments.names()).collect();
    for name in adopted.applies_to.iter().flatten() {
        if !known.contains(&name.value.as_str()) {
            scope.unknown(&code::UNKNOWN_NAME, "measurement or environment", &name.value, &name.place, &known);
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
        let placed = place(scope, effect, usage, sensors)?;
        let bound = bound(scope, effect, usage, placed.node.as_ref())?;
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
        let inputs = effect.form.inputs.names().zip(&bound);
        let inputs = inputs.map(|(name, bound)| (name.to_owned(), bound.name(&scope.resolved.model).to_owned()));
        let inputs = inputs.collect();
        let instance = Instance { name: &entry.name, effect, site: placed.site, bound, parameters, switch };
        let applied = match apply(&mut scope.resolved.model, &instance) {
            Ok(applied) => applied,
            Err(error) => {
                scope.error(&code::EFFECT_PLACE, &usage.name_place, error.to_string(), "");
                return None;
            }
        };
        let parameters = instance.parameters;
        scope.resolved.note_additions(parameters.iter().map(|parameter| (parameter.unit.clone(), parameter.prior)));
        scope.hosts.extend(&applied.nodes);
        self.priors.extend(parameters.iter().map(|parameter| parameter.prior));
        self.adopted.push(AdoptedEffect {
            name: entry.name.clone(),
            effect: effect.name.clone(),
            title: effect.form.title.clone(),
            equation: effect.form.equation.clone().unwrap_or_default(),
            source: crate::document::source_text(&effect.form.source, effect.form.evidence),
            file: None,
            place: placed.names,
            inputs,
            parameters: applied.first_parameter..applied.first_parameter + parameters.len(),
            because: entry.value.because.value.clone(),
            evidence: entry.value.evidence.as_ref().map(|e| [e.pass.value.clone(), e.job.value.clone()]),
            applies_to: applies_to.into_iter().flatten().map(|name| name.value.clone()).collect(),
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
        for entry in &form.adopt {
            // What is wrong with its name was said before.
            let found = entry.value.effect.iter().next().and_then(|usage| Some((catalogue.get(&usage.name)?, usage)));
            let Some((effect, usage)) = found.filter(|(effect, _)| of_sensors(effect)) else { continue };
            let has = |name: &str| match &entry.value.applies_to {
                Some(names) => names.iter().any(|wanted| wanted.value == name),
                None => true,
            };
            let sensors = sensor_places(measurements.iter().filter(|measurement| has(&measurement.name)));
            if sensors.is_empty() && !form.measurements.is_empty() && measurements.len() < form.measurements.len() {
                // The data of a measurement are missing or wrong, and its sensors with them.
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
            for measurement in measurements.iter_mut().filter(|measurement| names.contains(&measurement.name)) {
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
    scope.resolved.add_input(input, Scale { unit: Some(Unit::si(Dimension::NONE)) })
}

/// Sensors of measurements, each name with each quantity once.
pub fn sensor_places<'m>(measurements: impl Iterator<Item = &'m Measurement>) -> Vec<SensorPlace> {
    let mut places: Vec<SensorPlace> = Vec::new();
    for measurement in measurements {
        let steady = matches!(measurement.rows, Rows::Steady(_));
        for sensor in &measurement.sensors {
            match places.iter_mut().find(|place| place.name == sensor.name && place.quantity == sensor.quantity) {
                Some(place) => {
                    place.steady |= steady;
                    place.transient |= !steady;
                }
                None => places.push(SensorPlace {
                    name: sensor.name.clone(),
                    quantity: sensor.quantity,
                    steady,
                    transient: !steady,
                }),
            }
        }
    }
    places
}

/// Changes the sensors of a measurement.
fn change_sensors(scope: &mut Scope, measurement: &mut Measurement, change: &SensorChange, place: &Place) {
    match change {
        SensorChange::Reading { sensor, from, to } => {
            for own in measurement.sensors.iter_mut().filter(|own| own.name == *sensor && own.quantity == *from) {
                own.quantity = *to;
            }
        }
        SensorChange::Lag { sensor, parameter } => {
            let nominal = scope.resolved.model.parameters[*parameter].nominal;
            for own in measurement.sensors.iter_mut().filter(|own| own.name == *sensor) {
                if own.lag_s.is_some() {
                    let message = format!("the sensor `{sensor}` of `{}` has a lag already", measurement.name);
                    scope.error(&code::EFFECT_PLACE, place, message, "a sensor without `lag`");
                }
                own.lag_s = Some(Uncertain::Parameter { index: *parameter, nominal });
            }
        }
        SensorChange::Swap { sensors: [a, b] } => {
            let find = |name: &str| measurement.sensors.iter().position(|sensor| sensor.name == name);
            let (Some(a), Some(b)) = (find(a), find(b)) else { return };
            // Everything but the channel's own name and unit goes over.
            measurement.sensors.swap(a, b);
            let first = (measurement.sensors[a].name.clone(), measurement.sensors[a].unit.clone());
            let second = (measurement.sensors[b].name.clone(), measurement.sensors[b].unit.clone());
            (measurement.sensors[a].name, measurement.sensors[a].unit) = second;
            (measurement.sensors[b].name, measurement.sensors[b].unit) = first;
        }
    }
}

/// A place that was found.
struct Placed {
    site: Site,
    names: Vec<String>,
    /// A node named behind a sensor, which binds the effect's one input.
    node: Option<Spanned<String>>,
}

/// Where an effect acts.
fn place(scope: &mut Scope, effect: &Effect, usage: &MapEntry<EffectUse>, sensors: &[SensorPlace]) -> Option<Placed> {
    let expected = expected_place(effect);
    let Some(OneOrMany(written)) = &usage.value.place else {
        let message = format!("`{}` does not say where it acts", effect.name);
        scope.error(&code::EFFECT_PLACE, &usage.name_place, message, &format!("\"where\": {expected}"));
        return None;
    };
    let mut names: Vec<&Spanned<String>> = Vec::new();
    for one in written {
        match one {
            NameOr::Name(name) => names.push(name),
            NameOr::Other(GroupForm { group }) => return group_place(scope, effect, group, sensors),
        }
    }
    let mut node = None;
    if let ([PlaceKind::Sensor], [sensor, second]) = (effect.places.as_slice(), names.as_slice())
        && effect.form.inputs.len() == 1
    {
        node = Some((*second).clone());
        names = vec![*sensor];
    }
    let kinds: Vec<PlaceKind> = effect.places.iter().copied().filter(|kind| kind.names() == names.len()).collect();
    let place = written.first().map_or(&usage.name_place, |one| match one {
        NameOr::Name(name) => &name.place,
        NameOr::Other(GroupForm { group }) => &group.place,
    });
    if kinds.is_empty() {
        let message = format!("`{}` does not act on {}", effect.name, counted(names.len()));
        scope.error(&code::EFFECT_PLACE, place, message, &expected);
        return None;
    }
    let found = names.iter().map(|name| find(scope, effect, &kinds, name, sensors)).collect::<Option<Vec<_>>>()?;
    let mut words: Vec<String> = names.iter().map(|name| name.value.clone()).collect();
    words.extend(node.iter().map(|name| name.value.clone()));
    if names.len() == 2 && names[0].value == names[1].value {
        let message = format!("`{}` stands twice", names[1].value);
        scope.error(&code::EFFECT_PLACE, &names[1].place, message, &expected);
        return None;
    }
    let site = match found.as_slice() {
        [Found::Node(a), Found::Node(b)] => Site::Pair([*a, *b]),
        [Found::Node(one)] => Site::Nodes(vec![(*one, 1.0)]),
        [Found::Element(one)] => Site::Elements(vec![*one]),
        all => Site::Sensors(
            all.iter()
                .flat_map(|one| match one {
                    Found::Sensors(sensors) => sensors.clone(),
                    Found::Node(_) | Found::Element(_) => Vec::new(),
                })
                .collect(),
        ),
    };
    Some(Placed { site, names: words, node })
}

fn counted(names: usize) -> String {
    match names {
        0 => "nothing".to_owned(),
        1 => "one name".to_owned(),
        several => format!("{several} names"),
    }
}

/// What `where` holds, in words.
fn expected_place(effect: &Effect) -> String {
    let mut words: Vec<String> = effect
        .places
        .iter()
        .map(|place| match place {
            PlaceKind::Pair => "two nodes".to_owned(),
            PlaceKind::SensorPair => "two sensors".to_owned(),
            PlaceKind::Capacity => "a node with a heat capacity".to_owned(),
            PlaceKind::Node => "a node that is no boundary".to_owned(),
            other => format!("a {}", other.word()),
        })
        .collect();
    if effect.groups {
        words.push("{\"group\": NAME}".to_owned());
    }
    words.join(", or ")
}

/// Something that a name stands for.
enum Found {
    Node(usize),
    Element(usize),
    /// A sensor, once for each quantity that it measures somewhere.
    Sensors(Vec<SensorPlace>),
}

fn find(
    scope: &mut Scope,
    effect: &Effect,
    kinds: &[PlaceKind],
    name: &Spanned<String>,
    sensors: &[SensorPlace],
) -> Option<Found> {
    let model = &scope.resolved.model;
    let mut known: Vec<&str> = Vec::new();
    let mut sensor = false;
    for &kind in kinds {
        match kind {
            PlaceKind::Pair | PlaceKind::Node | PlaceKind::Boundary | PlaceKind::Capacity => {
                let fits = |index: &usize| kind == PlaceKind::Pair || kind.is_node(&model.nodes[*index].kind);
                if let Some(index) = scope.resolved.node(&name.value).filter(fits) {
                    return Some(Found::Node(index));
                }
                known.extend((0..model.nodes.len()).filter(fits).map(|index| model.nodes[index].name.as_str()));
            }
            PlaceKind::Sensor | PlaceKind::SensorPair => {
                let own: Vec<SensorPlace> = sensors.iter().filter(|place| place.name == name.value).cloned().collect();
                if let Some(misfit) = own.iter().find(|place| !effect.fits_sensor(model, place)) {
                    let message = format!("the sensor `{}` measures no temperature", misfit.name);
                    scope.error(&code::EFFECT_PLACE, &name.place, message, "a sensor of a temperature");
                    return None;
                }
                if !own.is_empty() {
                    return Some(Found::Sensors(own));
                }
                known.extend(sensors.iter().map(|place| place.name.as_str()));
                sensor = true;
            }
            _ => {
                let elements = || model.elements.iter().enumerate().filter(|(_, element)| kind.is_element(element));
                if let Some((index, _)) = elements().find(|(_, element)| element.name == name.value) {
                    return Some(Found::Element(index));
                }
                known.extend(elements().map(|(_, element)| element.name.as_str()));
            }
        }
    }
    known.dedup();
    let words: Vec<&str> = kinds.iter().map(|kind| kind.word()).collect();
    let what = match kinds {
        [PlaceKind::Pair] | [PlaceKind::Node | PlaceKind::Capacity] => "node".to_owned(),
        [PlaceKind::Boundary] => "boundary".to_owned(),
        _ if sensor => "sensor".to_owned(),
        _ => words.join(" or "),
    };
    let known: Vec<String> = known.into_iter().map(str::to_owned).collect();
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    if let (true, Some(node)) = (what == "node" || what == "boundary", scope.resolved.node(&name.value)) {
        let own = match scope.resolved.model.nodes[node].kind {
            NodeKind::Boundary { .. } => "is a boundary",
            NodeKind::Arithmetic | NodeKind::Diffusion { .. } => "is no boundary",
        };
        let message = format!("`{}` {own}", name.value);
        let expected = format!("{}: {}", expected_place(effect), suggest::listed(known.iter().copied(), 12));
        scope.error(&code::EFFECT_PLACE, &name.place, message, &expected);
        return None;
    }
    scope.unknown(&code::EFFECT_PLACE, &what, &name.value, &name.place, &known);
    None
}

fn group_place(scope: &mut Scope, effect: &Effect, group: &Spanned<String>, sensors: &[SensorPlace]) -> Option<Placed> {
    let Some(found) = scope.resolved.groups.iter().find(|known| known.name == group.value).cloned() else {
        let known: Vec<String> = scope.resolved.groups.iter().map(|group| group.name.clone()).collect();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        scope.unknown(&code::UNKNOWN_NAME, "group", &group.value, &group.place, &known);
        return None;
    };
    let site = match &found.members {
        Members::Nodes(nodes) => Site::Nodes(nodes.clone()),
        Members::Conductors(elements) | Members::Radiations(elements) | Members::Loads(elements) => {
            Site::Elements(elements.clone())
        }
        Members::Sensors(names) => {
            let member = |place: &&SensorPlace| names.iter().any(|name| name.value == place.name);
            Site::Sensors(sensors.iter().filter(member).cloned().collect())
        }
    };
    let empty = matches!(&site, Site::Sensors(sensors) if sensors.is_empty());
    if empty || !effect.fits_group(&scope.resolved.model, &site) {
        let message = format!("`{}` does not act on the group `{}`", effect.name, group.value);
        scope.error(&code::EFFECT_PLACE, &group.place, message, &expected_place(effect));
        return None;
    }
    Some(Placed { site, names: vec![group.value.clone()], node: None })
}

/// What the effect's inputs stand for; `node` binds the one input of a sensor's effect.
fn bound(
    scope: &mut Scope,
    effect: &Effect,
    usage: &MapEntry<EffectUse>,
    node: Option<&Spanned<String>>,
) -> Option<Vec<Bound>> {
    let before = scope.diagnostics.errors();
    let known: Vec<&str> = effect.form.inputs.names().collect();
    for entry in &usage.value.inputs {
        if effect.form.inputs.get(&entry.name).is_none() {
            let message = format!("`{}` has no input `{}`", effect.name, entry.name);
            let expected = suggest::listed(known.iter().copied(), 12);
            scope.error(&code::EFFECT_INPUT, &entry.name_place, message, &expected);
        }
    }
    let mut bound = Vec::new();
    for entry in &effect.form.inputs {
        let given = usage.value.inputs.get(&entry.name).map(|given| &given.value);
        let Some(given) = given.or(node) else {
            let message = format!("the input `{}` of `{}` is not bound", entry.name, effect.name);
            let what = if entry.value.temperature { "an input or a node" } else { "an input" };
            let expected = format!("\"inputs\": {{\"{}\": NAME}}, {what} of the model", entry.name);
            scope.error(&code::EFFECT_INPUT, &usage.name_place, message, &expected);
            continue;
        };
        let input = scope.resolved.input(&given.value).map(Bound::Input);
        let node = scope.resolved.node(&given.value).map(Bound::Node);
        let choices: Vec<Bound> = input.into_iter().chain(node).collect();
        match choices.iter().find(|&&choice| entry.value.fits(&scope.resolved.model, choice)) {
            Some(&choice) => bound.push(choice),
            None if choices.is_empty() => {
                let model = &scope.resolved.model;
                let inputs = model.inputs.iter().map(|input| input.name.clone());
                let nodes = model.nodes.iter().map(|node| node.name.clone());
                let known: Vec<String> = inputs.chain(nodes.filter(|_| entry.value.temperature)).collect();
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                let what = if entry.value.temperature { "input or node" } else { "input" };
                scope.unknown(&code::EFFECT_INPUT, what, &given.value, &given.place, &known);
            }
            None => {
                let units: Vec<&str> =
                    entry.value.unit.iter().flat_map(|units| &units.0).map(|unit| unit.unit.text.as_str()).collect();
                let message = format!("`{}` cannot stand for the input `{}`", given.value, entry.name);
                let expected = if units.is_empty() {
                    "an input".to_owned()
                } else {
                    format!("an input in {}", units.join(" or "))
                };
                scope.error(&code::EFFECT_INPUT, &given.place, message, &expected);
            }
        }
    }
    (scope.diagnostics.errors() == before).then_some(bound)
}
