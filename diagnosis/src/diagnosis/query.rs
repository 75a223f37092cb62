//! What those ask of a diagnosis who act upon it: which effects it supports, how probable they are, what they are confused
//! with.

use super::odds::posterior_odds::SURE;
use super::output::{EffectResult, GroupKind, Output, Verdict};
use super::verdict::small_effects::IS_MODEL_ERROR;
use crate::math::sort::sort_by;

/// Rivals that are less probable than this are not named.
const LEAST_RIVAL: f64 = 0.01;

impl EffectResult {
    /// Whether errors of the model itself are as likely what it stands for.
    pub fn is_weak(&self) -> bool {
        self.model_error >= IS_MODEL_ERROR
    }
}

/// Least difference of two probabilities that their percentages show.
const SHOWN: f64 = 1e-3;

impl Output {
    /// An effect by its id.
    pub fn effect(&self, id: &str) -> Option<&EffectResult> {
        self.effects.iter().find(|effect| effect.id == id)
    }

    /// Effects of an effect's group that were not selected and are more probable than it, the most probable first.
    pub fn more_probable(&self, own: &EffectResult) -> Vec<&EffectResult> {
        let is_rival = |other: &&EffectResult| {
            other.group.is_some() && other.group == own.group && !self.selected.contains(&other.id)
        };
        let rivals = self.effects.iter().filter(is_rival);
        let is_more = |other: &&EffectResult| other.probability - own.probability >= SHOWN;
        let mut rivals: Vec<&EffectResult> = rivals.filter(is_more).collect();
        sort_by(&mut rivals, |a, b| b.probability.total_cmp(&a.probability));
        rivals
    }

    /// Probability that all of these effects are missing, whatever else is: of the sets that have them, and at most that of the
    /// least probable one. `None` where no set has them all.
    pub fn odds(&self, chosen: &[&EffectResult]) -> Option<f64> {
        if let [one] = chosen {
            return Some(one.probability);
        }
        let has_all = |own: &[String]| chosen.iter().all(|effect| own.contains(&effect.id));
        let with: Vec<f64> =
            self.models.iter().filter(|model| has_all(&model.effects)).map(|model| model.probability).collect();
        let least = chosen.iter().map(|effect| effect.probability).fold(1.0, f64::min);
        (!with.is_empty()).then(|| with.iter().sum::<f64>().min(least))
    }

    /// Whether something is selected, and the data allow nothing in the place of any of it.
    pub fn is_without_rival(&self) -> bool {
        let mut selected = self.selected.iter().filter_map(|id| self.effect(id));
        !self.selected.is_empty() && selected.all(|effect| self.confused_with(effect).next().is_none())
    }

    /// Selected effects in whose place the data allow no other, and that are as probable as an identified one.
    pub fn settled(&self) -> Vec<&EffectResult> {
        let is_alone = |effect: &&EffectResult| self.confused_with(effect).next().is_none();
        let selected = self.selected.iter().filter_map(|id| self.effect(id));
        selected.filter(|effect| effect.probability >= SURE).filter(is_alone).collect()
    }

    /// What the group of an effect is, where all of it are laws of one thing.
    pub fn kind_of(&self, effect: &EffectResult) -> Option<&GroupKind> {
        self.kinds.iter().find(|kind| Some(kind.group) == effect.group)
    }

    /// What is missing as surely as an identified effect, by the group of an effect, though the data do not tell which of its laws.
    pub fn settled_kind_of(&self, effect: &EffectResult) -> Option<&GroupKind> {
        self.kind_of(effect).filter(|kind| kind.probability >= SURE)
    }

    /// Whether a selected effect is settled, or what all laws of its group are together.
    pub fn is_settled(&self, effect: &EffectResult) -> bool {
        self.settled().iter().any(|settled| settled.id == effect.id) || self.settled_kind_of(effect).is_some()
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
            let has_all = |effects: &[String]| chosen.iter().all(|effect| effects.contains(&effect.id));
            let others = self.models.iter().filter(|model| !model.effects.is_empty() && !has_all(&model.effects));
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
