//! The search through sets of effects, from round to round: which of them go on from what was fitted.

use std::collections::BTreeMap;

use crate::diagnosis::engine::{Diagnosis, Remainder, SINGLES, State};
use crate::diagnosis::fits::exchange::exchanges;
use crate::diagnosis::fits::refit::Amplitude;
use crate::diagnosis::misspecified::is_unstated;
use crate::diagnosis::odds::posterior_odds::{best, log_posterior_weights, posterior_odds};
use crate::diagnosis::screening::screen::{Lead, Screening};
use crate::diagnosis::story::rules::falls;
use crate::diagnosis::{FitError, Problem};
use crate::math::sort::sort_by;

/// Effects that are tried beside a set, or in the place of one of its members.
const BESIDE: usize = 8;
/// Falls of the sum of squares that differ by less are those of rivals: by a factor of 100 in probability.
const NEAR: f64 = 9.2;
/// Most rounds of extension.
const MOST_ROUNDS: u32 = 8;
/// Most times that other sets than the best one are extended.
const MOST_ASIDE: u32 = 6;
/// Single effects from which sets are sought that the best one does not lead to.
const MOST_SEEDS: usize = 3;
/// How often probable sets are fitted without each of their members: once more where that changed which are probable.
const MOST_WITHOUT_MEMBERS: u32 = 2;
/// Probability of such a set.
const PROBABLE: f64 = 0.01;
/// Most of them.
const MOST_PROBABLE: usize = 8;
/// Most effects of a set of which all parts are fitted.
const MOST_PARTED: usize = 4;
/// Laws that predict unseen rows best that are fitted beside a set that is extended.
const MOST_BEST_UNSEEN: usize = 3;
/// Standard deviations by which levels of a member in two sets are others.
const OTHER_LEVEL: f64 = 5.0;
/// Exchanges of channels that are fitted beside a set that is extended.
const EXCHANGES_BESIDE: usize = 2;

/// The best effects, of those within [`NEAR`] of the first as many as these two numbers allow.
fn near(leads: &[Lead], least: usize, most: usize) -> impl Iterator<Item = &Lead> {
    let best = leads.first().map_or(0.0, |lead| lead.fall);
    let count = leads.iter().filter(|lead| best - lead.fall < NEAR).count();
    leads.iter().take(count.clamp(least, most))
}

/// What screenings found, by the position of the set beside which they were made.
type Screened = BTreeMap<usize, Result<Screening, FitError>>;

impl State {
    /// The effects that explain most of what a set leaves, where that is known.
    fn leads_beside(&self, effects: &[usize]) -> Option<&[Lead]> {
        let of = self.remainders.iter().rev().find(|left| left.effects == effects);
        of.map(|left| left.leads.as_slice()).filter(|leads| !leads.is_empty())
    }
}

impl Diagnosis {
    /// Orders the sets that go on from the best one; where there are none, without
    /// readings that are faults of the data, or with another model error, if there are such.
    pub fn extend(&self, state: State) -> State {
        let (left_out, excursions) = (state.left_out.clone(), state.excursions.clone());
        let mut next = self.at(&state).extended(state);
        if next.left_out.is_empty() {
            next.left_out = left_out;
        }
        if next.excursions.is_empty() {
            next.excursions = excursions;
        }
        next
    }

    fn extended(&self, state: State) -> State {
        let mut state = self.search(state);
        if state.pending.is_empty() && !state.is_misspecified() && state.without_members < MOST_WITHOUT_MEMBERS {
            state.without_members += 1;
            self.order_without_members(&mut state);
        }
        if state.pending.is_empty() {
            match self.leave_out(&state) {
                Ok(Some(next)) => return next,
                Ok(None) => {}
                Err(why) => state.warn(why),
            }
            match self.allow_for_model_error(&state) {
                Ok(Some(next)) => return next,
                Ok(None) => {}
                Err(why) => state.warn(why),
            }
        }
        state
    }

