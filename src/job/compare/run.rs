//! The comparison as a job: what it is asked, and a block a measurement.

use super::{
    Deviation, FailedPhase, HeatBalance, Moment, Output, PhaseSummary, Readings, Row, SensorSummary, Spec,
    StabilisationCheck, Table, Tuned, Verdict, stretch, trend, words,
};
use crate::study::profile::Criteria;
use std::sync::Arc;

use serde_json::{Value, json};

use crate::expression::Symbol;
use crate::measurement::prediction::{Prediction, Predictor};
use crate::measurement::scatter;
use crate::measurement::{Measurement, Rows, Uncertain};
use crate::thermal::{External, Model, NodeKind};

use super::block::{Part, Summary};
use super::deviation::{KELVIN, common_unit, deviation, noise_rmse};
use super::readings::is_long;
use super::stretch::{Stretch, stretches};
use crate::job::array::Array;
use crate::job::{Done, Job, JobError, Parts, Step};

/// A comparison, ready to run.
#[derive(Debug)]
pub struct Compare {
    pub(super) spec: Spec,
    pub(super) model: Arc<Model>,
    pub(super) measurements: Arc<Vec<Measurement>>,
    pub(super) parameters: Vec<f64>,
    pub(super) predictor: Predictor,
    pub(super) tuned: Option<Tuned>,
}

impl Compare {
    /// Prepares the job. `measurements` are the pass's, `parameters` the values at which to predict, SI.
    ///
    /// # Errors
    /// A network that cannot be compiled.
    pub fn new(
        spec: Spec,
        model: Arc<Model>,
        measurements: Arc<Vec<Measurement>>,
        parameters: Vec<f64>,
    ) -> Result<Self, JobError> {
        let predictor = Predictor::new(&model, &[]).map_err(|e| JobError::Failed(e.to_string()))?;
        Ok(Self { spec, model, measurements, parameters, predictor, tuned: None })
    }

    /// The comparison with a tuned state beside the delivered one.
    pub fn with_tuned(self, tuned: Tuned) -> Self {
        Self { tuned: Some(tuned), ..self }
    }

    pub(super) fn part(&self, measurement: &Measurement) -> Part {
        let mut workspace = self.predictor.workspace();
        let prediction = self.predictor.predict(&mut workspace, measurement, &self.parameters);
        let tuned = self.tuned.as_ref();
        let state = tuned.map(|tuned| tuned.predicted(&self.predictor, &self.model, &self.parameters, measurement));
        let (fixed, tuned_readings) = state.unzip();
        let tuned_readings = tuned_readings.unwrap_or_default();
        let table = Table::new(measurement, &self.model, &prediction.readings, &tuned_readings);
        let mut sensors = self.sensors(measurement, &table);
        if let Some(fixed) = &fixed {
            Tuned::add(fixed, &self.spec.criteria, &table, &mut sensors);
        }
        let summary = Summary {
            sensors,
            phases: self.phases(measurement, &table),
            heat: self.heat(measurement, &prediction),
            trends: trend::trends(measurement, &self.model, &table),
            stabilisation: self.stabilisation(measurement),
            failed: failed(measurement, &prediction),
            unused_columns: measurement.unused_columns.clone(),
            chi2: chi2(measurement, &table),
        };
        Part { predicted: prediction.readings, tuned: tuned_readings, summary }
    }

    pub(super) fn sensors(&self, measurement: &Measurement, table: &Table) -> Vec<SensorSummary> {
        measurement
            .sensors
            .iter()
            .enumerate()
            .map(|(position, sensor)| {
                let of = |held_out: bool| -> Vec<f64> {
                    table.column(position).filter(|row| row.held_out == held_out).map(|row| row.deviation()).collect()
                };
                let unit = &self.model.quantities[sensor.quantity].unit;
                let limit = self.spec.criteria.each_k.filter(|_| unit == KELVIN);
                let (train, held_out) = (deviation(&of(false), limit), deviation(&of(true), limit));
                let sigma = match sensor.sigma {
                    Some(Uncertain::Known(sigma)) => Some(sigma),
                    _ => None,
                };
                let white = sensor.correlation_time_s.is_none();
                let missing = (0..measurement.len())
                    .filter(|&row| !measurement.ignored(row) && measurement.reading(row, position).is_none())
                    .count();
                SensorSummary {
                    measurement: measurement.name.clone(),
                    sensor: sensor.name.clone(),
                    unit: unit.clone(),
                    sigma,
                    noise_rmse: sigma.filter(|_| white).map(|sigma| noise_rmse(sigma, train.count + held_out.count)),
                    train,
                    held_out,
                    missing: missing as u64,
                    tuned: None,
                }
            })
            .collect()
    }

