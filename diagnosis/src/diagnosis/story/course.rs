//! The course of a story: effects are added while they pay, earlier ones give way to others, and what explains most comes first.

use std::collections::BTreeSet;

use crate::diagnosis::engine::{Diagnosis, State};
use crate::diagnosis::fits::held_level::HeldLevel;
use crate::diagnosis::odds::logged_heat::follow_heat_of;
use crate::diagnosis::odds::posterior_odds::{RIVALS_WITHIN, gains_unseen};
use crate::diagnosis::story::plainness::Drivers;
use crate::diagnosis::story::rules::{
    AskedOfUnseen, CLEARLY, Gain, Weighed, explains_nearly_as_much, pays_by, with_plainer_ones,
};
use crate::diagnosis::story::sets::{Logs, first_by_weight, gain, goes_before, is_implausible, pays};
use crate::diagnosis::story::step::{Addition, Step};

/// How effects are added one by one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Story {
    /// Positions of the sets, from nothing on.
    pub sets: Vec<usize>,
    /// The steps; the last one may add nothing.
    pub steps: Vec<Step>,
    /// Log posterior weights of all sets, with what unseen rows say.
    pub logs: Vec<f64>,
    /// Log evidences of all sets, each with its own model error.
    pub log_evidences: Vec<f64>,
    /// Log likelihoods of all sets by blocks of the fitted and the held-out readings, where a verdict asks for them.
    pub of_blocks: Vec<Vec<f64>>,
    /// Effects that are no part of it, though more probable than nothing at a step: the unseen rows speak against them, or the
    /// fitted ones.
    pub refused: BTreeSet<usize>,
    /// Position of the set of the effect that goes first by itself; another beginning may lead further.
    pub beginning: Option<usize>,
    /// What holds a temperature at which a control of a logged heat holds the readings, and is no part of it.
    pub holding: Option<Holding>,
    /// What drives the candidates.
    pub drivers: Drivers,
    /// Whether it ends since a further step does not say where something is missing.
    pub is_open: bool,
}

/// The most probable effect of those that hold a temperature at which a control of a logged heat holds the readings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Holding {
    pub effect: usize,
    /// The temperature, K.
    pub level_k: f64,
    /// Log posterior weight of it alone.
    pub log: f64,
}

impl Story {
    /// The set to which it leads.
    pub fn end(&self) -> usize {
        self.sets.last().copied().unwrap_or(0)
    }

    /// What its sets weigh.
    fn weights(&self) -> Logs {
        Logs { weights: self.logs.clone(), evidences: self.log_evidences.clone(), drivers: self.drivers.clone() }
    }

    /// What a set gains over another.
    pub fn gain(&self, state: &State, before: usize, after: usize) -> Gain {
        gain(state, [&self.logs, &self.log_evidences], before, after)
    }

    /// Whether it finds no law, or begins with one that has to be a hundred times as large as is plausible.
    pub fn finds_no_plausible_law(&self, state: &State) -> bool {
        self.sets.get(1).is_none_or(|&first| is_implausible(state, 0, first))
    }
}

/// Effects that a story leaves out although they are more probable than nothing at a step.
fn refused(state: &State, logs: &Logs, story: &Story) -> BTreeSet<usize> {
    let own = &state.refits[story.end()].effects;
    let is_refused = |step: &Step, one: &Addition| {
        logs[one.place] > logs[step.before]
            && !pays(state, logs, step.before, one.place, AskedOfUnseen::FallUnlessClear)
    };
    let of_step = |step: &Step| -> Vec<usize> {
        step.additions.iter().filter(|one| is_refused(step, one)).map(|one| one.effect).collect()
    };
    story.steps.iter().flat_map(of_step).filter(|effect| !own.contains(effect)).collect()
}

