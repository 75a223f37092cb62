//! Phases between the values of a grid, where more may be learnt: Bayesian optimisation on the same random numbers as the
//! grid's, so that what is sought is a smooth function.

use super::Design;
use super::block::{Found, Information, Known, State, Task};
use super::forward_model::Place;
use super::output::{Estimator, Phase};
use super::samples::REPLICATES;
use super::summary::FAILURE_LIMIT;
use crate::inference::information::search::{self, next};
use crate::job::Parts;
use crate::math::sort::sort_by;

/// Phases that are looked at side by side.
const AT_ONCE: u64 = 4;
/// Steps of an input's range to which its values are rounded.
const STEPS: f64 = 1000.0;
/// Most candidates that the search is given, the most telling ones: its cost grows with their third power.
const MOST_KNOWN: usize = 160;

impl Design {
    /// Inputs that the grid varies, with the ends of their values.
    fn ranges(&self) -> Vec<(usize, f64, f64)> {
        let ends = self.spec.varied.iter().map(|varied| {
            let low = varied.values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = varied.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (varied.input, low, high)
        });
        ends.filter(|(_, low, high)| low < high).collect()
    }

    /// Phases that the search looks at next; nothing where it is over.
    pub(super) fn search(&self, state: &State) -> Option<Vec<Task>> {
        let left = self.spec.search.saturating_sub(state.found.len() as u64);
        if left == 0 || state.output.best.is_none() {
            return None;
        }
        let ranges = self.ranges();
        let inputs = |candidate: usize| {
            let given_phase = self.spec.candidates.get(candidate);
            given_phase.or_else(|| state.found.get(candidate.checked_sub(self.spec.candidates.len())?))
        };
        let mut evaluated: Vec<search::Known> = (state.output.candidates.iter().enumerate())
            .filter_map(|(index, candidate)| {
                let phase = inputs(index)?;
                let excess = |share: Option<f64>, bound: Option<f64>| Some(share? - bound?);
                let red = excess(candidate.violation.red, self.spec.red);
                let yellow = excess(candidate.violation.yellow, self.spec.yellow);
                let excesses = red.into_iter().chain(yellow).chain([candidate.failed - FAILURE_LIMIT]);
                Some(search::Known {
                    point: ranges
                        .iter()
                        .map(|&(input, low, high)| (phase.inputs[input] - low) / (high - low))
                        .collect(),
                    value: candidate.information_nats,
                    excess: excesses.fold(f64::NEG_INFINITY, f64::max),
                })
            })
            .collect();
        let value = |point: &search::Known| point.value.unwrap_or(f64::NEG_INFINITY);
        sort_by(&mut evaluated, |a, b| value(b).total_cmp(&value(a)));
        evaluated.truncate(MOST_KNOWN);
        let count = usize::try_from(left.min(AT_ONCE)).unwrap_or(1);
        let points = next(&evaluated, count, STEPS, &self.key);
        let base = self.spec.candidates.first().filter(|_| !points.is_empty())?;
        let task = |point: Vec<f64>| {
            let mut phase = Phase { inputs: base.inputs.clone() };
            for (&(input, low, high), u) in ranges.iter().zip(point) {
                phase.inputs[input] = low * (1.0 - u) + high * u;
            }
            Task::Search { phase }
        };
        Some(points.into_iter().map(task).collect())
    }

    /// Solves a phase of the search and estimates its information.
    pub(super) fn look(&self, estimator: Estimator, place: &Place, parts: &dyn Parts) -> Found {
        let (head, readings) = self.predict(place, parts);
        let read = self.all_sensors();
        let has_solutions = head.failed as f64 <= FAILURE_LIMIT * self.all_samples() as f64;
        let places = [place.clone()];
        let question = self.question(estimator, &places, &read, &readings);
        let (replicates, inner_solutions) =
            if has_solutions { question.replicates(0..REPLICATES) } else { (Vec::new(), 0) };
        let solutions = inner_solutions + self.all_samples() as u64;
        Found { head: Some(head), information: Information { replicates, solutions }, readings }
    }

    /// Makes a phase of the search a candidate.
    pub(super) fn take_in(&self, known: &mut Known, phase: Phase, found: Found) {
        let Some(head) = found.head else { return };
        let mut candidate = self.candidate(&phase, &self.forward_model.place(&phase), &head);
        candidate.is_found = true;
        known.readings.push(if self.has_solutions(&candidate) { found.readings } else { Vec::new() });
        known.state.output.candidates.push(candidate);
        known.state.found.push(phase);
        known.state.replicates.push(found.information.replicates);
    }
}
