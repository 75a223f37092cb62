//! Heat that was logged beside a model that does not use it: a power or an irradiance among the inputs. Nobody logs the sun or the
//! power of a motor where it does not warm anything, so that heat in proportion to it is more probable than to another input.

use crate::diagnosis::Problem;
use crate::effect::Candidate;
use crate::expression::{Symbol, Unit};
use crate::thermal::{Input, Model};

/// How an effect's heat goes with a power or an irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OfHeat {
    /// In proportion to one that no heat of the model depends on.
    ProportionalToUnused,
    /// Not in proportion, as by the square: heat becomes no other amount of heat.
    NotProportional,
}

/// Of each candidate how its heat goes with a power or an irradiance; `None` where it depends on none, or on another input too.
pub(crate) fn of_heat(problem: &Problem) -> Vec<Option<OfHeat>> {
    let model = &problem.model;
    let unused = unused_heats(model);
    let of = |candidate: &Candidate| {
        let effect = problem.catalogue.get(&candidate.effect)?;
        let [input] = candidate.inputs(model)[..] else { return None };
        if !is_heat(&model.inputs[input]) || effect.form.adds.value.load.is_none() {
            return None;
        }
        match (effect.is_proportional_load(), unused[input]) {
            (true, true) => Some(OfHeat::ProportionalToUnused),
            (true, false) => None,
            (false, _) => Some(OfHeat::NotProportional),
        }
    };
    problem.candidates.iter().map(of).collect()
}

/// Of each input of a model whether it is a power or an irradiance that no heat in the model depends on; of no input of a model
/// that another program answers for, since what that uses is not known.
fn unused_heats(model: &Model) -> Vec<bool> {
    let mut graph = model.graph.clone();
    let mut unused: Vec<bool> = model.inputs.iter().map(|input| model.external.is_none() && is_heat(input)).collect();
    for element in &model.elements {
        for (_, heat) in element.contribution(&mut graph, &mut Vec::new(), false).heat {
            for symbol in graph.symbols(heat) {
                if let Symbol::Input(input) = symbol {
                    unused[input as usize] = false;
                }
            }
        }
    }
    unused
}

/// Whether an input is a power or an irradiance.
fn is_heat(input: &Input) -> bool {
    let dimension = |unit: &str| Unit::parse(unit).ok().map(|unit| unit.dimension);
    ["W", "W/m^2"].into_iter().any(|unit| dimension(&input.unit) == dimension(unit))
}
