//! Steady phases in the likelihood.

use super::build::is_used;
use super::whitening::Block;
use super::{Datum, Likelihood, LikelihoodError, Memory, SensorPart, SteadyState};
use crate::inference::cholesky;
use crate::inference::measurement::{Measurement, Rows};
use crate::inference::target::Rejected;
use crate::math::functions::ln;
use crate::thermal::{Network, Start, SteadyError};

/// A predicted start stays within this share of the reference's temperature.
const REACH: f64 = 0.25;

/// The phases of a measurement that take part in the fit.
#[derive(Clone, Debug)]
pub(super) struct SteadyPart {
    name: String,
    sensors: Vec<SensorPart>,
    phases: Vec<Phase>,
}

#[derive(Clone, Debug)]
struct Phase {
    name: String,
    inputs: Vec<f64>,
    /// Position of the first residual.
    first: usize,
    /// Sensor and reading, SI.
    readings: Vec<(usize, f64)>,
    /// `F S F'` of the readings, row by row.
    covariance: Option<Vec<f64>>,
    /// Where solves start.
    reference: Option<Reference>,
}

/// A solution, from which others start.
#[derive(Clone, Debug)]
struct Reference {
    /// Values of the differentiated symbols.
    at: Vec<f64>,
    temperatures: Vec<f64>,
    /// `nodes x symbols`.
    tangent: Vec<f64>,
}

impl SteadyPart {
    pub fn new(measurement: &Measurement, index: usize, sensors: Vec<SensorPart>, data: &mut Vec<Datum>) -> Self {
        let mut phases = Vec::new();
        if let Rows::Steady(written) = &measurement.rows {
            for (row, phase) in written.iter().enumerate() {
                let first = data.len();
                let mut readings = Vec::new();
                for sensor in (0..sensors.len()).filter(|&sensor| is_used(measurement, row, sensor)) {
                    if let Some(reading) = measurement.reading(row, sensor) {
                        readings.push((sensor, reading));
                        data.push(Datum { measurement: index, row, sensor });
                    }
                }
                if !readings.is_empty() {
                    let (name, inputs) = (phase.name.clone(), phase.inputs.clone());
                    phases.push(Phase { name, inputs, first, readings, covariance: None, reference: None });
                }
            }
        }
        Self { name: measurement.name.clone(), sensors, phases }
    }

    /// Most readings of a phase.
    pub fn widest(&self) -> usize {
        self.phases.iter().map(|phase| phase.readings.len()).max().unwrap_or(0)
    }

    /// Adds the inputs' known errors; `network` has these inputs as its differentiated symbols.
    pub fn set_input_errors(
        &mut self,
        network: &Network,
        parameters: &[f64],
        noisy: &[(usize, f64)],
    ) -> Result<(), LikelihoodError> {
        let mut workspace = network.workspace();
        let columns = noisy.len();
        let mut tangent = vec![0.0; network.quantities() * columns];
        network.set_parameters(&mut workspace, parameters);
        for phase in &mut self.phases {
            network.set_inputs(&mut workspace, &phase.inputs);
            let solved = network.solve_steady(&mut workspace, Start::Default).is_ok()
                && network.quantity_tangent(&mut workspace, &mut tangent).is_ok()
                && tangent.iter().all(|slope| slope.is_finite());
            if !solved {
                let (measurement, phase) = (self.name.clone(), phase.name.clone());
                return Err(LikelihoodError::Covariance { measurement, phase });
            }
            let k = phase.readings.len();
            let mut covariance = vec![0.0; k * k];
            let row = |reading: usize| {
                let quantity = self.sensors[phase.readings[reading].0].quantity;
                &tangent[quantity * columns..(quantity + 1) * columns]
            };
            for a in 0..k {
                for b in 0..k {
                    let terms = row(a).iter().zip(row(b)).zip(noisy);
                    covariance[a * k + b] = terms.map(|((x, y), (_, sigma))| x * y * sigma * sigma).sum();
                }
            }
            phase.covariance = Some(covariance);
        }
        Ok(())
    }

    /// Appends the state of each phase; the memory's network has the parameters.
    pub fn states(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        memory: &mut Memory,
        states: &mut Vec<SteadyState>,
    ) -> Result<(), Rejected> {
        let network = &likelihood.network;
        for phase in &self.phases {
            self.solve(phase, likelihood, unknowns, memory)?;
            let quantities: Vec<usize> =
                phase.readings.iter().map(|&(sensor, _)| self.sensors[sensor].quantity).collect();
            let mut adjoint = vec![0.0; quantities.len() * network.nodes()];
            network
                .quantity_adjoint(&mut memory.network, &quantities, &mut adjoint)
                .map_err(|_| Rejected::new("derivatives of a steady state are not there"))?;
            states.push(SteadyState {
                first: phase.first,
                inputs: memory.inputs.clone(),
                temperatures: memory.network.temperatures().to_vec(),
                adjoint,
            });
        }
        Ok(())
    }

