//! Which effects explain so little that errors of the model itself may be what they explain.
//!
//! Every thermal model is a little wrong everywhere: nodes have gradients, exchange areas are estimates. Such errors follow
//! the inputs as effects do, and some effect of a catalogue follows them better than the noise allows by chance. What tells a missing effect from
//! them is its size: it explains far more than what is left beside it, and not far less than another that is missing. Where
//! tests go on finding something that no effect explains, or the held-out rows are predicted badly, the model is wrong in such
//! ways, and all but the strongest effect may be. What would have to be a hundred times as large as is plausible stands for something
//! else as likely as not, and so do surroundings that are warmer than all that the record shows around the hardware, and a curve over
//! hardly more steady phases than it has values: what was peculiar to each phase looks the same.
//!
//! Where a model error is allowed for, an effect that explains `g` times the squares that it makes is one itself with the
//! probability `1 / (1 + g / 3)`, at most a half. The errors of a model's parts differ: a few make most of what they make together, and the
//! largest of them exceeds a multiple of their mean square with a probability that falls as slowly as its inverse.

use std::collections::BTreeMap;

use crate::diagnosis::engine::SensorNoise;
use crate::diagnosis::odds::medium::is_source;
use crate::diagnosis::problem::FittedReading;
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::{Problem, Refit};
use crate::measurement::Measurement;

/// Least share that an effect explains of what the strongest one explains, in squares.
const LEAST_SHARE: f64 = 0.2;
/// Multiple of what the model error makes, in squares, that an effect explains which is as likely one as not: with it the error
/// is half of that before.
pub(super) const AS_LIKELY: f64 = 3.0;
/// Probability that a small effect is none: nothing beforehand speaks for either.
pub(crate) const IS_MODEL_ERROR: f64 = 0.5;

impl Findings<'_> {
    /// Probability that errors of the model are what an effect explains, of each for which it is not 0. Where something `is_left`
    /// beside the selected set, all that explain less than the strongest may be.
    pub(super) fn model_errors(&self, is_left: bool) -> BTreeMap<usize, f64> {
        let refits = &self.state.refits;
        let chosen = &refits[self.selected];
        let strongest = chosen.effects.iter().filter_map(|&effect| self.gain(effect)).fold(0.0, f64::max);
        let left = Left {
            strongest,
            squares: self.left_by_model_error(chosen),
            is_allowed_for: self.state.is_misspecified(),
            is_found: is_left,
        };
        let mut effects: Vec<usize> = refits.iter().flat_map(|refit| refit.effects.iter().copied()).collect();
        effects.sort_unstable();
        effects.dedup();
        let one = |effect: usize| {
            let reads_alike = self.is_source(effect) || is_curve_of_few_phases(self.problem, effect);
            let by_size = if self.is_implausible(effect) || reads_alike { IS_MODEL_ERROR } else { 0.0 };
            Some((effect, left.is_model_error(self.gain(effect)?).max(by_size)))
        };
        effects.into_iter().filter_map(one).filter(|(_, probability)| *probability > 0.0).collect()
    }

    /// What an effect explains, in squares of the noise: in its step, or beside the rest of its best set.
    pub(super) fn gain(&self, effect: usize) -> Option<f64> {
        let (before, after) = self.step_of(effect).or_else(|| self.best_with(effect))?;
        Some(self.state.refits[before].chi_square - self.state.refits[after].chi_square)
    }

    /// Whether an effect has to be a hundred times as large as the catalogue's plausible sizes, in its step or
    /// its best set.
    fn is_implausible(&self, effect: usize) -> bool {
        let Some((_, place)) = self.step_of(effect).or_else(|| self.best_with(effect)) else { return false };
        self.state.refits[place].is_implausible(effect)
    }

    /// Whether an effect leads to surroundings that stand for a source or a store of heat, in its step or its best set.
    pub(super) fn is_source(&self, effect: usize) -> bool {
        let Some((_, place)) = self.step_of(effect).or_else(|| self.best_with(effect)) else { return false };
        let temperature = surroundings_k(self.problem, &self.state.refits[place], effect);
        temperature.is_some_and(|temperature| is_source(self.problem, temperature))
    }

    /// The selected set where it has an effect, else the most probable one with it, after the same set without it. `None` where no
    /// set was fitted without it.
    fn best_with(&self, effect: usize) -> Option<(usize, usize)> {
        let refits = &self.state.refits;
        let without = |&after: &usize| {
            let rest = || refits[after].effects.iter().filter(|&&other| other != effect);
            let before = refits.iter().position(|refit| refit.effects.iter().eq(rest()))?;
            refits[after].effects.contains(&effect).then_some((before, after))
        };
        let better = |a: (usize, usize), b: (usize, usize)| {
            if self.weights.sets[b.1] > self.weights.sets[a.1] { b } else { a }
        };
        without(&self.selected).or_else(|| (0..refits.len()).filter_map(|after| without(&after)).reduce(better))
    }

    /// Sum of squares that the model error makes: of the one that is allowed for, as far as the selected set leaves it, or what the
    /// set leaves beyond the noise.
    fn left_by_model_error(&self, chosen: &Refit) -> f64 {
        if !self.state.is_misspecified() {
            return (chosen.chi_square - chosen.residuals.len() as f64).max(0.0);
        }
        let of = |reading: FittedReading| {
            let same = |own: &&SensorNoise| own.measurement == reading.measurement && own.sensor == reading.sensor;
            let error = self.state.noise.iter().find(same)?.model_error?;
            Some((error.sd / error.counts_as) * (error.sd / error.counts_as))
        };
        // What it was before the effects were found is no measure of what they leave.
        self.problem.fitted_readings().into_iter().filter_map(of).sum::<f64>().min(chosen.chi_square)
    }
}