impl Diagnosis {
    /// The sets that follow from one another, each with one effect more than the one before, from nothing on: the most
    /// probable plain law is added while it pays, the error on unseen rows does not rise by the first and falls by each further
    /// one, unless that gains clearly and no other beginning leads further. A curve of one input goes before laws only where it is clearly
    /// more probable and errs no more on unseen rows; other curves only after them.
    pub(crate) fn story(&self, state: &State) -> Story {
        // With what the unseen rows say: users judge the error there.
        let unseen = self.independent_unseen(state);
        let (log_evidences, weights) = self.log_weights_of_story(state);
        let seen = weights.into_iter().zip(&state.refits);
        let weights = seen.map(|(log, refit)| log + gains_unseen(&state.refits[0], refit, unseen)).collect();
        let mut logs = Logs { weights, evidences: log_evidences, drivers: Drivers::of(self.problem()) };
        let holding = self.leave_out_holding(state, &mut logs);
        let mut story = Story { sets: vec![0], steps: Vec::new(), logs: logs.to_vec(), ..Story::default() };
        let beginning = self.step(state, &logs, 0, AskedOfUnseen::Fall).chosen;
        let mut at = 0;
        while (state.refits[at].effects.len() as u64) < self.settings().most {
            let mut step = self.step(state, &logs, at, AskedOfUnseen::Fall);
            let mut other = None;
            if step.chosen.is_none() {
                // Where nothing more is added, another beginning may lead further.
                other = self.exchange(state, &logs, story.end(), &story.steps, 1);
                if other.is_none() {
                    step = self.step(state, &logs, at, AskedOfUnseen::FallUnlessClear);
                }
            }
            if let Some(next) = step.chosen {
                story.sets.push(next);
                story.steps.push(step);
                at = next;
            } else if other.is_none() {
                story.steps.push(step);
                break;
            }
            while let Some((better, earlier)) =
                other.or_else(|| self.exchange(state, &logs, story.end(), &story.steps, 0))
            {
                // What was added first may stand for what is only seen now.
                let shortened: Vec<usize> = story.sets[..earlier].to_vec();
                story = self.along(state, &logs, shortened, better);
                at = better;
                other = None;
            }
        }
        let ordered = self.largest_first(state, &logs, story);
        let story = self.until_contradicted(state, &logs, ordered);
        let refused = refused(state, &logs, &story);
        Story { log_evidences: logs.evidences, drivers: logs.drivers, refused, beginning, holding, ..story }
    }

    /// Takes all weight from sets with an effect that holds a temperature at a level at which a control of a logged heat holds the readings,
    /// where another effect alone explains nearly as much as the most probable of those alone. In a set with such an effect any other fits.
    /// States which effects follow the controlled heat.
    fn leave_out_holding(&self, state: &State, logs: &mut Logs) -> Option<Holding> {
        let problem = self.problem();
        let held = |place: usize| -> Vec<HeldLevel> {
            let refit = &state.refits[place];
            let levels = refit.effects.iter().filter_map(|&effect| problem.held_level(refit, effect));
            levels.filter(|held| !held.controlled.is_empty()).collect()
        };
        let finite = (1..state.refits.len()).filter(|&place| logs[place].is_finite());
        let all: Vec<(usize, Vec<HeldLevel>)> = finite.map(|place| (place, held(place))).collect();
        let alone = |&&(place, _): &&(usize, Vec<HeldLevel>)| state.refits[place].effects.len() == 1;
        let holding = all.iter().filter(alone).filter(|(_, held)| !held.is_empty());
        let (first, levels) = holding.reduce(|a, b| if logs[b.0] > logs[a.0] { b } else { a })?;
        let level = levels.first()?;
        let follows_control = follow_heat_of(problem, &level.controlled);
        let explains = |place: usize| {
            let all = [0, place, *first].map(|place| &state.refits[place]);
            explains_nearly_as_much(all.map(|refit| refit.rmse_train_k), all.map(|refit| refit.rmse_held_out_k))
        };
        let is_rival = |(place, held): &(usize, Vec<HeldLevel>)| {
            let effect = state.refits[*place].effects[0];
            held.is_empty()
                && !follows_control[effect]
                && !problem.is_unknown_function(effect)
                && !is_implausible(state, 0, *place)
                && pays(state, logs, 0, *place, AskedOfUnseen::FallUnlessClear)
                && explains(*place)
        };
        all.iter().filter(alone).find(|own| is_rival(own))?;
        let found = Holding { effect: state.refits[*first].effects[0], level_k: level.level_k, log: logs[*first] };
        for (place, held) in &all {
            if held.iter().any(|own| own.is_at(level)) {
                logs.weights[*place] = f64::NEG_INFINITY;
            }
        }
        logs.drivers.control = follows_control;
        Some(found)
    }

    /// The steps before the first whose effect is far less probable than another that fails on the unseen rows: it would follow
    /// errors of the model.
    fn until_contradicted(&self, state: &State, logs: &Logs, mut story: Story) -> Story {
        let is_contradicted = |step: &Step| {
            let is_first = state.refits[step.before].effects.is_empty();
            let weighed = |one: &Addition| {
                // What the fitted rows want less contradicts nothing.
                let unseen = Gain { fitted: 0.0, ..gain(state, [logs, &logs.evidences], step.before, one.place) };
                Weighed {
                    probability: one.probability,
                    is_curve: self.is_unknown_function(one.effect),
                    pays: pays_by(unseen, is_first, AskedOfUnseen::FallUnlessClear),
                }
            };
            let own = step.additions.iter().find(|one| step.chosen == Some(one.place));
            own.is_some_and(|own| weighed(own).is_contradicted(step.additions.iter().map(weighed)))
        };
        if let Some(number) = story.steps.iter().position(is_contradicted) {
            let last =
                Step { chosen: None, ..self.step(state, logs, story.sets[number], AskedOfUnseen::FallUnlessClear) };
            story.sets.truncate(number + 1);
            story.steps.truncate(number);
            story.steps.push(last);
        }
        story
    }

