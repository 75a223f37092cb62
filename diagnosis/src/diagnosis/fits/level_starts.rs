//! Starts of effects that are about a level of their nodes' own temperature, such as that at which something melts.

use std::collections::BTreeMap;

use crate::diagnosis::fits::refit::place;
use crate::diagnosis::linearisation::threshold_levels::thresholds;
use crate::diagnosis::{Problem, Refit};
use crate::effect::{EffectParameter, Like};
use crate::inference::target::{LeastSquares, Target};
use crate::math::sort::sort_by;

/// Sizes that are tried, in plausible ones.
const SHARES_OF_SIZE: [f64; 3] = [1.0, 0.1, 0.01];
/// Starts from which the effect is fitted, each at a level of its own.
const STARTS: usize = 3;

impl Problem {
    /// Where the fit of an effect begins that is about a level of its nodes' own temperature: far from the level nothing leads there.
    /// Those levels between the nodes' readings that err least beside the baseline model's fit, each with the plausible size or that
    /// part of it that errs least; none where there is no such level. The starts hold the effect's parameters.
    pub(crate) fn starts_at_levels(&self, baseline: &Refit, candidate: usize) -> Vec<BTreeMap<String, f64>> {
        let own = &self.candidates[candidate];
        let Some(effect) = self.catalogue.get(&own.effect) else { return Vec::new() };
        let parameters = effect.parameters(&self.model, &own.bound);
        let is_level = |parameter: &&EffectParameter| {
            let form = effect.form.parameters.get(&parameter.written);
            form.is_some_and(|form| effect.like(&form.value) == Some(Like::OwnTemperature))
        };
        let Some(level) = parameters.iter().find(is_level) else { return Vec::new() };
        let likelihood = self.hypothesis(&[candidate], 1.0).ok().and_then(|own| own.likelihood(self).ok());
        let Some(likelihood) = likelihood else { return Vec::new() };
        let mut memory = likelihood.workspace();
        let mut residuals = vec![0.0; likelihood.residual_count()];
        let mut tried: Vec<(f64, BTreeMap<String, f64>)> = Vec::new();
        for value in thresholds(self, own, effect, level).unwrap_or_default() {
            let at_level = SHARES_OF_SIZE.into_iter().filter_map(|share| {
                let mut own_start = BTreeMap::new();
                for parameter in &parameters {
                    let size = if parameter.amplitude { share * parameter.nominal } else { parameter.nominal };
                    own_start.insert(format!("{}.{}", own.id, parameter.name), size);
                }
                own_start.insert(format!("{}.{}", own.id, level.name), value);
                let start = baseline.by_name().into_iter().chain(own_start.clone()).collect();
                likelihood.residuals(&place(&likelihood, &start), &mut memory, &mut residuals).ok()?;
                Some((residuals.iter().map(|residual| residual * residual).sum::<f64>(), own_start))
            });
            tried.extend(at_level.reduce(|a, b| if b.0 < a.0 { b } else { a }));
        }
        sort_by(&mut tried, |a, b| a.0.total_cmp(&b.0));
        tried.into_iter().take(STARTS).map(|(_, start)| start).collect()
    }
}