/// Whether an effect is a curve, and the fitted rows are steady phases of which there are fewer than two for each value of the curve.
pub fn is_curve_of_few_phases(problem: &Problem, effect: usize) -> bool {
    let catalogue_effect = problem.catalogue.get(&problem.candidates[effect].effect);
    let Some(curve) = catalogue_effect.and_then(|own| own.form.adds.value.curve.as_ref()) else { return false };
    let phases = |one: &Measurement| one.fitted_rows().count();
    !problem.has_transients() && problem.measurements.iter().map(phases).sum::<usize>() < 2 * curve.knots.value
}

/// Temperature, K, that a fit gives the surroundings to which an effect leads; `None` where they have no temperature of their own.
fn surroundings_k(problem: &Problem, refit: &Refit, effect: usize) -> Option<f64> {
    let candidate = &problem.candidates[effect];
    let ambient = problem.catalogue.get(&candidate.effect)?.form.adds.value.ambient.as_ref()?;
    refit.by_name().get(&format!("{}.{}", candidate.id, ambient.temperature.value)).copied()
}

/// What stands beside the effects, in squares of the noise.
pub struct Left {
    /// What the strongest effect of the selected set explains.
    pub strongest: f64,
    /// What the model error makes, or what is left beyond the noise.
    pub squares: f64,
    /// Whether a model error is allowed for.
    pub is_allowed_for: bool,
    /// Whether something is found beside the selected set.
    pub is_found: bool,
}

impl Left {
    /// Probability that errors of the model are what an effect with this gain explains.
    pub fn is_model_error(&self, gain: f64) -> f64 {
        let is_lesser = gain < LEAST_SHARE * self.strongest || self.is_found && gain < self.strongest;
        let least = if is_lesser { IS_MODEL_ERROR } else { 0.0 };
        let as_likely = AS_LIKELY * self.squares;
        let by_size = match self.is_allowed_for {
            _ if gain < as_likely => IS_MODEL_ERROR,
            true => as_likely / (as_likely + gain).max(f64::MIN_POSITIVE),
            false => 0.0,
        };
        by_size.max(least)
    }
}
