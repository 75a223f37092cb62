//! The information that a set of readings holds, replicate by replicate.

use super::forward_model::{ForwardModel, Place, Room, Whitening};
use super::output::{DesignSensor, Estimator};
use super::samples::{REPLICATES, Samples};
use crate::inference::information::estimate::{FEW, Replicate};
use crate::inference::information::linear;
use crate::inference::information::mixture::{Mixture, PRIOR_EVERY};
use crate::inference::information::nested::{Inner, LogMean};
use crate::math::functions::exp;
use crate::math::special::normal_quantile;
use crate::watch;

/// Most steps towards the most probable point of an outer sample.
const MOST_STEPS: usize = 8;
/// Squared distance from it, in standard deviations, that is near enough for a proposal.
const CLOSE: f64 = 0.02;
/// Smallest share of a step that is tried.
const LEAST_SHARE: f64 = 0.02;
/// Noises of each outer sample of one reading where they cost no solution, on a lattice of rank one with these generators by reading
/// (Sloan & Joe 1994, Lattice Methods, ch. 4). Readings beyond the ends of what the prior predicts are rare and tell most:
/// with one noise a sample the replicates' means are so skewed that three standard errors miss four times too often.
const NOISES: u32 = 8;
const GENERATORS: [u32; 4] = [1, 3, 5, 7];

/// What is asked of a set of readings.
pub(super) struct Question<'a> {
    pub forward_model: &'a ForwardModel,
    pub samples: &'a Samples,
    pub sensors: &'a [DesignSensor],
    pub estimator: Estimator,
    /// Number of unknowns to learn, the first ones.
    pub learn: usize,
    /// Inner samples.
    pub inner: usize,
    /// Draws of an inner integral by importance sampling.
    pub draws: usize,
    /// Phases that are done together.
    pub phases: &'a [Place],
    /// Positions of the sensors that are read.
    pub read: &'a [usize],
    /// Noise-free readings of each phase: `samples of all replicates x sensors`, SI.
    pub predictions: &'a [f64],
}

/// Room for one outer sample.
struct Work {
    room: Room,
    /// Of each phase.
    whitenings: Vec<Whitening>,
    readings: Vec<f64>,
    slopes: Vec<f64>,
    /// Whitened prediction and derivatives at the linearisation.
    prediction: Vec<f64>,
    jacobian: Vec<f64>,
    columns: Vec<f64>,
    residuals: Vec<f64>,
    draws: Vec<f64>,
    values: Vec<f64>,
    drawn: Vec<f64>,
    point: Vec<f64>,
    terms: Vec<f64>,
    /// Readings of the sensors that are read.
    picked: Vec<f64>,
}

