//! What the effects of a group are together, where they are laws of one and the same thing: a loss of one node, heat into it, a path,
//! a conductance, a store of heat or a sensor. The effects' files say what each adds, their places where.

use crate::diagnosis::Problem;
use crate::diagnosis::odds::posterior_odds::held;
use crate::diagnosis::output::{EffectResult, GroupKind};
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::numbers::or_joined;
use crate::effect::{Candidate, Site};
use crate::thermal::{Model, NodeKind};

/// What an effect changes.
#[derive(Clone, Debug, PartialEq)]
enum Changed {
    /// Heat of nodes, and whether it is exchanged with surroundings.
    Heat { nodes: Vec<usize>, with_surroundings: bool },
    /// The path between two nodes.
    Path([usize; 2]),
    /// Elements that carry heat.
    Conductance(Vec<usize>),
    /// What nodes store.
    Store(Vec<usize>),
    /// What sensors read.
    Reading(Vec<String>),
}

impl Changed {
    fn of(candidate: &Candidate, problem: &Problem) -> Option<Self> {
        let adds = &problem.catalogue.get(&candidate.effect)?.form.adds.value;
        let stores = adds.capacity.is_some() || adds.node.is_some() || adds.within.is_some() || adds.source.is_some();
        let stored_between = |ends: Vec<usize>| {
            let is_inner = |node: &usize| !matches!(problem.model.nodes[*node].kind, NodeKind::Boundary { .. });
            let inner: Vec<usize> = ends.iter().copied().filter(is_inner).collect();
            // A wall between two boundaries has no other name than theirs.
            let mut ends = if inner.is_empty() { ends } else { inner };
            ends.sort_unstable();
            ends.dedup();
            Self::Store(ends)
        };
        match &candidate.site {
            Site::Pair(ends) if stores => Some(stored_between(ends.to_vec())),
            Site::Pair(ends) => adds.flow.is_some().then_some(Self::Path(*ends)),
            Site::Sensors(sensors) => Some(Self::Reading(sensors.iter().map(|sensor| sensor.name.clone()).collect())),
            Site::Nodes(members) => {
                let nodes: Vec<usize> = members.iter().map(|&(node, _)| node).collect();
                let gives = adds.load.is_some() || adds.curve.is_some() || adds.flow.is_some();
                match (stores, gives) {
                    (true, _) => Some(Self::Store(nodes)),
                    (_, true) => Some(Self::Heat { nodes, with_surroundings: adds.ambient.is_some() }),
                    _ => None,
                }
            }
            Site::Elements(elements) if stores || adds.factor.is_some() => {
                let ends = |&element: &usize| problem.model.elements.get(element).map(|own| own.nodes());
                let ends: Vec<Vec<usize>> = elements.iter().filter_map(ends).collect();
                if stores {
                    return Some(stored_between(ends.concat()));
                }
                // What has one end gives heat to it.
                match ends.iter().all(|nodes| nodes.len() == 1) {
                    true => Some(Self::Heat { nodes: ends.concat(), with_surroundings: false }),
                    false => Some(Self::Conductance(elements.to_vec())),
                }
            }
            Site::Elements(_) | Site::Parameter(_) => None,
        }
    }

    /// The same, but a path to a boundary as a loss of the node at its other end.
    fn beside_boundary(self, model: &Model) -> Self {
        let Self::Path(ends) = self else { return self };
        let is_inner = |node: &usize| !matches!(model.nodes[*node].kind, NodeKind::Boundary { .. });
        let nodes: Vec<usize> = ends.into_iter().filter(is_inner).collect();
        if nodes.len() == 1 { Self::Heat { nodes, with_surroundings: true } } else { self }
    }
}

/// Whether two effects change the same thing, by whatever law: heat of the same nodes, the same path, conductance or readings, what is
/// stored anywhere; or one acts on a group that has the other's place.
pub fn are_one_thing(a: &Candidate, b: &Candidate, problem: &Problem) -> bool {
    if a.site == b.site || a.goes_before_member(b) || b.goes_before_member(a) {
        return true;
    }
    let of = |candidate: &Candidate| Some(Changed::of(candidate, problem)?.beside_boundary(&problem.model));
    match (of(a), of(b)) {
        (Some(Changed::Heat { nodes: own, .. }), Some(Changed::Heat { nodes: other, .. })) => own == other,
        (Some(Changed::Store(_)), Some(Changed::Store(_))) => true,
        (Some(own), Some(other)) => own == other,
        _ => false,
    }
}

