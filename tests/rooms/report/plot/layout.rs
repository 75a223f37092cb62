//! Tests of `src/report/plot/layout.rs`.

use bmv::report::plot::layout::*;

#[test]
fn a_chain_lies_in_order() {
    let links: Vec<_> = (0..7).map(|i| (i, i + 1)).collect();
    let places = positions(8, &links, &[false; 8]);
    let mut x: Vec<f64> = places.iter().map(|p| p.0).collect();
    if x[0] > x[7] {
        x.reverse();
    }
    assert!(x.windows(2).all(|w| w[1] > w[0]), "{x:?}");
}

#[test]
fn boundaries_lie_below() {
    let places = positions(3, &[(0, 1), (1, 2), (0, 2)], &[true, false, false]);
    assert!(places[0].1 > 0.5 * (places[1].1 + places[2].1));
}

#[test]
fn degenerate_networks_have_places() {
    assert!(positions(0, &[], &[]).is_empty());
    assert_eq!(positions(1, &[(0, 0)], &[true]), [(0.5, 0.5)]);
    for (x, y) in positions(5, &[(0, 9)], &[true; 5]) {
        assert!(x.is_finite() && y.is_finite());
    }
}

#[test]
fn boxes_end_up_apart() {
    let mut centres = vec![(500.0, 300.0); 6];
    let sizes = vec![(200.0, 60.0); 6];
    push_apart(&mut centres, &sizes, 20.0, (1600.0, 900.0));
    for i in 0..6 {
        for j in 0..i {
            let (dx, dy) = (centres[i].0 - centres[j].0, centres[i].1 - centres[j].1);
            assert!(dx.abs() > 200.0 || dy.abs() > 60.0, "{centres:?}");
        }
    }
}
