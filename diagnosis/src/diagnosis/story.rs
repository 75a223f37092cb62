//! How effects are added one by one where the model is a little wrong everywhere: what a larger set gains there at once is
//! as likely to be model error.

use crate::diagnosis::engine::{Diagnosis, State};
use crate::diagnosis::odds::posterior_odds::RIVALS_WITHIN;
use crate::diagnosis::{RISES, Refit};
use crate::math::functions::{exp, ln};
use crate::math::sort::sort_by;
use crate::math::sum::log_sum_exp;
use std::collections::BTreeSet;

/// Log odds that are clear: by which a curve goes before a law, or a single place before a whole surface, and within which
/// effects explain as much as one another.
const CLEARLY: f64 = 10.0;
/// Log odds by which a single place stands behind a whole surface that explains as much.
pub(crate) const SINGLE_PLACE: f64 = 3.0;
/// Share of the gain of a step in log odds within which effects explain as much as one another.
const ALIKE_SHARE: f64 = 0.1;
/// Share of what an effect of a hundred times the plausible size explains, in squares of errors, that one of plausible size
/// has to explain to go before it; and where it predicts unseen rows clearly better.
pub(crate) const EXPLAINS_ALIKE: f64 = 0.95;
const EXPLAINS_MOST: f64 = 0.8;
/// Log odds by which the former then stands behind.
const IMPLAUSIBLE: f64 = 1.0;
/// Share of the squares of errors that an effect has to explain, on the fitted and on the unseen rows, so that what the fitted rows want
/// more and what fails on the unseen ones is no rival of it: errors of the model help on one of them only.
const EXPLAINS_ON_BOTH: f64 = 0.5;
/// Share of the largest gain of a member below which a member is a minor one, which gives way to any that explains more.
const MINOR_SHARE: f64 = 0.2;

/// Log Bayes factor on the fitted rows, downwards, from which they speak against an effect; less is not worth more than a bare mention
/// (Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 773).
const SPEAKS_AGAINST: f64 = -1.0;
/// The same where what speaks for the effect outweighs it clearly: what is more is strong evidence (Kass & Raftery 1995).
const SPEAKS_STRONGLY_AGAINST: f64 = -3.0;

/// What the sets of a state weigh, in logarithms: posterior weights with what unseen rows say, for which it stands, and evidences.
struct Logs {
    weights: Vec<f64>,
    evidences: Vec<f64>,
}

impl std::ops::Deref for Logs {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.weights
    }
}

/// What may be added at a step.
#[derive(Clone, Debug)]
pub(crate) struct Addition {
    /// The effect.
    pub effect: usize,
    /// Position of the set with it.
    pub place: usize,
    /// Its probability among all that may be added, and nothing.
    pub probability: f64,
}

/// A step of a story.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    /// Position of the set before it.
    pub before: usize,
    /// Position of the set after it; `None` where nothing is added.
    pub chosen: Option<usize>,
    /// Probability that nothing is to be added.
    pub stays: f64,
    /// What may be added, most probable first.
    pub additions: Vec<Addition>,
    /// Effects that fail on the unseen rows, where the one that is added explains half of the errors there and on the fitted ones: they
    /// are no rivals of it.
    pub failing: Vec<usize>,
}

/// A set that displaces that of a story.
struct Exchange {
    /// Its position, by which it is weighed.
    place: usize,
    /// Position of the set to which the story goes: with a whole surface, where that explains as much.
    to: usize,
    /// Number of the step of the effect that it displaces.
    number: usize,
}

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
}

