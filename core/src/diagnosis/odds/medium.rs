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
pub(crate) fn is_vacuum(problem: &Problem) -> bool {
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::diagnosis::odds::prior_odds::PriorOdds;
    use crate::document::Diagnostics;
    use crate::effect::{Bound, Catalogue};
    use crate::math::functions::ln;
    use crate::twin::{InjectionRequest, Recipe, TestKind, Topology, case};

    /// A star in a chamber full of air, everything at 290 K.
    fn warm() -> Problem {
        let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
        let request = InjectionRequest { effects: 0, size: None, ..InjectionRequest::default() };
        let recipe = Recipe::of(Topology::Star, TestKind::Steady, request);
        let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
        let mut model = (*problem.model).clone();
        let room = model.graph.number(290.0);
        for node in &mut model.nodes {
            if let NodeKind::Boundary { temperature } = &mut node.kind
                && model.graph.symbols(*temperature).is_empty()
            {
                *temperature = room;
            }
        }
        problem.model = Arc::new(model);
        let inputs = problem.model.inputs.clone();
        for measurement in &mut problem.measurements {
            let Rows::Steady(phases) = &mut measurement.rows else { panic!("steady phases") };
            for phase in phases {
                for (value, input) in phase.inputs.iter_mut().zip(&inputs) {
                    match input.unit.as_str() {
                        "K" => *value = 290.0,
                        "Pa" => *value = 1e5,
                        _ => {}
                    }
                }
            }
        }
        problem
    }

    fn set(problem: &mut Problem, name: &str, value: f64) {
        let input = problem.model.inputs.iter().position(|input| input.name == name).unwrap();
        let Rows::Steady(phases) = &mut problem.measurements[0].rows else { panic!("steady phases") };
        phases[0].inputs[input] = value;
    }

    fn id_odds(problem: &Problem, effect: &str) -> f64 {
        let candidate = problem.candidates.iter().position(|own| own.effect == effect).unwrap();
        PriorOdds::new(problem).of(problem, &[candidate])
    }

    #[test]
    fn a_cold_shroud_tells_of_vacuum_and_convection_is_improbable_there() {
        let mut problem = warm();
        assert!(!is_vacuum(&problem));
        let alike = id_odds(&problem, "convection") - id_odds(&problem, "conductive-path");
        set(&mut problem, "T_shroud", 120.0);
        assert!(!is_vacuum(&problem));
        set(&mut problem, "T_shroud", 80.0);
        assert!(is_vacuum(&problem));
        let behind = id_odds(&problem, "convection") - id_odds(&problem, "conductive-path");
        assert!((alike - behind - 3.0).abs() < 1e-12, "{alike} {behind}");
    }

    #[test]
    fn a_low_pressure_tells_of_vacuum_and_is_no_source_of_heat() {
        let mut problem = warm();
        let heater = problem.model.inputs.iter().position(|input| input.unit == "W").unwrap();
        let mut model = (*problem.model).clone();
        model.inputs[heater].unit = "mbar".to_owned();
        let name = model.inputs[heater].name.clone();
        let of_it = |problem: &Problem| {
            let own = |own: &crate::effect::Candidate| {
                own.effect == "input-proportional-load" && own.bound == [Bound::Input(heater)]
            };
            let candidate = problem.candidates.iter().position(own).unwrap();
            PriorOdds::new(problem).of(problem, &[candidate])
        };
        let before = of_it(&problem);
        problem.model = Arc::new(model);
        let Rows::Steady(phases) = &mut problem.measurements[0].rows else { panic!("steady phases") };
        phases.iter_mut().for_each(|phase| phase.inputs[heater] = 1e-3);
        assert!(is_vacuum(&problem));
        set(&mut problem, &name, 1e5);
        assert!(!is_vacuum(&problem), "one phase in air");
        assert!((before - of_it(&problem) - 3.0).abs() < 1e-12 && before > ln(1e-6));
    }
}
