//! Transients in the likelihood: integrates to the last row that is shown, applies lag, clock and bias, gives the differences; `noise`
//! whitens them, `mod` sums the density.

use super::build::is_used;
use super::course::CourseSensor;
use super::fewer_rows::{Drawn, FewerRows};
use super::whitening::Block;
use super::{Datum, Likelihood, Memory, SensorPart};
use crate::inference::likelihood::noise::Series;
use crate::inference::target::Rejected;
use crate::measurement::timing::TimingSlopes;
use crate::measurement::unknown::{ALL, Unknowns, Value, shifted, start_name};
use crate::measurement::{Initial, InputTable, Measurement, Rows};
use crate::thermal::transient::{InitialState, TransientRequest};
use crate::thermal::{Model, NodeKind, Transient, TransientError};

/// A transient and its readings that take part in the fit.
#[derive(Clone, Debug)]
pub(super) struct TransientPart {
    name: String,
    /// Position of the measurement.
    index: usize,
    inputs: InputTable,
    start: Begin,
    sensors: Vec<SensorPart>,
    /// Readings of each sensor.
    readings: Vec<Readings>,
    /// Rows from the first to the last that is used.
    used: usize,
    /// Rows that are integrated: those, or all where a clock may be off and show later ones.
    rows: usize,
    /// Where derivatives are found on fewer rows.
    drawn: Option<Box<Drawn>>,
}

/// A transient that was integrated.
pub(super) struct Known {
    pub inputs: InputTable,
    pub rows: usize,
    pub from_steady: bool,
    /// `rows x nodes`, K.
    pub temperatures: Vec<f64>,
}

/// What is integrated.
struct Wanted<'a> {
    inputs: &'a InputTable,
    /// Rows of the inputs to which it goes.
    rows: usize,
    /// Times the usual local error that a step may have.
    tolerance: f64,
    slopes: bool,
    /// Whether the temperatures of all nodes are wanted.
    temperatures: bool,
}

#[derive(Clone, Debug)]
enum Begin {
    Temperatures {
        /// By node.
        values: Vec<Value>,
        /// Unknowns, and what one of their units does to all nodes.
        fitted: Vec<usize>,
        seeds: Vec<Vec<f64>>,
        /// Nodes that start in balance with the others.
        balanced: Vec<usize>,
    },
    Steady,
    Periodic,
}

/// What a sensor read.
#[derive(Clone, Debug)]
struct Readings {
    /// Position of the first residual.
    first: usize,
    rows: Vec<usize>,
    times_s: Vec<f64>,
    values: Vec<f64>,
}

impl TransientPart {
    pub fn new(
        model: &Model,
        measurement: &Measurement,
        index: usize,
        sensors: Vec<SensorPart>,
        unknowns: &mut Unknowns,
        data: &mut Vec<Datum>,
    ) -> Self {
        let (inputs, start) = match &measurement.rows {
            Rows::Transient { inputs, initial, .. } => {
                (inputs.clone(), begin(model, &measurement.name, initial, unknowns))
            }
            Rows::Steady(_) => (InputTable::default(), Begin::Steady),
        };
        let mut readings = Vec::new();
        let mut used = 0;
        for sensor in 0..sensors.len() {
            let mut sensor_readings = Readings { first: data.len(), rows: vec![], times_s: vec![], values: vec![] };
            for row in (0..measurement.len()).filter(|&row| is_used(measurement, row, sensor)) {
                if let Some(value) = measurement.reading(row, sensor) {
                    sensor_readings.rows.push(row);
                    sensor_readings.times_s.push(inputs.times_s[row]);
                    sensor_readings.values.push(value);
                    data.push(Datum { measurement: index, row, sensor });
                    used = used.max(row + 1);
                }
            }
            readings.push(sensor_readings);
        }
        let shown = sensors.iter().zip(&readings).map(|(sensor, own)| last_shown(sensor, own, &inputs.times_s));
        let rows = shown.fold(used, usize::max);
        Self { name: measurement.name.clone(), index, inputs, start, sensors, readings, used, rows, drawn: None }
    }

    /// Finds derivatives on fewer rows, if they are those of this measurement.
    pub fn find_slopes_on(&mut self, fewer: &[Option<FewerRows>]) {
        let own = fewer.get(self.index).cloned().flatten();
        self.drawn = own.and_then(|own| Drawn::new(own, &self.inputs.times_s[..self.rows], self.used)).map(Box::new);
    }

