//! The discrepancy as a job.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::joint::{CHAINS, Drawn, Together};
use super::laws::{Given, Question, two};
use super::output::{Confounded, Law, Output, PhaseResidual, SensorDiscrepancy, Spec};
use super::residuals::{Reading, Residuals, readings};
use crate::inference::gaussian_process::confounding::{Information, moved};
use crate::inference::gaussian_process::hyperparameters::Beforehand;
use crate::inference::gaussian_process::tested_range::TestedRange;
use crate::inference::sampler::chains::Chain;
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::measurement::prediction::Predictor;
use crate::measurement::unknown::with_unknowns;
use crate::measurement::{Measurement, Rows, Uncertain};
use crate::random::StreamKey;
use crate::study::resolve::scope::unit_of;
use crate::thermal::Model;

/// Draws of the posterior in a block; part of the job's identity.
const BLOCK: usize = 25;
/// Largest share of draws without a solution that is tolerated.
const MOST_FAILED: f64 = 0.1;
/// Ratio of standard deviations beyond which a parameter counts as confounded.
const WIDER: f64 = 1.25;
/// Shift in standard deviations beyond which it does.
const SHIFTED: f64 = 1.0;
/// Part of a residual that is not linear in the unknowns, in standard deviations of the noise, that is warned of.
const NONLINEAR: f64 = 0.5;

/// The part of a calibration's result that is used.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Calibrated {
    converged: bool,
    order: Vec<String>,
    tuned: Vec<(String, f64)>,
    draws: Draws,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Draws {
    values: Vec<Vec<f64>>,
}

impl Calibrated {
    /// From a calibration's result.
    ///
    /// # Errors
    /// A result without draws.
    pub fn from_result(source: &str, result: &Value) -> Result<Self, JobError> {
        let failed = |reason: String| JobError::Failed(format!("the posterior of {source}: {reason}"));
        let own = Self::deserialize(result).map_err(|error| failed(error.to_string()))?;
        let is_whole = |draw: &Vec<f64>| draw.len() == own.order.len() && draw.iter().all(|value| value.is_finite());
        if own.draws.values.is_empty() || !own.draws.values.iter().all(is_whole) {
            return Err(failed("it has no draws, or one that is not whole".to_owned()));
        }
        Ok(own)
    }

    /// Names of the unknowns.
    pub(super) fn order(&self) -> &[String] {
        &self.order
    }

    /// Mean of all draws.
    pub(super) fn mean(&self) -> Vec<f64> {
        mean(&self.draws.values)
    }

    /// Mean and standard deviation of an unknown.
    fn moments(&self, place: usize) -> [f64; 2] {
        let (mean, count) = (self.mean()[place], self.draws.values.len() as f64);
        let square = self.draws.values.iter().map(|draw| (draw[place] - mean) * (draw[place] - mean)).sum::<f64>();
        [mean, (square / count).sqrt()]
    }

    /// So many draws, evenly spaced.
    pub(super) fn some(&self, count: usize) -> Vec<&Vec<f64>> {
        let all = self.draws.values.len();
        (0..count.min(all)).map(|k| &self.draws.values[k * all / count.min(all)]).collect()
    }
}

/// Mean of draws.
fn mean(draws: &[Vec<f64>]) -> Vec<f64> {
    let count = draws.len().max(1) as f64;
    let of = |place: usize| draws.iter().map(|draw| draw[place]).sum::<f64>() / count;
    (0..draws.first().map_or(0, Vec::len)).map(of).collect()
}

/// A discrepancy, ready to run.
#[derive(Debug)]
pub struct Discrepancy {
    pub(super) spec: Spec,
    model: Arc<Model>,
    measurements: Arc<Vec<Measurement>>,
    predictor: Predictor,
    readings: Vec<Reading>,
    key: StreamKey,
    calibrated: Option<Calibrated>,
    /// In the mode `joint`.
    together: Option<Together>,
}

/// What a block is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Input {
    /// A chain over parameters and hyperparameters, by its number.
    Chain(u64),
    /// Residuals at points of the unknowns: the first is the posterior mean, the others draws.
    Points {
        /// First point.
        first: usize,
        /// Number of points.
        count: usize,
    },
    /// The law of a sensor, by its place in the settings.
    Sensor(usize),
}

