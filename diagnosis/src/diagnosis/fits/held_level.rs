//! Effects that hold a node at a temperature: those with a threshold of a simulated temperature, which are fitted where the readings
//! dwell. Where a control of a logged heat holds the readings, as heaters of tests are controlled, such an effect keeps the simulated node
//! there whatever is missing (on data in closed loop: Forssell & Ljung 1999, Automatica 35, 1215), so that what it explains is no evidence
//! of it.

use crate::diagnosis::linearisation::threshold_levels::{ends, readings_in_transients};
use crate::diagnosis::{Problem, Refit};
use crate::effect::EffectParameter;
use crate::effect::place::TEMPERATURE_RANGE_K;

/// Half width of the band about a threshold, K: that over which thresholds of a node's temperature are spread.
const BAND_K: f64 = 0.01 * (TEMPERATURE_RANGE_K[1] - TEMPERATURE_RANGE_K[0]);
/// The least and the largest half width, in shares of the range of the readings; beyond the latter readings are not near the level.
const LEAST_BAND: f64 = 0.025;
pub(super) const LARGEST_BAND: f64 = 0.1;
/// Share of the readings within the band from which they dwell there: more than evenly spread ones have in any band.
pub(super) const DWELLING: f64 = 0.25;
/// A temperature at which an effect of a fit holds a node while its readings dwell there.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldLevel {
    /// The temperature, K.
    pub level_k: f64,
    /// The elements whose heat a control makes that holds the readings there.
    pub controlled: Vec<usize>,
}

impl HeldLevel {
    /// Whether it is at the same temperature as another, as far as thresholds are spread.
    pub fn is_at(&self, other: &Self) -> bool {
        (self.level_k - other.level_k).abs() <= 2.0 * BAND_K
    }
}

impl Problem {
    /// Where an effect of a fit holds a temperature: a threshold of a simulated temperature at which the readings of its nodes dwell in the
    /// fitted rows of transients, one under control before others. `None` where it has no such threshold, and where nothing dwells there.
    pub fn held_level(&self, refit: &Refit, effect: usize) -> Option<HeldLevel> {
        let candidate = &self.candidates[effect];
        let file = self.catalogue.get(&candidate.effect)?;
        if file.form.parameters.iter().all(|own| own.value.unit_of.is_none()) {
            return None;
        }
        let held = |parameter: &EffectParameter| {
            let readings = readings_in_transients(self, candidate, file, parameter)?;
            let level_k = *refit.by_name().get(&format!("{}.{}", candidate.id, parameter.name))?;
            let at_level = at_level(&readings.iter().map(|own| own.2).collect::<Vec<_>>(), level_k)?;
            Some(HeldLevel { level_k, controlled: self.controlled(&readings, level_k, &at_level) })
        };
        let parameters = file.parameters(&self.model, &candidate.bound);
        let levels = parameters.iter().filter(|own| !own.amplitude).filter_map(held);
        levels.reduce(|a, b| if a.controlled.is_empty() { b } else { a })
    }
}

/// Which readings, K, lie in the band about a level; `None` where these are less than a quarter of them.
pub fn at_level(readings: &[f64], level_k: f64) -> Option<Vec<bool>> {
    let range = range(readings.iter().copied());
    if !(range > 0.0) {
        return None;
    }
    let band_k = BAND_K.clamp(LEAST_BAND * range, LARGEST_BAND * range);
    let at_level: Vec<bool> = readings.iter().map(|&own| (own - level_k).abs() <= band_k).collect();
    let dwell = at_level.iter().filter(|&&own| own).count() as f64 >= DWELLING * readings.len() as f64;
    dwell.then_some(at_level)
}

/// Between the least and the largest of some readings; 0 without any.
pub(super) fn range(readings: impl Iterator<Item = f64>) -> f64 {
    ends(readings).map_or(0.0, |[least, most]| most - least)
}
