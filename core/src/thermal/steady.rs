//! Steady temperatures of a network: every balance `r_i(T) = 0`.
//!
//! Plain Newton steps first ([`super::newton`]); where they fail, pseudo-transient continuation from the default start
//! (Kelley & Keyes 1998, SIAM J. Numer. Anal. 35, 508: the diagonal is weighted, the weight falls with the residual).

use thiserror::Error;

use crate::watch;

use super::equations::segment;
use super::external::Fault;
use super::network::{Network, Workspace};
use super::newton::{self, LaneStatus, SteadyStats};

/// Iterations of the continuation.
const CONTINUATION_ITERATIONS: u32 = 2000;

/// Where a solve starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start<'a> {
    /// From one temperature chosen from the boundaries.
    Default,
    /// From these temperatures of all nodes, K (boundaries' entries are ignored).
    Temperatures(&'a [f64]),
    /// From what the workspace holds from its last solve.
    Current,
}

/// A steady state that was not found.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SteadyError {
    /// Nodes without a path to a boundary.
    #[error("no path to a boundary from {}: their steady temperatures are undetermined", quoted(nodes))]
    Isolated {
        /// The nodes' names.
        nodes: Vec<String>,
    },
    /// Balances that do not close.
    #[error(
        "no steady state found after {iterations} iterations: node `{node}` is out of balance by {imbalance_w:e} W"
    )]
    NotConverged {
        /// The worst node.
        node: String,
        /// Its imbalance, W.
        imbalance_w: f64,
        /// Newton steps taken.
        iterations: u32,
    },
    /// A number that is not finite.
    #[error("`{element}` gives a heat that is not a finite number at {}", listed(temperatures))]
    NotFinite {
        /// The element or boundary.
        element: String,
        /// Node names and temperatures, K.
        temperatures: Vec<(String, f64)>,
    },
    /// A boundary below absolute zero, or without a temperature.
    #[error("boundary node `{node}` is given {temperature_k} K: a temperature is 0 K or above")]
    Boundary {
        /// The node.
        node: String,
        /// What it is given, K.
        temperature_k: f64,
    },
    /// A thermostat whose `off` is not above its `on`, or a proportional heater without a band.
    #[error("the band of heater `{element}` is {band_k} K wide: it must be above 0 K")]
    Band {
        /// The element.
        element: String,
        /// Its width, K.
        band_k: f64,
    },
    /// A conductance, exchange area or the like below 0, or 0 where that is too small.
    #[error("the {what} of `{element}` is {}: it must be {}", with_unit(*value, unit), bound(*above_zero))]
    Sign {
        /// The element.
        element: String,
        /// What it is.
        what: &'static str,
        /// Its SI unit.
        unit: &'static str,
        /// The value, SI.
        value: f64,
        /// Whether 0 is too small.
        above_zero: bool,
    },
    /// What answers for the model gave no outputs.
    #[error(transparent)]
    External(#[from] Fault),
    /// The matrix of slopes is singular.
    #[error("the balances do not determine the temperatures (node `{node}`): a conductance may be zero")]
    Singular {
        /// A node involved.
        node: String,
    },
}

fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn with_unit(value: f64, unit: &str) -> String {
    format!("{value} {unit}").trim_end().to_owned()
}

fn bound(above_zero: bool) -> &'static str {
    if above_zero { "above 0" } else { "0 or more" }
}

fn listed(temperatures: &[(String, f64)]) -> String {
    let shown: Vec<String> = temperatures.iter().map(|(name, kelvin)| format!("`{name}` {kelvin} K")).collect();
    if shown.is_empty() { "the given inputs".to_owned() } else { shown.join(", ") }
}

impl Network {
    /// Solves for the steady temperatures with the workspace's parameters and inputs. No memory is allocated unless
    /// the solve fails.
    ///
    /// # Errors
    /// [`SteadyError`] names the node or element that is at fault.
    pub fn solve_steady(&self, workspace: &mut Workspace, start: Start<'_>) -> Result<SteadyStats, SteadyError> {
        if let Some(nodes) = self.isolated_nodes() {
            return Err(SteadyError::Isolated { nodes: nodes.to_vec() });
        }
        if let Some(external) = &self.external {
            self.ask(external, workspace)?;
        }
        workspace.held.clear();
        self.solve_from(workspace, start)
    }

    /// Solves for the temperatures that balance some nodes while those of the others are held, with the workspace's
    /// parameters and inputs: `temperatures` of all nodes, K (first guesses where not held), `held` by node. Nodes beyond
    /// the end of `held` are balanced; boundaries have their own temperatures. Derivatives of the result are with the
    /// held temperatures constant.
    ///
    /// # Errors
    /// [`SteadyError`] names the node or element that is at fault.
    pub fn solve_held(
        &self,
        workspace: &mut Workspace,
        temperatures: &[f64],
        held: &[bool],
    ) -> Result<SteadyStats, SteadyError> {
        workspace.held.clear();
        workspace.held.extend(self.steady.unknowns.iter().map(|&node| newton::is_held(held, node)));
        self.solve_from(workspace, Start::Temperatures(temperatures))
    }

