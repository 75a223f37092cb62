//! Adaptive integration of the network's equations: step control, stops, and what happens between steps.
//!
//! The step follows a proportional-integral controller on the embedded error (Gustafsson 1991, ACM TOMS 17, 533), in
//! the largest norm over diffusion nodes. Corners of the inputs and discontinuities of expressions of time are hit exactly.

use crate::math::functions::{exp, ln};
use crate::math::lanes::add_multiple;
use crate::thermal::equations::{Equations, segment};
use crate::thermal::linear::Linear;
use crate::thermal::model::QuantityValue;
use crate::thermal::network::Network;
use crate::thermal::steady::Start;
use crate::watch;

use super::events::{MOST_SWITCHINGS, SWITCHINGS_AN_OUTPUT};
use super::inputs::InputReader;
use super::output::Recorder;
use super::sensitivity::Tangent;
use super::tableau::{self, STAGES};
use super::{InitialState, SwitchEvent, Transient, TransientError, TransientOptions, TransientRequest, TransientStats};

/// Aim of the step control below the tolerance.
const SAFETY: f64 = 0.9;
/// Largest growth and shrinking of a step.
const GROWTH: f64 = 5.0;
const SHRINK: f64 = 0.2;
/// With costly factors a step stays as it is unless it may grow by this much.
const WORTH_GROWING: f64 = 1.3;

/// Steps from which it is looked at how many there would be to the end.
const STEPS_LOOKED_AT: u64 = 1_000_000;

/// State of an integration at an instant, and room for a step.
pub(super) struct Integrator<'a> {
    pub network: &'a Network,
    pub equations: &'a Equations,
    pub reader: InputReader<'a>,
    pub options: TransientOptions,
    pub file: Vec<f64>,
    pub linear: Linear<f64>,
    /// For the arithmetic nodes alone; `None` without any.
    pub algebraic: Option<Linear<f64>>,
    /// Unknowns that store no heat.
    pub arithmetic: Vec<usize>,
    /// Unknowns that store heat and are in balance at the start; none later.
    pub balanced: Vec<bool>,
    pub time_s: f64,
    /// Temperatures of the unknowns at `time_s`, K; the values of the stages of the step under way.
    pub stage_values: Vec<Vec<f64>>,
    /// Slopes of the stages, K/s; the first is the slope at `time_s`.
    pub stage_slopes: Vec<Vec<f64>>,
    pub base: Vec<f64>,
    pub step: Vec<f64>,
    /// Reciprocal of the error allowed at the temperatures at `time_s`, 1/K.
    pub allowed: Vec<f64>,
    pub matrix: StepMatrix,
    pub predictors: [[f64; STAGES]; STAGES],
    /// Slopes at the start of the last step and its length, where the solution was smooth since.
    pub previous_slope: Vec<f64>,
    pub previous_step_s: Option<f64>,
    /// Estimated contraction of the stage iteration.
    pub contraction: f64,
    pub tangent: Option<Tangent>,
    pub stats: TransientStats,
    /// Instant for which inputs and hoisted expressions stand in the file.
    pub instant_s: f64,
    pub inputs: Vec<f64>,
}

/// Slopes from which the matrix of a step is made, and the step for which it is factored.
pub(super) struct StepMatrix {
    pub jacobian: Vec<f64>,
    pub capacity: Vec<f64>,
    /// Slope of the capacity times the slope of the temperature.
    pub capacity_rate: Vec<f64>,
    /// Step of the factors, s; `None` when they are out of date.
    pub factored_for_s: Option<f64>,
    /// Steps since the slopes were evaluated.
    pub age: u32,
}

/// How a step ended.
enum Attempt {
    Accepted { error: f64 },
    Rejected { error: f64 },
    Unsolved,
}

