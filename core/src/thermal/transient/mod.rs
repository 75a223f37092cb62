//! Temperatures over time: stiff integration with error control, events, outputs and derivatives.
//!
//! `C_i(T_i, p, t) dT_i/dt = r_i(T, p, t)` at diffusion nodes, `r_i = 0` at arithmetic nodes, given temperatures at
//! boundaries. See [`tableau`] for the scheme, [`TransientOptions`] for the accuracy.

mod consistent;
mod events;
pub mod inputs;
mod integrator;
pub mod linearised;
mod output;
mod periodic;
mod sensitivity;
mod stages;
pub mod tableau;

use thiserror::Error;

use super::steady::SteadyError;

pub use inputs::{InputColumn, InputTable};

/// How accurately and how far a transient is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransientOptions {
    /// Local error of a step allowed per kelvin of temperature.
    pub relative_tolerance: f64,
    /// Local error of a step allowed besides, K. The defaults keep the error at outputs near 1 mK.
    pub absolute_tolerance_k: f64,
    /// Share of the allowed error to which the equations of a stage are solved.
    pub newton_share: f64,
    /// First step, s; chosen from the initial slopes if `None`.
    pub first_step_s: Option<f64>,
    /// Longest step, s.
    pub longest_step_s: f64,
    /// Constant steps of this length, s, without error control (for studies of convergence).
    pub fixed_step_s: Option<f64>,
    /// Steps, rejected ones among them, after which the integration gives up; and sooner, where a tenth of them shows that
    /// it would not come to the end.
    pub most_steps: u64,
    /// Derivatives to a few per cent, by a step of second order in place of one that differentiates every stage.
    pub coarse_derivatives: bool,
}

impl Default for TransientOptions {
    fn default() -> Self {
        Self {
            relative_tolerance: 3e-7,
            absolute_tolerance_k: 3e-5,
            newton_share: 0.02,
            first_step_s: None,
            longest_step_s: f64::INFINITY,
            fixed_step_s: None,
            most_steps: 10_000_000,
            coarse_derivatives: false,
        }
    }
}

/// How a transient begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InitialState<'a> {
    /// At these temperatures of all nodes, K; boundaries' entries are ignored, arithmetic nodes' are first guesses.
    Temperatures(&'a [f64]),
    /// In the steady state of the inputs at the start.
    Steady,
    /// In the periodic state of the inputs' cycle, which lasts from the table's first to its last instant.
    Periodic,
}

/// What is asked of a transient.
#[derive(Clone, Copy, Debug)]
pub struct TransientRequest<'a> {
    /// Parameters, SI.
    pub parameters: &'a [f64],
    /// Inputs over time.
    pub inputs: &'a InputTable,
    /// How it begins.
    pub initial: InitialState<'a>,
    /// Directions of further derivatives: change of all nodes' start temperatures per unit of a value that is fitted.
    /// Used with [`InitialState::Temperatures`].
    pub seeds: &'a [Vec<f64>],
    /// Nodes that store heat and start in balance with the others, as arithmetic nodes do; their temperatures are first
    /// guesses. Used with [`InitialState::Temperatures`].
    pub balanced: &'a [usize],
    /// Start, s; the table's first instant (0 for an empty table) if `None`.
    pub start_s: Option<f64>,
    /// Instants at which temperatures and quantities are wanted, s, ascending, none before the start.
    pub outputs_s: &'a [f64],
    /// End, s, where it lies beyond the last output.
    pub end_s: Option<f64>,
    /// Whether derivatives are wanted.
    pub sensitivities: bool,
    /// Whether the temperatures of all nodes at the outputs, and their derivatives, are wanted beside the quantities.
    pub temperatures: bool,
    /// Accuracy.
    pub options: TransientOptions,
}

impl<'a> TransientRequest<'a> {
    /// A request without derivatives at default accuracy.
    pub fn new(parameters: &'a [f64], inputs: &'a InputTable, initial: InitialState<'a>, outputs_s: &'a [f64]) -> Self {
        Self {
            parameters,
            inputs,
            initial,
            seeds: &[],
            balanced: &[],
            start_s: None,
            outputs_s,
            end_s: None,
            sensitivities: false,
            temperatures: true,
            options: TransientOptions::default(),
        }
    }
}