    /// Statistics by phase, or by stretch of a transient.
    pub(super) fn phases(&self, measurement: &Measurement, table: &Table) -> Vec<PhaseSummary> {
        let unit = common_unit(table.iter());
        let limit = self.spec.criteria.each_k.filter(|_| unit == KELVIN);
        let summary = |phase: String, held_out: bool, is_within: &dyn Fn(Moment<'_>) -> bool| {
            let within = (0..table.len()).filter(|&row| is_within(table.moment(row)));
            let (mut deviations, mut worst) = (Vec::new(), None);
            for row in within.flat_map(|row| table.rows(row..row + 1)).filter(|row| row.unit == unit) {
                let deviation = row.deviation();
                deviations.push(deviation);
                if worst.is_none_or(|(_, before): (&str, f64)| before.abs().total_cmp(&deviation.abs()).is_le()) {
                    worst = Some((row.sensor, deviation));
                }
            }
            let (worst_sensor, worst) = worst?;
            Some(PhaseSummary {
                measurement: measurement.name.clone(),
                phase,
                held_out,
                deviation: deviation(&deviations, limit),
                worst_sensor: worst_sensor.to_owned(),
                worst,
            })
        };
        match &measurement.rows {
            Rows::Steady(phases) => phases
                .iter()
                .filter_map(|phase| {
                    let is_own = |moment: Moment<'_>| moment.phase == Some(phase.name.as_str());
                    summary(phase.name.clone(), phase.held_out, &is_own)
                })
                .collect(),
            Rows::Transient { inputs, .. } => stretches(measurement)
                .into_iter()
                .filter_map(|stretch| {
                    let (from, to) = (inputs.times_s[stretch.from], inputs.times_s[stretch.to - 1]);
                    let is_own = |moment: Moment<'_>| moment.time_s.is_some_and(|t| t >= from && t <= to);
                    summary(stretch::name(inputs, stretch), stretch.held_out, &is_own)
                })
                .collect(),
        }
    }

    /// Heat of the model by phase; over a stretch of a transient the time average, with what is stored taken from the
    /// temperatures at its ends, so that the imbalance is a check of the integration.
    pub(super) fn heat(&self, measurement: &Measurement, prediction: &Prediction) -> Vec<HeatBalance> {
        let name = |node: usize| self.model.nodes[node].name.clone();
        match &measurement.rows {
            Rows::Steady(phases) => phases
                .iter()
                .zip(&prediction.heat)
                .filter_map(|(phase, heat)| {
                    let heat = heat.as_ref()?;
                    let boundaries: f64 = heat.into_boundaries_w.iter().map(|b| b.1).sum();
                    Some(HeatBalance {
                        measurement: measurement.name.clone(),
                        phase: phase.name.clone(),
                        sources_w: heat.sources_w,
                        into_boundaries_w: heat.into_boundaries_w.iter().map(|&(n, w)| (name(n), w)).collect(),
                        stored_w: heat.stored_w,
                        imbalance_w: heat.sources_w - boundaries - heat.stored_w,
                    })
                })
                .collect(),
            Rows::Transient { inputs, .. } => stretches(measurement)
                .into_iter()
                .filter_map(|stretch| self.stretch_heat(measurement, inputs, prediction, stretch))
                .collect(),
        }
    }

