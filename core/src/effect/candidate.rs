//! An effect at a place of a model.

use crate::thermal::Model;

use super::place::{Bound, Site};

/// A group of a model, as effects see it.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupPlace {
    /// Its name.
    pub name: String,
    /// Its members.
    pub site: Site,
}

/// `where_kind` of a group.
pub const GROUP: &str = "group";

/// An effect at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Such as `conductive-path:baseplate:board`: the effect, the names of the place, the input if there is one.
    pub id: String,
    /// The effect.
    pub effect: String,
    /// Kind of the place, as in a result's `where_kind`.
    pub where_kind: &'static str,
    /// Names of the place; those of a pair in alphabetical order.
    pub place: Vec<String>,
    /// What the effect's inputs stand for; several joined by `*`.
    pub input: Option<String>,
    /// The place by indices.
    pub site: Site,
    /// What the effect's inputs stand for, in the order of its file.
    pub bound: Vec<Bound>,
    /// Whether steady phases can see it.
    pub steady: bool,
    /// Whether transients can see it.
    pub transient: bool,
}

impl Candidate {
    /// Inputs of the model that the effect goes with; no clocks.
    pub fn inputs(&self, model: &Model) -> Vec<usize> {
        let input = |bound: &Bound| match bound {
            Bound::Input(input) => Some(*input).filter(|input| !model.clocks.has(*input)),
            Bound::Node(_) => None,
        };
        self.bound.iter().filter_map(input).collect()
    }

    /// Whether it acts on a group.
    pub fn is_group(&self) -> bool {
        self.where_kind == GROUP
    }

    /// Whether this is the same effect on a group of which the other's place is a part.
    pub fn is_whole_of(&self, other: &Self) -> bool {
        self.holds_place_of(other) && self.effect == other.effect && self.input == other.input
    }

    /// Whether it acts on a whole group of nodes or elements, by whatever law, of which the other acts on a part; or is the whole of it.
    pub fn goes_before_member(&self, other: &Self) -> bool {
        self.is_whole_of(other) || !matches!(self.site, Site::Sensors(_)) && self.holds_place_of(other)
    }

    /// Whether it acts on a group beside which the other's place is another one: no part of it, and of the same kind, or in the
    /// hardware where the group is one of sensors, or the reverse.
    pub fn is_elsewhere_than(&self, other: &Self) -> bool {
        let is_alike = std::mem::discriminant(&self.site) == std::mem::discriminant(&other.site);
        let [own, others] = [self, other].map(|one| matches!(one.site, Site::Sensors(_)));
        self.is_group() && (is_alike || own != others) && !self.holds_place_of(other)
    }

    /// Whether its place is a group of which the other's is a part.
    fn holds_place_of(&self, other: &Self) -> bool {
        let is_part = match (&self.site, &other.site) {
            (Site::Nodes(whole), Site::Nodes(part)) => {
                part.iter().all(|(node, _)| whole.iter().any(|(own, _)| own == node)) && part.len() < whole.len()
            }
            (Site::Elements(whole), Site::Elements(part)) => {
                part.iter().all(|element| whole.contains(element)) && part.len() < whole.len()
            }
            (Site::Sensors(whole), Site::Sensors(part)) => {
                part.iter().all(|sensor| whole.contains(sensor)) && part.len() < whole.len()
            }
            _ => false,
        };
        self.is_group() && is_part
    }
}