    /// As [`Diagnosis::refine`]; what fails there is a warning.
    fn refined(&self, problem: &Problem, state: &mut State, place: usize) -> Option<State> {
        match self.refine(problem, state, place) {
            Ok(next) => next,
            Err(why) => {
                state.warn(why);
                None
            }
        }
    }

    /// Tests what the best set leaves, and orders the sets that go on from it.
    fn search(&self, mut state: State) -> State {
        state.pending.clear();
        state.rounds += 1;
        if state.model_errors == 0 && self.problem().measurements.iter().any(is_unstated) {
            // What was fitted so far shows the errors' size.
            return state;
        }
        if state.rounds == 1 {
            match self.estimate_noise_again(&state) {
                Ok(Some(next)) => return next,
                Ok(None) => {}
                Err(why) => state.warn(why),
            }
        }
        let problem = self.with_noise(&state.noise, &state.most_steps);
        if state.is_pilot {
            state.is_pilot = false;
            state.rounds = 0;
            self.order_first(&problem, &mut state);
            return state;
        }
        if problem.is_misspecified {
            // Step by step: what a larger set gains there is as likely to be model error.
            let story = self.story(&state);
            let place = story.end();
            if story.finds_no_plausible_law(&state) {
                let curves = state.screening.leads.clone();
                let curves = curves.iter().filter(|lead| self.is_last_resort(lead.candidate));
                curves.take(BESIDE).for_each(|lead| state.order(&[lead], &[], 0));
            }
            if let Some(next) = self.refined(&problem, &mut state, place) {
                return next;
            }
            self.order_parts(&mut state, place);
            self.extend_step(&problem, &mut state, place);
            // A larger set from another beginning has an advantage until this one is extended too.
            let end = state.refits[place].effects.clone();
            if let Some(own) =
                story.beginning.filter(|&own| !state.refits[own].effects.iter().all(|one| end.contains(one)))
            {
                self.extend_step(&problem, &mut state, own);
            }
            return state;
        }
        let weights = posterior_odds(self.problem(), &state.refits, None);
        let Some(place) = best(&weights) else { return state };
        if let Some(next) = self.refined(&problem, &mut state, place) {
            return next;
        }
        if state.was_extended(place) {
            while state.pending.is_empty() && state.aside < MOST_ASIDE {
                let Some(place) = self.aside(&state, place) else { break };
                state.aside += 1;
                let mut screened = self.screen_around(&problem, &state, place);
                self.extend_set(&problem, &mut state, place, &mut screened);
                self.replace_members(&problem, &mut state, place, &mut screened);
            }
        } else if !state.refits[place].effects.is_empty()
            && state.rounds.saturating_sub(state.aside) <= MOST_ROUNDS * (1 + state.model_errors)
        {
            let mut screened = self.screen_around(&problem, &state, place);
            self.extend_set(&problem, &mut state, place, &mut screened);
            self.order_at_prior_medians(&problem, &mut state, place);
            self.order_like(&mut state, place);
            self.replace_members(&problem, &mut state, place, &mut screened);
        }
        state
    }

    /// Orders what goes on from a set of a story, where that was not done.
    fn extend_step(&self, problem: &Problem, state: &mut State, place: usize) {
        if place > 0 && !state.was_extended(place) {
            let mut screened = self.screen_around(problem, state, place);
            self.extend_set(problem, state, place, &mut screened);
            self.order_like(state, place);
            self.order_best_unseen(state, place);
            self.replace_members(problem, state, place, &mut screened);
        }
    }

    /// Screens what a set leaves, and what it leaves without each of its members where that is not known.
    fn screen_around(&self, problem: &Problem, state: &State, place: usize) -> Screened {
        let set = &state.refits[place].effects;
        let mut places = vec![place];
        for &member in set.iter().filter(|_| set.len() > 1) {
            let rest: Vec<usize> = set.iter().copied().filter(|&other| other != member).collect();
            if state.leads_beside(&rest).is_none() {
                places.extend(state.refits.iter().position(|refit| refit.effects == rest));
            }
        }
        // Each has work for all threads; side by side they would only take more memory.
        places.into_iter().map(|place| (place, self.screen_beside(problem, &state.refits[place]))).collect()
    }

