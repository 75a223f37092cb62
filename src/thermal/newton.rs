//! Newton's method for the balances, one network or several lanes of it at a time.
//!
//! `J dT = -r` with exact slopes, the step shortened so that no temperature moves by more than a limit, temperatures
//! kept positive. A lane is done when every node closes to [`CLOSURE_W`] plus [`CLOSURE_RELATIVE`] of the sum of its
//! terms' sizes and the last step was below [`LAST_STEP_K`] (Newton's error after such a step is its square, so the
//! start leaves no trace in the result). A lane that is done or lost is frozen: it keeps the bits it would have alone.

use crate::expression::Lanes;

use super::equations::{Equations, segment};
use super::linear::Linear;
use super::network::State;

/// Absolute closure of a node's balance, W.
pub const CLOSURE_W: f64 = 1e-9;
/// Closure relative to the sum of the sizes of a node's terms.
pub const CLOSURE_RELATIVE: f64 = 1e-13;
/// Largest last step, K.
const LAST_STEP_K: f64 = 1e-4;
/// Above this imbalance the sizes of the terms cannot matter (they would be above 1e9 W).
const SIZE_MATTERS_BELOW_W: f64 = 1e-4;
/// Longest step of a temperature: this many K plus [`STEP_SHARE`] of it.
const STEP_K: f64 = 40.0;
const STEP_SHARE: f64 = 0.2;
/// A temperature falls to no less than this share of itself in a step.
const FLOOR_SHARE: f64 = 0.25;
/// Iterations before the plain method gives up.
const ITERATIONS: u32 = 60;

/// Where a lane stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LaneStatus {
    Running,
    Converged(u32),
    Lost,
}

/// Work of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SteadyStats {
    /// Newton steps.
    pub iterations: u32,
    /// Factorisations of the matrix of slopes.
    pub factorisations: u32,
    /// Evaluations of the balances.
    pub residual_evaluations: u32,
}

/// Whether every balance of a lane closes. Runs the sizes' segment once where they matter.
pub(super) fn closes<V: Lanes>(equations: &Equations, file: &mut [V], lane: usize, sizes_ready: &mut bool) -> bool {
    let mut worst: f64 = 0.0;
    for register in &equations.residual {
        let value = file[register.index()].lane(lane).abs();
        // Written so that a NaN counts as open.
        if !(value <= worst) {
            worst = value;
        }
    }
    if worst <= CLOSURE_W {
        return true;
    }
    if !(worst <= SIZE_MATTERS_BELOW_W) {
        return false;
    }
    if !*sizes_ready {
        equations.program.run(segment::MAGNITUDE, file);
        *sizes_ready = true;
    }
    equations.residual.iter().zip(&equations.magnitude).all(|(residual, size)| {
        let size = file[size.index()].lane(lane);
        file[residual.index()].lane(lane).abs() <= CLOSURE_W + CLOSURE_RELATIVE * size
    })
}

/// Moves a lane's temperatures by its step, shortened; returns the largest change in K, `None` if it is not finite.
pub(super) fn advance<V: Lanes>(equations: &Equations, state: &mut State<V>, lane: usize) -> Option<f64> {
    let temperatures = &mut state.file[equations.temperatures()];
    let mut excess: f64 = 1.0;
    for (temperature, step) in temperatures.iter().zip(&state.step) {
        let (temperature, step) = (temperature.lane(lane), step.lane(lane));
        if !step.is_finite() {
            return None;
        }
        excess = excess.max(step.abs() / (STEP_K + STEP_SHARE * temperature));
    }
    let mut largest: f64 = 0.0;
    for (temperature, step) in temperatures.iter_mut().zip(&state.step) {
        let old = temperature.lane(lane);
        let new = (old + step.lane(lane) / excess).max(FLOOR_SHARE * old);
        largest = largest.max((new - old).abs());
        temperature.set_lane(lane, new);
    }
    Some(largest)
}

/// Solves all running lanes from the temperatures in the file. Ends with the residual evaluated at the result.
pub(super) fn solve<V: Lanes>(
    equations: &Equations,
    state: &mut State<V>,
    linear: &mut Linear<V>,
    status: &mut [LaneStatus],
    last_step: &mut [f64],
) -> SteadyStats {
    let mut stats = SteadyStats::default();
    last_step.fill(f64::INFINITY);
    loop {
        equations.program.run(segment::RESIDUAL, &mut state.file);
        stats.residual_evaluations += 1;
        let mut running = false;
        let mut sizes_ready = false;
        for lane in 0..V::COUNT {
            if status[lane] != LaneStatus::Running {
                continue;
            }
            if last_step[lane] <= LAST_STEP_K && closes(equations, &mut state.file, lane, &mut sizes_ready) {
                status[lane] = LaneStatus::Converged(stats.iterations);
            } else if stats.iterations >= ITERATIONS {
                status[lane] = LaneStatus::Lost;
            } else {
                running = true;
            }
        }
        if !running {
            return stats;
        }
        equations.program.run(segment::JACOBIAN, &mut state.file);
        linear.load(equations, &state.file);
        linear.factor();
        for (step, register) in state.step.iter_mut().zip(&equations.residual) {
            *step = state.file[register.index()].map(|r| -r);
        }
        linear.solve(&mut state.step);
        stats.iterations += 1;
        stats.factorisations += 1;
        for lane in 0..V::COUNT {
            if status[lane] == LaneStatus::Running {
                match advance(equations, state, lane) {
                    Some(largest) => last_step[lane] = largest,
                    None => status[lane] = LaneStatus::Lost,
                }
            }
        }
    }
}

/// Temperature from which a solve starts that is given none: the boundaries' mean, not below 250 K, so that radiating
/// nodes come down to their solution from above, where the method converges monotonically.
pub(super) fn default_start<V: Lanes>(equations: &Equations, file: &[V], lane: usize) -> f64 {
    let mut total = 0.0;
    for &(_, register) in &equations.boundaries {
        total += file[register.index()].lane(lane);
    }
    let count = equations.boundaries.len();
    let mean = if count == 0 { 290.0 } else { total / count as f64 };
    if mean.is_finite() { mean.clamp(250.0, 2000.0) } else { 290.0 }
}
