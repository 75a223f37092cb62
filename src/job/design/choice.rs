//! Which estimator is used: the first that can be trusted by its own diagnostics, where the study leaves the choice.
//!
//! Nested Monte Carlo costs no further solution. Where the noise is small against the spread of the predictions, few inner
//! samples lie near a reading: its bias is then of any size, and so is the bound, which is no bound any more. Importance
//! sampling puts its draws where the likelihood is, and fails where the posterior is far from normal. Laplace's
//! approximation has no diagnostics: it shows numbers where the others have none, and names no best candidate.

use super::Design;
use super::block::State;
use super::output::{Candidate, Estimator};
use super::run::SetFound;
use crate::inference::information::estimate::{Estimate, Replicate, Trust};

/// What follows from the candidates' estimates.
pub(super) enum Choice {
    /// They stand.
    Keep,
    /// Another estimator is tried.
    Try,
    /// An earlier one was better after all: it is judged again.
    Return,
}

/// How far the estimates of several sets can be relied on for finding the best: all must be of use, and good are those
/// that may be the best.
fn trust(sets: &[&[Replicate]]) -> Trust {
    let estimates: Vec<Estimate> = sets.iter().filter_map(|replicates| Estimate::of(replicates)).collect();
    let least = estimates.iter().map(Estimate::trust).min();
    if least.is_none_or(|least| least == Trust::No) {
        return Trust::No;
    }
    let highest = estimates.iter().map(|estimate| estimate.range()[0]).fold(f64::NEG_INFINITY, f64::max);
    let leading = estimates.iter().filter(|estimate| estimate.range()[1] >= highest);
    leading.map(Estimate::trust).min().unwrap_or(Trust::No)
}

/// The diagnostics of the leading set in words.
fn diagnostics(sets: &[&[Replicate]]) -> String {
    let estimates = sets.iter().filter_map(|replicates| Estimate::of(replicates));
    let Some(worst) = estimates.max_by(|a, b| a.bias_bound.total_cmp(&b.bias_bound)) else {
        return "there is no estimate".to_owned();
    };
    format!(
        "at one candidate the bias is bounded by {:.2} nats only, and an inner average rests on {:.1} effective samples",
        worst.bias_bound, worst.effective
    )
}

impl Design {
    /// The estimator that is tried first.
    pub(super) fn first_estimator(&self) -> Estimator {
        match self.spec.estimator {
            Estimator::Automatic => Estimator::Nested,
            named => named,
        }
    }

    /// Of the allowed candidates with an estimate.
    fn allowed<'a>(candidates: &[Candidate], replicates: &'a [Vec<Replicate>]) -> Vec<&'a [Replicate]> {
        let both = candidates.iter().zip(replicates).filter(|(candidate, _)| candidate.allowed);
        both.map(|(_, replicates_of_one)| replicates_of_one.as_slice())
            .filter(|replicates_of_one| Estimate::of(replicates_of_one).is_some())
            .collect()
    }

    /// How far what an estimator gave can be relied on; an approximation has no diagnostics.
    pub(super) fn trust_in(&self, estimator: Estimator, sets: &[&[Replicate]]) -> Trust {
        if sets.is_empty() {
            // There is nothing to be wrong about.
            Trust::Good
        } else if estimator.tells_its_bias() {
            trust(sets)
        } else if self.spec.estimator == Estimator::Automatic {
            Trust::No
        } else {
            Trust::Good
        }
    }

    /// The same of the candidates.
    pub(super) fn trust_in_candidates(&self, state: &State) -> Trust {
        self.trust_in(state.estimator, &Self::allowed(&state.output.candidates, &state.replicates))
    }

    /// Goes on to the next estimator where the study leaves the choice and this one cannot be relied on.
    pub(super) fn choose(&self, state: &mut State) -> Choice {
        if self.spec.estimator != Estimator::Automatic {
            return Choice::Keep;
        }
        let current_trust = self.trust_in_candidates(state);
        let words = diagnostics(&Self::allowed(&state.output.candidates, &state.replicates));
        let is_first = state.tried.is_empty();
        match state.estimator {
            Estimator::Nested if is_first && current_trust == Trust::Good => {
                state.output.because =
                    "its bias and its inner samples are good at all candidates that may be the best".into();
                Choice::Keep
            }
            Estimator::Nested if is_first => {
                state.output.because = format!("`nested` is not good: {words}");
                self.try_estimator(state, Estimator::Importance)
            }
            Estimator::Importance if current_trust == Trust::No => {
                let usable = |(estimator, replicates): &(Estimator, Vec<Vec<Replicate>>)| {
                    self.trust_in(*estimator, &Self::allowed(&state.output.candidates, replicates)) > Trust::No
                };
                if let Some(place) = state.tried.iter().position(usable) {
                    let (estimator, replicates) = state.tried.swap_remove(place);
                    let left = (state.estimator, std::mem::replace(&mut state.replicates, replicates));
                    state.tried.push(left);
                    state.estimator = estimator;
                    state.output.because = format!("`importance` cannot be trusted: {words}");
                    return Choice::Return;
                }
                state.output.because.push_str(&format!("; `importance` cannot be trusted: {words}"));
                self.try_estimator(state, Estimator::Laplace)
            }
            _ => Choice::Keep,
        }
    }

    /// Sets aside what the current estimator gave and goes on with another one.
    fn try_estimator(&self, state: &mut State, next: Estimator) -> Choice {
        let empty = vec![Vec::new(); state.replicates.len()];
        let left = (state.estimator, std::mem::replace(&mut state.replicates, empty));
        state.tried.push(left);
        state.estimator = next;
        Choice::Try
    }

    /// Whether the sets of a greedy choice are estimated once more by importance sampling, as nested Monte Carlo is not good
    /// for them: a set of readings is sharper than one alone.
    pub(super) fn again(&self, state: &mut State, sets: &[SetFound]) -> bool {
        let is_open = self.spec.estimator == Estimator::Automatic
            && state.estimator == Estimator::Nested
            && state.tried.is_empty();
        let replicates: Vec<&[Replicate]> = sets.iter().map(|(_, set_replicates)| set_replicates.as_slice()).collect();
        if !is_open || self.trust_in(state.estimator, &replicates) == Trust::Good {
            return false;
        }
        let words = diagnostics(&replicates);
        state
            .output
            .because
            .push_str(&format!("; for sets of readings `importance`, since `nested` is not good: {words}"));
        state.tried.push((state.estimator, Vec::new()));
        state.estimator = Estimator::Importance;
        true
    }
}
