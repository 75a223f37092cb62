//! Goal setting as a job: what it is asked, and its stages.

use super::{Output, Spec, output};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::math::sort::sort_by;
use crate::random::{Distribution, PointKind, Points, StreamKey};
use crate::thermal::{External, Model, Network, Start};

use super::cell::{Cell, Outcome, Role};
use super::knowledge::{Known, error_for};
use super::prior::Prior;
use crate::job::stored::Block;
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::study::variable::Variable;

/// Names of the parts that are kept on the way.
const CELLS: &str = "cells";
/// Most leading parameters that are sharpened together.
pub(super) const MOST_TOGETHER: usize = 3;
/// Shares of the prior standard deviations that are tried with the given design.
pub(super) const RATIOS: [f64; 9] = [0.85, 0.7, 0.5, 0.35, 0.25, 0.15, 0.1, 0.05, 0.0];
/// Those for which a design value is sought.
pub(super) const DESIGN_RATIOS: [f64; 4] = [0.5, 0.25, 0.1, 0.0];
/// Design values over the range, then within the interval where the probability is reached.
pub(super) const DESIGN_VALUES: usize = 9;
pub(super) const DESIGN_FINER: usize = 7;
/// Shares tried between two, and how often.
pub(super) const SEARCHED: usize = 8;
pub(super) const SEARCHES: u32 = 2;
/// Truths, and samples for each.
pub(super) const TRUTHS: usize = 64;
pub(super) const TRUTH_SAMPLES: u64 = 1024;
/// Share of the prior standard deviation that an experiment is taken to leave where none is sought.
pub(super) const USUAL_RATIO: f64 = 0.25;

/// Goal setting, ready to run.
#[derive(Debug)]
pub struct Goal {
    pub(super) spec: Spec,
    pub(super) model: Arc<Model>,
    pub(super) priors: Vec<Distribution>,
    pub(super) network: Network,
    pub(super) points: Points,
    pub(super) truth_points: Points,
    /// Parameters that are not fixed and not the design variable, in order.
    pub(super) uncertain: Vec<usize>,
    pub(super) nominal: Vec<f64>,
    pub(super) starts: Vec<Vec<f64>>,
    pub(super) required: f64,
}

/// What a block found.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Partial {
    /// Of the given design with prior knowledge.
    Prior(Box<Prior>),
    /// Of each cell.
    Cells(Vec<Outcome>),
}

/// All that was found so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    pub(super) prior: Prior,
    pub(super) outcomes: Vec<Outcome>,
    /// The set and the bracket of shares in which its target lies: reached, not reached.
    pub(super) target: Option<(usize, [f64; 2])>,
    pub(super) searches: u32,
    pub(super) has_truths: bool,
}

