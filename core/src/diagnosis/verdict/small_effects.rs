//! Which effects explain so little that errors of the model itself may be what they explain.
//!
//! Every thermal model is a little wrong everywhere: nodes have gradients, exchange areas are estimates. Such errors follow
//! the inputs as effects do, and some effect of a catalogue follows them better than the noise allows by chance. What tells a missing effect from
//! them is its size: it explains far more than what is left beside it, and not far less than another that is missing.

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
    /// Effects that are small beside the strongest one of the selected set, or beside the model error that is left.
    pub(super) fn small_effects(&self) -> Vec<usize> {
        let refits = &self.state.refits;
        let chosen = &refits[self.selected];
        let gain = |effect: usize| {
            let (before, after) = self.step_of(effect).or_else(|| self.best_with(effect))?;
            Some(refits[before].chi_square - refits[after].chi_square)
        };
        let strongest = chosen.effects.iter().filter_map(|&effect| gain(effect)).fold(0.0, f64::max);
        let left = self.left_by_model_error(chosen);
        let mut effects: Vec<usize> = refits.iter().flat_map(|refit| refit.effects.iter().copied()).collect();
        effects.sort_unstable();
        effects.dedup();
        effects.retain(|&effect| gain(effect).is_some_and(|gain| is_small(gain, strongest, left)));
        effects
    }

    /// The most probable set with an effect, after the one without it. `None` where that was not fitted.
    fn best_with(&self, effect: usize) -> Option<(usize, usize)> {
        let refits = &self.state.refits;
        let has = |place: &usize| refits[*place].effects.contains(&effect);
        let better = |a: usize, b: usize| if self.weights.sets[b] > self.weights.sets[a] { b } else { a };
        let after = Some(self.selected).filter(has).or_else(|| (0..refits.len()).filter(has).reduce(better))?;
        let rest = refits[after].effects.iter().filter(|&&other| other != effect);
        let before = refits.iter().position(|refit| refit.effects.iter().eq(rest.clone()))?;
        Some((before, after))
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

/// Whether an effect with this gain is small beside the strongest, or beside the model error that is left.
fn is_small(gain: f64, strongest: f64, left: f64) -> bool {
    gain < LEAST_SHARE * strongest || gain < LEAST_OF_ERROR * left
}

#[cfg(test)]
mod tests {
    use super::is_small;

    #[test]
    fn an_effect_is_small_beside_a_stronger_one_or_beside_what_is_left() {
        assert!(!is_small(100.0, 100.0, 10.0));
        // Two effects of one size.
        assert!(!is_small(40.0, 60.0, 0.0));
        // A third of the strongest in readings is a ninth in squares.
        assert!(is_small(11.0, 100.0, 0.0));
        // It takes away less than half of the error.
        assert!(is_small(100.0, 100.0, 50.0));
    }
}
