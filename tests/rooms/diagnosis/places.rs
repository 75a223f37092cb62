//! Tests of `diagnosis/src/diagnosis/places.rs`.

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
    let column = |node: usize| match node {
        129 => vec![0.0, -50.0],
        _ if node.is_multiple_of(2) => vec![100.0 + 1e-3 * node as f64, 0.0],
        _ => vec![0.0, 100.0 - 1e-3 * node as f64],
    };
    let signature = |index| Signature { index, column: column(index), ..Signature::default() };
    let all = neighbours(&(0..130).map(signature).collect::<Vec<_>>(), 64);
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

/// Leaves of one hub are one to the sensors at the hub: what tells them apart, and makes neighbours, is how warm they are.
#[test]
fn like_leaves_of_a_hub_are_told_apart_by_their_temperatures() {
    let leaf = |index: usize| Signature {
        index,
        // Equal but for rounding.
        column: vec![3.0 + 1e-15 * (index % 5) as f64, 1.0],
        temperatures_k: vec![250.0 + (index * 37 % 100) as f64],
    };
    let all = neighbours(&(0..100).map(leaf).collect::<Vec<_>>(), 8);
    let warmth = |index: usize| (index * 37 % 100) as f64;
    let ends: Vec<f64> = all.iter().map(|nodes| warmth(nodes[0])).collect();
    // Eight of 0 to 99 that begin anywhere and are chosen farthest first leave none farther than 99 / 4 from the nearest.
    let gap = (0..100).map(|one| ends.iter().map(|end| (end - f64::from(one)).abs()).fold(f64::INFINITY, f64::min));
    assert!(gap.fold(0.0, f64::max) <= 99.0 / 4.0, "{ends:?}");
    for nodes in &all {
        // Four times 13 and four more neighbours: within 56 of the scale they come from both sides or from one end.
        assert!(nodes.iter().all(|&node| (warmth(node) - warmth(nodes[0])).abs() <= 56.0), "{nodes:?}");
        assert!((warmth(nodes[1]) - warmth(nodes[0])).abs() == 1.0, "the most alike comes first");
    }
}

/// A path of the twin that is found among all places is found by representatives and their neighbours, with the same size.
#[test]
#[ignore = "thorough"]
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
