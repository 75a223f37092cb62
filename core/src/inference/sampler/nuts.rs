//! The No-U-Turn sampler.
//!
//! Trajectories double until they turn round (Hoffman & Gelman 2014); the next state is drawn from the trajectory with
//! the weights of its points, later halves preferred, and the turn is judged by the sum of the momenta (Betancourt 2017,
//! appendix A), also across the seam of two halves, so that trajectories that come round in one half are seen.
//! The step size follows dual averaging, the metric is learnt in doubling windows of the warm-up. Where a normal
//! approximation of the posterior is known, coordinates are sheared along it (`triangular_transport`).

use crate::math::dense::dot_in_order as dot;
use serde::{Deserialize, Serialize};

use crate::inference::posterior::{Density, Evaluator, Posterior};
use crate::inference::prior::triangular_transport::NormalApproximation;
use crate::inference::sampler::adaptation::{DualAveraging, RunningCovariance, Windows};
use crate::inference::sampler::chains::{Chain, SampleError, start_point};
use crate::inference::sampler::metric::Metric;
use crate::inference::sampler::parts::Parts;
use crate::inference::target::Target;
use crate::math::functions::{exp, ln, ln_1p};
use crate::random::{Stream, StreamKey};
use crate::watch;

/// Coordinates beyond this, in units of the priors' spreads, mean that a trajectory has run away.
const FAR: f64 = 1e3;
/// Greatest variance of a coordinate with which a metric begins.
const WIDEST: f64 = 4.0;

/// Settings of the No-U-Turn sampler.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NutsSettings {
    /// Transitions that adapt and are dropped.
    pub warm_up: u64,
    /// Draws kept.
    pub draws: u64,
    /// Mean acceptance probability aimed at, within 0 to 1.
    pub acceptance: f64,
    /// Greatest number of doublings of a trajectory, 1 to 20.
    pub greatest_depth: u32,
    /// Rise of the energy that counts as divergence.
    pub divergence_energy: f64,
    /// Greatest dimension for which the whole covariance is learnt; above it, variances only.
    pub dense_up_to: usize,
    /// What is known of the posterior: the coordinates are sheared along it, and the metric begins with its covariance and
    /// is shrunk towards that; parameters with variance 0 begin with the spread of the coordinates.
    pub normal: Option<NormalApproximation>,
}

impl Default for NutsSettings {
    fn default() -> Self {
        Self {
            warm_up: 500,
            draws: 1000,
            acceptance: 0.8,
            greatest_depth: 10,
            divergence_energy: 1000.0,
            dense_up_to: 50,
            normal: None,
        }
    }
}

impl NutsSettings {
    fn check(&self) -> Result<(), SampleError> {
        SampleError::check("draws", self.draws as f64, self.draws > 0, "1 or more")?;
        let acceptance = self.acceptance;
        SampleError::check("acceptance", acceptance, acceptance > 0.0 && acceptance < 1.0, "between 0 and 1")?;
        let depth = self.greatest_depth;
        SampleError::check("greatest_depth", f64::from(depth), (1..=20).contains(&depth), "1 to 20")?;
        let energy = self.divergence_energy;
        SampleError::check("divergence_energy", energy, energy > 0.0, "above 0")
    }
}

/// Runs one chain; `start` (SI) is tried first, then draws from the prior.
///
/// # Errors
/// [`SampleError`] for a prior without a map, settings out of range, or no point to start from.
pub fn sample<T: Target>(
    target: &T,
    settings: &NutsSettings,
    key: &StreamKey,
    chain: u64,
    start: Option<&[f64]>,
) -> Result<Chain, SampleError> {
    Parts::none(|parts| sample_in_parts(target, settings, key, chain, start, parts))
}

/// A chain on its way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NutsState {
    /// Transitions done.
    transitions: u64,
    /// Place in the chain's stream of random numbers.
    words: u64,
    sample: Point,
    metric: Metric,
    step: f64,
    averaging: DualAveraging,
    window: RunningCovariance,
    acceptance_sum: f64,
    /// The draws so far, and the work.
    chain: Chain,
}