    /// Solves a phase.
    fn solve(
        &self,
        phase: &Phase,
        likelihood: &Likelihood,
        unknowns: &[f64],
        memory: &mut Memory,
    ) -> Result<(), Rejected> {
        let network = &likelihood.network;
        memory.inputs.copy_from_slice(&phase.inputs);
        for &(input, place) in &likelihood.biases {
            memory.inputs[input] += unknowns[place];
        }
        network.set_inputs(&mut memory.network, &memory.inputs);
        let start = match &phase.reference {
            Some(reference) => {
                reference.predict(&likelihood.columns, unknowns, &mut memory.start);
                Start::Temperatures(&memory.start)
            }
            None => Start::Default,
        };
        match network.solve_steady(&mut memory.network, start) {
            Ok(_) => Ok(()),
            Err(error) => Err(self.rejected(phase, &error)),
        }
    }

    /// Its sensors.
    pub fn sensors(&self) -> &[SensorPart] {
        &self.sensors
    }

    /// Appends the whitening of each phase.
    pub fn whitening(&self, unknowns: &[f64], blocks: &mut Vec<Block>) -> Result<(), Rejected> {
        for phase in &self.phases {
            let of = |&(sensor, _): &(usize, f64)| self.sensors[sensor].noise.total(unknowns);
            let sd: Vec<f64> = phase.readings.iter().map(of).collect();
            let (first, size) = (phase.first, phase.readings.len());
            blocks.push(match &phase.covariance {
                None => Block::Scales { first, sd },
                Some(covariance) => Block::Factor { first, size, factor: factor(covariance, &sd)? },
            });
        }
        Ok(())
    }

    /// Solves every phase at given parameters and input errors; `at` are the differentiated symbols there.
    pub fn set_reference(&mut self, network: &Network, parameters: &[f64], shifts: &[f64], at: &[f64]) {
        let mut workspace = network.workspace();
        network.set_parameters(&mut workspace, parameters);
        for phase in &mut self.phases {
            let inputs: Vec<f64> = phase.inputs.iter().zip(shifts).map(|(value, shift)| value + shift).collect();
            network.set_inputs(&mut workspace, &inputs);
            phase.reference = None;
            if network.solve_steady(&mut workspace, Start::Default).is_err() {
                continue;
            }
            let mut tangent = vec![0.0; network.nodes() * at.len()];
            let good = network.temperature_tangent(&mut workspace, &mut tangent).is_ok()
                && tangent.iter().all(|slope| slope.is_finite());
            if good {
                let temperatures = workspace.temperatures().to_vec();
                phase.reference = Some(Reference { at: at.to_vec(), temperatures, tangent });
            }
        }
    }

    pub fn evaluate(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        memory: &mut Memory,
        slopes: bool,
    ) -> Result<(), Rejected> {
        let network = &likelihood.network;
        network.set_parameters(&mut memory.network, &memory.parameters);
        network.set_time(&mut memory.network, 0.0);
        for phase in &self.phases {
            self.solve(phase, likelihood, unknowns, memory)?;
            if slopes && network.quantity_tangent(&mut memory.network, &mut memory.tangent).is_err() {
                return Err(Rejected::new("derivatives of a steady state are not there"));
            }
            self.differences(likelihood, phase, unknowns, memory, slopes);
            match &phase.covariance {
                None => self.scale(phase, unknowns, memory, slopes),
                Some(covariance) => self.decorrelate(phase, covariance, unknowns, memory, slopes)?,
            }
        }
        Ok(())
    }

    fn rejected(&self, phase: &Phase, error: &SteadyError) -> Rejected {
        let why = match error {
            SteadyError::Island { .. } => "has nodes without a path to a boundary",
            SteadyError::NotConverged { .. } => "was not found",
            SteadyError::NotFinite { .. } => "has a heat that is not a finite number",
            SteadyError::Singular { .. } => "is not determined by the balances",
            SteadyError::Boundary { .. } => "has a boundary below 0 K",
            SteadyError::Band { .. } => "has a heater whose band is not above 0",
        };
        Rejected::new(format!("the steady state of phase `{}` of `{}` {why}", phase.name, self.name))
    }

    /// Reading minus prediction, and its derivatives.
    fn differences(&self, likelihood: &Likelihood, phase: &Phase, unknowns: &[f64], memory: &mut Memory, slopes: bool) {
        let (n, columns) = (unknowns.len(), likelihood.columns.len());
        for (position, &(sensor, reading)) in phase.readings.iter().enumerate() {
            let sensor = &self.sensors[sensor];
            let at = phase.first + position;
            let predicted = likelihood.network.quantity(&memory.network, sensor.quantity);
            let bias = sensor.bias.map_or(0.0, |bias| bias.at(unknowns));
            memory.residuals[at] = reading - predicted - bias;
            if slopes {
                let row = &mut memory.jacobian[at * n..(at + 1) * n];
                let tangent = &memory.tangent[sensor.quantity * columns..(sensor.quantity + 1) * columns];
                for (&place, slope) in likelihood.columns.iter().zip(tangent) {
                    row[place] = -slope;
                }
                if let Some(place) = sensor.bias.and_then(|bias| bias.place()) {
                    row[place] -= 1.0;
                }
            }
        }
    }

