//! Steady phases in the likelihood.

use super::build::is_used;
use super::input_error::InputErrors;
use super::whitening::Block;
use super::{Datum, Likelihood, LikelihoodError, Memory, SensorPart, SteadyState, Wanted};
use crate::inference::target::Rejected;
use crate::math::cholesky;
use crate::math::functions::ln;
use crate::measurement::{Measurement, Rows};
use crate::thermal::{Batch, Network, Start, SteadyError, Workspace};

/// Phases solved side by side; a phase has the same bits in any company.
const LANES: usize = 8;

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

/// Room for phases side by side.
#[derive(Clone, Debug)]
pub(super) struct SteadyLanes {
    batch: Batch<LANES>,
    /// `quantities x symbols`.
    tangent: Vec<[f64; LANES]>,
    /// Of each quantity in the gradient.
    weights: Vec<[f64; LANES]>,
    /// Of each symbol.
    slopes: Vec<[f64; LANES]>,
    /// Standard deviation of each sensor's noise, and its logarithm.
    noise: Vec<(f64, f64)>,
}

impl SteadyLanes {
    pub fn new(network: &Network) -> Self {
        let (quantities, symbols) = (network.quantities(), network.differentiated().len());
        Self {
            batch: network.batch(),
            tangent: vec![[0.0; LANES]; quantities * symbols],
            weights: vec![[0.0; LANES]; quantities],
            slopes: vec![[0.0; LANES]; symbols],
            noise: Vec::new(),
        }
    }
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

    /// Adds the inputs' known errors at these parameters.
    pub fn set_input_errors(&mut self, errors: &InputErrors, parameters: &[f64]) -> Result<(), LikelihoodError> {
        let mut workspace = errors.workspace(parameters);
        for phase in &mut self.phases {
            let sensors: Vec<SensorPart> =
                phase.readings.iter().map(|&(sensor, _)| self.sensors[sensor].clone()).collect();
            let Some(covariance) = errors.covariance(&mut workspace, &phase.inputs, &sensors) else {
                let (measurement, phase) = (self.name.clone(), phase.name.clone());
                return Err(LikelihoodError::Covariance { measurement, phase });
            };
            phase.covariance = Some(covariance);
        }
        Ok(())
    }

    /// Appends the state of each phase; the workspace has the parameters.
    pub fn states(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        workspace: &mut Workspace,
        memory: &mut Memory,
        states: &mut Vec<SteadyState>,
    ) -> Result<(), Rejected> {
        let network = &likelihood.network;
        for phase in &self.phases {
            self.solve_one(phase, likelihood, unknowns, workspace, memory)?;
            let quantities: Vec<usize> =
                phase.readings.iter().map(|&(sensor, _)| self.sensors[sensor].quantity).collect();
            let mut adjoint = vec![0.0; quantities.len() * network.nodes()];
            network
                .quantity_adjoint(workspace, &quantities, &mut adjoint)
                .map_err(|_| Rejected::new("derivatives of a steady state are not there"))?;
            states.push(SteadyState {
                first: phase.first,
                inputs: memory.inputs.clone(),
                temperatures: workspace.temperatures().to_vec(),
                adjoint,
            });
        }
        Ok(())
    }

