//! The test plan as a job of one stage.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::output::{Instrument, Limited, Output, PlannedPhase, PlannedSensor, Predicted, SetPoint, Settling, Spec};
use crate::job::design;
use crate::job::propagate::Probability;
use crate::job::{Done, Job, JobError, Parts, Step};
use crate::math::functions::{exp, ln};
use crate::random::{Distribution, PointKind, Points, StreamKey};
use crate::statistics::interval::Interval;
use crate::statistics::quantile::{quantile_sorted, sorted};
use crate::thermal::transient::{InitialState, InputTable, Transient, TransientRequest};
use crate::thermal::{Model, Network, Start, Workspace};

/// Name of the only stage.
const STAGE: &str = "phases";
/// Confidence of the probabilities' intervals.
const CONFIDENCE: f64 = 0.95;
/// Instants of a transient at which its sensors are looked at, in geometric progression after the first.
const INSTANTS: usize = 400;
/// The first of them after the start, s.
const FIRST_INSTANT_S: f64 = 10.0;
/// Shares of a step's deviation between which its time constant is taken.
const DECAY: [f64; 2] = [0.1, 0.01];
/// Smallest deviation whose decay is followed, K: ten times what the integration is accurate to.
const LEAST_DECAY_K: f64 = 0.01;

/// What of the design's result is planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chosen {
    /// Parameters to learn.
    learn: Vec<String>,
    /// Inputs that differ between the candidates.
    varied: Vec<String>,
    /// The phases in order.
    phases: Vec<ChosenPhase>,
    /// Sensors that were chosen; none where all are read.
    sensors: Vec<String>,
    /// What stands against the choice.
    findings: Vec<String>,
}

/// A phase that was chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct ChosenPhase {
    /// Its inputs that differ between the candidates, SI.
    conditions: Vec<(String, f64)>,
    /// Information of it and those before it, and its standard error, nats.
    information_nats: [f64; 2],
}

impl Chosen {
    /// From the stored result of a design.
    ///
    /// # Errors
    /// A result of another form; one that names no phase.
    pub fn from_result(result: &Value) -> Result<Self, JobError> {
        let output = design::Output::deserialize(result)
            .map_err(|error| JobError::Failed(format!("the result of the design: {error}")))?;
        let Some(best) = &output.best else {
            let reason = "the design names no best candidate, so there is no phase to plan: see why in its result";
            return Err(JobError::Failed(reason.to_owned()));
        };
        let mut picks: Vec<(usize, f64, f64)> =
            output.picks.iter().map(|pick| (pick.position, pick.information_nats, pick.se)).collect();
        if picks.is_empty() {
            picks.push((best.candidate, best.information_nats, best.se));
        }
        let phase = |(position, information, se): (usize, f64, f64)| {
            let conditions = output.candidates.get(position)?.conditions.clone().into_iter().collect();
            Some(ChosenPhase { conditions, information_nats: [information, se] })
        };
        let phases = picks.into_iter().map(phase).collect::<Option<Vec<_>>>();
        let mut findings = Vec::new();
        if !best.rivals.is_empty() {
            findings.push(
                "the design does not distinguish its best candidate from others: which of them is flown first is free"
                    .to_owned(),
            );
        }
        Ok(Self {
            learn: output.learn.clone(),
            varied: output.axes.iter().map(|axis| axis.input.clone()).collect(),
            phases: phases
                .ok_or_else(|| JobError::Failed("the design picks a candidate that it has not".to_owned()))?,
            sensors: (output.sensor_picks.iter())
                .filter_map(|pick| output.sensors.get(pick.position).map(|sensor| sensor.name.clone()))
                .collect(),
            findings,
        })
    }
}

/// A test plan, ready to run.
#[derive(Debug)]
pub struct TestPlan {
    spec: Spec,
    model: Arc<Model>,
    priors: Vec<Distribution>,
    network: Network,
    /// Parameters that are not fixed: a coordinate each.
    uncertain: Vec<usize>,
    points: Points,
    transient_points: Points,
    chosen: Option<Chosen>,
}

