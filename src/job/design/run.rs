//! The choice of an experiment as a job: what it is asked, and its stages.

use super::{Estimator, Output, Phase, Spec, samples};
use std::sync::{Arc, OnceLock};

use serde_json::{Value, json};

use super::block::{Found, Information, Known, PredictHead, Purpose, Set, State, Task};
use super::choice::Choice;
use super::forward_model::{ForwardModel, Outside, Place};
use super::information::Question;
use super::samples::{REPLICATES, Samples};
use crate::inference::information::estimate::Replicate;
use crate::job::stored::{split_numbers, with_numbers};
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::random::{Distribution, StreamKey};
use crate::thermal::{External, Model};

pub(super) const PREDICT: &str = "predict";
pub(super) const INFORMATION: &str = "information";
/// Samples whose points are drawn at once.
pub(super) const DRAWN: usize = 512;
/// Below so many candidates their replicates are cut into several blocks.
pub(super) const MANY: usize = 8;
/// Replicates of a block where candidates are few.
pub(super) const CUT: usize = 4;

/// A design, ready to run.
#[derive(Debug)]
pub struct Design {
    pub(super) spec: Spec,
    pub(super) model: Arc<Model>,
    pub(super) priors: Vec<Distribution>,
    pub(super) forward_model: ForwardModel,
    /// Of the settings' candidates, from when they are needed on.
    places: OnceLock<Vec<Place>>,
    pub(super) samples: Samples,
    /// Of the points at which a search looks.
    pub(super) key: StreamKey,
}

/// A set of readings that was asked for, with the replicates found.
pub(super) type SetFound = (Set, Vec<Replicate>);

impl Design {
    /// Prepares the job; `name` is its name in the pass, which its random streams are keyed by.
    ///
    /// # Errors
    /// Settings without a candidate, a sensor or a parameter to learn; numbers of samples that do not fit together; a network
    /// that does not compile.
    pub fn new(
        spec: Spec,
        model: Arc<Model>,
        priors: Vec<Distribution>,
        seed: u64,
        name: &str,
    ) -> Result<Self, JobError> {
        let failed = |reason: &str| Err(JobError::Failed(reason.to_owned()));
        if spec.candidates.is_empty() || spec.sensors.is_empty() || spec.learn.is_empty() || spec.pick == 0 {
            return failed("a design needs a candidate phase, a sensor and a parameter to learn");
        }
        let fits = spec.outer.is_power_of_two()
            && spec.outer >= 16 * REPLICATES as u64
            && spec.inner.is_power_of_two()
            && (4..=spec.outer / 2).contains(&spec.inner)
            && spec.draws.is_power_of_two()
            && spec.draws >= 16;
        if !fits {
            return failed(
                "the numbers of samples must be powers of two: outer from 256, inner from 4 to outer / 2, draws from 16",
            );
        }
        let unknowns = samples::unknowns(&spec, &model, &priors);
        let samples = Samples::new(&spec, unknowns.len(), seed, name)?;
        let forward_model = ForwardModel::new(&spec, &model, &priors, unknowns)?;
        let key = StreamKey::new(seed, name, "design search");
        Ok(Self { spec, model, priors, forward_model, places: OnceLock::new(), samples, key })
    }

    /// The phases of the settings' candidates, solved when they are first asked for.
    pub(super) fn places(&self) -> &[Place] {
        let solved = || self.spec.candidates.iter().map(|phase| self.forward_model.place(phase)).collect();
        self.places.get_or_init(solved)
    }

    pub(super) fn all_samples(&self) -> usize {
        REPLICATES * self.samples.size
    }

