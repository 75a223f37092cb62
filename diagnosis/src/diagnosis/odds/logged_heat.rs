//! Heat that was logged beside a model that does not use it: a power or an irradiance among the inputs. Nobody logs the sun or the
//! power of a motor where it does not warm anything, so that heat in proportion to it is more probable than to another input.

use crate::diagnosis::Problem;
use crate::diagnosis::odds::medium::has_dimension;
use crate::effect::Candidate;
use crate::expression::Symbol;
use crate::thermal::{Input, Model};

/// Of each candidate whether it is heat in proportion to a power or an irradiance that no heat of the model depends on.
pub(crate) fn are_of_unused_heat(problem: &Problem) -> Vec<bool> {
    let model = &problem.model;
    let unused = unused_heats(model);
    let loads = problem.catalogue.effects().iter().filter(|effect| effect.is_proportional_load());
    let loads: Vec<&str> = loads.map(|effect| effect.name.as_str()).collect();
    let is_one = |own: &Candidate| {
        loads.contains(&own.effect.as_str()) && own.inputs(model).into_iter().any(|input| unused[input])
    };
    problem.candidates.iter().map(is_one).collect()
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
    has_dimension(input, "W") || has_dimension(input, "W/m^2")
}

/// Whether an input warms what it goes through: it is heat, or an electric current.
pub(crate) fn warms(input: &Input) -> bool {
    is_heat(input) || has_dimension(input, "A")
}