/// The same chain, which keeps its state on the way and goes on from one that was kept.
///
/// # Errors
/// As [`sample`].
pub fn sample_in_parts<T: Target>(
    target: &T,
    settings: &NutsSettings,
    key: &StreamKey,
    chain: u64,
    start: Option<&[f64]>,
    parts: &mut Parts<'_, NutsState>,
) -> Result<Chain, SampleError> {
    settings.check()?;
    let dimension = target.dimension();
    let fits = |normal: &&NormalApproximation| {
        normal.mode.len() == dimension && normal.covariance.len() == dimension * dimension
    };
    let normal = settings.normal.as_ref().filter(fits);
    let posterior = normal.map_or_else(|| Posterior::new(target), |normal| Posterior::along(target, normal))?;
    let mut stream = key.stream(chain);
    let mut evaluator = posterior.evaluator();
    let from = parts.from.take();
    let current = match &from {
        Some(state) => state.sample.clone(),
        None => {
            let start = start_point(&posterior, &mut evaluator, &mut stream, start, true)?;
            Point { coordinates: start.coordinates, gradient: start.gradient, density: start.density }
        }
    };
    let dense = dimension <= settings.dense_up_to;
    let normal_metric = normal.and_then(|normal| Metric::of(&in_coordinates(normal, &posterior), dimension, dense));
    let mut sampler = Sampler {
        evaluator,
        stream,
        metric: normal_metric.clone().unwrap_or_else(|| Metric::unit(dimension, dense)),
        step: 1.0,
        divergence_energy: settings.divergence_energy,
        moving: current.clone(),
        momentum: vec![0.0; dimension],
        velocity: vec![0.0; dimension],
        energy_at_start: 0.0,
        leapfrogs: 0,
        acceptance_sum: 0.0,
        diverged: false,
    };
    let mut trajectory = Trajectory::new(&current, settings.greatest_depth);
    let windows = Windows::new(settings.warm_up);
    let (mut result, mut window, mut averaging, mut acceptance_sum, first);
    match from {
        Some(state) => {
            sampler.stream.seek(state.words);
            (sampler.metric, sampler.step, sampler.evaluator.work) =
                (state.metric, state.step, state.chain.work.clone());
            (result, window, averaging) = (state.chain, state.window, state.averaging);
            (acceptance_sum, first) = (state.acceptance_sum, state.transitions);
        }
        None => {
            result = Chain::with_capacity(dimension, settings.draws as usize);
            window = RunningCovariance::new(dimension);
            sampler.step = sampler.reasonable_step(&trajectory.sample);
            averaging = DualAveraging::new(sampler.step, settings.acceptance);
            (acceptance_sum, first) = (0.0, 0);
        }
    }
    let transitions = settings.warm_up + settings.draws;
    for transition in first..transitions {
        watch::at(transition, transitions);
        if transition == settings.warm_up {
            sampler.step = averaging.averaged();
        }
        let outcome = trajectory.advance(&mut sampler);
        if transition < settings.warm_up {
            averaging.update(outcome.acceptance);
            sampler.step = averaging.step();
            if windows.collects(transition) {
                window.add(&trajectory.sample.coordinates);
            }
            if windows.ends(transition) {
                sampler.metric.learn(&window, normal_metric.as_ref());
                window.reset();
                sampler.step = sampler.reasonable_step(&trajectory.sample);
                averaging = DualAveraging::new(sampler.step, settings.acceptance);
            }
        } else {
            acceptance_sum += outcome.acceptance;
            result.moves.divergences += u64::from(outcome.diverged);
            result.moves.depth_limited += u64::from(outcome.depth_limited);
            result.push(&posterior, &trajectory.sample.coordinates, &trajectory.sample.density);
        }
        parts.at(transition + 1, transitions, || NutsState {
            transitions: transition + 1,
            words: sampler.stream.position(),
            sample: trajectory.sample.clone(),
            metric: sampler.metric.clone(),
            step: sampler.step,
            averaging: averaging.clone(),
            window: window.clone(),
            acceptance_sum,
            chain: Chain { work: sampler.evaluator.work.clone(), ..result.clone() },
        });
    }
    result.moves.acceptance = acceptance_sum / settings.draws as f64;
    result.moves.step_size = Some(sampler.step);
    result.work = sampler.evaluator.work.clone();
    Ok(result)
}

