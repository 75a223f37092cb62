//! What surrounds the hardware, as far as the model tells: effects that need a gas are improbable in vacuum, and surroundings that
//! are warmer than all else stand for a source.

use crate::diagnosis::Problem;
use crate::effect::Bound;
use crate::expression::{ExprId, Symbol, Unit};
use crate::measurement::Measurement;
use crate::thermal::element::{Drawing, Path};
use crate::thermal::{Input, Model, NodeKind};

/// Pressure below which nothing convects, Pa: a thousandth of the atmosphere's, where Rayleigh's number is a millionth.
const NO_CONVECTION_PA: f64 = 100.0;
/// Temperature of a boundary below which it is taken for space or a shroud in vacuum, K.
const NO_ROOM_K: f64 = 100.0;

/// Whether an input is a pressure.
pub(crate) fn is_pressure(input: &Input) -> bool {
    has_dimension(input, "Pa")
}

/// Whether an input is a temperature.
pub(crate) fn is_temperature(input: &Input) -> bool {
    has_dimension(input, "K")
}

/// Whether an input has the dimension of a unit.
pub(crate) fn has_dimension(input: &Input, of_unit: &str) -> bool {
    let dimension = |unit: &str| Unit::parse(unit).ok().map(|unit| unit.dimension);
    dimension(&input.unit) == dimension(of_unit)
}

/// Temperature above which no room is that the model does not show, K.
const WARM_ROOM_K: f64 = 300.0;
/// Temperature below which a boundary is no room, K.
const COLD_ROOM_K: f64 = 283.0;
/// By how much the surface of a room may be warmer than its air, K.
const WARMER_K: f64 = 3.0;

/// Temperatures of all boundaries of a model.
fn boundaries(model: &Model) -> Vec<ExprId> {
    let of = |node: &crate::thermal::Node| match node.kind {
        NodeKind::Boundary { temperature } => Some(temperature),
        NodeKind::Diffusion { .. } | NodeKind::Arithmetic => None,
    };
    model.nodes.iter().filter_map(of).collect()
}

/// Shows `visit` what inputs, nominal parameters and the time are in each row, until it answers false.
fn in_each_row(problem: &Problem, mut visit: impl FnMut(&dyn Fn(Symbol) -> f64) -> bool) {
    for measurement in &problem.measurements {
        for row in (0..measurement.len()).filter(|&row| !measurement.ignored(row)) {
            if !visit(&measurement.value_in(&problem.model, row)) {
                return;
            }
        }
    }
}

/// Temperatures in the first row of a measurement that no node's start states, K: of boundaries, and of inputs, which may stand
/// for surroundings that the model lacks.
pub(crate) fn surroundings_at_start(model: &Model, measurement: &Measurement) -> Vec<f64> {
    if measurement.is_empty() {
        return Vec::new();
    }
    let value = measurement.value_in(model, 0);
    let of_boundaries = boundaries(model).into_iter().map(|boundary| model.graph.evaluate(boundary, &value));
    let inputs = (0..).zip(&model.inputs).filter(|(_, input)| is_temperature(input));
    let of_inputs = inputs.map(|(own, _)| value(Symbol::Input(own)));
    of_boundaries.chain(of_inputs).filter(|temperature| temperature.is_finite()).collect()
}

/// Least and largest value, K, of each input that is a temperature, over all rows; of those that ever have one.
pub(crate) fn logged_temperatures(problem: &Problem) -> Vec<(usize, [f64; 2])> {
    let inputs = problem.model.inputs.iter().enumerate().filter(|(_, input)| is_temperature(input));
    let mut ranges: Vec<(usize, [f64; 2])> =
        inputs.map(|(input, _)| (input, [f64::INFINITY, f64::NEG_INFINITY])).collect();
    in_each_row(problem, |value| {
        for (input, [least, most]) in &mut ranges {
            let now = value(Bound::Input(*input).symbol());
            (*least, *most) = (least.min(now), most.max(now));
        }
        true
    });
    ranges.retain(|(_, [least, most])| least <= most);
    ranges
}

/// Whether the data were taken in vacuum: a boundary is colder than any room in some row, or a pressure among the inputs is
/// low in all rows. A model that says neither may be anywhere.
pub fn is_vacuum(problem: &Problem) -> bool {
    let model = &problem.model;
    let boundaries = boundaries(model);
    let pressures: Vec<usize> = (0..model.inputs.len()).filter(|&input| is_pressure(&model.inputs[input])).collect();
    if boundaries.is_empty() && pressures.is_empty() {
        return false;
    }
    let mut most_pa = vec![f64::NEG_INFINITY; pressures.len()];
    let mut is_cold = false;
    in_each_row(problem, |value| {
        is_cold = boundaries.iter().any(|&temperature| model.graph.evaluate(temperature, value) < NO_ROOM_K);
        for (most, &pressure) in most_pa.iter_mut().zip(&pressures) {
            *most = most.max(value(Bound::Input(pressure).symbol()));
        }
        !is_cold
    });
    is_cold || most_pa.iter().any(|&most| most.is_finite() && most < NO_CONVECTION_PA)
}

/// Words in names of nodes, inputs and elements, or in the title of a model, that tell of a gas or a liquid about the hardware.
const FLUIDS: [&str; 18] = [
    "air",
    "atmosphere",
    "convection",
    "fan",
    "flow",
    "gas",
    "greenhouse",
    "helium",
    "indoor",
    "nitrogen",
    "oil",
    "outdoor",
    "outside",
    "room",
    "ventilation",
    "water",
    "weather",
    "wind",
];

/// Whether a model may be that of a test in vacuum: heat is radiated in it, as it is there by whatever can lose any, and no name tells of a
/// gas or a liquid.
pub fn may_be_vacuum(model: &Model) -> bool {
    let radiates = model.elements.iter().any(|own| own.physics().drawing() == Drawing::Path(Path::Radiation));
    let nodes = model.nodes.iter().map(|own| own.name.as_str());
    let inputs = model.inputs.iter().map(|own| own.name.as_str());
    let elements = model.elements.iter().map(|own| own.name.as_str());
    let names = nodes.chain(inputs).chain(elements).chain([model.title.as_str()]);
    let mut words = names.flat_map(|name| name.split(|letter: char| !letter.is_alphabetic()));
    let is_fluid = |word: &str| {
        let word = word.to_lowercase();
        FLUIDS.iter().any(|fluid| word == *fluid || word.strip_suffix('s') == Some(*fluid))
    };
    radiates && !words.any(is_fluid)
}

/// Whether surroundings of this temperature, K, are warmer than all that the record shows around the hardware, and than a room
/// where no boundary is one: what keeps them warm is a source of heat, or a store.
pub fn is_source(problem: &Problem, surroundings_k: f64) -> bool {
    let model = &problem.model;
    let boundaries = boundaries(model);
    let mut hottest_k = f64::NEG_INFINITY;
    in_each_row(problem, |value| {
        hottest_k = boundaries.iter().map(|&own| model.graph.evaluate(own, value)).fold(hottest_k, f64::max);
        true
    });
    let warmest_k = if hottest_k < COLD_ROOM_K { WARM_ROOM_K } else { hottest_k };
    surroundings_k > warmest_k + WARMER_K
}