impl Goal {
    /// Prepares the job: compiles the network, lays out the points and solves the nominal cases.
    ///
    /// `priors` has one entry a parameter of the model; `name` is the job's name, which its random streams are keyed by.
    ///
    /// # Errors
    /// No requirement, no uncertain parameter, a network that cannot be compiled or has no steady state.
    pub fn new(
        spec: Spec,
        model: Arc<Model>,
        priors: Vec<Distribution>,
        seed: u64,
        name: &str,
    ) -> Result<Self, JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let network = Network::compile(&model, &[]).map_err(|e| failed(e.to_string()))?;
        let design = spec.design.as_ref().map(|design| design.variable);
        let uncertain: Vec<usize> =
            (0..priors.len()).filter(|&i| !priors[i].is_fixed() && design != Some(Variable::Parameter(i))).collect();
        if uncertain.is_empty() {
            return Err(failed("every parameter is fixed: there is nothing to know better".to_owned()));
        }
        if spec.requirements.is_empty() {
            return Err(failed("there is no requirement to meet".to_owned()));
        }
        let points = |purpose: &str, samples: usize, dimensions: usize| {
            Points::new(PointKind::Sobol, StreamKey::new(seed, name, purpose), samples, dimensions)
                .map_err(|e| failed(e.to_string()))
        };
        let samples = usize::try_from(spec.samples).unwrap_or(usize::MAX);
        let sets = MOST_TOGETHER.min(uncertain.len());
        let (points, truth_points) = (points("goal", samples, uncertain.len())?, points("truths", TRUTHS, 2 * sets)?);
        let nominal: Vec<f64> = model
            .parameters
            .iter()
            .zip(&priors)
            .map(|(parameter, prior)| if let Distribution::Fixed(value) = prior { *value } else { parameter.nominal })
            .collect();
        let required = spec.requirements.iter().map(|requirement| requirement.probability).fold(0.0, f64::max);
        let mut starts = Vec::new();
        let mut workspace = network.workspace();
        network.set_parameters(&mut workspace, &nominal);
        for environment in &spec.environments {
            if network.external().is_some() {
                // What is asked outside is asked when the job runs; there is nothing to start from.
                starts.push(Vec::new());
                continue;
            }
            network.set_inputs(&mut workspace, &environment.inputs);
            network
                .solve_steady(&mut workspace, Start::Default)
                .map_err(|e| failed(format!("environment `{}` at nominal parameters: {e}", environment.name)))?;
            starts.push(workspace.temperatures().to_vec());
        }
        Ok(Self { spec, model, priors, network, points, truth_points, uncertain, nominal, starts, required })
    }

    /// The parameters that are sharpened, in order: those of the settings, else the leading ones.
    pub(super) fn sharpened(&self, prior: &Prior) -> Vec<usize> {
        if self.spec.parameters.is_empty() {
            // What has no main effect beyond its error would only cost an experiment.
            // Nor is a surrogate's error anything that an experiment could teach.
            let errors = self.network.external().map_or(0..0, |external| external.errors.clone());
            let matters = |(index, leading): &&(usize, output::Leading)| {
                leading.main.is_some_and(|main| main.lower > 0.0) && !errors.contains(index)
            };
            prior.leading.iter().filter(matters).map(|(index, _)| *index).take(MOST_TOGETHER).collect()
        } else {
            let asked_for = self.spec.parameters.iter().copied().filter(|index| self.uncertain.contains(index));
            asked_for.take(MOST_TOGETHER).collect()
        }
    }

    /// Knowledge of the first `set` parameters that leaves a share of their standard deviations, at the priors' means.
    pub(super) fn known(&self, parameters: &[usize], set: usize, ratio: f64) -> Vec<Known> {
        parameters[..set.min(parameters.len())]
            .iter()
            .map(|&parameter| {
                let prior = &self.priors[parameter];
                Known { parameter, reading: prior.mean(), error: error_for(prior, ratio) }
            })
            .collect()
    }

    /// Design values from where the search starts to its end.
    pub(super) fn design_values(&self) -> Vec<f64> {
        let Some([from, to]) = self.design_range() else { return Vec::new() };
        between(from, to, DESIGN_VALUES)
    }

    pub(super) fn design_range(&self) -> Option<[f64; 2]> {
        let values = &self.spec.design.as_ref()?.values;
        Some([*values.first()?, *values.last()?])
    }

    /// Blocks of the second stage: levels of knowledge, and the curves over the design variable.
    pub(super) fn levels(&self, prior: &Prior) -> Vec<Vec<Cell>> {
        let parameters = self.sharpened(prior);
        let samples = self.spec.samples;
        let mut cells = Vec::new();
        for set in 1..=parameters.len() {
            for ratio in RATIOS {
                let knowledge = self.known(&parameters, set, ratio);
                cells.push(vec![Cell { role: Role::Level { set, ratio }, known: knowledge, design: None, samples }]);
            }
        }
        for set in 0..=parameters.len() {
            let ratios: &[f64] = if set == 0 { &[1.0] } else { &DESIGN_RATIOS };
            for &ratio in ratios {
                let knowledge = self.known(&parameters, set, ratio);
                let curve =
                    |design| Cell { role: Role::Curve { set, ratio }, known: knowledge.clone(), design, samples };
                cells.push(self.design_values().into_iter().map(|value| curve(Some(value))).collect());
            }
        }
        cells.retain(|cells| !cells.is_empty());
        cells
    }

    /// Runs the cells of a block, each a part that a kill does not lose; those between the two design values of its curve
    /// between which the probability is reached come last.
    pub(super) fn run_all(&self, cells: &[Cell], parts: &dyn Parts) -> Vec<Outcome> {
        let most = cells.len() + DESIGN_FINER;
        let kept = (1..=most).rev().find_map(|count| {
            let outcomes = Vec::<Outcome>::from_bytes(&parts.find(count as u64)?, CELLS).ok()?;
            (outcomes.len() == count).then_some(outcomes)
        });
        let mut outcomes = kept.unwrap_or_default();
        let run = |outcomes: &mut Vec<Outcome>, cells: &[Cell]| {
            for cell in cells {
                outcomes.push(self.run(cell));
                if parts.is_due()
                    && let Ok(bytes) = outcomes.clone().into_bytes()
                {
                    parts.keep(outcomes.len() as u64, &bytes);
                }
            }
        };
        let first = cells.get(outcomes.len()..).unwrap_or_default();
        run(&mut outcomes, first);
        // Which design values come closer follows from the first ones alone.
        let finer = self.finer(&outcomes[..cells.len()]);
        let done = outcomes.len() - cells.len();
        run(&mut outcomes, finer.get(done..).unwrap_or_default());
        outcomes
    }

    /// Cells between the two design values of a curve between which the probability is reached.
    pub(super) fn finer(&self, outcomes: &[Outcome]) -> Vec<Cell> {
        let curve: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.cell.design.is_some()).collect();
        let last = curve.iter().rposition(|o| o.probability().value < self.required);
        let Some((last, next)) = last.and_then(|last| Some((curve[last], *curve.get(last + 1)?))) else {
            return Vec::new();
        };
        let Some((from, to)) = last.cell.design.zip(next.cell.design) else { return Vec::new() };
        let inner = between(from, to, DESIGN_FINER + 2);
        inner[1..=DESIGN_FINER].iter().map(|&value| Cell { design: Some(value), ..next.cell.clone() }).collect()
    }

    /// Shares between the last that is enough and the first that is not.
    pub(super) fn search(&self, state: &State) -> Vec<Vec<Cell>> {
        let Some((set, [enough, too_much])) = state.target else { return Vec::new() };
        let parameters = self.sharpened(&state.prior);
        let inner = between(enough, too_much, SEARCHED + 2);
        let cell = |ratio: f64| Cell {
            role: Role::Level { set, ratio },
            known: self.known(&parameters, set, ratio),
            design: None,
            samples: self.spec.samples,
        };
        inner[1..=SEARCHED].iter().map(|&ratio| vec![cell(ratio)]).collect()
    }

    /// The smallest set that is enough with some share, and the bracket of the share: where the probability is reached with
    /// this and all smaller ones, and the next larger, where it is not.
    pub(super) fn bracket(&self, state: &State) -> Option<(usize, [f64; 2])> {
        if state.prior.probability.value >= self.required {
            return None;
        }
        (1..=self.sharpened(&state.prior).len()).find_map(|set| {
            let mut levels: Vec<(f64, f64)> = state
                .outcomes
                .iter()
                .filter_map(|o| match o.cell.role {
                    Role::Level { set: other, ratio } if other == set => Some((ratio, o.probability().value)),
                    _ => None,
                })
                .collect();
            levels.push((1.0, state.prior.probability.value));
            sort_by(&mut levels, |a, b| a.0.total_cmp(&b.0));
            let first = levels.iter().position(|&(_, probability)| probability < self.required)?;
            let enough = levels[first.checked_sub(1)?].0;
            Some((set, [enough, levels[first].0]))
        })
    }

    /// The set and share of the experiment whose outcome is averaged over truths.
    pub(super) fn experiment(&self, state: &State) -> Option<(usize, f64)> {
        let sets = self.sharpened(&state.prior).len();
        if sets == 0 {
            return None;
        }
        Some(match state.target {
            Some((set, [enough, _])) => (set, enough),
            None if state.prior.probability.value >= self.required => (1, USUAL_RATIO),
            None => (sets, USUAL_RATIO),
        })
    }

    /// What the experiment would read if each truth held, by the given design and along the design variable: a block a truth.
    pub(super) fn truths(&self, state: &State) -> Vec<Vec<Cell>> {
        let Some((set, ratio)) = self.experiment(state) else { return Vec::new() };
        let parameters = self.sharpened(&state.prior);
        let knowledge = self.known(&parameters, set, ratio);
        let samples = TRUTH_SAMPLES.min(self.spec.samples);
        let mut row = vec![0.0; self.truth_points.dimensions()];
        let mut cells = Vec::new();
        for index in 0..TRUTHS {
            self.truth_points.fill_row(index, &mut row);
            let readings: Vec<Known> = knowledge
                .iter()
                .enumerate()
                .map(|(place, planned)| {
                    let truth = self.priors[planned.parameter].quantile(row[2 * place]);
                    let error = planned.error * crate::math::special::normal_quantile(row[2 * place + 1]);
                    Known { reading: truth + error, ..*planned }
                })
                .collect();
            let mut truth_cells =
                vec![Cell { role: Role::Truth { index }, known: readings.clone(), design: None, samples }];
            let curve = |design| Cell { role: Role::TruthCurve { index }, known: readings.clone(), design, samples };
            truth_cells.extend(self.design_values().into_iter().map(|value| curve(Some(value))));
            cells.push(truth_cells);
        }
        cells
    }

    /// A stage of blocks of cells.
    pub(super) fn stage(stage: String, inputs: Vec<Vec<Cell>>, state: State) -> Step<Self> {
        Step::Blocks { stage, state: Some(state), inputs }
    }

    /// The next stage, or the result.
    pub(super) fn next(&self, mut state: State) -> Result<Step<Self>, JobError> {
        self.check_failures(&state)?;
        if !state.has_truths {
            state.target = self.bracket(&state);
            let blocks = if state.searches < SEARCHES { self.search(&state) } else { Vec::new() };
            state.searches += 1;
            if !blocks.is_empty() {
                return Ok(Self::stage(format!("closer {}", state.searches), blocks, state));
            }
            state.has_truths = true;
            let blocks = self.truths(&state);
            if !blocks.is_empty() {
                return Ok(Self::stage("truths".to_owned(), blocks, state));
            }
        }
        Ok(Step::Done(Box::new(self.output(&state))))
    }

    pub(super) fn check_failures(&self, state: &State) -> Result<(), JobError> {
        let (failed, solves) = self.counts(state);
        let share = failed as f64 / solves.max(1) as f64;
        if share > self.spec.failure_limit {
            let mut failures = std::iter::once(&state.prior.failed).chain(state.outcomes.iter().map(|o| &o.failed));
            let example = failures.find_map(|failed| failed.first.as_ref()).map_or(String::new(), |f| format!("; {f}"));
            return Err(JobError::Failed(format!(
                "{failed} of {solves} solves failed, more than the limit of {} %{example}",
                100.0 * self.spec.failure_limit
            )));
        }
        Ok(())
    }

    /// Failed solves and all.
    pub(super) fn counts(&self, state: &State) -> (u64, u64) {
        let environments = self.spec.environments.len() as u64;
        let failed = state.prior.failed.count + state.outcomes.iter().map(|o| o.failed.count).sum::<u64>();
        let samples = self.spec.samples + state.outcomes.iter().map(|o| o.cell.samples).sum::<u64>();
        (failed, environments * samples)
    }
}