/// The covariance of a normal approximation over the coordinates. Variances of 0 become 1, those above [`WIDEST`] fall to
/// it: a normal approximation that wide says only that the data say nothing.
pub(super) fn in_coordinates<T: Target>(normal: &NormalApproximation, posterior: &Posterior<'_, T>) -> Vec<f64> {
    let n = normal.mode.len();
    let mut covariance = posterior.covariance(normal);
    let cut: Vec<f64> = (0..n).map(|i| (WIDEST / covariance[i * n + i]).sqrt().min(1.0)).collect();
    for i in 0..n {
        for j in 0..n {
            covariance[i * n + j] *= cut[i] * cut[j];
        }
    }
    for i in 0..n {
        if !(covariance[i * n + i] > 0.0) {
            for j in 0..n {
                (covariance[i * n + j], covariance[j * n + i]) = (0.0, 0.0);
            }
            covariance[i * n + i] = 1.0;
        }
    }
    covariance
}

/// A state without its momentum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Point {
    coordinates: Vec<f64>,
    gradient: Vec<f64>,
    density: Density,
}

impl Point {
    fn copy_from(&mut self, other: &Self) {
        self.coordinates.copy_from_slice(&other.coordinates);
        self.gradient.copy_from_slice(&other.gradient);
        self.density = other.density;
    }
}

/// Momentum and velocity at an end of a trajectory.
#[derive(Clone, Debug)]
struct End {
    momentum: Vec<f64>,
    velocity: Vec<f64>,
}

impl End {
    fn new(dimension: usize) -> Self {
        Self { momentum: vec![0.0; dimension], velocity: vec![0.0; dimension] }
    }

    fn copy_from(&mut self, other: &Self) {
        self.momentum.copy_from_slice(&other.momentum);
        self.velocity.copy_from_slice(&other.velocity);
    }
}

/// What moves along a trajectory.
struct Sampler<'a, T: Target> {
    evaluator: Evaluator<'a, T>,
    stream: Stream,
    metric: Metric,
    step: f64,
    divergence_energy: f64,
    moving: Point,
    momentum: Vec<f64>,
    velocity: Vec<f64>,
    energy_at_start: f64,
    leapfrogs: u64,
    acceptance_sum: f64,
    diverged: bool,
}