/// Work of a transient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TransientStats {
    /// Steps accepted.
    pub steps: u64,
    /// Steps rejected for their error.
    pub rejected: u64,
    /// Steps rejected because a stage's equations were not solved.
    pub unsolved: u64,
    /// Evaluations of the slopes of the balances.
    pub jacobians: u64,
    /// Factorisations.
    pub factorisations: u64,
    /// Solutions of a linear system.
    pub solves: u64,
    /// Evaluations of the balances.
    pub residual_evaluations: u64,
    /// Switchings of thermostats.
    pub events: u64,
}

impl TransientStats {
    /// Steps tried.
    pub fn attempts(&self) -> u64 {
        self.steps + self.rejected + self.unsolved
    }
}

/// A thermostat that switched.
#[derive(Clone, Debug, PartialEq)]
pub struct SwitchEvent {
    /// Instant, s.
    pub time_s: f64,
    /// Name of the element.
    pub element: String,
    /// Whether it went on.
    pub on: bool,
}

/// A transient solution at the instants asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transient {
    /// Temperatures, `outputs x nodes`, K; empty where they were not wanted.
    pub temperatures: Vec<f64>,
    /// Quantities at the instants, `outputs x quantities`, SI.
    pub quantities: Vec<f64>,
    /// For each quantity that is a maximum, minimum or mean over time its value from start to end.
    pub over_time: Vec<Option<f64>>,
    /// Derivatives of the temperatures, `outputs x nodes x columns`: the differentiated symbols, then the seeds.
    pub temperature_tangent: Vec<f64>,
    /// Derivatives of the quantities, `outputs x quantities x columns`.
    pub quantity_tangent: Vec<f64>,
    /// Derivatives of `over_time`, `quantities x columns` (0 where there is none).
    pub over_time_tangent: Vec<f64>,
    /// Temperatures of all nodes at the start, K.
    pub start: Vec<f64>,
    /// Temperatures of all nodes at the end, K.
    pub end: Vec<f64>,
    /// Ends of the accepted steps, s.
    pub step_ends_s: Vec<f64>,
    /// Switchings in order.
    pub events: Vec<SwitchEvent>,
    /// Work.
    pub stats: TransientStats,
}

/// A transient that was not found.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TransientError {
    /// The steady state at the start, or balances without storage, were not solved.
    #[error(transparent)]
    Steady(#[from] SteadyError),
    /// A capacity that is not positive.
    #[error("node `{node}`: heat capacity {capacity} J/K at {time_s} s is not above 0")]
    Capacity {
        /// The node.
        node: String,
        /// The capacity, J/K.
        capacity: f64,
        /// Instant, s.
        time_s: f64,
    },
    /// The step became too short.
    #[error("the integration stops at {time_s} s: no step is short enough (node `{node}` changes fastest)")]
    StepTooShort {
        /// Instant, s.
        time_s: f64,
        /// The node whose error is largest.
        node: String,
    },
    /// Too many steps.
    #[error(
        "the integration stops at {time_s} s after {steps} steps: it would not come to its end within the steps allowed"
    )]
    TooManySteps {
        /// Instant, s.
        time_s: f64,
        /// Steps taken.
        steps: u64,
    },
    /// A thermostat that switches far too often for the time that is asked for.
    #[error(
        "thermostat `{element}` switches without end: {switchings} times by {time_s:.3e} s, which would be {expected:.1e} times \
         by {end_s} s, and {most} are allowed; its band of {band_k:.1e} K is too narrow: write one of {wider_k:.0e} K or \
         more, or a `proportional` heater, which does not cycle"
    )]
    Cycling {
        /// The element.
        element: String,
        /// How often it has switched.
        switchings: u64,
        /// Instant, s.
        time_s: f64,
        /// How often it would switch to the end.
        expected: f64,
        /// End, s.
        end_s: f64,
        /// How often it may.
        most: u64,
        /// `off` minus `on`, K.
        band_k: f64,
        /// A band with which it would switch seldom enough, K.
        wider_k: f64,
    },
    /// A thermostat whose `off` is not above its `on`.
    #[error(
        "thermostat `{element}`: its `off` temperature must lie above its `on` temperature (difference {band_k} K)"
    )]
    NoHysteresis {
        /// The element.
        element: String,
        /// `off` minus `on`, K.
        band_k: f64,
    },
    /// Outputs out of order, or a table that does not fit.
    #[error("{what}: {value}")]
    Request {
        /// What is wrong.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// The cycle was not closed.
    #[error("no periodic state found after {orbits} cycles: node `{node}` still changes by {change_k:e} K a cycle")]
    NotPeriodic {
        /// Cycles integrated.
        orbits: u64,
        /// The node that changes most.
        node: String,
        /// Change of a cycle, K.
        change_k: f64,
    },
}