impl<'a> Integrator<'a> {
    pub fn new(network: &'a Network, request: &TransientRequest<'a>) -> Result<Self, TransientError> {
        let equations = network.switched.as_ref().unwrap_or(&network.steady);
        let size = equations.size();
        let mut file = equations.program.registers();
        for (slot, &value) in file[..equations.parameters].iter_mut().zip(&network.nominal_parameters) {
            *slot = value;
        }
        for (slot, &value) in file[..equations.parameters].iter_mut().zip(request.parameters) {
            *slot = value;
        }
        let mut inputs = network.nominal_inputs.clone();
        for (slot, &value) in inputs.iter_mut().zip(&request.inputs.base) {
            *slot = value;
        }
        file[equations.parameters..equations.time()].copy_from_slice(&inputs);
        let rows = request.inputs.times_s.len();
        if let Some(column) = request.inputs.columns.iter().find(|c| c.values.len() != rows) {
            return Err(TransientError::Request {
                what: "an input column must have a value for each instant of its table; values",
                value: column.values.len() as f64,
            });
        }
        if let Some(pair) = request.inputs.times_s.windows(2).find(|pair| !(pair[1] > pair[0])) {
            return Err(TransientError::Request { what: "the instants of inputs must increase", value: pair[1] });
        }
        let balanced: Vec<bool> = equations.unknowns.iter().map(|node| request.balanced.contains(node)).collect();
        let arithmetic: Vec<usize> = (0..size).filter(|&row| equations.capacity[row].is_none()).collect();
        let has_balances = !arithmetic.is_empty() || balanced.contains(&true);
        let linear = network.transient_linear();
        let time_s = request.start_s.or_else(|| request.inputs.times_s.first().copied()).unwrap_or(0.0);
        let mut predictors = [[0.0; STAGES]; STAGES];
        for (stage, weights) in predictors.iter_mut().enumerate().skip(1) {
            *weights = tableau::predictor(stage);
        }
        let mut integrator = Self {
            network,
            equations,
            reader: InputReader::new(request.inputs),
            options: request.options,
            algebraic: has_balances.then(|| linear.clone()),
            arithmetic,
            balanced,
            linear,
            time_s,
            stage_values: vec![vec![0.0; size]; STAGES],
            stage_slopes: vec![vec![0.0; size]; STAGES],
            base: vec![0.0; size],
            step: vec![0.0; size],
            allowed: vec![0.0; size],
            matrix: StepMatrix {
                jacobian: vec![0.0; equations.jacobian.len()],
                capacity: vec![0.0; size],
                capacity_rate: vec![0.0; size],
                factored_for_s: None,
                age: 0,
            },
            predictors,
            previous_slope: vec![0.0; size],
            previous_step_s: None,
            contraction: 1.0,
            tangent: request
                .sensitivities
                .then(|| Tangent::new(network, equations, request.seeds, request.options.coarse_derivatives)),
            stats: TransientStats::default(),
            instant_s: f64::NAN,
            inputs,
            file,
        };
        integrator.equations.program.run(segment::PARAMETERS, &mut integrator.file);
        integrator.equations.program.run(segment::INPUTS, &mut integrator.file);
        integrator.reader.enter(time_s);
        integrator.set_instant(time_s);
        Ok(integrator)
    }

    /// Brings inputs and what is hoisted to an instant.
    pub fn set_instant(&mut self, time_s: f64) {
        if time_s == self.instant_s {
            return;
        }
        self.instant_s = time_s;
        let program = &self.equations.program;
        if self.reader.varies() {
            self.reader.read(time_s, &mut self.inputs);
            self.file[self.equations.parameters..self.equations.time()].copy_from_slice(&self.inputs);
            program.run(segment::INPUTS, &mut self.file);
        }
        self.file[self.equations.time()] = time_s;
        program.run(segment::INSTANT, &mut self.file);
    }

    /// Forgets the instant: something that is hoisted has changed.
    pub fn forget_instant(&mut self) {
        self.instant_s = f64::NAN;
    }

    /// Evaluates balances and capacities at the temperatures of a stage and the instant set.
    pub fn evaluate(&mut self, stage: usize) {
        self.file[self.equations.temperatures()].copy_from_slice(&self.stage_values[stage]);
        self.equations.program.run(segment::RESIDUAL, &mut self.file);
        self.equations.program.run(segment::CAPACITY, &mut self.file);
        self.stats.residual_evaluations += 1;
    }

    /// Whether an unknown stores heat.
    pub fn stores(&self, row: usize) -> bool {
        self.equations.capacity[row].is_some()
    }

    /// Whether the temperature of an unknown follows from the others at once: it stores no heat, or starts in balance.
    pub fn follows(&self, row: usize) -> bool {
        self.equations.capacity[row].is_none() || self.balanced[row]
    }

    /// Capacity of a row as evaluated last, J/K; 0 for arithmetic nodes.
    pub fn capacity(&self, row: usize) -> f64 {
        self.equations.capacity[row].map_or(0.0, |register| self.file[register.index()])
    }

