//! Sequential Monte Carlo from the prior to the posterior through powers of the likelihood (Del Moral, Doucet & Jasra
//! 2006; temperatures by the effective sample size, Jasra et al. 2011).
//!
//! Each island is a population of its own: particles drawn from the prior are weighted to the next temperature, chosen
//! by bisection so that their effective number falls to a given share, resampled systematically, and moved until they
//! have forgotten where they were. Moves of several kinds alternate (`proposal`), each fed by the other half of the
//! population; the halves are moved in turn, so that each move leaves the tempered density as it is.
//!
//! The evidence of an island is the product of its mean weights. A point that the target refuses has the likelihood zero,
//! and its share of the prior is paid for in the evidence.
//!
//! The scatter of a few islands knows the error of their mean badly: of four it is too small by half every seventh time.
//! Each island tells its own variance from its genealogy (Chan & Lai 2013; Lee & Whiteley 2018, Biometrika 105, 609).
//! With `W_e` the share of the last weights that the descendants of the prior's draw `e` have, among N,
//!
//! `V = sum_e W_e^2 - 1 / N - sum_t R_t`,
//!
//! where `R_t` is by how much stage t's resampling alone raises the sum on average. Multinomial resampling, which is theirs,
//! raises it by `(1 - sum_e W_e^2) / N`. Systematic resampling in the particles' order, which keeps families together, gives
//! a family of weight `W_e` either of the two whole numbers round `N W_e`, and raises it by `sum_e f_e (1 - f_e) / N^2`, `f_e`
//! being the fraction of `N W_e`. A mode that an island lost is not in its genealogy: the larger of this and the
//! scatter of the islands is what is stated.

use serde::{Deserialize, Serialize};

use crate::inference::posterior::{Density, Evaluator, Posterior};
use crate::inference::sampler::chains::{Chain, Chains, SampleError, most_frequent};
use crate::inference::sampler::proposal::{Kind, Proposal};
use crate::inference::target::Target;
use crate::math::functions::{exp, ln};
use crate::random::{Stream, StreamKey};

/// Settings of sequential Monte Carlo.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SmcSettings {
    /// Particles of an island, at least 16.
    pub particles: usize,
    /// Independent islands, at least 2.
    pub islands: u64,
    /// Share of effective particles at the next temperature, within 0 to 1.
    pub effective_share: f64,
    /// Correlation of the particles with where they were before a stage's moves, below which moving ends; chance alone
    /// gives about twice the inverse root of the number of particles.
    pub correlation: f64,
    /// Most moves of a stage.
    pub most_moves: u64,
    /// Most stages.
    pub most_stages: u64,
}

impl Default for SmcSettings {
    fn default() -> Self {
        Self { particles: 512, islands: 8, effective_share: 0.5, correlation: 0.15, most_moves: 40, most_stages: 200 }
    }
}

impl SmcSettings {
    fn check(&self) -> Result<(), SampleError> {
        let check = SampleError::check;
        check("particles", self.particles as f64, self.particles >= 16, "16 or more")?;
        check("islands", self.islands as f64, self.islands >= 2, "2 or more")?;
        let share = self.effective_share;
        check("effective_share", share, share > 0.0 && share < 1.0, "between 0 and 1")?;
        check("correlation", self.correlation, self.correlation > 0.0, "above 0")?;
        check("most_moves", self.most_moves as f64, self.most_moves > 0, "1 or more")?;
        check("most_stages", self.most_stages as f64, self.most_stages > 0, "1 or more")
    }
}

/// A stage of the tempering.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// Power of the likelihood reached.
    pub temperature: f64,
    /// Share of the particles that had weight, by their effective number.
    pub effective_share: f64,
    /// Moves made by each particle.
    pub moves: u64,
    /// Share of moves accepted.
    pub acceptance: f64,
    /// Largest remaining correlation with the positions before the moves.
    pub correlation: f64,
}

/// One island.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Island {
    /// The particles at the posterior, equally weighted, as a chain.
    pub chain: Chain,
    /// Logarithm of the evidence.
    pub log_evidence: f64,
    /// Variance of the evidence relative to its square, from the genealogy of the particles.
    pub evidence_variance: f64,
    /// The stages.
    pub stages: Vec<Stage>,
    /// Whether the posterior was reached within the most stages.
    pub finished: bool,
}

/// All islands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SmcResult {
    /// The islands' particles as chains.
    pub chains: Chains,
    /// Weight of each island: its share of the evidence. Equal weights would bias expectations by the islands' scatter.
    pub weights: Vec<f64>,
    /// Logarithm of the mean evidence.
    pub log_evidence: f64,
    /// Its standard error to first order: the larger of that by the islands' genealogies and that by their scatter.
    pub log_evidence_error: f64,
    /// Log evidence of each island.
    pub island_log_evidences: Vec<f64>,
    /// Stages of each island.
    pub stages: Vec<Vec<Stage>>,
    /// Whether every island reached the posterior.
    pub finished: bool,
}

