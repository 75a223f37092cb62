//! What the data have tested: between which temperatures sensors read, and between which values inputs were set.

use crate::diagnosis::Problem;
use crate::thermal::Model;

/// A temperature this far beyond all readings is far from what was tested, K.
pub(super) const FAR_BEYOND_K: f64 = 30.0;
const ROOM_K: f64 = 293.15;

/// Between which temperatures sensors read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tested {
    /// K; nothing where no temperature was read.
    pub temperatures_k: Option<[f64; 2]>,
}

impl Tested {
    /// Of all readings.
    pub fn of(problem: &Problem) -> Self {
        let readings = problem.measurements.iter().flat_map(|own| {
            let of_temperature =
                |&sensor: &usize| problem.model.quantities[own.sensors[sensor].quantity].is_temperature;
            let sensors = (0..own.sensors.len()).filter(of_temperature);
            sensors.flat_map(move |sensor| (0..own.len()).filter_map(move |row| own.reading(row, sensor)))
        });
        Self { temperatures_k: readings.fold(None, wider) }
    }

    /// The highest temperature that was read, at least that of a room, K.
    pub fn warmest_k(self) -> f64 {
        self.temperatures_k.map_or(ROOM_K, |[_, high]| high.max(ROOM_K))
    }

    /// How far a temperature lies beyond all readings, K; below 0 within them.
    pub fn beyond_k(self, value: f64) -> f64 {
        self.temperatures_k.map_or(f64::NEG_INFINITY, |[low, high]| (value - high).max(low - value))
    }

    /// Whether a quantity of this value, K, is not far from what was tested, or is the temperature of a node whose limits say what
    /// is allowed. What is no temperature always is.
    pub fn is_near(self, model: &Model, quantity: usize, value: f64) -> bool {
        let is_limited = || {
            model
                .node_of(quantity)
                .is_some_and(|node| model.nodes.get(node).is_some_and(|node| node.limits.red.is_some()))
        };
        !model.quantities[quantity].is_temperature || self.beyond_k(value) <= FAR_BEYOND_K || is_limited()
    }
}

/// Between which values an input was set, SI, over all rows that are not left out; nothing without rows.
pub(super) fn input(problem: &Problem, index: usize) -> Option<[f64; 2]> {
    let values = problem.measurements.iter().flat_map(|own| {
        let rows = (0..own.len()).filter(|&row| !own.ignored(row));
        rows.filter_map(|row| own.level(&problem.model, row, index))
    });
    values.fold(None, wider)
}

/// A range with one value more.
fn wider(known: Option<[f64; 2]>, value: f64) -> Option<[f64; 2]> {
    let [low, high] = known.unwrap_or([value; 2]);
    Some([low.min(value), high.max(value)])
}