/// What a block found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Partial {
    /// A chain over parameters and hyperparameters.
    Chain(Box<Chain>),
    /// Residuals at each point, reading by reading; NaN where there is no solution.
    Residuals(Vec<Vec<f64>>),
    /// The law, and what the readings say of the unknowns.
    Law(Box<SensorDiscrepancy>, Option<Information>),
}

/// What is known when a stage begins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Draws of parameters and hyperparameters together, in the mode `joint`.
    pub(super) drawn: Option<Box<Drawn>>,
    /// The residuals.
    pub(super) residuals: Option<Residuals>,
}

impl State {
    fn drawn(&self) -> Option<&Drawn> {
        self.drawn.as_deref()
    }
}

impl Discrepancy {
    /// Prepares the job. `measurements` are the pass's; `seed` and `name` key its random numbers.
    ///
    /// # Errors
    /// A network that cannot be compiled.
    pub fn new(
        spec: Spec,
        model: Arc<Model>,
        measurements: Arc<Vec<Measurement>>,
        seed: u64,
        name: &str,
    ) -> Result<Self, JobError> {
        let predictor = Predictor::new(&model, &[]).map_err(|error| JobError::Failed(error.to_string()))?;
        let readings = readings(&measurements, &spec.data, &spec.sensors);
        let key = StreamKey::new(seed, name, "discrepancy");
        Ok(Self { spec, model, measurements, predictor, readings, key, calibrated: None, together: None })
    }

    /// The same with the calibration whose parameters are inferred together with the discrepancies.
    pub(super) fn with_together(self, together: Together) -> Self {
        Self { together: Some(together), ..self }
    }

    /// The same with the posterior after which residuals are taken.
    pub fn with_calibrated(self, calibrated: Calibrated) -> Self {
        Self { calibrated: Some(calibrated), ..self }
    }

    fn calibrated(&self) -> Result<&Calibrated, JobError> {
        self.calibrated.as_ref().ok_or_else(|| JobError::Failed("the calibration has no result yet".to_owned()))
    }

    /// The points of the unknowns: their means over the draws, then the draws.
    fn points(&self, drawn: Option<&Drawn>) -> Result<Vec<Vec<f64>>, JobError> {
        let draws: Vec<Vec<f64>> = match drawn {
            Some(drawn) => drawn.joint.draws.values.clone(),
            None => {
                let calibrated = self.calibrated()?;
                // A slope is told from the noise of the others only with some draws for each unknown.
                let least = 4 * (calibrated.order.len() + 1);
                let count = usize::try_from(self.spec.draws).unwrap_or(usize::MAX).max(least);
                calibrated.some(count).into_iter().cloned().collect()
            }
        };
        Ok(std::iter::once(mean(&draws)).chain(draws).collect())
    }

    /// The blocks that take residuals.
    fn residual_blocks(&self, drawn: Option<Box<Drawn>>) -> Result<Step<Self>, JobError> {
        let points = self.points(drawn.as_deref())?.len();
        let block = |first: usize| Input::Points { first, count: BLOCK.min(points - first) };
        let inputs = (0..points).step_by(BLOCK).map(block).collect();
        Ok(Step::Blocks { stage: "residuals".to_owned(), state: State { drawn, residuals: None }, inputs })
    }

    fn together(&self) -> Result<&Together, JobError> {
        self.together.as_ref().ok_or_else(|| JobError::Failed("the calibration is not there".to_owned()))
    }

    /// Ranges of the inputs that the discrepancy may depend on.
    fn ranges(&self) -> Vec<TestedRange> {
        let tested = self.tested();
        let names = self.spec.inputs.iter().map(|&input| &self.model.inputs[input].name);
        names.filter_map(|own| tested.iter().find(|range| range.input == *own).cloned()).collect()
    }

    /// Measurements with what was inferred of them put in, at a point of the unknowns, and the model's parameters there.
    fn fixed(&self, calibrated: &Calibrated, point: &[f64]) -> (Vec<Measurement>, Vec<f64>) {
        let find = |name: &str| {
            let inferred = calibrated.order.iter().position(|own| own == name).map(|place| point[place]);
            inferred.or_else(|| calibrated.tuned.iter().find(|(own, _)| own == name).map(|(_, value)| *value))
        };
        let parameters =
            self.model.parameters.iter().map(|parameter| find(&parameter.name).unwrap_or(parameter.nominal)).collect();
        let inputs: Vec<String> = self.model.inputs.iter().map(|input| input.name.clone()).collect();
        let nodes: Vec<String> = self.model.nodes.iter().map(|node| node.name.clone()).collect();
        let of = |&index: &usize| with_unknowns(&self.measurements[index], &inputs, &nodes, &find);
        (self.spec.data.iter().map(of).collect(), parameters)
    }