    /// Positions of its residuals.
    pub fn residuals(&self) -> std::ops::Range<usize> {
        let first = self.readings.first().map_or(0, |of_sensor| of_sensor.first);
        first..self.readings.last().map_or(first, |of_sensor| of_sensor.first + of_sensor.rows.len())
    }

    /// The quantities of its course at these unknowns, if it was the last that was found there and is kept.
    pub fn kept(&self, unknowns: &[f64], memory: &mut Memory) -> Option<Vec<f64>> {
        let last = memory.courses.remove(&self.index).filter(|(at, _)| self.drawn.is_some() && at == unknowns);
        last.map(|(_, quantities)| quantities)
    }

    /// The quantities of its course, with their derivatives where `slopes`; those that are `kept` are not found again.
    pub fn course(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        parameters: &[f64],
        kept: Option<Vec<f64>>,
        slopes: bool,
    ) -> Result<Transient, Rejected> {
        if self.rows == 0 {
            return Ok(Transient::default());
        }
        let drawn = self.drawn.as_deref().filter(|_| slopes);
        let mut solution = match kept {
            Some(quantities) => Transient { quantities, ..Transient::default() },
            None => self.solve(likelihood, unknowns, parameters, &self.whole(likelihood, slopes && drawn.is_none()))?,
        };
        if let Some(Drawn { fewer, .. }) = drawn {
            let tolerance = likelihood.tolerance * fewer.tolerance;
            let course =
                Wanted { temperatures: false, inputs: &fewer.inputs, rows: fewer.rows.len(), tolerance, slopes };
            let on_fewer = self.solve(likelihood, unknowns, parameters, &course)?;
            solution.quantity_tangent = on_fewer.quantity_tangent;
        }
        Ok(solution)
    }

    /// Writes the residuals of its course, with their derivatives where `slopes`.
    pub fn evaluate(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        memory: &mut Memory,
        solution: Transient,
        slopes: bool,
    ) -> Result<(), Rejected> {
        if self.rows == 0 {
            return Ok(());
        }
        let drawn = self.drawn.as_deref().filter(|_| slopes);
        let fitted: &[usize] = match &self.start {
            Begin::Temperatures { fitted, .. } => fitted,
            Begin::Steady | Begin::Periodic => &[],
        };

        let n = unknowns.len();
        let width = likelihood.columns.len() + fitted.len();
        let quantities = likelihood.network.quantities();
        let mut column_values = vec![0.0; self.rows];
        let mut timing_slopes = TimingSlopes::default();
        for (sensor, readings) in self.sensors.iter().zip(&self.readings) {
            let count = readings.rows.len();
            let timing = sensor.timing(unknowns);
            let bias = sensor.bias.map_or(0.0, |bias| bias.at(unknowns));
            let range = readings.first..readings.first + count;
            for (row, value) in column_values.iter_mut().enumerate() {
                *value = solution.quantities[row * quantities + sensor.quantity];
            }
            timing.apply(&self.inputs.times_s, &mut column_values, slopes.then_some(&mut timing_slopes));
            for (residual, (&row, reading)) in
                memory.residuals[range.clone()].iter_mut().zip(readings.rows.iter().zip(&readings.values))
            {
                *residual = reading - column_values[row] - bias;
            }
            let jacobian: &mut [f64] =
                if slopes { &mut memory.jacobian[range.start * n..range.end * n] } else { &mut [] };
            if slopes {
                for (column, &place) in likelihood.columns.iter().chain(fitted).enumerate() {
                    let slope =
                        |row: usize| solution.quantity_tangent[(row * quantities + sensor.quantity) * width + column];
                    match drawn {
                        Some(drawn) => drawn.draw(slope, &mut column_values),
                        None => column_values.iter_mut().enumerate().for_each(|(row, value)| *value = slope(row)),
                    }
                    timing.apply(&self.inputs.times_s, &mut column_values, None);
                    for (position, &row) in readings.rows.iter().enumerate() {
                        jacobian[position * n + place] = -column_values[row];
                    }
                }
                let by_lag = sensor.lag_s.iter().map(|value| (value, &timing_slopes.by_lag));
                let by_behind = sensor.behind_s.iter().map(|value| (value, &timing_slopes.by_behind));
                for (value, slope) in by_lag.chain(by_behind) {
                    let Some(place) = value.place() else { continue };
                    for (position, &row) in readings.rows.iter().enumerate() {
                        jacobian[position * n + place] -= slope[row];
                    }
                }
                if let Some(place) = sensor.bias.and_then(|bias| bias.place()) {
                    for position in 0..count {
                        jacobian[position * n + place] -= 1.0;
                    }
                }
            }
            let mut series = Series {
                times_s: &readings.times_s,
                values: &mut memory.residuals[range.clone()],
                jacobian,
                log_scales: &mut memory.log_scales[range],
                scale_gradient: if slopes { &mut memory.scale_gradient } else { &mut [] },
            };
            sensor.noise.whiten(unknowns, &mut series)?;
        }
        if self.drawn.is_some() {
            memory.courses.insert(self.index, (unknowns.to_vec(), solution.quantities));
        }
        Ok(())
    }

