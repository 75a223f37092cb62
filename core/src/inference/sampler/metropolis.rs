//! Adaptive Metropolis with delayed rejection over the unconstrained coordinates.
//!
//! Proposals are normal with `s_d (C + e I)`, `C` the covariance of the chain's history and `s_d = 2.4^2 / d` (Haario,
//! Saksman & Tamminen 2001); a rejected proposal is followed by a smaller one, whose acceptance keeps the balance
//! (Haario, Laine, Mira & Saksman 2006, equation for two stages):
//! `a2 = min(1, p(y2) q1(y2, y1) (1 - a1(y2, y1)) / (p(x) q1(x, y1) (1 - a1(x, y1))))`.
//!
//! The warm-up opens with a stretch that only scales an isotropic proposal, since the history must not begin where the
//! chain merely travels. Then the covariance of the history since that stretch is taken over at regular intervals until
//! the warm-up ends, or to the end of the chain with [`MetropolisSettings::adapt_throughout`], as in the paper. There are
//! no bounds in these coordinates, so that no proposal is lost at a bound.

use serde::{Deserialize, Serialize};

use crate::inference::posterior::{Density, Evaluator, Posterior};
use crate::inference::sampler::adaptation::RunningCovariance;
use crate::inference::sampler::chains::{Chain, SampleError, start_point};
use crate::inference::sampler::parts::Parts;
use crate::inference::target::Target;
use crate::math::cholesky;
use crate::math::functions::{exp, ln, ln_1p};
use crate::random::{Stream, StreamKey};
use crate::watch;

/// Settings of adaptive Metropolis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MetropolisSettings {
    /// Steps that adapt and are dropped.
    pub warm_up: u64,
    /// Draws kept.
    pub draws: u64,
    /// Steps from one draw kept to the next.
    pub thin: u64,
    /// Share of the warm-up that only scales the proposal, 0 to 1.
    pub opening: f64,
    /// Steps between two uses of the history's covariance.
    pub interval: u64,
    /// Share of the second proposal's standard deviation in the first's, above 0, at most 1; `None`: no second proposal.
    pub second_scale: Option<f64>,
    /// `e`, in squared spreads of the priors.
    pub regularisation: f64,
    /// Go on adapting after the warm-up.
    pub adapt_throughout: bool,
}

impl Default for MetropolisSettings {
    fn default() -> Self {
        Self {
            warm_up: 5000,
            draws: 5000,
            thin: 2,
            opening: 0.2,
            interval: 100,
            second_scale: Some(0.2),
            regularisation: 1e-10,
            adapt_throughout: false,
        }
    }
}

impl MetropolisSettings {
    fn check(&self) -> Result<(), SampleError> {
        let check = SampleError::check;
        check("draws", self.draws as f64, self.draws > 0, "1 or more")?;
        check("thin", self.thin as f64, self.thin > 0, "1 or more")?;
        check("interval", self.interval as f64, self.interval > 0, "1 or more")?;
        check("opening", self.opening, (0.0..=1.0).contains(&self.opening), "0 to 1")?;
        let regularisation = self.regularisation;
        check("regularisation", regularisation, regularisation > 0.0 && regularisation < 1.0, "above 0, below 1")?;
        match self.second_scale {
            Some(scale) => check("second_scale", scale, scale > 0.0 && scale <= 1.0, "above 0, at most 1"),
            None => Ok(()),
        }
    }
}

/// Runs one chain; `start` (SI) is tried first, then draws from the prior.
///
/// # Errors
/// [`SampleError`] for a prior without a map, settings out of range, or no point to start from.
pub fn sample<T: Target>(
    target: &T,
    settings: &MetropolisSettings,
    key: &StreamKey,
    chain: u64,
    start: Option<&[f64]>,
) -> Result<Chain, SampleError> {
    Parts::none(|parts| sample_in_parts(target, settings, key, chain, start, parts))
}

/// A chain on its way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MetropolisState {
    /// Steps done.
    steps: u64,
    /// Place in the chain's stream of random numbers.
    words: u64,
    coordinates: Vec<f64>,
    density: Density,
    /// Lower Cholesky factor of the proposal's covariance.
    factor: Vec<f64>,
    history: RunningCovariance,
    /// First proposals accepted before the opening last judged its scale.
    before: u64,
    /// First proposals, those accepted of them, second ones, those accepted of them.
    counts: [u64; 4],
    /// The draws so far, and the work.
    chain: Chain,
}