    pub(super) fn stretch_heat(
        &self,
        measurement: &Measurement,
        inputs: &crate::measurement::InputTable,
        prediction: &Prediction,
        stretch: Stretch,
    ) -> Option<HeatBalance> {
        // From the stretch's first row to the next one's, so that the stretches join up.
        let last = stretch.to.min(measurement.len() - 1);
        let duration_s = inputs.times_s[last] - inputs.times_s[stretch.from];
        if duration_s <= 0.0 {
            return None;
        }
        let mut sources = 0.0;
        let mut boundaries: Vec<(usize, f64)> = Vec::new();
        let mut stored = 0.0;
        for row in stretch.from..last {
            let (from, to) = (prediction.heat[row].as_ref()?, prediction.heat_before[row + 1].as_ref()?);
            let step_s = inputs.times_s[row + 1] - inputs.times_s[row];
            sources += step_s * 0.5 * (from.sources_w + to.sources_w);
            for (position, (&(node, a), &(_, b))) in
                from.into_boundaries_w.iter().zip(&to.into_boundaries_w).enumerate()
            {
                match boundaries.get_mut(position) {
                    Some(entry) => entry.1 += step_s * 0.5 * (a + b),
                    None => boundaries.push((node, step_s * 0.5 * (a + b))),
                }
            }
            stored += self.stored_j(inputs, prediction, row);
        }
        let into: f64 = boundaries.iter().map(|b| b.1).sum();
        if !(sources - into - stored).is_finite() {
            return None;
        }
        Some(HeatBalance {
            measurement: measurement.name.clone(),
            phase: stretch::name(inputs, stretch),
            sources_w: sources / duration_s,
            into_boundaries_w: boundaries
                .iter()
                .map(|&(node, joules)| (self.model.nodes[node].name.clone(), joules / duration_s))
                .collect(),
            stored_w: stored / duration_s,
            imbalance_w: (sources - into - stored) / duration_s,
        })
    }

    /// Heat stored from a row to the next, J: each node's capacity half way times its rise.
    pub(super) fn stored_j(&self, inputs: &crate::measurement::InputTable, prediction: &Prediction, row: usize) -> f64 {
        let nodes = self.model.nodes.len();
        let temperature = |row: usize, node: usize| prediction.temperatures[row * nodes + node];
        let mut total = 0.0;
        for (index, node) in self.model.nodes.iter().enumerate() {
            let NodeKind::Diffusion { capacity } = node.kind else { continue };
            let (from, to) = (temperature(row, index), temperature(row + 1, index));
            let capacity = self.model.graph.evaluate(capacity, &|symbol| match symbol {
                Symbol::Parameter(i) => self.parameters[i as usize],
                Symbol::Input(i) => inputs.in_row(row, i as usize),
                Symbol::Time => 0.5 * (inputs.times_s[row] + inputs.times_s[row + 1]),
                // A capacity depends on no other node's temperature.
                Symbol::Node(_) => 0.5 * (from + to),
                _ => f64::NAN,
            });
            total += capacity * (to - from);
        }
        total
    }

    /// That the stated noise is larger than what the fitted readings scatter by about the tuned state, or the delivered one where
    /// there is none. Sensors whose noise is correlated are left out: their errors are not independent.
    pub(super) fn overstated(&self, readings: &Readings) -> Option<String> {
        let residuals = readings.tables().iter().flat_map(|table| {
            let measurement = self.measurements.iter().find(|declared| declared.name == table.measurement);
            let find = move |row: &Row<&str>| measurement?.sensors.iter().find(|declared| declared.name == row.sensor);
            table.iter().filter_map(move |row| {
                let sensor = find(&row)?;
                let (Some(Uncertain::Known(sigma)), None) = (&sensor.sigma, &sensor.correlation_time_s) else {
                    return None;
                };
                let deviation = if self.tuned.is_some() { row.tuned_deviation()? } else { row.deviation() };
                (!row.held_out && *sigma > 0.0).then_some((sensor, deviation / sigma))
            })
        });
        let sensors = scatter::of_stated(residuals, &self.model);
        scatter::warning(&sensors, self.tuned.as_ref().map_or(0, Tuned::unknowns))
    }

    /// Steadiness of the phases that are windows of time series.
    pub(super) fn stabilisation(&self, measurement: &Measurement) -> Vec<StabilisationCheck> {
        let Rows::Steady(phases) = &measurement.rows else { return Vec::new() };
        phases
            .iter()
            .filter_map(|phase| {
                let steadiness = phase.stabilisation.as_ref()?;
                let sensors = measurement.sensors_in_kelvin(&self.model);
                let limit = self.spec.criteria.stabilisation_k_per_s;
                let drifting = limit.and_then(|limit| steadiness.drifting(&sensors, limit));
                let fastest = drifting.or_else(|| steadiness.steepest(sensors.iter().copied()))?;
                let drift_k_per_s = steadiness.slopes[fastest]?;
                let stored_w = (0..measurement.sensors.len())
                    .filter_map(|s| {
                        Some(self.capacity(measurement.sensors[s].quantity, phase)? * steadiness.slopes[s]?.abs())
                    })
                    .sum();
                Some(StabilisationCheck {
                    measurement: measurement.name.clone(),
                    phase: phase.name.clone(),
                    sensor: measurement.sensors[fastest].name.clone(),
                    drift_k_per_s,
                    drift_error_k_per_s: steadiness.slope_errors[fastest].unwrap_or(0.0),
                    stored_w,
                    stabilised: limit.map(|_| drifting.is_none()),
                    unclear: drifting.is_none() && limit.is_some_and(|limit| drift_k_per_s.abs() > limit),
                })
            })
            .collect()
    }

