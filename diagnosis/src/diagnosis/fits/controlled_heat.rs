//! Heats that a control makes: as heaters of tests are controlled, which hold a temperature. Such a heat is nearly as large as it ever is until
//! readings come to a level, and there it falls to what keeps them.

use std::collections::BTreeMap;

use crate::diagnosis::Problem;
use crate::diagnosis::fits::held_level::{DWELLING, LARGEST_BAND, range};
use crate::expression::{ExprId, Graph, Symbol};
use crate::thermal::NodeKind;

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

impl Problem {
    /// The elements whose heat a control makes that holds readings at a level. Readings with their measurements and rows, in the order of
    /// time in each; which of them are at the level.
    pub(super) fn controlled(&self, readings: &[(usize, usize, f64)], level_k: f64, at_level: &[bool]) -> Vec<usize> {
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
                    let value = self.measurements[measurement].value_in(&self.model, row);
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
