//! All that a calibration drew, read back from its blocks, and what single draws predict with their noise. The result
//! keeps a thousand draws and summaries of the rest; this is for programs that want all of it.

use super::Calibrate;
use super::block::{Partial, Predicted, Task};
use super::predictive::InputSpread;
use super::run::{PREDICT, SAMPLE};
use crate::inference::sampler::chains::Chains;
use crate::inference::sampler::smc;
use crate::inference::target::Target;
use crate::job::{JobError, Stage, runnable};
use crate::math::cholesky;
use crate::measurement::{Measurement, Sensor, Uncertain};
use crate::random::StreamKey;
use crate::twin::NoiseTruth;
use crate::twin::noise::noise;

/// Part of the largest variance that is added to each, so that a covariance of fewer errors than readings has a factor.
const JITTER: f64 = 1e-12;

/// What a calibration drew.
#[derive(Debug)]
pub struct Drawn {
    /// All draws of all chains or islands, SI.
    pub chains: Chains,
    /// Weight of each island; `None` for chains, which weigh the same.
    pub weights: Option<Vec<f64>>,
    /// Draws from the prior, SI.
    pub prior: Vec<Vec<f64>>,
    /// Factor of the covariance that known errors of the inputs give to the readings of a row, by measurement and row.
    spread: InputSpread,
}

/// What draws predict.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replicates {
    /// Readings of all measurements, rows and sensors with their noise, draw by draw, SI; NaN where the model failed.
    pub readings: Vec<f64>,
    /// Log density of each reading that was fitted, given those before it where noise is correlated, draw by draw.
    pub log_likelihoods: Vec<f64>,
}

impl Calibrate {
    /// Reads all draws back from the blocks of the job's stages.
    ///
    /// # Errors
    /// Blocks of another form, or of a run that did not end.
    pub fn drawn(&self, stages: Vec<(Stage, Vec<Vec<u8>>)>) -> Result<Drawn, JobError> {
        let (mut chains, mut weights, mut prior) = (None, None, Vec::new());
        for (stage, outputs) in stages {
            let blocks = runnable::blocks::<Self>(&stage, outputs)?;
            match stage.name.as_str() {
                SAMPLE => {
                    let sampled = self.sampled(blocks);
                    let names = self.likelihood().names();
                    chains = Some(if self.spec.sampler.method().has_islands() {
                        let combined = smc::combine(names, sampled.islands);
                        weights = Some(combined.weights);
                        combined.chains
                    } else {
                        Chains { names: names.to_vec(), chains: sampled.chains }
                    });
                }
                PREDICT => {
                    for (task, partial) in blocks {
                        if let (Task::Predict { prior: true, draws }, Partial::Predicted(_)) = (task, partial) {
                            prior.extend(draws);
                        }
                    }
                }
                _ => {}
            }
        }
        let missing = || JobError::Failed("the calibration has no stored draws".to_owned());
        let chains = chains.filter(|chains| !chains.is_empty()).ok_or_else(missing)?;
        let mut spread = self.input_spread();
        for covariance in spread.iter_mut().flatten() {
            let factored = covariance.take().and_then(factor);
            *covariance = factored;
        }
        Ok(Drawn { chains, weights, prior, spread })
    }

    /// What draws predict; `of` and the number of each draw key the noise of its readings.
    pub fn replicates(&self, drawn: &Drawn, of: &str, draws: &[(u64, Vec<f64>)]) -> Replicates {
        let values: Vec<Vec<f64>> = draws.iter().map(|(_, draw)| draw.clone()).collect();
        let Predicted { mut readings, pointwise, .. } = self.predict(of == PRIOR, &values);
        let width = readings.len() / draws.len().max(1);
        for ((number, draw), readings) in draws.iter().zip(readings.chunks_exact_mut(width.max(1))) {
            self.add_noise(drawn, draw, &self.stream(&format!("export {of} {number}")), readings);
        }
        Replicates { readings, log_likelihoods: pointwise }
    }

    /// Adds to the readings of all measurements the noise of the sensors at a draw, and what errors of the inputs add.
    fn add_noise(&self, drawn: &Drawn, draw: &[f64], key: &StreamKey, readings: &mut [f64]) {
        let full = self.likelihood().full_parameters(draw);
        let mut first = 0;
        for (position, mut measurement) in (0_u64..).zip(self.at_unknowns(draw)) {
            measurement.sensors.iter_mut().for_each(|sensor| settle(sensor, &full));
            let added = noise(&measurement, position, NoiseTruth::AsStated, key);
            for (reading, added) in readings.iter_mut().skip(first).zip(&added) {
                *reading += added;
            }
            self.add_input_errors(drawn, position, &measurement, key, readings.get_mut(first..).unwrap_or_default());
            first += added.len();
        }
    }

    /// Adds what errors of the inputs add to the rows of a measurement, whose readings come first.
    fn add_input_errors(
        &self,
        drawn: &Drawn,
        position: u64,
        measurement: &Measurement,
        key: &StreamKey,
        readings: &mut [f64],
    ) {
        let width = measurement.sensors.len();
        let rows = usize::try_from(position).ok().and_then(|position| drawn.spread.get(position));
        // Streams of sensors are numbered from a thousand times the position on; these stand behind all of them.
        let mut stream = key.stream(u64::MAX - position);
        for (factor, row) in rows.into_iter().flatten().zip(readings.chunks_exact_mut(width.max(1))) {
            let Some(factor) = factor else { continue };
            let normal: Vec<f64> = (0..width).map(|_| stream.normal()).collect();
            let mut error = vec![0.0; width];
            cholesky::multiply(factor, &normal, &mut error);
            for (reading, error) in row.iter_mut().zip(error) {
                *reading += error;
            }
        }
    }
}

/// The name by which draws of the prior key their noise.
pub const PRIOR: &str = "prior";
/// The same of the posterior.
pub const POSTERIOR: &str = "posterior";

/// The factor of a covariance, `None` where it is no covariance or nothing but zeros.
fn factor(mut covariance: Vec<f64>) -> Option<Vec<f64>> {
    let width = covariance.len().isqrt();
    let largest = covariance.iter().step_by(width + 1).copied().fold(0.0, f64::max);
    for place in 0..width {
        covariance[place * (width + 1)] += JITTER * largest;
    }
    cholesky::factor(&mut covariance, width).is_ok().then_some(covariance)
}

/// Noise that is a parameter of the model at the values of its parameters.
fn settle(sensor: &mut Sensor, parameters: &[f64]) {
    let values = [&mut sensor.sigma, &mut sensor.white, &mut sensor.correlation_time_s];
    for value in values.into_iter().flatten() {
        if matches!(value, Uncertain::Parameter { .. }) {
            *value = Uncertain::Known(value.at(parameters));
        }
    }
}
