//! The training of a surrogate as a job: runs of the model itself, a block each, so that none is lost; then rounds of further
//! runs where the surrogate is needed, until it is good enough or the rounds are used up.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::needs::{Assessed, Need, TOGETHER};
use super::output::{Output, OutputError, Round, Trained};
use crate::inference::gaussian_process::GaussianProcessError;
use crate::inference::gaussian_process::emulator::Predicted;
use crate::inference::surrogate::choice::choose;
use crate::inference::surrogate::{Axis, Emulation, Run, Space, Surrogate};
use crate::job::calibrate;
use crate::job::stored::Block;
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::math::functions::ln;
use crate::measurement::Rows;
use crate::random::{Distribution, PointKind, Points, StreamKey};
use crate::study::model::surrogate;
use crate::study::requirement::{Environment, Requirement};
use crate::thermal::{External, Point};

/// Runs for each coordinate, at least: a trend has one coefficient more than there are, and the process is to see beyond it.
const RUNS_BY_COORDINATE: usize = 3;

/// The training of a surrogate, ready to run.
pub struct Train {
    pub(super) surrogate: Arc<surrogate::Surrogate>,
    /// Model, priors, measurements.
    pub(super) inputs: calibrate::Inputs,
    pub(super) requirements: Vec<Requirement>,
    pub(super) environments: Vec<Environment>,
    /// All parameters where nothing is uncertain; the surrogate's errors are 0.
    pub(super) nominal: Vec<f64>,
    space: Space,
    points: Points,
    pub(super) seed: u64,
    pub(super) name: String,
}

/// A point at which the model is asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ask {
    parameters: Vec<f64>,
    inputs: Vec<f64>,
}

/// What it gave: outputs, or why there are none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer(Result<Vec<f64>, String>);

/// What is known so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    runs: Vec<Run>,
    /// How many of the runs lay within the priors.
    first_runs: usize,
    failed: u64,
    failure: Option<String>,
    rounds: Vec<Round>,
}

impl Train {
    /// Prepares the training; `name` is its name in the pass, which its random streams are keyed by.
    ///
    /// # Errors
    /// Nothing that varies, more coordinates than the runs can tell.
    pub fn new(
        surrogate: Arc<surrogate::Surrogate>,
        inputs: calibrate::Inputs,
        requirements: Vec<Requirement>,
        environments: Vec<Environment>,
        seed: u64,
        name: &str,
    ) -> Result<Self, JobError> {
        let model = &inputs.model;
        let fixed = |(parameter, prior): (&crate::thermal::Parameter, &Distribution)| match prior {
            Distribution::Fixed(value) => *value,
            _ => parameter.nominal,
        };
        let nominal: Vec<f64> = model.parameters.iter().zip(&inputs.priors).map(fixed).collect();
        let own = model.external.as_ref().map_or(nominal.len(), |external| external.errors.start);
        let space = space(&inputs, &environments, &nominal[..own.min(nominal.len())]);
        let runs = usize::try_from(surrogate.runs).unwrap_or(usize::MAX);
        if space.axes.is_empty() {
            let reason = "nothing varies that a surrogate could learn: give a parameter a prior, or an input a `range`";
            return Err(JobError::Failed(reason.to_owned()));
        }
        if runs < RUNS_BY_COORDINATE * space.axes.len() {
            return Err(JobError::Failed(format!(
                "{runs} runs are too few for a surrogate over {} parameters and inputs: `runs` from {} on",
                space.axes.len(),
                RUNS_BY_COORDINATE * space.axes.len()
            )));
        }
        let key = StreamKey::new(seed, name, "runs");
        let points = Points::new(PointKind::Sobol, key, runs, space.axes.len())
            .map_err(|error| JobError::Failed(error.to_string()))?;
        Ok(Self { surrogate, inputs, requirements, environments, nominal, space, points, seed, name: name.to_owned() })
    }

    /// A sample of the model's own parameters from the priors, and of its inputs from their ranges.
    pub(super) fn sample(&self, index: usize) -> Point {
        let mut row = vec![0.5; self.space.axes.len()];
        self.points.fill_row(index, &mut row);
        let value = |(axis, u): (&Axis, &f64)| match axis.range {
            Some([lower, upper]) => lower * (1.0 - u) + upper * u,
            None => self.inputs.priors.get(axis.place).map_or(axis.centre, |prior| prior.quantile(*u)),
        };
        let values: Vec<f64> = self.space.axes.iter().zip(&row).map(value).collect();
        self.space.point(&values)
    }

