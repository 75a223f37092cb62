//! Effects that hold a node at a temperature: those with a threshold of a simulated temperature, which are fitted where the readings
//! dwell. Where a control of a logged heat holds the readings, as heaters of tests are controlled, such an effect keeps the simulated node
//! there whatever is missing (on data in closed loop: Forssell & Ljung 1999, Automatica 35, 1215), so that what it explains is no evidence of it.

use std::collections::BTreeSet;

use crate::diagnosis::linearisation::threshold_levels::readings_in_transients;
use crate::diagnosis::odds::medium::value_in_row;
use crate::diagnosis::{Problem, Refit};
use crate::effect::EffectParameter;
use crate::effect::place::TEMPERATURE_RANGE_K;
use crate::expression::{ExprId, Graph, Symbol};
use crate::thermal::NodeKind;

/// Half width of the band about a threshold, K: that over which thresholds of a node's temperature are spread.
const BAND_K: f64 = 0.01 * (TEMPERATURE_RANGE_K[1] - TEMPERATURE_RANGE_K[0]);
/// The least and the largest half width, in shares of the range of the readings; beyond the latter readings are not near the level.
const LEAST_BAND: f64 = 0.025;
const LARGEST_BAND: f64 = 0.1;
/// Share of the readings within the band from which they dwell there: more than evenly spread ones have in any band.
const DWELLING: f64 = 0.25;
/// Share of its largest value that a controlled heat has on the way to the level, on average: a control gives what it can until then.
const NEARLY_ALL: f64 = 0.75;
/// How many times that is what a controlled heat has at the level.
const MORE_BEFORE: f64 = 1.2;

/// A temperature at which an effect of a fit holds a node while its readings dwell there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldLevel {
    /// The temperature, K.
    pub level_k: f64,
    /// Whether a control of a logged heat holds the readings there: on the way to the level the heat is nearly as large as it ever is, and
    /// at the level clearly less.
    pub by_logged_heat: bool,
}

impl Problem {
    /// Where an effect of a fit holds a temperature: a threshold of a simulated temperature at which the readings of its nodes dwell in the
    /// fitted rows of transients. `None` where it has no such threshold, and where nothing dwells there.
    pub fn held_level(&self, refit: &Refit, effect: usize) -> Option<HeldLevel> {
        let candidate = &self.candidates[effect];
        let file = self.catalogue.get(&candidate.effect)?;
        let held = |parameter: &EffectParameter| {
            let level_k = *refit.by_name().get(&format!("{}.{}", candidate.id, parameter.name))?;
            let readings = readings_in_transients(self, candidate, file, parameter)?;
            let at_level = at_level(&readings.iter().map(|own| own.2).collect::<Vec<_>>(), level_k)?;
            Some(HeldLevel { level_k, by_logged_heat: self.is_controlled(&readings, level_k, &at_level) })
        };
        file.parameters(&self.model, &candidate.bound).iter().filter(|own| !own.amplitude).find_map(held)
    }

    /// Whether the logged heat is nearly as large as it ever is before readings come near a level, and clearly less while they dwell
    /// there. Readings with their measurements and rows, in the order of time in each; which of them are at the level.
    fn is_controlled(&self, readings: &[(usize, usize, f64)], level_k: f64, at_level: &[bool]) -> bool {
        let far_k = LARGEST_BAND * range(readings.iter().map(|own| own.2));
        let mut graph = self.model.graph.clone();
        let heats: Vec<ExprId> = self.heats(&mut graph);
        let (mut before, mut dwelling, mut largest) = (Vec::new(), Vec::new(), 0.0_f64);
        let mut reached = BTreeSet::new();
        for (&(measurement, row, reading_k), &is_there) in readings.iter().zip(at_level) {
            let value = value_in_row(&self.model, &self.measurements[measurement], row);
            let value = |symbol| if let Symbol::Node(_) = symbol { reading_k } else { value(symbol) };
            let heat_w: f64 =
                heats.iter().map(|&heat| graph.evaluate(heat, &value)).filter(|heat| heat.is_finite()).sum();
            largest = largest.max(heat_w.abs());
            if is_there {
                reached.insert(measurement);
                dwelling.push(heat_w.abs());
            } else if !reached.contains(&measurement) && (reading_k - level_k).abs() > far_k {
                before.push(heat_w.abs());
            }
        }
        let mean = |heats: &[f64]| heats.iter().sum::<f64>() / heats.len() as f64;
        !before.is_empty()
            && mean(&before) >= NEARLY_ALL * largest
            && mean(&before) >= MORE_BEFORE * mean(&dwelling)
            && largest > 0.0
    }

    /// The heat into all nodes with a balance, W. Where all nodes have one temperature conductors and radiations carry none, so that the
    /// heat of loads, heaters and flows is left.
    fn heats(&self, graph: &mut Graph) -> Vec<ExprId> {
        let has_balance =
            |node: usize| self.model.nodes.get(node).is_some_and(|own| !matches!(own.kind, NodeKind::Boundary { .. }));
        let all =
            self.model.elements.iter().flat_map(|element| element.contribution(graph, &mut Vec::new(), false).heat);
        all.filter(|&(node, _)| has_balance(node)).map(|(_, heat)| heat).collect()
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

/// Between the least and the largest of some readings.
fn range(readings: impl Iterator<Item = f64>) -> f64 {
    let [least, most] =
        readings.fold([f64::INFINITY, f64::NEG_INFINITY], |ends, own| [ends[0].min(own), ends[1].max(own)]);
    most - least
}
