//! A sensor's discrepancy at new inputs, from its stored result.

use super::output::{Output, SensorDiscrepancy};
use crate::inference::gaussian_process::process::Process;
use crate::inference::gaussian_process::tested_range::{Outside, TestedRange};
use crate::inference::gaussian_process::{GaussianProcessError, Training};
use crate::math::sort::sort_by;

/// A sensor's discrepancy, ready to be asked.
#[derive(Clone, Debug)]
pub struct Rebuilt {
    /// One for each draw of the hyperparameters.
    processes: Vec<Process>,
    /// Slopes of the residuals behind it with the unknowns.
    slopes: Vec<Vec<f64>>,
    /// Its inputs, with what was tested of them.
    ranges: Vec<TestedRange>,
}

/// What is expected in a case, as a function of the unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// For each draw of the hyperparameters: mean at the posterior mean, slopes with the unknowns, standard deviation.
    pub draws: Vec<(f64, Vec<f64>, f64)>,
    /// Least distance to a phase behind it in lengths, over the draws their median; 0 without a Gaussian process.
    pub distance: f64,
}

/// Places of inputs in widths of what was tested.
pub(super) fn scaled(ranges: &[TestedRange], values: &[f64]) -> Vec<f64> {
    let place = |(range, value): (&TestedRange, &f64)| {
        let width = range.upper - range.lower;
        (value - range.lower) / if width > 0.0 { width } else { 1.0 }
    };
    ranges.iter().zip(values).map(place).collect()
}

impl Rebuilt {
    /// From a result.
    ///
    /// # Errors
    /// A result whose numbers do not belong together.
    pub fn new(output: &Output, sensor: &SensorDiscrepancy) -> Result<Self, GaussianProcessError> {
        let find = |name: &String| output.tested.iter().find(|range| range.input == *name).cloned();
        let ranges: Vec<TestedRange> = output.inputs.iter().filter_map(find).collect();
        let behind: Vec<_> = sensor.residuals.iter().filter(|residual| !residual.held_out).collect();
        let training = Training::new(
            ranges.len(),
            behind.iter().flat_map(|residual| scaled(&ranges, &residual.inputs)).collect(),
            behind.iter().map(|residual| residual.residual).collect(),
            behind.iter().map(|residual| residual.noise_sd * residual.noise_sd).collect(),
        )?;
        let processes = sensor.draws.iter().map(|draw| Process::new(training.clone(), sensor.form, draw));
        let slopes = behind.iter().map(|residual| residual.slopes.clone()).collect();
        Ok(Self { processes: processes.collect::<Result<_, _>>()?, slopes, ranges })
    }

    /// In a case with these values of its inputs, SI.
    pub fn at(&self, values: &[f64]) -> Case {
        let point = scaled(&self.ranges, values);
        let unknowns = self.slopes.first().map_or(0, Vec::len);
        let of = |process: &Process| {
            let functional = process.functional(&point);
            let mean = functional.weights.iter().zip(process.training().values()).map(|(w, r)| w * r).sum();
            let slope = |a: usize| functional.weights.iter().zip(&self.slopes).map(|(w, row)| w * row[a]).sum();
            (mean, (0..unknowns).map(slope).collect(), (functional.variance + functional.scatter).max(0.0).sqrt())
        };
        let mut distances: Vec<f64> = self.processes.iter().map(|process| process.nearest(&point)).collect();
        sort_by(&mut distances, f64::total_cmp);
        let distance = distances.get(distances.len() / 2).copied().unwrap_or(0.0);
        Case { draws: self.processes.iter().map(of).collect(), distance }
    }
}

impl Output {
    /// The inputs of a model, SI by name, that lie outside what was tested.
    pub fn outside(&self, inputs: &[(String, f64)]) -> Vec<Outside> {
        let find = |range: &TestedRange| {
            let value = inputs.iter().find(|(name, _)| *name == range.input)?.1;
            range.outside(value)
        };
        self.tested.iter().filter_map(find).collect()
    }
}

impl Case {
    /// Mean and standard deviation at the posterior mean, over the draws of the hyperparameters.
    pub fn moments(&self) -> (f64, f64) {
        let count = self.draws.len().max(1) as f64;
        let mean = self.draws.iter().map(|(mean, ..)| mean).sum::<f64>() / count;
        let square = |(own, _, sd): &(f64, Vec<f64>, f64)| sd * sd + (own - mean) * (own - mean);
        (mean, (self.draws.iter().map(square).sum::<f64>() / count).sqrt())
    }
}