/// What a block found of its phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    sensors: Vec<Predicted>,
    limits: Vec<Limited>,
    failed: u64,
    /// Time to become steady: at the nominal parameters, then of each sample.
    settling_s: Vec<Option<f64>>,
    time_constant_s: Option<f64>,
}

/// Values of one quantity over the samples.
fn predicted(nominal: f64, values: &[f64]) -> Predicted {
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if finite.is_empty() {
        return Predicted { nominal, mean: nominal, band: [nominal; 2] };
    }
    let mean = finite.iter().sum::<f64>() / finite.len() as f64;
    let in_order = sorted(&finite);
    Predicted { nominal, mean, band: [0.025, 0.975].map(|share| quantile_sorted(&in_order, share)) }
}

/// A quantile of times of which some are later than all others.
fn time_quantile(times: &[Option<f64>], share: f64) -> Option<f64> {
    let all: Vec<f64> = times.iter().map(|time| time.unwrap_or(f64::INFINITY)).collect();
    if all.is_empty() {
        return None;
    }
    // By rank, not between ranks: next to an infinite time there is nothing in between.
    let rank = ((all.len() as f64 * share).ceil() as usize).clamp(1, all.len());
    sorted(&all).get(rank - 1).copied().filter(|time| time.is_finite())
}

impl TestPlan {
    /// Prepares the job; `name` is its name in the pass, which its random streams are keyed by.
    ///
    /// # Errors
    /// A network that does not compile, priors that fit no point set.
    pub fn new(
        spec: Spec,
        model: Arc<Model>,
        priors: Vec<Distribution>,
        seed: u64,
        name: &str,
    ) -> Result<Self, JobError> {
        let failed = |reason: String| JobError::Failed(reason);
        let network = Network::compile(&model, &[]).map_err(|error| failed(error.to_string()))?;
        let uncertain: Vec<usize> = (0..priors.len()).filter(|&index| !priors[index].is_fixed()).collect();
        if uncertain.is_empty() {
            return Err(failed("every parameter is fixed: give at least one a prior to predict a band".to_owned()));
        }
        let points = |kind: PointKind, purpose: &str, samples: u64| {
            let samples = usize::try_from(samples).unwrap_or(usize::MAX);
            Points::new(kind, StreamKey::new(seed, name, purpose), samples, uncertain.len())
                .map_err(|error| failed(error.to_string()))
        };
        let own = points(PointKind::Sobol, "test plan", spec.samples)?;
        let transient_points = points(PointKind::LatinHypercube, "test plan durations", spec.transients)?;
        Ok(Self { spec, model, priors, network, points: own, transient_points, uncertain, chosen: None })
    }

    /// The same with what the design chose.
    pub fn with_chosen(self, chosen: Chosen) -> Self {
        Self { chosen: Some(chosen), ..self }
    }

    fn chosen(&self) -> Result<&Chosen, JobError> {
        self.chosen.as_ref().ok_or_else(|| JobError::Failed("the design has no result yet".to_owned()))
    }

    /// Inputs of a chosen phase, SI.
    fn inputs(&self, conditions: &[(String, f64)]) -> Vec<f64> {
        let mut inputs = self.spec.inputs.clone();
        for (name, value) in conditions {
            if let Some(index) = self.model.inputs.iter().position(|input| input.name == *name) {
                inputs[index] = *value;
            }
        }
        inputs
    }

    /// The sensors that are read: those chosen, else all.
    fn instruments(&self) -> Result<Vec<&PlannedSensor>, JobError> {
        let wanted = &self.chosen()?.sensors;
        Ok(self.spec.sensors.iter().filter(|sensor| wanted.is_empty() || wanted.contains(&sensor.name)).collect())
    }

    fn nominal(&self) -> Vec<f64> {
        let value = |(index, prior): (usize, &Distribution)| match prior {
            Distribution::Fixed(fixed) => *fixed,
            _ => self.model.parameters[index].nominal,
        };
        self.priors.iter().enumerate().map(value).collect()
    }

    /// Parameters of a sample.
    fn sample(&self, points: &Points, index: usize) -> Vec<f64> {
        let mut row = vec![0.5; self.uncertain.len()];
        points.fill_row(index, &mut row);
        let mut parameters = self.nominal();
        for (&parameter, share) in self.uncertain.iter().zip(&row) {
            parameters[parameter] = self.priors[parameter].quantile(*share);
        }
        parameters
    }

