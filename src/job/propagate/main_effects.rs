//! Main effects of the parameters from the samples of a propagation: no further solve.

use super::Propagate;
use super::output::MainEffect;
use crate::statistics::given_data::main_effect;

/// Samples that are looked at, the first of all.
const MOST_SAMPLES: usize = 1 << 16;

impl Propagate {
    /// Main effects by quantity then parameter. `values` holds the samples of each quantity, NaN where a solution failed; the
    /// parameters' probabilities are drawn again from the point set.
    pub(super) fn main_effects(&self, values: &[Vec<f64>]) -> Vec<MainEffect> {
        let samples = values.first().map_or(0, Vec::len).min(MOST_SAMPLES);
        let width = self.uncertain.len();
        let mut rows = vec![0.0; width * samples];
        self.points.fill_rows(0, &mut rows);
        let mut effects = Vec::new();
        for (column, &quantity) in values.iter().zip(&self.spec.quantities) {
            for (position, &parameter) in self.uncertain.iter().enumerate() {
                let probabilities: Vec<f64> = rows.iter().skip(position).step_by(width).copied().collect();
                effects.extend(main_effect(&probabilities, &column[..samples]).map(|estimate| MainEffect {
                    quantity: self.model.quantities[quantity].name.clone(),
                    parameter: self.model.parameters[parameter].name.clone(),
                    estimate,
                }));
            }
        }
        effects
    }
}