    fn residuals_at(&self, calibrated: &Calibrated, point: &[f64]) -> Vec<f64> {
        let (fixed, parameters) = self.fixed(calibrated, point);
        let mut workspace = self.predictor.workspace();
        let predictions: Vec<_> =
            fixed.iter().map(|own| self.predictor.predict(&mut workspace, own, &parameters).readings).collect();
        let residual = |reading: &Reading| {
            let place = self.spec.data.iter().position(|&index| index == reading.measurement).unwrap_or(0);
            let measured = fixed[place].reading(reading.row, reading.sensor).unwrap_or(f64::NAN);
            measured - predictions[place][reading.row * fixed[place].sensors.len() + reading.sensor]
        };
        self.readings.iter().map(residual).collect()
    }

    /// What was tested of every input: by the phases that calibration and law used.
    fn tested(&self) -> Vec<TestedRange> {
        let mut ranges = Vec::new();
        for (input, own) in self.model.inputs.iter().enumerate() {
            let mut values = Vec::new();
            for &index in &self.spec.data {
                let measurement = &self.measurements[index];
                let Rows::Steady(phases) = &measurement.rows else { continue };
                values.extend(measurement.fitted_rows().map(|row| phases[row].inputs[input]));
            }
            let lower = values.iter().copied().fold(f64::INFINITY, f64::min);
            let upper = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if lower.is_finite() && upper.is_finite() && !self.model.clocks.has(input) {
                let unit = unit_of(&own.unit).dimension.to_string();
                ranges.push(TestedRange { input: own.name.clone(), unit, lower, upper });
            }
        }
        ranges
    }

    fn law(&self, residuals: &Residuals, drawn: Option<&Drawn>, name: usize) -> Result<Partial, JobError> {
        let calibrated = self.calibrated()?;
        let (fixed, parameters) = self.fixed(calibrated, &residuals.means);
        let ranges = self.ranges();
        let mut phases = Vec::new();
        let mut quantity = 0;
        for (place, reading) in self.readings.iter().enumerate().filter(|(_, reading)| reading.name == name) {
            let position = self.spec.data.iter().position(|&index| index == reading.measurement).unwrap_or(0);
            let (measurement, sensor) = (&fixed[position], &fixed[position].sensors[reading.sensor]);
            quantity = sensor.quantity;
            let Rows::Steady(rows) = &measurement.rows else { continue };
            let part = |value: &Option<Uncertain>| value.as_ref().map_or(0.0, |value| value.at(&parameters));
            // Inputs as they were written: constant errors of theirs belong to the calibration.
            let inputs = match &self.measurements[reading.measurement].rows {
                Rows::Steady(written) => &written[reading.row].inputs,
                Rows::Transient { .. } => continue,
            };
            phases.push(PhaseResidual {
                measurement: measurement.name.clone(),
                phase: rows[reading.row].name.clone(),
                inputs: self.spec.inputs.iter().map(|&input| inputs[input]).collect(),
                residual: residuals.at_mean[place],
                calibration_sd: residuals.sds[place],
                noise_sd: crate::measurement::total_sd(part(&sensor.sigma), part(&sensor.white)),
                slopes: residuals.slopes[place].clone(),
                held_out: reading.held_out,
                expected: 0.0,
                expected_sd: 0.0,
            });
        }
        let own = &self.model.quantities[quantity];
        let question = Question {
            names: [&self.spec.sensors[name], &own.name, &own.unit],
            residuals: phases,
            ranges: &ranges,
            kernel: self.spec.kernel,
            trend: self.spec.trend,
            law: self.spec.law,
            sampled: self.spec.sampled,
            beforehand: &self.spec.beforehand,
            given: drawn.map(|drawn| {
                let (draws, r_hat) = &drawn.hyperparameters[name];
                let law = self.spec.law.unwrap_or(Law::GaussianProcess);
                Given { law, draws, r_hat: *r_hat }
            }),
            key: self.key,
        };
        let (answer, information) = question.answer()?;
        Ok(Partial::Law(Box::new(answer), information))
    }