/// Equally spaced values, both ends exact.
pub(super) fn between(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count)
        .map(|index| {
            let share = index as f64 / (count - 1) as f64;
            from * (1.0 - share) + to * share
        })
        .collect()
}

impl Job for Goal {
    /// Nothing before the prior is known.
    type State = Option<State>;
    /// Cells of which those with a design value are one curve; none for the prior.
    type Input = Vec<Cell>;
    type Partial = Partial;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "goal"
    }

    fn algorithm_version(&self) -> u32 {
        3
    }

    fn identity(&self) -> Value {
        json!({"settings": self.spec, "model": self.model.identity(), "priors": self.priors})
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        Ok(Step::Blocks { stage: "prior".to_owned(), state: None, inputs: vec![Vec::new()] })
    }

    fn external(&self) -> Option<&External> {
        self.network.external()
    }

    fn block(&self, state: &Option<State>, cells: Vec<Cell>, parts: &dyn Parts) -> Result<Partial, JobError> {
        Ok(match state {
            None => Partial::Prior(Box::new(self.prior(parts))),
            Some(_) => Partial::Cells(self.run_all(&cells, parts)),
        })
    }

    fn memory_bytes(&self) -> u64 {
        // The values of the prior's samples, and whether each is met in the cells that are looked at.
        let values = (self.spec.environments.len() * self.spec.requirements.len()) as u64 + 2;
        values.saturating_mul(self.spec.samples).saturating_mul(size_of::<f64>() as u64)
    }

    fn reduce(&self, state: Option<State>, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let mut outcomes = state.as_ref().map_or_else(Vec::new, |state| state.outcomes.clone());
        let mut prior = state.as_ref().map(|state| state.prior.clone());
        for (_, partial) in blocks {
            match partial {
                Partial::Prior(block_prior) => prior = Some(*block_prior),
                Partial::Cells(block_outcomes) => outcomes.extend(block_outcomes),
            }
        }
        let prior = prior.ok_or_else(|| JobError::Failed("the block of the prior is not there".to_owned()))?;
        if let Some(state) = state {
            return self.next(State { outcomes, ..state });
        }
        let cells = self.levels(&prior);
        let state = State { prior, outcomes, target: None, searches: 0, has_truths: false };
        self.check_failures(&state)?;
        if cells.is_empty() {
            return self.next(state);
        }
        Ok(Self::stage("knowledge".to_owned(), cells, state))
    }
}
