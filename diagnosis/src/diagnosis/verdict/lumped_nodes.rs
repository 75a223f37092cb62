//! What lumped nodes explain: errors that every thermal network has, whatever noise is stated.
//!
//! A node has one temperature where the hardware has a gradient, exchange areas are estimates, and edges lose heat. What remains of
//! lumped models of spacecraft at their best is some 0.1 to 0.5 K, in proportion to what the temperatures vary by. An effect that
//! explains `g` times the squares that such errors make is one itself with the probability `1 / (1 + g / 3)`, at most a half, as
//! beside a model error that is allowed for ([`crate::diagnosis::verdict::small_effects`]).
//!
//! A sensor that is pulled towards another temperature reads what one off the middle of a node with a gradient reads. No data tell
//! the two apart.

use std::collections::BTreeMap;

use crate::diagnosis::engine::SensorNoise;
use crate::diagnosis::problem::FittedReading;
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::small_effects::{AS_LIKELY, IS_MODEL_ERROR};
use crate::diagnosis::{PRIOR_OF, Problem};
use crate::effect::Effect;
use crate::math::functions::sqrt;

/// Standard deviation of the errors of lumped nodes, as a share of that of a thermometer's readings: 0.06 K where these vary by 20 K.
/// A convention.
const LUMPED: f64 = 0.003;

impl Findings<'_> {
    /// Probability that lumped nodes are what an effect explains, of each effect that was fitted.
    pub(super) fn lumped_nodes(&self) -> BTreeMap<usize, f64> {
        let as_likely = AS_LIKELY * self.squares_of_lumped_nodes();
        let mut effects: Vec<usize> =
            self.state.refits.iter().flat_map(|refit| refit.effects.iter().copied()).collect();
        effects.sort_unstable();
        effects.dedup();
        // A prior that is too narrow is no error of the model's parts.
        effects.retain(|&effect| self.problem.candidates[effect].effect != PRIOR_OF);
        let one = |effect: usize| {
            if is_like_gradient(self.problem, effect) {
                return Some((effect, IS_MODEL_ERROR));
            }
            Some((effect, probability(as_likely, self.gain(effect)?)))
        };
        effects.into_iter().filter_map(one).filter(|(_, probability)| *probability > 0.0).collect()
    }

    /// Whether lumped nodes may well be what an effect explains, and nothing else says that it may be none.
    pub(super) fn is_lumped_nodes_alone(&self, effect: usize) -> bool {
        self.lumped_nodes.get(&effect).is_some_and(|own| *own >= IS_MODEL_ERROR)
            && !self.is_small(effect)
            && !self.is_refused(effect)
    }

    /// Sum of squares, in those of the noise, that lumped nodes make in the fitted readings of thermometers.
    fn squares_of_lumped_nodes(&self) -> f64 {
        let readings = self.problem.fitted_readings();
        let lumped_k = lumped_k(self.problem);
        let of = |reading: &FittedReading| {
            let sensor = &self.problem.measurements[reading.measurement].sensors[reading.sensor];
            if !self.problem.model.quantities[sensor.quantity].is_temperature {
                return 0.0;
            }
            let same = |own: &&SensorNoise| own.measurement == reading.measurement && own.sensor == reading.sensor;
            let sd = self.state.noise.iter().find(same).map_or(sensor.total_sd(), |own| own.weighed().total());
            if sd > 0.0 { (lumped_k / sd) * (lumped_k / sd) } else { 0.0 }
        };
        readings.iter().map(of).sum()
    }
}

/// Standard deviation of the errors of lumped nodes in a problem's readings, K.
pub(super) fn lumped_k(problem: &Problem) -> f64 {
    LUMPED * typical_variation_k(problem, &problem.fitted_readings())
}

/// Whether a gradient within a node reads the same as an effect.
pub fn is_like_gradient(problem: &Problem, effect: usize) -> bool {
    problem.catalogue.get(&problem.candidates[effect].effect).is_some_and(Effect::is_like_gradient)
}

/// Probability of an effect with a gain in squares of being none, where one with the gain `as_likely` is as likely one as not.
pub fn probability(as_likely: f64, gain: f64) -> f64 {
    if gain < as_likely { IS_MODEL_ERROR } else { as_likely / (as_likely + gain).max(f64::MIN_POSITIVE) }
}

/// Standard deviation of a thermometer's fitted readings in all measurements together, median over the thermometers, K.
pub fn typical_variation_k(problem: &Problem, readings: &[FittedReading]) -> f64 {
    let mut thermometers: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for reading in readings {
        let measurement = &problem.measurements[reading.measurement];
        let quantity = measurement.sensors[reading.sensor].quantity;
        if problem.model.quantities[quantity].is_temperature {
            thermometers.entry(quantity).or_default().extend(measurement.reading(reading.row, reading.sensor));
        }
    }
    let deviation = |values: &Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        sqrt(values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / values.len() as f64)
    };
    let mut deviations: Vec<f64> = thermometers.values().filter(|values| !values.is_empty()).map(deviation).collect();
    deviations.sort_by(f64::total_cmp);
    deviations.get(deviations.len() / 2).copied().unwrap_or(0.0)
}