    /// Starts at the given state: consistent arithmetic nodes, modes, slopes, derivatives.
    pub fn start(&mut self, request: &TransientRequest<'a>) -> Result<(), TransientError> {
        match request.initial {
            InitialState::Temperatures(given) => {
                for (value, &node) in self.stage_values[0].iter_mut().zip(&self.equations.unknowns) {
                    *value = given.get(node).copied().unwrap_or(f64::NAN);
                    if !(*value > 0.0 && value.is_finite()) {
                        return Err(TransientError::Request {
                            what: "a start temperature must be above 0 K",
                            value: *value,
                        });
                    }
                }
            }
            InitialState::Steady | InitialState::Periodic => {
                let mut workspace = self.network.workspace();
                self.network.set_parameters(&mut workspace, request.parameters);
                self.network.set_inputs(&mut workspace, &self.inputs);
                self.network.set_time(&mut workspace, self.time_s);
                self.network.solve_steady(&mut workspace, Start::Default)?;
                for (value, &node) in self.stage_values[0].iter_mut().zip(&self.equations.unknowns) {
                    *value = workspace.temperatures()[node];
                }
                if let Some(tangent) = &mut self.tangent {
                    tangent.start_steady(self.network, &mut workspace);
                }
            }
        }
        self.choose_modes()?;
        self.restart()?;
        self.balanced.fill(false);
        if self.arithmetic.is_empty() {
            self.algebraic = None;
        }
        Ok(())
    }

    /// Sets the present instant anew, with the inputs that hold from it on, and checks the temperatures that are given.
    fn enter_instant(&mut self) -> Result<(), TransientError> {
        self.forget_instant();
        self.set_instant(self.time_s);
        self.equations.program.run(segment::BOUNDARY, &mut self.file);
        self.equations.check_given(&self.file, 0, &self.network.nodes)?;
        Ok(())
    }

    /// After a start or a jump: consistent arithmetic nodes, slopes from the equations, new matrix.
    pub fn restart(&mut self) -> Result<(), TransientError> {
        self.enter_instant()?;
        self.make_consistent(0)?;
        self.evaluate(0);
        for row in 0..self.equations.size() {
            if !self.stores(row) {
                self.stage_slopes[0][row] = 0.0;
                continue;
            }
            let capacity = self.capacity(row);
            if !(capacity > 0.0 && capacity.is_finite()) {
                return Err(TransientError::Capacity {
                    node: self.network.nodes[self.equations.unknowns[row]].clone(),
                    capacity,
                    time_s: self.time_s,
                });
            }
            self.stage_slopes[0][row] = self.file[self.equations.residual[row].index()] / capacity;
        }
        if self.stage_slopes[0].iter().any(|slope| !slope.is_finite()) {
            return Err(self.not_finite());
        }
        self.refresh_slopes(0);
        // With slopes as new as these the iteration goes as before, or nearly so; at the start nothing is known of it.
        self.contraction = self.contraction.sqrt();
        self.previous_step_s = None;
        self.restart_tangent();
        Ok(())
    }

    /// The element behind a number that is not finite at the present state of the file.
    pub fn not_finite(&self) -> TransientError {
        match self.equations.name_not_finite(&self.file, &self.network.nodes) {
            Some(error) => error.into(),
            None => TransientError::StepTooShort { time_s: self.time_s, node: self.fastest() },
        }
    }

    /// Takes the slopes of the balances at the last evaluation (of the given stage) for the matrix.
    pub fn refresh_slopes(&mut self, stage: usize) {
        self.equations.program.run(segment::JACOBIAN, &mut self.file);
        for (value, entry) in self.matrix.jacobian.iter_mut().zip(&self.equations.jacobian) {
            *value = self.file[entry.register.index()];
        }
        if self.equations.capacity_varies {
            self.equations.program.run(segment::CAPACITY_SLOPE, &mut self.file);
        }
        for row in 0..self.equations.size() {
            self.matrix.capacity[row] = self.capacity(row);
            self.matrix.capacity_rate[row] = self.equations.capacity_slope[row]
                .map_or(0.0, |register| self.file[register.index()] * self.stage_slopes[stage][row]);
        }
        self.matrix.factored_for_s = None;
        self.matrix.age = 0;
        self.stats.jacobians += 1;
    }

