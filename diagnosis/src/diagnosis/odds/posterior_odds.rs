//! Probabilities of sets of effects.
//!
//! They sum to one over "nothing", the refitted sets and "something else".

use crate::diagnosis::odds::prior_odds::PriorOdds;
use crate::diagnosis::{Problem, Refit};
use crate::math::functions::{exp, ln};
use crate::math::sort::sort_by;
use crate::math::sum::log_sum_exp;

/// Sets within this factor of the best are rivals.
pub const RIVALS_WITHIN: f64 = 10.0;
/// Most rivals that are taken to hold enough probability.
pub const MOST_RIVALS: usize = 5;

/// Probability below which a set that is not near the best is no rival.
pub const LEAST_RIVAL: f64 = 0.01;

/// Probability at which "nothing" stands against a test that is not clear: a convention. Four to one
/// for something are too little where no test is clear.
pub const STANDS: f64 = 0.2;
/// Probability that a group and its rivals hold together: what a set keeps against a single one that is a tenth as
/// probable, the least that is a rival ([`RIVALS_WITHIN`]), `10 / 11`.
pub const SURE: f64 = 0.91;

/// Probabilities of the sets, in their order, and of something else.
#[derive(Clone, Debug, PartialEq)]
pub struct SetProbabilities {
    /// Of each set.
    pub sets: Vec<f64>,
    /// Of something that is in none of the sets.
    pub unexplained: f64,
}

impl SetProbabilities {
    /// Without a set: the others have what it had, in proportion.
    pub fn leave_out(&mut self, set: usize) {
        self.sets[set] = 0.0;
        let total = self.sets.iter().sum::<f64>() + self.unexplained;
        if total > 0.0 {
            self.sets.iter_mut().chain([&mut self.unexplained]).for_each(|weight| *weight /= total);
        }
    }
}

/// Log likelihood that a set gains over another on unseen rows which are worth so many independent readings, each set with
/// the model error that it shows there.
pub(crate) fn gains_unseen(before: &Refit, after: &Refit, independent: f64) -> f64 {
    let ratio = before.rmse_held_out_k.zip(after.rmse_held_out_k).map(|(before, after)| before / after);
    ratio.filter(|ratio| ratio.is_finite() && *ratio > 0.0).map_or(0.0, |ratio| independent * ln(ratio))
}

/// Logarithms of what sets weigh by evidence and prior, not normalised.
pub fn log_posterior_weights(problem: &Problem, refits: &[Refit]) -> Vec<f64> {
    let odds = PriorOdds::new(problem);
    refits.iter().map(|refit| refit.log_evidence + odds.of(problem, &refit.effects)).collect()
}

/// Weighs sets by evidence and prior; `unexplained` is the log evidence of something else, where it is known.
pub fn posterior_odds(problem: &Problem, refits: &[Refit], unexplained: Option<f64>) -> SetProbabilities {
    normalised(log_posterior_weights(problem, refits), unexplained)
}

/// The same with what the held-out readings say, each set with the noise that it shows there.
pub fn odds_with_held_out(problem: &Problem, refits: &[Refit]) -> SetProbabilities {
    let mut logs = log_posterior_weights(problem, refits);
    for (log, refit) in logs.iter_mut().zip(refits) {
        *log += gains_unseen(&refits[0], refit, refit.held_out.len() as f64);
    }
    normalised(logs, None)
}

/// Probabilities from the logarithms of weights.
fn normalised(mut logs: Vec<f64>, unexplained: Option<f64>) -> SetProbabilities {
    logs.push(unexplained.map_or(f64::NEG_INFINITY, |evidence| evidence + PriorOdds::unexplained()));
    let total = log_sum_exp(&logs);
    let mut sets: Vec<f64> =
        logs.into_iter().map(|log| if total.is_finite() { exp(log - total) } else { 0.0 }).collect();
    let unexplained = sets.pop().unwrap_or(0.0);
    SetProbabilities { sets, unexplained }
}

/// Whether "nothing" stands although a test finds something with this p: it keeps a fifth of the probability, also against an
/// unspecified alternative that is as likely as the p allows, by a Bayes factor of at most `1 / (-e p ln p)` (Sellke, Bayarri &
/// Berger 2001, Am. Stat. 55, 62, eq. 3). A test knows the noise as it was estimated; the odds ask for something that made it.
pub fn nothing_stands(nothing: f64, p: f64) -> bool {
    let p = p.min(exp(-1.0));
    let least = -std::f64::consts::E * p * ln(p);
    nothing / (1.0 + nothing * exp(PriorOdds::unexplained()) / least) >= STANDS
}

