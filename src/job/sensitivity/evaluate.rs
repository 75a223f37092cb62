//! The model at many points side by side.

use super::Sensitivity;
use crate::thermal::{LANES, SampleBatch, Start};

/// Values above this would overflow when squared and summed.
const LARGEST: f64 = 1e140;

/// A number a lane.
pub type Lanes = [f64; LANES];

/// The model in one environment, a point a lane.
pub struct Evaluator<'j> {
    job: &'j Sensitivity,
    case: usize,
    batch: SampleBatch,
}

impl<'j> Evaluator<'j> {
    /// Every lane at the nominal parameters.
    pub fn new(job: &'j Sensitivity, case: usize) -> Self {
        let mut batch: SampleBatch = job.network.sample_batch();
        for lane in 0..LANES {
            batch.set_parameters(&job.network, lane, &job.nominal);
            batch.set_inputs(&job.network, lane, &job.spec.environments[case].inputs);
        }
        Self { job, case, batch }
    }

    /// Says how many lanes are read, so that a model that is asked outside is not asked for others.
    pub fn use_lanes(&mut self, lanes: usize) {
        if self.job.network.external().is_some() {
            self.batch.use_lanes(lanes);
        }
    }

    /// Sets an uncertain parameter in every lane, SI.
    pub fn set(&mut self, coordinate: usize, values: Lanes) {
        self.batch.set_parameter_lanes(self.job.uncertain[coordinate], values);
    }

    /// Solves every lane from the nominal solution, or from the temperatures that are kept; so a lane's result depends
    /// on its own points alone.
    pub fn solve(&mut self, from: Option<&[Lanes]>) {
        match from {
            Some(temperatures) => {
                self.batch.set_all_temperatures(temperatures);
                self.job.network.solve_samples(&mut self.batch, Start::Current);
            }
            None => {
                let start = Start::Temperatures(&self.job.starts[self.case]);
                self.job.network.solve_samples(&mut self.batch, start);
            }
        }
    }

    /// Temperatures of the last solve.
    pub fn temperatures(&self) -> &[Lanes] {
        self.batch.temperatures()
    }

    /// A quantity (by its position in the settings) of the last solve in every lane; NaN where it failed.
    pub fn quantity(&self, position: usize) -> Lanes {
        let index = self.job.spec.quantities[position];
        std::array::from_fn(|lane| {
            let value = self.batch.quantity(&self.job.network, lane, index);
            if value.abs() <= LARGEST { value } else { f64::NAN }
        })
    }

    /// Why the last solve of a lane failed.
    pub fn fault(&self, lane: usize) -> String {
        match self.batch.outcome(lane) {
            Err(error) => error.to_string(),
            Ok(_) => {
                let bad = self.job.spec.quantities.iter().find_map(|&index| {
                    let value = self.batch.quantity(&self.job.network, lane, index);
                    let name = &self.job.model.quantities[index].name;
                    (!(value.abs() <= LARGEST)).then(|| format!("quantity `{name}` is {value}"))
                });
                bad.unwrap_or_default()
            }
        }
    }
}