impl Story {
    /// The set to which it leads.
    pub fn end(&self) -> usize {
        self.sets.last().copied().unwrap_or(0)
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

/// Log likelihood that a set gains over another on unseen rows which are worth so many independent readings, each set with
/// the model error that it shows there.
pub(crate) fn gains_unseen(before: &Refit, after: &Refit, independent: f64) -> f64 {
    let ratio = before.rmse_held_out_k.zip(after.rmse_held_out_k).map(|(before, after)| before / after);
    ratio.filter(|ratio| ratio.is_finite() && *ratio > 0.0).map_or(0.0, |ratio| independent * ln(ratio))
}

/// Whether the error on unseen rows rises clearly from a set to one that follows it.
pub fn rises(errors: [Option<f64>; 2]) -> bool {
    matches!(errors, [Some(before), Some(after)] if after > RISES * before)
}

/// Whether it falls clearly, or there are no such rows.
pub fn falls(errors: [Option<f64>; 2]) -> bool {
    !matches!(errors, [Some(before), Some(after)] if !(RISES * after < before))
}

/// Whether an effect explains at least half of the squares of the errors, on the fitted and on the unseen rows: errors without it and with
/// it on each.
pub fn explains_on_both(fitted: [Option<f64>; 2], unseen: [Option<f64>; 2]) -> bool {
    let leaves = 1.0 - EXPLAINS_ON_BOTH;
    let explains = |[before, after]: [Option<f64>; 2]| {
        before.zip(after).is_some_and(|(before, after)| after * after <= leaves * before * before)
    };
    explains(fitted) && explains(unseen)
}

/// Whether a curve goes before laws: it leads the most probable one by clear log odds, and errs hardly more on unseen rows than the
/// one that would be added; their errors there, the law's first.
pub fn curve_goes_first(lead: f64, errors: [Option<f64>; 2]) -> bool {
    lead > CLEARLY && !rises(errors)
}

/// A law that may be added at a step.
#[derive(Clone, Copy, Debug)]
pub struct LawOfStep {
    /// Its log posterior weight.
    pub log: f64,
    /// Whether it acts on a group.
    pub is_of_group: bool,
    /// Whether it acts elsewhere than the most probable law.
    pub is_elsewhere: bool,
    /// Whether a law at a single place elsewhere, which is no part of what it does, is far more probable.
    pub has_rival_elsewhere: bool,
}

/// Which law of a step goes first, of those that pay, the most probable first: it does, unless it acts at a single place and a whole
/// surface explains nearly as much, which nothing elsewhere explains far better.
pub fn whole_surface_first(laws: &[LawOfStep]) -> usize {
    let is_first_choice = |one: &LawOfStep| one.is_of_group && !one.is_elsewhere && !one.has_rival_elsewhere;
    let alike = |one: &LawOfStep| is_first_choice(one) && one.log > laws[0].log - CLEARLY;
    if laws.first().is_none_or(|first| first.is_of_group) { 0 } else { laws.iter().position(alike).unwrap_or(0) }
}

/// Whether a set with a whole surface goes before one with a single place of it in its stead: by their log posterior weights and their
/// errors on unseen rows, the single place's first.
pub fn surface_explains_alike([single, surface]: [f64; 2], errors: [Option<f64>; 2]) -> bool {
    surface > single - CLEARLY && !rises(errors)
}

/// Which of the effects that may go first at a step does, in the order of the rules: the first that is likely. Each with its probability, and
/// that of its most probable rival, whether that pays or not: where the fitted rows want far more what fails on the unseen ones, the
/// effect would follow errors of the model. `None` where none is likely.
pub fn first_likely(in_turn: &[[f64; 2]]) -> Option<usize> {
    in_turn.iter().position(|[own, rival]| own * RIVALS_WITHIN >= *rival)
}

/// Log odds by which another set has to lead that of a story to displace it: clear ones where it has more effects, or a single place
/// for a whole surface that would go before it.
pub fn least_lead(is_larger: bool, displaces_surface: bool) -> f64 {
    if is_larger || displaces_surface { CLEARLY } else { 0.0 }
}

/// The errors of two sets on unseen rows.
fn unseen(before: &Refit, after: &Refit) -> [Option<f64>; 2] {
    [before.rmse_held_out_k, after.rmse_held_out_k]
}

/// The effect that a set adds to another; `None` where it does not hold the other and one effect more.
pub(crate) fn added(state: &State, at: usize, place: usize) -> Option<usize> {
    let (own, effects) = (&state.refits[at].effects, &state.refits[place].effects);
    let is_next = effects.len() == own.len() + 1 && own.iter().all(|one| effects.contains(one));
    effects.iter().find(|effect| is_next && !own.contains(effect)).copied()
}

/// Whether the effect that a set adds to another is larger than plausible.
fn is_implausible(state: &State, at: usize, place: usize) -> bool {
    added(state, at, place).is_some_and(|effect| state.refits[place].is_implausible(effect))
}

/// Whether the prior of an effect of a set is as wide as the catalogue's.
fn is_as_written(state: &State, effect: usize, place: usize) -> bool {
    state.refits[place].widths().get(&effect).is_some_and(|&width| width <= 1.0)
}

/// Whether what a set adds to another explains half of the errors on the fitted and on the unseen rows.
pub(crate) fn explains_half(state: &State, at: usize, place: usize) -> bool {
    let [before, after] = [at, place].map(|place| &state.refits[place]);
    explains_on_both([before.rmse_train_k, after.rmse_train_k], unseen(before, after))
}

/// The set of most log weight among some that each add an effect to another. One that fails on the unseen rows comes last where another
/// explains half of the errors on both.
fn first_by_weight(state: &State, weight: impl Fn(usize) -> f64, at: usize, places: &[usize]) -> Option<usize> {
    let fails = |place: usize| rises(unseen(&state.refits[at], &state.refits[place]));
    let has_half = places.iter().any(|&place| explains_half(state, at, place));
    let rank = |place: usize| (!(has_half && fails(place)), weight(place));
    places.iter().copied().reduce(|a, b| if rank(b) > rank(a) { b } else { a })
}

/// Whether an effect of plausible size goes before one of a hundred times that, each by a set that adds it to another: it
/// explains nearly as much, and predicts unseen rows no worse; or explains most of it, predicts them better, and is not clearly less
/// probable.
fn goes_before(state: &State, logs: &[f64], at: usize, plausible: usize, other: usize) -> bool {
    let [own, plausible_set, other_set] = [at, plausible, other].map(|place| &state.refits[place]);
    let squares = [own, plausible_set, other_set].map(|refit| refit.residuals.iter().map(|error| error * error).sum());
    is_implausible(state, at, other)
        && !is_implausible(state, at, plausible)
        && serves_as_well(squares, unseen(other_set, plausible_set), logs[other] - logs[plausible])
}

/// Whether a set explains nearly as much as another, from the sums of squares without both, with it and with the other, and
/// errs no more on unseen rows: the errors of the other and of it there. Where it errs clearly less there, it may explain less, unless
/// the other leads it by clear log odds.
pub fn serves_as_well([without, with, with_other]: [f64; 3], errors: [Option<f64>; 2], lead: f64) -> bool {
    let predicts_better = matches!(errors, [Some(_), Some(_)]) && falls(errors) && lead <= CLEARLY;
    let share = if predicts_better { EXPLAINS_MOST } else { EXPLAINS_ALIKE };
    without - with >= share * (without - with_other) && !matches!(errors, [Some(other), Some(own)] if own > other)
}

/// What unseen rows are asked of a further effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AskedOfUnseen {
    /// That the error there falls.
    Fall,
    /// The same, or no rise where the gain is clear.
    FallUnlessClear,
}

/// What an effect gains at a step.
#[derive(Clone, Copy, Debug)]
pub struct Gain {
    /// In log odds, with what the unseen rows say.
    pub log_odds: f64,
    /// Log Bayes factor on the fitted rows.
    pub fitted: f64,
    /// Errors on unseen rows without it and with it.
    pub unseen: [Option<f64>; 2],
}

impl Gain {
    /// Whether the fitted rows speak against it: strongly, or with less that nothing outweighs clearly.
    pub fn is_against_fitted(self) -> bool {
        let least = if self.log_odds > CLEARLY { SPEAKS_STRONGLY_AGAINST } else { SPEAKS_AGAINST };
        self.fitted < least
    }
}

/// Whether an effect pays. The errors on unseen rows must fall, or not rise where the gain of the first effect is clear; of a further
/// one more is asked, as what it gains may be errors of the model, and the fitted rows must not speak against it
/// ([`Gain::is_against_fitted`]).
pub fn pays_by(gain: Gain, is_first: bool, asked: AskedOfUnseen) -> bool {
    let may_stay = (is_first || asked == AskedOfUnseen::FallUnlessClear) && gain.log_odds > CLEARLY;
    gain.log_odds > 0.0
        && (is_first || !gain.is_against_fitted())
        && if may_stay { !rises(gain.unseen) } else { falls(gain.unseen) }
}

/// What a set gains over another, by the log posterior weights and the log evidences of all sets.
fn gain(state: &State, [weights, evidences]: [&[f64]; 2], at: usize, place: usize) -> Gain {
    Gain {
        log_odds: weights[place] - weights[at],
        fitted: evidences[place] - evidences[at],
        unseen: unseen(&state.refits[at], &state.refits[place]),
    }
}

/// Whether a set that adds an effect to another is more probable, and neither unseen nor fitted rows speak against it.
fn pays(state: &State, logs: &Logs, at: usize, place: usize, asked: AskedOfUnseen) -> bool {
    pays_by(gain(state, [logs, &logs.evidences], at, place), state.refits[at].effects.is_empty(), asked)
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

/// What may be added at a step, as it is weighed.
#[derive(Clone, Copy, Debug)]
pub struct Weighed {
    /// Its probability among all that may be added, and nothing.
    pub probability: f64,
    /// Whether it is an unknown function.
    pub is_curve: bool,
    /// Whether it is more probable than nothing, and the unseen rows do not speak against it.
    pub pays: bool,
}

impl Weighed {
    /// Whether another one is far more probable that does not pay; a law is contradicted by no curve.
    pub fn is_contradicted(self, mut others: impl Iterator<Item = Self>) -> bool {
        let speaks = |other: &Self| !other.pays && (self.is_curve || !other.is_curve);
        others.any(|other| speaks(&other) && self.probability * RIVALS_WITHIN < other.probability)
    }
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
        let logs = Logs { weights, evidences: log_evidences };
        let mut story = Story { sets: vec![0], steps: Vec::new(), logs: logs.to_vec(), ..Story::default() };
        let beginning = self.step(state, &logs, 0, AskedOfUnseen::Fall).chosen;
        let mut at = 0;
        while (state.refits[at].effects.len() as u64) < self.settings().most {
            let mut step = self.step(state, &logs, at, AskedOfUnseen::Fall);
            let mut other = None;
            if step.chosen.is_none() {
                // Where nothing more is added, another beginning may lead further.
                other = self.exchange(state, &logs, &story, 1);
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
            while let Some((better, earlier)) = other.or_else(|| self.exchange(state, &logs, &story, 0)) {
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
        Story { log_evidences: logs.evidences, refused, beginning, ..story }
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

    /// The same sets in the order of what their effects explain: the one that explains most comes first. A law of a whole
    /// surface goes before single places that explain clearly more only, one of plausible size before one of a hundred times
    /// that which explains hardly more.
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
            let before_next = all.iter().copied().filter(|&place| goes_before(state, logs, at, place, next));
            let plausible = most(&before_next.collect::<Vec<_>>());
            sets.push(plausible.unwrap_or(next));
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

    /// What a set gains by a member, in log odds; without end where the set without it was not fitted.
    fn gain_of(&self, state: &State, logs: &[f64], set: usize, member: usize) -> f64 {
        let rest = state.refits[set].effects.iter().filter(|&&one| one != member);
        let without = state.refits.iter().position(|refit| refit.effects.iter().eq(rest.clone()));
        without.map_or(f64::INFINITY, |without| logs[set] - logs[without])
    }

    /// What may be added to a set, and what is.
    fn step(&self, state: &State, logs: &Logs, at: usize, asked: AskedOfUnseen) -> Step {
        self.step_to(state, logs, at, asked, None)
    }

    /// The same; where a next set is given, the step leads to that set, whatever would be added otherwise.
    fn step_to(&self, state: &State, logs: &Logs, at: usize, asked: AskedOfUnseen, next_set: Option<usize>) -> Step {
        let is_failing = |&place: &usize| {
            added(state, at, place).is_some() && rises(unseen(&state.refits[at], &state.refits[place]))
        };
        let failing: Vec<usize> = (0..logs.len()).filter(is_failing).collect();
        if !failing.is_empty() {
            let without = self.step_without(state, logs, at, asked, next_set, &failing);
            if without.chosen.is_some_and(|place| explains_half(state, at, place)) {
                return without;
            }
        }
        self.step_without(state, logs, at, asked, next_set, &[])
    }

    /// The same, where some sets are no rivals of the one that is added.
    fn step_without(
        &self,
        state: &State,
        logs: &Logs,
        at: usize,
        asked: AskedOfUnseen,
        next_set: Option<usize>,
        failing: &[usize],
    ) -> Step {
        let next: Vec<(usize, usize)> = (0..logs.len())
            .filter_map(|place| Some((added(state, at, place)?, place)))
            .filter(|one| logs[one.1].is_finite())
            .collect();
        let pays = |place: usize| pays(state, logs, at, place, asked);
        let most_probable = |wanted: &dyn Fn(usize) -> bool| {
            let laws = next.iter().filter(|one| !self.is_unknown_function(one.0) && pays(one.1) && wanted(one.1));
            laws.map(|one| one.1).reduce(|a, b| if logs[b] > logs[a] { b } else { a })
        };
        let largest_law = most_probable(&|_| true);
        let before_implausible =
            largest_law.and_then(|law| most_probable(&|place| goes_before(state, logs, at, place, law)));
        let mut logs_of_step = logs.to_vec();
        if let Some(plausible) = before_implausible {
            let others = next.iter().map(|one| one.1).filter(|&place| logs[place] > logs[plausible]);
            others.for_each(|place| logs_of_step[place] = logs[plausible] - IMPLAUSIBLE);
        }
        failing.iter().for_each(|&place| logs_of_step[place] = f64::NEG_INFINITY);
        let largest_law = largest_law.map_or(f64::NEG_INFINITY, |place| logs[place]);
        let logs = logs_of_step;
        let all: Vec<f64> = next.iter().map(|one| logs[one.1]).chain([logs[at]]).collect();
        let total = log_sum_exp(&all);
        let mut additions: Vec<Addition> = next
            .iter()
            .map(|&(effect, place)| Addition { effect, place, probability: exp(logs[place] - total) })
            .collect();
        sort_by(&mut additions, |a, b| b.probability.total_cmp(&a.probability).then(a.effect.cmp(&b.effect)));
        let pays = |one: &&Addition| pays(one.place);
        let is_curve = |one: &Addition| self.is_unknown_function(one.effect);
        let candidate = |one: &Addition| &self.problem().candidates[one.effect];
        let is_of_group = |one: &Addition| candidate(one).is_group();
        let is_elsewhere = |one: &Addition, other: &Addition| candidate(one).is_elsewhere_than(candidate(other));
        let law = additions.iter().filter(pays).find(|one| !is_curve(one));
        let of_one_input = |one: &&Addition| is_curve(one) && self.problem().candidates[one.effect].bound.len() == 1;
        let curve = additions.iter().filter(pays).find(of_one_input);
        let errors_of = |one: &Addition, other: &Addition| unseen(&state.refits[one.place], &state.refits[other.place]);
        // A law that has to be a hundred times as large as is plausible is no better than a curve of plausible size.
        let is_plausible = |one: &&Addition| is_curve(one) && is_as_written(state, one.effect, one.place);
        let plausible = law.filter(|law| is_implausible(state, at, law.place));
        let plausible = plausible.and_then(|law| {
            additions.iter().filter(pays).find(is_plausible).filter(|curve| logs[curve.place] > logs[law.place])
        });
        let chosen = match (law, curve) {
            _ if plausible.is_some() => plausible,
            (Some(law), Some(curve)) if curve_goes_first(logs[curve.place] - largest_law, errors_of(law, curve)) => {
                Some(curve)
            }
            (Some(law), _) => {
                let laws: Vec<&Addition> = additions.iter().filter(pays).filter(|one| !is_curve(one)).collect();
                let is_rival_elsewhere = |one: &Addition, other: &Addition| {
                    !is_of_group(other)
                        && is_elsewhere(one, other)
                        && one.probability * RIVALS_WITHIN < other.probability
                };
                let of_step = |one: &&Addition| LawOfStep {
                    log: logs[one.place],
                    is_of_group: is_of_group(one),
                    is_elsewhere: is_elsewhere(one, law),
                    has_rival_elsewhere: laws.iter().any(|other| is_rival_elsewhere(one, other)),
                };
                let first = whole_surface_first(&laws.iter().map(of_step).collect::<Vec<_>>());
                laws.get(first).copied()
            }
            (None, curve) => curve.or_else(|| additions.iter().find(pays)),
        };
        let goes_before_others = |one: &Addition| law.is_some_and(|law| is_of_group(one) && !is_of_group(law));
        let most_wanted = |one: &Addition| {
            let is_rival = |other: &&Addition| {
                (!goes_before_others(one) || is_of_group(other))
                    && (law.is_none() || self.is_last_resort(one.effect) || !is_curve(other))
            };
            additions.iter().filter(is_rival).map(|other| other.probability).fold(0.0, f64::max)
        };
        let chosen = match next_set {
            Some(place) => additions.iter().find(|one| one.place == place),
            None => {
                let last_resort = additions.iter().find(pays).filter(|_| state.refits[at].effects.is_empty());
                let in_turn: Vec<&Addition> = [chosen, law, curve, last_resort].into_iter().flatten().collect();
                let weighed: Vec<[f64; 2]> = in_turn.iter().map(|one| [one.probability, most_wanted(one)]).collect();
                first_likely(&weighed).map(|position| in_turn[position])
            }
        };
        let before_others = chosen.is_some_and(goes_before_others);
        let chosen = chosen.cloned();
        let mut stays = exp(logs[at] - total);
        if chosen.as_ref().is_some_and(|chosen| !self.is_unknown_function(chosen.effect)) {
            // Curves are asked only after the laws. Single places stand behind the surface that goes before them, whatever they
            // gain beyond it: errors of the model decide that.
            additions.retain(|one| !self.is_unknown_function(one.effect));
            let most = chosen.as_ref().map_or(0.0, |chosen| chosen.probability * exp(-SINGLE_PLACE));
            let is_behind = |one: &Addition| {
                before_others && !is_of_group(one) && chosen.as_ref().is_none_or(|first| !is_elsewhere(first, one))
            };
            let behind = additions.iter_mut().filter(|one| is_behind(one));
            behind.for_each(|one| one.probability = (one.probability * exp(-SINGLE_PLACE)).min(most));
            sort_by(&mut additions, |a, b| b.probability.total_cmp(&a.probability).then(a.effect.cmp(&b.effect)));
            let rest = stays + additions.iter().map(|one| one.probability).sum::<f64>();
            additions.iter_mut().for_each(|one| one.probability /= rest);
            stays /= rest;
        }
        let failing = failing.iter().filter_map(|&place| added(state, at, place)).collect();
        Step { before: at, chosen: chosen.map(|one| one.place), stays, additions, failing }
    }

    /// The most probable set with so many effects more than the story that is more probable than its end, with another effect in the
    /// place of an earlier one, and the step of that one. The other explained as much when that one was added, or that one is a minor
    /// member beside what was added since. A larger set has to be clearly more probable, and to err less on unseen rows; the other
    /// then has to pay alone.
    fn exchange(&self, state: &State, logs: &Logs, story: &Story, more: usize) -> Option<(usize, usize)> {
        let end = *story.sets.last()?;
        let members = &state.refits[end].effects;
        let gains: Vec<f64> = members.iter().map(|&member| self.gain_of(state, logs, end, member)).collect();
        let largest = gains.iter().copied().filter(|gain| gain.is_finite()).fold(0.0, f64::max);
        let is_minor = |member: usize| {
            members.iter().zip(&gains).any(|(&one, gain)| one == member && *gain < MINOR_SHARE * largest)
        };
        let may_follow = |place: usize| {
            let errors = unseen(&state.refits[end], &state.refits[place]);
            if more == 0 { !rises(errors) } else { falls(errors) }
        };
        let mut best: Option<Exchange> = None;
        // The last effect has had the whole choice of its own.
        let earlier = if more == 0 { story.steps.len().saturating_sub(1) } else { story.steps.len() };
        for (number, step) in story.steps.iter().enumerate().take(earlier) {
            let chosen = step.chosen?;
            let gain = logs[chosen] - logs[step.before];
            let member =
                state.refits[chosen].effects.iter().find(|one| !state.refits[step.before].effects.contains(one))?;
            let is_alike = |one: &&Addition| logs[chosen] - logs[one.place] < CLEARLY.max(ALIKE_SHARE * gain);
            let pays = |one: &&Addition| more > 0 && pays(state, logs, step.before, one.place, AskedOfUnseen::Fall);
            let may_displace = |one: &&Addition| {
                !step.failing.contains(&one.effect) && (is_alike(one) || is_minor(*member) || pays(one))
            };
            for other in step.additions.iter().filter(may_displace) {
                let before = &state.refits[step.before].effects;
                let is_other = |&place: &usize| {
                    let effects = &state.refits[place].effects;
                    effects.len() == members.len() + more
                        && effects.contains(&other.effect)
                        && !effects.contains(member)
                        && before.iter().all(|one| effects.contains(one))
                        && effects.iter().all(|&one| members.contains(&one) || !self.is_unknown_function(one))
                        && may_follow(place)
                };
                let place = (0..logs.len()).filter(is_other).reduce(|a, b| if logs[b] > logs[a] { b } else { a });
                // A single place displaces a whole surface only where it would go before that.
                let [surface, single] = [*member, other.effect].map(|one| &self.problem().candidates[one]);
                let displaces_surface = surface.is_group() && !single.is_group() && !surface.is_elsewhere_than(single);
                let least = logs[end] + least_lead(more > 0, displaces_surface);
                let place = place
                    .filter(|&place| logs[place] > best.as_ref().map_or(least, |best| logs[best.place].max(least)));
                let Some(place) = place else { continue };
                let surface = self.surface_in_place_of(state, logs, place, other.effect);
                // Beside the surface that is there the further effect is asked for as any next one.
                if surface.is_some_and(|surface| state.refits[surface].effects.contains(member)) {
                    continue;
                }
                let surface = surface.filter(|&surface| logs[surface] > least && may_follow(surface));
                best = Some(Exchange { place, to: surface.unwrap_or(place), number: number + 1 });
            }
        }
        best.map(|best| (best.to, best.number))
    }

    /// The most probable set with a whole surface in the place of a single place of it, where the surface explains as much and errs
    /// hardly more on unseen rows.
    fn surface_in_place_of(&self, state: &State, logs: &Logs, place: usize, single: usize) -> Option<usize> {
        let candidates = &self.problem().candidates;
        let own = &state.refits[place].effects;
        let explains_alike = |&other: &usize| {
            let effects = &state.refits[other].effects;
            let is_surface = |&surface: &usize| {
                !self.is_unknown_function(surface) && candidates[surface].goes_before_member(&candidates[single])
            };
            effects.len() == own.len()
                && own.iter().all(|one| *one == single || effects.contains(one))
                && effects.iter().find(|one| !own.contains(one)).is_some_and(is_surface)
                && surface_explains_alike(
                    [logs[place], logs[other]],
                    unseen(&state.refits[place], &state.refits[other]),
                )
        };
        (0..logs.len()).filter(explains_alike).reduce(|a, b| if logs[b] > logs[a] { b } else { a })
    }

    /// The story that leads to a set along others, as far as these were fitted.
    fn along(&self, state: &State, logs: &Logs, mut sets: Vec<usize>, end: usize) -> Story {
        while let Some(&at) = sets.last()
            && state.refits[at].effects.len() < state.refits[end].effects.len()
        {
            let all: Vec<usize> = self.on_the_way(state, at, end).collect();
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
        let before = state.refits.iter().position(|refit| refit.effects == rest)?;
        Some(self.step_to(state, logs, before, AskedOfUnseen::FallUnlessClear, Some(end)))
    }

    /// Whether an effect is an unknown function in which several inputs meet, which is asked where no law of plausible size is found.
    pub(crate) fn is_last_resort(&self, effect: usize) -> bool {
        self.is_unknown_function(effect) && self.problem().candidates[effect].bound.len() > 1
    }
}
