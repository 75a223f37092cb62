//! Slopes of a model that is asked outside, where whoever answers for it has them.
//!
//! A quantity `q(p, x, y)` is an expression over parameters, inputs and outputs `y(p, x)`, so that
//! `dq/dp = dq/dp|y + (dq/dy) dy/dp`. The outer slopes are symbolic, and `dy/dp` is asked for: of all outputs, or of their sum
//! with weights, which a model with an adjoint gives at the cost of one.

use crate::expression::Symbol;

use super::batch::Batch;
use super::equations::segment;
use super::external::{External, Fault, SlopesAt, unanswered};
use super::network::{Network, Workspace};
use super::tangent::UnsolvedError;

impl Network {
    /// Which of the parameters, then inputs, each differentiated symbol is.
    fn places(&self) -> Vec<Option<usize>> {
        let place = |symbol: &Symbol| match symbol {
            Symbol::Parameter(index) => Some(*index as usize),
            Symbol::Input(index) => Some(self.steady.parameters + *index as usize),
            _ => None,
        };
        self.differentiate.iter().map(place).collect()
    }

    /// What is asked for at a point; `value` reads the registers there.
    fn slopes_at(&self, external: &External, weights: Option<&[f64]>, value: impl Fn(usize) -> f64) -> SlopesAt {
        let mut by: Vec<usize> = self.places().into_iter().flatten().collect();
        by.sort_unstable();
        by.dedup();
        let columns = self.differentiate.len();
        let weights = weights.map(|weights| {
            let mut of_outputs = vec![0.0; external.outputs];
            for entry in self.steady.quantity_symbol.iter().filter(|entry| entry.column >= columns) {
                // A quantity that nobody asks for may have no slope.
                if let Some(slot) = of_outputs.get_mut(entry.column - columns)
                    && weights[entry.row] != 0.0
                {
                    *slot += weights[entry.row] * value(entry.register.index());
                }
            }
            of_outputs
        });
        SlopesAt { point: self.point(value), by, weights }
    }

    /// Puts the slopes of the quantities, or of their weighted sum, together; not a number where there is no answer.
    fn put_slopes(
        &self,
        asked: &SlopesAt,
        weights: Option<&[f64]>,
        answer: &Result<Vec<f64>, Fault>,
        value: impl Fn(usize) -> f64,
        out: &mut [f64],
    ) {
        let Ok(slopes) = answer else {
            out.fill(f64::NAN);
            return;
        };
        let columns = self.differentiate.len();
        let places = self.places();
        let position = |place: usize| asked.by.binary_search(&place).ok();
        out.fill(0.0);
        for entry in self.steady.quantity_symbol.iter() {
            let slope = value(entry.register.index());
            match (weights, entry.column.checked_sub(columns)) {
                (None, None) => out[entry.row * columns + entry.column] += slope,
                (None, Some(output)) => {
                    for (column, place) in places.iter().enumerate() {
                        let of_output =
                            place.and_then(position).and_then(|by| slopes.get(output * asked.by.len() + by));
                        out[entry.row * columns + column] += of_output.map_or(0.0, |of_output| slope * of_output);
                    }
                }
                (Some(weights), None) if weights[entry.row] != 0.0 => out[entry.column] += weights[entry.row] * slope,
                // The outputs' part is in the answer.
                (Some(_), _) => {}
            }
        }
        if weights.is_some() {
            for (slot, place) in out.iter_mut().zip(&places) {
                *slot += place.and_then(position).and_then(|by| slopes.get(by)).copied().unwrap_or(0.0);
            }
        }
    }

    /// Slopes of all quantities by the differentiated symbols (`quantities x symbols`), or of their sum with weights, at a
    /// solution.
    pub(super) fn served_slopes(
        &self,
        external: &External,
        workspace: &mut Workspace,
        weights: Option<&[f64]>,
        out: &mut [f64],
    ) -> Result<(), UnsolvedError> {
        if !workspace.solved {
            return Err(UnsolvedError);
        }
        self.steady.program.run(segment::QUANTITY_TANGENT, &mut workspace.state.file);
        let file = &workspace.state.file;
        let asked = self.slopes_at(external, weights, |register| file[register]);
        let answer = external.slopes(std::slice::from_ref(&asked)).pop().unwrap_or_else(unanswered);
        self.put_slopes(&asked, weights, &answer, |register| file[register], out);
        Ok(())
    }

    /// [`Network::served_slopes`] for every lane with work of its own.
    pub(super) fn lane_served_slopes<const N: usize>(
        &self,
        external: &External,
        batch: &mut Batch<N>,
        weights: Option<&[[f64; N]]>,
        out: &mut [[f64; N]],
    ) {
        self.steady.program.run(segment::QUANTITY_TANGENT, &mut batch.state.file);
        let file = &batch.state.file;
        let solved: Vec<usize> = (0..batch.used()).filter(|&lane| batch.outcomes[lane].is_ok()).collect();
        let of_lane = |lane: usize| weights.map(|weights| weights.iter().map(|own| own[lane]).collect::<Vec<f64>>());
        let asked: Vec<SlopesAt> = (solved.iter())
            .map(|&lane| self.slopes_at(external, of_lane(lane).as_deref(), |register| file[register][lane]))
            .collect();
        let mut answers = external.slopes(&asked).into_iter();
        out.fill([f64::NAN; N]);
        let mut slopes = vec![0.0; out.len()];
        for (&lane, asked) in solved.iter().zip(&asked) {
            let answer = answers.next().unwrap_or_else(unanswered);
            self.put_slopes(asked, of_lane(lane).as_deref(), &answer, |register| file[register][lane], &mut slopes);
            out.iter_mut().zip(&slopes).for_each(|(lanes, slope)| lanes[lane] = *slope);
        }
    }
}
