//! Tests of `core/src/thermal/external.rs`.

use bmv::expression::Symbol;
use bmv::thermal::external::*;
use bmv::thermal::network::Network;
use bmv::thermal::{Input, Model, Parameter, Quantity, QuantityValue, Start};
use std::fmt::Debug;
use std::sync::Arc;

/// `y = a^2 x` and `z = a x`, for `a` below 2.
#[derive(Debug)]
struct Formula;

impl Evaluator for Formula {
    fn ready(&self) -> Result<(), String> {
        Ok(())
    }

    fn evaluate(&self, points: &[Point]) -> Vec<Result<Vec<f64>, Fault>> {
        let at = |point: &Point| {
            let (a, x) = (point.parameters[0], point.inputs[0]);
            let fault = || Fault { what: "too large", detail: format!("{a}") };
            (a < 2.0).then(|| vec![a * a * x, a * x]).ok_or_else(fault)
        };
        points.iter().map(at).collect()
    }

    fn slopes(&self, asked: &[SlopesAt]) -> Vec<Result<Vec<f64>, Fault>> {
        let at = |asked: &SlopesAt| {
            let (a, x) = (asked.point.parameters[0], asked.point.inputs[0]);
            let fault = || Fault { what: "too large", detail: format!("{a}") };
            let each = [[2.0 * a * x, a * a], [x, a]];
            let slope = |row: [f64; 2]| asked.by.iter().map(move |&place| row[place]);
            match &asked.weights {
                None => (a < 2.0).then(|| each.into_iter().flat_map(slope).collect()).ok_or_else(fault),
                Some(w) => Ok(slope([0, 1].map(|by| w[0] * each[0][by] + w[1] * each[1][by])).collect()),
            }
        };
        asked.iter().map(at).collect()
    }

    fn broken(&self) -> Option<String> {
        None
    }
}

/// A model with the quantities `y` and `y + a z`.
fn network(derivatives: Derivatives) -> Network {
    let mut model = Model::default();
    model.parameters.push(Parameter {
        name: "a".into(),
        unit: "1".into(),
        nominal: 1.5,
        description: String::new(),
        source: String::new(),
    });
    model.inputs.push(Input {
        name: "x".into(),
        unit: "1".into(),
        nominal: 3.0,
        range: None,
        settable: true,
        description: String::new(),
    });
    let graph = &mut model.graph;
    let [a, y, z] = [Symbol::Parameter(0), Symbol::Output(0), Symbol::Output(1)].map(|symbol| graph.symbol(symbol));
    let product = graph.multiply(a, z);
    let sum = graph.add(y, product);
    for (name, value) in [("y", y), ("sum", sum)] {
        let value = QuantityValue::Instant(value);
        model.quantities.push(Quantity { name: name.into(), unit: "1".into(), is_temperature: false, value });
    }
    model.external = Some(External {
        outputs: 2,
        description: "a formula".into(),
        identity: serde_json::json!("formula"),
        steps: vec![1e-3, 1e-3],
        derivatives,
        errors: 0..0,
        evaluator: Some(Arc::new(Formula)),
    });
    Network::compile(&model, &[Symbol::Parameter(0), Symbol::Input(0)]).expect("compiled")
}

#[test]
fn slopes_are_differences_of_all_that_depends_on_a_symbol() {
    let network = network(Derivatives::StatedSteps);
    let mut workspace = network.workspace();
    network.solve_steady(&mut workspace, Start::Default).expect("solved");
    assert_eq!([0, 1].map(|quantity| network.quantity(&workspace, quantity)), [6.75, 13.5]);
    let mut tangent = [0.0; 4];
    network.quantity_tangent(&mut workspace, &mut tangent).expect("solved");
    // 2 a x, a^2, and twice that: central differences of a square are exact but for rounding over the step.
    for (slope, exact) in tangent.iter().zip([9.0, 2.25, 18.0, 4.5]) {
        assert!((slope - exact).abs() < 1e-10, "{tangent:?}");
    }
    assert_eq!(network.quantity(&workspace, 1), 13.5, "left as it was");
    let mut gradient = [0.0; 2];
    network.quantity_gradient(&mut workspace, &[1.0, -0.5], &mut gradient).expect("solved");
    assert!(gradient.iter().all(|slope| slope.abs() < 1e-10), "{gradient:?}");
    // Where only one side has an answer the error is of the step's order: x h.
    network.set_parameters(&mut workspace, &[1.9995]);
    network.solve_steady(&mut workspace, Start::Default).expect("solved");
    network.quantity_tangent(&mut workspace, &mut tangent).expect("solved");
    assert!((tangent[0] - 2.0 * 1.9995 * 3.0).abs() < 4e-3, "{tangent:?}");
}

#[test]
fn slopes_that_are_served_pass_through_the_quantities_alone_and_in_lanes() {
    let network = network(Derivatives::Served);
    let mut workspace = network.workspace();
    network.solve_steady(&mut workspace, Start::Default).expect("solved");
    let (mut tangent, mut gradient) = ([0.0; 4], [0.0; 2]);
    network.quantity_tangent(&mut workspace, &mut tangent).expect("solved");
    // By hand: dy = (2 a x, a^2), and d(y + a z) twice that, since a z = y. Nothing is rounded at a = 1.5, x = 3.
    assert_eq!(tangent, [9.0, 2.25, 18.0, 4.5]);
    network.quantity_gradient(&mut workspace, &[1.0, -0.25], &mut gradient).expect("solved");
    assert_eq!(gradient, [4.5, 1.125]);
    let mut batch = network.batch::<4>();
    for (lane, a) in [1.0, 2.5, 1.5].into_iter().enumerate() {
        batch.set_parameters(&network, lane, &[a]);
    }
    batch.use_lanes(3);
    network.solve_steady_batch(&mut batch, Start::Current);
    let mut tangents = vec![[0.0; 4]; 4];
    network.quantity_tangent_batch(&mut batch, &mut tangents);
    assert_eq!([0, 2].map(|lane| tangents[2][lane]), [12.0, 18.0]);
    assert!(tangents[2][1].is_nan(), "{tangents:?}");
    let mut gradients = vec![[0.0; 4]; 2];
    network.quantity_gradient_batch(&mut batch, &[[1.0; 4], [-0.25; 4]], &mut gradients);
    assert_eq!([0, 2].map(|lane| gradients[0][lane]), [3.0, 4.5]);
}

#[test]
fn lanes_are_asked_as_alone_and_a_fault_is_that_of_its_lane() {
    let network = network(Derivatives::StatedSteps);
    let mut batch = network.batch::<4>();
    for (lane, a) in [1.0, 2.5, 1.5].into_iter().enumerate() {
        batch.set_parameters(&network, lane, &[a]);
    }
    batch.use_lanes(3);
    network.solve_steady_batch(&mut batch, Start::Current);
    assert_eq!([0, 2].map(|lane| batch.quantity(&network, lane, 1)), [6.0, 13.5]);
    assert_eq!(batch.outcome(1).as_ref().map_err(ToString::to_string), Err("too large: 2.5".to_owned()));
    assert!(batch.quantity(&network, 1, 0).is_nan());
    let mut tangent = vec![[0.0; 4]; 4];
    network.quantity_tangent_batch(&mut batch, &mut tangent);
    assert!((tangent[0][2] - 9.0).abs() < 1e-10 && tangent[0][1].is_nan(), "{tangent:?}");
    assert_eq!(batch.quantity(&network, 2, 1), 13.5, "left as it was");
}