    /// Steps that it takes, rejected ones among them.
    pub fn attempted_steps(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        parameters: &[f64],
    ) -> Result<u64, Rejected> {
        if self.rows == 0 {
            return Ok(0);
        }
        Ok(self.solve(likelihood, unknowns, parameters, &self.whole(likelihood, false))?.stats.attempts())
    }

    /// The course over all rows to the last that is used.
    fn whole(&self, likelihood: &Likelihood, slopes: bool) -> Wanted<'_> {
        Wanted { temperatures: false, inputs: &self.inputs, rows: self.rows, tolerance: likelihood.tolerance, slopes }
    }

    fn solve(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        parameters: &[f64],
        course: &Wanted<'_>,
    ) -> Result<Transient, Rejected> {
        let network = &likelihood.network;
        let moved = moved(likelihood, unknowns, course.inputs);
        let inputs = moved.as_ref().unwrap_or(course.inputs);
        let temperatures: Vec<f64>;
        let (initial, seeds, balanced): (_, &[Vec<f64>], &[usize]) = match &self.start {
            Begin::Temperatures { values, seeds, balanced, .. } => {
                temperatures = values.iter().map(|value| value.at(unknowns)).collect();
                (InitialState::Temperatures(&temperatures), seeds, balanced)
            }
            Begin::Steady => (InitialState::Steady, &[], &[]),
            Begin::Periodic => (InitialState::Periodic, &[], &[]),
        };
        let mut request = TransientRequest::new(parameters, inputs, initial, &inputs.times_s[..course.rows]);
        request.seeds = seeds;
        request.balanced = balanced;
        request.sensitivities = course.slopes;
        request.temperatures = course.temperatures;
        request.options.relative_tolerance *= course.tolerance;
        request.options.absolute_tolerance_k *= course.tolerance;
        // What is wanted roughly is wanted so with its derivatives.
        request.options.coarse_derivatives = course.tolerance > 1.0;
        // It is that of the rows which are used.
        let more = self.rows.div_ceil(self.used.max(1)) as u64;
        let limit = likelihood.most_steps.get(self.index).map(|most| most.saturating_mul(more));
        request.options.most_steps = limit.unwrap_or(request.options.most_steps);
        network.solve_transient(&request).map_err(|error| match (&error, limit) {
            (TransientError::TooManySteps { .. }, Some(_)) => Rejected {
                reason: format!("the transient `{}` is given up: it takes far more steps than expected", self.name)
                    .into(),
                is_given_up: true,
            },
            _ => self.rejected(&error),
        })
    }

    /// Its sensors.
    pub fn sensors(&self) -> &[SensorPart] {
        &self.sensors
    }

    /// Position of the measurement.
    pub fn measurement(&self) -> usize {
        self.index
    }

    /// Whether no reading is used.
    pub fn is_empty(&self) -> bool {
        self.rows == 0
    }

    /// Its course; `None` where it begins in a periodic state, or with nodes in balance.
    pub fn known(
        &self,
        likelihood: &Likelihood,
        unknowns: &[f64],
        parameters: &[f64],
    ) -> Result<Option<Known>, Rejected> {
        let from_steady = match &self.start {
            Begin::Temperatures { balanced, .. } if balanced.is_empty() => false,
            Begin::Steady => true,
            Begin::Temperatures { .. } | Begin::Periodic => return Ok(None),
        };
        let wanted = Wanted { temperatures: true, rows: self.used, ..self.whole(likelihood, false) };
        let temperatures = self.solve(likelihood, unknowns, parameters, &wanted)?.temperatures;
        let inputs = moved(likelihood, unknowns, &self.inputs).unwrap_or_else(|| self.inputs.clone());
        Ok(Some(Known { inputs, rows: self.used, from_steady, temperatures }))
    }

    /// Its sensors at given unknowns.
    pub fn course_sensors(&self, unknowns: &[f64]) -> Vec<CourseSensor> {
        let of = |(sensor, readings): (&SensorPart, &Readings)| CourseSensor {
            quantity: sensor.quantity,
            timing: sensor.timing(unknowns),
            first: readings.first,
            rows: readings.rows.clone(),
        };
        self.sensors.iter().zip(&self.readings).map(of).collect()
    }

    /// Appends the whitening of each sensor.
    pub fn whitening(&self, unknowns: &[f64], blocks: &mut Vec<Block>) -> Result<(), Rejected> {
        for (sensor, readings) in self.sensors.iter().zip(&self.readings) {
            let filter = sensor.noise.filter(unknowns, &readings.times_s)?;
            blocks.push(Block::Series { first: readings.first, readings: readings.times_s.len(), filter });
        }
        Ok(())
    }

    fn rejected(&self, error: &TransientError) -> Rejected {
        if let TransientError::Cycling { element, .. } = error {
            let why = format!("thermostat `{element}` switches far too often: give it a wider band");
            return Rejected::new(format!("in the transient `{}` {why}", self.name));
        }
        let why = match error {
            TransientError::Steady(_) => "has no steady state to begin with",
            TransientError::Capacity { .. } => "meets a capacity that is not above 0",
            TransientError::StepTooShort { .. }
            | TransientError::TooManySteps { .. }
            | TransientError::Cycling { .. } => "cannot be integrated",
            TransientError::NoHysteresis { .. } => "has a thermostat without a band",
            TransientError::Request { .. } => "is not well posed",
            TransientError::NotPeriodic { .. } => "has no periodic state",
        };
        Rejected::new(format!("the transient `{}` {why}", self.name))
    }
}