/// What is left of the weights when sets are vetoed.
#[derive(Clone, Debug, PartialEq)]
pub struct Vetoed {
    /// The vetoed sets, ascending.
    pub sets: Vec<usize>,
    /// Their probability given to what no set explains.
    pub with: SetProbabilities,
    /// The probabilities of the others and of something else when the vetoed sets are out of the question.
    pub without: SetProbabilities,
}

/// Asks, of every set of at least some probability, whether it is vetoed; also of those that come to it as others go. The
/// first, "nothing", is not asked.
///
/// Where a set is left that explains all, giving what is lost to something else is too much: a flexible curve with the best
/// fit to the rows that it saw would take the effect that made them along when it fails on others.
pub fn veto(weights: &SetProbabilities, least: f64, is_vetoed: impl Fn(usize) -> bool) -> Vetoed {
    let mut vetoed = Vetoed { sets: Vec::new(), with: weights.clone(), without: weights.clone() };
    let mut asked = vec![false; weights.sets.len()];
    let next =
        |asked: &[bool], left: &SetProbabilities| (1..asked.len()).find(|&set| !asked[set] && left.sets[set] >= least);
    while let Some(set) = next(&asked, &vetoed.without) {
        asked[set] = true;
        if !is_vetoed(set) {
            continue;
        }
        vetoed.sets.push(set);
        vetoed.with.unexplained += weights.sets[set];
        vetoed.with.sets[set] = 0.0;
        vetoed.without.leave_out(set);
    }
    vetoed.sets.sort_unstable();
    vetoed
}

/// Position of the most probable set.
pub fn best(weights: &SetProbabilities) -> Option<usize> {
    let better = |best: Option<usize>, next: usize| match best {
        Some(known) if !(weights.sets[next] > weights.sets[known]) => Some(known),
        _ => Some(next),
    };
    (0..weights.sets.len()).fold(None, better)
}

/// The groups of a set's members, each member first in its own, and the sets that are its rivals, itself first.
///
/// A rival is not larger. Rivals are taken in the order of their probability: those within a factor of the set, those that
/// predict the same, and others while the groups together do not hold [`SURE`]. Between sets that predict the same only the
/// odds beforehand decide, which are conventions (how many places a kind of effect has): no data tell them apart. A rival's
/// effects that the set does not have go into the groups of the members that the rival lacks.
pub fn groups(refits: &[Refit], weights: &SetProbabilities, of: usize, within: f64) -> (Vec<Vec<usize>>, Vec<usize>) {
    let own = &refits[of].effects;
    let mut groups: Vec<Vec<usize>> = own.iter().map(|&effect| vec![effect]).collect();
    let mut rivals = vec![of];
    let is_rival = |other: &usize| {
        let effects = &refits[*other].effects;
        *other != of && !effects.is_empty() && effects.len() <= own.len() && weights.sets[*other] > 0.0
    };
    let mut others: Vec<usize> = (0..refits.len()).filter(is_rival).collect();
    sort_by(&mut others, |&a, &b| weights.sets[b].total_cmp(&weights.sets[a]).then(a.cmp(&b)));
    for other in others {
        let near = weights.sets[other] * within >= weights.sets[of];
        let likely = weights.sets[other] >= LEAST_RIVAL;
        let unsure = likely && held(refits, weights, &groups) < SURE && rivals.len() < MOST_RIVALS;
        let same = likely && rivals.len() < MOST_RIVALS && predict_the_same(&refits[of], &refits[other]);
        if !near && !unsure && !same {
            if !likely {
                break;
            }
            continue;
        }
        let effects = &refits[other].effects;
        let absent: Vec<usize> = own.iter().copied().filter(|effect| !effects.contains(effect)).collect();
        for (position, &effect) in effects.iter().filter(|effect| !own.contains(effect)).enumerate() {
            // The last where there are more than members.
            let Some(&member) = absent.get(position).or(absent.last()) else { continue };
            let group = own.iter().position(|&known| known == member).unwrap_or(0);
            if !groups.iter().any(|group| group.contains(&effect)) {
                groups[group].push(effect);
            }
        }
        rivals.push(other);
    }
    (groups, rivals)
}

/// Whether the predictions of two fits differ by less than a standard deviation, all fitted readings together.
fn predict_the_same(a: &Refit, b: &Refit) -> bool {
    let square: f64 = a.residuals.iter().zip(&b.residuals).map(|(a, b)| (a - b) * (a - b)).sum();
    a.residuals.len() == b.residuals.len() && square < 1.0
}

/// Probability of the sets that have an effect of every group.
pub fn held(refits: &[Refit], weights: &SetProbabilities, groups: &[Vec<usize>]) -> f64 {
    let hits = |refit: &Refit| groups.iter().all(|group| group.iter().any(|effect| refit.effects.contains(effect)));
    refits.iter().zip(&weights.sets).filter(|(refit, _)| hits(refit)).map(|(_, weight)| weight).sum()
}
