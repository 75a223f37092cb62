//! What the picture of a network marks: paths and heat that a diagnosis finds missing, and elements of adopted effects.

use crate::diagnosis::output::EffectResult;
use crate::job::diagnose;
use crate::report::number::{significant, with_unit};
use crate::report::plot::{Diagram, Missing, Path};
use crate::report::view::PassReport;

/// Whether an element comes from an effect that the pass adopts: its name begins with the effect's.
fn is_adopted(report: &PassReport<'_>, element: &str) -> bool {
    report
        .adopted
        .iter()
        .any(|effect| element.strip_prefix(effect.name.as_str()).is_some_and(|rest| rest.starts_with('.')))
}

/// Marks a diagram; `place` says which box of it stands for a node. Gives whether anything was marked.
pub(super) fn mark(report: &PassReport<'_>, diagram: &mut Diagram, place: impl Fn(usize) -> usize) -> bool {
    let adopted = diagram.paths.iter().map(|path| &path.0).chain(diagram.sources.iter().map(|source| &source.0));
    let adopted: Vec<String> = adopted.filter(|name| is_adopted(report, name)).cloned().collect();
    diagram.adopted = adopted;
    if let Some((_, output)) = report.outputs::<diagnose::Kind>().next() {
        let selected = output.selected.iter().filter_map(|id| output.effects.iter().find(|effect| effect.id == *id));
        diagram.missing = selected.filter_map(|effect| missing(report, effect, &place)).collect();
    }
    !diagram.adopted.is_empty() || !diagram.missing.is_empty()
}

/// A missing effect between two nodes or at one; others, as of a sensor or a parameter, have no place in a network.
fn missing(report: &PassReport<'_>, effect: &EffectResult, place: impl Fn(usize) -> usize) -> Option<Missing> {
    let nodes: Option<Vec<usize>> = (effect.place.iter())
        .map(|name| report.model.nodes.iter().position(|node| node.name == *name).map(&place))
        .collect();
    let watts = effect.watts.map_or_else(String::new, |[least, most]| {
        let size = if most >= -least { most } else { -least };
        format!(", {}", with_unit(&significant(size, 2), "W"))
    });
    let label = format!("missing: {}{watts}", effect.effect.replace('-', " "));
    let path = match effect.effect.contains("radiat") {
        true => Path::Radiation,
        false => Path::Conductor,
    };
    match (effect.where_kind.as_str(), nodes?.as_slice()) {
        ("nodes", &[from, to]) if from != to => Some(Missing { label, path, from, to }),
        ("node", &[at]) => Some(Missing { label, path, from: at, to: at }),
        _ => None,
    }
}