    /// Tests what a set leaves, and orders those with one or two effects more where that is something.
    fn extend_set(&self, problem: &Problem, state: &mut State, place: usize, screened: &mut Screened) {
        let set = state.refits[place].effects.clone();
        let screening = match screened.remove(&place) {
            Some(Ok(screening)) => screening,
            Some(Err(why)) => return state.warn(why),
            None => return,
        };
        let leads = screening.leads.iter().take(2 * BESIDE).cloned().collect();
        state.remainders.push(Remainder { effects: set.clone(), p: screening.family.p, leads });
        let finds = self.finds(&screening) || problem.is_misspecified;
        if !finds || set.len() as u64 >= self.settings().most {
            return;
        }
        for lead in near(&screening.leads, 2 * BESIDE, SINGLES) {
            if !(problem.is_misspecified && self.is_last_resort(lead.candidate)) {
                state.order(&[lead], &set, place);
            }
        }
        let with = problem.with(&state.refits[place]);
        // What cannot be made beside this set was tried alone before.
        match with.and_then(|with| exchanges(&with, &state.refits[place], EXCHANGES_BESIDE)) {
            Ok(found) => {
                for candidate in found.likeliest {
                    state.order(&[&Lead { candidate, fall: 0.0, starts: vec![BTreeMap::new()] }], &set, place);
                }
            }
            Err(why) => state.warn(why),
        }
        if set.len() as u64 + 2 <= self.settings().most && !problem.is_misspecified {
            for pair in screening.pairs.iter().take(BESIDE) {
                state.order(&[&pair[0], &pair[1]], &set, place);
            }
        }
    }

    /// The next set to extend when the best one, of several effects or with a curve, is done: single steps from the best
    /// single effect may not lead to the best set. The best set of effects with names, where a curve belongs to the best one; and
    /// where that is large, or something is still found beside it, the best ones with each of the single effects that
    /// explain most at places of their own, while they are smaller.
    pub fn aside(&self, state: &State, leader: usize) -> Option<usize> {
        let leading = &state.refits[leader].effects;
        let logs = log_posterior_weights(self.problem(), &state.refits);
        let is_named = |effects: &[usize]| !effects.iter().any(|&effect| self.is_unknown_function(effect));
        let effects = |place: usize| state.refits[place].effects.as_slice();
        let best_of = |allowed: &dyn Fn(&[usize]) -> bool| {
            let better = |a: usize, b: usize| if logs[b] > logs[a] { b } else { a };
            let is_allowed =
                |&place: &usize| !effects(place).is_empty() && is_named(effects(place)) && allowed(effects(place));
            (0..state.refits.len()).filter(is_allowed).reduce(better)
        };
        let is_new = |place: &usize| !state.was_extended(*place);
        if !is_named(leading)
            && let Some(place) = best_of(&|effects| effects.len() <= leading.len()).filter(is_new)
        {
            return Some(place);
        }
        let place_of = |effect: usize| &self.problem().candidates[effect].place;
        let mut places: Vec<_> = leading.iter().map(|&effect| place_of(effect)).collect();
        let left = state.remainders.iter().find(|remainder| remainder.effects == *leading);
        let is_doubtful = leading.len() > 2 || left.is_some_and(|left| left.p <= self.settings().false_alarm);
        for _ in 0..if leading.len() > 1 && is_doubtful { MOST_SEEDS } else { 0 } {
            let seed = best_of(&|effects| effects.len() == 1 && !places.contains(&place_of(effects[0])))?;
            let seed = effects(seed)[0];
            places.push(place_of(seed));
            let with = best_of(&|effects| effects.contains(&seed) && effects.len() < leading.len());
            if with.is_some_and(|place| is_new(&place)) {
                return with;
            }
        }
        None
    }

