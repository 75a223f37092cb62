//! Which effects explain so little that errors of the model itself may be what they explain.
//!
//! Every thermal model is a little wrong everywhere: nodes have gradients, exchange areas are estimates. Such errors follow
//! the inputs as effects do, and some effect of a catalogue follows them better than the noise allows by chance. What tells a missing effect from
//! them is its size: it explains far more than what is left beside it, and not far less than another that is missing. Where
//! tests go on finding something that no effect explains, the model is wrong in such ways, and all but the strongest effect may be.

use crate::diagnosis::Refit;
use crate::diagnosis::engine::SensorNoise;
use crate::diagnosis::problem::FittedReading;
use crate::diagnosis::verdict::conclude::Findings;

/// Least share that an effect explains of what the strongest one explains, in squares.
const LEAST_SHARE: f64 = 0.2;
/// Least multiple that an effect explains of the model error that is left, in squares: with it the error is less than half of that before.
const LEAST_OF_ERROR: f64 = 3.0;
/// Probability that a small effect is none: nothing beforehand speaks for either.
pub(super) const IS_MODEL_ERROR: f64 = 0.5;

impl Findings<'_> {
    /// Effects that are small beside the strongest one of the selected set, or beside the model error that is left. Where what
    /// the set leaves has a family-wise p of at most `false_alarm`, all that explain less than the strongest.
    pub(super) fn small_effects(&self, false_alarm: f64) -> Vec<usize> {
        let refits = &self.state.refits;
        let chosen = &refits[self.selected];
        let gain = |effect: usize| {
            let (before, after) = self.step_of(effect).or_else(|| self.best_with(effect))?;
            Some(refits[before].chi_square - refits[after].chi_square)
        };
        let strongest = chosen.effects.iter().filter_map(|&effect| gain(effect)).fold(0.0, f64::max);
        let left = self.left_by_model_error(chosen);
        let is_left = !self.state.is_misspecified() && self.remaining_now().is_some_and(|p| p <= false_alarm);
        let mut effects: Vec<usize> = refits.iter().flat_map(|refit| refit.effects.iter().copied()).collect();
        effects.sort_unstable();
        effects.dedup();
        effects.retain(|&effect| gain(effect).is_some_and(|gain| is_small(gain, strongest, left, is_left)));
        effects
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

    /// Sum of squares that the model error makes: of the one that is allowed for, or what the selected set leaves beyond the
    /// noise.
    fn left_by_model_error(&self, chosen: &Refit) -> f64 {
        if !self.state.is_misspecified() {
            return (chosen.chi_square - chosen.residuals.len() as f64).max(0.0);
        }
        let of = |reading: FittedReading| {
            let same = |own: &&SensorNoise| own.measurement == reading.measurement && own.sensor == reading.sensor;
            let error = self.state.noise.iter().find(same)?.model_error?;
            Some((error.sd / error.counts_as) * (error.sd / error.counts_as))
        };
        self.problem.fitted_readings().into_iter().filter_map(of).sum()
    }
}

/// Whether an effect with this gain is small beside the strongest, or beside the model error that is left; where tests find that
/// something `is_left`, any that is less than the strongest.
fn is_small(gain: f64, strongest: f64, left: f64, is_left: bool) -> bool {
    gain < LEAST_SHARE * strongest || gain < LEAST_OF_ERROR * left || is_left && gain < strongest
}

#[cfg(test)]
mod tests {
    use super::is_small;

    #[test]
    fn an_effect_is_small_beside_a_stronger_one_or_beside_what_is_left() {
        assert!(!is_small(100.0, 100.0, 10.0, false));
        // Two effects of one size.
        assert!(!is_small(40.0, 60.0, 0.0, false));
        // But where something is left, the lesser one may be model error; the strongest is not.
        assert!(is_small(40.0, 60.0, 0.0, true));
        assert!(!is_small(60.0, 60.0, 0.0, true));
        // A third of the strongest in readings is a ninth in squares.
        assert!(is_small(11.0, 100.0, 0.0, false));
        // It takes away less than half of the error.
        assert!(is_small(100.0, 100.0, 50.0, false));
    }
}