    /// Takes the residuals together; begins with the laws.
    fn known(&self, drawn: Option<Box<Drawn>>, rows: Vec<Vec<f64>>) -> Result<Step<Self>, JobError> {
        let points = self.points(drawn.as_deref())?;
        let (Some(at_mean), Some(means)) = (rows.first(), points.first()) else {
            return Err(JobError::Failed("no residual was taken".to_owned()));
        };
        if let Some(place) = at_mean.iter().position(|residual| !residual.is_finite()) {
            let reading = &self.readings[place];
            let measurement = &self.measurements[reading.measurement];
            let phase = match &measurement.rows {
                Rows::Steady(phases) => phases[reading.row].name.as_str(),
                Rows::Transient { .. } => "",
            };
            let sensor = &measurement.sensors[reading.sensor].name;
            return Err(JobError::Failed(format!(
                "the model has no value for sensor `{sensor}` in phase `{phase}` of `{}` at the posterior mean",
                measurement.name
            )));
        }
        let residuals = Residuals::new(means.clone(), at_mean.clone(), &points[1..], &rows[1..]);
        let [used, failed] = residuals.draws;
        if failed as f64 > MOST_FAILED * (used + failed) as f64 || used < 2 {
            return Err(JobError::Failed(format!(
                "at {failed} of {} draws of the posterior a phase has no solution",
                used + failed
            )));
        }
        let inputs = (0..self.spec.sensors.len()).map(Input::Sensor).collect();
        let state = State { drawn, residuals: Some(residuals) };
        Ok(Step::Blocks { stage: "laws".to_owned(), state, inputs })
    }

    fn output(
        &self,
        residuals: &Residuals,
        drawn: Option<Box<Drawn>>,
        laws: Vec<(SensorDiscrepancy, Option<Information>)>,
    ) -> Result<Output, JobError> {
        let calibrated = self.calibrated()?;
        let unknowns = calibrated.order.clone();
        let information: Vec<Information> = laws.iter().filter_map(|(_, information)| information.clone()).collect();
        let moved = moved(&residuals.covariance, unknowns.len(), &information).unwrap_or_default();
        let parameters: Vec<Confounded> = (unknowns.iter().zip(&moved))
            .enumerate()
            .map(|(place, (name, own))| {
                let (sd, free_sd, shift) = match drawn {
                    None => (own.sd, own.free_sd, own.shift),
                    // What became of it: its posterior together with the discrepancies beside that of the calibration.
                    Some(_) => {
                        let [mean, sd] = calibrated.moments(place);
                        (sd, own.sd, residuals.means[place] - mean)
                    }
                };
                let is_confounded = free_sd > WIDER * sd || shift.abs() > SHIFTED * sd;
                Confounded { name: name.clone(), sd, free_sd, shift, absorbed: own.absorbed, is_confounded }
            })
            .collect();
        let sensors: Vec<SensorDiscrepancy> = laws.into_iter().map(|(law, _)| law).collect();
        let mut findings: Vec<String> = drawn.iter().flat_map(|drawn| drawn.joint.objections.clone()).collect();
        let confounded: Vec<&str> =
            parameters.iter().filter(|own| own.is_confounded).map(|own| own.name.as_str()).collect();
        if !confounded.is_empty() {
            let diagnosis = match &self.spec.diagnosis {
                Some(name) => format!("`{name}` of this pass says whether it finds one"),
                None => "a `diagnose` job seeks one".to_owned(),
            };
            findings.push(match drawn {
                Some(_) => format!(
                    "inferred together with the discrepancies, the posteriors of {} are more than {WIDER} times as wide, or have moved \
                     by more than their standard deviation: these data do not tell them from a discrepancy wholly, and the priors of \
                     the discrepancy, {}, decide a part of the result (Brynjarsdottir & O'Hagan 2014). A physical effect that \
                     explains the residuals removes this; {diagnosis}",
                    confounded.join(", "),
                    if self.spec.beforehand == Beforehand::default() {
                        "here the usual ones by the size of what the calibration left (`priors` states what is known)"
                    } else {
                        "which the study states"
                    },
                ),
                None => format!(
                "with a discrepancy free beside them the posteriors of {} would be more than {WIDER} times as wide, or move by more \
                 than their standard deviation: these data do not tell them from a discrepancy wholly, so that their calibrated \
                 values may be off by more than their intervals say (Brynjarsdottir & O'Hagan 2014). A physical effect that \
                 explains the residuals removes this; {diagnosis}",
                confounded.join(", ")
                ),
            });
        }
        let mut worst: Option<f64> = None;
        for (reading, nonlinear) in self.readings.iter().zip(&residuals.nonlinear) {
            let noise = self.measurements[reading.measurement].sensors[reading.sensor].total_sd();
            if noise > 0.0 {
                worst = Some(worst.unwrap_or(0.0).max(nonlinear / noise));
            }
        }
        if let Some(nonlinear) = worst.filter(|nonlinear| *nonlinear > NONLINEAR) {
            findings.push(format!(
                "residuals are no linear functions of the unknowns over the posterior: up to {} standard deviations of the noise \
                 are left out of what a prediction adds to a draw",
                two(nonlinear)
            ));
        }
        let converged = match &drawn {
            Some(drawn) => drawn.joint.converged,
            None => calibrated.converged && sensors.iter().all(|own| own.r_hat.is_none_or(|r_hat| r_hat <= 1.05)),
        };
        Ok(Output {
            converged,
            source: self.spec.source.clone(),
            draws: residuals.draws,
            unknowns,
            means: residuals.means.clone(),
            nonlinearity: worst,
            inputs: self.spec.inputs.iter().map(|&input| self.model.inputs[input].name.clone()).collect(),
            tested: self.tested(),
            sensors,
            parameters,
            findings,
            joint: drawn.map(|drawn| drawn.joint),
        })
    }
}

