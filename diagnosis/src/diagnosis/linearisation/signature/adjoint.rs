//! Exact derivatives of steady phases: what an effect at amplitude 0 would do, from one solution of each phase.
//!
//! With the balances `r(T, a) = 0` and a reading `q(T, a)`: `dq/da = dq/da|T - l' dr/da`, `J' l = dq/dT`. The adjoints
//! `l` are those of the model without effects, a solve a reading; of each candidate only `dr/da` and `dq/da|T` are
//! wanted, a few expressions, evaluated at the solution (`slopes`).

use super::slopes::{Bench, Outputs, Slopes};
use super::variant::{self, Variant};
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::linearisation::linear::Direction;
use crate::inference::likelihood::{Likelihood, SteadyState};
use crate::inference::target::Rejected;

/// The phases at the fit.
pub(super) struct Phases {
    states: Vec<SteadyState>,
    parameters: Vec<f64>,
}

impl Phases {
    pub fn new(likelihood: &Likelihood, unknowns: &[f64]) -> Result<Self, Rejected> {
        let states = likelihood.steady_states(unknowns)?;
        Ok(Self { states, parameters: likelihood.full_parameters(unknowns) })
    }

    /// Adds the directions of variants to what was found of their candidates.
    pub fn directions(&self, base: &Base<'_>, variants: &[Variant<'_>], directions: &mut [Found]) {
        let mut bench = Bench::new(&base.problem.model);
        let slopes: Vec<Result<Vec<Slopes>, FitError>> =
            variants.iter().map(|variant| bench.slopes(base, variant)).collect();
        let outputs = bench.outputs();
        let values = self.values(&bench.into_outputs(&self.parameters), outputs);
        let mut column = vec![0.0; base.residuals.len()];
        for (variant, slopes) in variants.iter().zip(slopes) {
            let columns = slopes.and_then(|slopes| {
                let columns = slopes.iter().map(|slopes| {
                    self.column(base, slopes, &values, &mut column);
                    base.whitening.apply(&mut column)?;
                    Ok(column.clone())
                });
                columns.collect::<Result<Vec<Vec<f64>>, FitError>>()
            });
            let direction: Result<Option<Direction>, FitError> =
                columns.and_then(|columns| variant.direction(base.rows, columns.into_iter()));
            variant::put(&mut directions[variant.asked], direction);
        }
    }

    /// Whitened columns of the heat that elements carry.
    pub fn heats_of_elements(&self, base: &Base<'_>, elements: &[usize]) -> Result<Vec<Vec<f64>>, FitError> {
        let mut bench = Bench::new(&base.problem.model);
        let slopes: Vec<Slopes> = elements.iter().map(|&element| bench.heats_of(element)).collect();
        let outputs = bench.outputs();
        let values = self.values(&bench.into_outputs(&self.parameters), outputs);
        let column = |slopes: &Slopes| {
            let mut column = vec![0.0; base.residuals.len()];
            self.column(base, slopes, &values, &mut column);
            base.whitening.apply(&mut column)?;
            Ok(column)
        };
        slopes.iter().map(column).collect()
    }

    /// Values of the outputs of a program, phase by phase.
    pub fn values(&self, program: &Outputs, outputs: usize) -> Vec<Vec<f64>> {
        let mut room = program.room();
        let of_phase = |state: &SteadyState| {
            let mut values = vec![0.0; outputs];
            program.evaluate(&mut room, &state.inputs, 0.0, &state.temperatures, &mut |output, value| {
                values[output] = value;
            });
            values
        };
        self.states.iter().map(of_phase).collect()
    }

    /// Changes of the predictions a unit of an amplitude.
    pub fn column(&self, base: &Base<'_>, slopes: &Slopes, values: &[Vec<f64>], column: &mut [f64]) {
        column.fill(0.0);
        let data = base.likelihood.data();
        for (state, values) in self.states.iter().zip(values) {
            let nodes = state.temperatures.len();
            for (position, adjoint) in state.adjoint.chunks_exact(nodes.max(1)).enumerate() {
                let row = state.first + position;
                let mut change = 0.0;
                for &(node, output) in &slopes.heats {
                    if let Some(adjoint) = adjoint.get(node) {
                        change -= adjoint * values[output];
                    }
                }
                if !slopes.quantities.is_empty() || !slopes.readings.is_empty() {
                    let sensor = &base.problem.measurements[data[row].measurement].sensors[data[row].sensor];
                    let direct = slopes.of_sensor(&sensor.name, sensor.quantity);
                    change += direct.map_or(0.0, |output| values[output]);
                }
                column[row] = change;
            }
        }
    }
}
