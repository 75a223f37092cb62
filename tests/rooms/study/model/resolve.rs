//! Tests of `src/study/model/resolve.rs`.

use bmv::document::Diagnostics;
use bmv::document::prior::Prior;
use bmv::expression::Symbol;
use bmv::random::Distribution;
use bmv::study::model::load;
use bmv::study::model::resolve::*;
use bmv::thermal::element::ElementKind;

fn whole() -> ResolvedModel {
    let mut diagnostics = Diagnostics::new();
    let bytes = include_bytes!("../../../diagnostics/whole.json");
    load("whole.json", bytes, &mut diagnostics).expect("valid")
}

fn prior(model: &ResolvedModel, name: &str) -> Distribution {
    let index = model.parameter(name).expect("a parameter");
    *model.priors[index].distribution().expect("a distribution")
}

#[test]
fn values_are_si() {
    let model = whole();
    let parameter = |name: &str| model.model.parameters[model.parameter(name).expect("there")].nominal;
    assert_eq!(parameter("G"), 0.8);
    assert_eq!(parameter("T_on"), 273.15 - 5.0);
    assert_eq!(parameter("e"), 0.86);
    assert_eq!(prior(&model, "G"), Distribution::Uniform { lower: 0.4, upper: 1.2 });
    // The standard deviation in degC is a difference, the bounds are absolute.
    let expected = Distribution::Normal { mean: 268.15, sd: 0.5, lower: Some(263.15), upper: Some(273.15) };
    assert_eq!(prior(&model, "T_on"), expected);
    assert_eq!(prior(&model, "free"), Distribution::Fixed(3.0));
    let plate = &model.model.inputs[model.input("T_if").expect("there")];
    assert_eq!((plate.nominal, plate.range), (293.15, Some([273.15 - 40.0, 333.15])));
    assert_eq!(model.input_errors[0].sigma, Some(0.5));
    let bias = Distribution::Normal { mean: 0.0, sd: 0.5, lower: None, upper: None };
    assert_eq!(model.input_errors[0].bias, Some(Prior::Distribution(bias)), "a bias has no offset");
    // The entry states no unit of its own but its nominal value does: bare numbers are in that.
    assert_eq!((model.model.inputs[1].nominal, model.model.inputs[1].range), (0.5, Some([0.0, 0.9])));
    let limits = model.model.nodes[model.node("plate").expect("there")].limits;
    assert_eq!(limits.yellow, Some([263.15, 323.15]));
    assert!(matches!(model.priors[model.parameter("l").expect("there")], Prior::Posterior { .. }));
}

#[test]
fn expressions_mean_their_physics() {
    let mut model = whole();
    let temperatures = |s: Symbol| match s {
        Symbol::Node(i) => 300.0 + 5.0 * f64::from(i),
        Symbol::Parameter(i) => f64::from(i) + 1.0,
        _ => 0.0,
    };
    let value = |model: &ResolvedModel, name: &str| {
        let id = model.model.quantities[model.quantity(name).expect("there")].value.expression();
        model.model.graph.evaluate(id, &temperatures)
    };
    // Nodes: interface 300, space 305, plate 310, lid 315, mid 320, cold 325; G = 1.
    assert_eq!(value(&model, "leak"), 10.0);
    assert_eq!(value(&model, "average"), 0.25 * 310.0 + 0.75 * 315.0);
    assert_eq!(value(&model, "gradient"), 5.0);
    assert_eq!(value(&model, "again"), 5.0);
    assert_eq!(value(&model, "rise"), 310.0 - 325.0);
    assert_eq!(value(&model, "mass"), 20.0);
    assert_eq!(value(&model, "peak"), 315.0);
    let rows: Vec<(&str, bool)> = model.model.quantities.iter().map(|q| (q.unit.as_str(), q.is_temperature)).collect();
    assert_eq!(rows[0], ("K", true));
    assert_eq!(rows[2], ("K", false), "a gradient is no place on the scale");
    assert_eq!(rows[3], ("W", false));
    assert_eq!(rows[model.quantity("mass").expect("there")], ("kg", false));
    let element = model.elements["tec"][0];
    let ElementKind::Cooler(cooler) = model.model.elements[element].kind.clone() else { panic!("a cooler") };
    assert_eq!(cooler.nodes, ["cold", "mid", "plate"].map(|n| model.node(n).expect("there")));
    let couples: Vec<_> = cooler.couples.iter().map(|&c| model.model.graph.constant(c)).collect();
    assert_eq!(couples, [Some(8.0), Some(24.0)]);
    assert!(model.contribution(element).current.is_some());
}

#[test]
fn large_models_take_linear_time() {
    use std::fmt::Write;
    let mut text = String::from(r#"{"format": "bmv-network/1", "nodes": {"n0": {"boundary": 290}"#);
    for i in 1..10_000 {
        write!(text, r#", "n{i}": {{"capacity": {i}}}"#).expect("memory");
    }
    text.push_str(r#"}, "conductors": {"c0": {"between": ["n0", "n1"], "conductance": 1}"#);
    for i in 1..9_999 {
        write!(text, r#", "c{i}": {{"between": ["n{i}", "n{}"], "conductance": "1 + Tm / 1e3"}}"#, i + 1)
            .expect("memory");
    }
    text.push_str("}}");
    let mut diagnostics = Diagnostics::new();
    let model = load("large.json", text.as_bytes(), &mut diagnostics).expect("valid");
    // Work, not time: each element adds a bounded number of terms.
    assert_eq!(model.model.elements.len(), 9_999);
    assert!(model.model.graph.len() < 6 * 10_000, "{}", model.model.graph.len());
}
