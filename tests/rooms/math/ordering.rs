//! Tests of `core/src/math/ordering.rs`.

use bmv::math::ordering::*;
use std::collections::BTreeSet;

/// Fill of Cholesky's factor (below the diagonal) by eliminating explicitly.
fn factor_entries(neighbours: &[Vec<usize>], order: &[usize]) -> usize {
    let mut graph: Vec<BTreeSet<usize>> = neighbours.iter().map(|l| l.iter().copied().collect()).collect();
    let mut entries = 0;
    for &pivot in order {
        let around: Vec<usize> = graph[pivot].iter().copied().collect();
        entries += around.len();
        for &i in &around {
            graph[i].remove(&pivot);
            for &j in &around {
                if i != j {
                    graph[i].insert(j);
                }
            }
        }
    }
    entries
}

fn grid(side: usize) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); side * side];
    for i in 0..side * side {
        let (x, y) = (i % side, i / side);
        if x > 0 {
            neighbours[i].push(i - 1);
        }
        if x + 1 < side {
            neighbours[i].push(i + 1);
        }
        if y > 0 {
            neighbours[i].push(i - side);
        }
        if y + 1 < side {
            neighbours[i].push(i + side);
        }
    }
    neighbours
}

fn assert_permutation(order: &[usize], size: usize) {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..size).collect::<Vec<_>>());
}

#[test]
fn trees_get_no_fill() {
    // A star of chains has an order without fill; minimum degree finds it.
    let mut neighbours = vec![Vec::new(); 41];
    for arm in 0..10 {
        let mut inner = 0;
        for step in 0..4 {
            let outer = 1 + arm * 4 + step;
            neighbours[inner].push(outer);
            neighbours[outer].push(inner);
            inner = outer;
        }
    }
    let order = minimum_degree(neighbours.clone());
    assert_permutation(&order, 41);
    assert_eq!(factor_entries(&neighbours, &order), 40);
}

#[test]
fn a_grid_gets_little_fill() {
    let neighbours = grid(30);
    let order = minimum_degree(neighbours.clone());
    assert_permutation(&order, 900);
    let natural = factor_entries(&neighbours, &(0..900).collect::<Vec<_>>());
    let ordered = factor_entries(&neighbours, &order);
    // Row by row fills the band: about 30 entries a column. Published minimum degree results lie near a third of it.
    assert!(ordered * 2 < natural, "{ordered} against {natural}");
    assert_eq!(order, minimum_degree(neighbours), "the order is reproducible");
}

#[test]
fn dense_variables_go_last() {
    let mut neighbours = vec![vec![0]; 400];
    neighbours[0] = (1..400).collect();
    let order = minimum_degree(neighbours);
    assert_permutation(&order, 400);
    assert_eq!(order[399], 0);
}