    /// Inputs where nothing else is said.
    pub(super) fn nominal_inputs(&self) -> Vec<f64> {
        self.inputs.model.inputs.iter().map(|input| input.nominal).collect()
    }

    fn ask(&self, point: Point) -> Ask {
        let mut parameters = point.parameters;
        parameters.truncate(self.space.parameters);
        Ask { parameters, inputs: point.inputs }
    }

    fn failed(error: &GaussianProcessError) -> JobError {
        JobError::Failed(format!("no surrogate can be laid through the runs: {error}"))
    }

    /// Points where the needs that are not met ask for runs, taken in turn.
    fn further(&self, surrogate: &Surrogate, needs: &[Need]) -> Vec<Ask> {
        let unmet: Vec<&Need> = needs.iter().filter(|need| !need.is_met() && !need.candidates.is_empty()).collect();
        let more = usize::try_from(self.surrogate.more).unwrap_or(usize::MAX);
        let share = more.div_ceil(unmet.len().max(1));
        let chosen: Vec<Vec<usize>> = unmet.iter().map(|need| choose(surrogate, &need.candidates, share)).collect();
        let mut asked: Vec<Ask> = Vec::new();
        for turn in 0..share {
            for (need, places) in unmet.iter().zip(&chosen) {
                let Some(candidate) = places.get(turn).and_then(|&place| need.candidates.get(place)) else { continue };
                let ask = self.ask(candidate.point.clone());
                if asked.len() < more && !asked.contains(&ask) {
                    asked.push(ask);
                }
            }
        }
        asked
    }

    /// Chooses the anchors of each output's error: where the posterior lies, or without readings within priors and ranges.
    /// Gives the share of each error's variance there that they leave; nothing of a constant.
    fn place_anchors(
        &self,
        surrogate: &Surrogate,
        runs: &[Run],
        emulations: &mut [Emulation],
        posterior: &[Point],
    ) -> Result<Vec<Option<f64>>, JobError> {
        let samples: Vec<Point>;
        let points = if posterior.is_empty() {
            samples = (0..TOGETHER).map(|index| self.sample(index)).collect();
            &samples
        } else {
            posterior
        };
        let coordinates: Vec<Vec<f64>> = points.iter().filter_map(|point| surrogate.coordinates(point).ok()).collect();
        for (own, anchors) in emulations.iter_mut().zip(surrogate.anchors(&coordinates, self.surrogate.anchors)) {
            own.anchors = anchors;
        }
        let anchored = Surrogate::new(self.space.clone(), runs, emulations).map_err(|error| Self::failed(&error))?;
        let left = |predicted: Vec<Predicted>| {
            let (mut rest, mut all) = (0.0, 0.0);
            for own in predicted {
                let square = own.rest * own.rest;
                rest += square;
                all += square + own.parts.iter().map(|part| part * part).sum::<f64>();
            }
            (all > 0.0).then(|| rest / all)
        };
        Ok(anchored.predicted(&coordinates).into_iter().map(left).collect())
    }

    /// What came of it, with what must be known of it.
    fn output(
        &self,
        progress: Progress,
        emulations: Vec<Emulation>,
        assessed: Assessed,
        left: &[Option<f64>],
    ) -> Output {
        let outputs = self.surrogate.outputs.iter().enumerate().zip(&emulations).zip(left);
        let outputs = outputs.map(|(((place, (name, unit)), own), left)| {
            let spread = spread(&progress.runs[..progress.first_runs.min(progress.runs.len())], place);
            let late = own.left_out.errors.get(progress.first_runs..).unwrap_or_default();
            let square: f64 = late.iter().map(|error| error * error).sum();
            OutputError {
                output: name.clone(),
                unit: unit.clone(),
                spread,
                error: own.left_out.rms,
                share: (spread > 0.0).then(|| own.left_out.rms / spread),
                worst: own.left_out.worst,
                error_where_needed: (!late.is_empty()).then(|| (square / late.len() as f64).sqrt()),
                widened: own.factor,
                anchors: own.anchors.len() as u64,
                beside_anchors: *left,
            }
        });
        let names = self.space.axes.iter().filter_map(|axis| self.space.names.get(axis.place).cloned());
        let mut output = Output {
            model: self.surrogate.truth.description.clone(),
            runs: progress.runs.len() as u64,
            first_runs: progress.first_runs as u64,
            failed: progress.failed,
            failure: progress.failure,
            coordinates: names.collect(),
            outputs: outputs.collect(),
            readings: assessed.readings,
            rounds: progress.rounds,
            findings: Vec::new(),
            trained: Trained { space: self.space.clone(), runs: progress.runs, emulations },
        };
        output.findings = findings(&output, assessed.no_posterior.as_deref());
        output
    }
}