    /// Noise-free readings of all samples of a phase; each replicate is a part that a kill does not lose.
    pub(super) fn predict(&self, at: &Place, parts: &dyn Parts) -> (PredictHead, Vec<f64>) {
        let (unknowns, sensors, size) = (self.samples.unknowns, self.forward_model.sensors(), self.samples.size);
        let mut room = self.forward_model.room();
        let mut outside = Outside { nodes: vec![0; self.model.nodes.len()], ..Outside::default() };
        let mut readings = vec![f64::NAN; self.all_samples() * sensors];
        let mut done = 0;
        for kept in (1..REPLICATES).rev() {
            let part = parts.find(kept as u64).and_then(|bytes| split_numbers::<Outside>(&bytes, PREDICT).ok());
            if let Some((kept_outside, solved)) = part.filter(|(_, solved)| solved.len() == kept * size * sensors) {
                readings[..solved.len()].copy_from_slice(&solved);
                (outside, done) = (kept_outside, kept);
                break;
            }
        }
        let mut values = vec![0.0; DRAWN * unknowns];
        let mut column = Vec::with_capacity(DRAWN);
        for replicate in done..REPLICATES {
            if replicate > done && parts.is_due() {
                let solved = &readings[..replicate * size * sensors];
                if let Ok(bytes) = with_numbers(&outside, solved) {
                    parts.keep(replicate as u64, &bytes);
                }
            }
            let readings = &mut readings[replicate * size * sensors..(replicate + 1) * size * sensors];
            let (rows, dimensions) = self.samples.outer(replicate);
            for (rows, readings) in rows.chunks(DRAWN * dimensions).zip(readings.chunks_mut(DRAWN * sensors)) {
                let count = rows.len() / dimensions;
                for (place, unknown) in self.forward_model.unknowns().iter().enumerate() {
                    column.clear();
                    column.extend(rows.chunks_exact(dimensions).map(|row| row[place]));
                    unknown.prior.quantiles(&mut column);
                    for (slot, value) in values[place..].iter_mut().step_by(unknowns).zip(&column) {
                        *slot = *value;
                    }
                }
                self.forward_model.readings(at, &values[..count * unknowns], &mut room, readings, Some(&mut outside));
            }
        }
        let Outside { failed, outside, nodes } = outside;
        let changes = self.forward_model.nominal_changes(at, &mut room).unwrap_or_default();
        (PredictHead { failed, outside, nodes, changes }, readings)
    }

    /// Blocks for sets of readings, cut by replicates where there are few sets.
    pub(super) fn inform(stage: String, known: Known, sets: Vec<Set>) -> Step<Self> {
        let cut = if sets.len() < MANY { CUT } else { REPLICATES };
        let replicates = |set: Set| {
            let of = move |first| Task::Inform { set: set.clone(), replicates: [first, cut] };
            (0..REPLICATES).step_by(cut).map(of)
        };
        Step::Blocks { stage, state: known, inputs: sets.into_iter().flat_map(replicates).collect() }
    }

    /// All sensors, in order.
    pub(super) fn all_sensors(&self) -> Vec<usize> {
        (0..self.forward_model.sensors()).collect()
    }

    /// A set of each candidate that has solutions.
    pub(super) fn candidate_sets(&self, known: &Known) -> Vec<Set> {
        let solved = (0..known.readings.len()).filter(|&index| !known.readings[index].is_empty());
        solved
            .map(|index| Set { purpose: Purpose::Candidate, phases: vec![index], sensors: self.all_sensors() })
            .collect()
    }

