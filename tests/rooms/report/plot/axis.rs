//! Tests of `src/report/plot/axis.rs`.

use bmv::report::plot::axis::*;

fn labels(low: f64, high: f64) -> Vec<String> {
    Scale::new((low, high), (0.0, 100.0), 5).ticks().into_iter().map(|t| t.1).collect()
}

#[test]
fn ticks_are_round() {
    assert_eq!(labels(0.0, 10.0), ["0", "2", "4", "6", "8", "10"]);
    assert_eq!(labels(0.28, 0.36), ["0.28", "0.30", "0.32", "0.34", "0.36"]);
    assert_eq!(labels(-1.0, 1.0), ["\u{2212}1.0", "\u{2212}0.5", "0.0", "0.5", "1.0"]);
}

#[test]
fn degenerate_ranges_give_a_scale() {
    for (low, high) in [(3.0, 3.0), (f64::NAN, 1.0), (f64::NEG_INFINITY, 0.0), (1.0, 0.0), (0.0, 0.0), (1e300, 1e300)] {
        let scale = Scale::new((low, high), (0.0, 100.0), 5);
        assert!(scale.ticks().len() < 42);
        assert!(scale.at(low.max(-1e6)).is_nan() || (0.0..=100.0).contains(&scale.at(low.max(-1e6))), "{low} {high}");
    }
}
