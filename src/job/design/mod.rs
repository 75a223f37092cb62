//! The experiment that teaches most: expected information gain about parameters over candidate phases, with nuisance
//! parameters integrated out, limits kept, several phases chosen one after the other, and sensors ranked.
//!
//! Stages: `predict` (a block a candidate: noise-free readings of all samples, limits), `information` (blocks of
//! replicates of a candidate; once more by another estimator where one cannot be trusted), `search N` (blocks of phases between the values of the grid, by Bayesian optimisation), then
//! `phase N` and `sensor N` for greedy choices. The readings of the samples are solved
//! once: those of a replicate are outer samples there and inner samples of the replicates before it. All candidates see
//! the same random numbers, so that their differences are known better than their values.

mod block;
mod choice;
mod information;
mod output;
mod plant;
mod samples;
mod search;
mod summary;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

pub use output::{
    Axis, Best, Candidate, DesignSensor, ErringInput, Estimator, Observed, Output, Partial, Phase, Pick, Redundant,
    Spec, UsedSensor, Varied, Violation,
};

use super::stored::{self, split_numbers, with_numbers};
use super::{Job, JobError, Step};
use crate::inference::information::estimate::Replicate;
use crate::random::{Distribution, StreamKey};
use crate::thermal::Model;
use block::{InformationInput, InformationOutput, PredictHead, PredictInput, Purpose};
use choice::{Choice, as_set};
use information::Question;
use plant::{Outside, Place, Plant};
use samples::{REPLICATES, Samples};

const PREDICT: &str = "predict";
const INFORMATION: &str = "information";
/// Samples whose points are drawn at once.
const DRAWN: usize = 512;
/// Below so many candidates their replicates are cut into several blocks.
const MANY: usize = 8;
/// Replicates of a block where candidates are few.
const CUT: usize = 4;

/// A design, ready to run.
#[derive(Debug)]
pub struct Design {
    spec: Spec,
    model: Arc<Model>,
    priors: Vec<Distribution>,
    plant: Plant,
    /// Of the settings' candidates.
    places: Vec<Place>,
    samples: Samples,
    /// Of the points at which a search looks.
    key: StreamKey,
}

/// Phases, sensors, and the readings of each phase.
type Set<'a> = (Vec<usize>, Vec<usize>, Vec<&'a [f64]>);

/// The result so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    output: Output,
    /// The estimator at work, never `automatic`.
    estimator: Estimator,
    /// Of each candidate, by that estimator.
    replicates: Vec<Vec<Replicate>>,
    /// Phases that a search found: candidates after those of the settings.
    found: Vec<Phase>,
    /// What other estimators gave, which were not good.
    tried: Vec<(Estimator, Vec<Vec<Replicate>>)>,
    /// Whether the choice of further phases, and of sensors, has ended early.
    ended: [bool; 2],
}