/// What must be known of a surrogate before its results are relied on.
fn findings(output: &Output, no_posterior: Option<&str>) -> Vec<String> {
    let mut findings = Vec::new();
    for own in &output.readings {
        let (sensor, unit) = (format!("`{}` of `{}`", own.sensor, own.measurement), &own.unit);
        let numbers = |error: f64| format!("{} {unit} against {} {unit}", short(error), short(own.noise));
        if own.error > own.noise {
            findings.push(format!(
                "where the posterior lies the surrogate's error exceeds the noise of {sensor} ({}): what is inferred from it says more \
                 of the surrogate than of the model. Raise `runs` or `rounds`",
                numbers(own.error)
            ));
        } else if own.cross_validated > own.noise {
            findings.push(format!(
                "the cross-validated error over all runs exceeds the noise of {sensor} ({}). Where the posterior lies it is {} {unit}, \
                 which results carry",
                numbers(own.cross_validated),
                short(own.error)
            ));
        }
    }
    if let Some(last) = output.rounds.last() {
        for need in last.needs.iter().filter(|need| need.error > need.allowed) {
            findings.push(format!(
                "the rounds are used up before the surrogate is good enough for {}: {}, where {} is allowed. Results carry the \
                 error; `rounds` or `runs` lower it",
                need.what,
                short(need.error),
                short(need.allowed)
            ));
        }
    }
    if let Some(reason) = no_posterior {
        findings.push(format!("no run was placed by the readings, whose posterior cannot be had: {reason}"));
    }
    if output.failed > 0 {
        findings.push(format!(
            "{} of {} runs failed and tell the surrogate nothing; it does not know where the model has no answer",
            output.failed,
            output.failed + output.runs
        ));
    }
    findings
}

/// Three significant digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let decimals = [100.0, 10.0, 1.0, 0.1, 0.01].iter().filter(|end| size < **end).count();
    format!("{value:.decimals$}")
}

fn spread(runs: &[Run], output: usize) -> f64 {
    let values: Vec<f64> = runs.iter().filter_map(|run| run.outputs.get(output).copied()).collect();
    let moments = crate::statistics::Moments::of(&values);
    if values.len() < 2 { 0.0 } else { moments.sd() }
}

/// The coordinates: parameters whose priors are not fixed, inputs that have a range or vary from case to case.
fn space(inputs: &calibrate::Inputs, environments: &[Environment], nominal: &[f64]) -> Space {
    let model = &inputs.model;
    let mut axes = Vec::new();
    for (place, prior) in inputs.priors.iter().take(nominal.len()).enumerate() {
        let [low, centre, high] = [0.16, 0.5, 0.84].map(|u| prior.quantile(u));
        if !prior.is_fixed() && high > low {
            // What is known by factors varies by factors.
            let is_log = matches!(prior, Distribution::LogNormal { .. } | Distribution::LogUniform { .. });
            let scale = 0.5 * if is_log { ln(high) - ln(low) } else { high - low };
            axes.push(Axis { place, centre, scale, is_log, range: None });
        }
    }
    let mut ranges: Vec<Option<[f64; 2]>> = vec![None; model.inputs.len()];
    for measurement in inputs.measurements.iter() {
        let Rows::Steady(phases) = &measurement.rows else { continue };
        for phase in phases {
            for (range, value) in ranges.iter_mut().zip(&phase.inputs) {
                let [lower, upper] = range.unwrap_or([*value; 2]);
                *range = Some([lower.min(*value), upper.max(*value)]);
            }
        }
    }
    for (input, own) in model.inputs.iter().enumerate() {
        let mut range = [own.nominal; 2];
        let ends = own.range.into_iter().chain(ranges[input]).flatten();
        for value in ends.chain(environments.iter().filter_map(|environment| environment.inputs.get(input).copied())) {
            range = [range[0].min(value), range[1].max(value)];
        }
        let [lower, upper] = range;
        if upper > lower {
            let (centre, scale) = (0.5 * (lower + upper), 0.25 * (upper - lower));
            axes.push(Axis { place: nominal.len() + input, centre, scale, is_log: false, range: Some(range) });
        }
    }
    let own = model.parameters.iter().take(nominal.len()).map(|parameter| parameter.name.clone());
    Space {
        names: own.chain(model.inputs.iter().map(|input| input.name.clone())).collect(),
        parameters: nominal.len(),
        base: nominal.iter().copied().chain(model.inputs.iter().map(|input| input.nominal)).collect(),
        axes,
    }
}

