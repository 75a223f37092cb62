//! What surrounds the hardware, as far as the model tells: effects that need a gas are improbable in vacuum.

use crate::diagnosis::Problem;
use crate::expression::{Symbol, Unit};
use crate::measurement::Rows;
use crate::thermal::{Input, NodeKind};

/// Pressure below which nothing convects, Pa: a thousandth of the atmosphere's, where Rayleigh's number is a millionth.
const NO_CONVECTION_PA: f64 = 100.0;
/// Temperature of a boundary below which it is taken for space or a shroud in vacuum, K.
const NO_ROOM_K: f64 = 100.0;

/// Whether an input is a pressure.
pub(crate) fn is_pressure(input: &Input) -> bool {
    let dimension = |unit: &str| Unit::parse(unit).ok().map(|unit| unit.dimension);
    dimension(&input.unit) == dimension("Pa")
}

/// Whether the data were taken in vacuum: a boundary is colder than any room in some row, or a pressure among the inputs is
/// low in all rows. A model that says neither may be anywhere.
pub fn is_vacuum(problem: &Problem) -> bool {
    let model = &problem.model;
    let boundaries: Vec<_> = (model.nodes.iter())
        .filter_map(|node| match node.kind {
            NodeKind::Boundary { temperature } => Some(temperature),
            _ => None,
        })
        .collect();
    let pressures: Vec<usize> = (0..model.inputs.len()).filter(|&input| is_pressure(&model.inputs[input])).collect();
    if boundaries.is_empty() && pressures.is_empty() {
        return false;
    }
    let mut most_pa = vec![f64::NEG_INFINITY; pressures.len()];
    for measurement in &problem.measurements {
        for row in (0..measurement.len()).filter(|&row| !measurement.ignored(row)) {
            let (input, time_s): (Box<dyn Fn(usize) -> f64>, f64) = match &measurement.rows {
                Rows::Steady(phases) => {
                    (Box::new(move |own| phases[row].inputs.get(own).copied().unwrap_or(f64::NAN)), 0.0)
                }
                Rows::Transient { inputs, .. } => (Box::new(move |own| inputs.in_row(row, own)), inputs.times_s[row]),
            };
            let value = |symbol: Symbol| match symbol {
                Symbol::Input(own) => input(own as usize),
                Symbol::Parameter(own) => model.parameters[own as usize].nominal,
                Symbol::Time => time_s,
                _ => f64::NAN,
            };
            if boundaries.iter().any(|&temperature| model.graph.evaluate(temperature, &value) < NO_ROOM_K) {
                return true;
            }
            for (most, &pressure) in most_pa.iter_mut().zip(&pressures) {
                *most = most.max(input(pressure));
            }
        }
    }
    most_pa.iter().any(|&most| most.is_finite() && most < NO_CONVECTION_PA)
}