    /// A first step from the size of the slopes: a hundredth of the time in which a temperature would change by
    /// itself (Hairer & Wanner 1996, II.4).
    fn first_step(&self, end_s: f64) -> f64 {
        let span = end_s - self.time_s;
        let fastest = self.stage_values[0]
            .iter()
            .zip(&self.stage_slopes[0])
            .map(|(value, slope)| slope.abs() / value)
            .fold(0.0, f64::max);
        let step = if fastest > 0.0 { 1e-3 / fastest } else { 1e-3 * span };
        self.options.first_step_s.unwrap_or(step).min(span)
    }

    /// Name of the node with the largest slope.
    fn fastest(&self) -> String {
        let mut row = 0;
        for (candidate, slope) in self.stage_slopes[0].iter().enumerate() {
            if slope.abs() > self.stage_slopes[0][row].abs() {
                row = candidate;
            }
        }
        self.equations.unknowns.get(row).map_or_else(String::new, |&node| self.network.nodes[node].clone())
    }

    /// Integrates to the end, recording what is asked.
    pub fn run(
        &mut self,
        end_s: f64,
        recorder: &mut Recorder<'_>,
        result: &mut Transient,
    ) -> Result<(), TransientError> {
        recorder.begin(self, result)?;
        let start_s = self.time_s;
        let most_switchings = MOST_SWITCHINGS.max(SWITCHINGS_AN_OUTPUT * recorder.outputs() as u64);
        let mut step_s = self.options.fixed_step_s.unwrap_or_else(|| self.first_step(end_s));
        // The logarithm of the last step's error.
        let mut last_error: f64 = 0.0;
        let mut failures = 0;
        while self.time_s < end_s {
            watch::check();
            if self.is_hopeless(start_s, end_s) {
                return Err(TransientError::TooManySteps { time_s: self.time_s, steps: self.stats.attempts() });
            }
            let corner = self.reader.next_corner(self.time_s).filter(|&corner| corner < end_s);
            let stop = corner.unwrap_or(end_s);
            let wanted = step_s.min(self.options.longest_step_s);
            let left = stop - self.time_s;
            let mut reaches_stop = wanted >= left * (1.0 - 1e-9);
            let mut present = if reaches_stop {
                left
            } else if wanted > 0.5 * left && self.options.fixed_step_s.is_none() {
                // Two like steps rather than a long and a tiny one.
                0.5 * left
            } else {
                wanted
            };
            let discontinuity = self.discontinuity_within(present);
            if let Some((before, _)) = discontinuity {
                present = before - self.time_s;
                reaches_stop = false;
            }
            // What an instant can resolve: below it a step has no meaning.
            let shortest = 1e-13 * self.time_s.abs().max(end_s.abs()).max(1e-3);
            if present <= shortest {
                if let Some((_, after)) = discontinuity {
                    self.pass_discontinuity(after)?;
                    continue;
                }
                if reaches_stop {
                    // A discontinuity just before a corner of the inputs: nothing changes in between.
                    self.pass_discontinuity(stop)?;
                    continue;
                }
                return Err(TransientError::StepTooShort { time_s: self.time_s, node: self.fastest() });
            }
            let attempt = self.attempt(present);
            let factor = match attempt {
                Attempt::Unsolved => {
                    self.stats.unsolved += 1;
                    failures += 1;
                    if self.matrix.age > 0 {
                        self.evaluate_at_start();
                    } else {
                        step_s = 0.25 * present;
                        self.matrix.factored_for_s = None;
                    }
                    if failures > 60 || self.options.fixed_step_s.is_some() {
                        return Err(self.not_finite());
                    }
                    continue;
                }
                Attempt::Rejected { error } => {
                    self.stats.rejected += 1;
                    step_s = present * (SAFETY * error.sqrt().sqrt().recip()).clamp(SHRINK, 0.9);
                    continue;
                }
                Attempt::Accepted { error } => {
                    failures = 0;
                    let (now, before) = (ln(error.max(1e-8)), last_error);
                    last_error = now;
                    (SAFETY * exp(-0.175 * now + 0.1 * before)).clamp(SHRINK, GROWTH)
                }
            };
            let event = self.switching_within(present);
            if let Some(time_s) = event
                && time_s - self.time_s < present
            {
                // Once more to the switching itself, so that the state there has the full accuracy.
                let to_event = time_s - self.time_s;
                if to_event > shortest {
                    if !matches!(self.attempt(to_event), Attempt::Accepted { .. } | Attempt::Rejected { .. }) {
                        step_s = 0.25 * to_event;
                        self.evaluate_at_start();
                        continue;
                    }
                    self.commit(to_event, self.time_s + to_event, true, recorder, result)?;
                }
                self.switch(result)?;
                self.check_cycling([start_s, end_s], most_switchings, result)?;
                continue;
            }
            if self.options.fixed_step_s.is_none() {
                let proposed = present * factor;
                // A step cut short by a stop says little about the longest that is possible.
                step_s = if present < wanted { proposed.max(wanted.min(proposed * GROWTH)) } else { proposed };
                if !self.linear.is_cheap() && present == wanted && (1.0..WORTH_GROWING).contains(&factor) {
                    step_s = present;
                }
            }
            let arrival = if reaches_stop { stop } else { self.time_s + present };
            let enters_row = reaches_stop && corner.is_some();
            let jumps = enters_row && self.reader.steps_at(arrival);
            self.commit(present, arrival, jumps || discontinuity.is_some(), recorder, result)?;
            if let Some((_, after)) = discontinuity {
                self.pass_discontinuity(after)?;
                last_error = 0.0;
            } else if enters_row {
                self.reader.enter(self.time_s);
                if jumps {
                    self.restart()?;
                    last_error = 0.0;
                } else {
                    // At a corner of linear inputs the slopes go on without a jump.
                    self.enter_instant()?;
                    self.previous_step_s = None;
                }
            }
        }
        // A discontinuity at the very end takes the state across it.
        recorder.due(self, result)?;
        recorder.finish(self, result);
        Ok(())
    }