/// The same chain, which keeps its state on the way and goes on from one that was kept.
///
/// # Errors
/// As [`sample`].
pub fn sample_in_parts<T: Target>(
    target: &T,
    settings: &MetropolisSettings,
    key: &StreamKey,
    chain: u64,
    start: Option<&[f64]>,
    parts: &mut Parts<'_, MetropolisState>,
) -> Result<Chain, SampleError> {
    settings.check()?;
    let posterior = Posterior::new(target)?;
    let mut stream = key.stream(chain);
    let mut evaluator = posterior.evaluator();
    let dimension = posterior.dimension();
    let (mut walker, mut result, mut history, mut before, first);
    match parts.from.take() {
        Some(state) => {
            stream.seek(state.words);
            evaluator.work = state.chain.work.clone();
            walker = Walker::new(evaluator, stream, state.coordinates, state.density, settings.second_scale);
            walker.factor = state.factor;
            [walker.firsts, walker.first_accepted, walker.seconds, walker.second_accepted] = state.counts;
            (result, history, before, first) = (state.chain, state.history, state.before, state.steps);
        }
        None => {
            let start = start_point(&posterior, &mut evaluator, &mut stream, start, false)?;
            walker = Walker::new(evaluator, stream, start.coordinates, start.density, settings.second_scale);
            result = Chain::with_capacity(dimension, settings.draws as usize);
            history = RunningCovariance::new(dimension);
            (before, first) = (0, 0);
        }
    }
    let opening = (settings.opening * settings.warm_up as f64) as u64;
    let steps = settings.warm_up + settings.draws * settings.thin;
    for step in first..steps {
        watch::at(step, steps);
        if step == settings.warm_up {
            walker.forget_counts();
        }
        walker.advance();
        if step < opening {
            if (step + 1).is_multiple_of(OPENING_BATCH) {
                walker.rescale((walker.first_accepted - before) as f64 / OPENING_BATCH as f64);
                before = walker.first_accepted;
            }
        } else if step < settings.warm_up {
            history.add(&walker.coordinates);
            if (step + 1 - opening).is_multiple_of(settings.interval) {
                walker.learn(&history, settings.regularisation);
            }
        } else {
            let kept = step + 1 - settings.warm_up;
            if settings.adapt_throughout {
                history.add(&walker.coordinates);
                if kept.is_multiple_of(settings.interval) {
                    walker.learn(&history, settings.regularisation);
                }
            }
            if kept.is_multiple_of(settings.thin) {
                result.push(&posterior, &walker.coordinates, &walker.density);
            }
        }
        parts.at(step + 1, steps, || MetropolisState {
            steps: step + 1,
            words: walker.stream.position(),
            coordinates: walker.coordinates.clone(),
            density: walker.density,
            factor: walker.factor.clone(),
            history: history.clone(),
            before,
            counts: [walker.firsts, walker.first_accepted, walker.seconds, walker.second_accepted],
            chain: Chain { work: walker.evaluator.work.clone(), ..result.clone() },
        });
    }
    result.moves.acceptance = walker.first_accepted as f64 / walker.firsts.max(1) as f64;
    result.moves.second_acceptance =
        (walker.seconds > 0).then(|| walker.second_accepted as f64 / walker.seconds as f64);
    result.work = walker.evaluator.work.clone();
    Ok(result)
}

/// Steps after which the opening judges its scale.
const OPENING_BATCH: u64 = 25;

struct Walker<'a, T: Target> {
    evaluator: Evaluator<'a, T>,
    stream: Stream,
    coordinates: Vec<f64>,
    density: Density,
    /// Lower Cholesky factor of the proposal's covariance.
    factor: Vec<f64>,
    second_scale: Option<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    first_normals: Vec<f64>,
    second_normals: Vec<f64>,
    move_by: Vec<f64>,
    firsts: u64,
    first_accepted: u64,
    seconds: u64,
    second_accepted: u64,
}

