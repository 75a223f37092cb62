//! The model of a design: readings and their derivatives at samples of the unknowns.

use serde::{Deserialize, Serialize};

use super::output::{DesignSensor, Phase, Spec};
use super::samples::{Kind, Unknown};
use crate::expression::Symbol;
use crate::inference::information::coordinates;
use crate::inference::likelihood::covariance_by_inputs;
use crate::job::JobError;
use crate::math::cholesky;
use crate::random::Distribution;
use crate::thermal::{External, LANES, Model, Network, SampleBatch, Start, Workspace};

/// Networks with the sensors' quantities alone.
#[derive(Debug)]
pub(super) struct ForwardModel {
    plain: Network,
    tangent: Network,
    /// Parameters where nothing is unknown.
    base: Vec<f64>,
    unknowns: Vec<Unknown>,
    /// Quantity of each sensor in the networks.
    quantities: Vec<usize>,
    /// Unknown of each differentiated symbol.
    columns: Vec<usize>,
    /// Red and yellow limits by node.
    limits: Vec<[Option<[f64; 2]>; 2]>,
    /// Derivatives by the inputs that err from phase to phase, with the standard deviations of these; none without any.
    noisy: Option<(Network, Vec<f64>)>,
}

/// A phase, ready to be solved.
#[derive(Clone, Debug)]
pub(super) struct Place {
    inputs: Vec<f64>,
    /// Where its solves start; `None` where its nominal state has no solution, or is asked outside.
    start: Option<Vec<f64>>,
    /// Covariance of the readings by the errors of the inputs, `F S F'`; empty without any.
    covariance: Vec<f64>,
}

impl Place {
    fn start(&self) -> Start<'_> {
        self.start.as_deref().map_or(Start::Default, Start::Temperatures)
    }
}

/// What makes the noise of a phase's readings independent with unit variance.
#[derive(Clone, Debug)]
pub(super) struct Whitening {
    sigmas: Vec<f64>,
    /// Factor of `diag(sigma^2) + F S F'`; empty where the noise is independent.
    factor: Vec<f64>,
}

impl Whitening {
    /// Of the sensors that are read.
    pub fn new(place: &Place, sensors: &[DesignSensor], read: &[usize]) -> Self {
        let sigmas: Vec<f64> = read.iter().map(|&sensor| sensors[sensor].sigma).collect();
        let n = read.len();
        let mut factor = Vec::new();
        if !place.covariance.is_empty() {
            for (a, &row) in read.iter().enumerate() {
                for (b, &column) in read.iter().enumerate() {
                    let noise_variance = if a == b { sigmas[a] * sigmas[a] } else { 0.0 };
                    factor.push(place.covariance[row * sensors.len() + column] + noise_variance);
                }
            }
            // Finite derivatives leave it positive definite; others are caught where they arise.
            if cholesky::factor(&mut factor, n).is_err() {
                factor.clear();
            }
        }
        Self { sigmas, factor }
    }

    /// Turns readings (SI) of the sensors that are read, or their differences, into whitened ones.
    pub fn apply(&self, values: &mut [f64]) {
        if self.factor.is_empty() {
            values.iter_mut().zip(&self.sigmas).for_each(|(value, sigma)| *value /= sigma);
        } else {
            cholesky::solve_lower(&self.factor, values);
        }
    }
}

/// Room of one block.
#[derive(Debug)]
pub(super) struct Room {
    batch: SampleBatch,
    workspace: Workspace,
    parameters: Vec<f64>,
    slopes: Vec<f64>,
    /// Model solutions so far.
    pub solutions: u64,
}

/// How often limits were left.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Outside {
    pub failed: u64,
    pub outside: [u64; 2],
    pub nodes: Vec<u64>,
}

