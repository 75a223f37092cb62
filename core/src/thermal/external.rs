//! A model that is not a network: something outside, a program or a server, answers with outputs for parameters and inputs.
//!
//! To everything that solves it is a network without nodes, whose quantities are expressions over its outputs. It has no
//! equations to differentiate. Slopes of its outputs are asked for where it has them (`external_slopes.rs`); elsewhere they
//! are central differences with the steps that the model states, forward or backward ones where one side has no answer.

use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

use thiserror::Error;

use crate::expression::Symbol;

use super::batch::Batch;
use super::equations::segment;
use super::network::{Network, Workspace};
use super::newton::SteadyStats;
use super::steady::SteadyError;
use super::tangent::UnsolvedError;

/// Where a model is asked, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// All parameters, in the model's order.
    pub parameters: Vec<f64>,
    /// All inputs, in the model's order.
    pub inputs: Vec<f64>,
}

/// Why there is no answer at a point.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{what}: {detail}")]
pub struct Fault {
    /// What happened, the same text at all points to which it happens.
    pub what: &'static str,
    /// The details.
    pub detail: String,
}

/// At which point and by what slopes of the outputs are asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct SlopesAt {
    /// The point.
    pub point: Point,
    /// By which of the parameters, then inputs, in rising order.
    pub by: Vec<usize>,
    /// Weight of each output, where the slopes of the weighted sum are wanted and not those of each.
    pub weights: Option<Vec<f64>>,
}

/// Where slopes come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivatives {
    /// From whoever answers for the model.
    Served,
    /// From differences with steps that the model states for all uncertain parameters.
    StatedSteps,
    /// From differences with steps that follow from the priors.
    UsualSteps,
}

/// Answers for a model. The same point has the same answer.
pub trait Evaluator: Debug + Send + Sync {
    /// Whether it can be asked now: it is allowed to run, and is what the model says that it is.
    ///
    /// # Errors
    /// What people are to do about it.
    fn ready(&self) -> Result<(), String>;
    /// The outputs at each point, SI, as many as the model has and all finite, or why there are none.
    fn evaluate(&self, points: &[Point]) -> Vec<Result<Vec<f64>, Fault>>;
    /// Slopes of the outputs, SI and finite, or why there are none: of the weighted sum a number for each of `by`, else
    /// `outputs x by`, row by row. Asked only where the model says that they are [`Derivatives::Served`].
    fn slopes(&self, asked: &[SlopesAt]) -> Vec<Result<Vec<f64>, Fault>> {
        let fault = Fault { what: "the model has no derivatives", detail: "none are served".to_owned() };
        vec![Err(fault); asked.len()]
    }
    /// What keeps it from answering at all, whatever the point: what was asked since then says nothing of the model.
    fn broken(&self) -> Option<String>;
}

/// What answers for a model in place of nodes and elements.
#[derive(Clone, Debug)]
pub struct External {
    /// Number of outputs.
    pub outputs: usize,
    /// What it is, for people, as in "the command `sim/run.sh`".
    pub description: String,
    /// What of it decides a result.
    pub identity: serde_json::Value,
    /// Step of differences by each parameter, then by each input, SI.
    pub steps: Vec<f64>,
    /// Where slopes come from.
    pub derivatives: Derivatives,
    /// Parameters that are errors of a surrogate in their standard deviations, one an output; none without a surrogate.
    pub errors: Range<usize>,
    /// Who asks it; `None` where nobody was lent.
    pub evaluator: Option<Arc<dyn Evaluator>>,
}

impl External {
    /// As [`Evaluator::ready`].
    ///
    /// # Errors
    /// As there; nobody asks it.
    pub fn ready(&self) -> Result<(), String> {
        match &self.evaluator {
            Some(evaluator) => evaluator.ready(),
            None => Err("nothing was lent that could ask what is outside".to_owned()),
        }
    }

    /// Whether a surrogate answers, which takes no time to speak of.
    pub fn is_surrogate(&self) -> bool {
        !self.errors.is_empty()
    }

    /// As [`Evaluator::broken`].
    pub fn broken(&self) -> Option<String> {
        self.evaluator.as_ref()?.broken()
    }

    /// As [`Evaluator::evaluate`].
    pub fn evaluate(&self, points: &[Point]) -> Vec<Result<Vec<f64>, Fault>> {
        match &self.evaluator {
            Some(evaluator) => evaluator.evaluate(points),
            None => {
                let fault = Fault { what: "the model was not asked", detail: "nothing was lent that could".to_owned() };
                vec![Err(fault); points.len()]
            }
        }
    }

    /// As [`Evaluator::slopes`].
    pub fn slopes(&self, asked: &[SlopesAt]) -> Vec<Result<Vec<f64>, Fault>> {
        match &self.evaluator {
            Some(evaluator) => evaluator.slopes(asked),
            None => {
                let fault = Fault { what: "the model was not asked", detail: "nothing was lent that could".to_owned() };
                vec![Err(fault); asked.len()]
            }
        }
    }

