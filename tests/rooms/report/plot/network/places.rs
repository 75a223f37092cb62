//! Tests of `src/report/plot/network/places.rs`.

use bmv::report::plot::network::places::{Field, centres};
use bmv::report::plot::{Diagram, NodeShape, Path, network};

const FIELD: Field = Field { width: 1010.0, height: 450.0, side: 110.0, rim: 60.0, gap: 40.0 };

/// A star of boxes round a hub, with nodes that adopted effects add at the hub.
fn star(added: usize) -> Diagram {
    let mut nodes: Vec<_> = (0..6).map(|node| (format!("node {node}"), NodeShape::Diffusion)).collect();
    let mut paths: Vec<_> = (1..6).map(|node| (format!("path {node}"), Path::Conductor, 0, node)).collect();
    let mut adopted = Vec::new();
    for position in 0..added {
        let name = format!("effect {position}");
        paths.push((name.clone(), Path::Conductor, 0, nodes.len()));
        nodes.push((format!("{name}.hidden"), NodeShape::Diffusion));
        adopted.extend([name.clone(), format!("{name}.hidden")]);
    }
    Diagram { nodes, paths, adopted, ..Diagram::default() }
}

fn overlapping(centres: &[(f64, f64)], sizes: &[(f64, f64)]) -> Vec<[usize; 2]> {
    let pairs = (0..centres.len()).flat_map(|a| (0..a).map(move |b| [b, a]));
    let overlap = |[a, b]: &[usize; 2]| {
        let (x, y) = ((centres[*a].0 - centres[*b].0).abs(), (centres[*a].1 - centres[*b].1).abs());
        x < 0.5 * (sizes[*a].0 + sizes[*b].0) && y < 0.5 * (sizes[*a].1 + sizes[*b].1)
    };
    pairs.filter(overlap).collect()
}

#[test]
fn adopted_nodes_find_free_places_and_move_no_other() {
    let (before, _) = centres(&star(0), &[(150.0, 60.0); 6], &FIELD);
    for added in 1..=4 {
        let sizes: Vec<(f64, f64)> = (0..6 + added).map(|node| (if node < 6 { 150.0 } else { 210.0 }, 60.0)).collect();
        let (places, _) = centres(&star(added), &sizes, &FIELD);
        assert_eq!(places[..6], before[..], "the model's own boxes stand where they stood");
        assert_eq!(overlapping(&places, &sizes), Vec::<[usize; 2]>::new(), "{added} added: {places:?}");
        for (x, y) in &places[6..] {
            assert!((105.0..=905.0).contains(x) && (30.0..=420.0).contains(y), "inside: {x} {y}");
        }
    }
}

#[test]
fn where_nothing_is_free_the_field_grows_and_no_box_lies_on_another() {
    let sizes = [(900.0, 400.0); 8];
    let (places, height) = centres(&star(2), &sizes, &FIELD);
    assert_eq!(overlapping(&places, &sizes), Vec::<[usize; 2]>::new(), "{places:?}");
    assert!(places.iter().all(|(_, y)| y + 200.0 <= height), "{places:?} in {height}");
    assert!(centres(&Diagram::default(), &[], &FIELD).0.is_empty());
}

/// A node that an effect adds is called like its effect, so that the path to it needs no name of its own.
#[test]
fn an_added_node_is_named_once() {
    let drawn = network(&star(1)).svg("id", "title", "description", true);
    assert!(drawn.contains("\neffect 0\n</text>") && !drawn.contains("adopted: effect 0"), "{drawn}");
    let mut between = star(0);
    between.paths.push(("leak".into(), Path::Conductor, 1, 2));
    between.adopted.push("leak".into());
    assert!(network(&between).svg("id", "title", "description", true).contains("adopted: leak"));
}
