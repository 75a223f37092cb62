//! Fitted sets of which each adds an effect to another: what that effect gains, and which goes first.

use crate::diagnosis::engine::State;
use crate::diagnosis::story::plainness::{Drivers, Plainness};
use crate::diagnosis::story::rules::{AskedOfUnseen, Gain, explains_on_both, pays_by, rises, serves_as_well};
use crate::diagnosis::{Problem, Refit};

/// What the sets of a state weigh, in logarithms: posterior weights with what unseen rows say, for which it stands, and evidences.
pub(super) struct Logs {
    pub weights: Vec<f64>,
    pub evidences: Vec<f64>,
    /// What drives the candidates.
    pub drivers: Drivers,
}

impl std::ops::Deref for Logs {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.weights
    }
}

/// The errors of two sets on unseen rows.
pub(super) fn unseen(before: &Refit, after: &Refit) -> [Option<f64>; 2] {
    [before.rmse_held_out_k, after.rmse_held_out_k]
}

/// The effect that a set adds to another; `None` where it does not hold the other and one effect more.
pub(crate) fn added(state: &State, at: usize, place: usize) -> Option<usize> {
    let (own, effects) = (&state.refits[at].effects, &state.refits[place].effects);
    let is_next = effects.len() == own.len() + 1 && own.iter().all(|one| effects.contains(one));
    effects.iter().find(|effect| is_next && !own.contains(effect)).copied()
}

/// Whether the effect that a set adds to another is larger than plausible.
pub(super) fn is_implausible(state: &State, at: usize, place: usize) -> bool {
    added(state, at, place).is_some_and(|effect| state.refits[place].is_implausible(effect))
}

/// Whether the prior of an effect of a set is as wide as the catalogue's.
pub(super) fn is_as_written(state: &State, effect: usize, place: usize) -> bool {
    state.refits[place].widths().get(&effect).is_some_and(|&width| width <= 1.0)
}

/// Whether what a set adds to another explains half of the errors on the fitted and on the unseen rows.
pub(crate) fn explains_half(state: &State, at: usize, place: usize) -> bool {
    let [before, after] = [at, place].map(|place| &state.refits[place]);
    explains_on_both([before.rmse_train_k, after.rmse_train_k], unseen(before, after))
}

/// The set of most log weight among some that each add an effect to another. One that fails on the unseen rows comes last where another
/// explains half of the errors on both.
pub(super) fn first_by_weight(
    state: &State,
    weight: impl Fn(usize) -> f64,
    at: usize,
    places: &[usize],
) -> Option<usize> {
    let fails = |place: usize| rises(unseen(&state.refits[at], &state.refits[place]));
    let has_half = places.iter().any(|&place| explains_half(state, at, place));
    let rank = |place: usize| (!(has_half && fails(place)), weight(place));
    places.iter().copied().reduce(|a, b| if rank(b) > rank(a) { b } else { a })
}

/// Whether a plain effect goes before another, each by a set that adds it to a third. One of plausible size goes before one of a hundred
/// times that: it explains nearly as much, and predicts unseen rows no worse; or explains most of it, predicts them better, and is
/// not clearly less probable. A plainer law goes before another where it explains nearly as much on fitted and unseen rows
/// ([`Plainness`]).
pub(super) fn goes_before(
    problem: &Problem,
    state: &State,
    logs: &Logs,
    at: usize,
    plain: usize,
    other: usize,
) -> bool {
    let sets = [at, plain, other].map(|place| &state.refits[place]);
    if is_implausible(state, at, other) && !is_implausible(state, at, plain) {
        let squares = sets.map(|refit| refit.residuals.iter().map(|error| error * error).sum());
        if serves_as_well(squares, unseen(sets[2], sets[1]), logs[other] - logs[plain]) {
            return true;
        }
    }
    why_plainer(problem, state, &logs.drivers, at, [plain, other]).is_some()
}

/// Why the effect that a set adds to another goes before that of a third set, where it is plainer, of plausible size, and explains
/// nearly as much.
pub(crate) fn why_plainer(
    problem: &Problem,
    state: &State,
    drivers: &Drivers,
    at: usize,
    [plain, other]: [usize; 2],
) -> Option<Plainness> {
    if is_implausible(state, at, plain) {
        return None;
    }
    let own = added(state, at, plain)?;
    let why = drivers.plainness(problem, own, added(state, at, other)?)?;
    // Heat that cools is not what was logged.
    if why.is_of_logged_heat() && !state.refits[plain].is_positive(own) {
        return None;
    }
    let sets = [at, plain, other].map(|place| &state.refits[place]);
    let (fitted, unseen) = (sets.map(|refit| refit.rmse_train_k), sets.map(|refit| refit.rmse_held_out_k));
    why.goes_before(fitted, unseen).then_some(why)
}

/// What a set gains over another, by the log posterior weights and the log evidences of all sets.
pub(super) fn gain(state: &State, [weights, evidences]: [&[f64]; 2], at: usize, place: usize) -> Gain {
    Gain {
        log_odds: weights[place] - weights[at],
        fitted: evidences[place] - evidences[at],
        unseen: unseen(&state.refits[at], &state.refits[place]),
    }
}

/// Whether a set that adds an effect to another is more probable, and neither unseen nor fitted rows speak against it.
pub(super) fn pays(state: &State, logs: &Logs, at: usize, place: usize, asked: AskedOfUnseen) -> bool {
    pays_by(gain(state, [logs, &logs.evidences], at, place), state.refits[at].effects.is_empty(), asked)
}
