//! Log odds of effects beforehand.
//!
//! Each kind of effect is missing with probability 0.05 if the study does not say otherwise, at any of its places in this
//! network alike, and so is physics that no kind describes: so the number of places is paid for. What is out of place, such
//! as convection in vacuum, is less probable. A hidden node between two nodes that the model does not join is two things at
//! once, a path and a part.

use std::collections::BTreeMap;

use crate::diagnosis::Problem;
use crate::diagnosis::odds::medium::{is_pressure, is_vacuum};
use crate::effect::{Bound, Effect, Site};
use crate::math::functions::ln;
use crate::thermal::element::Element;

/// Probability beforehand that a kind of effect is missing: a convention. It makes an effect of one place pay a log odds of
/// 2.9, and a study may say another ([`Problem::missing_probability`]).
const MISSING: f64 = 0.05;
/// Log odds by which an unknown function stands behind an effect that has a name.
pub(crate) const CURVE_COST: f64 = 3.0;
/// Log odds by which an effect stands behind others where its physics is out of place: a twentieth, not nothing, as the
/// model may say too little of where it is.
const OUT_OF_PLACE: f64 = 3.0;

/// Log prior odds, against "nothing", of one instance of each kind of effect.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorOdds {
    kinds: BTreeMap<String, f64>,
    vacuum: bool,
}

impl PriorOdds {
    /// Counts the places of each kind.
    pub fn new(problem: &Problem) -> Self {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for candidate in &problem.candidates {
            *counts.entry(candidate.effect.clone()).or_default() += 1;
        }
        let odds = |effect: &str, count: usize| {
            let unknown = problem.catalogue.get(effect).is_some_and(Effect::is_unknown_function);
            let behind = if unknown { CURVE_COST } else { 0.0 };
            let missing = problem.missing_probability.get(effect).copied().unwrap_or(MISSING);
            ln(missing / (1.0 - missing)) - ln(count.max(1) as f64) - behind
        };
        let kinds = counts.into_iter().map(|(effect, count)| (effect.clone(), odds(&effect, count))).collect();
        Self { kinds, vacuum: is_vacuum(problem) }
    }

    /// Whether a candidate's physics is out of place: it needs a gas in vacuum, or something that any input may stand for
    /// is a pressure (heat moves through a gas between two temperatures; no pressure is a source of it).
    pub fn is_out_of_place(&self, problem: &Problem, candidate: usize) -> bool {
        let candidate = &problem.candidates[candidate];
        let Some(effect) = problem.catalogue.get(&candidate.effect) else { return false };
        let mut bound = effect.form.inputs.iter().zip(&candidate.bound);
        self.vacuum && effect.needs_gas()
            || bound.any(|(form, bound)| {
                form.value.unit.is_none()
                    && matches!(bound, Bound::Input(input) if is_pressure(&problem.model.inputs[*input]))
            })
    }

    /// Of a set of candidates.
    pub fn of(&self, problem: &Problem, effects: &[usize]) -> f64 {
        let one = |&effect: &usize| {
            let odds = self.kinds.get(&problem.candidates[effect].effect)?;
            let place = if self.is_out_of_place(problem, effect) { OUT_OF_PLACE } else { 0.0 };
            let second = if is_path_and_part(problem, effect) { ln(MISSING / (1.0 - MISSING)) } else { 0.0 };
            Some(odds + second - place)
        };
        effects.iter().filter_map(one).sum()
    }

    /// Of "something else".
    pub fn unexplained() -> f64 {
        ln(MISSING / (1.0 - MISSING))
    }
}

/// Whether an effect is a hidden node between two nodes that nothing in the baseline model joins.
fn is_path_and_part(problem: &Problem, effect: usize) -> bool {
    let candidate = &problem.candidates[effect];
    let Site::Pair([a, b]) = candidate.site else { return false };
    let has_node = problem.catalogue.get(&candidate.effect).is_some_and(|own| own.form.adds.value.node.is_some());
    let joins =
        |element: &Element| element.physics().between().is_some_and(|between| between == [a, b] || between == [b, a]);
    has_node && !problem.model.elements.iter().any(joins)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::document::Diagnostics;
    use crate::effect::Catalogue;
    use crate::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

    /// A kind that is held for likely gains the ratio of its odds to the conventional 1/19 at each of its places, others nothing.
    #[test]
    fn the_study_may_say_how_probable_a_kind_of_effect_is() {
        let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
        let mut problem =
            case(&catalogue, &Recipe::of(Topology::Star, TestKind::Steady, InjectionRequest::default()), 1, 0)
                .unwrap()
                .problem;
        let of = |effect: &str| problem.candidates.iter().position(|own| own.effect == effect).unwrap();
        let (load, path) = (of("heat-load"), of("conductive-path"));
        let before = PriorOdds::new(&problem);
        problem.missing_probability.insert("heat-load".to_owned(), 0.5);
        let after = PriorOdds::new(&problem);
        let gain = |effects: &[usize]| after.of(&problem, effects) - before.of(&problem, effects);
        assert!((gain(&[load]) - ln(19.0)).abs() < 1e-12 && gain(&[path]) == 0.0);
        assert!((gain(&[load, path]) - ln(19.0)).abs() < 1e-12);
    }
}
