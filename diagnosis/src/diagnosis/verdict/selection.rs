//! Which set of effects goes first, its rivals and its groups.

use crate::diagnosis::Refit;
use crate::diagnosis::odds::narrow_prior::is_prior;
use crate::diagnosis::odds::posterior_odds::{
    LEAST_RIVAL, MOST_RIVALS, RIVALS_WITHIN, SURE, SetProbabilities, best, gains_unseen, groups,
};
use crate::diagnosis::story::course::Story;
use crate::diagnosis::story::rules::{SINGLE_PLACE, rises};
use crate::diagnosis::verdict::findings::Findings;
use crate::math::functions::{exp, pow};
use crate::math::sort::sort_by_key;
use crate::math::special::normal_quantile;

impl Findings<'_> {
    /// Selects the set to which the steps of a story lead; the group of a member is what could be added in its stead.
    fn follow(&mut self, story: &Story) {
        self.selected = story.end();
        for step in &story.steps {
            let Some(chosen) = step.chosen else { continue };
            let chance = |place: usize| step.additions.iter().find(|one| one.place == place);
            let Some(own) = chance(chosen) else { continue };
            let (mut group, mut held) = (vec![own.effect], own.probability);
            for other in step.additions.iter().filter(|one| one.place != chosen) {
                let near = other.probability * RIVALS_WITHIN >= own.probability;
                let unsure = held < SURE && other.probability >= LEAST_RIVAL;
                if (near || unsure) && group.len() <= MOST_RIVALS {
                    group.push(other.effect);
                    held += other.probability;
                }
            }
            self.rivals =
                step.additions.iter().filter(|one| group.contains(&one.effect)).map(|one| one.place).collect();
            sort_by_key(&mut self.rivals, |place| *place != chosen);
            self.groups.push(group);
        }
    }

    /// Selects the most probable set, its rivals and its groups.
    ///
    /// While something is still found beside the most probable set, the likelihood is known to be wrong, and odds made with
    /// it are too sure: their logarithms are divided by how far beyond the level of the tests that is (a likelihood raised
    /// to a power below 1; Miller & Dunson 2019, J. Am. Stat. Assoc. 114, 1113), and of the sets that are rivals then the one
    /// with the fewest parameters goes first. Of these the one that has to invent least does, as a prior may simply be wrong; and
    /// a whole group goes before one of its members.
    pub(super) fn select(&mut self, false_alarm: f64) {
        if let Some(story) = self.story.clone() {
            return self.follow(&story);
        }
        self.ask_unseen_of_curve();
        let place = best(&self.weights).unwrap_or(0);
        self.selected = place;
        if place == 0 {
            return;
        }
        let refits = &self.state.refits;
        let doubt = self.remaining(place).map_or(1.0, |p| doubt(p, false_alarm));
        let within = pow(RIVALS_WITHIN, doubt);
        // What takes more parameters has no claim on doubt.
        let mut weights = self.weights.clone();
        for (refit, weight) in refits.iter().zip(&mut weights.sets) {
            let near = *weight * RIVALS_WITHIN >= self.weights.sets[place];
            if doubt > 1.0 && !near && refit.unknowns.len() > refits[place].unknowns.len() {
                *weight = 0.0;
            }
        }
        self.go_on_with(place, &weights, within);
        if doubt > 1.0 {
            let plainer = |a: usize, b: usize| if refits[b].unknowns.len() < refits[a].unknowns.len() { b } else { a };
            let plainest = self.rivals_of_its_size().into_iter().reduce(plainer).unwrap_or(place);
            self.fewest_parameters = plainest != place;
            self.go_on_with(plainest, &weights, within);
        }
        let invented = |other: usize| {
            let effects = refits[other].effects.iter();
            effects.filter(|&&effect| !is_prior(&self.problem.candidates[effect])).count()
        };
        let less = |a: usize, b: usize| if invented(b) < invented(a) { b } else { a };
        let first = self.rivals_of_its_size().into_iter().reduce(less).unwrap_or(self.selected);
        if invented(first) < invented(self.selected) {
            self.fewest_parameters = false;
            self.go_on_with(first, &weights, within);
        }
        // Once for each member at most.
        for _ in 0..refits[self.selected].effects.len() {
            let near = |other: &usize| weights.sets[*other] * RIVALS_WITHIN >= weights.sets[self.selected];
            let is_whole = |other: &usize| self.is_of_whole_group(*other, self.selected);
            let Some(whole) = self.rivals_of_its_size().into_iter().filter(near).find(is_whole) else { return };
            let of_members: Vec<usize> =
                self.rivals_of_its_size().into_iter().filter(|&other| self.is_of_whole_group(whole, other)).collect();
            give_to_whole(&mut weights, whole, &of_members);
            give_to_whole(&mut self.weights, whole, &of_members);
            self.go_on_with(whole, &weights, within);
        }
    }

    /// Weighs the sets with what the held-out rows say, where the most probable one has an unknown function and errs clearly more on
    /// them than the most probable one of laws: a curve follows the rows that it saw.
    fn ask_unseen_of_curve(&mut self) {
        let refits = &self.state.refits;
        let is_curved = |place: usize| refits[place].effects.iter().any(|&one| self.problem.is_unknown_function(one));
        let Some(curve) = best(&self.weights).filter(|&place| is_curved(place)) else { return };
        let laws = (1..refits.len()).filter(|&place| !is_curved(place));
        let sets = &self.weights.sets;
        let Some(law) = laws.reduce(|a, b| if sets[b] > sets[a] { b } else { a }) else { return };
        if !rises([refits[law].rmse_held_out_k, refits[curve].rmse_held_out_k]) {
            return;
        }
        let gain = |refit: &Refit| gains_unseen(&refits[curve], refit, refit.held_out.len() as f64);
        self.weights = with_gains(&self.weights, &refits.iter().map(gain).collect::<Vec<_>>());
    }

    /// Selects a set, with its rivals and its groups.
    fn go_on_with(&mut self, place: usize, weights: &SetProbabilities, within: f64) {
        self.selected = place;
        (self.groups, self.rivals) = groups(&self.state.refits, weights, place, within);
    }

    /// The selected set and its rivals of as many effects.
    fn rivals_of_its_size(&self) -> Vec<usize> {
        let size = |place: usize| self.state.refits[place].effects.len();
        self.rivals.iter().copied().filter(|&other| size(other) == size(self.selected)).collect()
    }

    /// Whether a set has a whole group where another one has a member of it; by another law too, but by no curve.
    fn is_of_whole_group(&self, whole: usize, other: usize) -> bool {
        let candidates = &self.problem.candidates;
        let effects = |place: usize| &self.state.refits[place].effects;
        let goes_before = |group: usize, member: usize| {
            candidates[group].is_whole_of(&candidates[member])
                || !self.problem.is_unknown_function(group) && candidates[group].goes_before_member(&candidates[member])
        };
        let mut gone = effects(other).iter().filter(|effect| !effects(whole).contains(effect));
        gone.any(|&member| effects(whole).iter().any(|&group| goes_before(group, member)))
    }
}

