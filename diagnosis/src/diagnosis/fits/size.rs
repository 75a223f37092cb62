//! Which effects are larger than plausible.
//!
//! The catalogue knows the sizes of a small spacecraft's hardware. In a larger thing, or one that is driven harder, an effect may
//! well be a hundred times as large: what counts there is the heat that it carries beside the heat that the model moves. A part that stores
//! far more than the model is a sink by another name, whatever heat it carries.

use crate::diagnosis::fits::effect_heat_flow::largest_heat;
use crate::diagnosis::fits::refit::Amplitude;
use crate::diagnosis::{Problem, Refit};
use crate::expression::{Dimension, Unit};
use crate::measurement::prediction::{Predictor, RowHeat};

/// Times what a model stores per kelvin that a part which it lacks may store: a case of a winding, the walls of a room. A convention.
const STORES_AT_MOST: f64 = 10.0;

/// Whether an effect of a fitted set carries heat, no more of it into any node than the whole model moves in any row, and stores no
/// more than ten times what the model stores. Not where its amplitudes are factors: these are relative to the model as it is.
pub(crate) fn is_within_model(problem: &Problem, refit: &Refit, effect: usize, amplitudes: &[&Amplitude]) -> bool {
    let with_unit = amplitudes.iter().filter_map(|own| Some((Unit::parse(&own.unit).ok()?, own.mode)));
    let of_hardware: Vec<(Unit, f64)> = with_unit.filter(|(unit, _)| is_of_hardware(unit.dimension)).collect();
    if of_hardware.is_empty() {
        return false;
    }
    let capacities = of_hardware.iter().filter(|(unit, _)| unit.dimension == Dimension::HEAT_CAPACITY);
    let stores_j_per_k = capacities.map(|(unit, mode)| unit.to_si(*mode)).fold(0.0, f64::max);
    let carried = largest_heat(problem, refit, effect);
    let within = |model: ModelSize| carried <= model.moved_w && stores_j_per_k <= STORES_AT_MOST * model.stores_j_per_k;
    carried > 0.0 && model_size(problem).is_some_and(within)
}

/// Whether a unit is one of heat, of what conducts or stores it, or of an area: what grows with the hardware.
pub fn is_of_hardware(dimension: Dimension) -> bool {
    dimension.mass_power() != 0.0 || dimension == Dimension::AREA
}

/// The size of a model, its parameters at their priors' medians.
struct ModelSize {
    /// The most heat that it moves in a row that is not left out, W.
    moved_w: f64,
    /// The capacities of its nodes together, J/K.
    stores_j_per_k: f64,
}

/// `None` where the model cannot be solved.
fn model_size(problem: &Problem) -> Option<ModelSize> {
    let predictor = Predictor::new(&problem.model, &[]).ok()?;
    let medians: Vec<f64> = problem.priors.iter().map(|prior| prior.quantile(0.5)).collect();
    let mut workspace = predictor.workspace();
    let mut most: Option<f64> = None;
    for measurement in &problem.measurements {
        for row in predictor.predict(&mut workspace, measurement, &medians).heat.iter().flatten() {
            most = Some(most.unwrap_or(0.0).max(moved(row)));
        }
    }
    let nodes = predictor.network().node_heat(&mut workspace);
    let stores_j_per_k = nodes.iter().filter_map(|node| node.capacity_j_per_k).sum();
    most.filter(|most| most.is_finite()).map(|moved_w| ModelSize { moved_w, stores_j_per_k })
}

/// Heat that goes through a network: what comes in goes out or stays, so that each watt is counted twice in their sum.
pub fn moved(row: &RowHeat) -> f64 {
    let boundaries: f64 = row.into_boundaries_w.iter().map(|(_, watts)| watts.abs()).sum();
    0.5 * (row.sources_w.abs() + boundaries + row.stored_w.abs())
}
