//! Tests of `src/job/conventional/run.rs`.

use std::sync::Arc;

use bmv::expression::{Binary, Graph, Symbol};
use bmv::job::conventional::Spec;
use bmv::job::conventional::run::*;
use bmv::random::Distribution;
use bmv::study::requirement::Requirement;
use bmv::study::variable::{Sweep, Variable};
use bmv::thermal::{Model, Parameter, Quantity, QuantityValue};

/// An algebraic model of one quantity over parameters `load` (nominal 10) and `bend` (nominal 0), and a size.
fn job(quantity: impl Fn(&mut Graph, [bmv::expression::ExprId; 3]) -> bmv::expression::ExprId) -> Conventional {
    let mut model = Model::default();
    let symbols = [0, 1, 2].map(|i| model.graph.symbol(Symbol::Parameter(i)));
    let value = quantity(&mut model.graph, symbols);
    for (name, nominal) in [("load", 10.0), ("bend", 0.0), ("size", 1.0)] {
        model.parameters.push(Parameter {
            name: name.into(),
            unit: "1".into(),
            nominal,
            description: String::new(),
            source: String::new(),
        });
    }
    model.quantities.push(Quantity {
        name: "q".into(),
        unit: "K".into(),
        is_temperature: false,
        value: QuantityValue::Instant(value),
    });
    let spec = Spec {
        rules: Vec::new(),
        environments: Vec::new(),
        requirements: Vec::new(),
        design: Sweep {
            name: "size".into(),
            unit: "1".into(),
            variable: Variable::Parameter(2),
            values: vec![0.1, 10.0],
        },
        heat_loads: vec![Variable::Parameter(0)],
        correlation: None,
        knowledge: None,
    };
    let priors = vec![
        Distribution::Uniform { lower: 9.0, upper: 11.0 },
        Distribution::Uniform { lower: -1.0, upper: 1.0 },
        Distribution::Fixed(1.0),
    ];
    Conventional::new(spec, Arc::new(model), priors).expect("a job")
}

fn requirement(below: Option<f64>, above: Option<f64>) -> Requirement {
    Requirement { name: "r".into(), quantity: 0, below, above, probability: 0.99 }
}

fn nominal() -> Point {
    Point { parameters: vec![10.0, 0.0, 1.0], inputs: Vec::new() }
}

#[test]
fn a_heat_load_margin_is_less_heat_for_a_limit_against_cold() {
    let job = job(|graph, [load, _, size]| graph.divide(load, size));
    let mut workspace = job.network.workspace();
    let mut at = |r: Requirement| job.loaded(&mut workspace, &nominal(), &r, 0.25).expect("a point").parameters[0];
    assert_eq!(at(requirement(Some(20.0), None)), 12.5);
    assert_eq!(at(requirement(None, Some(5.0))), 7.5);
}

#[test]
fn nominal_is_the_worst_where_both_ends_are_milder() {
    // q = load - 4 bend^2: either end of `bend` lowers it.
    let job = job(|graph, [load, bend, _]| {
        let (two, four) = (graph.number(2.0), graph.number(4.0));
        let square = graph.binary(Binary::Power, bend, two);
        let drop = graph.multiply(four, square);
        graph.subtract(load, drop)
    });
    let mut workspace = job.network.workspace();
    let (hot, _) = job.stack(&mut workspace, &nominal(), &requirement(Some(20.0), None)).expect("a stack");
    assert_eq!(hot.parameters, [11.0, 0.0, 1.0]);
    let (cold, ends) = job.stack(&mut workspace, &nominal(), &requirement(None, Some(5.0))).expect("a stack");
    assert_eq!(cold.parameters[0], 9.0);
    assert_eq!(ends[0].effect, -4.0);
}