/// Runs one island.
///
/// # Errors
/// [`SampleError`] for a prior without a map, settings out of range, or a target that refuses every particle.
pub fn run_island<T: Target>(
    target: &T,
    settings: &SmcSettings,
    key: &StreamKey,
    island: u64,
) -> Result<Island, SampleError> {
    settings.check()?;
    let posterior = Posterior::new(target)?;
    let mut population = Population::new(&posterior, settings, key.stream(island))?;
    let (mut log_evidence, mut evidence_variance) = (0.0, 0.0);
    let mut stages = Vec::new();
    while population.temperature < 1.0 && (stages.len() as u64) < settings.most_stages {
        let (log_mean_weight, effective_share) = population.next_temperature(settings.effective_share);
        log_evidence += log_mean_weight;
        evidence_variance = population.evidence_variance();
        population.resample();
        let mut stage = population.spread(settings);
        stage.effective_share = effective_share;
        stages.push(stage);
    }
    let mut chain = Chain::with_capacity(posterior.dimension(), settings.particles);
    for particle in &population.particles {
        if let Some(density) = &particle.density {
            chain.push(&posterior, &particle.coordinates, density);
        }
    }
    chain.moves.acceptance = stages.last().map_or(0.0, |stage| stage.acceptance);
    chain.work = population.evaluator.work.clone();
    Ok(Island { chain, log_evidence, evidence_variance, stages, finished: population.temperature >= 1.0 })
}

/// Joins islands, in their order.
pub fn combine(names: &[String], islands: Vec<Island>) -> SmcResult {
    let island_log_evidences: Vec<f64> = islands.iter().map(|island| island.log_evidence).collect();
    let (log_evidence, scatter) = mean_evidence(&island_log_evidences);
    let count = islands.len() as f64;
    let weights: Vec<f64> = island_log_evidences
        .iter()
        .map(|island_log_evidence| exp(island_log_evidence - log_evidence) / count)
        .collect();
    let of_island = |(weight, island): (&f64, &Island)| weight * weight * island.evidence_variance;
    let genealogy = weights.iter().zip(&islands).map(of_island).sum::<f64>().sqrt();
    // One that is not a number stays one.
    let log_evidence_error = if genealogy > scatter { genealogy } else { scatter };
    SmcResult {
        weights,
        log_evidence,
        log_evidence_error,
        island_log_evidences,
        finished: islands.iter().all(|island| island.finished),
        stages: islands.iter().map(|island| island.stages.clone()).collect(),
        chains: Chains { names: names.to_vec(), chains: islands.into_iter().map(|island| island.chain).collect() },
    }
}

/// Logarithm of the mean of evidences given by their logarithms, and its standard error to first order by their scatter.
fn mean_evidence(log_evidences: &[f64]) -> (f64, f64) {
    let count = log_evidences.len() as f64;
    let largest = log_evidences.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return (largest, f64::NAN);
    }
    let shares: Vec<f64> = log_evidences.iter().map(|log_evidence| exp(log_evidence - largest)).collect();
    let mean = shares.iter().sum::<f64>() / count;
    let squares: f64 = shares.iter().map(|share| (share / mean - 1.0) * (share / mean - 1.0)).sum();
    (largest + ln(mean), (squares / (count - 1.0) / count).sqrt())
}

/// A particle; without density where the target refused it, which only draws from the prior can be.
#[derive(Clone, Debug)]
pub(super) struct Particle {
    pub(super) coordinates: Vec<f64>,
    density: Option<Density>,
    /// The draw from the prior that it descends from.
    family: usize,
}

struct Population<'a, T: Target> {
    evaluator: Evaluator<'a, T>,
    stream: Stream,
    particles: Vec<Particle>,
    weights: Vec<f64>,
    temperature: f64,
    /// By how much resampling raised the sum of the families' squared shares so far, on average.
    raised: f64,
    /// Scales of the shrinking moves, the random walk and the difference steps, adapted.
    scales: [f64; 3],
}

