//! Predictive checks of the finished posterior: what it and the prior predict, block by block, and the scores of that.

use super::block::{Partial, Predicted, State, Task};
use super::output::{CrossValidation, Output};
use super::predictive::{self, Draws, InputSpread};
use super::run::PREDICT;
use super::{Calibrate, scores};
use crate::inference::sampler::psis::{self, LeaveOneOut};
use crate::inference::target::{LeastSquares, Target};
use crate::job::{Done, JobError, Step};
use crate::math::special::chi_square_sf;
use crate::measurement::unknown::with_unknowns;
use crate::measurement::{Measurement, Rows};
use crate::random::{PointKind, Points};

/// Draws of the posterior in the predictive checks.
const POSTERIOR_CHECKS: usize = 400;
/// Draws of the prior in the predictive checks; a power of two.
const PRIOR_CHECKS: usize = 256;
/// Draws of a block of predictive checks.
const BLOCK: usize = 50;

impl Calibrate {
    /// The blocks of predictive checks.
    pub(super) fn predict_blocks(&self, output: Output) -> Result<Step<Self>, JobError> {
        let all = &output.draws.values;
        let count = POSTERIOR_CHECKS.min(all.len());
        let chosen: Vec<Vec<f64>> = (0..count).map(|k| all[(2 * k + 1) * all.len() / (2 * count)].clone()).collect();
        let priors = self.target.priors();
        let key = self.stream("calibrate prior");
        let points = Points::new(PointKind::Sobol, key, PRIOR_CHECKS, priors.len())
            .or_else(|_| Points::new(PointKind::MonteCarlo, key, PRIOR_CHECKS, priors.len()))
            .map_err(|e| JobError::Failed(e.to_string()))?;
        let mut row = vec![0.5; priors.len()];
        let before: Vec<Vec<f64>> = (0..PRIOR_CHECKS)
            .map(|index| {
                points.fill_row(index, &mut row);
                let at: Vec<f64> = priors.iter().zip(&row).map(|(prior, share)| prior.quantile(*share)).collect();
                self.target.parameters(&at)
            })
            .collect();
        let mut inputs = Vec::new();
        for (prior, draws) in [(false, &chosen), (true, &before)] {
            for draws in draws.chunks(BLOCK) {
                inputs.push(Task::Predict { prior, draws: draws.to_vec() });
            }
        }
        Ok(Step::Blocks { stage: PREDICT.to_owned(), state: State::Predict(Box::new(output)), inputs })
    }

    /// The measurements with what is inferred of them as it is at a draw.
    pub(super) fn at_unknowns(&self, draw: &[f64]) -> Vec<Measurement> {
        let names = self.likelihood().names();
        let inputs: Vec<String> = self.inputs.model.inputs.iter().map(|input| input.name.clone()).collect();
        let nodes: Vec<String> = self.inputs.model.nodes.iter().map(|node| node.name.clone()).collect();
        let find = |name: &str| names.iter().position(|unknown_name| unknown_name == name).map(|place| draw[place]);
        self.measurements().into_iter().map(|measurement| with_unknowns(measurement, &inputs, &nodes, &find)).collect()
    }

    /// What some draws predict.
    pub(super) fn predict(&self, prior: bool, draws: &[Vec<f64>]) -> Predicted {
        let mut workspace = self.predictor.workspace();
        let mut memory = self.likelihood().workspace();
        let mut pointwise = vec![0.0; self.likelihood().residual_count()];
        let mut predicted = Predicted::default();
        for draw in draws {
            let full = self.likelihood().full_parameters(draw);
            for fixed in self.at_unknowns(draw) {
                predicted.readings.extend(self.predictor.predict(&mut workspace, &fixed, &full).readings);
            }
            if !prior {
                let squares = self.likelihood().pointwise(draw, &mut memory, &mut pointwise);
                predicted.squares.push(squares.unwrap_or(f64::NAN));
                if predicted.squares.last().is_some_and(|squares| squares.is_nan()) {
                    pointwise.fill(f64::NAN);
                }
                predicted.pointwise.extend(&pointwise);
            }
        }
        predicted
    }

    /// What known errors of the inputs add to the readings, by measurement and row.
    pub(super) fn input_spread(&self) -> InputSpread {
        let of_row = |index: usize, measurement: &Measurement, row: usize| match &measurement.rows {
            Rows::Steady(phases) if !measurement.ignored(row) => {
                self.likelihood().input_covariance(index, &phases[row].inputs)
            }
            _ => None,
        };
        (self.measurements().into_iter().enumerate())
            .map(|(index, measurement)| (0..measurement.len()).map(|row| of_row(index, measurement, row)).collect())
            .collect()
    }

    /// Completes the result.
    pub(super) fn finish(&self, mut output: Box<Output>, blocks: Done<Self>) -> Step<Self> {
        let empty = || Draws { values: Vec::new(), predicted: Predicted::default() };
        let (mut posterior, mut before) = (empty(), empty());
        for block in blocks {
            let (Task::Predict { prior, draws }, Partial::Predicted(block)) = block else { continue };
            let collected = if prior { &mut before } else { &mut posterior };
            collected.values.extend(draws);
            collected.predicted.readings.extend(block.readings);
            collected.predicted.pointwise.extend(block.pointwise);
            collected.predicted.squares.extend(block.squares);
        }
        let (measurements, spread) = (self.measurements(), self.input_spread());
        let (model, order) = (&self.inputs.model, &output.order);
        output.predictive = predictive::checks(&measurements, model, order, &posterior, &before, &spread);
        output.predictive_draws = posterior.values.len() as u64;
        let readings = self.likelihood().residual_count();
        let tails: Vec<f64> = (posterior.predicted.squares.iter())
            .filter(|squares| squares.is_finite())
            .map(|&squares| chi_square_sf(squares, readings as f64))
            .collect();
        output.p_value = (!tails.is_empty()).then(|| tails.iter().sum::<f64>() / tails.len() as f64);
        let pointwise = &posterior.predicted.pointwise;
        let good = psis::greatest_good_shape(posterior.values.len());
        let validated = |left_out: &LeaveOneOut| CrossValidation {
            expected_log_density: left_out.expected_log_density,
            standard_error: left_out.standard_error,
            effective_parameters: left_out.effective_parameters,
            unreliable: left_out.pareto_k.iter().filter(|k| !(**k <= good)).count() as u64,
        };
        output.leave_one_out = psis::leave_one_out(pointwise, readings, 1.0).as_ref().map(validated);
        let (groups, summed) = scores::by_phase(&measurements, self.likelihood().data(), pointwise);
        let left_out = psis::leave_one_out(&summed, groups.len(), 1.0);
        output.leave_one_phase_out = left_out.as_ref().map(validated);
        output.phases =
            scores::phases(&measurements, &groups, left_out.as_ref(), good, &output.order, &posterior, &spread);
        output.held_out = scores::held_out(&output.phases);
        Step::Done(output)
    }
}
