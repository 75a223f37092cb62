//! Newton's method for the balances, one network or several lanes of it at a time.
//!
//! `J dT = -r` with exact slopes, the step shortened so that no temperature moves by more than a limit, temperatures
//! kept positive. A lane is done when every node closes to [`CLOSURE_W`] plus [`CLOSURE_RELATIVE`] of the sum of its
//! terms' sizes and the last step was below `LAST_STEP_K` (Newton's error after such a step is its square, so the
//! start leaves no trace in the result). A lane that is done or lost is frozen: it keeps the bits it would have alone.
//!
//! Where factors are costly they serve further steps as long as these shrink fast (the chord method; Ortega & Rheinboldt
//! 1970, 7.1). Such steps end when what is left, the last one times the ratio of the last two, is as small.

use crate::math::lanes::Lanes;
use crate::watch;

use super::equations::{Equations, segment};
use super::linear::Linear;
use super::network::State;

/// Absolute closure of a node's balance, W.
pub const CLOSURE_W: f64 = 1e-9;
/// Closure relative to the sum of the sizes of a node's terms.
pub const CLOSURE_RELATIVE: f64 = 1e-13;
/// Largest last step, K.
const LAST_STEP_K: f64 = 1e-4;
/// Steps with the factors of an earlier one: the largest step before the first, K, and the largest ratio of two.
const CHORD_BELOW_K: f64 = 20.0;
const CHORD_RATIO: f64 = 0.3;
/// Error left at the end of such steps, K: the square of [`LAST_STEP_K`] over the kelvins in which a radiative slope changes.
const CHORD_ERROR_K: f64 = 1e-10;
/// Above this imbalance the sizes of the terms cannot matter (they would be above 1e9 W).
const SIZE_MATTERS_BELOW_W: f64 = 1e-4;
/// Longest step of a temperature: this many K plus [`STEP_SHARE`] of it.
const STEP_K: f64 = 40.0;
const STEP_SHARE: f64 = 0.2;
/// A temperature falls to no less than this share of itself in a step.
const FLOOR_SHARE: f64 = 0.25;
/// Iterations before the plain method gives up.
const ITERATIONS: u32 = 60;

/// Diagonal that holds a temperature where it is, W/K: beyond any conductance, far from overflow.
pub(super) const HOLD_W_PER_K: f64 = 1e30;

/// Whether the temperature of a row is held; an empty list holds none.
pub(super) fn is_held(held: &[bool], row: usize) -> bool {
    held.get(row).copied().unwrap_or(false)
}

/// Where a lane stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LaneStatus {
    Running,
    Converged(u32),
    Lost,
}

/// Which factors the last step had and how it compared with the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Factors {
    /// Of the slopes where the step began.
    Own,
    /// Of an earlier point; the step was this share of the one before.
    Earlier { ratio: f64 },
}

impl Factors {
    /// Whether the error after a step of a length, K, is small.
    fn suffice(self, step_k: f64) -> bool {
        match self {
            Self::Own => step_k <= LAST_STEP_K,
            Self::Earlier { ratio } => step_k * ratio <= CHORD_ERROR_K,
        }
    }