impl ForwardModel {
    pub fn new(spec: &Spec, model: &Model, priors: &[Distribution], unknowns: Vec<Unknown>) -> Result<Self, JobError> {
        let mut quantities: Vec<usize> = Vec::new();
        let mut of_sensor = Vec::new();
        for sensor in &spec.sensors {
            let place = quantities.iter().position(|chosen_quantity| *chosen_quantity == sensor.quantity);
            of_sensor.push(place.unwrap_or(quantities.len()));
            if place.is_none() {
                quantities.push(sensor.quantity);
            }
        }
        let model =
            Model { quantities: quantities.iter().map(|&q| model.quantities[q].clone()).collect(), ..model.clone() };
        let (mut symbols, mut columns) = (Vec::new(), Vec::new());
        for (place, unknown) in unknowns.iter().enumerate() {
            match unknown.kind {
                Kind::Parameter(index) => symbols.push(Symbol::Parameter(u32::try_from(index).unwrap_or(u32::MAX))),
                Kind::Input(index) => symbols.push(Symbol::Input(u32::try_from(index).unwrap_or(u32::MAX))),
                Kind::Bias(_) => continue,
            }
            columns.push(place);
        }
        let failed = |e: crate::thermal::NetworkError| JobError::Failed(e.to_string());
        let plain = Network::compile(&model, &[]).map_err(failed)?;
        let tangent = Network::compile(&model, &symbols).map_err(failed)?;
        let base = model.parameters.iter().zip(priors).map(|(parameter, prior)| match prior {
            Distribution::Fixed(value) => *value,
            _ => parameter.nominal,
        });
        let noisy: Vec<(usize, f64)> = spec
            .input_errors
            .iter()
            .filter_map(|input_error| Some((input_error.input, input_error.sigma.filter(|s| *s > 0.0)?)))
            .collect();
        let noisy = if noisy.is_empty() {
            None
        } else {
            let symbol = |&(input, _): &(usize, f64)| Symbol::Input(u32::try_from(input).unwrap_or(u32::MAX));
            let symbols: Vec<Symbol> = noisy.iter().map(symbol).collect();
            let network = Network::compile(&model, &symbols).map_err(failed)?;
            Some((network, noisy.iter().map(|(_, sigma)| *sigma).collect()))
        };
        Ok(Self {
            base: base.collect(),
            limits: model.nodes.iter().map(|node| [node.limits.red, node.limits.yellow]).collect(),
            quantities: of_sensor,
            plain,
            tangent,
            unknowns,
            columns,
            noisy,
        })
    }

    /// What is asked outside, where that answers for the model.
    pub fn external(&self) -> Option<&External> {
        self.plain.external()
    }

    /// Solves a phase at nominal parameters.
    pub fn place(&self, phase: &Phase) -> Place {
        if self.external().is_some() && self.noisy.is_none() {
            // What is asked outside starts nowhere, and takes its time.
            return Place { inputs: phase.inputs.clone(), start: None, covariance: Vec::new() };
        }
        let mut workspace = self.plain.workspace();
        self.plain.set_parameters(&mut workspace, &self.base);
        self.plain.set_inputs(&mut workspace, &phase.inputs);
        let solved = self.plain.solve_steady(&mut workspace, Start::Default).is_ok();
        let start = solved.then(|| workspace.temperatures().to_vec());
        let covariance = if solved { self.covariance(phase).unwrap_or_default() } else { Vec::new() };
        Place { inputs: phase.inputs.clone(), start, covariance }
    }

    /// `F S F'` of the sensors by the inputs that err, at nominal parameters, as in a calibration.
    fn covariance(&self, phase: &Phase) -> Option<Vec<f64>> {
        let (network, sigmas) = self.noisy.as_ref()?;
        let mut workspace = network.workspace();
        network.set_parameters(&mut workspace, &self.base);
        network.set_inputs(&mut workspace, &phase.inputs);
        network.solve_steady(&mut workspace, Start::Default).ok()?;
        let mut slopes = vec![0.0; network.quantities() * sigmas.len()];
        network.quantity_tangent(&mut workspace, &mut slopes).ok()?;
        let covariance = covariance_by_inputs(&slopes, sigmas, &self.quantities);
        covariance.iter().all(|value| value.is_finite()).then_some(covariance)
    }