impl Question<'_> {
    /// Readings of the set.
    fn channels(&self) -> usize {
        self.phases.len() * self.read.len()
    }

    /// Estimates of a range of replicates, and how many solutions they took.
    pub fn replicates(&self, range: std::ops::Range<usize>) -> (Vec<Replicate>, u64) {
        let mut work = self.work();
        let estimates = range
            .map(|replicate| match self.estimator {
                Estimator::Linear => self.linear(&mut work),
                _ => self.replicate(replicate, &mut work),
            })
            .collect();
        (estimates, work.room.solutions)
    }

    fn work(&self) -> Work {
        let (unknowns, sensors, channels) = (self.samples.unknowns, self.forward_model.sensors(), self.channels());
        Work {
            room: self.forward_model.room(),
            whitenings: self.phases.iter().map(|place| Whitening::new(place, self.sensors, self.read)).collect(),
            picked: vec![0.0; self.read.len()],
            readings: vec![0.0; sensors],
            slopes: vec![0.0; sensors * unknowns],
            prediction: vec![0.0; channels],
            jacobian: vec![0.0; channels * unknowns],
            columns: Vec::new(),
            residuals: vec![0.0; channels],
            draws: vec![0.0; self.draws * unknowns],
            values: vec![0.0; self.draws * unknowns],
            drawn: vec![0.0; self.draws * sensors],
            point: vec![0.0; channels],
            terms: vec![0.0; self.draws],
        }
    }

    /// Whitened noise-free readings of one sample, phase by phase; not finite where there is no solution.
    fn whitened(&self, sample: usize, whitenings: &[Whitening], out: &mut [f64]) {
        let sensors = self.forward_model.sensors();
        let all = REPLICATES * self.samples.size;
        for (phase, slots) in out.chunks_exact_mut(self.read.len()).enumerate() {
            let row = &self.predictions[(phase * all + sample) * sensors..][..sensors];
            for (slot, &sensor) in slots.iter_mut().zip(self.read) {
                *slot = row[sensor];
            }
            whitenings[phase].apply(slots);
        }
    }

    /// Samples of other replicates that average `ln p(z)` of this one: the next ones, so that no outer sample meets
    /// itself and every prediction serves both.
    fn inner(&self, replicate: usize, whitenings: &[Whitening]) -> Option<Inner> {
        let (size, channels) = (self.samples.size, self.channels());
        let mut rows = vec![0.0; self.inner * channels];
        for (place, row) in rows.chunks_exact_mut(channels).enumerate() {
            let other = (replicate + 1 + place / size) % REPLICATES;
            self.whitened(other * size + place % size, whitenings, row);
        }
        Inner::new(&rows, channels)
    }

    /// Noises of each outer sample: several only where they take no solutions, and fewer the more readings there are, each of
    /// which has noises of its own.
    fn noises(&self) -> u32 {
        let is_free = self.estimator == Estimator::Nested && self.learn == self.samples.unknowns;
        let readings = u32::try_from(self.channels().max(1)).unwrap_or(u32::MAX);
        if is_free { (NOISES / readings).max(1).next_power_of_two() } else { 1 }
    }

    fn replicate(&self, replicate: usize, work: &mut Work) -> Replicate {
        let mut sums = Replicate::default();
        let (channels, unknowns, size) = (self.channels(), self.samples.unknowns, self.samples.size);
        let is_nested = self.estimator == Estimator::Nested;
        let inner = if is_nested { self.inner(replicate, &work.whitenings) } else { None };
        let (rows, dimensions) = self.samples.outer(replicate);
        let (mut true_readings, mut readings) = (vec![0.0; channels], vec![0.0; channels]);
        let mut coordinates = vec![0.0; unknowns];
        let noises = self.noises();
        for (sample, row) in rows.chunks_exact(dimensions).enumerate() {
            watch::check();
            self.whitened(replicate * size + sample, &work.whitenings, &mut true_readings);
            if !true_readings.iter().all(|value| value.is_finite()) {
                continue;
            }
            for (slot, &u) in coordinates.iter_mut().zip(row) {
                *slot = normal_quantile(u);
            }
            let (mut estimate, mut count) = (Replicate::default(), 0_u32);
            for step in 0..noises {
                for (phase, slots) in readings.chunks_exact_mut(self.read.len()).enumerate() {
                    let noise = &row[unknowns + phase * self.forward_model.sensors()..];
                    for (slot, &sensor) in slots.iter_mut().zip(self.read) {
                        let generator = GENERATORS[(phase * self.forward_model.sensors() + sensor) % GENERATORS.len()];
                        *slot = normal_quantile(shifted(noise[sensor], step * generator, noises));
                    }
                }
                for (slot, truth) in readings.iter_mut().zip(&true_readings) {
                    *slot += truth;
                }
                let terms = match (&inner, self.estimator) {
                    (_, Estimator::Laplace) => {
                        self.laplace(&coordinates, &readings, work).map(|value| (value, None, None))
                    }
                    (Some(inner), _) => {
                        let marginal = inner.log_mean(&readings, &mut work.point);
                        self.terms((replicate, sample), &coordinates, &readings, Some(marginal), work)
                    }
                    (None, _) => self.terms((replicate, sample), &coordinates, &readings, None, work),
                };
                let Some((value, marginal, conditional)) = terms.filter(|sample_terms| sample_terms.0.is_finite())
                else {
                    continue;
                };
                count += 1;
                estimate.sum += value;
                estimate.marginal_rise += marginal.map_or(0.0, |log_mean| log_mean.rise().min(value.abs() + 50.0));
                estimate.conditional_rise +=
                    conditional.map_or(0.0, |log_mean| log_mean.rise().min(value.abs() + 50.0));
                let effective = marginal.iter().chain(&conditional).map(|log_mean| log_mean.effective).reduce(f64::min);
                estimate.effective += effective.unwrap_or(0.0);
                estimate.few += u64::from(effective.is_some_and(|effective| effective < FEW));
            }
            if count > 0 {
                sums.add_mean(&estimate, count);
            }
        }
        sums
    }

    /// `ln p(z | theta) - ln p(z)` of an outer sample, with both averages.
    fn terms(
        &self,
        sample: (usize, usize),
        coordinates: &[f64],
        readings: &[f64],
        marginal: Option<LogMean>,
        work: &mut Work,
    ) -> Option<(f64, Option<LogMean>, Option<LogMean>)> {
        let marginal = match marginal {
            Some(log_mean) => log_mean,
            None => self.integrated(sample, 0, coordinates, readings, work)?,
        };
        if self.learn == self.samples.unknowns {
            // What is left is the noise alone, whose mean is known.
            return Some((-0.5 * self.channels() as f64 - marginal.whole, Some(marginal), None));
        }
        let conditional = self.integrated(sample, self.learn, coordinates, readings, work)?;
        Some((conditional.whole - marginal.whole, Some(marginal), Some(conditional)))
    }

    /// Average of the likelihood over the unknowns from `first` on, by importance sampling.
    fn integrated(
        &self,
        (replicate, sample): (usize, usize),
        first: usize,
        coordinates: &[f64],
        readings: &[f64],
        work: &mut Work,
    ) -> Option<LogMean> {
        let (unknowns, sensors) = (self.samples.unknowns, self.forward_model.sensors());
        let mixture = self.approximation(first, coordinates, readings, work)?;
        let mut draws = std::mem::take(&mut work.draws);
        self.samples.draws(replicate, sample, &mut draws);
        for (index, draw) in draws.chunks_exact_mut(unknowns).enumerate() {
            draw[..first].copy_from_slice(&coordinates[..first]);
            mixture.place(index, &mut draw[first..]);
            work.terms[index] = mixture.log_weight(&draw[first..], self.draws);
        }
        for (draw, values) in draws.chunks_exact(unknowns).zip(work.values.chunks_exact_mut(unknowns)) {
            self.forward_model.values(draw, values);
        }
        work.draws = draws;
        for (phase, place) in self.phases.iter().enumerate() {
            self.forward_model.readings(place, &work.values, &mut work.room, &mut work.drawn, None);
            let phase_readings = &readings[phase * self.read.len()..][..self.read.len()];
            for (term, row) in work.terms.iter_mut().zip(work.drawn.chunks_exact(sensors)) {
                for (slot, &sensor) in work.picked.iter_mut().zip(self.read) {
                    *slot = row[sensor];
                }
                work.whitenings[phase].apply(&mut work.picked);
                for (reading, predicted) in phase_readings.iter().zip(&work.picked) {
                    let apart = reading - predicted;
                    *term -= 0.5 * apart * apart;
                }
            }
        }
        // A draw without a solution weighs nothing.
        let shift = work.terms.iter().copied().filter(|term| !term.is_nan()).fold(f64::NEG_INFINITY, f64::max);
        if !shift.is_finite() {
            return None;
        }
        let (mut sums, mut squares) = ([0.0; 2], 0.0);
        for (index, term) in work.terms.iter().enumerate().filter(|(_, term)| !term.is_nan()) {
            let weight = exp(term - shift);
            // Both halves have the same share of draws from the prior.
            sums[(index / PRIOR_EVERY) % 2] += weight;
            squares += weight * weight;
        }
        let log_mean = LogMean::of_sums(sums, squares, self.draws / 2, shift);
        Some(log_mean)
    }

    /// Normal approximation at the most probable point of the unknowns from `first` on: Gauss-Newton steps from the true
    /// values, halved where the density falls. Near a bound of a prior the coordinates are far from linear.
    fn approximation(&self, first: usize, coordinates: &[f64], readings: &[f64], work: &mut Work) -> Option<Mixture> {
        let mut at = coordinates.to_vec();
        let mut value = self.misfit(first, &at, readings, work)?;
        let mut trial = at.clone();
        for _ in 0..MOST_STEPS {
            let mixture = self.linear_posterior(first, &at, work)?;
            let step: Vec<f64> =
                mixture.mean().iter().zip(&at[first..]).map(|(mean, coordinate)| mean - coordinate).collect();
            if mixture.distance_squared(&at[first..]) < CLOSE {
                return Some(mixture.centred(&at[first..]));
            }
            let (mut share, mut accepted) = (1.0, false);
            while share > LEAST_SHARE {
                for (slot, (coordinate, step)) in trial[first..].iter_mut().zip(at[first..].iter().zip(&step)) {
                    *slot = coordinate + share * step;
                }
                if let Some(new) = self.misfit(first, &trial, readings, work)
                    && new < value
                {
                    at.copy_from_slice(&trial);
                    value = new;
                    accepted = true;
                    break;
                }
                share *= 0.5;
            }
            if !accepted {
                // The last trial has left its derivatives behind.
                return Some(mixture.centred(&at[first..]));
            }
        }
        Some(self.linear_posterior(first, &at, work)?.centred(&at[first..]))
    }

    /// Half the sum of squares of prior and readings, with the linearisation there.
    fn misfit(&self, first: usize, at: &[f64], readings: &[f64], work: &mut Work) -> Option<f64> {
        if !self.linearise(at, work) {
            return None;
        }
        let mut sum = 0.5 * at[first..].iter().map(|u| u * u).sum::<f64>();
        for (slot, (reading, predicted)) in work.residuals.iter_mut().zip(readings.iter().zip(&work.prediction)) {
            *slot = reading - predicted;
            sum += 0.5 * *slot * *slot;
        }
        Some(sum)
    }

    /// The posterior of the model that was linearised last.
    fn linear_posterior(&self, first: usize, at: &[f64], work: &mut Work) -> Option<Mixture> {
        work.columns.clear();
        for row in work.jacobian.chunks_exact(self.samples.unknowns) {
            work.columns.extend_from_slice(&row[first..]);
        }
        Mixture::linearised(&work.columns, &work.residuals, &at[first..]).ok()
    }

    /// Whitened predictions and derivatives of all phases at coordinates.
    fn linearise(&self, at: &[f64], work: &mut Work) -> bool {
        let (unknowns, read) = (self.samples.unknowns, self.read.len());
        for (phase, place) in self.phases.iter().enumerate() {
            if !self.forward_model.linearised(place, at, &mut work.room, &mut work.readings, &mut work.slopes) {
                return false;
            }
            let prediction = &mut work.prediction[phase * read..(phase + 1) * read];
            for (slot, &sensor) in prediction.iter_mut().zip(self.read) {
                *slot = work.readings[sensor];
            }
            work.whitenings[phase].apply(prediction);
            let rows = whitened_rows(&work.slopes, unknowns, &work.whitenings[phase], self.read);
            work.jacobian[phase * read * unknowns..][..rows.len()].copy_from_slice(&rows);
        }
        true
    }

    fn laplace(&self, coordinates: &[f64], readings: &[f64], work: &mut Work) -> Option<f64> {
        let mixture = self.approximation(0, coordinates, readings, work)?;
        linear::divergence(mixture.precision_factor(), mixture.mean(), self.learn).ok()
    }

    /// Without random numbers: every replicate is the same.
    fn linear(&self, work: &mut Work) -> Replicate {
        let unknowns = self.samples.unknowns;
        let mut jacobian = Vec::new();
        for (place, whitening) in self.phases.iter().zip(&work.whitenings) {
            let Some(changes) = self.forward_model.nominal_changes(place, &mut work.room) else {
                return Replicate::default();
            };
            jacobian.extend(whitened_rows(&changes, unknowns, whitening, self.read));
        }
        let value = linear::information(&jacobian, unknowns, self.learn);
        value.map_or_else(|_| Replicate::default(), |sum| Replicate { count: 1, sum, ..Replicate::default() })
    }
}

/// Derivatives of the sensors that are read, whitened (`sensors x unknowns`).
pub(super) fn whitened_rows(changes: &[f64], unknowns: usize, whitening: &Whitening, read: &[usize]) -> Vec<f64> {
    let mut rows = vec![0.0; read.len() * unknowns];
    let mut column = vec![0.0; read.len()];
    for unknown in 0..unknowns {
        for (slot, &sensor) in column.iter_mut().zip(read) {
            *slot = changes[sensor * unknowns + unknown];
        }
        whitening.apply(&mut column);
        for (row, value) in column.iter().enumerate() {
            rows[row * unknowns + unknown] = *value;
        }
    }
    rows
}

/// A probability moved by `step / steps` round the unit interval.
pub fn shifted(u: f64, step: u32, steps: u32) -> f64 {
    let moved = u + f64::from(step % steps) / f64::from(steps);
    // Where rounding lands on an end, the quantile would be infinite.
    (if moved >= 1.0 { moved - 1.0 } else { moved }).clamp(0.5 * f64::EPSILON, 1.0 - 0.5 * f64::EPSILON)
}
