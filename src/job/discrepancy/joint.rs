//! Parameters and discrepancies inferred together: chains over both, and what of them is kept.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::expected::scaled;
use super::output::{Joint, JointParameter, Law, Spec};
use super::run::Calibrated;
use crate::inference::estimate::informed::Informed;
use crate::inference::gaussian_process::tested_range::TestedRange;
use crate::inference::gaussian_process::{Training, hyperparameters};
use crate::inference::joint_discrepancy::{JointDiscrepancy, SensorProcess};
use crate::inference::likelihood::Likelihood;
use crate::inference::sampler::chains::{Chain, Chains};
use crate::inference::sampler::convergence::{ConvergenceLimits, judge};
use crate::inference::sampler::nuts::{self, NutsSettings};
use crate::inference::target::{LeastSquares, Target};
use crate::job::JobError;
use crate::job::calibrate::{Calibrate, Weighted, objections};
use crate::measurement::{Measurement, Rows, Sensor, Uncertain};
use crate::random::StreamKey;

/// Chains.
pub(super) const CHAINS: u64 = 4;
/// Transitions of a chain that adapt.
const WARM_UP: u64 = 500;
/// Draws of a chain.
const DRAWS: u64 = 1000;

/// The calibration whose parameters are inferred together with the discrepancies.
#[derive(Debug)]
pub(super) struct Together {
    calibration: Calibrate,
    /// Positions of its measurements in the pass's list.
    data: Vec<usize>,
}

/// What was drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Drawn {
    /// Of the parameters.
    pub joint: Joint,
    /// Of the hyperparameters, by sensor: draws, and the largest R-hat.
    pub hyperparameters: Vec<(Vec<Vec<f64>>, Option<f64>)>,
}

impl Together {
    /// From the calibration of the pass.
    ///
    /// # Errors
    /// What keeps parameters and discrepancy from being inferred together, with what to do.
    pub fn new(spec: &Spec, calibration: Calibrate, measurements: &[Measurement]) -> Result<Self, JobError> {
        let failed = |reason: String| Err(JobError::Failed(reason));
        let data = calibration.data().to_vec();
        if calibration.input_errors().iter().any(|error| error.sigma.is_some()) {
            return failed(
                "the mode `joint` takes readings whose noise is independent, and an input of the model has a `sigma`: leave it out, \
                 or take the mode `modular`"
                    .to_owned(),
            );
        }
        for &index in &spec.data {
            let measurement = &measurements[index];
            if !data.contains(&index) {
                return failed(format!(
                    "the calibration {} does not use `{}`: name it among its `data`, or leave it out here",
                    spec.source, measurement.name
                ));
            }
            let of_spec = |sensor: &&Sensor| spec.sensors.contains(&sensor.name);
            if let Some(sensor) = measurement.sensors.iter().filter(of_spec).find(|sensor| !has_known_noise(sensor)) {
                return failed(format!(
                    "the noise of sensor `{}` of `{}` is inferred: give its `sigma` as a value, since the scatter of the discrepancy \
                     takes what it leaves",
                    sensor.name, measurement.name
                ));
            }
        }
        Ok(Self { calibration, data })
    }