    /// Heat capacity of the diffusion node whose temperature a quantity is, J/K, where it does not depend on temperature.
    pub(super) fn capacity(&self, quantity: usize, phase: &crate::measurement::Phase) -> Option<f64> {
        let node = self.model.node_of(quantity)?;
        let NodeKind::Diffusion { capacity } = self.model.nodes[node].kind else { return None };
        let capacity = self.model.graph.evaluate(capacity, &|symbol| match symbol {
            Symbol::Parameter(i) => self.parameters[i as usize],
            Symbol::Input(i) => phase.inputs[i as usize],
            Symbol::Time => 0.0,
            _ => f64::NAN,
        });
        capacity.is_finite().then_some(capacity)
    }
}

pub(super) fn failed(measurement: &Measurement, prediction: &Prediction) -> Vec<FailedPhase> {
    prediction
        .failures
        .iter()
        .map(|(row, reason)| FailedPhase {
            measurement: measurement.name.clone(),
            phase: match (&measurement.rows, row) {
                (Rows::Steady(phases), Some(row)) => phases[*row].name.clone(),
                _ => "transient".to_owned(),
            },
            reason: reason.clone(),
        })
        .collect()
}

/// Sum of squares over sigma squared and number of readings, of the rows that a fit may use, where every sigma is known.
pub(super) fn chi2(measurement: &Measurement, table: &Table) -> Option<(f64, u64)> {
    let mut total = (0.0, 0);
    for row in (0..table.len()).filter(|&row| !table.moment(row).held_out) {
        for (column, sensor) in measurement.sensors.iter().enumerate() {
            let Some(reading) = table.at(row, column) else { continue };
            let Some(Uncertain::Known(sigma)) = sensor.sigma else { return None };
            let scaled = reading.deviation() / sigma;
            total = (total.0 + scaled * scaled, total.1 + 1);
        }
    }
    Some(total)
}

/// Number of readings of the rows that are not left out altogether.
fn read(measurement: &Measurement) -> usize {
    let rows = (0..measurement.len()).filter(|&row| !measurement.ignored(row));
    let of_row =
        |row| (0..measurement.sensors.len()).filter(|&sensor| measurement.reading(row, sensor).is_some()).count();
    rows.map(of_row).sum()
}

/// The profile's criteria, over the readings that a fit may use and those held out apart.
pub fn verdicts(criteria: &Criteria, train: &Deviation, held_out: &Deviation) -> Vec<Verdict> {
    let mut verdicts = Vec::new();
    for (which, of, statistics) in [("", "", train), ("held-out ", " of held-out readings", held_out)] {
        if statistics.count == 0 {
            continue;
        }
        let mut judge = |criterion: String, value: f64, limit: f64, kept: bool| {
            verdicts.push(Verdict { criterion, value, limit, kept });
        };
        if let Some(limit) = criteria.mean_k {
            let kept = statistics.mean.abs() <= limit;
            judge(format!("magnitude of the mean deviation{of}, K"), statistics.mean.abs(), limit, kept);
        }
        if let Some(limit) = criteria.sd_k {
            judge(format!("standard deviation{of}, K"), statistics.sd, limit, statistics.sd <= limit);
        }
        if let Some(limit) = criteria.each_k {
            let share = criteria.share.unwrap_or(1.0);
            let kept = statistics.within_limit >= share;
            judge(format!("share of {which}readings within {limit} K"), statistics.within_limit, share, kept);
        }
    }
    verdicts
}

impl Output {
    /// The criteria judged of the tuned state, as [`Output::verdicts`] judges them of the delivered one; none where there is
    /// no tuned state, or where nothing is judged.
    pub fn tuned_verdicts(&self) -> Vec<Verdict> {
        match &self.tuned {
            Some(tuned) if !self.verdicts.is_empty() => verdicts(&self.criteria, &tuned.train, &tuned.held_out),
            Some(_) | None => Vec::new(),
        }
    }
}

impl Job for Compare {
    type State = ();
    type Input = usize;
    type Partial = Part;
    type Output = Output;

