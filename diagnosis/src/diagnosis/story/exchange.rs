//! When an effect of a story gives way to another: what was added first may stand for what is only seen beside later ones.

use crate::diagnosis::engine::{Diagnosis, State};
use crate::diagnosis::story::plainness::Plainness;
use crate::diagnosis::story::rules::{
    ALIKE_SHARE, AskedOfUnseen, CLEARLY, MINOR_SHARE, falls, least_lead, rises, surface_explains_alike,
};
use crate::diagnosis::story::sets::{Logs, pays, unseen, why_plainer};
use crate::diagnosis::story::step::{Addition, Step};

/// A set that displaces that of a story.
struct Exchange {
    /// Its position, by which it is weighed.
    place: usize,
    /// Position of the set to which the story goes: with a whole surface, where that explains as much.
    to: usize,
    /// Number of the step of the effect that it displaces.
    number: usize,
}

impl Diagnosis {
    /// The most probable set with so many effects more than the end of a story that is more probable than it, with another effect in the
    /// place of an earlier one, and the number of that one's step. The other explained as much when that one was added, or that one is a minor
    /// member beside what was added since. A larger set has to be clearly more probable, and to err less on unseen rows; the other
    /// then has to pay alone.
    pub(super) fn exchange(
        &self,
        state: &State,
        logs: &Logs,
        end: usize,
        steps: &[Step],
        more: usize,
    ) -> Option<(usize, usize)> {
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
        let earlier = if more == 0 { steps.len().saturating_sub(1) } else { steps.len() };
        for (number, step) in steps.iter().enumerate().take(earlier) {
            let chosen = step.chosen?;
            let gain = logs[chosen] - logs[step.before];
            let member =
                state.refits[chosen].effects.iter().find(|one| !state.refits[step.before].effects.contains(one))?;
            let is_alike = |one: &&Addition| logs[chosen] - logs[one.place] < CLEARLY.max(ALIKE_SHARE * gain);
            let pays = |one: &&Addition| more > 0 && pays(state, logs, step.before, one.place, AskedOfUnseen::Fall);
            let may_displace = |one: &&Addition| {
                !step.failing.contains(&one.effect) && (is_alike(one) || is_minor(*member) || pays(one))
            };
            // Whether the chosen effect is logged heat that explained nearly as much at the step as another one.
            let is_logged_before = |one: &Addition| {
                let why = why_plainer(self.problem(), state, &logs.drivers, step.before, [chosen, one.place]);
                why.is_some_and(Plainness::is_of_logged_heat)
            };
            for other in step.additions.iter().filter(may_displace) {
                // What follows a control's heat displaces nothing else: with any other effect it explains what is missing.
                if logs.drivers.only_other_follows_control(*member, other.effect) {
                    continue;
                }
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
                // A single place displaces a whole surface only where it would go before that, a law of several inputs one of one, and heat by a
                // clock, or a change by a logged heat, that heat where it explained nearly as much at the step.
                let [own, rival] = [*member, other.effect].map(|one| &self.problem().candidates[one]);
                let displaces_surface = own.is_group() && !rival.is_group() && !own.is_elsewhere_than(rival);
                let is_behind = is_logged_before(other);
                let is_less_plain = own.bound.len() < 2 && rival.bound.len() > 1 || is_behind;
                let was_less_probable = is_behind && logs[other.place] < logs[chosen];
                let least = logs[end] + least_lead(more > 0, displaces_surface || is_less_plain, was_less_probable);
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

    /// What a set gains by a member, in log odds; without end where the set without it was not fitted.
    fn gain_of(&self, state: &State, logs: &[f64], set: usize, member: usize) -> f64 {
        let rest = state.refits[set].effects.iter().filter(|&&one| one != member);
        let without = state.refits.iter().position(|refit| refit.effects.iter().eq(rest.clone()));
        without.map_or(f64::INFINITY, |without| logs[set] - logs[without])
    }
}