    pub fn unknowns(&self) -> &[Unknown] {
        &self.unknowns
    }

    pub fn sensors(&self) -> usize {
        self.quantities.len()
    }

    /// Whether any node has red, and any yellow limits.
    pub fn has_limits(&self) -> [bool; 2] {
        [0, 1].map(|colour| self.limits.iter().any(|limits| limits[colour].is_some()))
    }

    pub fn room(&self) -> Room {
        let mut batch = self.plain.sample_batch();
        for lane in 0..LANES {
            batch.set_parameters(&self.plain, lane, &self.base);
        }
        let columns = self.columns.len();
        Room {
            batch,
            workspace: self.tangent.workspace(),
            parameters: self.base.clone(),
            slopes: vec![0.0; self.tangent.quantities() * columns],
            solutions: 0,
        }
    }

    /// Readings of a phase at `values` (`samples x unknowns`, SI) into `readings` (`samples x sensors`, SI),
    /// which are NaN where there is no solution; `outside` counts limits that were left.
    pub fn readings(
        &self,
        at: &Place,
        values: &[f64],
        room: &mut Room,
        readings: &mut [f64],
        mut outside: Option<&mut Outside>,
    ) {
        let (width, sensors) = (self.unknowns.len(), self.sensors());
        let batch = &mut room.batch;
        for lane in 0..LANES {
            batch.set_inputs(&self.plain, lane, &at.inputs);
        }
        let errs = self.unknowns.iter().any(|unknown| matches!(unknown.kind, Kind::Input(_)));
        let mut inputs = at.inputs.clone();
        for (rows, out) in values.chunks(width * LANES).zip(readings.chunks_mut(sensors * LANES)) {
            let lanes = rows.len() / width;
            for (place, unknown) in self.unknowns.iter().enumerate() {
                if let Kind::Parameter(parameter) = unknown.kind {
                    // Lanes beyond the last sample repeat it and are not read.
                    let lane_values = std::array::from_fn(|lane| rows[lane.min(lanes - 1) * width + place]);
                    batch.set_parameter_lanes(parameter, lane_values);
                }
            }
            if errs {
                for lane in 0..LANES {
                    inputs.copy_from_slice(&at.inputs);
                    self.shift(&rows[lane.min(lanes - 1) * width..], &mut inputs);
                    batch.set_inputs(&self.plain, lane, &inputs);
                }
            }
            if self.external().is_some() {
                batch.use_lanes(lanes);
            }
            self.plain.solve_samples(batch, at.start());
            room.solutions += lanes as u64;
            for lane in 0..lanes {
                let row = &mut out[lane * sensors..(lane + 1) * sensors];
                let mut is_good = batch.outcome(lane).is_ok();
                for (slot, &quantity) in row.iter_mut().zip(&self.quantities) {
                    *slot = if is_good { batch.quantity(&self.plain, lane, quantity) } else { f64::NAN };
                    is_good &= slot.is_finite();
                }
                for (place, unknown) in self.unknowns.iter().enumerate() {
                    if let Kind::Bias(sensor) = unknown.kind {
                        row[sensor] += rows[lane * width + place];
                    }
                }
                if !is_good {
                    row.fill(f64::NAN);
                }
                if let Some(outside) = outside.as_deref_mut() {
                    self.count(batch, lane, is_good, outside);
                }
            }
        }
    }

    /// Adds the constant errors of the inputs among the values of the unknowns.
    fn shift(&self, values: &[f64], inputs: &mut [f64]) {
        for (unknown, value) in self.unknowns.iter().zip(values) {
            if let Kind::Input(index) = unknown.kind {
                inputs[index] += value;
            }
        }
    }

