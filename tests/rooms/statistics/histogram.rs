//! Tests of `core/src/statistics/histogram.rs`.

use bmv::statistics::histogram::*;

#[test]
fn edges_follow_the_rule_and_its_limits() {
    // 0..=999: IQR 499.5, width 99.9, range 999: ten bins.
    let values: Vec<f64> = (0..1000).map(f64::from).collect();
    let edges = edges_sorted(&values);
    assert_eq!((edges.len(), edges[0], edges[10]), (11, 0.0, 999.0));
    assert_eq!(edges_sorted(&[1.0, 2.0]).len(), 6);
    assert_eq!(edges_sorted(&[3.0, 3.0, 3.0]).len(), 2);
    let mut outlier = vec![0.0; 50];
    outlier.push(1.0);
    assert_eq!(edges_sorted(&outlier).len(), 61);
    assert!(edges_sorted(&[]).is_empty());
}

#[test]
fn each_value_is_counted_once() {
    let histogram = Histogram::new(vec![0.0, 1.0, 2.0], &[0.0, 0.5, 1.0, 2.0, 2.1, -0.1, f64::NAN]);
    assert_eq!((histogram.counts.as_slice(), histogram.outside), (&[2, 2][..], 3));
    let sorted = [-0.1, 0.0, 0.5, 1.0, 2.0, 2.1];
    let edges = vec![0.0, 1.0, 2.0];
    assert_eq!(Histogram::of_sorted(edges.clone(), &sorted), Histogram::new(edges, &sorted));
    assert_eq!(Histogram::of_sorted(vec![], &[1.0]).outside, 1);
    let pairs = PairHistogram::new(vec![0.0, 1.0, 2.0], vec![0.0, 1.0], &[0.5, 1.5, 1.5], &[0.5, 1.0, 3.0]);
    assert_eq!((pairs.counts.as_slice(), pairs.outside), (&[1, 1][..], 1));
    assert_eq!(Histogram::new(vec![], &[1.0]).outside, 1);
}