impl<'a, T: Target> Population<'a, T> {
    fn new(posterior: &'a Posterior<'a, T>, settings: &SmcSettings, mut stream: Stream) -> Result<Self, SampleError> {
        let mut evaluator = posterior.evaluator();
        let particles: Vec<Particle> = (0..settings.particles)
            .map(|family| {
                let coordinates = posterior.draw_prior(&mut stream);
                let density = evaluator.density(&coordinates);
                Particle { coordinates, density, family }
            })
            .collect();
        if particles.iter().all(|particle| particle.density.is_none()) {
            let reason = most_frequent(&evaluator.work.rejections);
            return Err(SampleError::NoStart { tries: settings.particles as u64, reason });
        }
        let dimension = posterior.dimension() as f64;
        Ok(Self {
            evaluator,
            stream,
            weights: vec![0.0; particles.len()],
            particles,
            temperature: 0.0,
            raised: 0.0,
            scales: [0.8, 2.38 / dimension.sqrt(), 2.38 / (2.0 * dimension).sqrt()],
        })
    }

    /// Moves on to the next temperature: sets the weights (sum one), returns the log of their mean and the effective share.
    fn next_temperature(&mut self, wanted: f64) -> (f64, f64) {
        let log_likelihoods: Vec<f64> = self
            .particles
            .iter()
            .map(|particle| particle.density.map_or(f64::NEG_INFINITY, |density| density.log_likelihood))
            .collect();
        // Refused particles never have weight: the share is of those that can have it.
        let alive = log_likelihoods.iter().filter(|l| l.is_finite()).count() as f64;
        let rest = 1.0 - self.temperature;
        let mut step = rest;
        if effective(&log_likelihoods, rest) < wanted * alive {
            let (mut lower, mut upper) = (0.0, rest);
            // Sixty halvings exhaust the digits; the lower end is always accepted.
            for _ in 0..60 {
                let middle = 0.5 * (lower + upper);
                if effective(&log_likelihoods, middle) < wanted * alive {
                    upper = middle;
                } else {
                    lower = middle;
                }
            }
            step = if lower > 0.0 { lower } else { upper };
        }
        let count = self.particles.len() as f64;
        let share = effective(&log_likelihoods, step) / count;
        let largest = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        for (weight, l) in self.weights.iter_mut().zip(&log_likelihoods) {
            *weight = if l.is_finite() { exp(step * (l - largest)) } else { 0.0 };
            sum += *weight;
        }
        for weight in &mut self.weights {
            *weight /= sum;
        }
        self.temperature = if step >= rest { 1.0 } else { self.temperature + step };
        (step * largest + ln(sum / count), share)
    }

    /// Shares of the weights by family.
    fn families(&self) -> Vec<f64> {
        let mut shares = vec![0.0; self.particles.len()];
        for (particle, weight) in self.particles.iter().zip(&self.weights) {
            shares[particle.family] += weight;
        }
        shares
    }

    /// Variance of the evidence so far, relative to its square, from the weights and the families.
    fn evidence_variance(&self) -> f64 {
        let squares: f64 = self.families().iter().map(|share| share * share).sum();
        (squares - 1.0 / self.particles.len() as f64 - self.raised).max(0.0)
    }

    /// Systematic resampling: copies of each particle by its weight, in the particles' order.
    fn resample(&mut self) {
        let count = self.particles.len();
        let fraction = |share: &f64| share * count as f64 - (share * count as f64).floor();
        let spread: f64 = self.families().iter().map(fraction).map(|f| f * (1.0 - f)).sum();
        self.raised += spread / (count as f64 * count as f64);
        let offset = self.stream.uniform();
        let mut chosen = Vec::with_capacity(count);
        let (mut source, mut sum) = (0, self.weights[0]);
        for i in 0..count {
            let level = (i as f64 + offset) / count as f64;
            while sum < level && source + 1 < count {
                source += 1;
                sum += self.weights[source];
            }
            chosen.push(source);
        }
        // Rounding at the end of the sum must not choose a particle without weight.
        let last_alive = self.weights.iter().rposition(|&weight| weight > 0.0).unwrap_or(0);
        self.particles = chosen.iter().map(|&source| self.particles[source.min(last_alive)].clone()).collect();
        // Copies of one particle lie side by side; the halves that move each other should share few of them, and do.
    }