    /// The steady temperatures of all nodes.
    fn steady(
        &self,
        workspace: &mut Workspace,
        parameters: &[f64],
        inputs: &[f64],
        start: Start<'_>,
    ) -> Result<Vec<f64>, String> {
        self.network.set_parameters(workspace, parameters);
        self.network.set_inputs(workspace, inputs);
        self.network.solve_steady(workspace, start).map_err(|error| error.to_string())?;
        Ok(workspace.temperatures().to_vec())
    }

    /// The transient from the steady state of some inputs to that of others, with the instants at which it is known.
    fn transient(
        &self,
        workspace: &mut Workspace,
        parameters: &[f64],
        [before, after]: [&[f64]; 2],
    ) -> Option<(Vec<f64>, Transient)> {
        let start = self.steady(workspace, parameters, before, Start::Default).ok()?;
        let growth = ln(self.spec.longest_s / FIRST_INSTANT_S.min(self.spec.longest_s)) / (INSTANTS - 1) as f64;
        let first = FIRST_INSTANT_S.min(self.spec.longest_s);
        let mut instants = vec![0.0];
        for step in 0..INSTANTS {
            let instant = first * exp(growth * step as f64);
            if instants.last().is_some_and(|last| instant > *last) {
                instants.push(instant);
            }
        }
        let table = InputTable { base: after.to_vec(), ..InputTable::default() };
        let request = TransientRequest {
            temperatures: false,
            ..TransientRequest::new(parameters, &table, InitialState::Temperatures(&start), &instants)
        };
        let transient = self.network.solve_transient(&request).ok()?;
        Some((instants, transient))
    }

    /// When the sensors of temperature begin to change more slowly than the criteria say, for good; `None` where they do not.
    fn settled(&self, quantities: &[usize], instants: &[f64], transient: &Transient) -> Option<f64> {
        let width = self.network.quantities();
        let is_fast = |step: usize| {
            quantities.iter().any(|&quantity| {
                let at = |instant: usize| transient.quantities[instant * width + quantity];
                let rate = (at(step + 1) - at(step)).abs() / (instants[step + 1] - instants[step]);
                // One that is no number is no steady one.
                !(rate <= self.spec.rate_k_per_s)
            })
        };
        let steps = instants.len() - 1;
        match (0..steps).rev().find(|&step| is_fast(step)) {
            None => Some(0.0),
            Some(last) if last + 1 == steps => None,
            Some(last) => Some(instants[last + 1]),
        }
    }

    /// Time constant of the slowest decay of the sensors of temperature; `None` where the step is too small to tell, or they do not
    /// decay.
    fn time_constant(&self, quantities: &[usize], instants: &[f64], transient: &Transient) -> Option<f64> {
        let width = self.network.quantities();
        let last = instants.len() - 1;
        let deviation = |instant: usize| {
            let of = |&quantity: &usize| {
                (transient.quantities[instant * width + quantity] - transient.quantities[last * width + quantity]).abs()
            };
            quantities.iter().map(of).fold(0.0, f64::max)
        };
        let largest = (0..=last).map(deviation).fold(0.0, f64::max);
        if !(largest * DECAY[1] >= LEAST_DECAY_K) {
            return None;
        }
        // From behind: what overshoots passes the share more than once.
        let [early, late] = DECAY.map(|share| (0..=last).rev().find(|&instant| deviation(instant) >= share * largest));
        let (early, late) = (early?, late?);
        let (from, to) = (deviation(early), deviation(late));
        // At the end of all the deviation is 0 by definition: a decay that is not over has no constant here.
        (late > early && to < from && late + 1 < last && deviation(late + 1) > 0.0)
            .then(|| (instants[late] - instants[early]) / ln(from / to))
    }