/// What was asked, its predictions, and the replicates found.
type Told = (InformationInput, Vec<f64>, Vec<Replicate>);

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
        let plant = Plant::new(&spec, &model, &priors, unknowns)?;
        let places = spec.candidates.iter().map(|phase| plant.place(phase)).collect();
        let key = StreamKey::new(seed, name, "design search");
        Ok(Self { spec, model, priors, plant, places, samples, key })
    }

    fn all_samples(&self) -> usize {
        REPLICATES * self.samples.size
    }

    /// Noise-free readings of all samples of a phase.
    fn predict(&self, at: &Place) -> (PredictHead, Vec<f64>) {
        let (unknowns, sensors, size) = (self.samples.unknowns, self.plant.sensors(), self.samples.size);
        let mut room = self.plant.room();
        let mut outside = Outside { nodes: vec![0; self.model.nodes.len()], ..Outside::default() };
        let mut readings = vec![f64::NAN; self.all_samples() * sensors];
        let mut values = vec![0.0; DRAWN * unknowns];
        let mut column = Vec::with_capacity(DRAWN);
        for (replicate, readings) in readings.chunks_exact_mut(size * sensors).enumerate() {
            let (rows, dimensions) = self.samples.outer(replicate);
            for (rows, readings) in rows.chunks(DRAWN * dimensions).zip(readings.chunks_mut(DRAWN * sensors)) {
                let count = rows.len() / dimensions;
                for (place, unknown) in self.plant.unknowns().iter().enumerate() {
                    column.clear();
                    column.extend(rows.chunks_exact(dimensions).map(|row| row[place]));
                    unknown.prior.quantiles(&mut column);
                    for (slot, value) in values[place..].iter_mut().step_by(unknowns).zip(&column) {
                        *slot = *value;
                    }
                }
                self.plant.readings(at, &values[..count * unknowns], &mut room, readings, Some(&mut outside));
            }
        }
        let Outside { failed, outside, nodes } = outside;
        let changes = self.plant.nominal_changes(at, &mut room).unwrap_or_default();
        (PredictHead { failed, outside, nodes, changes }, readings)
    }

    /// Blocks for a set of readings, cut by replicates where there are few sets.
    fn blocks(&self, purpose: Purpose, sets: &[Set<'_>], state: &State) -> Result<Vec<Vec<u8>>, JobError> {
        let cut = if sets.len() < MANY { CUT } else { REPLICATES };
        let mut inputs = Vec::new();
        for (phases, sensors, predictions) in sets {
            let numbers = predictions.concat();
            for first in (0..REPLICATES).step_by(cut) {
                let head = InformationInput {
                    purpose,
                    phases: phases.clone(),
                    sensors: sensors.clone(),
                    estimator: state.estimator,
                    replicates: [first, cut],
                    found: state.found.clone(),
                    carry: None,
                };
                inputs.push(with_numbers(&head, &numbers)?);
            }
        }
        inputs.push(with_numbers(&Self::carry(state, Vec::new()), &[])?);
        Ok(inputs)
    }

    /// A block that carries what is known so far; the numbers behind it are the readings of the candidates `with`.
    fn carry(state: &State, with: Vec<usize>) -> InformationInput {
        InformationInput {
            purpose: Purpose::Carry,
            phases: with,
            sensors: Vec::new(),
            estimator: state.estimator,
            replicates: [0, 0],
            found: Vec::new(),
            carry: Some(Box::new(state.clone())),
        }
    }

    fn question<'a>(
        &'a self,
        estimator: Estimator,
        phases: &'a [Place],
        read: &'a [usize],
        predictions: &'a [f64],
    ) -> Question<'a> {
        Question {
            plant: &self.plant,
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

    fn after_predictions(&self, stage: &str, outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        let mut heads = Vec::new();
        let mut predictions = Vec::new();
        for bytes in outputs {
            let (head, numbers) = split_numbers::<PredictHead>(bytes, stage)?;
            heads.push(head);
            predictions.push(numbers);
        }
        let mut state = State { output: self.begun(&heads), estimator: self.first_estimator(), ..State::default() };
        state.output.solutions = outputs.len() as u64 * self.all_samples() as u64;
        let read: Vec<usize> = (0..self.plant.sensors()).collect();
        let sets: Vec<_> = (state.output.candidates.iter().enumerate())
            .filter(|(_, candidate)| self.has_solutions(candidate))
            .map(|(index, _)| (vec![index], read.clone(), vec![predictions[index].as_slice()]))
            .collect();
        state.replicates = vec![Vec::new(); predictions.len()];
        Ok(Step::Blocks { stage: INFORMATION.to_owned(), inputs: self.blocks(Purpose::Phase, &sets, &state)? })
    }

    fn after_information(&self, stage: &str, inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        let mut carried = None;
        let mut sets: Vec<Told> = Vec::new();
        let (mut searched, mut solutions) = (Vec::new(), 0);
        let all = self.all_samples() * self.plant.sensors();
        for (input, output) in inputs.iter().zip(outputs) {
            let (head, numbers) = split_numbers::<InformationInput>(input, stage)?;
            let (told, readings) = split_numbers::<InformationOutput>(output, stage)?;
            solutions += told.solutions;
            match head.purpose {
                Purpose::Carry => {
                    let shell = head.shell();
                    let state = head.carry.ok_or_else(|| stored::unreadable(stage, "it carries nothing"))?;
                    for (&phase, readings) in head.phases.iter().zip(numbers.chunks_exact(all)) {
                        let sensors = (0..self.plant.sensors()).collect();
                        let own = InformationInput { phases: vec![phase], sensors, ..shell.clone() };
                        let replicates = state.replicates.get(phase).cloned().unwrap_or_default();
                        sets.push((own, readings.to_vec(), replicates));
                    }
                    carried = Some(*state);
                }
                Purpose::Search => searched.push((head, told, readings)),
                Purpose::Phase | Purpose::Sensor => match sets.last_mut() {
                    Some((last, _, replicates)) if last.phases == head.phases && last.sensors == head.sensors => {
                        replicates.extend(told.replicates);
                    }
                    _ => sets.push((head, numbers, told.replicates)),
                },
            }
        }
        let mut state = carried.ok_or_else(|| stored::unreadable(stage, "earlier stages are not there"))?;
        state.output.solutions += solutions;
        let is_of_all = stage.starts_with(INFORMATION);
        if !is_of_all && searched.is_empty() {
            return match self.again(&mut state, &sets)? {
                Some(inputs) => Ok(Step::Blocks { stage: format!("{stage} by {}", state.estimator.name()), inputs }),
                None => {
                    self.add_pick(&mut state, &sets);
                    self.next(&state, &sets)
                }
            };
        }
        if is_of_all {
            for (head, _, replicates) in &sets {
                if let Some(&candidate) = head.phases.last() {
                    state.replicates[candidate].clone_from(replicates);
                }
            }
        }
        for (head, told, readings) in searched {
            self.take_in(&mut state, &mut sets, head, told, readings);
        }
        let best = loop {
            let best = self.judge(&mut state);
            match self.choose(&mut state) {
                Choice::Keep => break best,
                Choice::Return => {}
                Choice::Try => {
                    let sets: Vec<Set<'_>> = sets.iter().map(as_set).collect();
                    let inputs = self.blocks(Purpose::Phase, &sets, &state)?;
                    return Ok(Step::Blocks { stage: format!("{INFORMATION} by {}", state.estimator.name()), inputs });
                }
            }
        };
        if let Some(blocks) = self.search(&state, &sets)? {
            return Ok(blocks);
        }
        if let Some(best) = best
            && let Some((_, predictions, _)) = sets.iter().find(|(head, _, _)| head.phases == [best])
        {
            let place = self.place(best, &state.found);
            self.describe_best(&mut state.output, place.as_ref(), predictions);
        }
        self.next(&state, &sets)
    }

    /// A candidate of the settings, or of those that were found.
    fn place(&self, candidate: usize, found: &[Phase]) -> Option<Place> {
        let own = self.places.get(candidate).cloned();
        own.or_else(|| Some(self.plant.place(found.get(candidate.checked_sub(self.places.len())?)?)))
    }

    /// The next greedy stage, or the result.
    fn next(&self, state: &State, sets: &[Told]) -> Result<Step, JobError> {
        let output = &state.output;
        let all = self.all_samples() * self.plant.sensors();
        // The readings of a candidate stand last in the blocks that ask for it.
        let of = |candidate: usize| {
            let own = sets.iter().find(|(head, _, _)| head.phases.last() == Some(&candidate));
            own.map(|(_, numbers, _)| &numbers[numbers.len().saturating_sub(all)..])
        };
        let picked: Vec<usize> = output.picks.iter().map(|pick| pick.position).collect();
        if output.best.is_some() && (picked.len() as u64) < self.spec.pick && !state.ended[0] {
            let read: Vec<usize> = (0..self.plant.sensors()).collect();
            let sets: Vec<_> = (output.candidates.iter().enumerate())
                .filter(|(_, candidate)| candidate.allowed)
                .filter_map(|(index, _)| {
                    let phases: Vec<usize> = picked.iter().copied().chain([index]).collect();
                    let predictions: Option<Vec<&[f64]>> = phases.iter().map(|&phase| of(phase)).collect();
                    Some((phases, read.clone(), predictions?))
                })
                .collect();
            let stage = format!("phase {}", picked.len() + 1);
            return Ok(Step::Blocks { stage, inputs: self.blocks(Purpose::Phase, &sets, state)? });
        }
        let chosen: Vec<usize> = output.sensor_picks.iter().map(|pick| pick.position).collect();
        let wanted = self.spec.choose_sensors.unwrap_or(0).min(self.plant.sensors() as u64);
        if let Some(best) = &output.best
            && (chosen.len() as u64) < wanted
            && !state.ended[1]
            && let Some(predictions) = of(best.candidate)
        {
            let sets: Vec<_> = (0..self.plant.sensors())
                .filter(|sensor| !chosen.contains(sensor))
                .map(|sensor| {
                    let read: Vec<usize> = chosen.iter().copied().chain([sensor]).collect();
                    (vec![best.candidate], read, vec![predictions])
                })
                .collect();
            let stage = format!("sensor {}", chosen.len() + 1);
            return Ok(Step::Blocks { stage, inputs: self.blocks(Purpose::Sensor, &sets, state)? });
        }
        let mut output = output.clone();
        self.tell(&mut output, state);
        stored::result(&output)
    }
}