impl<'a, T: Target> Walker<'a, T> {
    fn new(
        evaluator: Evaluator<'a, T>,
        stream: Stream,
        coordinates: Vec<f64>,
        density: Density,
        second_scale: Option<f64>,
    ) -> Self {
        let n = coordinates.len();
        let mut factor = vec![0.0; n * n];
        for i in 0..n {
            factor[i * n + i] = 2.4 / (n as f64).sqrt();
        }
        let zeros = || vec![0.0; n];
        Self {
            evaluator,
            stream,
            density,
            factor,
            second_scale,
            first: zeros(),
            second: zeros(),
            first_normals: zeros(),
            second_normals: zeros(),
            move_by: zeros(),
            coordinates,
            firsts: 0,
            first_accepted: 0,
            seconds: 0,
            second_accepted: 0,
        }
    }

    fn forget_counts(&mut self) {
        (self.firsts, self.first_accepted, self.seconds, self.second_accepted) = (0, 0, 0, 0);
    }

    /// Widens or narrows the isotropic proposal of the opening towards an acceptance between 0.15 and 0.5.
    fn rescale(&mut self, acceptance: f64) {
        let change = if acceptance < 0.05 {
            0.3
        } else if acceptance < 0.15 {
            0.7
        } else if acceptance > 0.5 {
            1.5
        } else {
            1.0
        };
        for value in &mut self.factor {
            *value *= change;
        }
    }

    /// Takes over the covariance of the history, unless it has no factor.
    fn learn(&mut self, history: &RunningCovariance, regularisation: f64) {
        let n = self.coordinates.len();
        if history.count() < 2 * n as u64 + 2 {
            return;
        }
        let mut covariance = vec![0.0; n * n];
        history.covariance(&mut covariance);
        let scale = 2.4 * 2.4 / n as f64;
        for i in 0..n {
            covariance[i * n + i] += regularisation;
        }
        for value in &mut covariance {
            *value *= scale;
        }
        if cholesky::factor(&mut covariance, n).is_ok() {
            self.factor = covariance;
        }
    }

    /// One step: a proposal and, where it is rejected, perhaps a second.
    fn advance(&mut self) {
        self.firsts += 1;
        for value in &mut self.first_normals {
            *value = self.stream.normal();
        }
        cholesky::multiply(&self.factor, &self.first_normals, &mut self.move_by);
        for i in 0..self.first.len() {
            self.first[i] = self.coordinates[i] + self.move_by[i];
        }
        let first = self.evaluator.density(&self.first);
        let here = self.density.total();
        let first_gain = first.map_or(f64::NEG_INFINITY, |density| density.total() - here);
        if ln(self.stream.uniform()) < first_gain
            && let Some(density) = first
        {
            self.first_accepted += 1;
            self.density = density;
            std::mem::swap(&mut self.coordinates, &mut self.first);
            return;
        }
        let Some(scale) = self.second_scale else { return };
        self.seconds += 1;
        for value in &mut self.second_normals {
            *value = self.stream.normal();
        }
        cholesky::multiply(&self.factor, &self.second_normals, &mut self.move_by);
        for i in 0..self.second.len() {
            self.second[i] = self.coordinates[i] + scale * self.move_by[i];
        }
        let chance = self.stream.uniform();
        let Some(density) = self.evaluator.density(&self.second) else { return };
        let log_ratio =
            second_log_ratio(density.total() - here, first_gain, &self.first_normals, &self.second_normals, scale);
        if ln(chance) < log_ratio {
            self.second_accepted += 1;
            self.density = density;
            std::mem::swap(&mut self.coordinates, &mut self.second);
        }
    }
}

/// Log acceptance ratio of the second proposal. `second_gain` and `first_gain`: log densities of the proposals less that
/// of the state, the latter below 0 since it was rejected. With the same factor at both points, the distance from the
/// second proposal to the first is that of the normals.
fn second_log_ratio(second_gain: f64, first_gain: f64, first: &[f64], second: &[f64], scale: f64) -> f64 {
    let back_gain = first_gain - second_gain;
    if back_gain >= 0.0 {
        // From the second proposal the first would surely have been accepted: no way back.
        return f64::NEG_INFINITY;
    }
    let (mut there, mut back) = (0.0, 0.0);
    for (u, v) in first.iter().zip(second) {
        there += u * u;
        let w = u - scale * v;
        back += w * w;
    }
    second_gain - 0.5 * (back - there) + ln_1p(-exp(back_gain)) - ln_1p(-exp(first_gain))
}