    /// The likelihood with the discrepancies, which may depend on inputs of these ranges.
    fn target(
        &self,
        spec: &Spec,
        measurements: &[Measurement],
        ranges: &[TestedRange],
        calibrated: &Calibrated,
    ) -> Result<JointDiscrepancy<Informed<Likelihood>>, JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let target = self.calibration.target().clone();
        if target.names() != calibrated.order() {
            return Err(failed(format!("the posterior of {} is not of these parameters", spec.source)));
        }
        // The usual priors of the hyperparameters follow the residuals that the calibration leaves.
        let mut left = vec![0.0; target.residual_count()];
        let mean = calibrated.mean();
        target.residuals(&mean, &mut target.workspace(), &mut left).map_err(|error| failed(error.to_string()))?;
        let law = spec.law.unwrap_or(Law::GaussianProcess);
        let form = law.form(spec.kernel, spec.trend);
        let mut processes = Vec::new();
        for sensor in &spec.sensors {
            let (mut rows, mut sds, mut points, mut values) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            for (row, datum) in target.target().data().iter().enumerate() {
                let index = self.data[datum.measurement];
                let measurement = &measurements[index];
                let own = &measurement.sensors[datum.sensor];
                let Rows::Steady(phases) = &measurement.rows else { continue };
                if own.name != *sensor || !spec.data.contains(&index) {
                    continue;
                }
                let inputs: Vec<f64> = spec.inputs.iter().map(|&input| phases[datum.row].inputs[input]).collect();
                points.extend(scaled(ranges, &inputs));
                rows.push(row);
                sds.push(own.total_sd());
                values.push(left[row] * own.total_sd());
            }
            let of_sensor = |reason: String| failed(format!("sensor `{sensor}`: {reason}"));
            let noise = sds.iter().map(|sd| sd * sd).collect();
            let training = Training::new(ranges.len(), points, values, noise);
            let training = training.map_err(|error| of_sensor(error.to_string()))?;
            if training.is_empty() {
                return Err(of_sensor(format!("the calibration {} uses none of its readings", spec.source)));
            }
            let priors = hyperparameters::priors(&training, &form, &spec.beforehand);
            processes.push(SensorProcess { sensor: sensor.clone(), rows, sds, training, form, priors });
        }
        Ok(JointDiscrepancy::new(target, processes))
    }

    /// Runs a chain: from a draw of the calibration, and hyperparameters from their priors.
    pub fn chain(
        &self,
        spec: &Spec,
        measurements: &[Measurement],
        ranges: &[TestedRange],
        calibrated: &Calibrated,
        key: &StreamKey,
        index: u64,
    ) -> Result<Chain, JobError> {
        let target = self.target(spec, measurements, ranges, calibrated)?;
        let draws = calibrated.some(usize::try_from(CHAINS).unwrap_or(1));
        let mut start = draws[usize::try_from(index).unwrap_or(0) % draws.len()].clone();
        // Streams of chains are numbered from 0 on; these stand behind all of them.
        let mut stream = key.stream(u64::MAX - index);
        start.extend(target.priors()[start.len()..].iter().map(|prior| prior.quantile(0.1 + 0.8 * stream.uniform())));
        let settings = NutsSettings { warm_up: WARM_UP, draws: DRAWS, ..NutsSettings::default() };
        nuts::sample(&target, &settings, key, index, Some(&start)).map_err(|error| JobError::Failed(error.to_string()))
    }

    /// Judges the chains and keeps so many draws.
    pub fn drawn(
        &self,
        spec: &Spec,
        measurements: &[Measurement],
        ranges: &[TestedRange],
        calibrated: &Calibrated,
        chains: Vec<Chain>,
    ) -> Result<Drawn, JobError> {
        let target = self.target(spec, measurements, ranges, calibrated)?;
        let own = target.own_parameters();
        let lengths = [chains.len() as u64, chains.first().map_or(0, Chain::len) as u64];
        if lengths[1] == 0 || chains.iter().any(|chain| chain.len() as u64 != lengths[1]) {
            return Err(JobError::Failed("the chains have no draws, or not equally many".to_owned()));
        }
        let chains = Chains { names: target.names().to_vec(), chains };
        let judged = judge(&chains, target.priors(), &ConvergenceLimits::default());
        let weighted = Weighted::new(&chains, None);
        let parameter = |place: usize| {
            let diagnostics = &judged.parameters[place];
            let [lower, upper] = [0.025, 0.975].map(|share| weighted.quantiles(place, &[share])[0]);
            let (rhat, ess_bulk, ess_tail) = (diagnostics.r_hat, diagnostics.ess_bulk, diagnostics.ess_tail);
            (chains.names[place].clone(), JointParameter { interval: [lower, upper], rhat, ess_bulk, ess_tail })
        };
        let parameters: BTreeMap<String, JointParameter> = (0..own).map(parameter).collect();
        let mut kept = weighted.kept(usize::try_from(spec.draws).unwrap_or(usize::MAX));
        let mut first = own;
        let mut of_sensors = Vec::new();
        for part in target.hyperparameters(&kept.values[0]) {
            let places = first..first + part.len();
            let draws = kept.values.iter().map(|draw| draw[places.clone()].to_vec()).collect();
            let r_hat = judged.parameters[places.clone()]
                .iter()
                .try_fold(0.0, |most: f64, own| own.r_hat.map(|value| most.max(value)));
            of_sensors.push((draws, r_hat.filter(|_| !places.is_empty())));
            first = places.end;
        }
        kept.values.iter_mut().for_each(|draw| draw.truncate(own));
        let joint = Joint {
            converged: judged.objections.is_empty(),
            objections: objections(&judged, &chains.names),
            chains: lengths,
            order: chains.names[..own].to_vec(),
            parameters,
            key_numbers: self.calibration.key_numbers(&chains, None),
            draws: kept,
        };
        Ok(Drawn { joint, hyperparameters: of_sensors })
    }

    /// What of the calibration decides the result.
    pub fn identity(&self) -> serde_json::Value {
        serde_json::json!({
            "calibration": crate::job::Job::identity(&self.calibration),
            "chains": [CHAINS, WARM_UP, DRAWS],
        })
    }
}

/// Whether the noise of a sensor is a number.
fn has_known_noise(sensor: &Sensor) -> bool {
    [&sensor.sigma, &sensor.white].into_iter().flatten().all(|value| matches!(value, Uncertain::Known(_)))
}