impl<T: Target> Sampler<'_, T> {
    /// One leapfrog step of the moving state; the energy after it, infinite where the posterior has no value.
    #[inline]
    fn leapfrog(&mut self, step: f64) -> f64 {
        let half = 0.5 * step;
        for (p, g) in self.momentum.iter_mut().zip(&self.moving.gradient) {
            *p += half * g;
        }
        self.metric.velocity(&self.momentum, &mut self.velocity);
        for (z, v) in self.moving.coordinates.iter_mut().zip(&self.velocity) {
            *z += step * v;
        }
        let moving = &mut self.moving;
        let Some(density) = self.evaluator.density_gradient(&moving.coordinates, &mut moving.gradient) else {
            // Coordinates without bounds are a trajectory's fault, any others that are refused are not.
            self.diverged |= moving.coordinates.iter().any(|z| z.is_nan() || z.abs() > FAR);
            return f64::INFINITY;
        };
        moving.density = density;
        for (p, g) in self.momentum.iter_mut().zip(&moving.gradient) {
            *p += half * g;
        }
        self.metric.velocity(&self.momentum, &mut self.velocity);
        self.energy()
    }

    /// Energy of the moving state, whose velocity is up to date.
    #[inline]
    fn energy(&self) -> f64 {
        0.5 * dot(&self.momentum, &self.velocity) - self.moving.density.total()
    }

    /// A step size whose single leapfrog has an acceptance near 0.8 (Hoffman & Gelman 2014, algorithm 4).
    fn reasonable_step(&mut self, from: &Point) -> f64 {
        let mut step = self.step.clamp(1e-7, 1e7);
        let log_wanted = ln(0.8);
        let mut direction = 0.0;
        for _ in 0..60 {
            self.moving.copy_from(from);
            self.metric.draw_momentum(&mut self.stream, &mut self.momentum);
            self.metric.velocity(&self.momentum, &mut self.velocity);
            let before = self.energy();
            let gain = before - self.leapfrog(step);
            let now = if gain > log_wanted { 1.0 } else { -1.0 };
            if direction == 0.0 {
                direction = now;
            } else if now != direction {
                break;
            }
            step *= if direction > 0.0 { 2.0 } else { 0.5 };
        }
        step
    }

    /// Builds a subtree of `2^depth` points from the moving state; the log of its weight, or `None` when it turned or
    /// diverged. `momentum_sum` gains the subtree's momenta, `begin` and `end` become its ends in the direction of time.
    fn build(&mut self, levels: &mut [Level], forward: bool, tree: Tree<'_>) -> Option<f64> {
        let Some((level, below)) = levels.split_last_mut() else {
            let energy = self.leapfrog(if forward { self.step } else { -self.step });
            self.leapfrogs += 1;
            let gain = self.energy_at_start - energy;
            if !gain.is_finite() {
                // The target refused: counted there, and no fault of the trajectory.
                return None;
            }
            self.acceptance_sum += if gain >= 0.0 { 1.0 } else { exp(gain) };
            if -gain > self.divergence_energy {
                self.diverged = true;
                return None;
            }
            tree.proposal.copy_from(&self.moving);
            for (sum, p) in tree.momentum_sum.iter_mut().zip(&self.momentum) {
                *sum += p;
            }
            for end in [tree.begin, tree.end] {
                end.momentum.copy_from_slice(&self.momentum);
                end.velocity.copy_from_slice(&self.velocity);
            }
            return Some(gain);
        };
        level.first_sum.fill(0.0);
        let first = Tree {
            begin: tree.begin,
            end: &mut level.first_end,
            momentum_sum: &mut level.first_sum,
            proposal: tree.proposal,
        };
        let first_weight = self.build(below, forward, first)?;
        level.second_sum.fill(0.0);
        let second = Tree {
            begin: &mut level.second_begin,
            end: tree.end,
            momentum_sum: &mut level.second_sum,
            proposal: &mut level.second_proposal,
        };
        let second_weight = self.build(below, forward, second)?;
        let weight = log_sum(first_weight, second_weight);
        if second_weight >= weight || self.stream.uniform() < exp(second_weight - weight) {
            std::mem::swap(tree.proposal, &mut level.second_proposal);
        }
        for (sum, (a, b)) in tree.momentum_sum.iter_mut().zip(level.first_sum.iter().zip(&level.second_sum)) {
            *sum += a + b;
        }
        let on = goes_on(&tree.begin.velocity, &tree.end.velocity, &level.first_sum, &level.second_sum)
            && goes_on(
                &tree.begin.velocity,
                &level.second_begin.velocity,
                &level.first_sum,
                &level.second_begin.momentum,
            )
            && goes_on(&level.first_end.velocity, &tree.end.velocity, &level.second_sum, &level.first_end.momentum);
        on.then_some(weight)
    }
}

/// Where a subtree puts its results.
struct Tree<'a> {
    begin: &'a mut End,
    end: &'a mut End,
    momentum_sum: &'a mut [f64],
    proposal: &'a mut Point,
}

/// Memory of one level of the recursion.
struct Level {
    first_end: End,
    second_begin: End,
    first_sum: Vec<f64>,
    second_sum: Vec<f64>,
    second_proposal: Point,
}

/// How a transition went.
struct Outcome {
    acceptance: f64,
    diverged: bool,
    depth_limited: bool,
}

/// Memory of a trajectory, and the chain's state.
struct Trajectory {
    sample: Point,
    /// State at the backward and at the forward end.
    points: [Point; 2],
    /// Outer ends, backward and forward.
    outer: [End; 2],
    /// Ends at the seam: of the backward part, and of the forward part.
    seam: [End; 2],
    /// Sums of momenta of the parts that meet at the seam.
    sums: [Vec<f64>; 2],
    proposal: Point,
    levels: Vec<Level>,
}