    /// Orders the sets with one more effect that stands out where the parameters are at the medians of their priors, if what
    /// is still missing bends the fit with the set: a parameter that a bound holds gives way only far from there, which
    /// no linearisation at the bound tells.
    fn order_at_prior_medians(&self, problem: &Problem, state: &mut State, place: usize) {
        let set = state.refits[place].effects.clone();
        if set.len() as u64 >= self.settings().most {
            return;
        }
        let with = problem.with(&state.refits[place]);
        match with.and_then(|with| self.leads_at_prior_medians(&with, &state.refits[place])) {
            Ok(leads) => leads.iter().take(BESIDE).for_each(|lead| state.order(&[lead], &set, place)),
            Err(why) => state.warn(why),
        }
    }

    /// Orders the sets in which another law stands at the place of a member. At the baseline fit, which a strong effect bends,
    /// their linearisations may have missed the best of them.
    fn order_like(&self, state: &mut State, place: usize) {
        let set = state.refits[place].effects.clone();
        let candidates = &self.problem().candidates;
        let unseen: Vec<usize> = state.screening.unseen.iter().map(|(candidate, _)| *candidate).collect();
        for &member in &set {
            let own = &candidates[member];
            let rest: Vec<usize> = set.iter().copied().filter(|&other| other != member).collect();
            let is_like = |&other: &usize| {
                let one = &candidates[other];
                one.place == own.place
                    && one.where_kind == own.where_kind
                    && (one.input.is_none() || one.input == own.input)
                    && !set.contains(&other)
                    && !self.is_unknown_function(other)
                    // What plausible sizes would not show, larger ones may.
                    && (one.steady || !unseen.contains(&other))
            };
            for candidate in (0..candidates.len()).filter(is_like).take(BESIDE) {
                state.order(&[&Lead { candidate, fall: 0.0, starts: vec![BTreeMap::new()] }], &rest, place);
            }
        }
    }

    /// Orders a set with the single laws that predict unseen rows best, where these err clearly less there than without any: what fits
    /// the fitted rows best may leave a law to be seen only there.
    fn order_best_unseen(&self, state: &mut State, place: usize) {
        let set = state.refits[place].effects.clone();
        let base = state.refits[0].rmse_held_out_k;
        if set.len() as u64 >= self.settings().most {
            return;
        }
        let mut laws: Vec<(f64, usize)> = Vec::new();
        for (single, refit) in state.refits.iter().enumerate().filter(|(_, refit)| refit.effects.len() == 1) {
            let is_law = !self.is_unknown_function(refit.effects[0]);
            if let Some(error) = refit.rmse_held_out_k.filter(|_| is_law && falls([base, refit.rmse_held_out_k])) {
                laws.push((error, single));
            }
        }
        sort_by(&mut laws, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, single) in laws.into_iter().take(MOST_BEST_UNSEEN) {
            let candidate = state.refits[single].effects[0];
            state.order(&[&Lead { candidate, fall: 0.0, starts: vec![BTreeMap::new()] }], &set, place);
        }
    }

    /// Orders the parts of a set, and of the most probable one of laws, that were not fitted: which effect explains most is
    /// seen only where each stands alone too.
    fn order_parts(&self, state: &mut State, place: usize) {
        let logs = log_posterior_weights(self.problem(), &state.refits);
        let is_of_laws = |&place: &usize| !state.refits[place].effects.iter().any(|&one| self.is_unknown_function(one));
        let likeliest = (0..logs.len()).filter(is_of_laws).reduce(|a, b| if logs[b] > logs[a] { b } else { a });
        for whole in [Some(place), likeliest].into_iter().flatten() {
            let effects = state.refits[whole].effects.clone();
            for chosen in 1..(1_u64 << effects.len().min(MOST_PARTED)) - 1 {
                let is_in = |position: &usize| chosen >> position & 1 == 1;
                let part: Vec<usize> = (0..effects.len()).filter(is_in).map(|position| effects[position]).collect();
                state.order(&[], &part, whole);
            }
            self.order_at_levels(state, whole);
        }
    }