    /// A story as far as before a step, by its position, of which the place is open.
    pub(crate) fn cut(&self, state: &State, story: &Story, number: usize) -> Story {
        let (logs, sets) = (story.weights(), story.sets[..=number].to_vec());
        let end = sets[number];
        // What shows only beside later steps is judged beside those that are left.
        let again = self.along(state, &logs, sets.clone(), end).steps;
        let all = story.steps.iter().zip(again).zip(&sets);
        let own = all.map(|((own, again), &set)| if own.before == set { own.clone() } else { again });
        let mut steps: Vec<Step> = own.collect();
        let next = self.step(state, &logs, end, AskedOfUnseen::FallUnlessClear);
        steps.push(Step { chosen: None, failing: Vec::new(), ..next });
        Story { sets, steps, is_open: true, ..story.clone() }
    }

    /// The same sets in the order of what their effects explain: the one that explains most comes first. A law of a whole
    /// surface goes before single places that explain clearly more only, one of plausible size before one of a hundred times
    /// that which explains hardly more, and a plainer one before another.
    fn largest_first(&self, state: &State, logs: &Logs, story: Story) -> Story {
        let end = story.end();
        let weight = |at: usize, place: usize| {
            let own = &state.refits[at].effects;
            let is_of_group = |one: &&usize| !own.contains(*one) && self.problem().candidates[**one].is_group();
            logs[place] + if state.refits[place].effects.iter().any(|one| is_of_group(&one)) { CLEARLY } else { 0.0 }
        };
        let mut sets = vec![0];
        while let Some(&at) = sets.last().filter(|&&at| at != end) {
            let all: Vec<usize> = self.on_the_way(state, at, end).filter(|&place| logs[place].is_finite()).collect();
            let most = |places: &[usize]| first_by_weight(state, |place| weight(at, place), at, places);
            let Some(next) = most(&all) else { return story };
            let before = |law: usize| {
                let goes_before = |&place: &usize| goes_before(self.problem(), state, logs, at, place, law);
                most(&all.iter().copied().filter(goes_before).collect::<Vec<_>>())
            };
            sets.extend(with_plainer_ones(next, before).last());
        }
        if sets == story.sets {
            return story;
        }
        let mut ordered = self.along(state, logs, sets, end);
        ordered.steps.extend(story.steps.into_iter().filter(|step| step.chosen.is_none()));
        ordered
    }

    /// Positions of the sets with one effect more than one, all of them effects of another.
    fn on_the_way<'a>(&self, state: &'a State, at: usize, end: usize) -> impl Iterator<Item = usize> + 'a {
        let (own, all) = (&state.refits[at].effects, &state.refits[end].effects);
        let is_next = move |effects: &[usize]| {
            effects.len() == own.len() + 1
                && own.iter().all(|one| effects.contains(one))
                && effects.iter().all(|one| all.contains(one))
        };
        (0..state.refits.len()).filter(move |&place| is_next(&state.refits[place].effects))
    }

    /// The story that leads to a set along others, as far as these were fitted.
    fn along(&self, state: &State, logs: &Logs, mut sets: Vec<usize>, end: usize) -> Story {
        while let Some(&at) = sets.last()
            && state.refits[at].effects.len() < state.refits[end].effects.len()
        {
            let all: Vec<usize> = self.on_the_way(state, at, end).filter(|&place| logs[place].is_finite()).collect();
            sets.push(first_by_weight(state, |place| logs[place], at, &all).unwrap_or(end));
        }
        let step = |pair: &[usize]| {
            let own = self.step_to(state, logs, pair[0], AskedOfUnseen::FallUnlessClear, Some(pair[1]));
            let most = own.additions.iter().map(|one| one.probability).fold(0.0, f64::max);
            let is_likely = |one: &Addition| one.place == pair[1] && one.probability * RIVALS_WITHIN >= most;
            // What shows only beside the others is judged beside them.
            let beside = || self.last_of(state, logs, pair, end);
            if own.additions.iter().any(is_likely) { own } else { beside().unwrap_or(own) }
        };
        let steps = sets.windows(2).map(step).collect();
        Story { sets, steps, logs: logs.to_vec(), ..Story::default() }
    }

    /// The step to a set by the effect that another step added, as if that had come last.
    fn last_of(&self, state: &State, logs: &Logs, pair: &[usize], end: usize) -> Option<Step> {
        let added = state.refits[pair[1]].effects.iter().find(|one| !state.refits[pair[0]].effects.contains(one))?;
        let rest: Vec<usize> = state.refits[end].effects.iter().copied().filter(|one| one != added).collect();
        let before =
            state.refits.iter().position(|refit| refit.effects == rest).filter(|&own| logs[own].is_finite())?;
        Some(self.step_to(state, logs, before, AskedOfUnseen::FallUnlessClear, Some(end)))
    }
}