/// Rows up to the one that a sensor shows last in its readings: all where its clock is off by a time that is inferred.
fn last_shown(sensor: &SensorPart, readings: &Readings, times_s: &[f64]) -> usize {
    let Some(&last_s) = readings.times_s.last() else { return 0 };
    let mut behind_s = 0.0;
    for behind in &sensor.behind_s {
        let Value::Known(known_s) = behind else { return times_s.len() };
        behind_s += known_s;
    }
    if behind_s > 0.0 {
        (times_s.partition_point(|time_s| *time_s < last_s + behind_s) + 1).min(times_s.len())
    } else {
        0
    }
}

/// Inputs with the constant errors that are inferred; `None` where none are.
fn moved(likelihood: &Likelihood, unknowns: &[f64], inputs: &InputTable) -> Option<InputTable> {
    if likelihood.biases.is_empty() {
        return None;
    }
    let mut shifts = vec![0.0; likelihood.network.nominal_inputs().len()];
    for &(input, place) in &likelihood.biases {
        shifts[input] = unknowns[place];
    }
    Some(shifted(inputs, &shifts))
}

fn begin(model: &Model, measurement: &str, initial: &Initial, unknowns: &mut Unknowns) -> Begin {
    let (values, shared, balanced) = match initial {
        Initial::Steady => return Begin::Steady,
        Initial::Periodic => return Begin::Periodic,
        Initial::Temperatures { values, shared, balanced } => (values, shared, balanced),
    };
    let stores = |node: usize| matches!(model.nodes[node].kind, NodeKind::Diffusion { .. });
    let (mut fitted, mut seeds) = (Vec::new(), Vec::new());
    let mut common: Option<Value> = None;
    let mut begin = Vec::with_capacity(values.len());
    for (node, value) in values.iter().enumerate() {
        // A node without storage, or one that starts in balance, only takes its first guess from here.
        let Some(prior) = value.prior().filter(|_| stores(node) && !balanced.contains(&node)) else {
            begin.push(Value::Known(value.nominal()));
            continue;
        };
        let together = shared.contains(&node);
        let start = match common.filter(|_| together) {
            Some(start) => start,
            None => {
                let name = if together { ALL } else { &model.nodes[node].name };
                let start = unknowns.push(start_name(measurement, name), *prior, "K");
                fitted.extend(start.place());
                seeds.push(vec![0.0; values.len()]);
                if together {
                    common = Some(start);
                }
                start
            }
        };
        if let Some(seed) = fitted.iter().position(|&place| start.place() == Some(place)) {
            seeds[seed][node] = 1.0;
        }
        begin.push(start);
    }
    Begin::Temperatures { values: begin, fitted, seeds, balanced: balanced.clone() }
}