    fn kind(&self) -> &'static str {
        "compare"
    }

    fn arrays(output: &Output) -> Vec<(String, Array)> {
        output.rows.arrays()
    }

    fn algorithm_version(&self) -> u32 {
        9
    }

    fn identity(&self) -> Value {
        let data: Vec<Value> = self.spec.data.iter().map(|&index| self.measurements[index].identity()).collect();
        let mut identity = json!({
            "criteria": self.spec.criteria,
            "state": self.spec.from,
            "calibration": self.spec.calibration,
            "parameters": self.parameters,
            "model": self.model.identity(),
            "data": data,
        });
        let readings = self.spec.data.iter().map(|&index| read(&self.measurements[index])).sum();
        if is_long(readings) {
            // Once a list of rows, whatever their number.
            identity["form"] = json!("arrays");
        }
        identity
    }

    fn begin(&self) -> Result<Step<Self>, JobError> {
        Ok(Step::Blocks { stage: "predictions".to_owned(), state: (), inputs: self.spec.data.clone() })
    }

    fn block(&self, (): &(), input: usize, _parts: &dyn Parts) -> Result<Part, JobError> {
        let measurement = self.measurements.get(input);
        Ok(self.part(measurement.ok_or_else(|| JobError::Failed("there is no such measurement".to_owned()))?))
    }

    fn external(&self) -> Option<&External> {
        self.predictor.network().external()
    }

    fn is_last(&self, (): &()) -> bool {
        true
    }

    fn reduce(&self, (): (), blocks: Done<Self>) -> Result<Step<Self>, JobError> {
        let mut whole = Summary::default();
        let mut tables = Vec::new();
        let mut chi2 = Some((0.0, 0));
        for (index, Part { predicted, tuned, summary }) in blocks {
            let Some(measurement) = self.measurements.get(index) else { continue };
            tables.push(Table::new(measurement, &self.model, &predicted, &tuned));
            whole.sensors.extend(summary.sensors);
            whole.phases.extend(summary.phases);
            whole.heat.extend(summary.heat);
            whole.trends.extend(summary.trends);
            whole.stabilisation.extend(summary.stabilisation);
            whole.failed.extend(summary.failed);
            whole.unused_columns.extend(summary.unused_columns);
            chi2 = chi2.zip(summary.chi2).map(|(a, b)| (a.0 + b.0, a.1 + b.1));
        }
        let rows: Readings = tables.into_iter().collect();
        if rows.is_empty() {
            let reason = whole
                .failed
                .first()
                .map_or("there are no readings".to_owned(), |f| format!("{}: {}", f.phase, f.reason));
            return Err(JobError::Failed(format!("nothing could be compared: {reason}")));
        }
        trend::strongest_first(&mut whole.trends);
        let unit = common_unit(rows.iter()).to_owned();
        let judged = || rows.iter().filter(|row| row.unit == unit);
        let limit = self.spec.criteria.each_k.filter(|_| unit == KELVIN);
        let of = |held_out: bool| -> Vec<f64> {
            judged().filter(|row| row.held_out == held_out).map(|row| row.deviation()).collect()
        };
        let (train, held_out) = (deviation(&of(false), limit), deviation(&of(true), limit));
        let overstated = self.overstated(&rows);
        let output = Output {
            state: self.spec.from.clone(),
            parameters: self
                .model
                .parameters
                .iter()
                .zip(&self.parameters)
                .map(|(p, &value)| (p.name.clone(), p.unit.clone(), value))
                .collect(),
            fails: words::fails(&whole.sensors, &self.measurements, &whole.trends, &rows, self.spec.criteria.each_k),
            verdicts: if unit == KELVIN { verdicts(&self.spec.criteria, &train, &held_out) } else { Vec::new() },
            criteria: self.spec.criteria.clone(),
            chi2_per_reading: chi2.filter(|c| c.1 > 0).map(|(sum, count)| sum / count as f64),
            converged: self.tuned.as_ref().map(Tuned::converged),
            tuned: self.tuned.as_ref().map(|tuned| tuned.state(&self.model, &self.parameters, judged, limit)),
            train,
            held_out,
            sensors: whole.sensors,
            phases: whole.phases,
            heat: whole.heat,
            trends: whole.trends,
            stabilisation: whole.stabilisation,
            failed: whole.failed,
            unused_columns: whole.unused_columns,
            warnings: (self.spec.data.iter())
                .flat_map(|&index| self.measurements[index].doubts.iter().map(|doubt| doubt.message.clone()))
                .chain(overstated)
                .collect(),
            rows,
        };
        Ok(Step::Done(Box::new(output)))
    }
}