impl Job for Train {
    type State = Progress;
    type Input = Ask;
    type Partial = Answer;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "surrogate"
    }

    fn algorithm_version(&self) -> u32 {
        2
    }

    fn identity(&self) -> Value {
        let measurements: Vec<Value> = self.inputs.measurements.iter().map(|own| own.identity()).collect();
        json!({
            "settings": self.surrogate.identity(),
            "model": self.inputs.model.identity(),
            "priors": self.inputs.priors,
            "measurements": measurements,
            "input_errors": self.inputs.input_errors,
            "requirements": self.requirements,
            "environments": self.environments,
        })
    }

    fn external(&self) -> Option<&External> {
        Some(&self.surrogate.truth)
    }

    fn is_last(&self, progress: &Progress) -> bool {
        progress.rounds.len() as u64 == self.surrogate.rounds
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        let runs = usize::try_from(self.surrogate.runs).unwrap_or(usize::MAX);
        let inputs = (0..runs).map(|index| self.ask(self.sample(index))).collect();
        Ok(Step::Blocks { stage: "runs".to_owned(), state: Progress::default(), inputs })
    }

    fn block(&self, _progress: &Progress, ask: Ask, parts: &dyn Parts) -> Result<Answer, JobError> {
        // A run follows from the model and its inputs alone, whatever the pass wants of it.
        let of = (self.surrogate.answered_by.to_string(), ask.clone()).into_bytes()?;
        if let Some(known) = parts.shared(&of) {
            return Answer::from_bytes(&known, "runs");
        }
        let point = Point { parameters: ask.parameters, inputs: ask.inputs };
        let answer = self.surrogate.truth.evaluate(std::slice::from_ref(&point)).pop();
        let answer = answer.ok_or_else(|| JobError::Failed("the model was not asked".to_owned()))?;
        let answer = Answer(answer.map_err(|fault| fault.to_string()));
        if answer.0.is_ok() {
            parts.share(&of, &answer.clone().into_bytes()?);
        }
        Ok(answer)
    }

    fn reduce(&self, mut progress: Progress, blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        for (Ask { parameters, inputs }, Answer(answer)) in blocks {
            match answer {
                Ok(outputs) => progress.runs.push(Run { parameters, inputs, outputs }),
                Err(reason) => {
                    progress.failed += 1;
                    progress.failure.get_or_insert(reason);
                }
            }
        }
        if progress.rounds.is_empty() {
            progress.first_runs = progress.runs.len();
        }
        if progress.runs.len() < RUNS_BY_COORDINATE * self.space.axes.len() {
            let reason = progress.failure.as_ref().map_or_else(String::new, |reason| format!("; {reason}"));
            return Err(JobError::Failed(format!(
                "{} of {} runs failed, and what is left is too little for a surrogate{reason}",
                progress.failed,
                progress.failed + progress.runs.len() as u64
            )));
        }
        let key = StreamKey::new(self.seed, &self.name, "processes");
        let mut emulations = Surrogate::fit(&self.space, &progress.runs, &key).map_err(|error| Self::failed(&error))?;
        let surrogate = Surrogate::new(self.space.clone(), &progress.runs, &emulations);
        let surrogate = surrogate.map_err(|error| Self::failed(&error))?;
        let round = progress.rounds.len() as u64;
        let assessed = self.assess(&surrogate, &emulations, round)?;
        let needs = assessed.needs.iter().map(|need| need.state.clone()).collect();
        progress.rounds.push(Round { runs: progress.runs.len() as u64, needs });
        if round < self.surrogate.rounds {
            let inputs = self.further(&surrogate, &assessed.needs);
            if !inputs.is_empty() {
                return Ok(Step::Blocks { stage: format!("round {}", round + 1), state: progress, inputs });
            }
        }
        let left = self.place_anchors(&surrogate, &progress.runs, &mut emulations, &assessed.posterior)?;
        Ok(Step::Done(Box::new(self.output(progress, emulations, assessed, &left))))
    }
}
