//! Groups: members that share physics.

use crate::document::Diagnostic;
use crate::document::{Diagnostics, Map, Spanned, code, written_choice};
use crate::effect::{SensorPlace, Site};

use super::name;
use super::resolve::ResolvedModel;
use crate::thermal::element::Lookup;

written_choice! {
    /// Members that share physics: one effect with one parameter applies to all.
    pub enum GroupForm: "a group" {
        /// Nodes with their weights (relative areas).
        "nodes" => Nodes(Map<Spanned<f64>>),
        /// Conductors.
        "conductors" => Conductors(Vec<Spanned<String>>),
        /// Radiations.
        "radiations" => Radiations(Vec<Spanned<String>>),
        /// Loads.
        "loads" => Loads(Vec<Spanned<String>>),
        /// Sensors, by their names in the passes.
        "sensors" => Sensors(Vec<Spanned<String>>),
    }
}

/// A group, resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name.
    pub name: String,
    /// Its members.
    pub members: Members,
}

/// Members of a group.
#[derive(Clone, Debug, PartialEq)]
pub enum Members {
    /// Indices of nodes with weights.
    Nodes(Vec<(usize, f64)>),
    /// Indices into the model's elements, all conductors.
    Conductors(Vec<usize>),
    /// Indices into the model's elements, all radiations.
    Radiations(Vec<usize>),
    /// Indices into the model's elements, all loads.
    Loads(Vec<usize>),
    /// Names of sensors; measurements know them.
    Sensors(Vec<Spanned<String>>),
}

impl Members {
    /// The members as a place; `sensors` are those of the measurements.
    pub fn site(&self, sensors: &[SensorPlace]) -> Site {
        match self {
            Self::Nodes(nodes) => Site::Nodes(nodes.as_slice().into()),
            Self::Conductors(elements) | Self::Radiations(elements) | Self::Loads(elements) => {
                Site::Elements(elements.as_slice().into())
            }
            Self::Sensors(names) => {
                let member = |place: &&SensorPlace| names.iter().any(|name| name.value == place.name);
                Site::Sensors(sensors.iter().filter(member).cloned().collect())
            }
        }
    }
}

/// Resolves a model's groups.
pub(super) fn resolve(form: &Map<GroupForm>, model: &ResolvedModel, diagnostics: &mut Diagnostics) -> Vec<Group> {
    name::check_labels(form, diagnostics);
    let mut groups = Vec::new();
    for entry in form {
        let members = match &entry.value {
            GroupForm::Nodes(nodes) => {
                let mut members = Vec::new();
                for node in nodes {
                    if node.value.value <= 0.0 {
                        let message = format!("the weight {} of `{}` is not above 0", node.value.value, node.name);
                        diagnostics.push(
                            Diagnostic::error(&code::OUT_OF_RANGE, &node.place, message).expected("a weight above 0"),
                        );
                    }
                    let node_index = model.find_node(&node.name, &node.name_place, diagnostics);
                    members.extend(node_index.map(|index| (index, node.value.value)));
                }
                (members.len(), Members::Nodes(members))
            }
            GroupForm::Conductors(names) => {
                let indices = elements(names, "conductor", model, diagnostics);
                (indices.len(), Members::Conductors(indices))
            }
            GroupForm::Radiations(names) => {
                let indices = elements(names, "radiation", model, diagnostics);
                (indices.len(), Members::Radiations(indices))
            }
            GroupForm::Loads(names) => {
                let indices = elements(names, "load", model, diagnostics);
                (indices.len(), Members::Loads(indices))
            }
            GroupForm::Sensors(names) => (names.len(), Members::Sensors(names.clone())),
        };
        let (count, members) = members;
        if count == 0 && !diagnostics.has_errors() {
            diagnostics.push(
                Diagnostic::error(
                    &code::OUT_OF_RANGE,
                    &entry.place,
                    format!("the group `{}` has no members", entry.name),
                )
                .expected("at least one member"),
            );
        }
        groups.push(Group { name: entry.name.clone(), members });
    }
    groups
}

/// Indices of named elements of a kind, each once.
fn elements(names: &[Spanned<String>], kind: &str, model: &ResolvedModel, diagnostics: &mut Diagnostics) -> Vec<usize> {
    let mut indices = Vec::new();
    for name in names {
        let Some(index) = model.find_element(&name.value, Some(kind), &name.place, diagnostics) else { continue };
        if indices.contains(&index) {
            diagnostics.push(Diagnostic::error(
                &code::DUPLICATE_NAME,
                &name.place,
                format!("`{}` stands twice in this group", name.value),
            ));
        }
        indices.push(index);
    }
    indices
}