    fn phase(&self, index: usize) -> Result<Found, JobError> {
        let chosen = self.chosen()?;
        let after = self.inputs(&chosen.phases[index].conditions);
        let before = match index.checked_sub(1) {
            Some(before) => self.inputs(&chosen.phases[before].conditions),
            None => self.spec.start.clone(),
        };
        let instruments = self.instruments()?;
        let mut workspace = self.network.workspace();
        let nominal = self.nominal();
        let fixed = self
            .steady(&mut workspace, &nominal, &after, Start::Default)
            .map_err(|error| JobError::Failed(format!("phase {} at nominal parameters: {error}", index + 1)))?;
        let of_sensors = |workspace: &Workspace| -> Vec<f64> {
            instruments.iter().map(|sensor| self.network.quantity(workspace, sensor.quantity)).collect()
        };
        let nominal_readings = of_sensors(&workspace);
        let limited: Vec<usize> = (0..self.model.nodes.len())
            .filter(|&node| {
                let limits = self.model.nodes[node].limits;
                limits.yellow.is_some() || limits.red.is_some()
            })
            .collect();
        let samples = usize::try_from(self.spec.samples).unwrap_or(usize::MAX);
        let mut readings = vec![Vec::with_capacity(samples); instruments.len()];
        let mut temperatures = vec![Vec::with_capacity(samples); limited.len()];
        let mut failed = 0;
        for sample in 0..samples {
            let parameters = self.sample(&self.points, sample);
            match self.steady(&mut workspace, &parameters, &after, Start::Temperatures(&fixed)) {
                Ok(nodes) => {
                    readings.iter_mut().zip(of_sensors(&workspace)).for_each(|(column, value)| column.push(value));
                    temperatures.iter_mut().zip(&limited).for_each(|(column, &node)| column.push(nodes[node]));
                }
                Err(_) => failed += 1,
            }
        }
        let outside = |column: &[f64], range: Option<[f64; 2]>| {
            range.map(|[low, high]| {
                let count = column.iter().filter(|value| !(low..=high).contains(*value)).count() as u64 + failed;
                let Interval { lower, upper } = Interval::wilson(count, self.spec.samples, CONFIDENCE);
                Probability { value: count as f64 / self.spec.samples as f64, lower, upper }
            })
        };
        let limits = limited.iter().zip(&temperatures).map(|(&node, column)| {
            let own = &self.model.nodes[node];
            Limited {
                node: own.name.clone(),
                predicted: predicted(fixed[node], column),
                yellow: own.limits.yellow,
                red: own.limits.red,
                outside_yellow: outside(column, own.limits.yellow),
                outside_red: outside(column, own.limits.red),
            }
        });
        let thermometers: Vec<usize> = (instruments.iter().map(|sensor| sensor.quantity))
            .filter(|&quantity| self.model.quantities[quantity].is_temperature)
            .collect();
        let ways: [&[f64]; 2] = [&before, &after];
        let mut settling_s = Vec::new();
        let mut time_constant_s = None;
        if let Some((instants, transient)) = self.transient(&mut workspace, &nominal, ways) {
            settling_s.push(self.settled(&thermometers, &instants, &transient));
            time_constant_s = self.time_constant(&thermometers, &instants, &transient);
        } else {
            settling_s.push(None);
        }
        for sample in 0..usize::try_from(self.spec.transients).unwrap_or(usize::MAX) {
            let parameters = self.sample(&self.transient_points, sample);
            let found = self.transient(&mut workspace, &parameters, ways);
            settling_s.push(found.and_then(|(instants, transient)| self.settled(&thermometers, &instants, &transient)));
        }
        let sensors = nominal_readings.iter().zip(&readings).map(|(nominal, column)| predicted(*nominal, column));
        Ok(Found { sensors: sensors.collect(), limits: limits.collect(), failed, settling_s, time_constant_s })
    }