    /// Whether they will do for the step after one of a length, K.
    fn serve_after(self, step_k: f64) -> bool {
        match self {
            Self::Own => step_k <= CHORD_BELOW_K,
            Self::Earlier { ratio } => ratio <= CHORD_RATIO,
        }
    }
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

/// The largest imbalance of each lane over the rows that are not held, W; not a number where a balance is none.
fn worst<V: Lanes>(equations: &Equations, file: &[V], held: &[bool]) -> V {
    let mut worst = V::splat(0.0);
    for (row, register) in equations.residual.iter().enumerate() {
        if is_held(held, row) {
            continue;
        }
        // A number that is none stays.
        let larger = |a: f64, b: f64| if b.abs() <= a || a.is_nan() { a } else { b.abs() };
        worst = worst.zip(file[register.index()], larger);
    }
    worst
}

/// Whether every balance of a lane closes, of which the largest is given. Runs the sizes' segment once where they
/// matter.
fn closes_with<V: Lanes>(
    equations: &Equations,
    file: &mut [V],
    held: &[bool],
    lane: usize,
    worst: f64,
    sizes_ready: &mut bool,
) -> bool {
    if worst <= CLOSURE_W {
        return true;
    }
    // Written so that no number counts as open.
    if !(worst <= SIZE_MATTERS_BELOW_W) {
        return false;
    }
    if !*sizes_ready {
        equations.program.run(segment::BALANCE_SCALE, file);
        *sizes_ready = true;
    }
    equations.residual.iter().zip(&equations.balance_scale).enumerate().all(|(row, (residual, size))| {
        let size = file[size.index()].lane(lane);
        is_held(held, row) || file[residual.index()].lane(lane).abs() <= CLOSURE_W + CLOSURE_RELATIVE * size
    })
}

/// Whether every balance of a single network closes, those of held temperatures apart.
pub(super) fn closes(equations: &Equations, file: &mut [f64], held: &[bool]) -> bool {
    let worst = worst(equations, file, held);
    closes_with(equations, file, held, 0, worst, &mut false)
}

/// Moves temperatures by their steps, shortened lane by lane; returns the largest change of each lane in K. A lane with
/// a step that is not finite does not move and has no number.
pub(super) fn advance<V: Lanes>(equations: &Equations, state: &mut State<V>) -> V {
    let temperatures = &mut state.file[equations.temperatures()];
    let (mut excess, mut finite) = (V::splat(1.0), V::splat(0.0));
    for (temperature, step) in temperatures.iter().zip(&state.step) {
        // Zero, or no number for a step that is infinite or none.
        finite = finite.zip(*step, |a, b| a + b * 0.0);
        let share = step.zip(*temperature, |step, temperature| step.abs() / (STEP_K + STEP_SHARE * temperature));
        excess = excess.zip(share, f64::max);
    }
    let mut largest = finite;
    let whole = (0..V::COUNT).all(|lane| finite.lane(lane) == 0.0);
    for (temperature, step) in temperatures.iter_mut().zip(&state.step) {
        let old = *temperature;
        let mut new = old.zip(step.zip(excess, |a, b| a / b), |a, b| a + b).zip(old, |a, b| a.max(FLOOR_SHARE * b));
        if !whole {
            for lane in (0..V::COUNT).filter(|&lane| finite.lane(lane) != 0.0) {
                new.set_lane(lane, old.lane(lane));
            }
        }
        // A lane without a number keeps none.
        largest = largest.zip(new.zip(old, |a, b| (a - b).abs()), |a, b| if b > a { b } else { a });
        *temperature = new;
    }
    largest
}

/// Solves all running lanes from the temperatures in the file, of which those of the held rows stay. Ends with the
/// residual evaluated at the result.
pub(super) fn solve<V: Lanes>(
    equations: &Equations,
    state: &mut State<V>,
    linear: &mut Linear<V>,
    held: &[bool],
    status: &mut [LaneStatus],
    last_step: &mut [f64],
) -> SteadyStats {
    let mut stats = SteadyStats::default();
    last_step.fill(f64::INFINITY);
    let keeps_factors = V::COUNT == 1 && linear.is_costly();
    let mut factors = Factors::Own;
    loop {
        watch::check();
        equations.program.run(segment::RESIDUAL, &mut state.file);
        stats.residual_evaluations += 1;
        let mut running = 0;
        let mut sizes_ready = false;
        let worst = worst(equations, &state.file, held);
        for lane in 0..V::COUNT {
            if status[lane] != LaneStatus::Running {
                continue;
            }
            if factors.suffice(last_step[lane])
                && closes_with(equations, &mut state.file, held, lane, worst.lane(lane), &mut sizes_ready)
            {
                status[lane] = LaneStatus::Converged(stats.iterations);
            } else if stats.iterations >= ITERATIONS {
                status[lane] = LaneStatus::Lost;
            } else {
                running += 1;
            }
        }
        if running == 0 {
            return stats;
        }
        let chord = keeps_factors && factors.serve_after(last_step[0]);
        if !chord {
            equations.program.run(segment::JACOBIAN, &mut state.file);
            linear.load(equations, &state.file);
            hold(linear, held);
            linear.factor();
            stats.factorisations += 1;
        }
        for (row, (step, register)) in state.step.iter_mut().zip(&equations.residual).enumerate() {
            *step = if is_held(held, row) { V::splat(0.0) } else { state.file[register.index()].map(|r| -r) };
        }
        linear.solve(&mut state.step);
        stats.iterations += 1;
        if running < V::COUNT {
            for lane in (0..V::COUNT).filter(|&lane| status[lane] != LaneStatus::Running) {
                state.step.iter_mut().for_each(|step| step.set_lane(lane, 0.0));
            }
        }
        let largest = advance(equations, state);
        factors = if chord { Factors::Earlier { ratio: largest.lane(0) / last_step[0] } } else { Factors::Own };
        for (lane, status) in status.iter_mut().enumerate() {
            if *status == LaneStatus::Running {
                last_step[lane] = largest.lane(lane);
                if last_step[lane].is_nan() {
                    *status = LaneStatus::Lost;
                }
            }
        }
    }
}

/// Holds the temperatures of some rows in a matrix that was loaded.
pub(super) fn hold<V: Lanes>(linear: &mut Linear<V>, held: &[bool]) {
    for row in (0..held.len()).filter(|&row| held[row]) {
        linear.add_to_diagonal(row, V::splat(-HOLD_W_PER_K));
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