/// What sets weigh with so much more log likelihood each; what no set explains gains nothing.
pub fn with_gains(weights: &SetProbabilities, gains: &[f64]) -> SetProbabilities {
    let sets: Vec<f64> = weights.sets.iter().zip(gains).map(|(weight, gain)| weight * exp(*gain)).collect();
    let total = sets.iter().sum::<f64>() + weights.unexplained;
    if !(total.is_finite() && total > 0.0) {
        return weights.clone();
    }
    let sets = sets.into_iter().map(|weight| weight / total).collect();
    SetProbabilities { sets, unexplained: weights.unexplained / total }
}

/// Gives a set with a whole group what sets with one of its members have, but for the share of a single place.
pub fn give_to_whole(weights: &mut SetProbabilities, whole: usize, of_members: &[usize]) {
    let theirs: f64 = of_members.iter().map(|&place| weights.sets[place]).sum();
    let all = theirs + weights.sets[whole];
    let left = all * exp(-SINGLE_PLACE) / (1.0 + exp(-SINGLE_PLACE));
    if theirs > left {
        of_members.iter().for_each(|&place| weights.sets[place] *= left / theirs);
        weights.sets[whole] = all - left;
    }
}

/// By how much odds are too sure beside which tests still find something: the ratio of the squares of the normal deviates
/// of what they find and of their level; 1 where they find nothing.
pub fn doubt(p: f64, false_alarm: f64) -> f64 {
    const MOST: f64 = 10.0;
    let square = |p: f64| normal_quantile(0.5 * p.clamp(1e-300, 1.0)) * normal_quantile(0.5 * p.clamp(1e-300, 1.0));
    (square(p) / square(false_alarm)).clamp(1.0, MOST)
}
