//! Tests of `core/src/effect/parameter.rs`.

use bmv::document::Diagnostics;
use bmv::effect::parameter::*;
use bmv::effect::{Bound, Catalogue};
use bmv::expression::{Dimension, Unit};
use bmv::random::Distribution;
use bmv::thermal::element::{Conductor, Element, ElementKind};
use bmv::thermal::{Clock, Limits, Model, Node, NodeKind};

/// A node that stores and exchanges so much, beside a boundary.
fn hardware(capacity: f64, conductance: f64) -> Model {
    let mut model = Model::default();
    let [capacity, cold, conductance] = [capacity, 290.0, conductance].map(|value| model.graph.number(value));
    let node =
        |name: &str, kind| Node { name: name.to_owned(), kind, area: None, alias: None, limits: Limits::default() };
    model.nodes = vec![
        node("inside", NodeKind::Diffusion { capacity }),
        node("outside", NodeKind::Boundary { temperature: cold }),
    ];
    let kind = ElementKind::Conductor(Conductor { between: [0, 1], conductance });
    model.elements = vec![Element { name: "wall".to_owned(), kind }];
    model
}

/// A house of 10 MJ/K that loses 120 W/K may hide parts of 4 MJ/K behind 12 W/K; an instrument those of the catalogue.
#[test]
fn sizes_are_plausible_for_the_hardware() {
    let catalogue = Catalogue::embedded(&mut Diagnostics::new());
    let plausible = |effect: &str, model: &Model| -> Vec<f64> {
        catalogue.get(effect).unwrap().parameters(model, &[]).iter().map(|parameter| parameter.plausible).collect()
    };
    let (house, head) = (hardware(1e7, 120.0), hardware(700.0, 2.0));
    assert_eq!(plausible("hidden-node", &head), [200.0, 0.1]);
    assert_eq!(plausible("hidden-node", &house), [4e6, 12.0]);
    assert_eq!(plausible("sensor-bias", &house), plausible("sensor-bias", &head));
    let mut study_effect = catalogue.get("hidden-node").unwrap().clone();
    study_effect.embedded = false;
    assert_eq!(
        study_effect.parameters(&house, &[])[0].plausible,
        200.0,
        "a study's own effect is meant for its hardware"
    );
}

/// Heat over powers, fluxes and pressures is written as an engineer would; the same dimension cancels.
#[test]
fn a_unit_over_others_is_one_that_people_read() {
    let dimension = |text: &str| Unit::parse(text).unwrap().dimension;
    let cases: [(&[&str], &str); 6] = [
        (&["Pa"], "W/Pa"),
        (&["W"], "1"),
        (&["K", "K"], "W/K2"),
        (&["W/m2", "W"], "1/(W/m2)"),
        (&["W/m2", "A"], "W/((W/m2) A)"),
        (&["W/m2", "W/m2"], "W/((W/m2) (W/m2))"),
    ];
    for (below, expected) in cases {
        let below: Vec<Dimension> = below.iter().map(|text| dimension(text)).collect();
        let unit = si_per(dimension("W"), &below);
        assert_eq!(unit.text, expected);
        assert_eq!(unit.dimension, below.iter().fold(dimension("W"), |above, divisor| above.over(*divisor)));
    }
}

#[test]
fn nothing_changes_at_a_date_at_the_ends_of_what_was_measured() {
    let catalogue = Catalogue::embedded(&mut Diagnostics::new());
    let mut model = hardware(700.0, 2.0);
    let date = model.clock_input(Clock::Date);
    model.inputs[date].range = Some([1000.0, 2000.0]);
    let parameters = catalogue.get("dated-load").unwrap().parameters(&model, &[Bound::Input(date)]);
    let own = parameters.iter().find(|own| own.name == "date").unwrap();
    assert_eq!(own.prior, Distribution::Uniform { lower: 1020.0, upper: 1980.0 });
}

/// No sensor reads beyond the temperature towards which it is pulled, and no joint loses more than all.
#[test]
fn a_share_is_at_most_1_however_wide_its_prior() {
    let catalogue = Catalogue::embedded(&mut Diagnostics::new());
    let model = hardware(700.0, 2.0);
    for (effect, name) in [("sensor-conduction", "ratio"), ("conductance-lost-below", "lost")] {
        let parameters = catalogue.get(effect).unwrap().parameters(&model, &[Bound::Node(1)]);
        let prior = parameters.iter().find(|parameter| parameter.name == name).unwrap().prior;
        let Distribution::Normal { lower, upper, .. } = widened(prior, 100.0) else { panic!("{effect}: {prior:?}") };
        assert_eq!((lower, upper), (Some(0.0), Some(1.0)), "{effect}");
    }
}
