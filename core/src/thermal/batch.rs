//! Steady solves of several samples side by side: the lanes of a batch share every instruction, and each lane ends
//! with the bits that a solve of it alone from the same start would have.

use crate::math::lanes::Lanes;

use super::equations::segment;
use super::linear::Linear;
use super::network::{Network, State, Workspace};
use super::newton::{self, LaneStatus, SteadyStats};
use super::steady::{Start, SteadyError};

/// Room for `N` samples.
#[derive(Clone, Debug)]
pub struct Batch<const N: usize> {
    pub(super) state: State<[f64; N]>,
    /// None where lanes are always solved one after the other.
    pub(super) linear: Option<Linear<[f64; N]>>,
    status: [LaneStatus; N],
    last_step: [f64; N],
    pub(super) outcomes: Vec<Result<SteadyStats, SteadyError>>,
    /// For lanes that the plain method loses.
    pub(super) alone: Workspace,
    /// A workspace a lane, as far as lanes of a network with sparse factors were solved one after the other.
    pub(super) own: Vec<Workspace>,
    /// Whether the last solve took one lane after the other.
    pub(super) one_by_one: bool,
    /// Lanes written so far hold the solution.
    temperatures: Vec<[f64; N]>,
    /// Whether what follows from the parameters must be computed again.
    pub(super) stale_parameters: bool,
    /// Lanes from here on have no work of their own.
    used: usize,
}

/// Samples that jobs solve side by side; no part of any identity, since each lane gives the bits of a solve alone.
pub const LANES: usize = 16;

/// The batch of jobs.
pub type SampleBatch = Batch<LANES>;

impl<const N: usize> Batch<N> {
    /// Sets all parameters of a lane, SI.
    pub fn set_parameters(&mut self, network: &Network, lane: usize, values: &[f64]) {
        for (slot, &value) in self.state.file[..network.steady.parameters].iter_mut().zip(values) {
            slot[lane] = value;
        }
        self.stale_parameters = true;
    }

    /// Sets one parameter of a lane, SI.
    pub fn set_parameter(&mut self, lane: usize, parameter: usize, value: f64) {
        self.state.file[parameter][lane] = value;
        self.stale_parameters = true;
    }

    /// Sets one parameter of every lane, SI.
    pub fn set_parameter_lanes(&mut self, parameter: usize, values: [f64; N]) {
        self.state.file[parameter] = values;
        self.stale_parameters = true;
    }

    /// Sets all inputs of a lane, SI.
    pub fn set_inputs(&mut self, network: &Network, lane: usize, values: &[f64]) {
        let range = network.steady.parameters..network.steady.time();
        for (slot, &value) in self.state.file[range].iter_mut().zip(values) {
            slot[lane] = value;
        }
    }

    /// Sets the temperatures of all nodes from which a lane's next solve from [`Start::Current`] begins, K (boundaries'
    /// entries are ignored).
    pub fn set_temperatures(&mut self, lane: usize, values: &[f64]) {
        for (slot, &value) in self.temperatures.iter_mut().zip(values) {
            slot[lane] = value;
        }
    }

    /// Says how many lanes, from the first on, have work of their own. Where lanes are solved one after the other (few
    /// lanes of a large network), the others are left out; what they hold is then without meaning.
    pub fn use_lanes(&mut self, count: usize) {
        self.used = count.min(N);
    }

    /// Lanes with work of their own.
    pub(super) fn used(&self) -> usize {
        self.used
    }

    /// How the last solve of a lane ended.
    pub fn outcome(&self, lane: usize) -> &Result<SteadyStats, SteadyError> {
        &self.outcomes[lane]
    }

    /// Temperature of a node in a lane, K.
    pub fn temperature(&self, lane: usize, node: usize) -> f64 {
        self.temperatures[node][lane]
    }

    /// Temperatures of all nodes in every lane, K, boundaries included.
    pub fn temperatures(&self) -> &[[f64; N]] {
        &self.temperatures
    }

    /// Replaces the temperatures of all nodes in every lane, from which [`Start::Current`] starts.
    pub fn set_all_temperatures(&mut self, temperatures: &[[f64; N]]) {
        for (lanes, given) in self.temperatures.iter_mut().zip(temperatures) {
            *lanes = *given;
        }
    }

    /// A quantity in a lane, SI. Not a number where the lane's solve failed.
    pub fn quantity(&self, network: &Network, lane: usize, index: usize) -> f64 {
        if self.outcomes[lane].is_err() {
            return f64::NAN;
        }
        self.state.file[network.steady.quantity[index].index()][lane]
    }
}

impl Network {
    /// The batch of jobs with every lane at the nominal parameters and inputs. It is compiled here once, and not in the
    /// crates that call it.
    pub fn sample_batch(&self) -> SampleBatch {
        self.batch()
    }

    /// Solves every lane of the batch of jobs, as [`Network::solve_steady_batch`] does.
    pub fn solve_samples(&self, batch: &mut SampleBatch, start: Start<'_>) {
        self.solve_steady_batch(batch, start);
    }

    /// A batch with every lane at the nominal parameters and inputs.
    pub fn batch<const N: usize>(&self) -> Batch<N> {
        let mut batch = Batch {
            state: State::new(&self.steady),
            linear: self.linear.in_lanes(),
            status: [LaneStatus::Running; N],
            last_step: [0.0; N],
            outcomes: vec![Ok(SteadyStats::default()); N],
            alone: self.workspace(),
            own: Vec::new(),
            one_by_one: false,
            temperatures: vec![[0.0; N]; self.nodes.len()],
            stale_parameters: true,
            used: N,
        };
        for lane in 0..N {
            batch.set_parameters(self, lane, &self.nominal_parameters);
            batch.set_inputs(self, lane, &self.nominal_inputs);
        }
        batch
    }

