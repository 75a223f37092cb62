//! The rules by which effects are added, as functions of log odds and errors.

use crate::diagnosis::RISES;
use crate::diagnosis::odds::posterior_odds::RIVALS_WITHIN;

/// Log odds that are clear: by which a curve goes before a law, or a single place before a whole surface, and within which
/// effects explain as much as one another.
pub(crate) const CLEARLY: f64 = 10.0;
/// Log odds by which a single place stands behind a whole surface that explains as much.
pub(crate) const SINGLE_PLACE: f64 = 3.0;
/// Share of the gain of a step in log odds within which effects explain as much as one another.
pub(crate) const ALIKE_SHARE: f64 = 0.1;
/// Share of what an effect of a hundred times the plausible size explains, in squares of errors, that one of plausible size
/// has to explain to go before it; and where it predicts unseen rows clearly better.
pub(crate) const EXPLAINS_ALIKE: f64 = 0.95;
const EXPLAINS_MOST: f64 = 0.8;
/// Log odds by which the former then stands behind, and a law behind a plainer one that explains nearly as much.
pub(crate) const STANDS_BEHIND: f64 = 1.0;
/// Share of the squares of errors that an effect has to explain, on the fitted and on the unseen rows, so that what the fitted rows want
/// more and what fails on the unseen ones is no rival of it: errors of the model help on one of them only.
const EXPLAINS_ON_BOTH: f64 = 0.5;
/// Share of what an effect explains, in squares of errors on the fitted and on the unseen rows, that another has to explain to go before it
/// where the former follows a control or a clock, which go with whatever is missing, or changes something by what warms.
const EXPLAINS_NEARLY: f64 = 0.9;
/// Share of the largest gain of a member below which a member is a minor one, which gives way to any that explains more.
pub(crate) const MINOR_SHARE: f64 = 0.2;
/// Log Bayes factor on the fitted rows, downwards, from which they speak against an effect; less is not worth more than a bare mention
/// (Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 773).
const SPEAKS_AGAINST: f64 = -1.0;
/// The same where what speaks for the effect outweighs it clearly: what is more is strong evidence (Kass & Raftery 1995).
const SPEAKS_STRONGLY_AGAINST: f64 = -3.0;

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

/// Whether an effect explains such a share of the squares of errors that another does, on the fitted and on the unseen rows: errors on each
/// without both, with it and with the other.
fn explains_share(share: f64, fitted: [Option<f64>; 3], unseen: [Option<f64>; 3]) -> bool {
    let explains = |errors: [Option<f64>; 3]| match errors {
        [Some(without), Some(own), Some(other)] => {
            without * without - own * own >= share * (without * without - other * other) && own < without
        }
        _ => true,
    };
    matches!(fitted, [Some(_), Some(_), Some(_)]) && explains(fitted) && explains(unseen)
}

/// Whether an effect explains nine tenths of what another does that follows a control or a clock, or changes something by what warms.
pub fn explains_nearly_as_much(fitted: [Option<f64>; 3], unseen: [Option<f64>; 3]) -> bool {
    explains_share(EXPLAINS_NEARLY, fitted, unseen)
}

/// Whether an effect explains 95 % of what another does.
pub fn explains_as_much(fitted: [Option<f64>; 3], unseen: [Option<f64>; 3]) -> bool {
    explains_share(EXPLAINS_ALIKE, fitted, unseen)
}

/// A law, what goes before it, what goes before that, and so on: the plainest comes last. `before` gives what goes before a law.
pub fn with_plainer_ones(law: usize, before: impl Fn(usize) -> Option<usize>) -> Vec<usize> {
    let mut laws = vec![law];
    // Nothing goes before itself, by whatever way.
    while let Some(plainer) = laws.last().and_then(|&last| before(last)).filter(|own| !laws.contains(own)) {
        laws.push(plainer);
    }
    laws
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
/// for a whole surface that would go before it, or a law for a plainer one; and as much again where the plainer one is logged heat that
/// was the more probable at its step.
pub fn least_lead(is_larger: bool, displaces_plainer: bool, was_less_probable: bool) -> f64 {
    let clear = |is_asked: bool| if is_asked { CLEARLY } else { 0.0 };
    clear(is_larger || displaces_plainer) + clear(was_less_probable)
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
