//! A surrogate of a model that takes long to answer: a Gaussian process for each output, over the parameters and inputs that
//! vary, through runs of the model itself (Sacks, Welch, Mitchell & Wynn 1989, Statist. Sci. 4, 409).
//!
//! `space`: the coordinates. `emulation`: the process of an output, and how well it predicts runs left out. `answers`: the
//! surrogate in the model's place. `choice`: where further runs tell most.

pub mod answers;
pub mod choice;
pub mod emulation;
pub mod space;

use serde::{Deserialize, Serialize};

use super::gaussian_process::GaussianProcessError;
use super::gaussian_process::emulator::{Emulator, Predicted, PredictedSlopes, most_telling};
use crate::random::StreamKey;
use crate::thermal::{Fault, Point};
pub use answers::Answers;
pub use emulation::{Emulation, LeftOutError};
pub use space::{Axis, Space};

/// A run of the model itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The model's own parameters, SI.
    pub parameters: Vec<f64>,
    /// Its inputs, SI.
    pub inputs: Vec<f64>,
    /// Its outputs, SI.
    pub outputs: Vec<f64>,
}

/// What is expected of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Mean, SI.
    pub mean: f64,
    /// Standard deviation of the surrogate's error, SI.
    pub sd: f64,
}

/// A surrogate that can be asked.
#[derive(Clone, Debug)]
pub struct Surrogate {
    space: Space,
    outputs: Vec<Emulated>,
}

/// The process of an output.
#[derive(Clone, Debug)]
enum Emulated {
    /// All runs gave this value.
    Constant(f64),
    /// A process, over so many coordinates.
    Process(Box<Emulator>),
}

impl Emulated {
    fn predicted(&self, coordinates: &[Vec<f64>]) -> Vec<Predicted> {
        match self {
            Self::Constant(value) => vec![Predicted { mean: *value, parts: Vec::new(), rest: 0.0 }; coordinates.len()],
            Self::Process(emulator) => emulator.at(coordinates),
        }
    }
}

impl Surrogate {
    /// Fits a process to each output of the runs; `key` gives the starts of the searches.
    ///
    /// # Errors
    /// Too few runs, or runs that tell no process apart.
    pub fn fit(space: &Space, runs: &[Run], key: &StreamKey) -> Result<Vec<Emulation>, GaussianProcessError> {
        let points: Vec<f64> = runs.iter().flat_map(|run| space.of_run(run)).collect();
        let outputs = runs.first().map_or(0, |run| run.outputs.len());
        (0..outputs)
            .map(|output| {
                let values = runs.iter().map(|run| run.outputs.get(output).copied().unwrap_or(f64::NAN)).collect();
                Emulation::fit(space.axes.len(), &points, values, key)
            })
            .collect()
    }

    /// From runs and what was fitted to them.
    ///
    /// # Errors
    /// Runs and fits that do not belong together.
    pub fn new(space: Space, runs: &[Run], emulations: &[Emulation]) -> Result<Self, GaussianProcessError> {
        let points: Vec<f64> = runs.iter().flat_map(|run| space.of_run(run)).collect();
        let emulated = |(output, emulation): (usize, &Emulation)| {
            let values: Vec<f64> =
                runs.iter().map(|run| run.outputs.get(output).copied().unwrap_or(f64::NAN)).collect();
            Ok(match emulation.process(space.axes.len(), &points, &values)? {
                None => Emulated::Constant(values.first().copied().unwrap_or(f64::NAN)),
                Some(process) => {
                    Emulated::Process(Box::new(Emulator::new(process, emulation.factor, &emulation.anchors)))
                }
            })
        };
        let outputs = emulations.iter().enumerate().map(emulated).collect::<Result<_, _>>()?;
        Ok(Self { space, outputs })
    }

    /// What is expected of each output at coordinates.
    pub fn at(&self, coordinates: &[f64]) -> Vec<Expected> {
        let expected = |emulated: &Emulated| match emulated {
            Emulated::Constant(value) => Expected { mean: *value, sd: 0.0 },
            Emulated::Process(emulator) => {
                let expected = emulator.process().at(coordinates);
                Expected { mean: expected.mean, sd: emulator.factor() * expected.sd() }
            }
        };
        self.outputs.iter().map(expected).collect()
    }

    /// What is expected of each output at points, and what its error is made of: by output, then by point.
    pub fn predicted(&self, coordinates: &[Vec<f64>]) -> Vec<Vec<Predicted>> {
        self.outputs.iter().map(|emulated| emulated.predicted(coordinates)).collect()
    }

    /// Slopes of that at a point, by output; nothing of a constant.
    pub fn slopes(&self, coordinates: &[f64]) -> Vec<Option<PredictedSlopes>> {
        let of = |emulated: &Emulated| match emulated {
            Emulated::Constant(_) => None,
            Emulated::Process(emulator) => Some(emulator.slopes(coordinates)),
        };
        self.outputs.iter().map(of).collect()
    }

    /// At most so many of some points, for each output those at which its error tells most of its errors at all of them.
    pub fn anchors(&self, coordinates: &[Vec<f64>], count: usize) -> Vec<Vec<Vec<f64>>> {
        let of = |output: usize| {
            let chosen = most_telling(&self.covariance(output, coordinates), coordinates.len(), count);
            chosen.into_iter().map(|place| coordinates[place].clone()).collect()
        };
        (0..self.outputs.len()).map(of).collect()
    }

    /// Covariance (row after row) of the errors of an output at several coordinates; 0 throughout for a constant.
    pub fn covariance(&self, output: usize, coordinates: &[Vec<f64>]) -> Vec<f64> {
        match self.outputs.get(output) {
            Some(Emulated::Process(emulator)) => {
                let factor = emulator.factor();
                let (_, mut covariance) = emulator.process().together(coordinates);
                covariance.iter_mut().for_each(|value| *value *= factor * factor);
                covariance
            }
            Some(Emulated::Constant(_)) | None => vec![0.0; coordinates.len() * coordinates.len()],
        }
    }

    /// Coordinates of a point.
    ///
    /// # Errors
    /// A point where no run says anything.
    pub fn coordinates(&self, point: &Point) -> Result<Vec<f64>, Fault> {
        self.space.coordinates(point)
    }
}