    /// Solves a phase by itself.
    fn solve_one(
        &self,
        phase: &Phase,
        likelihood: &Likelihood,
        unknowns: &[f64],
        workspace: &mut Workspace,
        memory: &mut Memory,
    ) -> Result<(), Rejected> {
        let network = &likelihood.network;
        memory.inputs.copy_from_slice(&phase.inputs);
        for &(input, place) in &likelihood.biases {
            memory.inputs[input] += unknowns[place];
        }
        network.set_inputs(workspace, &memory.inputs);
        let start = match &phase.reference {
            Some(reference) => {
                reference.predict(&likelihood.columns, unknowns, &mut memory.start);
                Start::Temperatures(&memory.start)
            }
            None => Start::Default,
        };
        match network.solve_steady(workspace, start) {
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
        if network.external().is_some() {
            // There are no temperatures to start from.
            return;
        }
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

    /// Solves the phases, [`LANES`] of them side by side, and fills in their residuals and scales, with derivatives
    /// where wanted.
    pub fn evaluate(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        memory: &mut Memory,
        wanted: &mut Wanted<'_>,
    ) -> Result<(), Rejected> {
        let network = &likelihood.network;
        let Some(mut lanes) = memory.lanes.take() else { return Ok(()) };
        for lane in 0..LANES {
            lanes.batch.set_parameters(network, lane, &memory.parameters);
        }
        lanes.noise.clear();
        lanes.noise.extend(self.sensors.iter().map(|sensor| {
            let sd = sensor.noise.total(unknowns);
            (sd, ln(sd))
        }));
        let done = self.phases.chunks(LANES).try_for_each(|phases| {
            self.solve(likelihood, phases, unknowns, memory, &mut lanes)?;
            if let Wanted::Jacobian = wanted {
                network.quantity_tangent_batch(&mut lanes.batch, &mut lanes.tangent);
            }
            lanes.weights.fill([0.0; LANES]);
            for (lane, phase) in phases.iter().enumerate() {
                self.differences(likelihood, phase, unknowns, memory, &lanes, lane, wanted);
                match &phase.covariance {
                    None => self.scale(phase, unknowns, memory, &lanes.noise, wanted),
                    Some(covariance) => self.decorrelate(phase, covariance, unknowns, memory, wanted)?,
                }
                if let Wanted::Gradient(gradient) = wanted {
                    self.add_gradient_weights(phase, memory, &mut lanes, lane, gradient);
                }
            }
            if let Wanted::Gradient(gradient) = wanted {
                network.quantity_gradient_batch(&mut lanes.batch, &lanes.weights, &mut lanes.slopes);
                for (&place, slopes) in likelihood.columns.iter().zip(&lanes.slopes) {
                    for slope in &slopes[..phases.len()] {
                        gradient[place] += slope;
                    }
                }
            }
            Ok(())
        });
        memory.lanes = Some(lanes);
        done
    }

    /// Solves phases side by side.
    fn solve(
        &self,
        likelihood: &Likelihood,
        phases: &[Phase],
        unknowns: &[f64],
        memory: &mut Memory,
        lanes: &mut SteadyLanes,
    ) -> Result<(), Rejected> {
        lanes.batch.use_lanes(phases.len());
        for lane in 0..LANES {
            // What is left over does the last phase's work again.
            let Some(phase) = phases.get(lane).or(phases.last()) else { continue };
            memory.inputs.copy_from_slice(&phase.inputs);
            for &(input, place) in &likelihood.biases {
                memory.inputs[input] += unknowns[place];
            }
            lanes.batch.set_inputs(&likelihood.network, lane, &memory.inputs);
            match &phase.reference {
                Some(reference) => reference.predict(&likelihood.columns, unknowns, &mut memory.start),
                // The solver replaces what is no temperature by its own default.
                None => memory.start.fill(f64::NAN),
            }
            lanes.batch.set_temperatures(lane, &memory.start);
        }
        likelihood.network.solve_steady_batch(&mut lanes.batch, Start::Current);
        for (lane, phase) in phases.iter().enumerate() {
            if let Err(error) = lanes.batch.outcome(lane) {
                return Err(self.rejected(phase, error));
            }
        }
        Ok(())
    }

    fn rejected(&self, phase: &Phase, error: &SteadyError) -> Rejected {
        let why = match error {
            SteadyError::External(fault) => {
                return Rejected::new(format!("phase `{}` of `{}`: {}", phase.name, self.name, fault.what));
            }
            SteadyError::Isolated { .. } => "has nodes without a path to a boundary",
            SteadyError::NotConverged { .. } => "was not found",
            SteadyError::NotFinite { .. } => "has a heat that is not a finite number",
            SteadyError::Singular { .. } => "is not determined by the balances",
            SteadyError::Boundary { .. } => "has a boundary below 0 K",
            SteadyError::Band { .. } => "has a heater whose band is not above 0",
            SteadyError::Sign { above_zero: true, .. } => "has a conductance, resistance or number that is not above 0",
            SteadyError::Sign { .. } => "has a conductance, exchange area or resistance below 0",
        };
        Rejected::new(format!("the steady state of phase `{}` of `{}` {why}", phase.name, self.name))
    }

    /// Reading minus prediction, and its derivatives.
    #[allow(clippy::too_many_arguments)]
    fn differences(
        &self,
        likelihood: &Likelihood,
        phase: &Phase,
        unknowns: &[f64],
        memory: &mut Memory,
        lanes: &SteadyLanes,
        lane: usize,
        wanted: &Wanted<'_>,
    ) {
        let (n, columns) = (unknowns.len(), likelihood.columns.len());
        for (position, &(sensor, reading)) in phase.readings.iter().enumerate() {
            let sensor = &self.sensors[sensor];
            let at = phase.first + position;
            let predicted = lanes.batch.quantity(&likelihood.network, lane, sensor.quantity);
            let bias = sensor.bias.map_or(0.0, |bias| bias.at(unknowns));
            memory.residuals[at] = reading - predicted - bias;
            if let Wanted::Jacobian = wanted {
                let row = &mut memory.jacobian[at * n..(at + 1) * n];
                let tangent = &lanes.tangent[sensor.quantity * columns..(sensor.quantity + 1) * columns];
                for (&place, slope) in likelihood.columns.iter().zip(tangent) {
                    row[place] = -slope[lane];
                }
                if let Some(place) = sensor.bias.and_then(|bias| bias.place()) {
                    row[place] -= 1.0;
                }
            }
        }
    }

    /// Adds the weights of the readings in the gradient, `w = W' r` of the whitening `W`: the gradient is `sum w d(f + bias)`.
    fn add_gradient_weights(
        &self,
        phase: &Phase,
        memory: &mut Memory,
        lanes: &mut SteadyLanes,
        lane: usize,
        gradient: &mut [f64],
    ) {
        let k = phase.readings.len();
        let residuals = &memory.residuals[phase.first..phase.first + k];
        let split = memory.factor.len() - k;
        let (factor, weights) = memory.factor.split_at_mut(split);
        weights.copy_from_slice(residuals);
        if phase.covariance.is_some() {
            cholesky::solve_lower_transposed(&factor[..k * k], weights);
        } else {
            for (weight, &(sensor, _)) in weights.iter_mut().zip(&phase.readings) {
                *weight /= lanes.noise[sensor].0;
            }
        }
        for (weight, &(sensor, _)) in weights.iter().zip(&phase.readings) {
            let sensor = &self.sensors[sensor];
            lanes.weights[sensor.quantity][lane] += weight;
            if let Some(place) = sensor.bias.and_then(|bias| bias.place()) {
                gradient[place] += weight;
            }
        }
    }

    /// Independent noise: divides by each sensor's standard deviation.
    fn scale(
        &self,
        phase: &Phase,
        unknowns: &[f64],
        memory: &mut Memory,
        deviations: &[(f64, f64)],
        wanted: &mut Wanted<'_>,
    ) {
        let n = unknowns.len();
        for (position, &(sensor, _)) in phase.readings.iter().enumerate() {
            let noise = &self.sensors[sensor].noise;
            let at = phase.first + position;
            let (sd, log_sd) = deviations[sensor];
            memory.residuals[at] /= sd;
            memory.log_scales[at] = -log_sd;
            let residual = memory.residuals[at];
            match wanted {
                Wanted::Values => {}
                Wanted::Jacobian => {
                    let row = &mut memory.jacobian[at * n..(at + 1) * n];
                    for value in row.iter_mut() {
                        *value /= sd;
                    }
                    for (place, slope) in noise.total_slopes(unknowns).into_iter().flatten() {
                        row[place] -= residual * slope / sd;
                        memory.scale_gradient[place] -= slope / sd;
                    }
                }
                Wanted::Gradient(gradient) => {
                    for (place, slope) in noise.total_slopes(unknowns).into_iter().flatten() {
                        gradient[place] += (residual * residual - 1.0) * slope / sd;
                    }
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
        wanted: &mut Wanted<'_>,
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
        match wanted {
            Wanted::Values => return Ok(()),
            Wanted::Gradient(_) => {}
            Wanted::Jacobian => {
                for place in 0..n {
                    for position in 0..k {
                        column[position] = memory.jacobian[(first + position) * n + place];
                    }
                    cholesky::solve_lower(factor, column);
                    for position in 0..k {
                        memory.jacobian[(first + position) * n + place] = column[position];
                    }
                }
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
                    let contribution = column[row] * residuals[row];
                    let slope = -weight * column[row] * (before + 0.5 * contribution);
                    let scale_slope = -0.5 * weight * column[row] * column[row];
                    if let Wanted::Gradient(gradient) = wanted {
                        gradient[place] += scale_slope - residuals[row] * slope;
                    } else {
                        memory.jacobian[(first + row) * n + place] += slope;
                        memory.scale_gradient[place] += scale_slope;
                    }
                    before += contribution;
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
