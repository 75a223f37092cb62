//! Tests of `src/report/plot/contours.rs`.

use bmv::report::plot::contours::*;

/// x + 2 y on a skewed grid.
fn plane() -> Vec<Vec<Node>> {
    let node = |row: usize, column: usize| {
        let (x, y) = (column as f64 + 0.3 * row as f64, row as f64);
        Node { x, y, value: x + 2.0 * y }
    };
    (0..4).map(|row| (0..5).map(|column| node(row, column)).collect()).collect()
}

#[test]
fn a_level_of_a_plane_is_a_straight_line() {
    let rows = plane();
    let mut pieces = 0;
    for [a, b] in triangles(&rows).filter_map(|triangle| crossing(&triangle, 3.7)) {
        for (x, y) in [a, b] {
            assert!((x + 2.0 * y - 3.7).abs() < 1e-12, "{x} {y}");
        }
        pieces += 1;
    }
    assert!(pieces > 3, "{pieces}");
}

#[test]
fn what_is_above_a_level_and_what_is_below_make_a_triangle() {
    let area = |outline: &[(f64, f64)]| {
        let twice: f64 = (0..outline.len())
            .map(|at| {
                let (a, b) = (outline[at], outline[(at + 1) % outline.len()]);
                a.0 * b.1 - b.0 * a.1
            })
            .sum();
        0.5 * twice.abs()
    };
    for triangle in triangles(&plane()) {
        let whole = area(&triangle.map(|node| (node.x, node.y)));
        for level in [1.0, 2.5, 4.0, 8.0] {
            let upside_down = triangle.map(|node| Node { value: -node.value, ..node });
            let parts = area(&above(&triangle, level)) + area(&above(&upside_down, -level));
            assert!((parts - whole).abs() < 1e-12, "{parts} {whole}");
        }
    }
}

#[test]
fn a_node_without_a_value_leaves_its_cells_empty() {
    let mut rows = plane();
    rows[1][2].value = f64::NAN;
    // Six of the 24 triangles have that corner.
    assert_eq!(triangles(&rows).count(), 24 - 6);
    assert!(contours(&Contours { rows, ..Contours::default() }).svg("a", "", "", false).contains("<polygon"));
    assert!(!contours(&Contours::default()).svg("a", "", "", false).contains("<polygon"));
}