    fn count(&self, batch: &SampleBatch, lane: usize, is_good: bool, outside: &mut Outside) {
        if !is_good {
            outside.failed += 1;
            for (count, has) in outside.outside.iter_mut().zip(self.has_limits()) {
                *count += u64::from(has);
            }
            return;
        }
        let mut any = [false; 2];
        for (node, limits) in self.limits.iter().enumerate() {
            let temperature = batch.temperature(lane, node);
            let mut is_outside = false;
            for (any, range) in any.iter_mut().zip(limits) {
                if let Some([low, high]) = range
                    && !(temperature >= *low && temperature <= *high)
                {
                    *any = true;
                    is_outside = true;
                }
            }
            outside.nodes[node] += u64::from(is_outside);
        }
        for (count, any) in outside.outside.iter_mut().zip(any) {
            *count += u64::from(any);
        }
    }

    /// Values (SI) at standard normal coordinates.
    pub fn values(&self, coordinates: &[f64], values: &mut [f64]) {
        for ((slot, unknown), &u) in values.iter_mut().zip(&self.unknowns).zip(coordinates) {
            *slot = coordinates::value(&unknown.prior, u);
        }
    }

    /// Readings (SI) at coordinates and their derivatives with respect to them (`sensors x unknowns`); false where
    /// there is no solution.
    pub fn linearised(
        &self,
        place: &Place,
        at: &[f64],
        room: &mut Room,
        readings: &mut [f64],
        jacobian: &mut [f64],
    ) -> bool {
        let mut values = vec![0.0; self.unknowns.len()];
        self.values(at, &mut values);
        let scales: Vec<f64> =
            self.unknowns.iter().zip(at).map(|(unknown, &u)| coordinates::slope(&unknown.prior, u)).collect();
        self.tangents(place, &values, &scales, room, readings, jacobian)
    }

    /// The same at nominal parameters, for a change of one prior standard deviation.
    pub fn nominal_changes(&self, at: &Place, room: &mut Room) -> Option<Vec<f64>> {
        let values: Vec<f64> = (self.unknowns.iter())
            .map(|unknown| match unknown.kind {
                Kind::Parameter(index) => self.base[index],
                Kind::Bias(_) | Kind::Input(_) => unknown.prior.quantile(0.5),
            })
            .collect();
        let scales: Vec<f64> = self.unknowns.iter().map(|unknown| unknown.prior.sd()).collect();
        let mut readings = vec![0.0; self.sensors()];
        let mut jacobian = vec![0.0; self.sensors() * self.unknowns.len()];
        self.tangents(at, &values, &scales, room, &mut readings, &mut jacobian).then_some(jacobian)
    }

    fn tangents(
        &self,
        at: &Place,
        values: &[f64],
        scales: &[f64],
        room: &mut Room,
        readings: &mut [f64],
        jacobian: &mut [f64],
    ) -> bool {
        for (unknown, &value) in self.unknowns.iter().zip(values) {
            if let Kind::Parameter(index) = unknown.kind {
                room.parameters[index] = value;
            }
        }
        let network = &self.tangent;
        network.set_parameters(&mut room.workspace, &room.parameters);
        let mut inputs = at.inputs.clone();
        self.shift(values, &mut inputs);
        network.set_inputs(&mut room.workspace, &inputs);
        room.solutions += 1;
        if network.solve_steady(&mut room.workspace, at.start()).is_err()
            || network.quantity_tangent(&mut room.workspace, &mut room.slopes).is_err()
        {
            return false;
        }
        let (width, columns) = (self.unknowns.len(), self.columns.len());
        jacobian.fill(0.0);
        for (sensor, &quantity) in self.quantities.iter().enumerate() {
            readings[sensor] = network.quantity(&room.workspace, quantity);
            for (column, &place) in self.columns.iter().enumerate() {
                jacobian[sensor * width + place] = room.slopes[quantity * columns + column] * scales[place];
            }
        }
        for (place, unknown) in self.unknowns.iter().enumerate() {
            if let Kind::Bias(sensor) = unknown.kind {
                readings[sensor] += values[place];
                jacobian[sensor * width + place] = scales[place];
            }
        }
        readings.iter().chain(jacobian.iter()).all(|value| value.is_finite())
    }
}