    /// Orders members of a set once more alone where they were fitted at other levels than in the set, such as another temperature of
    /// melting: no slope leads from one level to the next.
    fn order_at_levels(&self, state: &mut State, whole: usize) {
        let effects = state.refits[whole].effects.clone();
        if effects.len() < 2 || state.at_levels.contains(&effects) {
            return;
        }
        for (position, &effect) in effects.iter().enumerate() {
            let alone = state.refits.iter().find(|refit| refit.effects == [effect]);
            let is_elsewhere = alone.is_some_and(|alone| {
                let pairs = alone.amplitudes[0].iter().zip(&state.refits[whole].amplitudes[position]);
                let apart = |(own, other): (&Amplitude, &Amplitude)| {
                    (own.mode - other.mode).abs() > OTHER_LEVEL * own.sd.max(other.sd)
                };
                pairs.zip(self.are_amplitudes(effect)).any(|(pair, is_amplitude)| !is_amplitude && apart(pair))
            });
            if is_elsewhere {
                state.order_again(vec![effect], whole);
            }
        }
        state.at_levels.push(effects);
    }

    /// Which parameters of an effect are amplitudes, in the order of its file.
    fn are_amplitudes(&self, effect: usize) -> Vec<bool> {
        let problem = self.problem();
        let candidate = &problem.candidates[effect];
        let file = problem.catalogue.get(&candidate.effect);
        let parameters = file.map(|file| file.parameters(&problem.model, &candidate.bound)).unwrap_or_default();
        parameters.iter().map(|parameter| parameter.amplitude).collect()
    }

    /// Orders probable sets without each of their members, where these were not fitted: what a member explains is known beside
    /// the others.
    pub fn order_without_members(&self, state: &mut State) {
        let weights = posterior_odds(self.problem(), &state.refits, None);
        let mut places: Vec<usize> = (0..state.refits.len()).filter(|&place| weights.sets[place] >= PROBABLE).collect();
        sort_by(&mut places, |&a, &b| weights.sets[b].total_cmp(&weights.sets[a]));
        for place in places.into_iter().take(MOST_PROBABLE) {
            let set = state.refits[place].effects.clone();
            for &member in set.iter().filter(|_| set.len() > 1) {
                let rest: Vec<usize> = set.iter().copied().filter(|&other| other != member).collect();
                state.order(&[], &rest, place);
            }
        }
    }

    /// Orders the sets in which another effect stands in the place of a member, and those without it.
    fn replace_members(&self, problem: &Problem, state: &mut State, place: usize, screened: &mut Screened) {
        let set = state.refits[place].effects.clone();
        if set.len() < 2 {
            return;
        }
        for &member in &set {
            let rest: Vec<usize> = set.iter().copied().filter(|&other| other != member).collect();
            let Some(from) = state.refits.iter().position(|refit| refit.effects == rest) else {
                state.order(&[], &rest, place);
                continue;
            };
            // What does nothing is not needed: without it the fit is at least as good, unless it stopped elsewhere.
            if state.refits[place].does_nothing(member) && !rest.is_empty() {
                state.order_again(rest.clone(), place);
            }
            let leads = match screened.remove(&from) {
                Some(Ok(screening)) => screening.leads,
                Some(Err(why)) => {
                    state.warn(why);
                    continue;
                }
                None => state.leads_beside(&rest).unwrap_or_default().to_vec(),
            };
            for lead in near(&leads, BESIDE, 2 * BESIDE) {
                if !(problem.is_misspecified && self.is_last_resort(lead.candidate)) {
                    state.order(&[lead], &rest, from);
                }
            }
        }
    }
}
