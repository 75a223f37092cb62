//! Probabilities of sets of effects.
//!
//! Beforehand each kind of effect is missing with probability 0.05, at any of its places in this network alike, and so is
//! physics that no kind describes: so the number of places is paid for. Probabilities sum to one over "nothing", the
//! refitted sets and "something else".

use std::collections::BTreeMap;

use super::{Problem, Refit};
use crate::math::functions::{exp, ln};
use crate::math::sum::log_sum_exp;

/// Probability beforehand that a kind of effect is missing.
const MISSING: f64 = 0.05;
/// Sets within this factor of the best are rivals.
pub const RIVALS_WITHIN: f64 = 10.0;

/// Log prior odds, against "nothing", of one instance of each kind of effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Odds(BTreeMap<String, f64>);

impl Odds {
    /// Counts the places of each kind.
    pub fn new(problem: &Problem) -> Self {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for candidate in &problem.candidates {
            *counts.entry(candidate.effect.clone()).or_default() += 1;
        }
        let odds = |count: usize| ln(MISSING / (1.0 - MISSING)) - ln(count.max(1) as f64);
        Self(counts.into_iter().map(|(effect, count)| (effect, odds(count))).collect())
    }

    /// Of a set of candidates.
    pub fn of(&self, problem: &Problem, effects: &[usize]) -> f64 {
        effects.iter().filter_map(|&e| self.0.get(&problem.candidates[e].effect)).sum()
    }

    /// Of "something else".
    pub fn unexplained() -> f64 {
        ln(MISSING / (1.0 - MISSING))
    }
}

/// Probabilities of the sets, in their order, and of something else.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// Of each set.
    pub sets: Vec<f64>,
    /// Of something that is in none of the sets.
    pub unexplained: f64,
}

/// Weighs sets by evidence and prior; `unexplained` is the log evidence of something else, where it is known.
pub fn weigh(problem: &Problem, refits: &[Refit], unexplained: Option<f64>) -> Weights {
    let odds = Odds::new(problem);
    let mut logs: Vec<f64> = refits.iter().map(|refit| refit.log_evidence + odds.of(problem, &refit.effects)).collect();
    logs.push(unexplained.map_or(f64::NEG_INFINITY, |evidence| evidence + Odds::unexplained()));
    let total = log_sum_exp(&logs);
    let mut sets: Vec<f64> =
        logs.into_iter().map(|log| if total.is_finite() { exp(log - total) } else { 0.0 }).collect();
    let unexplained = sets.pop().unwrap_or(0.0);
    Weights { sets, unexplained }
}

/// Position of the most probable set.
pub fn best(weights: &Weights) -> Option<usize> {
    let better = |best: Option<usize>, next: usize| match best {
        Some(known) if !(weights.sets[next] > weights.sets[known]) => Some(known),
        _ => Some(next),
    };
    (0..weights.sets.len()).fold(None, better)
}

/// Sets that stand beside one as rivals, itself first: not larger, and within a factor of 10 of its probability.
pub fn rivals(refits: &[Refit], weights: &Weights, of: usize) -> Vec<usize> {
    let own = &refits[of];
    let mut rivals = vec![of];
    rivals.extend((0..refits.len()).filter(|&other| {
        let near = weights.sets[other] * RIVALS_WITHIN >= weights.sets[of];
        let simple = !refits[other].effects.is_empty() && refits[other].effects.len() <= own.effects.len();
        other != of && near && simple
    }));
    rivals[1..].sort_by(|&a, &b| weights.sets[b].total_cmp(&weights.sets[a]).then(a.cmp(&b)));
    rivals
}
