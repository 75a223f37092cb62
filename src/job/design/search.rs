//! Phases between the values of a grid, where more may be learnt: Bayesian optimisation on the same random numbers as the
//! grid's, so that what is sought is a smooth function.

use super::block::{InformationInput, InformationOutput, Purpose};
use super::output::{Estimator, Phase};
use super::plant::Place;
use super::samples::REPLICATES;
use super::summary::FAILURE_LIMIT;
use super::{Design, State, Told};
use crate::inference::information::search::{Known, next};
use crate::job::stored::with_numbers;
use crate::job::{JobError, Step};

/// Phases that are looked at side by side.
const AT_ONCE: u64 = 4;
/// Steps of an input's range to which its values are rounded.
const STEPS: f64 = 1000.0;
/// Most candidates that the search is told of, the most telling ones: its cost grows with their third power.
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

    /// The next stage of the search; nothing where it is over.
    pub(super) fn search(&self, state: &State, sets: &[Told]) -> Result<Option<Step>, JobError> {
        let left = self.spec.search.saturating_sub(state.found.len() as u64);
        if left == 0 || state.output.best.is_none() {
            return Ok(None);
        }
        let ranges = self.ranges();
        let inputs = |candidate: usize| {
            let own = self.spec.candidates.get(candidate);
            own.or_else(|| state.found.get(candidate.checked_sub(self.spec.candidates.len())?))
        };
        let mut known: Vec<Known> = (state.output.candidates.iter().enumerate())
            .filter_map(|(index, candidate)| {
                let phase = inputs(index)?;
                let excess = |share: Option<f64>, bound: Option<f64>| Some(share? - bound?);
                let red = excess(candidate.violation.red, self.spec.red);
                let yellow = excess(candidate.violation.yellow, self.spec.yellow);
                let excesses = red.into_iter().chain(yellow).chain([candidate.failed - FAILURE_LIMIT]);
                Some(Known {
                    point: ranges
                        .iter()
                        .map(|&(input, low, high)| (phase.inputs[input] - low) / (high - low))
                        .collect(),
                    value: candidate.information_nats,
                    excess: excesses.fold(f64::NEG_INFINITY, f64::max),
                })
            })
            .collect();
        let value = |own: &Known| own.value.unwrap_or(f64::NEG_INFINITY);
        known.sort_by(|a, b| value(b).total_cmp(&value(a)));
        known.truncate(MOST_KNOWN);
        let count = usize::try_from(left.min(AT_ONCE)).unwrap_or(1);
        let points = next(&known, count, STEPS, &self.key);
        let Some(base) = self.spec.candidates.first().filter(|_| !points.is_empty()) else { return Ok(None) };
        let mut found = state.found.clone();
        for point in points {
            let mut phase = Phase { inputs: base.inputs.clone() };
            for (&(input, low, high), u) in ranges.iter().zip(point) {
                phase.inputs[input] = low * (1.0 - u) + high * u;
            }
            found.push(phase);
        }
        let mut blocks = Vec::new();
        for place in state.found.len()..found.len() {
            let head = InformationInput {
                purpose: Purpose::Search,
                phases: vec![self.spec.candidates.len() + place],
                sensors: Vec::new(),
                estimator: state.estimator,
                replicates: [0, REPLICATES],
                found: found.clone(),
                carry: None,
            };
            blocks.push(with_numbers(&head, &[])?);
        }
        let with: Vec<usize> = sets.iter().filter_map(|(head, _, _)| head.phases.last().copied()).collect();
        let numbers: Vec<f64> = sets.iter().flat_map(|(_, numbers, _)| numbers.iter().copied()).collect();
        blocks.push(with_numbers(&Self::carry(state, with), &numbers)?);
        Ok(Some(Step::Blocks { stage: format!("search {}", found.len()), inputs: blocks }))
    }

    /// Solves a phase of the search and estimates its information.
    pub(super) fn look(&self, estimator: Estimator, place: &Place) -> Result<Vec<u8>, JobError> {
        let (head, readings) = self.predict(place);
        let read: Vec<usize> = (0..self.plant.sensors()).collect();
        let has_solutions = head.failed as f64 <= FAILURE_LIMIT * self.all_samples() as f64;
        let places = [place.clone()];
        let question = self.question(estimator, &places, &read, &readings);
        let (replicates, own) = if has_solutions { question.replicates(0..REPLICATES) } else { (Vec::new(), 0) };
        let solutions = own + self.all_samples() as u64;
        with_numbers(&InformationOutput { head: Some(head), replicates, solutions }, &readings)
    }

    /// Makes a phase of the search a candidate.
    pub(super) fn take_in(
        &self,
        state: &mut State,
        sets: &mut Vec<Told>,
        head: InformationInput,
        told: InformationOutput,
        readings: Vec<f64>,
    ) {
        let (Some(&index), Some(own)) = (head.phases.last(), told.head) else { return };
        let Some(place) = index.checked_sub(self.spec.candidates.len()) else { return };
        let (Some(phase), Some(at)) = (head.found.get(place), self.place(index, &head.found)) else { return };
        let mut candidate = self.candidate(phase, &at, &own);
        candidate.is_found = true;
        let has_solutions = self.has_solutions(&candidate);
        state.output.candidates.push(candidate);
        state.found.push(phase.clone());
        state.replicates.push(told.replicates.clone());
        if has_solutions {
            sets.push((
                InformationInput { phases: vec![index], sensors: (0..self.plant.sensors()).collect(), ..head.shell() },
                readings,
                told.replicates,
            ));
        }
    }
}