    /// Whether the steps allowed are taken, or a tenth of them led less than a tenth of the way.
    fn is_hopeless(&self, start_s: f64, end_s: f64) -> bool {
        let (attempts, most) = (self.stats.attempts(), self.options.most_steps);
        let is_looked_at = attempts >= STEPS_LOOKED_AT && attempts.is_multiple_of(STEPS_LOOKED_AT / 10);
        let expected = attempts as f64 * (end_s - start_s) / (self.time_s - start_s);
        attempts >= most || (is_looked_at && expected > most as f64)
    }

    /// Goes on right after a discontinuity. A held input may step at the same instant, which then is no corner any more.
    fn pass_discontinuity(&mut self, after_s: f64) -> Result<(), TransientError> {
        self.time_s = after_s;
        self.reader.enter(after_s);
        self.restart()
    }

    /// Evaluates the slopes anew at the start of the step.
    fn evaluate_at_start(&mut self) {
        self.set_instant(self.time_s);
        self.evaluate(0);
        self.refresh_slopes(0);
        self.contraction = 1.0;
    }

    /// Tries a step; the state moves only in [`Integrator::commit`].
    fn attempt(&mut self, step_s: f64) -> Attempt {
        self.prepare_matrix(step_s);
        for (allowed, value) in self.allowed.iter_mut().zip(&self.stage_values[0]) {
            *allowed = (self.options.absolute_tolerance_k + self.options.relative_tolerance * value).recip();
        }
        for stage in 1..STAGES {
            if !self.solve_stage(stage, step_s) {
                return Attempt::Unsolved;
            }
        }
        // The iterations' room is free now: the error of each temperature.
        self.step.fill(0.0);
        for (stage, slopes) in self.stage_slopes.iter().enumerate() {
            add_multiple(&mut self.step, step_s * tableau::error_weight(stage), slopes);
        }
        for &row in &self.arithmetic {
            self.step[row] = 0.0;
        }
        let mut worst: f64 = 0.0;
        let ends = self.stage_values[0].iter().zip(&self.stage_values[STAGES - 1]);
        for (error, (start, end)) in self.step.iter().zip(ends) {
            let size = start.abs().max(end.abs());
            let allowed = self.options.absolute_tolerance_k + self.options.relative_tolerance * size;
            worst = worst.max(error.abs() / allowed);
        }
        if worst <= 1.0 || self.options.fixed_step_s.is_some() {
            Attempt::Accepted { error: worst }
        } else {
            Attempt::Rejected { error: worst }
        }
    }