    /// Step of differences by a symbol, SI; `None` for what is neither a parameter nor an input.
    fn step(&self, parameters: usize, symbol: Symbol) -> Option<f64> {
        match symbol {
            Symbol::Parameter(index) => self.steps.get(index as usize).copied(),
            Symbol::Input(index) => self.steps.get(parameters + index as usize).copied(),
            _ => None,
        }
    }
}

/// Sums of the slopes of all quantities (`quantities x symbols`) with weights, a number a symbol.
fn weighted(tangent: &[f64], weights: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (row, weight) in tangent.chunks_exact(out.len().max(1)).zip(weights) {
        // A quantity that nobody asks for may have no slope.
        if *weight != 0.0 {
            out.iter_mut().zip(row).for_each(|(sum, slope)| *sum += weight * slope);
        }
    }
}

impl Network {
    /// The point of these parameters and inputs.
    pub(super) fn point(&self, value: impl Fn(usize) -> f64) -> Point {
        let (parameters, inputs) = (self.steady.parameters, self.steady.inputs);
        Point {
            parameters: (0..parameters).map(&value).collect(),
            inputs: (parameters..parameters + inputs).map(&value).collect(),
        }
    }

    /// Puts the outputs at the workspace's parameters and inputs into its registers.
    pub(super) fn ask(&self, external: &External, workspace: &mut Workspace) -> Result<(), SteadyError> {
        workspace.solved = false;
        let point = self.point(|place| workspace.state.file[place]);
        let answer = external.evaluate(std::slice::from_ref(&point)).pop();
        self.take(workspace, &answer.unwrap_or_else(unanswered)?);
        Ok(())
    }

    fn take(&self, workspace: &mut Workspace, outputs: &[f64]) {
        let registers = self.steady.given_outputs();
        for (slot, value) in workspace.state.file[registers].iter_mut().zip(outputs) {
            *slot = *value;
        }
        workspace.stale_inputs = true;
    }

    /// Asks for every lane with work of its own; the others get the outcome of none.
    pub(super) fn ask_for_lanes<const N: usize>(&self, external: &External, batch: &mut Batch<N>) {
        batch.one_by_one = false;
        let lanes = batch.used();
        let points: Vec<Point> = (0..lanes).map(|lane| self.point(|place| batch.state.file[place][lane])).collect();
        let mut answers = external.evaluate(&points).into_iter();
        for lane in 0..lanes {
            batch.outcomes[lane] = match answers.next().unwrap_or_else(unanswered) {
                Ok(outputs) => {
                    for (place, value) in self.steady.given_outputs().zip(outputs) {
                        batch.state.file[place][lane] = value;
                    }
                    Ok(SteadyStats::default())
                }
                Err(fault) => Err(fault.into()),
            };
        }
        for part in [segment::PARAMETERS, segment::INPUTS, segment::INSTANT, segment::QUANTITY] {
            self.steady.program.run(part, &mut batch.state.file);
        }
        batch.stale_parameters = false;
    }

    /// Slopes of all quantities at a solution by the differentiated symbols (`quantities x symbols`); not a number where there
    /// is no answer.
    pub(super) fn external_tangent(
        &self,
        external: &External,
        workspace: &mut Workspace,
        out: &mut [f64],
    ) -> Result<(), UnsolvedError> {
        match external.derivatives {
            Derivatives::Served => self.served_slopes(external, workspace, None, out),
            _ => self.quantity_differences(external, workspace, out),
        }
    }

    /// The slopes of the sum of the quantities with these weights, a number a symbol.
    pub(super) fn external_gradient(
        &self,
        external: &External,
        workspace: &mut Workspace,
        weights: &[f64],
        out: &mut [f64],
    ) -> Result<(), UnsolvedError> {
        if external.derivatives == Derivatives::Served {
            return self.served_slopes(external, workspace, Some(weights), out);
        }
        let mut tangent = vec![0.0; self.quantities.len() * self.differentiate.len()];
        self.quantity_differences(external, workspace, &mut tangent)?;
        weighted(&tangent, weights, out);
        Ok(())
    }

