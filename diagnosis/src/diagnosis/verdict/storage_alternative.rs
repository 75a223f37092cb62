//! A storage effect as the alternative of surroundings that are warmer than every boundary.
//!
//! What has a constant temperature above all boundaries may be a heavy part that the model lacks: walls behind the air of a room, a
//! block behind a cooler. Half of the probability of such surroundings is given to that (`small_effects`). Where a storage
//! effect at the same place explains at least 95 % as much on the fitted rows, and lowers the error on held-out rows as well,
//! it joins their group and has that half. Which of the two errs less on held-out rows does not matter: errors of the
//! model decide that. It does where the noise is stated and nothing is left, so that there is no such alternative there.

use crate::diagnosis::Refit;
use crate::diagnosis::story::rules::{EXPLAINS_ALIKE, falls};
use crate::diagnosis::story::sets::added;
use crate::diagnosis::story::step::Step;
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::small_effects::IS_MODEL_ERROR;
use crate::effect::form::Family;

/// A storage effect that reads the same as surroundings of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StorageAlternative {
    /// Position of the group.
    pub group: usize,
    /// The storage effect.
    pub effect: usize,
    /// Positions of the sets without it and with it.
    pub sets: (usize, usize),
    /// Probability that the surroundings lose to it.
    pub probability: f64,
}

impl Findings<'_> {
    /// The storage effects that are more probable as alternatives of surroundings than by themselves, one for a group at most.
    pub(super) fn storage_alternatives(&self) -> Vec<StorageAlternative> {
        self.story.iter().flat_map(|story| &story.steps).filter_map(|step| self.storage_alternative(step)).collect()
    }

    /// Adds them to their groups, and what was fitted with them to the rivals.
    pub(super) fn add_storage_alternatives(&mut self) {
        for StorageAlternative { group, effect, probability, .. } in self.storage_alternatives.clone() {
            self.shared.insert((group, effect), probability);
            if !self.groups[group].contains(&effect) {
                self.groups[group].push(effect);
            }
            let first = self.groups[group][0];
            let selected = &self.state.refits[self.selected].effects;
            let is_exchanged = |refit: &Refit| {
                refit.effects.len() == selected.len()
                    && refit.effects.contains(&effect)
                    && selected.iter().all(|one| *one == first || refit.effects.contains(one))
            };
            let rival = self.state.refits.iter().position(is_exchanged);
            self.rivals.extend(rival.filter(|place| !self.rivals.contains(place)));
        }
    }

    /// The one that leaves least on the fitted rows, of a step and its group; `None` where none explains as much.
    fn storage_alternative(&self, step: &Step) -> Option<StorageAlternative> {
        let refits = &self.state.refits;
        let first = added(self.state, step.before, step.chosen?)?;
        let group = self.groups.iter().position(|members| members[0] == first)?;
        let squares = |place: usize| refits[place].residuals.iter().map(|error| error * error).sum::<f64>();
        let warm: Vec<(usize, usize)> = step
            .additions
            .iter()
            .filter(|one| self.groups[group].contains(&one.effect) && self.is_source(one.effect))
            .map(|one| (one.effect, one.place))
            .collect();
        let is_free = |effect: usize| {
            let mut others = self.groups.iter().enumerate().filter(|(number, _)| *number != group);
            first != effect && others.all(|(_, members)| !members.contains(&effect))
        };
        let alternative = |place: usize| {
            let effect = added(self.state, step.before, place).filter(|&effect| is_free(effect))?;
            let reads_the_same = |&&(surroundings, with): &&(usize, usize)| {
                self.is_storage_at(effect, surroundings)
                    && explains_as_much([step.before, with, place].map(squares))
                    && falls([step.before, place].map(|place| refits[place].rmse_held_out_k))
            };
            let alike = warm.iter().filter(reads_the_same);
            let lost: f64 = alike.map(|(one, _)| IS_MODEL_ERROR * self.probability_as_weighed(*one)).sum();
            let probability = lost.min(IS_MODEL_ERROR);
            let sets = (step.before, place);
            (probability > self.probability_as_weighed(effect)).then_some(StorageAlternative {
                group,
                effect,
                sets,
                probability,
            })
        };
        let less =
            |a: StorageAlternative, b: StorageAlternative| if squares(b.sets.1) < squares(a.sets.1) { b } else { a };
        (0..refits.len()).filter_map(alternative).reduce(less)
    }

    /// Whether an effect stores heat at the place of another.
    fn is_storage_at(&self, effect: usize, other: usize) -> bool {
        let [own, other] = [effect, other].map(|effect| &self.problem.candidates[effect]);
        let file = self.problem.catalogue.get(&own.effect);
        file.is_some_and(|file| file.form.family == Family::Storage)
            && own.where_kind == other.where_kind
            && own.place == other.place
    }
}

/// Whether a storage effect explains as much as surroundings do, from the sums of squares on the fitted rows without both, with the
/// surroundings and with the storage effect.
pub fn explains_as_much([without, with_surroundings, with_storage]: [f64; 3]) -> bool {
    let gain = without - with_surroundings;
    gain > 0.0 && without - with_storage >= EXPLAINS_ALIKE * gain
}
