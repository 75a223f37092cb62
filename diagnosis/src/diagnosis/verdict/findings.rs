//! The sets, weighed, and which of them is said.

use crate::diagnosis::engine::{Remainder, State};
use crate::diagnosis::odds::posterior_odds::{STANDS, SURE, SetProbabilities, best, held};
use crate::diagnosis::output::Verdict;
use crate::diagnosis::problem::is_idle;
use crate::diagnosis::story::course::Story;
use crate::diagnosis::story::sets::added;
use crate::diagnosis::story::step::{Addition, Step};
use crate::diagnosis::verdict::small_effects::IS_MODEL_ERROR;
use crate::diagnosis::verdict::storage_alternative::StorageAlternative;
use crate::diagnosis::{Problem, Refit};
use crate::math::sort::sort_by;
use std::collections::BTreeMap;

/// The sets, weighed, and which of them is said.
pub(crate) struct Findings<'a> {
    pub problem: &'a Problem,
    pub state: &'a State,
    pub weights: SetProbabilities,
    /// The steps that lead to the selected set, where the model is taken to be a little wrong everywhere.
    pub story: Option<Story>,
    /// Position of the selected fit; that of the baseline model where nothing is selected.
    pub selected: usize,
    /// Members of each group: positions of effects, the selected one first.
    pub groups: Vec<Vec<usize>>,
    /// Fits that are rivals of the selected one, itself first.
    pub rivals: Vec<usize>,
    /// What sets leave that were not screened before.
    pub late: Vec<Remainder>,
    /// Whether nothing stands although tests find something.
    pub doubted: bool,
    /// Whether the held-out rows speak against a set that fits the others.
    pub vetoed: bool,
    /// Position of the most probable set, where it leaves the model too far from the noise to be selected.
    pub too_far: Option<usize>,
    /// Whether the held-out rows show what the tests of the fitted rows do not.
    pub shown_by_held_out: bool,
    /// Whether the selected set goes before a more probable one since odds are doubted.
    pub fewest_parameters: bool,
    /// Probabilities that errors of the model itself are what effects explain, where they are not 0.
    pub model_errors: BTreeMap<usize, f64>,
    /// Probability that lumped nodes are what an effect explains.
    pub lumped_nodes: BTreeMap<usize, f64>,
    /// Probabilities of effects in a group, by its number and the effect, where others explain nearly as much.
    pub shared: BTreeMap<(usize, usize), f64>,
    /// Storage effects as alternatives of surroundings.
    pub storage_alternatives: Vec<StorageAlternative>,
}

/// What is no rival of an effect at a step, though it would be more probable.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SetAside {
    /// Something that fails on the held-out rows.
    Failing,
    /// An effect that holds a temperature, K, at which a control of a logged heat holds the readings.
    Holding { effect: usize, level_k: f64 },
}