    fn output(&self, found: Vec<Found>) -> Result<Output, JobError> {
        let chosen = self.chosen()?;
        let settings = &self.spec;
        // A sample is the same set of parameters in all phases, so that their times add up.
        let total = |sample: usize| -> Option<f64> {
            let of_phase = |phase: &Found| Some(phase.settling_s.get(sample).copied()?? + settings.hold_s);
            found.iter().map(of_phase).sum()
        };
        let totals: Vec<Option<f64>> =
            (1..=usize::try_from(settings.transients).unwrap_or(usize::MAX)).map(total).collect();
        let duration_s =
            [total(0), time_quantile(&totals, 0.05), time_quantile(&totals, 0.5), time_quantile(&totals, 0.95)];
        let mut findings = chosen.findings.clone();
        let mut phases = Vec::new();
        for (index, (phase, ChosenPhase { conditions, information_nats })) in
            found.into_iter().zip(&chosen.phases).enumerate()
        {
            let (nominal, own) = phase.settling_s.split_first().map_or((None, &[][..]), |(first, rest)| (*first, rest));
            let unsettled = own.iter().filter(|time| time.is_none()).count() as u64;
            let name = format!("P{:02}", index + 1);
            if let Some(first) = chosen.phases.iter().take(index).position(|own| own.conditions == *conditions) {
                findings.push(format!(
                    "{name} repeats the set points of P{:02}: that averages the sensors' noise and no constant error of theirs",
                    first + 1
                ));
            }
            if nominal.is_none() || unsettled > 0 {
                findings.push(format!(
                    "{name} is not steady within the longest time{} in {unsettled} of {} samples: allow more time, or a larger \
                     rate of change",
                    if nominal.is_none() { " at the nominal parameters and" } else { "" },
                    settings.transients
                ));
            }
            phases.push(PlannedPhase {
                name,
                set_points: self.inputs(conditions),
                information_nats: information_nats[0],
                information_se: information_nats[1],
                sensors: phase.sensors,
                limits: phase.limits,
                failed: phase.failed,
                settling: Settling {
                    nominal_s: nominal,
                    quantiles_s: [0.05, 0.5, 0.95].map(|share| time_quantile(own, share)),
                    unsettled,
                    time_constant_s: phase.time_constant_s,
                },
            });
        }
        let input = |(index, input): (usize, &crate::thermal::Input)| SetPoint {
            name: input.name.clone(),
            unit: input.unit.clone(),
            start: settings.start[index],
            varies: chosen.varied.contains(&input.name),
        };
        let instrument = |sensor: &PlannedSensor| {
            let quantity = &self.model.quantities[sensor.quantity];
            Instrument {
                name: sensor.name.clone(),
                quantity: quantity.name.clone(),
                unit: quantity.unit.clone(),
                is_temperature: quantity.is_temperature,
                sigma: sensor.sigma,
                bias_sd: sensor.bias_sd,
            }
        };
        Ok(Output {
            design: settings.design.job.clone(),
            learn: chosen.learn.clone(),
            objectives: settings.objectives.clone(),
            success: settings.success.clone(),
            criteria: settings.criteria.clone(),
            rate_k_per_s: settings.rate_k_per_s,
            hold_s: settings.hold_s,
            longest_s: settings.longest_s,
            samples: [settings.samples, settings.transients],
            inputs: self.model.inputs.iter().enumerate().map(input).collect(),
            sensors: self.instruments()?.into_iter().map(instrument).collect(),
            phases,
            duration_s,
            findings,
        })
    }
}

impl Job for TestPlan {
    type State = ();
    /// Position of the phase.
    type Input = usize;
    type Partial = Found;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "test-plan"
    }

    fn algorithm_version(&self) -> u32 {
        1
    }

    fn identity(&self) -> Value {
        let settings = &self.spec;
        json!({
            "inputs": settings.inputs,
            "start": settings.start,
            "sensors": settings.sensors,
            "objectives": settings.objectives,
            "success": settings.success,
            "criteria": settings.criteria,
            "hold_s": settings.hold_s,
            "longest_s": settings.longest_s,
            "samples": settings.samples,
            "transients": settings.transients,
            "priors": self.priors,
            "model": self.model.identity(),
        })
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        let inputs = (0..self.chosen()?.phases.len()).collect();
        Ok(Step::Blocks { stage: STAGE.to_owned(), state: (), inputs })
    }

    fn block(&self, _state: &(), input: usize, _parts: &dyn Parts) -> Result<Found, JobError> {
        self.phase(input)
    }

    fn reduce(&self, _state: (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        Ok(Step::Done(Box::new(self.output(blocks.into_iter().map(|(_, found)| found).collect())?)))
    }

    fn is_last(&self, _state: &()) -> bool {
        true
    }
}