/// What effects are together and what the readings do not tell of it; `None` where there is one, or they are of several kinds or at several
/// places. Stores of heat are one kind at several places too: then the place is open.
pub fn one_kind(effects: &[&EffectResult], problem: &Problem) -> Option<(String, &'static str)> {
    let first = effects.first().filter(|_| effects.len() > 1)?;
    let of = |effect: &&EffectResult| {
        let candidate = problem.candidates.iter().find(|candidate| candidate.id == effect.id)?;
        Changed::of(candidate, problem)
    };
    let mut all: Vec<Changed> = effects.iter().map(of).collect::<Option<_>>()?;
    if all.iter().any(|changed| *changed != all[0]) {
        all = all.into_iter().map(|changed| changed.beside_boundary(&problem.model)).collect();
    }
    let place = |nodes: &[usize]| match nodes {
        [node] => format!("`{}`", problem.model.nodes[*node].name),
        _ => format!("`{}`", first.place.join("` and `")),
    };
    let differ = all.iter().any(|changed| *changed != all[0]);
    let (what, open) = match all.first()? {
        Changed::Heat { nodes: own, .. } => {
            let surroundings = |changed: &Changed| match changed {
                Changed::Heat { nodes, with_surroundings } if nodes == own => Some(*with_surroundings),
                _ => None,
            };
            let exchanged: Vec<bool> = all.iter().map(surroundings).collect::<Option<_>>()?;
            heat(&place(own), effects, &exchanged)
        }
        Changed::Store(_) if all.iter().all(|changed| matches!(changed, Changed::Store(_))) && differ => {
            ("a heat capacity that the model lacks".to_owned(), "whose place and coupling")
        }
        _ if differ => return None,
        Changed::Path(ends) => {
            let [a, b] = ends.map(|end| &problem.model.nodes[end].name);
            (format!("a path for heat between `{a}` and `{b}`"), "whose law")
        }
        Changed::Conductance(_) => {
            (format!("a change of the conductance of `{}`", first.place.join("`, `")), "whose cause")
        }
        Changed::Store(nodes) => {
            (format!("a heat capacity that the model lacks at {}", place(nodes)), "whose coupling")
        }
        Changed::Reading(_) => (format!("a fault of the readings of `{}`", first.place.join("` and `")), "whose kind"),
    };
    Some((what, open))
}

/// The laws of some effects, each once.
pub fn laws(effects: &[&EffectResult]) -> String {
    let mut laws: Vec<String> = Vec::new();
    for effect in effects {
        let law = effect
            .input
            .as_ref()
            .map_or_else(|| effect.effect.clone(), |input| format!("{} with {input}", effect.effect));
        if !laws.contains(&law) {
            laws.push(law);
        }
    }
    or_joined(&laws)
}

impl Findings<'_> {
    /// The effects of a group by its position, of those that are stated: no other selected ones, and no stores of heat that stand for
    /// surroundings.
    pub(super) fn laws_of_group<'o>(
        &self,
        group: usize,
        effects: &'o [EffectResult],
        selected: &[String],
    ) -> Vec<&'o EffectResult> {
        let Some((&first, _)) = self.groups[group].split_first() else { return Vec::new() };
        let is_alternative = |member: usize| self.storage_alternatives.iter().any(|own| own.effect == member);
        let members = self.groups[group].iter().filter(|&&member| !is_alternative(member));
        let stated = members.filter_map(|&member| effects.iter().find(|other| other.id == self.id(member)));
        stated.filter(|other| other.id == self.id(first) || !selected.contains(&other.id)).collect()
    }

    /// What the groups are together of which all effects are laws of one thing.
    pub(super) fn kinds(&self, effects: &[EffectResult], selected: &[String]) -> Vec<GroupKind> {
        let kind = |group: usize| {
            let members = self.laws_of_group(group, effects, selected);
            let (what, open) = one_kind(&members, self.problem)?;
            let position = |own: &&EffectResult| self.groups[group].iter().copied().find(|&one| self.id(one) == own.id);
            let members: Vec<usize> = members.iter().filter_map(position).collect();
            let probability = self.probability_of_any(&members);
            Some(GroupKind { group: group as u64 + 1, what, open: open.to_owned(), probability })
        };
        (0..self.groups.len()).filter_map(kind).collect()
    }

    /// Probability that one of the effects of a group is missing, the leading one first: with steps, of those that may be added at its
    /// step; else of the sets with any of them. What errors of the model have of each is not theirs.
    fn probability_of_any(&self, members: &[usize]) -> f64 {
        let Some(&first) = members.first() else { return 0.0 };
        let Some(step) = self.story_step_of(first) else {
            let any = held(&self.state.refits, &self.weights, &[members.to_vec()]);
            return self.unless_model_error(first, any);
        };
        let additions = step.additions.iter().filter(|one| members.contains(&one.effect));
        additions.map(|one| self.unless_model_error(one.effect, one.probability)).sum()
    }
}

/// Heat of a place, and what of it is open.
fn heat(place: &str, effects: &[&EffectResult], exchanged: &[bool]) -> (String, &'static str) {
    let is_all = |holds: fn([f64; 2]) -> bool| effects.iter().all(|effect| effect.watts.is_some_and(holds));
    let with_surroundings = exchanged.contains(&true);
    if is_all(|[_, most]| most <= 0.0) {
        let to = if with_surroundings { " to its surroundings" } else { "" };
        return (format!("a loss of heat from {place}{to}"), "whose law");
    }
    if !with_surroundings {
        return (format!("heat dissipated in {place}"), "whose dependence on time and inputs");
    }
    if exchanged.contains(&false) {
        return (format!("heat into or out of {place}"), "whose law");
    }
    if is_all(|[least, _]| least >= 0.0) {
        return (format!("heat from the surroundings into {place}"), "whose law");
    }
    (format!("heat exchanged between {place} and its surroundings"), "whose law")
}
