//! Effects that hold a node at a temperature: those with a threshold of a simulated temperature, which are fitted where the readings
//! dwell. Where a control of a logged heat holds the readings, as heaters of tests are controlled, such an effect keeps the simulated node
//! there whatever is missing (on data in closed loop: Forssell & Ljung 1999, Automatica 35, 1215), so that what it explains is no evidence
//! of it.

use std::collections::BTreeMap;

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
/// The least share of its largest value that a controlled heat has at the level, on average: what is off holds nothing.
const LEAST_AT_LEVEL: f64 = 0.02;
/// The least standard deviation of a controlled heat at the level, in shares of its mean there: what is set and stays controls nothing.
const LEAST_CHANGES: f64 = 0.02;
/// Readings beside which the heat is evaluated; of more every so many.
const MOST_READINGS: usize = 500;

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

    /// The elements whose heat a control makes that holds readings at a level. Readings with their measurements and rows, in the order of
    /// time in each; which of them are at the level.
    fn controlled(&self, readings: &[(usize, usize, f64)], level_k: f64, at_level: &[bool]) -> Vec<usize> {
        let far_k = LARGEST_BAND * range(readings.iter().map(|own| own.2));
        let mut runs: BTreeMap<usize, Vec<(usize, f64, bool)>> = BTreeMap::new();
        for (&(measurement, row, reading_k), &is_there) in readings.iter().zip(at_level) {
            runs.entry(measurement).or_default().push((row, reading_k, is_there));
        }
        // What passes the level in another run does not dwell there.
        let dwells = |run: &Vec<(usize, f64, bool)>| {
            run.iter().filter(|own| own.2).count() as f64 >= DWELLING * run.len() as f64
        };
        runs.retain(|_, run| dwells(run));
        let every = readings.len().div_ceil(MOST_READINGS).max(1);
        let mut graph = self.model.graph.clone();
        let all: Vec<(usize, Vec<ExprId>)> =
            (0..self.model.elements.len()).map(|element| (element, self.heats(element, &mut graph))).collect();
        let heat_is_controlled = |heats: &[ExprId]| {
            if heats.is_empty() {
                return false;
            }
            let mut heat = Heat::default();
            for (&measurement, run) in &runs {
                let reached = run.iter().position(|own| own.2).unwrap_or(run.len());
                for (position, &(row, reading_k, is_there)) in run.iter().enumerate().step_by(every) {
                    let value = value_in_row(&self.model, &self.measurements[measurement], row);
                    let value = |symbol| if let Symbol::Node(_) = symbol { reading_k } else { value(symbol) };
                    let watts: f64 = heats.iter().map(|&own| graph.evaluate(own, &value)).sum();
                    // Heat leads to the level from below, cooling from above.
                    let is_before = position < reached && watts * (level_k - reading_k) > 0.0;
                    heat.add(watts, is_before && (level_k - reading_k).abs() > far_k, is_there);
                }
            }
            is_controlled(&heat.before, &heat.at_level, heat.largest)
        };
        all.into_iter().filter(|(_, heats)| heat_is_controlled(heats)).map(|(element, _)| element).collect()
    }

    /// The heat of an element into nodes with a balance, W; none of conductors and radiations.
    fn heats(&self, element: usize, graph: &mut Graph) -> Vec<ExprId> {
        let has_balance =
            |node: usize| self.model.nodes.get(node).is_some_and(|own| !matches!(own.kind, NodeKind::Boundary { .. }));
        let own = &self.model.elements[element];
        if own.physics().is_passive() {
            return Vec::new();
        }
        let all = own.contribution(graph, &mut Vec::new(), false).heat;
        all.into_iter().filter(|&(node, _)| has_balance(node)).map(|(_, heat)| heat).collect()
    }
}

/// A heat as readings come to a level and dwell there, W.
#[derive(Default)]
struct Heat {
    before: Vec<f64>,
    at_level: Vec<f64>,
    largest: f64,
}

impl Heat {
    fn add(&mut self, watts: f64, is_before: bool, is_at_level: bool) {
        if !watts.is_finite() {
            return;
        }
        self.largest = self.largest.max(watts.abs());
        if is_at_level {
            self.at_level.push(watts.abs());
        } else if is_before {
            self.before.push(watts.abs());
        }
    }
}

/// Whether a control makes a heat, from its sizes (W) before the readings come near the level, those while they dwell there, and the
/// largest of all: it is nearly as large as it ever is before, clearly less at the level, and neither off nor constant there.
pub fn is_controlled(before: &[f64], at_level: &[f64], largest: f64) -> bool {
    let mean = |heats: &[f64]| heats.iter().sum::<f64>() / heats.len().max(1) as f64;
    let there = mean(at_level);
    let variance = mean(&at_level.iter().map(|heat| (heat - there) * (heat - there)).collect::<Vec<_>>());
    mean(before) >= NEARLY_ALL * largest
        && mean(before) >= MORE_BEFORE * there
        && there > LEAST_AT_LEVEL * largest
        && variance.sqrt() >= LEAST_CHANGES * there
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
