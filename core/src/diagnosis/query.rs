//! What those ask of a diagnosis who act upon it: which effects it supports, how probable they are, what they are confused
//! with.

use super::output::{EffectResult, Output, Verdict};

/// Rivals that are less probable than this are not named.
const LEAST_RIVAL: f64 = 0.01;

impl Output {
    /// An effect by its id.
    pub fn effect(&self, id: &str) -> Option<&EffectResult> {
        self.effects.iter().find(|effect| effect.id == id)
    }

    /// Probability of exactly these effects; `None` where this set was not fitted.
    pub fn probability_of(&self, effects: &[&str]) -> Option<f64> {
        let is_set = |own: &[String]| own.len() == effects.len() && own.iter().all(|id| effects.contains(&id.as_str()));
        self.models.iter().find(|model| is_set(&model.effects)).map(|model| model.probability)
    }

    /// Probability of exactly these effects; that of a single one where its set was not weighed alone.
    pub fn odds(&self, chosen: &[&EffectResult]) -> Option<f64> {
        let ids: Vec<&str> = chosen.iter().map(|effect| effect.id.as_str()).collect();
        self.probability_of(&ids).or(if let [one] = chosen { Some(one.probability) } else { None })
    }

    /// What else the data allow in place of these effects, best first, each with its probability: what shares a group with
    /// one of them, or, where nothing does, other sets.
    pub fn rivals(&self, chosen: &[&EffectResult]) -> Vec<(String, f64)> {
        let is_chosen = |id: &str| chosen.iter().any(|effect| effect.id == id);
        let mut rivals: Vec<(String, f64)> = Vec::new();
        for rival in chosen.iter().flat_map(|effect| self.confused_with(effect)).filter(|own| !is_chosen(&own.id)) {
            if !rivals.iter().any(|(id, _)| *id == rival.id) {
                rivals.push((rival.id.clone(), rival.probability));
            }
        }
        if rivals.is_empty() {
            let is_same = |effects: &[String]| effects.len() == chosen.len() && effects.iter().all(|id| is_chosen(id));
            let others = self.models.iter().filter(|model| !model.effects.is_empty() && !is_same(&model.effects));
            let likely = others.filter(|model| model.probability >= LEAST_RIVAL);
            rivals.extend(likely.map(|model| (model.effects.join(" + "), model.probability)));
        }
        rivals
    }

    /// The effects that the diagnosis would adopt; where it names none of several that explain the data alike, the best.
    fn leading(&self) -> Vec<&EffectResult> {
        if self.selected.is_empty() && self.verdict == Verdict::Ambiguous {
            return self.effects.iter().find(|effect| effect.group.is_some()).into_iter().collect();
        }
        self.selected.iter().filter_map(|id| self.effect(id)).collect()
    }

    /// Whether the diagnosis supports an effect: it is selected, or these data cannot tell it from one that is.
    pub fn supports(&self, effect: &EffectResult) -> bool {
        let alike =
            |other: &&EffectResult| other.id == effect.id || (effect.group.is_some() && other.group == effect.group);
        self.leading().iter().any(alike)
    }

    /// All effects that these data cannot tell from this one, itself left out, best first. Members of the selected set
    /// stand beside it, not in its place.
    pub fn confused_with<'f>(&'f self, effect: &'f EffectResult) -> impl Iterator<Item = &'f EffectResult> {
        let is_selected = |id: &String| self.selected.contains(id);
        let together = is_selected(&effect.id);
        self.effects.iter().filter(move |other| {
            let rival = other.id != effect.id && other.group.is_some() && other.group == effect.group;
            rival && !(together && is_selected(&other.id))
        })
    }
}
