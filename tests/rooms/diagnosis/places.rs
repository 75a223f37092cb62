//! Tests of `core/src/diagnosis/places.rs`.

use bmv::diagnosis::Settings;
use bmv::diagnosis::engine::Diagnosis;
use bmv::diagnosis::places::*;
use bmv::document::Diagnostics;
use bmv::effect::{Catalogue, Limits, candidates_within};
use bmv::measurement::sensor_places;
use bmv::random::StreamKey;
use bmv::twin::{InjectionRequest, Recipe, TestKind, Topology, case};
use std::sync::Arc;

#[test]
fn representatives_are_far_apart_and_have_their_neighbours() {
    // Two bundles of nodes, and one node apart.
    let columns: Vec<(usize, Vec<f64>)> = (0..130)
        .map(|node| match node {
            129 => (node, vec![0.0, -50.0]),
            _ if node % 2 == 0 => (node, vec![100.0 + 1e-3 * node as f64, 0.0]),
            _ => (node, vec![0.0, 100.0 - 1e-3 * node as f64]),
        })
        .collect();
    let all = neighbours(&columns, 64);
    assert_eq!(all.len(), 64);
    assert!(all[..3].iter().any(|nodes| nodes[0] == 129), "what lies apart comes early");
    // 130 nodes are 3 a representative: four times that and four more.
    assert!(all.iter().all(|nodes| nodes.len() == 1 + 16));
    for nodes in all.iter().filter(|nodes| nodes[0] != 129) {
        assert!(nodes.iter().all(|node| node % 2 == nodes[0] % 2), "bundles stay apart: {nodes:?}");
    }
    let places = Places {
        neighbours: vec![vec![1, 4], vec![2, 3, 4], vec![9]],
        pairs: vec![[1, 2], [1, 9], [2, 9]],
        ..Places::default()
    };
    assert_eq!(places.near_pair([1, 2]), [[1, 3], [1, 4], [2, 4], [3, 4]]);
    assert_eq!(places.near_pair([9, 2]), [[3, 9], [4, 9]]);
    assert!(places.near_pair([1, 3]).is_empty(), "3 stands for itself");
}

/// A path of the twin that is found among all places is found by representatives and their neighbours, with the same size.
#[test]
fn few_representatives_lead_to_what_all_places_show() {
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let request =
        InjectionRequest { only: Some("conductive-path".to_owned()), size: Some(5.0), ..InjectionRequest::default() };
    let problem = case(&catalogue, &Recipe::of(Topology::Star, TestKind::Steady, request), 1, 0).unwrap().problem;
    let key = StreamKey::new(1, "test", "places");
    let whole = Diagnosis::new(problem.clone(), Settings::default(), key).run().unwrap();
    let limits = Limits { nodes_in_pairs: 0, nodes_one_by_one: 0, elements_of_a_kind: 0 };
    let sensors = sensor_places(problem.measurements.iter());
    let mut few = problem.clone();
    few.candidates = Arc::new(candidates_within(&limits, &problem.model, &[], &sensors, &catalogue));
    let mut by_few = Diagnosis::new(few, Settings::default(), key);
    // Nodes of so small a model are unlike one another: one stands for another.
    by_few.choice = Choice { limits, representatives: 6 };
    let refined = by_few.run().unwrap();
    let [found] = whole.selected.as_slice() else { panic!("{:?}", whole.selected) };
    assert!(found.starts_with("conductive-path"), "{found}");
    assert_eq!(refined.selected, whole.selected);
    // Descents from other starts end within a small share of a standard deviation.
    for (name, size) in &whole.effect(found).unwrap().amplitudes {
        let own = &refined.effect(found).unwrap().amplitudes[name];
        assert!((own.value - size.value).abs() < 0.01 * size.sd, "{found}: {own:?} and {size:?}");
    }
}