impl Trajectory {
    fn new(at: &Point, greatest_depth: u32) -> Self {
        let dimension = at.coordinates.len();
        let end = || End::new(dimension);
        let zeros = || vec![0.0; dimension];
        Self {
            sample: at.clone(),
            points: [at.clone(), at.clone()],
            outer: [end(), end()],
            seam: [end(), end()],
            sums: [zeros(), zeros()],
            proposal: at.clone(),
            levels: (0..greatest_depth)
                .map(|_| Level {
                    first_end: end(),
                    second_begin: end(),
                    first_sum: zeros(),
                    second_sum: zeros(),
                    second_proposal: at.clone(),
                })
                .collect(),
        }
    }

    /// One transition: `sample` becomes the next state.
    fn advance<T: Target>(&mut self, sampler: &mut Sampler<'_, T>) -> Outcome {
        sampler.moving.copy_from(&self.sample);
        sampler.metric.draw_momentum(&mut sampler.stream, &mut sampler.momentum);
        sampler.metric.velocity(&sampler.momentum, &mut sampler.velocity);
        sampler.energy_at_start = sampler.energy();
        sampler.leapfrogs = 0;
        sampler.acceptance_sum = 0.0;
        sampler.diverged = false;
        for side in 0..2 {
            self.points[side].copy_from(&self.sample);
            self.outer[side].momentum.copy_from_slice(&sampler.momentum);
            self.outer[side].velocity.copy_from_slice(&sampler.velocity);
            self.sums[side].copy_from_slice(&sampler.momentum);
        }
        let mut weight = 0.0;
        let mut depth_limited = true;
        for depth in 0..self.levels.len() {
            let forward = sampler.stream.uniform() > 0.5;
            let (new, old) = if forward { (1, 0) } else { (0, 1) };
            // The part so far lies on the old side; its end at the seam is its outer end on the new side.
            let (seam_old, outer_new) = (&mut self.seam[old], &self.outer[new]);
            seam_old.copy_from(outer_new);
            // Before the first doubling both sums hold the first momentum; later the total lies in both (see below).
            self.sums[new].fill(0.0);
            sampler.moving.copy_from(&self.points[new]);
            sampler.momentum.copy_from_slice(&self.outer[new].momentum);
            let tree = Tree {
                begin: &mut self.seam[new],
                end: &mut self.outer[new],
                momentum_sum: &mut self.sums[new],
                proposal: &mut self.proposal,
            };
            let Some(added) = sampler.build(&mut self.levels[..depth], forward, tree) else {
                depth_limited = false;
                break;
            };
            self.points[new].copy_from(&sampler.moving);
            if added >= weight || sampler.stream.uniform() < exp(added - weight) {
                std::mem::swap(&mut self.sample, &mut self.proposal);
            }
            weight = log_sum(weight, added);
            let on = goes_on(&self.outer[0].velocity, &self.outer[1].velocity, &self.sums[0], &self.sums[1])
                && goes_on(
                    &self.outer[old].velocity,
                    &self.seam[new].velocity,
                    &self.sums[old],
                    &self.seam[new].momentum,
                )
                && goes_on(
                    &self.seam[old].velocity,
                    &self.outer[new].velocity,
                    &self.sums[new],
                    &self.seam[old].momentum,
                );
            if !on {
                depth_limited = false;
                break;
            }
            for i in 0..self.sums[0].len() {
                let total = self.sums[0][i] + self.sums[1][i];
                self.sums[0][i] = total;
                self.sums[1][i] = total;
            }
        }
        Outcome {
            acceptance: sampler.acceptance_sum / sampler.leapfrogs.max(1) as f64,
            diverged: sampler.diverged,
            depth_limited,
        }
    }
}

/// Whether a stretch with these velocities at its ends, whose momenta sum to `a + b`, has not turned round. Velocities of
/// backward stretches point the same way at both ends, so that the order of the ends does not matter.
#[inline]
fn goes_on(one: &[f64], other: &[f64], a: &[f64], b: &[f64]) -> bool {
    let (mut first, mut second) = (0.0, 0.0);
    for i in 0..a.len() {
        let sum = a[i] + b[i];
        first += one[i] * sum;
        second += other[i] * sum;
    }
    first > 0.0 && second > 0.0
}

/// `ln(e^a + e^b)`.
#[inline]
fn log_sum(a: f64, b: f64) -> f64 {
    let (large, small) = if a > b { (a, b) } else { (b, a) };
    large + ln_1p(exp(small - large))
}