impl Job for Design {
    fn kind(&self) -> &'static str {
        "design"
    }

    fn algorithm_version(&self) -> u32 {
        4
    }

    fn identity(&self) -> Value {
        json!({ "settings": self.spec, "model": self.model.identity(), "priors": self.priors })
    }

    fn begin(&self) -> Result<Step, JobError> {
        let inputs = (0..self.spec.candidates.len()).map(|candidate| with_numbers(&PredictInput { candidate }, &[]));
        Ok(Step::Blocks { stage: PREDICT.to_owned(), inputs: inputs.collect::<Result<_, _>>()? })
    }

    fn block(&self, stage: &str, input: &[u8]) -> Result<Vec<u8>, JobError> {
        let unreadable = |reason: &str| JobError::Unreadable { stage: stage.to_owned(), reason: reason.to_owned() };
        if stage == PREDICT {
            let (head, _) = split_numbers::<PredictInput>(input, stage)?;
            let place = self.places.get(head.candidate).ok_or_else(|| unreadable("there is no such candidate"))?;
            let (head, readings) = self.predict(place);
            return with_numbers(&head, &readings);
        }
        let (head, predictions) = split_numbers::<InformationInput>(input, stage)?;
        if head.purpose == Purpose::Carry {
            return with_numbers(&InformationOutput::default(), &[]);
        }
        let places: Option<Vec<Place>> = head.phases.iter().map(|&phase| self.place(phase, &head.found)).collect();
        let places = places.ok_or_else(|| unreadable("there is no such candidate"))?;
        if head.purpose == Purpose::Search {
            let [place] = places.as_slice() else { return Err(unreadable("it is not one phase")) };
            return self.look(head.estimator, place);
        }
        let [first, count] = head.replicates;
        let expected = head.phases.len() * self.all_samples() * self.plant.sensors();
        let fits = predictions.len() == expected
            && first + count <= REPLICATES
            && head.phases.len() as u64 <= self.spec.pick
            && head.sensors.iter().all(|sensor| *sensor < self.plant.sensors());
        if !fits {
            return Err(unreadable("its readings do not fit"));
        }
        let (replicates, solutions) =
            self.question(head.estimator, &places, &head.sensors, &predictions).replicates(first..first + count);
        with_numbers(&InformationOutput { head: None, replicates, solutions }, &[])
    }

    fn reduce(&self, stage: &str, inputs: &[Vec<u8>], outputs: &[Vec<u8>]) -> Result<Step, JobError> {
        if stage == PREDICT {
            self.after_predictions(stage, outputs)
        } else {
            self.after_information(stage, inputs, outputs)
        }
    }
}
