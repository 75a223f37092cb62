//! What is unknown, and the random numbers of a design: the same for every candidate.

use super::output::Spec;
use crate::job::JobError;
use crate::math::special::normal_quantile;
use crate::measurement::unknown::sensor_name;
use crate::random::{Distribution, PointKind, Points, StreamKey};
use crate::thermal::Model;

/// Independent scrambles of the points; their scatter gives the standard error.
pub(super) const REPLICATES: usize = 16;

/// What an unknown is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A parameter of the model.
    Parameter(usize),
    /// The constant error of a sensor.
    Bias(usize),
    /// The constant error of an input.
    Input(usize),
}

/// An unknown.
#[derive(Clone, Debug)]
pub(super) struct Unknown {
    pub name: String,
    pub prior: Distribution,
    pub kind: Kind,
}

/// The unknowns of a design: those to learn first, then nuisance parameters, then errors of sensors, then of inputs.
pub(super) fn unknowns(spec: &Spec, model: &Model, priors: &[Distribution]) -> Vec<Unknown> {
    let parameters = spec.learn.iter().chain(&spec.nuisance).map(|&index| Unknown {
        name: model.parameters[index].name.clone(),
        prior: priors[index],
        kind: Kind::Parameter(index),
    });
    let biases = spec.sensors.iter().enumerate().filter_map(|(place, sensor)| {
        let prior = sensor.bias.filter(|prior| !prior.is_fixed())?;
        Some(Unknown { name: sensor_name("experiment", &sensor.name, "bias"), prior, kind: Kind::Bias(place) })
    });
    let inputs = spec.input_errors.iter().filter_map(|input_error| {
        let prior = input_error.bias.filter(|prior| !prior.is_fixed())?;
        let name = format!("{}.bias", model.inputs[input_error.input].name);
        Some(Unknown { name, prior, kind: Kind::Input(input_error.input) })
    });
    parameters.chain(biases).chain(inputs).collect()
}

/// The point sets of a design.
#[derive(Debug)]
pub(super) struct Samples {
    /// Number of unknowns.
    pub unknowns: usize,
    /// Outer samples of a replicate.
    pub size: usize,
    outer: Vec<Points>,
    draws: Vec<Points>,
}

impl Samples {
    /// Lays out the points: unknowns, then a noise for every reading of every phase.
    pub fn new(spec: &Spec, unknowns: usize, seed: u64, name: &str) -> Result<Self, JobError> {
        let count = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
        let size = count(spec.outer) / REPLICATES;
        let dimensions = unknowns + spec.sensors.len() * count(spec.pick);
        let points = |purpose: String, samples: usize, dimensions: usize| {
            Points::new(PointKind::Sobol, StreamKey::new(seed, name, &purpose), samples, dimensions)
                .map_err(|e| JobError::Failed(e.to_string()))
        };
        let outer = (0..REPLICATES).map(|r| points(format!("design {r}"), size, dimensions));
        let draws = (0..REPLICATES).map(|r| points(format!("design draws {r}"), size * count(spec.draws), unknowns));
        Ok(Self { unknowns, size, outer: outer.collect::<Result<_, _>>()?, draws: draws.collect::<Result<_, _>>()? })
    }

    /// Coordinates of a replicate's outer samples in the unit cube, `samples x dimensions`.
    pub fn outer(&self, replicate: usize) -> (Vec<f64>, usize) {
        let points = &self.outer[replicate];
        let mut rows = vec![0.0; self.size * points.dimensions()];
        points.fill_rows(0, &mut rows);
        (rows, points.dimensions())
    }

    /// Standard normal numbers for the draws that belong to an outer sample, `draws x unknowns`.
    pub fn draws(&self, replicate: usize, sample: usize, rows: &mut [f64]) {
        let count = rows.len() / self.unknowns;
        self.draws[replicate].fill_rows(sample * count, rows);
        for value in rows {
            *value = normal_quantile(*value);
        }
    }
}