    /// Newton's method from a start, then the continuation.
    fn solve_from(&self, workspace: &mut Workspace, start: Start<'_>) -> Result<SteadyStats, SteadyError> {
        self.refresh(workspace);
        let equations = &self.steady;
        workspace.solved = false;
        equations.check_given(&workspace.state.file, 0, &self.nodes)?;
        let first = equations.temperatures().start;
        let cold = newton::default_start(equations, &workspace.state.file, 0);
        for (position, &node) in equations.unknowns.iter().enumerate() {
            let guess = match start {
                Start::Default => cold,
                Start::Temperatures(given) => given.get(node).copied().unwrap_or(cold),
                Start::Current => workspace.temperatures[node],
            };
            workspace.state.file[first + position] = if guess.is_finite() && guess > 0.0 { guess } else { cold };
        }
        workspace.solved = false;
        workspace.factored = false;
        let mut status = [LaneStatus::Running];
        let mut last_step = [0.0];
        let (state, linear) = (&mut workspace.state, &mut workspace.linear);
        let mut stats = newton::solve(equations, state, linear, &workspace.held, &mut status, &mut last_step);
        if matches!(status[0], LaneStatus::Lost) {
            self.continuation(workspace, cold, &mut stats)?;
        }
        self.store(workspace);
        Ok(stats)
    }

    /// Copies the solution out of the registers and evaluates the quantities.
    pub(super) fn store(&self, workspace: &mut Workspace) {
        let equations = &self.steady;
        let file = &mut workspace.state.file;
        for (position, &node) in equations.unknowns.iter().enumerate() {
            workspace.temperatures[node] = file[equations.temperatures().start + position];
        }
        equations.program.run(segment::QUANTITY, file);
        workspace.solved = true;
    }

    /// Pseudo-transient continuation: `(J + w diag J) dT = -r`, `w` from 1 towards 0 as the residual falls.
    fn continuation(&self, workspace: &mut Workspace, start: f64, stats: &mut SteadyStats) -> Result<(), SteadyError> {
        let equations = &self.steady;
        let state = &mut workspace.state;
        let held = &workspace.held;
        for (row, temperature) in state.file[equations.temperatures()].iter_mut().enumerate() {
            if !newton::is_held(held, row) {
                *temperature = start;
            }
        }
        let mut weight: f64 = 1.0;
        let mut last_size = f64::INFINITY;
        let mut last_step = f64::INFINITY;
        for _ in 0..CONTINUATION_ITERATIONS {
            watch::check();
            equations.program.run(segment::RESIDUAL, &mut state.file);
            stats.residual_evaluations += 1;
            if last_step <= 1e-4 && weight < 1e-6 && newton::closes(equations, &mut state.file, held) {
                return Ok(());
            }
            let balanced = equations.residual.iter().enumerate().filter(|(row, _)| !newton::is_held(held, *row));
            let size: f64 = balanced.map(|(_, r)| state.file[r.index()].abs()).sum();
            if !size.is_finite() {
                return Err(self.not_finite(workspace));
            }
            if last_size.is_finite() && last_size > 0.0 {
                weight = (weight * (size / last_size).clamp(0.1, 4.0)).min(1e3);
            }
            last_size = size;
            equations.program.run(segment::JACOBIAN, &mut state.file);
            workspace.linear.load(equations, &state.file);
            for row in 0..equations.size() {
                let diagonal = workspace.linear.diagonal(row);
                workspace.linear.add_to_diagonal(row, -weight * diagonal.abs());
            }
            newton::hold(&mut workspace.linear, held);
            workspace.linear.factor();
            for (row, (step, register)) in state.step.iter_mut().zip(&equations.residual).enumerate() {
                *step = if newton::is_held(held, row) { 0.0 } else { -state.file[register.index()] };
            }
            workspace.linear.solve(&mut state.step);
            stats.iterations += 1;
            stats.factorisations += 1;
            last_step = newton::advance(equations, state);
            if last_step.is_nan() {
                return Err(self.singular(workspace));
            }
        }
        let (node, imbalance_w) = self.worst(workspace);
        Err(SteadyError::NotConverged { node, imbalance_w, iterations: stats.iterations })
    }

    /// The node with the largest imbalance and that imbalance, W.
    fn worst(&self, workspace: &Workspace) -> (String, f64) {
        let mut worst = (String::new(), 0.0);
        for (row, (register, &node)) in self.steady.residual.iter().zip(&self.steady.unknowns).enumerate() {
            if newton::is_held(&workspace.held, row) {
                continue;
            }
            let imbalance: f64 = workspace.state.file[register.index()];
            if worst.0.is_empty() || imbalance.abs() > f64::abs(worst.1) {
                worst = (self.nodes[node].clone(), imbalance);
            }
        }
        worst
    }

    /// The node whose step is not finite, or the element behind it.
    fn singular(&self, workspace: &mut Workspace) -> SteadyError {
        let equations = &self.steady;
        let finite = equations.jacobian.iter().all(|e| workspace.state.file[e.register.index()].is_finite());
        if !finite {
            return self.not_finite(workspace);
        }
        let row = workspace.state.step.iter().position(|step| !step.is_finite()).unwrap_or(0);
        SteadyError::Singular { node: self.nodes[equations.unknowns[row]].clone() }
    }

    /// Names the first element whose heat or slope is not finite.
    fn not_finite(&self, workspace: &Workspace) -> SteadyError {
        let file = &workspace.state.file;
        self.steady.name_not_finite(file, &self.nodes).unwrap_or_else(|| {
            let (node, imbalance_w) = self.worst(workspace);
            SteadyError::NotConverged { node, imbalance_w, iterations: 0 }
        })
    }
}
