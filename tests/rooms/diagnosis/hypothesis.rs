//! Tests of `diagnosis/src/diagnosis/hypothesis.rs`.

use bmv::document::Diagnostics;
use bmv::effect::{Catalogue, Site};
use bmv::measurement::{Initial, Rows, Uncertain};
use bmv::random::Distribution;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

/// About the mean of the record's readings, K.
const HOST_K: f64 = 280.0;

/// The start of a node that is added to a record whose host begins at 300 K, alone or with all others, and what the record shows.
/// The model is a little wrong everywhere, or right and the record goes on after a gap, or neither.
fn start_of_hidden_node(with_all: bool, is_misspecified: bool, follows_gap: bool) -> (Uncertain, Vec<f64>) {
    start_among(300.0, 300.0, with_all, is_misspecified, follows_gap)
}

/// The same where the host and all other nodes begin at given temperatures, K.
fn start_among(
    host_k: f64,
    others_k: f64,
    with_all: bool,
    is_misspecified: bool,
    follows_gap: bool,
) -> (Uncertain, Vec<f64>) {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let recipe = Recipe::of(Topology::Star, TestKind::Steps, InjectionRequest::default());
    let mut problem = case(&catalogue, &recipe, 1, 0).unwrap().problem;
    problem.is_misspecified = is_misspecified;
    let position = problem.candidates.iter().position(|own| own.effect == "hidden-node").unwrap();
    let count = problem.model.nodes.len();
    let host = match &problem.candidates[position].site {
        Site::Nodes(hosts) => hosts[0].0,
        Site::Pair(ends) => ends[0],
        other => panic!("{other:?}"),
    };
    for measurement in &mut problem.measurements {
        measurement.follows_gap = follows_gap;
        let Rows::Transient { initial, .. } = &mut measurement.rows else { panic!("a transient") };
        let shared = if with_all { (0..count).collect() } else { Vec::new() };
        let mut values = vec![Uncertain::Known(others_k); count];
        values[host] = Uncertain::Known(host_k);
        *initial = Initial::Temperatures { values, shared, balanced: Vec::new() };
    }
    let mut shown: Vec<f64> = problem.measurements[0].readings.iter().flatten().copied().collect();
    let Rows::Transient { inputs, .. } = &problem.measurements[0].rows else { panic!("a transient") };
    let is_temperature = |input: usize| problem.model.inputs[input].unit == "K";
    let columns = inputs.columns.iter().filter(|column| is_temperature(column.input));
    shown.extend(columns.flat_map(|column| column.values.iter().copied()));
    let hypothesis = problem.hypothesis(&[position], 1.0).unwrap();
    let Rows::Transient { initial: Initial::Temperatures { values, .. }, .. } = &hypothesis.measurements[0].rows else {
        panic!("temperatures")
    };
    let listed = hypothesis.starts.iter().filter(|start| start.measurement == 0 && start.node == count);
    let listed: Vec<Uncertain> = listed.map(|start| Uncertain::Inferred(start.prior)).collect();
    assert_eq!(
        listed,
        if with_all || !(is_misspecified || follows_gap) { Vec::new() } else { vec![values[count].clone()] }
    );
    (values[count].clone(), shown)
}

#[test]
#[ignore = "thorough"]
fn a_node_that_is_added_starts_with_all_or_near_what_the_record_shows() {
    assert_eq!(start_of_hidden_node(true, true, true).0, Uncertain::Known(300.0));
    assert_eq!(start_of_hidden_node(false, false, false).0, Uncertain::Known(300.0));
    let (free, shown) = start_of_hidden_node(false, true, false);
    assert_eq!(start_of_hidden_node(false, false, true).0, free);
    let Uncertain::Inferred(Distribution::Normal { mean, lower: Some(lower), upper: Some(upper), .. }) = free else {
        panic!("{free:?}")
    };
    let least = shown.iter().copied().fold(300.0, f64::min);
    let most = shown.iter().copied().fold(300.0, f64::max);
    assert_eq!(mean, 300.0);
    assert!((lower - (least - 1.0)).abs() < 1e-9, "{lower}");
    assert!((upper - (most + 1.0)).abs() < 1e-9, "{upper}");
}

/// A part without a source of its own is near what surrounds it. The host begins at the mean of the readings.
#[test]
fn the_start_of_a_node_that_is_added_is_known_the_better_the_less_its_surroundings_differ() {
    let sd = |others_k: f64| {
        let (free, _) = start_among(HOST_K, others_k, false, true, false);
        let Uncertain::Inferred(Distribution::Normal { sd, .. }) = free else { panic!("{free:?}") };
        sd
    };
    let [same, near, far] = [0.0, 10.0, 30.0].map(|off| sd(HOST_K - off));
    assert!(same < near && near < far, "{same} {near} {far}");
}