impl Job for Discrepancy {
    type State = State;
    type Input = Input;
    type Partial = Partial;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "discrepancy"
    }

    fn algorithm_version(&self) -> u32 {
        2
    }

    fn identity(&self) -> Value {
        let mut identity = json!({
            "data": self.spec.data.iter().map(|&index| self.measurements[index].identity()).collect::<Vec<_>>(),
            "source": self.spec.source,
            "sensors": self.spec.sensors,
            "inputs": self.spec.inputs,
            "kernel": self.spec.kernel,
            "trend": self.spec.trend,
            "law": self.spec.law,
            "sampled": self.spec.sampled,
            "draws": self.spec.draws,
            "diagnosis": self.spec.diagnosis,
            "block": BLOCK,
            "model": self.model.identity(),
        });
        if self.spec.beforehand != Beforehand::default() {
            identity["beforehand"] = json!(self.spec.beforehand);
        }
        if let Some(together) = &self.together {
            identity["together"] = together.identity();
        }
        identity
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        if self.together.is_none() {
            return self.residual_blocks(None);
        }
        let state = State { drawn: None, residuals: None };
        Ok(Step::Blocks { stage: "chains".to_owned(), state, inputs: (0..CHAINS).map(Input::Chain).collect() })
    }

    fn block(&self, state: &State, input: Input, _parts: &dyn Parts) -> Result<Partial, JobError> {
        match (input, &state.residuals) {
            (Input::Chain(index), _) => {
                let (calibrated, ranges) = (self.calibrated()?, self.ranges());
                let together = self.together()?;
                let chain = together.chain(&self.spec, &self.measurements, &ranges, calibrated, &self.key, index)?;
                Ok(Partial::Chain(Box::new(chain)))
            }
            (Input::Points { first, count }, _) => {
                let calibrated = self.calibrated()?;
                let points = self.points(state.drawn())?;
                let some = points.iter().skip(first).take(count);
                Ok(Partial::Residuals(some.map(|point| self.residuals_at(calibrated, point)).collect()))
            }
            (Input::Sensor(name), Some(residuals)) => self.law(residuals, state.drawn(), name),
            (Input::Sensor(_), None) => Err(JobError::Failed("the residuals are not known yet".to_owned())),
        }
    }

    fn is_last(&self, state: &State) -> bool {
        state.residuals.is_some()
    }

    fn reduce(&self, state: State, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let (mut chains, mut rows, mut laws) = (Vec::new(), Vec::new(), Vec::new());
        for (_, partial) in blocks {
            match partial {
                Partial::Chain(chain) => chains.push(*chain),
                Partial::Residuals(more) => rows.extend(more),
                Partial::Law(law, information) => laws.push((*law, information)),
            }
        }
        if let Some(residuals) = &state.residuals {
            return Ok(Step::Done(Box::new(self.output(residuals, state.drawn, laws)?)));
        }
        if self.together.is_some() && state.drawn.is_none() {
            let (together, calibrated, ranges) = (self.together()?, self.calibrated()?, self.ranges());
            let drawn = together.drawn(&self.spec, &self.measurements, &ranges, calibrated, chains)?;
            return self.residual_blocks(Some(Box::new(drawn)));
        }
        self.known(state.drawn, rows)
    }
}