    pub(super) fn question<'a>(
        &'a self,
        estimator: Estimator,
        phases: &'a [Place],
        read: &'a [usize],
        predictions: &'a [f64],
    ) -> Question<'a> {
        Question {
            forward_model: &self.forward_model,
            samples: &self.samples,
            sensors: &self.spec.sensors,
            estimator,
            learn: self.spec.learn.len(),
            inner: usize::try_from(self.spec.inner).unwrap_or(usize::MAX),
            draws: usize::try_from(self.spec.draws).unwrap_or(usize::MAX),
            phases,
            read,
            predictions,
        }
    }

    pub(super) fn after_predictions(&self, found: Vec<Found>) -> Step<Self> {
        let heads: Vec<PredictHead> = found.iter().filter_map(|prediction| prediction.head.clone()).collect();
        let mut state = State { output: self.begun(&heads), estimator: self.first_estimator(), ..State::default() };
        state.output.solutions = found.iter().map(|prediction| prediction.information.solutions).sum();
        state.replicates = vec![Vec::new(); found.len()];
        let both = state.output.candidates.iter().zip(found);
        let readings = both.map(
            |(candidate, prediction)| if self.has_solutions(candidate) { prediction.readings } else { Vec::new() },
        );
        let progress = Known { readings: readings.collect(), state };
        let sets = self.candidate_sets(&progress);
        Self::inform(INFORMATION.to_owned(), progress, sets)
    }

    pub(super) fn after_information(&self, mut known: Known, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let mut sets: Vec<SetFound> = Vec::new();
        for (task, partial) in blocks {
            known.state.output.solutions += partial.information.solutions;
            match task {
                Task::Inform { set, .. } => match sets.last_mut() {
                    Some((last, replicates)) if *last == set => replicates.extend(partial.information.replicates),
                    _ => sets.push((set, partial.information.replicates)),
                },
                Task::Search { phase } => self.take_in(&mut known, phase, partial),
                Task::Predict { .. } => {}
            }
        }
        if sets.iter().any(|(set, _)| set.purpose != Purpose::Candidate) {
            return Ok(match self.again(&mut known.state, &sets) {
                true => {
                    let stage =
                        format!("{} by {}", self.greedy_stage(&known.state, &sets), known.state.estimator.name());
                    Self::inform(stage, known, sets.into_iter().map(|(set, _)| set).collect())
                }
                false => {
                    self.add_pick(&mut known.state, &sets);
                    self.next(known)
                }
            });
        }
        for (set, replicates) in sets {
            if let Some(&candidate) = set.phases.last() {
                known.state.replicates[candidate] = replicates;
            }
        }
        let best = loop {
            let best = self.judge(&mut known.state);
            match self.choose(&mut known.state) {
                Choice::Keep => break best,
                Choice::Return => {}
                Choice::Try => {
                    let stage = format!("{INFORMATION} by {}", known.state.estimator.name());
                    let sets = self.candidate_sets(&known);
                    return Ok(Self::inform(stage, known, sets));
                }
            }
        };
        if let Some(inputs) = self.search(&known.state) {
            let stage = format!("search {}", known.state.found.len() + inputs.len());
            return Ok(Step::Blocks { stage, state: known, inputs });
        }
        if let Some(best) = best.filter(|&best| !known.readings[best].is_empty()) {
            let place = self.place(best, &known.state.found);
            self.describe_best(&mut known.state.output, place.as_ref(), &known.readings[best]);
        }
        Ok(self.next(known))
    }

    /// Name of a greedy stage.
    pub(super) fn greedy_stage(&self, state: &State, sets: &[SetFound]) -> String {
        if sets.first().is_some_and(|(set, _)| set.purpose == Purpose::Sensor) {
            format!("sensor {}", state.output.sensor_picks.len() + 1)
        } else {
            format!("phase {}", state.output.picks.len() + 1)
        }
    }

    /// A candidate of the settings, or of those that were found.
    pub(super) fn place(&self, candidate: usize, found: &[Phase]) -> Option<Place> {
        let from_settings = self.places().get(candidate).cloned();
        from_settings
            .or_else(|| Some(self.forward_model.place(found.get(candidate.checked_sub(self.places().len())?)?)))
    }

    /// The next greedy stage, or the result.
    pub(super) fn next(&self, known: Known) -> Step<Self> {
        let Known { state, readings } = &known;
        let output = &state.output;
        let is_solved =
            |candidate: usize| readings.get(candidate).is_some_and(|candidate_readings| !candidate_readings.is_empty());
        let picked: Vec<usize> = output.picks.iter().map(|pick| pick.position).collect();
        if output.best.is_some() && (picked.len() as u64) < self.spec.pick && !state.ended[0] {
            let sets = (output.candidates.iter().enumerate())
                .filter(|(index, candidate)| candidate.allowed && is_solved(*index))
                .map(|(index, _)| Set {
                    purpose: Purpose::Phase,
                    phases: picked.iter().copied().chain([index]).collect(),
                    sensors: self.all_sensors(),
                })
                .collect();
            return Self::inform(format!("phase {}", picked.len() + 1), known, sets);
        }
        let chosen: Vec<usize> = output.sensor_picks.iter().map(|pick| pick.position).collect();
        let wanted = self.spec.choose_sensors.unwrap_or(0).min(self.forward_model.sensors() as u64);
        if let Some(best) = output.best.as_ref().filter(|best| is_solved(best.candidate))
            && (chosen.len() as u64) < wanted
            && !state.ended[1]
        {
            let sets = (0..self.forward_model.sensors())
                .filter(|sensor| !chosen.contains(sensor))
                .map(|sensor| Set {
                    purpose: Purpose::Sensor,
                    phases: vec![best.candidate],
                    sensors: chosen.iter().copied().chain([sensor]).collect(),
                })
                .collect();
            return Self::inform(format!("sensor {}", chosen.len() + 1), known, sets);
        }
        let mut output = output.clone();
        self.tell(&mut output, state);
        Step::Done(Box::new(output))
    }
}