    /// Solves every lane. A lane that fails leaves its reason in [`Batch::outcome`]; the others are not affected.
    pub fn solve_steady_batch<const N: usize>(&self, batch: &mut Batch<N>, start: Start<'_>) {
        if let Some(external) = &self.external {
            self.ask_for_lanes(external, batch);
            return;
        }
        let equations = &self.steady;
        batch.one_by_one = batch.linear.as_ref().is_none_or(|linear| !linear.is_worth_lanes(batch.used));
        if batch.one_by_one {
            for lane in 0..batch.used {
                self.solve_own(batch, lane, start);
            }
            return;
        }
        if self.isolated_nodes().is_some() {
            for lane in 0..batch.used {
                self.solve_alone(batch, lane, start);
            }
            equations.program.run(segment::QUANTITY, &mut batch.state.file);
            return;
        }
        if batch.stale_parameters {
            equations.program.run(segment::PARAMETERS, &mut batch.state.file);
            batch.stale_parameters = false;
        }
        for part in [segment::INPUTS, segment::INSTANT, segment::BOUNDARY] {
            equations.program.run(part, &mut batch.state.file);
        }
        for &(node, register) in &equations.boundaries {
            batch.temperatures[node] = batch.state.file[register.index()];
        }
        let first = equations.temperatures().start;
        for lane in 0..N {
            let cold = newton::default_start(equations, &batch.state.file, lane);
            for (position, &node) in equations.unknowns.iter().enumerate() {
                let guess = match start {
                    Start::Default => cold,
                    Start::Temperatures(given) => given.get(node).copied().unwrap_or(cold),
                    Start::Current => batch.temperatures[node][lane],
                };
                let usable = guess.is_finite() && guess > 0.0;
                batch.state.file[first + position].set_lane(lane, if usable { guess } else { cold });
            }
        }
        for lane in 0..N {
            // What a lane by itself would refuse is left to it, with its reason.
            let possible = equations.check_given(&batch.state.file, lane, &self.nodes).is_ok();
            batch.status[lane] = if possible { LaneStatus::Running } else { LaneStatus::Lost };
        }
        if let Some(linear) = &mut batch.linear {
            newton::solve(equations, &mut batch.state, linear, &[], &mut batch.status, &mut batch.last_step);
        }
        for lane in 0..N {
            match batch.status[lane] {
                LaneStatus::Converged(iterations) => {
                    // A lane that was lost still needs where it began.
                    for (position, &node) in equations.unknowns.iter().enumerate() {
                        batch.temperatures[node][lane] = batch.state.file[first + position][lane];
                    }
                    batch.outcomes[lane] = Ok(SteadyStats {
                        iterations,
                        factorisations: iterations,
                        residual_evaluations: iterations + 1,
                    });
                }
                LaneStatus::Running | LaneStatus::Lost => self.solve_alone(batch, lane, start),
            }
        }
        equations.program.run(segment::QUANTITY, &mut batch.state.file);
    }

    /// Solves a lane in its own workspace, where derivatives find it; its temperatures and quantities go to the batch.
    fn solve_own<const N: usize>(&self, batch: &mut Batch<N>, lane: usize, start: Start<'_>) {
        let equations = &self.steady;
        while batch.own.len() <= lane {
            batch.own.push(self.workspace());
        }
        let own = &mut batch.own[lane];
        let (parameters, inputs) = (0..equations.parameters, equations.parameters..equations.time());
        // What follows from parameters that did not change since the lane's last solve is not computed again.
        own.stale_parameters |= copied(&mut own.state.file[parameters.clone()], &batch.state.file[parameters], lane);
        copied(&mut own.state.file[inputs.clone()], &batch.state.file[inputs], lane);
        // The boundaries, too, are filled in anew.
        own.stale_inputs = true;
        if let Start::Current = start {
            for (slot, lanes) in own.temperatures.iter_mut().zip(&batch.temperatures) {
                *slot = lanes[lane];
            }
        }
        batch.outcomes[lane] = self.solve_steady(own, start);
        for (lanes, &value) in batch.temperatures.iter_mut().zip(&own.temperatures) {
            lanes[lane] = value;
        }
        for register in &equations.quantity {
            batch.state.file[register.index()][lane] = own.state.file[register.index()];
        }
    }

    /// Solves one lane by itself and puts the result back.
    fn solve_alone<const N: usize>(&self, batch: &mut Batch<N>, lane: usize, start: Start<'_>) {
        let equations = &self.steady;
        let given = equations.time();
        for (slot, lanes) in batch.alone.state.file[..given].iter_mut().zip(&batch.state.file) {
            *slot = lanes[lane];
        }
        batch.alone.stale_parameters = true;
        batch.alone.stale_inputs = true;
        if let Start::Current = start {
            for (slot, lanes) in batch.alone.temperatures.iter_mut().zip(&batch.temperatures) {
                *slot = lanes[lane];
            }
        }
        batch.outcomes[lane] = self.solve_steady(&mut batch.alone, start);
        for (lanes, &value) in batch.temperatures.iter_mut().zip(&batch.alone.temperatures) {
            lanes[lane] = value;
        }
        for place in 0..batch.state.file.len() {
            batch.state.file[place][lane] = batch.alone.state.file[place];
        }
    }
}

/// Copies the values of a lane; whether any of them is another.
fn copied<const N: usize>(own: &mut [f64], lanes: &[[f64; N]], lane: usize) -> bool {
    let mut changed = false;
    for (slot, lanes) in own.iter_mut().zip(lanes) {
        changed |= slot.to_bits() != lanes[lane].to_bits();
        *slot = lanes[lane];
    }
    changed
}
