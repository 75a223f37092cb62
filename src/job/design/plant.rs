//! The model of a design: readings and their derivatives at samples of the unknowns.

use super::output::{Phase, Spec};
use super::samples::{Kind, Unknown};
use crate::expression::Symbol;
use crate::inference::information::coordinates;
use crate::job::JobError;
use crate::random::Distribution;
use crate::thermal::{Batch, Model, Network, Start, Workspace};

/// Samples solved side by side; no part of the identity.
const LANES: usize = 16;

/// Networks with the sensors' quantities alone.
#[derive(Debug)]
pub(super) struct Plant {
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
    /// Where solves of a candidate start; `None` where its nominal state has no solution.
    starts: Vec<Option<Vec<f64>>>,
    phases: Vec<Phase>,
}

/// Room of one block.
#[derive(Debug)]
pub(super) struct Room {
    batch: Batch<LANES>,
    workspace: Workspace,
    parameters: Vec<f64>,
    slopes: Vec<f64>,
    /// Model solutions so far.
    pub solutions: u64,
}

/// How often limits were left.
#[derive(Clone, Debug, Default)]
pub(super) struct Outside {
    pub failed: u64,
    pub outside: [u64; 2],
    pub nodes: Vec<u64>,
}

impl Plant {
    pub fn new(spec: &Spec, model: &Model, priors: &[Distribution], unknowns: Vec<Unknown>) -> Result<Self, JobError> {
        let mut quantities: Vec<usize> = Vec::new();
        let mut of_sensor = Vec::new();
        for sensor in &spec.sensors {
            let place = quantities.iter().position(|own| *own == sensor.quantity);
            of_sensor.push(place.unwrap_or(quantities.len()));
            if place.is_none() {
                quantities.push(sensor.quantity);
            }
        }
        let model =
            Model { quantities: quantities.iter().map(|&q| model.quantities[q].clone()).collect(), ..model.clone() };
        let (mut symbols, mut columns) = (Vec::new(), Vec::new());
        for (place, unknown) in unknowns.iter().enumerate() {
            if let Kind::Parameter(index) = unknown.kind {
                symbols.push(Symbol::Parameter(u32::try_from(index).unwrap_or(u32::MAX)));
                columns.push(place);
            }
        }
        let failed = |e: crate::thermal::NetworkError| JobError::Failed(e.to_string());
        let plain = Network::compile(&model, &[]).map_err(failed)?;
        let tangent = Network::compile(&model, &symbols).map_err(failed)?;
        let base = model.parameters.iter().zip(priors).map(|(parameter, prior)| match prior {
            Distribution::Fixed(value) => *value,
            _ => parameter.nominal,
        });
        let mut plant = Self {
            base: base.collect(),
            limits: model.nodes.iter().map(|node| [node.limits.red, node.limits.yellow]).collect(),
            quantities: of_sensor,
            starts: Vec::new(),
            phases: spec.candidates.clone(),
            plain,
            tangent,
            unknowns,
            columns,
        };
        let mut workspace = plant.plain.workspace();
        plant.plain.set_parameters(&mut workspace, &plant.base);
        for phase in &plant.phases {
            plant.plain.set_inputs(&mut workspace, &phase.inputs);
            let solved = plant.plain.solve_steady(&mut workspace, Start::Default).is_ok();
            plant.starts.push(solved.then(|| workspace.temperatures().to_vec()));
        }
        Ok(plant)
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
        let mut batch = self.plain.batch();
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

    fn start(&self, candidate: usize) -> Start<'_> {
        self.starts[candidate].as_deref().map_or(Start::Default, Start::Temperatures)
    }

    /// Readings of a candidate phase at `values` (`samples x unknowns`, SI) into `readings` (`samples x sensors`, SI),
    /// which are NaN where there is no solution; `outside` counts limits that were left.
    pub fn readings(
        &self,
        candidate: usize,
        values: &[f64],
        room: &mut Room,
        readings: &mut [f64],
        mut outside: Option<&mut Outside>,
    ) {
        let (width, sensors) = (self.unknowns.len(), self.sensors());
        let batch = &mut room.batch;
        for lane in 0..LANES {
            batch.set_inputs(&self.plain, lane, &self.phases[candidate].inputs);
        }
        for (rows, out) in values.chunks(width * LANES).zip(readings.chunks_mut(sensors * LANES)) {
            let lanes = rows.len() / width;
            for (place, unknown) in self.unknowns.iter().enumerate() {
                if let Kind::Parameter(parameter) = unknown.kind {
                    // Lanes beyond the last sample repeat it and are not read.
                    let lane_values = std::array::from_fn(|lane| rows[lane.min(lanes - 1) * width + place]);
                    batch.set_parameter_lanes(parameter, lane_values);
                }
            }
            self.plain.solve_steady_batch(batch, self.start(candidate));
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

    fn count(&self, batch: &Batch<LANES>, lane: usize, is_good: bool, outside: &mut Outside) {
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
        candidate: usize,
        at: &[f64],
        room: &mut Room,
        readings: &mut [f64],
        jacobian: &mut [f64],
    ) -> bool {
        let mut values = vec![0.0; self.unknowns.len()];
        self.values(at, &mut values);
        let scales: Vec<f64> =
            self.unknowns.iter().zip(at).map(|(unknown, &u)| coordinates::slope(&unknown.prior, u)).collect();
        self.tangents(candidate, &values, &scales, room, readings, jacobian)
    }

    /// The same at nominal parameters, for a change of one prior standard deviation.
    pub fn nominal_changes(&self, candidate: usize, room: &mut Room) -> Option<Vec<f64>> {
        let values: Vec<f64> = (self.unknowns.iter())
            .map(|unknown| match unknown.kind {
                Kind::Parameter(index) => self.base[index],
                Kind::Bias(_) => unknown.prior.quantile(0.5),
            })
            .collect();
        let scales: Vec<f64> = self.unknowns.iter().map(|unknown| unknown.prior.sd()).collect();
        let mut readings = vec![0.0; self.sensors()];
        let mut jacobian = vec![0.0; self.sensors() * self.unknowns.len()];
        self.tangents(candidate, &values, &scales, room, &mut readings, &mut jacobian).then_some(jacobian)
    }

    fn tangents(
        &self,
        candidate: usize,
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
        network.set_inputs(&mut room.workspace, &self.phases[candidate].inputs);
        room.solutions += 1;
        if network.solve_steady(&mut room.workspace, self.start(candidate)).is_err()
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
