//! Where an adopted effect acts, and what its inputs stand for.

use crate::document::{MapEntry, NameOr, OneOrMany, Spanned, code, suggest};
use crate::effect::{Bound, Effect, GroupPlace, PlaceKind, SensorPlace, Site};
use crate::study::pass::adopt::{EffectUse, GroupForm};
use crate::thermal::NodeKind;

use super::group_places;
use super::scope::Scope;

/// Inputs of an effect that a message names.
const NAMED: usize = 12;

/// A place that was found.
pub struct Placed {
    /// The place.
    pub site: Site,
    /// Its names as written.
    pub names: Vec<String>,
    /// A node named behind a sensor, which binds the effect's one input.
    pub node: Option<Spanned<String>>,
}

/// Where an effect acts. `None` after an error.
pub fn place(
    scope: &mut Scope,
    effect: &Effect,
    usage: &MapEntry<EffectUse>,
    sensors: &[SensorPlace],
) -> Option<Placed> {
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
    let found_places =
        names.iter().map(|name| find(scope, effect, &kinds, name, sensors)).collect::<Option<Vec<_>>>()?;
    let mut words: Vec<String> = names.iter().map(|name| name.value.clone()).collect();
    words.extend(node.iter().map(|name| name.value.clone()));
    if names.len() == 2 && names[0].value == names[1].value {
        let message = format!("`{}` stands twice", names[1].value);
        scope.error(&code::EFFECT_PLACE, &names[1].place, message, &expected);
        return None;
    }
    let site = match found_places.as_slice() {
        [Found::Node(a), Found::Node(b)] => Site::Pair([*a, *b]),
        [Found::Node(one)] => Site::Nodes([(*one, 1.0)].into()),
        [Found::Element(one)] => Site::Elements([*one].into()),
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
    let mut fitting_names: Vec<&str> = Vec::new();
    let mut sensor = false;
    for &kind in kinds {
        match kind {
            PlaceKind::Pair | PlaceKind::Node | PlaceKind::Boundary | PlaceKind::Capacity => {
                let fits = |index: &usize| kind == PlaceKind::Pair || kind.is_node(&model.nodes[*index].kind);
                if let Some(index) = scope.resolved.node(&name.value).filter(fits) {
                    return Some(Found::Node(index));
                }
                fitting_names.extend((0..model.nodes.len()).filter(fits).map(|index| model.nodes[index].name.as_str()));
            }
            PlaceKind::Sensor | PlaceKind::SensorPair => {
                let same_name: Vec<SensorPlace> =
                    sensors.iter().filter(|place| place.name == name.value).cloned().collect();
                if let Some(misfit) = same_name.iter().find(|place| !effect.fits_sensor(model, place)) {
                    let message = format!("the sensor `{}` measures no temperature", misfit.name);
                    scope.error(&code::EFFECT_PLACE, &name.place, message, "a sensor of a temperature");
                    return None;
                }
                if !same_name.is_empty() {
                    return Some(Found::Sensors(same_name));
                }
                fitting_names.extend(sensors.iter().map(|place| place.name.as_str()));
                sensor = true;
            }
            _ => {
                let elements = || model.elements.iter().enumerate().filter(|(_, element)| kind.is_element(element));
                if let Some((index, _)) = elements().find(|(_, element)| element.name == name.value) {
                    return Some(Found::Element(index));
                }
                fitting_names.extend(elements().map(|(_, element)| element.name.as_str()));
            }
        }
    }
    fitting_names.dedup();
    let words: Vec<&str> = kinds.iter().map(|kind| kind.word()).collect();
    let what = match kinds {
        [PlaceKind::Pair] | [PlaceKind::Node | PlaceKind::Capacity] => "node".to_owned(),
        [PlaceKind::Boundary] => "boundary".to_owned(),
        _ if sensor => "sensor".to_owned(),
        _ => words.join(" or "),
    };
    let fitting_names: Vec<String> = fitting_names.into_iter().map(str::to_owned).collect();
    let fitting_names: Vec<&str> = fitting_names.iter().map(String::as_str).collect();
    if let (true, Some(node)) = (what == "node" || what == "boundary", scope.resolved.node(&name.value)) {
        let boundary_clause = match scope.resolved.model.nodes[node].kind {
            NodeKind::Boundary { .. } => "is a boundary",
            NodeKind::Arithmetic | NodeKind::Diffusion { .. } => "is no boundary",
        };
        let message = format!("`{}` {boundary_clause}", name.value);
        let expected = format!("{}: {}", expected_place(effect), suggest::listed(fitting_names.iter().copied(), 12));
        scope.error(&code::EFFECT_PLACE, &name.place, message, &expected);
        return None;
    }
    scope.unknown(&code::EFFECT_PLACE, &what, &name.value, &name.place, &fitting_names);
    None
}

fn group_place(scope: &mut Scope, effect: &Effect, group: &Spanned<String>, sensors: &[SensorPlace]) -> Option<Placed> {
    let groups = group_places(&scope.resolved, sensors);
    let Some(GroupPlace { site, .. }) = groups.iter().find(|known| known.name == group.value).cloned() else {
        let group_names: Vec<&str> = groups.iter().map(|known| known.name.as_str()).collect();
        scope.unknown(&code::UNKNOWN_NAME, "group", &group.value, &group.place, &group_names);
        return None;
    };
    let empty = matches!(&site, Site::Sensors(sensors) if sensors.is_empty());
    if empty || !effect.fits_group(&scope.resolved.model, &site) {
        let message = format!("`{}` does not act on the group `{}`", effect.name, group.value);
        scope.error(&code::EFFECT_PLACE, &group.place, message, &expected_place(effect));
        return None;
    }
    Some(Placed { site, names: vec![group.value.clone()], node: None })
}

/// What the effect's inputs stand for; `node` binds the one input of a sensor's effect. `None` after an error.
pub fn bound(
    scope: &mut Scope,
    effect: &Effect,
    usage: &MapEntry<EffectUse>,
    node: Option<&Spanned<String>>,
) -> Option<Vec<Bound>> {
    let before = scope.diagnostics.errors();
    let input_names: Vec<&str> = effect
        .form
        .inputs
        .iter()
        .filter(|entry| entry.value.clock().is_none())
        .map(|entry| entry.name.as_str())
        .collect();
    for entry in &usage.value.inputs {
        if !input_names.contains(&entry.name.as_str()) {
            let message = format!("`{}` has no input `{}`", effect.name, entry.name);
            let expected = suggest::listed(input_names.iter().copied(), NAMED);
            scope.error(&code::EFFECT_INPUT, &entry.name_place, message, &expected);
        }
    }
    let (mut bound, mut not_bound) = (Vec::new(), Vec::new());
    for entry in &effect.form.inputs {
        if let Some(clock) = entry.value.clock() {
            bound.push(Bound::Input(scope.resolved.clock_input(clock)));
            continue;
        }
        let given = usage.value.inputs.get(&entry.name).map(|given| &given.value);
        let Some(given) = given.or(node) else {
            not_bound.push(entry);
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
                let listed_names: Vec<String> = inputs.chain(nodes.filter(|_| entry.value.temperature)).collect();
                let listed_names: Vec<&str> = listed_names.iter().map(String::as_str).collect();
                let what = if entry.value.temperature { "input or node" } else { "input" };
                scope.unknown(&code::EFFECT_INPUT, what, &given.value, &given.place, &listed_names);
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
    if !not_bound.is_empty() {
        let names = suggest::listed(not_bound.iter().map(|entry| entry.name.as_str()), NAMED);
        let is_one = not_bound.len() == 1;
        let (inputs, are) = if is_one { ("input", "is") } else { ("inputs", "are") };
        let message = format!("the {inputs} {names} of `{}` {are} not bound", effect.name);
        let written: Vec<String> = not_bound.iter().map(|entry| format!("\"{}\": NAME", entry.name)).collect();
        let what = match (is_one, not_bound.iter().any(|entry| entry.value.temperature)) {
            (true, false) => "an input",
            (true, true) => "an input or a node",
            (false, false) => "inputs",
            (false, true) => "inputs or nodes",
        };
        let expected = format!("\"inputs\": {{{}}}, {what} of the model", written.join(", "));
        scope.error(&code::EFFECT_INPUT, &usage.name_place, message, &expected);
    }
    (scope.diagnostics.errors() == before).then_some(bound)
}
