//! Which effect is added to a set, with its rivals and what the step is worth.

use crate::diagnosis::engine::{Diagnosis, State};
use crate::diagnosis::odds::posterior_odds::RIVALS_WITHIN;
use crate::diagnosis::story::rules::{
    AskedOfUnseen, LawOfStep, SINGLE_PLACE, STANDS_BEHIND, curve_goes_first, first_likely, rises, whole_surface_first,
    with_plainer_ones,
};
use crate::diagnosis::story::sets::{
    Logs, added, explains_half, goes_before, is_as_written, is_implausible, pays, unseen,
};
use crate::effect::Candidate;
use crate::math::functions::exp;
use crate::math::sort::sort_by;
use crate::math::sum::log_sum_exp;

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

impl Diagnosis {
    /// What may be added to a set, and what is.
    pub(super) fn step(&self, state: &State, logs: &Logs, at: usize, asked: AskedOfUnseen) -> Step {
        self.step_to(state, logs, at, asked, None)
    }

    /// The same; where a next set is given, the step leads to that set, whatever would be added otherwise.
    pub(super) fn step_to(
        &self,
        state: &State,
        logs: &Logs,
        at: usize,
        asked: AskedOfUnseen,
        next_set: Option<usize>,
    ) -> Step {
        let choice = Choice { diagnosis: self, state, logs, at, asked };
        let is_failing = |&place: &usize| {
            logs[place].is_finite()
                && added(state, at, place).is_some()
                && rises(unseen(&state.refits[at], &state.refits[place]))
        };
        let failing: Vec<usize> = (0..logs.len()).filter(is_failing).collect();
        if !failing.is_empty() {
            let without = choice.step(next_set, &failing);
            if without.chosen.is_some_and(|place| explains_half(state, at, place)) {
                return without;
            }
        }
        choice.step(next_set, &[])
    }
}

/// The choice of the effect that is added to a set.
struct Choice<'a> {
    diagnosis: &'a Diagnosis,
    state: &'a State,
    logs: &'a Logs,
    /// Position of the set.
    at: usize,
    asked: AskedOfUnseen,
}

/// The most probable effects of a step that pay.
struct Leading<'a> {
    law: Option<&'a Addition>,
    /// A curve of one input.
    curve: Option<&'a Addition>,
}

