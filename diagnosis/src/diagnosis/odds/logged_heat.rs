//! Heat that was logged: a power or an irradiance among the inputs. Beside a model that does not use it heat in proportion to it is
//! more probable than to another input: nobody logs the sun or the power of a motor where it does not warm anything. A power that
//! the model uses is what was read, at any temperature.

use crate::diagnosis::Problem;
use crate::diagnosis::odds::medium::has_dimension;
use crate::effect::{Bound, Candidate, Effect, Site};
use crate::expression::{Dependence, Graph, Symbol};
use crate::thermal::element::Element;
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
        for input in inputs(&symbols_of_heat(element, &mut graph)) {
            unused[input] = false;
        }
    }
    unused
}

/// What an element's heat depends on.
fn symbols_of_heat(element: &Element, graph: &mut Graph) -> Vec<Symbol> {
    let heats = element.contribution(graph, &mut Vec::new(), false).heat;
    heats.into_iter().flat_map(|(_, heat)| graph.symbols(heat)).collect()
}

/// The inputs among symbols.
fn inputs(symbols: &[Symbol]) -> Vec<usize> {
    let input = |symbol: &Symbol| if let Symbol::Input(input) = symbol { Some(*input as usize) } else { None };
    symbols.iter().filter_map(input).collect()
}

/// Of each candidate whether it lets paths, or loads whose heat goes with no input, follow inputs. An effect that states the unit of its
/// inputs is left out: it is meant for these.
pub(crate) fn are_changes_by_inputs(problem: &Problem) -> Vec<bool> {
    let model = &problem.model;
    let mut graph = model.graph.clone();
    let mut is_undriven = |element: &Element| {
        let physics = element.physics();
        let is_path = physics.between().is_some();
        is_path || physics.heated().is_some() && inputs(&symbols_of_heat(element, &mut graph)).is_empty()
    };
    let is_undriven: Vec<bool> = model.elements.iter().map(&mut is_undriven).collect();
    let is_factor = |effect: &Effect| {
        effect.form.adds.value.factor.is_some() && effect.form.inputs.iter().all(|input| input.value.unit.is_none())
    };
    let is_one = |own: &Candidate| {
        let Site::Elements(elements) = &own.site else { return false };
        problem.catalogue.get(&own.effect).is_some_and(is_factor)
            && !own.bound.is_empty()
            && elements.iter().all(|&element| is_undriven.get(element) == Some(&true))
    };
    problem.candidates.iter().map(is_one).collect()
}

/// Of each candidate whether it lets the power of loads or heaters follow their temperature, though all of them are made of logged powers
/// and of nothing else that changes.
pub(crate) fn are_laws_of_logged_power(problem: &Problem) -> Vec<bool> {
    let model = &problem.model;
    let mut graph = model.graph.clone();
    let mut is_logged = |element: &Element| {
        let symbols = symbols_of_heat(element, &mut graph);
        let follows_node = symbols.iter().any(|symbol| matches!(symbol, Symbol::Node(_)));
        let inputs = inputs(&symbols);
        let are_powers = inputs.iter().all(|&input| has_dimension(&model.inputs[input], "W"));
        element.physics().heated().is_some() && !follows_node && !inputs.is_empty() && are_powers
    };
    let is_logged: Vec<bool> = model.elements.iter().map(&mut is_logged).collect();
    let laws = problem.catalogue.effects().iter().filter(|effect| follows_temperature(effect));
    let laws: Vec<&str> = laws.map(|effect| effect.name.as_str()).collect();
    let is_one = |own: &Candidate| {
        let Site::Elements(elements) = &own.site else { return false };
        laws.contains(&own.effect.as_str()) && elements.iter().all(|&element| is_logged.get(element) == Some(&true))
    };
    problem.candidates.iter().map(is_one).collect()
}

/// Of each candidate whether it follows the heat of some elements, such as heaters under control: by an input on which that heat depends, or as
/// a change of it by more than a constant share. Where a control makes the heat, that follows whatever is missing.
pub(crate) fn follow_heat_of(problem: &Problem, elements: &[usize]) -> Vec<bool> {
    let model = &problem.model;
    let mut graph = model.graph.clone();
    let own = elements.iter().filter_map(|&element| model.elements.get(element));
    let given: Vec<usize> = own.flat_map(|element| inputs(&symbols_of_heat(element, &mut graph))).collect();
    let is_given = |bound: &Bound| matches!(bound, Bound::Input(input) if given.contains(input));
    let changes_heat = |own: &Candidate| {
        let Site::Elements(changed) = &own.site else { return false };
        let varies = |effect: &Effect| {
            effect.form.adds.value.factor.is_some() && (!own.bound.is_empty() || follows_temperature(effect))
        };
        problem.catalogue.get(&own.effect).is_some_and(varies)
            && changed.iter().any(|element| elements.contains(element))
    };
    problem.candidates.iter().map(|own| own.bound.iter().any(is_given) || changes_heat(own)).collect()
}

/// Whether an effect is a factor that depends on temperatures, and on no input.
fn follows_temperature(effect: &Effect) -> bool {
    let mut graph = Graph::new();
    effect.factor(&mut graph).is_some_and(|factor| {
        let dependence = graph.dependence(factor);
        dependence.intersects(Dependence::NODE) && !dependence.intersects(Dependence::INPUT)
    })
}

/// Whether an input is a power or an irradiance.
fn is_heat(input: &Input) -> bool {
    has_dimension(input, "W") || has_dimension(input, "W/m^2")
}

/// Least frequency, Hz, that is taken for that of electronics: no fan, pump or wheel turns a million times a second.
const LEAST_OF_ELECTRONICS_HZ: f64 = 1e6;

/// Whether an input is a frequency of electronics, such as that of a processor, by the end of its stated range or else its nominal value:
/// their dissipation follows it.
fn is_of_electronics(input: &Input) -> bool {
    let most = input.range.map_or(input.nominal, |[_, most]| most);
    has_dimension(input, "Hz") && most >= LEAST_OF_ELECTRONICS_HZ
}

/// Whether an input warms what it goes through: it is heat, an electric current or a frequency of electronics.
pub(crate) fn warms(input: &Input) -> bool {
    is_heat(input) || has_dimension(input, "A") || is_of_electronics(input)
}