impl Job for Design {
    type State = Known;
    type Input = Task;
    type Partial = Found;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "design"
    }

    fn algorithm_version(&self) -> u32 {
        5
    }

    fn identity(&self) -> Value {
        json!({ "settings": self.spec, "model": self.model.identity(), "priors": self.priors })
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        let inputs = (0..self.spec.candidates.len()).map(|candidate| Task::Predict { candidate }).collect();
        Ok(Step::Blocks { stage: PREDICT.to_owned(), state: Known::default(), inputs })
    }

    fn external(&self) -> Option<&External> {
        self.forward_model.external()
    }

    fn block(&self, known: &Known, task: Task, parts: &dyn Parts) -> Result<Found, JobError> {
        let wrong = |reason: &str| JobError::Failed(reason.to_owned());
        match task {
            Task::Predict { candidate } => {
                let place = self.places().get(candidate).ok_or_else(|| wrong("there is no such candidate"))?;
                let (head, readings) = self.predict(place, parts);
                let information = Information { replicates: Vec::new(), solutions: self.all_samples() as u64 };
                Ok(Found { head: Some(head), information, readings })
            }
            Task::Search { phase } => Ok(self.look(known.state.estimator, &self.forward_model.place(&phase), parts)),
            Task::Inform { set, replicates: [first, count] } => {
                let places: Option<Vec<Place>> =
                    set.phases.iter().map(|&phase| self.place(phase, &known.state.found)).collect();
                let places = places.ok_or_else(|| wrong("there is no such candidate"))?;
                let phase_readings = set.phases.iter().filter_map(|&phase| known.readings.get(phase));
                let readings: Vec<f64> = phase_readings.flatten().copied().collect();
                let fits = readings.len() == places.len() * self.all_samples() * self.forward_model.sensors()
                    && first + count <= REPLICATES
                    && set.sensors.iter().all(|sensor| *sensor < self.forward_model.sensors());
                if !fits {
                    return Err(wrong("its readings do not fit"));
                }
                let question = self.question(known.state.estimator, &places, &set.sensors, &readings);
                let (replicates, solutions) = question.replicates(first..first + count);
                Ok(Found { information: Information { replicates, solutions }, ..Found::default() })
            }
        }
    }

    fn reduce(&self, known: Known, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        if known.readings.is_empty() {
            return Ok(self.after_predictions(blocks.into_iter().map(|(_, partial)| partial).collect()));
        }
        self.after_information(known, blocks)
    }
}
