//! Which effects explain nearly as much as a selected one, where the model has errors of its own.
//!
//! Errors of a model decide between effects that resemble each other: the same loss at the next node, another law between
//! the same two. How far they can go is seen from small effects that were selected as well: what one of them gains, a
//! wrong effect may gain on the right one.

use crate::diagnosis::odds::posterior_odds::{MOST_RIVALS, RIVALS_WITHIN};
use crate::diagnosis::odds::sampling::{odds_by_chance, standard_error};
use crate::diagnosis::verdict::findings::Findings;
use crate::math::functions::{exp, ln};
use crate::math::sort::sort_by;

/// Log odds by which the small effect that gains most stands before another one, in squares of a standard normal deviate: the largest
/// of about ten has twice their logarithm (Cramér 1946, Mathematical Methods of Statistics, section 28.6).
const LARGEST_OF_SOME: f64 = 4.6;

/// An effect that explains nearly as much as a member of the selected set.
#[derive(Clone, Debug, PartialEq)]
struct Alternative {
    /// Position of the group of the member.
    group: usize,
    effect: usize,
    /// Position of the set with it that lags least.
    place: usize,
    /// Log odds by which that set stands behind the best one with the member.
    lag: f64,
    /// Position of the latter.
    best: usize,
}

impl Findings<'_> {
    /// Adds the effects that explain nearly as much to the groups, and takes their share from the members.
    pub(super) fn add_nearly_as_good(&mut self) {
        let has_small = self.members().iter().any(|&effect| self.is_minor(effect));
        let logs: Vec<f64> = match &self.story {
            Some(story) => story.logs.clone(),
            None if has_small => self.weights.sets.iter().map(|weight| ln(*weight)).collect(),
            None => return,
        };
        let tempering = self.tempering(&logs);
        let odds = |own: &Alternative| exp(-own.lag.max(0.0) / tempering).max(self.odds_by_chance(own));
        let may_stand = |own: &Alternative| !self.fails_beside(self.groups[own.group][0], own.effect);
        let mut all: Vec<(f64, Alternative)> =
            self.lags(&logs).into_iter().filter(may_stand).map(|own| (odds(&own), own)).collect();
        sort_by(&mut all, |a, b| {
            b.0.total_cmp(&a.0).then(a.1.lag.total_cmp(&b.1.lag)).then(a.1.effect.cmp(&b.1.effect))
        });
        let members = self.members();
        for group in 0..self.groups.len() {
            let is_near = |(odds, own): &&(f64, Alternative)| own.group == group && odds * RIVALS_WITHIN >= 1.0;
            let near: Vec<&(f64, Alternative)> = all.iter().filter(is_near).take(MOST_RIVALS).collect();
            let total = 1.0 + near.iter().map(|(odds, _)| odds).sum::<f64>();
            let member = self.groups[group][0];
            let most = self.probability_as_weighed(member).min(1.0 / total);
            self.shared.insert((group, member), most);
            for (odds, own) in near {
                let share = self.probability_as_weighed(own.effect).max(odds / total);
                self.shared.insert((group, own.effect), share);
                // It may stand for several members, in different sets.
                if !members.contains(&own.effect) && !self.groups[group].contains(&own.effect) {
                    self.groups[group].push(own.effect);
                }
                if !self.rivals.contains(&own.place) && self.rivals.len() <= MOST_RIVALS {
                    self.rivals.push(own.place);
                }
            }
        }
    }

    /// Odds that an effect stands behind by chance, where models have errors of their own.
    fn odds_by_chance(&self, own: &Alternative) -> f64 {
        let of_blocks = self.story.as_ref().map(|story| &story.of_blocks);
        let se = of_blocks.and_then(|of| standard_error(&of[own.best], &of[own.place]));
        se.map_or(0.0, |se| odds_by_chance(own.lag, se))
    }

    /// Whether an effect is so small that errors of the model may well be what it explains. What a story begins with is not small,
    /// whatever else speaks against it.
    fn is_minor(&self, effect: usize) -> bool {
        let begins = self.story.is_some() && self.members().first() == Some(&effect);
        self.is_small(effect) && !begins
    }

    /// Members of the selected set, in the order of the groups.
    fn members(&self) -> Vec<usize> {
        self.groups.iter().filter_map(|group| group.first()).copied().collect()
    }

    /// By what log odds are divided: the variance of what errors of the model gain along one direction, beside that of the
    /// noise. Half the square of a deviate is what it gains.
    fn tempering(&self, logs: &[f64]) -> f64 {
        let refits = &self.state.refits;
        let own = &refits[self.selected].effects;
        let gain = |effect: &usize| {
            let rest = own.iter().filter(|other| *other != effect);
            let before = refits.iter().position(|refit| refit.effects.iter().eq(rest.clone()))?;
            Some(logs[self.selected] - logs[before]).filter(|gain| gain.is_finite())
        };
        let small = own.iter().filter(|&&effect| self.is_minor(effect));
        1.0 + 2.0 * small.filter_map(gain).fold(0.0, f64::max) / LARGEST_OF_SOME
    }

    /// The least lag of every effect that can stand in the place of a large member, among sets of one size.
    fn lags(&self, logs: &[f64]) -> Vec<Alternative> {
        let refits = &self.state.refits;
        let members = self.members();
        let large: Vec<usize> = (0..members.len()).filter(|&group| !self.is_minor(members[group])).collect();
        let alone = |effect: usize| {
            let place = refits.iter().position(|refit| refit.effects == [effect]);
            place.map_or(f64::NEG_INFINITY, |place| logs[place])
        };
        let is_unknown = |effect: usize| self.problem.is_unknown_function(effect);
        // A single place comes after the whole surface of which it is a part.
        let is_behind = |other: usize, one: usize| {
            let [other, one] = [other, one].map(|effect| &self.problem.candidates[effect]);
            one.is_group() && !other.is_group() && !one.is_elsewhere_than(other)
        };
        let mut found: Vec<Alternative> = Vec::new();
        let mut best: Option<usize> = None;
        for size in large.len().max(1)..=members.len() + 1 {
            let of_size =
                || (0..refits.len()).filter(|&place| refits[place].effects.len() == size && logs[place].is_finite());
            let has_all = |place: &usize| large.iter().all(|&group| refits[*place].effects.contains(&members[group]));
            // What a larger set may gain beside the members was perhaps not tried.
            let more_probable = |a: usize, b: usize| if logs[b] > logs[a] { b } else { a };
            best = best.into_iter().chain(of_size().filter(has_all)).reduce(more_probable);
            let Some(best) = best else { continue };
            for place in of_size() {
                let effects = &refits[place].effects;
                let absent: Vec<usize> =
                    large.iter().copied().filter(|&group| !effects.contains(&members[group])).collect();
                // Beyond those that stand for large members, as many stand for small ones.
                let small_absent = members.len()
                    - large.len()
                    - effects.iter().filter(|effect| members.contains(effect) && self.is_minor(**effect)).count();
                let mut others: Vec<usize> =
                    effects.iter().copied().filter(|effect| !members.contains(effect)).collect();
                // The strongest stands for the strongest.
                sort_by(&mut others, |&a, &b| alone(b).total_cmp(&alone(a)).then(a.cmp(&b)));
                for (position, &effect) in others.iter().enumerate() {
                    let is_for_small = (absent.len()..absent.len() + small_absent).contains(&position);
                    let Some(&group) = absent.get(position).or(absent.last()).filter(|_| !is_for_small) else {
                        continue;
                    };
                    // Curves come after laws.
                    let (one, other) = (members[group], effect);
                    // What changes nothing explains nothing.
                    if (is_unknown(other) && !is_unknown(one))
                        || is_behind(other, one)
                        || refits[place].does_nothing(other)
                    {
                        continue;
                    }
                    let lag = logs[best] - logs[place];
                    match found.iter_mut().find(|own| own.group == group && own.effect == effect) {
                        Some(known) if known.lag <= lag => {}
                        Some(known) => (known.lag, known.place, known.best) = (lag, place, best),
                        None => found.push(Alternative { group, effect, place, lag, best }),
                    }
                }
            }
        }
        found
    }
}