    /// As [`Network::external_tangent`], by differences.
    fn quantity_differences(
        &self,
        external: &External,
        workspace: &mut Workspace,
        out: &mut [f64],
    ) -> Result<(), UnsolvedError> {
        if !workspace.solved {
            return Err(UnsolvedError);
        }
        let columns = self.differentiate.len();
        let centre = self.point(|place| workspace.state.file[place]);
        let outputs: Vec<f64> = workspace.state.file[self.steady.given_outputs()].to_vec();
        // Symbol, distance and point: below and above, side by side, so that all are asked at once.
        let mut steps: Vec<(usize, f64, Point)> = Vec::new();
        for (column, &symbol) in self.differentiate.iter().enumerate() {
            let Some(step) = external.step(self.steady.parameters, symbol) else { continue };
            for distance in [-step, step] {
                let mut point = centre.clone();
                match symbol {
                    Symbol::Parameter(index) => point.parameters[index as usize] += distance,
                    Symbol::Input(index) => point.inputs[index as usize] += distance,
                    _ => continue,
                }
                steps.push((column, distance, point));
            }
        }
        let points: Vec<Point> = steps.iter().map(|(_, _, point)| point.clone()).collect();
        let answers = external.evaluate(&points);
        let at_centre = self.all_quantities(workspace);
        out.fill(0.0);
        for (pair, answers) in steps.chunks_exact(2).zip(answers.chunks_exact(2)) {
            let column = pair[0].0;
            let mut side = |place: usize| -> Option<(f64, Vec<f64>)> {
                let (_, distance, point) = &pair[place];
                let outputs = answers[place].as_ref().ok()?;
                Some((*distance, self.quantities_at(workspace, point, outputs)))
            };
            let (below, above) = (side(0), side(1));
            let centre = Some((0.0, at_centre.clone()));
            let (from, to) = match (below, above) {
                (None, above) => (centre, above),
                (below, None) => (below, centre),
                both => both,
            };
            for row in 0..self.quantities.len() {
                out[row * columns + column] = match (&from, &to) {
                    (Some((from, low)), Some((to, high))) => (high[row] - low[row]) / (to - from),
                    _ => f64::NAN,
                };
            }
        }
        // As it was found.
        self.quantities_at(workspace, &centre, &outputs);
        workspace.solved = true;
        Ok(())
    }

    fn all_quantities(&self, workspace: &Workspace) -> Vec<f64> {
        (0..self.quantities.len()).map(|index| self.quantity(workspace, index)).collect()
    }

    /// The quantities at a point with these outputs.
    fn quantities_at(&self, workspace: &mut Workspace, point: &Point, outputs: &[f64]) -> Vec<f64> {
        self.set_parameters(workspace, &point.parameters);
        self.set_inputs(workspace, &point.inputs);
        self.take(workspace, outputs);
        self.refresh(workspace);
        self.steady.program.run(segment::QUANTITY, &mut workspace.state.file);
        self.all_quantities(workspace)
    }

    /// [`Network::external_gradient`] for every lane with work of its own.
    pub(super) fn lane_external_gradient<const N: usize>(
        &self,
        external: &External,
        batch: &mut Batch<N>,
        weights: &[[f64; N]],
        out: &mut [[f64; N]],
    ) {
        if external.derivatives == Derivatives::Served {
            self.lane_served_slopes(external, batch, Some(weights), out);
            return;
        }
        let mut tangent = vec![[0.0; N]; self.quantities.len() * self.differentiate.len()];
        self.lane_differences(external, batch, &mut tangent);
        for lane in 0..batch.used() {
            let of_lane = |values: &[[f64; N]]| values.iter().map(|lanes| lanes[lane]).collect::<Vec<f64>>();
            let mut gradient = vec![0.0; out.len()];
            weighted(&of_lane(&tangent), &of_lane(weights), &mut gradient);
            out.iter_mut().zip(gradient).for_each(|(lanes, slope)| lanes[lane] = slope);
        }
    }

    /// [`Network::external_tangent`] for every lane with work of its own.
    pub(super) fn lane_external_tangent<const N: usize>(
        &self,
        external: &External,
        batch: &mut Batch<N>,
        out: &mut [[f64; N]],
    ) {
        match external.derivatives {
            Derivatives::Served => self.lane_served_slopes(external, batch, None, out),
            _ => self.lane_differences(external, batch, out),
        }
    }

    fn lane_differences<const N: usize>(&self, external: &External, batch: &mut Batch<N>, out: &mut [[f64; N]]) {
        let mut tangent = vec![0.0; out.len()];
        for lane in 0..batch.used() {
            let registers = self.steady.time();
            for (slot, lanes) in batch.alone.state.file[..registers].iter_mut().zip(&batch.state.file) {
                *slot = lanes[lane];
            }
            (batch.alone.stale_parameters, batch.alone.stale_inputs) = (true, true);
            self.refresh(&mut batch.alone);
            self.store(&mut batch.alone);
            let is_solved = batch.outcomes[lane].is_ok()
                && self.quantity_differences(external, &mut batch.alone, &mut tangent).is_ok();
            for (lanes, slope) in out.iter_mut().zip(&tangent) {
                lanes[lane] = if is_solved { *slope } else { f64::NAN };
            }
        }
    }
}

/// An evaluator that gives fewer answers than it was asked for.
pub(super) fn unanswered() -> Result<Vec<f64>, Fault> {
    Err(Fault { what: "the model was not asked", detail: "there are fewer answers than points".to_owned() })
}