    /// Moves to the end of the step just tried: derivatives, outputs, then the state. Where it restarts there, slopes for the
    /// matrix of the next step are left to the restart.
    fn commit(
        &mut self,
        step_s: f64,
        arrival_s: f64,
        restarts: bool,
        recorder: &mut Recorder<'_>,
        result: &mut Transient,
    ) -> Result<(), TransientError> {
        // The file still holds the last evaluation of the last stage, a Newton correction away from the result.
        let renew = self.linear.is_cheap() || self.matrix.age >= 20 || self.contraction > 0.1;
        self.matrix.age += 1;
        if renew && !restarts {
            self.refresh_slopes(STAGES - 1);
        }
        self.step_tangent(step_s);
        recorder.record(self, step_s, arrival_s, result)?;
        if !renew {
            self.contraction = self.contraction.max(0.02);
        }
        self.stats.steps += 1;
        self.previous_step_s = Some(step_s);
        std::mem::swap(&mut self.previous_slope, &mut self.stage_slopes[0]);
        let (first, last) = self.stage_values.split_at_mut(STAGES - 1);
        first[0].copy_from_slice(&last[0]);
        let (first, last) = self.stage_slopes.split_at_mut(STAGES - 1);
        first[0].copy_from_slice(&last[0]);
        if let Some(tangent) = &mut self.tangent {
            tangent.arrive();
        }
        self.time_s = arrival_s;
        result.step_ends_s.push(arrival_s);
        Ok(())
    }

    /// Temperatures of all nodes at the present state, K.
    pub fn all_temperatures(&mut self) -> Vec<f64> {
        self.set_instant(self.time_s);
        self.equations.program.run(segment::BOUNDARY, &mut self.file);
        let mut out = vec![0.0; self.network.nodes.len()];
        for &(node, register) in &self.equations.boundaries {
            out[node] = self.file[register.index()];
        }
        for (&value, &node) in self.stage_values[0].iter().zip(&self.equations.unknowns) {
            out[node] = value;
        }
        out
    }
}

impl Network {
    /// Integrates over time.
    ///
    /// Outputs at the instant at which a held input steps belong to the interval that ends there. Derivatives are
    /// those of the discrete solution with its steps held fixed; a thermostat's switching moves with the parameters,
    /// corners of inputs and discontinuities of expressions of time do not.
    ///
    /// # Errors
    /// [`TransientError`] tells when and where the integration stopped.
    pub fn solve_transient(&self, request: &TransientRequest<'_>) -> Result<Transient, TransientError> {
        if let InitialState::Periodic = request.initial {
            return self.solve_periodic(request);
        }
        let mut integrator = Integrator::new(self, request)?;
        integrator.start(request)?;
        self.integrate(integrator, request)
    }

    /// Runs an integrator that has been started.
    pub(super) fn integrate<'a>(
        &'a self,
        mut integrator: Integrator<'a>,
        request: &TransientRequest<'a>,
    ) -> Result<Transient, TransientError> {
        let start_s = integrator.time_s;
        let mut before = start_s;
        for &output in request.outputs_s {
            if !(output >= before) || !output.is_finite() {
                return Err(TransientError::Request {
                    what: "outputs must ascend from the start; output at s",
                    value: output,
                });
            }
            before = output;
        }
        let end_s = match (request.end_s, request.outputs_s.last()) {
            (Some(end), Some(&last)) => end.max(last),
            (Some(end), None) => end,
            (None, Some(&last)) => last,
            (None, None) => request.inputs.times_s.last().copied().unwrap_or(start_s),
        };
        let mut result = Transient { start: integrator.all_temperatures(), ..Transient::default() };
        let mut recorder = Recorder::new(&integrator, request, start_s, end_s);
        integrator.run(end_s, &mut recorder, &mut result)?;
        result.end = integrator.all_temperatures();
        result.stats = integrator.stats;
        Ok(result)
    }

    /// Whether a quantity needs the whole course.
    pub(super) fn is_over_time(&self, quantity: usize) -> bool {
        !matches!(self.quantities[quantity], QuantityValue::Instant(_))
    }
}

impl Integrator<'_> {
    /// Records a switching.
    pub fn note_event(&mut self, mode: usize, on: bool, result: &mut Transient) {
        self.stats.events += 1;
        let element = self.equations.mode_names[mode].clone();
        result.events.push(SwitchEvent { time_s: self.time_s, element, on });
    }
}