    /// Moves the particles until they have forgotten their positions.
    fn spread(&mut self, settings: &SmcSettings) -> Stage {
        let count = self.particles.len();
        let before: Vec<Vec<f64>> = self.particles.iter().map(|particle| particle.coordinates.clone()).collect();
        let mut proposal = Proposal::new(before[0].len());
        let mut stage =
            Stage { temperature: self.temperature, effective_share: 0.0, moves: 0, acceptance: 0.0, correlation: 1.0 };
        let (mut tried, mut accepted) = (0_u64, 0_u64);
        while stage.moves < settings.most_moves {
            let kind = Kind::of(stage.moves);
            let mut kind_accepted = 0_u64;
            for half in 0..2 {
                let (updated, others) =
                    if half == 0 { (0..count / 2, count / 2..count) } else { (count / 2..count, 0..count / 2) };
                if kind.needs_covariance() {
                    proposal.learn(&self.particles[others.clone()]);
                }
                for i in updated {
                    let correction = self.propose(kind, i, others.clone(), &mut proposal);
                    kind_accepted += u64::from(self.try_move(i, &proposal.coordinates, correction));
                }
            }
            tried += count as u64;
            accepted += kind_accepted;
            self.adapt(kind, kind_accepted as f64 / count as f64);
            stage.moves += 1;
            // One move of each kind at least.
            if stage.moves >= 3 {
                stage.correlation = self.correlation(&before);
                if stage.correlation < settings.correlation {
                    break;
                }
            }
        }
        stage.acceptance = accepted as f64 / tried.max(1) as f64;
        stage
    }

    /// Writes a proposal for a particle; the log ratio of the proposal densities, back over there.
    fn propose(&mut self, kind: Kind, i: usize, others: std::ops::Range<usize>, proposal: &mut Proposal) -> f64 {
        let here = &self.particles[i].coordinates;
        match kind {
            Kind::Shrink => proposal.shrink(here, self.scales[0], &mut self.stream),
            Kind::Walk => {
                proposal.draw(&mut self.stream);
                for (p, (z, step)) in proposal.coordinates.iter_mut().zip(here.iter().zip(&proposal.normals)) {
                    *p = z + self.scales[1] * step;
                }
                0.0
            }
            Kind::Difference | Kind::LongDifference => {
                let one = &self.particles[others.start + self.stream.below(others.len())].coordinates;
                let two = &self.particles[others.start + self.stream.below(others.len())].coordinates;
                let scale = if kind == Kind::LongDifference { 1.0 } else { self.scales[2] };
                for j in 0..here.len() {
                    // The small normal part lets a walk leave the span of the particles.
                    proposal.coordinates[j] = here[j] + scale * (one[j] - two[j]) + 1e-4 * self.stream.normal();
                }
                0.0
            }
        }
    }

    /// Steers the scale of a kind of move towards a useful acceptance.
    fn adapt(&mut self, kind: Kind, acceptance: f64) {
        match kind {
            Kind::Shrink => self.scales[0] = (self.scales[0] * exp(acceptance - 0.35)).clamp(0.02, 1.0),
            Kind::Walk => self.scales[1] = (self.scales[1] * exp(0.7 * (acceptance - 0.27))).clamp(1e-4, 5.0),
            Kind::Difference => self.scales[2] = (self.scales[2] * exp(0.7 * (acceptance - 0.27))).clamp(1e-4, 5.0),
            Kind::LongDifference => {}
        }
    }

    /// Moves a particle to a proposal with the Metropolis probability.
    fn try_move(&mut self, i: usize, proposal: &[f64], correction: f64) -> bool {
        let Some(there) = self.evaluator.density(proposal) else { return false };
        let particle = &mut self.particles[i];
        let here = particle.density.map_or(f64::NEG_INFINITY, |density| density.tempered(self.temperature));
        let accept = ln(self.stream.uniform()) < there.tempered(self.temperature) - here + correction;
        if accept {
            particle.coordinates.copy_from_slice(proposal);
            particle.density = Some(there);
        }
        accept
    }

    /// Largest correlation, over the coordinates, between the particles and their positions before.
    fn correlation(&self, before: &[Vec<f64>]) -> f64 {
        let dimension = before[0].len();
        let count = before.len() as f64;
        let mut largest: f64 = 0.0;
        for j in 0..dimension {
            let mean_before = before.iter().map(|b| b[j]).sum::<f64>() / count;
            let mean_now = self.particles.iter().map(|p| p.coordinates[j]).sum::<f64>() / count;
            let (mut bb, mut bn, mut nn) = (0.0, 0.0, 0.0);
            for (b, now) in before.iter().zip(&self.particles) {
                let (b, n) = (b[j] - mean_before, now.coordinates[j] - mean_now);
                bb += b * b;
                bn += b * n;
                nn += n * n;
            }
            if bb > 0.0 && nn > 0.0 {
                largest = largest.max(bn / (bb * nn).sqrt());
            }
        }
        largest
    }
}

/// Effective number of particles with weights `L^step`.
fn effective(log_likelihoods: &[f64], step: f64) -> f64 {
    let largest = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (mut sum, mut squares) = (0.0, 0.0);
    for l in log_likelihoods {
        if l.is_finite() {
            let weight = exp(step * (l - largest));
            sum += weight;
            squares += weight * weight;
        }
    }
    sum * sum / squares
}
