//! What the picture of a network marks: paths and heat that a diagnosis finds missing, and elements of adopted effects.

use crate::diagnosis::output::EffectResult;
use crate::effect::candidate::GROUP;
use crate::job::diagnose;
use crate::report::number::{significant, with_unit};
use crate::report::plot::{Diagram, Missing, Path};
use crate::report::section::diagnosis::amount;
use crate::report::view::PassReport;
use crate::study::AdoptedEffect;

/// The adopted effect from which an element comes: it has the effect's name, with the member behind it where there are several.
fn adopted<'r>(report: &'r PassReport<'_>, element: &str) -> Option<&'r AdoptedEffect> {
    report.adopted.iter().find(|effect| {
        element.strip_prefix(effect.name.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with(" ("))
    })
}

/// Share of the heat at one node below which that of all is none.
const NO_HEAT: f64 = 0.01;

/// How the path of an effect is drawn.
fn path_of(effect: &str) -> Path {
    if effect.contains("radiat") { Path::Radiation } else { Path::Conductor }
}

/// Whether an effect is a path of a kind that is drawn so, and no other flow of heat.
fn is_path(effect: &str) -> bool {
    ["radiat", "conduct", "path"].iter().any(|word| effect.contains(word))
}

/// Marks a diagram; `place` says which box of it stands for a node.
pub(super) fn mark(report: &PassReport<'_>, diagram: &mut Diagram, place: impl Fn(usize) -> usize) {
    for (name, path, ..) in &mut diagram.paths {
        if let Some(effect) = adopted(report, name) {
            diagram.adopted.push(name.clone());
            // To the solver it is a heat flow; to people it is what its effect says.
            if is_path(&effect.effect) {
                *path = path_of(&effect.effect);
            }
        }
    }
    let of_sources = diagram.sources.iter().map(|own| &own.0).filter(|name| adopted(report, name).is_some());
    // A node of an effect is named after it, `NAME.hidden`.
    let is_of =
        |name: &str, effect: &AdoptedEffect| name.strip_prefix(&effect.name).is_some_and(|rest| rest.starts_with('.'));
    let of_nodes =
        diagram.nodes.iter().map(|own| &own.0).filter(|name| report.adopted.iter().any(|own| is_of(name, own)));
    // What an effect changes has its place's name.
    let is_changed = |name: &&String| report.adopted.iter().any(|effect| effect.place == [(*name).clone()]);
    let changed =
        diagram.paths.iter().map(|own| &own.0).chain(diagram.sources.iter().map(|own| &own.0)).filter(is_changed);
    let added: Vec<String> = of_sources.chain(of_nodes).cloned().collect();
    diagram.changed = changed.cloned().collect();
    diagram.adopted.extend(added);
    if let Some((_, output)) = report.outputs::<diagnose::Kind>().next() {
        let selected = output.selected.iter().filter_map(|id| output.effects.iter().find(|effect| effect.id == *id));
        diagram.missing = selected.filter_map(|effect| missing(report, effect, &place)).collect();
    }
}

/// The boxes at the ends of the element on which an effect acts, or the one that it heats.
fn ends(report: &PassReport<'_>, effect: &EffectResult, place: impl Fn(usize) -> usize) -> Option<Vec<usize>> {
    let [name] = effect.place.as_slice() else { return None };
    let element = report.model.elements.iter().find(|element| element.name == *name)?;
    let physics = element.physics();
    let ends = physics.between().map(Vec::from).or_else(|| physics.heated().map(|node| vec![node]))?;
    Some(ends.into_iter().map(place).collect())
}

/// The box of the node to which an effect of a group gives most heat, or from which it takes most; `None` of other effects.
fn most_of_group(report: &PassReport<'_>, effect: &EffectResult, place: impl Fn(usize) -> usize) -> Option<Vec<usize>> {
    let most = effect.carries.first().filter(|_| effect.where_kind == GROUP)?;
    // What goes from node to node only is no heat at one of them.
    let now = effect
        .carries
        .iter()
        .filter(|own| (&own.measurement, &own.phase, own.time_s) == (&most.measurement, &most.phase, most.time_s));
    if now.map(|own| own.watts).sum::<f64>().abs() < NO_HEAT * most.watts.abs() {
        return None;
    }
    let node = report.model.nodes.iter().position(|node| node.name == most.node)?;
    Some(vec![place(node)])
}

/// A missing effect between two nodes or at one, on an element there, or of a group, which stands where it carries most; others, as of a
/// sensor or a parameter, have no place in a network.
fn missing(report: &PassReport<'_>, effect: &EffectResult, place: impl Fn(usize) -> usize) -> Option<Missing> {
    let nodes: Option<Vec<usize>> = (effect.place.iter())
        .map(|name| report.model.nodes.iter().position(|node| node.name == *name).map(&place))
        .collect();
    let watts = effect.watts.map_or_else(String::new, |[least, most]| {
        let size = if most >= -least { most } else { -least };
        let of_node = if effect.where_kind == GROUP { "up to " } else { "" };
        format!(", {of_node}{}", with_unit(&significant(size, 2), "W"))
    });
    let is_node = effect.effect.contains("hidden-node");
    // Of a node its coupling counts: heat that it stores goes to and fro.
    let coupling = effect.amplitudes.get("conductance").filter(|_| is_node);
    let size = coupling.map_or(watts, |size| format!(", {}", amount(size)));
    let of_all = match effect.place.first().filter(|_| effect.where_kind == GROUP) {
        Some(group) => format!(" at all of {group}"),
        None => String::new(),
    };
    let here = if of_all.is_empty() || size.is_empty() { "" } else { " here" };
    let label = format!("missing{of_all}: {}{size}{here}", effect.effect.replace('-', " "));
    let path = path_of(&effect.effect);
    let nodes = nodes.or_else(|| most_of_group(report, effect, &place)).or_else(|| ends(report, effect, &place))?;
    match (if nodes.len() == 2 { "nodes" } else { "node" }, nodes.as_slice()) {
        ("nodes", &[from, to]) if from != to => Some(Missing { label, path, from, to, is_node }),
        ("node", &[at]) => Some(Missing { label, path, from: at, to: at, is_node }),
        _ => None,
    }
}