    /// Independent noise: divides by each sensor's standard deviation.
    fn scale(&self, phase: &Phase, unknowns: &[f64], memory: &mut Memory, slopes: bool) {
        let n = unknowns.len();
        for (position, &(sensor, _)) in phase.readings.iter().enumerate() {
            let noise = &self.sensors[sensor].noise;
            let at = phase.first + position;
            let sd = noise.total(unknowns);
            memory.residuals[at] /= sd;
            memory.log_scales[at] = -ln(sd);
            if slopes {
                let row = &mut memory.jacobian[at * n..(at + 1) * n];
                for value in row.iter_mut() {
                    *value /= sd;
                }
                for (place, slope) in noise.total_slopes(unknowns).into_iter().flatten() {
                    row[place] -= memory.residuals[at] * slope / sd;
                    memory.scale_gradient[place] -= slope / sd;
                }
            }
        }
    }

    /// Noise that the inputs' errors correlate: `r = L^-1 d` with `L L' = diag(sd^2) + F S F'`. For a standard
    /// deviation `s` of one sensor, `a = L^-1 e`: `dL = L Phi(2 s a a')`, `Phi` the lower triangle with half its
    /// diagonal, so that `dr = -Phi(2 s a a') r` and `d ln det L = s a' a`.
    fn decorrelate(
        &self,
        phase: &Phase,
        covariance: &[f64],
        unknowns: &[f64],
        memory: &mut Memory,
        slopes: bool,
    ) -> Result<(), Rejected> {
        let (k, n, first) = (phase.readings.len(), unknowns.len(), phase.first);
        let split = memory.factor.len() - k;
        let (factor, column) = memory.factor.split_at_mut(split);
        let factor = &mut factor[..k * k];
        factor.copy_from_slice(covariance);
        for (position, &(sensor, _)) in phase.readings.iter().enumerate() {
            let sd = self.sensors[sensor].noise.total(unknowns);
            factor[position * k + position] += sd * sd;
        }
        cholesky::factor(factor, k).map_err(|_| Rejected::new("the covariance of a phase is not positive definite"))?;
        let residuals = &mut memory.residuals[first..first + k];
        cholesky::solve_lower(factor, residuals);
        for position in 0..k {
            memory.log_scales[first + position] = -ln(factor[position * k + position]);
        }
        if !slopes {
            return Ok(());
        }
        for place in 0..n {
            for position in 0..k {
                column[position] = memory.jacobian[(first + position) * n + place];
            }
            cholesky::solve_lower(factor, column);
            for position in 0..k {
                memory.jacobian[(first + position) * n + place] = column[position];
            }
        }
        for (position, &(sensor, _)) in phase.readings.iter().enumerate() {
            let noise = &self.sensors[sensor].noise;
            for (place, slope) in noise.total_slopes(unknowns).into_iter().flatten() {
                let weight = 2.0 * noise.total(unknowns) * slope;
                column.fill(0.0);
                column[position] = 1.0;
                cholesky::solve_lower(factor, column);
                let mut before = 0.0;
                for row in 0..k {
                    let own = column[row] * residuals[row];
                    memory.jacobian[(first + row) * n + place] -= weight * column[row] * (before + 0.5 * own);
                    memory.scale_gradient[place] -= 0.5 * weight * column[row] * column[row];
                    before += own;
                }
            }
        }
        Ok(())
    }
}

/// `L` with `L L' = diag(sd^2) + F S F'`.
fn factor(covariance: &[f64], sd: &[f64]) -> Result<Vec<f64>, Rejected> {
    let size = sd.len();
    let mut factor = covariance.to_vec();
    for (position, sd) in sd.iter().enumerate() {
        factor[position * size + position] += sd * sd;
    }
    cholesky::factor(&mut factor, size)
        .map_err(|_| Rejected::new("the covariance of a phase is not positive definite"))?;
    Ok(factor)
}

impl Reference {
    /// Temperatures to first order at other unknowns.
    fn predict(&self, columns: &[usize], unknowns: &[f64], start: &mut [f64]) {
        let count = columns.len();
        for (node, (value, &reference)) in start.iter_mut().zip(&self.temperatures).enumerate() {
            let mut shift = 0.0;
            for (column, &place) in columns.iter().enumerate() {
                shift += self.tangent[node * count + column] * (unknowns[place] - self.at[column]);
            }
            let reach = REACH * reference;
            *value = reference + shift.clamp(-reach, reach);
        }
    }
}