impl Choice<'_> {
    /// The step, where some sets are no rivals of the one that is added.
    fn step(&self, next_set: Option<usize>, failing: &[usize]) -> Step {
        let largest_law = self.most_probable_law(|_| true);
        let logs = self.logs_of_step(largest_law, failing);
        let (mut additions, mut stays) = self.weighed(&logs);
        let leading = self.leading(&additions);
        let chosen = match next_set {
            Some(place) => additions.iter().find(|one| one.place == place),
            None => {
                let largest_law = largest_law.map_or(f64::NEG_INFINITY, |place| self.logs[place]);
                let first = self.first(&logs, &additions, &leading, largest_law);
                let last_resort = additions.iter().find(|one| self.pays(one));
                let last_resort = last_resort.filter(|_| self.state.refits[self.at].effects.is_empty());
                let in_turn: Vec<&Addition> =
                    [first, leading.law, leading.curve, last_resort].into_iter().flatten().collect();
                let weighed: Vec<[f64; 2]> = in_turn
                    .iter()
                    .map(|one| [one.probability, self.most_wanted(&additions, leading.law, one)])
                    .collect();
                first_likely(&weighed).map(|position| in_turn[position])
            }
        };
        let goes_before_places = chosen.is_some_and(|one| self.goes_before_places(leading.law, one));
        let chosen = chosen.cloned();
        if let Some(chosen) = chosen.as_ref().filter(|chosen| !self.is_curve(chosen)) {
            self.set_back(chosen, goes_before_places, &mut additions, &mut stays);
        }
        let failing = failing.iter().filter_map(|&place| added(self.state, self.at, place)).collect();
        Step { before: self.at, chosen: chosen.map(|one| one.place), stays, additions, failing }
    }

    /// The effects that may be added, each with the set that has it.
    fn next(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let next = (0..self.logs.len()).filter_map(|place| Some((added(self.state, self.at, place)?, place)));
        next.filter(|one| self.logs[one.1].is_finite())
    }

    fn pays(&self, one: &Addition) -> bool {
        self.pays_at(one.place)
    }

    fn pays_at(&self, place: usize) -> bool {
        pays(self.state, self.logs, self.at, place, self.asked)
    }

    fn is_curve(&self, one: &Addition) -> bool {
        self.diagnosis.is_unknown_function(one.effect)
    }

    fn candidate(&self, one: &Addition) -> &Candidate {
        &self.diagnosis.problem().candidates[one.effect]
    }

    fn is_of_group(&self, one: &Addition) -> bool {
        self.candidate(one).is_group()
    }

    fn is_elsewhere(&self, one: &Addition, other: &Addition) -> bool {
        self.candidate(one).is_elsewhere_than(self.candidate(other))
    }

    /// Position of the set of the most probable law that pays, among some.
    fn most_probable_law(&self, is_wanted: impl Fn(usize) -> bool) -> Option<usize> {
        let is_law = |one: &(usize, usize)| {
            !self.diagnosis.is_unknown_function(one.0) && self.pays_at(one.1) && is_wanted(one.1)
        };
        let laws = self.next().filter(is_law).map(|one| one.1);
        laws.reduce(|a, b| if self.logs[b] > self.logs[a] { b } else { a })
    }

    /// Log posterior weights of the sets at this step: without those that fail, and with what is implausibly large or less
    /// plain behind a plain effect that goes before it ([`goes_before`]), itself or by way of others.
    fn logs_of_step(&self, largest_law: Option<usize>, failing: &[usize]) -> Vec<f64> {
        let mut logs = self.logs.to_vec();
        let goes_before_law = |law: usize| {
            self.most_probable_law(|place| {
                goes_before(self.diagnosis.problem(), self.state, self.logs, self.at, place, law)
            })
        };
        let laws = largest_law.map_or_else(Vec::new, |law| with_plainer_ones(law, goes_before_law));
        if let [law, first, ..] = laws[..]
            && let Some(&plain) = laws.last()
        {
            let goes_before = |own: usize, place: usize| {
                goes_before(self.diagnosis.problem(), self.state, self.logs, self.at, own, place)
            };
            // Beside a law of implausible size nothing between it and the first that goes before it is worth more than that.
            let is_outdone = |place: usize| {
                is_implausible(self.state, self.at, law) && self.logs[place] > self.logs[first]
                    || laws.contains(&place)
                    || laws[1..].iter().any(|&own| goes_before(own, place))
            };
            let more = self.next().map(|one| one.1).filter(|&place| self.logs[place] > self.logs[plain]);
            let others: Vec<usize> = more.filter(|&place| is_outdone(place)).collect();
            others.into_iter().for_each(|place| logs[place] = self.logs[plain] - STANDS_BEHIND);
        }
        failing.iter().for_each(|&place| logs[place] = f64::NEG_INFINITY);
        logs
    }

    /// What may be added, the most probable first, and the probability that nothing is.
    fn weighed(&self, logs: &[f64]) -> (Vec<Addition>, f64) {
        let all: Vec<f64> = self.next().map(|one| logs[one.1]).chain([logs[self.at]]).collect();
        let total = log_sum_exp(&all);
        let addition =
            |(effect, place): (usize, usize)| Addition { effect, place, probability: exp(logs[place] - total) };
        let mut additions: Vec<Addition> = self.next().map(addition).collect();
        sort_by_probability(&mut additions);
        (additions, exp(logs[self.at] - total))
    }

    fn leading<'b>(&self, additions: &'b [Addition]) -> Leading<'b> {
        let of_one_input = |one: &&Addition| self.is_curve(one) && self.candidate(one).bound.len() == 1;
        let mut paying = additions.iter().filter(|one| self.pays(one));
        Leading { law: paying.clone().find(|one| !self.is_curve(one)), curve: paying.find(of_one_input) }
    }

    /// The effect that goes first by the order of laws, curves and whole surfaces, however likely it is.
    fn first<'b>(
        &self,
        logs: &[f64],
        additions: &'b [Addition],
        leading: &Leading<'b>,
        largest_law: f64,
    ) -> Option<&'b Addition> {
        let Some(law) = leading.law else {
            return leading.curve.or_else(|| additions.iter().find(|one| self.pays(one)));
        };
        if is_implausible(self.state, self.at, law.place) {
            // A law that has to be a hundred times as large as is plausible is no better than a curve of plausible size.
            let is_plausible = |one: &&Addition| self.is_curve(one) && is_as_written(self.state, one.effect, one.place);
            let curve = additions.iter().filter(|one| self.pays(one)).find(is_plausible);
            if let Some(curve) = curve.filter(|curve| logs[curve.place] > logs[law.place]) {
                return Some(curve);
            }
        }
        let errors = |curve: &Addition| unseen(&self.state.refits[law.place], &self.state.refits[curve.place]);
        if let Some(curve) = leading.curve
            && curve_goes_first(logs[curve.place] - largest_law, errors(curve))
        {
            return Some(curve);
        }
        let laws: Vec<&Addition> = additions.iter().filter(|one| self.pays(one) && !self.is_curve(one)).collect();
        let is_rival_elsewhere = |one: &Addition, other: &Addition| {
            !self.is_of_group(other)
                && self.is_elsewhere(one, other)
                && one.probability * RIVALS_WITHIN < other.probability
        };
        let of_step = |one: &&Addition| LawOfStep {
            log: logs[one.place],
            is_of_group: self.is_of_group(one),
            is_elsewhere: self.is_elsewhere(one, law),
            has_rival_elsewhere: laws.iter().any(|other| is_rival_elsewhere(one, other)),
        };
        let first = whole_surface_first(&laws.iter().map(of_step).collect::<Vec<_>>());
        laws.get(first).copied()
    }

    /// Whether an effect is that of a whole surface that goes before the most probable law, which acts at a single place.
    fn goes_before_places(&self, law: Option<&Addition>, one: &Addition) -> bool {
        law.is_some_and(|law| self.is_of_group(one) && !self.is_of_group(law))
    }

    /// Probability of the most probable rival of an effect.
    fn most_wanted(&self, additions: &[Addition], law: Option<&Addition>, one: &Addition) -> f64 {
        let is_rival = |other: &&Addition| {
            (!self.goes_before_places(law, one) || self.is_of_group(other))
                && (law.is_none() || self.diagnosis.is_last_resort(one.effect) || !self.is_curve(other))
        };
        additions.iter().filter(is_rival).map(|other| other.probability).fold(0.0, f64::max)
    }

    /// Leaves curves out beside a law that is added: they are asked only after the laws. Sets single places back behind the surface that
    /// goes before them, whatever they gain beyond it: errors of the model decide that.
    fn set_back(&self, chosen: &Addition, goes_before_places: bool, additions: &mut Vec<Addition>, stays: &mut f64) {
        additions.retain(|one| !self.is_curve(one));
        let most = chosen.probability * exp(-SINGLE_PLACE);
        let is_behind =
            |one: &Addition| goes_before_places && !self.is_of_group(one) && !self.is_elsewhere(chosen, one);
        let behind = additions.iter_mut().filter(|one| is_behind(one));
        behind.for_each(|one| one.probability = (one.probability * exp(-SINGLE_PLACE)).min(most));
        sort_by_probability(additions);
        let rest = *stays + additions.iter().map(|one| one.probability).sum::<f64>();
        additions.iter_mut().for_each(|one| one.probability /= rest);
        *stays /= rest;
    }
}

/// The most probable first, those that are as probable in the order of the candidates.
fn sort_by_probability(additions: &mut [Addition]) {
    sort_by(additions, |a, b| b.probability.total_cmp(&a.probability).then(a.effect.cmp(&b.effect)));
}
