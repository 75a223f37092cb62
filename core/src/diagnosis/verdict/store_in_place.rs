//! A part that stores heat in the place of surroundings that nothing keeps warm.
//!
//! A constant temperature that is above all boundaries is what a heavy part that the model lacks would have: walls behind the
//! air of a room, a block behind a cooler. Over a record that is short beside the time constant of such a part the two read the
//! same, and what they predict of later rows differs by errors of the model. So where one was fitted at the same place and
//! explains as much, it has a name: half of the probability of the surroundings is its own.

use crate::diagnosis::Refit;
use crate::diagnosis::story::falls;
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::small_effects::IS_MODEL_ERROR;
use crate::effect::Candidate;
use crate::effect::form::Family;

/// Least share of what the surroundings explain, in squares of errors on the fitted rows, that a store of heat explains as well.
const EXPLAINS_AS_MUCH: f64 = 0.95;

/// A store of heat in the place of surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StoreInPlace {
    /// Position of the group of the surroundings.
    pub group: usize,
    /// The store.
    pub effect: usize,
    /// Positions of the sets before it and with it.
    pub sets: (usize, usize),
}

impl Findings<'_> {
    /// For each group with surroundings that stand for a source or a store, the store of heat at the same place that explains as much.
    pub(super) fn stores_in_place(&self) -> Vec<StoreInPlace> {
        let selected: Vec<usize> = self.groups.iter().filter_map(|group| group.first()).copied().collect();
        let of_group = |group: usize| {
            let (effect, sets) = self.store_in_place_of(&self.sources(group))?;
            (!selected.contains(&effect)).then_some(StoreInPlace { group, effect, sets })
        };
        (0..self.groups.len()).filter_map(of_group).collect()
    }

    /// Adds the stores to their groups, each with what their surroundings have lost to it.
    pub(super) fn add_stores(&mut self) {
        for StoreInPlace { group, effect, sets } in self.stores.clone() {
            let weighed =
                |one: usize| self.shared.get(&one).copied().unwrap_or_else(|| self.probability_as_weighed(one));
            let given: f64 = self.sources(group).into_iter().map(|one| IS_MODEL_ERROR * weighed(one)).sum();
            let share = weighed(effect).max(given);
            self.shared.insert(effect, share);
            if !self.groups[group].contains(&effect) {
                self.groups[group].push(effect);
            }
            if !self.rivals.contains(&sets.1) {
                self.rivals.push(sets.1);
            }
        }
    }

    /// Members of a group that lead to surroundings which stand for a source or a store of heat.
    fn sources(&self, group: usize) -> Vec<usize> {
        self.groups[group].iter().copied().filter(|&effect| self.is_source(effect)).collect()
    }

    /// The store of heat at the place of one of these surroundings that leaves least on the fitted rows, with the positions of the sets
    /// before it and with it; `None` where none explains as much.
    fn store_in_place_of(&self, sources: &[usize]) -> Option<(usize, (usize, usize))> {
        let refits = &self.state.refits;
        let squares = |refit: &Refit| refit.residuals.iter().map(|error| error * error).sum::<f64>();
        let mut best: Option<(f64, usize, (usize, usize))> = None;
        for &source in sources {
            let Some((before, after)) = self.step_of(source).or_else(|| self.best_with(source)) else { continue };
            let [without, with_source] = [before, after].map(|place| squares(&refits[place]));
            for (place, refit) in refits.iter().enumerate() {
                let own = &refits[before].effects;
                let is_next = refit.effects.len() == own.len() + 1 && own.iter().all(|one| refit.effects.contains(one));
                let added = refit.effects.iter().copied().find(|effect| is_next && !own.contains(effect));
                let Some(store) = added.filter(|&effect| self.is_store_at(effect, source)) else { continue };
                let with_store = squares(refit);
                let errors = [refits[before].rmse_held_out_k, refit.rmse_held_out_k];
                if explains_as_much([without, with_source, with_store])
                    && falls(errors)
                    && best.is_none_or(|(least, ..)| with_store < least)
                {
                    best = Some((with_store, store, (before, place)));
                }
            }
        }
        best.map(|(_, store, sets)| (store, sets))
    }

    /// Whether an effect is a store of heat at the place of another alone.
    fn is_store_at(&self, effect: usize, other: usize) -> bool {
        let [own, other] = [effect, other].map(|effect| &self.problem.candidates[effect]);
        let file = self.problem.catalogue.get(&own.effect);
        file.is_some_and(|file| file.form.family == Family::Storage) && is_same_place(own, other)
    }
}

/// Whether the place of an effect is that of another.
fn is_same_place(one: &Candidate, other: &Candidate) -> bool {
    one.where_kind == other.where_kind && one.place == other.place
}

/// Whether a store of heat explains as much as surroundings do, from the sums of squares on the fitted rows without both, with the
/// surroundings and with the store.
pub fn explains_as_much([without, with_surroundings, with_store]: [f64; 3]) -> bool {
    let gain = without - with_surroundings;
    gain > 0.0 && without - with_store >= EXPLAINS_AS_MUCH * gain
}