impl Findings<'_> {
    /// What a set leaves, by the noise and the model error that is allowed for.
    pub fn reduced_chi_square(&self, place: usize) -> f64 {
        let refit = &self.state.refits[place];
        refit.chi_square / (refit.residuals.len() as f64 - free(refit) as f64).max(1.0)
    }

    pub fn id(&self, effect: usize) -> &str {
        &self.problem.candidates[effect].id
    }

    /// The sets without and with an effect: where it is an alternative of surroundings, or else at the step of a story at which it was
    /// added or was most probable.
    pub(super) fn step_of(&self, effect: usize) -> Option<(usize, usize)> {
        if let Some(own) = self.storage_alternatives.iter().find(|own| own.effect == effect) {
            return Some(own.sets);
        }
        let steps = &self.story.as_ref()?.steps;
        let of = |step: &Step| {
            let chance = step.additions.iter().find(|one| one.effect == effect)?;
            Some((step.chosen == Some(chance.place), chance.probability, (step.before, chance.place)))
        };
        let best = steps.iter().filter_map(of).reduce(|a, b| if (b.0, b.1) > (a.0, a.1) { b } else { a });
        best.map(|(_, _, places)| places)
    }

    /// Effects of the selected set: in the order of the story or, without one, that first without which most is lost.
    pub(super) fn in_order(&self) -> Vec<usize> {
        let refits = &self.state.refits;
        let own = &refits[self.selected].effects;
        if self.story.is_some() && self.selected > 0 {
            return self.groups.iter().filter_map(|group| group.first()).copied().collect();
        }
        let without = |effect: usize| {
            let rest: Vec<usize> = own.iter().copied().filter(|&other| other != effect).collect();
            let rest = refits.iter().find(|refit| refit.effects == rest);
            rest.map_or(f64::NEG_INFINITY, |rest| rest.log_evidence)
        };
        let mut order: Vec<(f64, usize)> = own.iter().map(|&effect| (without(effect), effect)).collect();
        sort_by(&mut order, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        order.into_iter().map(|(_, effect)| effect).collect()
    }

    /// Probability that an effect is missing.
    pub fn probability(&self, effect: usize) -> f64 {
        let own = self.shared.iter().filter(|(key, _)| key.1 == effect).map(|(_, probability)| *probability);
        let shared = own.reduce(f64::max);
        self.unless_model_error(effect, shared.unwrap_or_else(|| self.probability_as_weighed(effect)))
    }

    /// Probability that an effect is missing by a step at which it may be added: at most that by all steps.
    pub(super) fn probability_at_step(&self, one: &Addition) -> f64 {
        self.probability(one.effect).min(self.unless_model_error(one.effect, one.probability))
    }

    /// A probability of an effect, less what it has of being none.
    pub(super) fn unless_model_error(&self, effect: usize, probability: f64) -> f64 {
        (1.0 - self.model_error(effect)) * probability
    }

    /// Probability that errors of the model are what an effect explains.
    pub(super) fn model_error(&self, effect: usize) -> f64 {
        let of = |probabilities: &BTreeMap<usize, f64>| probabilities.get(&effect).copied().unwrap_or(0.0);
        // What no effect of a step describes is taken from all that may stand for it.
        let is_outweighed = |group: &Vec<usize>| group.contains(&effect) && self.outweighed_by(group[0]).is_some();
        let is_contradicted =
            self.is_refused(effect) || self.outweighed_by(effect).is_some() || self.groups.iter().any(is_outweighed);
        let contradicted = if is_contradicted { IS_MODEL_ERROR } else { 0.0 };
        of(&self.model_errors).max(of(&self.lumped_nodes)).max(contradicted)
    }

    /// Whether the held-out rows refuse an effect as a step.
    pub(super) fn is_refused(&self, effect: usize) -> bool {
        self.story.as_ref().is_some_and(|story| story.refused.contains(&effect))
    }

    /// The step that adds an effect.
    pub(super) fn story_step_of(&self, effect: usize) -> Option<&Step> {
        let adds = |step: &&Step| step.chosen.and_then(|place| added(self.state, step.before, place)) == Some(effect);
        self.story.as_ref()?.steps.iter().find(adds)
    }

    /// Whether an effect fails on the held-out rows at the step that adds a member, which explains half of the errors.
    pub(super) fn fails_beside(&self, member: usize, effect: usize) -> bool {
        self.story_step_of(member).is_some_and(|step| step.failing.contains(&effect))
    }

    /// What would be more probable than an effect at the step that adds it, and is no rival of it.
    pub(super) fn outweighed_by(&self, effect: usize) -> Option<SetAside> {
        let (story, step) = (self.story.as_ref()?, self.story_step_of(effect)?);
        let own = story.logs[step.chosen?];
        if let Some(holding) = story.holding.filter(|holding| step.before == 0 && holding.log > own) {
            return Some(SetAside::Holding { effect: holding.effect, level_k: holding.level_k });
        }
        let is_more = |one: &Addition| step.failing.contains(&one.effect) && story.logs[one.place] > own;
        step.additions.iter().any(is_more).then_some(SetAside::Failing)
    }

    /// Whether an effect is so small that errors of the model may well be what it explains.
    pub(super) fn is_small(&self, effect: usize) -> bool {
        self.model_errors.get(&effect).is_some_and(|probability| *probability >= IS_MODEL_ERROR)
    }

    /// The same as if models had no errors of their own.
    pub(super) fn probability_as_weighed(&self, effect: usize) -> f64 {
        if let Some(story) = &self.story {
            let chances = story.steps.iter().flat_map(|step| &step.additions).filter(|one| one.effect == effect);
            return chances.map(|one| one.probability).fold(0.0, f64::max);
        }
        let with =
            self.state.refits.iter().zip(&self.weights.sets).filter(|(refit, _)| refit.effects.contains(&effect));
        with.map(|(_, weight)| weight).sum()
    }

    /// Log Bayes factor of a fit over another; where a model error is allowed for, each with the one that is most likely beside
    /// it: with that of the best set the baseline model would seem far less probable than it is, and later steps hardly more.
    pub(super) fn log_bayes_factor(&self, before: usize, after: usize) -> f64 {
        let own = |place: usize| self.story.as_ref()?.log_evidences.get(place).copied().filter(|log| log.is_finite());
        let refits = &self.state.refits;
        match (own(before), own(after)) {
            (Some(before), Some(after)) => after - before,
            _ => refits[after].log_evidence - refits[before].log_evidence,
        }
    }

    /// Whether the selected set goes before a more probable one.
    pub fn goes_first(&self) -> bool {
        self.story.is_none() && best(&self.weights).is_some_and(|place| self.selected != 0 && place != self.selected)
    }

    /// The family-wise p of what a set leaves, where that was tested.
    pub(super) fn remaining(&self, place: usize) -> Option<f64> {
        let effects = &self.state.refits[place].effects;
        let mut known = self.state.remainders.iter().chain(&self.late);
        known.find(|remainder| remainder.effects == *effects).map(|remainder| remainder.p)
    }

    /// The same of the selected set, or of the most probable one where the selected one goes before it.
    pub fn remaining_now(&self) -> Option<f64> {
        self.remaining(self.selected).or_else(|| self.remaining(best(&self.weights)?))
    }

    pub(super) fn judge(&self) -> Verdict {
        if self.story.is_some() {
            let first = self.groups.iter().filter_map(|group| group.first());
            let sure = self.groups.iter().all(|group| group.len() == 1)
                && first.into_iter().all(|&effect| self.probability(effect) >= SURE);
            // A model that is wrong by more than the noise may be so in the steps as well.
            return if sure && is_small_error(self.state) { Verdict::Identified } else { Verdict::Ambiguous };
        }
        let alone = self.rivals.len() == 1;
        let sure = held(&self.state.refits, &self.weights, &self.groups) >= SURE;
        let own = &self.state.refits[self.selected].effects;
        // As nothing does against a test that is not clear.
        let model_error_stands = own.iter().any(|&effect| self.model_error(effect) >= STANDS);
        if alone && sure && !model_error_stands { Verdict::Identified } else { Verdict::Ambiguous }
    }
}

/// Number of parameters that are not held at a bound.
pub(super) fn free(refit: &Refit) -> usize {
    refit.held.iter().zip(&refit.names).filter(|(held, name)| !**held && !is_idle(name)).count()
}

/// Whether the model errors that are allowed for are smaller than the noise of their sensors.
pub(super) fn is_small_error(state: &State) -> bool {
    state.noise.iter().all(|one| one.model_error.is_none_or(|error| error.sd <= one.noise.total()))
}
