//! Tests of `core/src/measurement/scatter.rs`.

use bmv::measurement::scatter::*;
use bmv::random::StreamKey;

fn sensor(name: &str, square: f64, readings: usize) -> Scatter {
    Scatter { sensor: name.to_owned(), sigma: 0.5, unit: "K".to_owned(), square, readings }
}

#[test]
fn a_small_sum_of_squares_is_an_overstated_noise() {
    // 40 readings, 10 unknowns: of 30 degrees of freedom 0.1 % lie below 11.588 (tables), a ratio of 1.61.
    assert_eq!(overstated(11.7, 40, 10), None);
    let times = overstated(11.5, 40, 10).expect("overstated");
    assert!((times - (30.0_f64 / 11.5).sqrt()).abs() < 1e-12);
    assert_eq!(overstated(0.0, 10, 10), None, "what has no freedom scatters not at all");
    // 0.1 % of 10 000 degrees lie below 9570, a ratio of 1.02: significant, and of no use.
    assert_eq!(overstated(9500.0, 10_000, 0), None);
}

#[test]
fn all_sensors_or_single_ones_are_named() {
    let text = warning(&[sensor("a", 5.0, 20), sensor("b", 6.0, 20)], 10).expect("both");
    // sqrt(30 / 11) = 1.651; 0.5 / 1.651 = 0.30.
    assert!(text.contains("a 0.30 instead of 0.5 K, b 0.30 instead of 0.5 K"), "{text}");
    let text = warning(&[sensor("a", 60.0, 40), sensor("b", 6.0, 40)], 10).expect("one");
    assert!(text.contains("b 0.22 instead of 0.5 K") && !text.contains("a 0."), "{text}");
    assert_eq!(warning(&[sensor("a", 40.0, 40), sensor("b", 30.0, 40)], 10), None);
    assert_eq!(warning(&[], 3), None);
}

#[test]
fn right_noise_is_hardly_ever_called_overstated() {
    let mut stream = StreamKey::new(1, "scatter", "test").stream(0);
    let mut warnings = 0;
    for _ in 0..2000 {
        let square = |stream: &mut bmv::random::Stream| (0..30).map(|_| stream.normal()).map(|z| z * z).sum::<f64>();
        let sensors = [sensor("a", square(&mut stream), 30), sensor("b", square(&mut stream), 30)];
        warnings += usize::from(warning(&sensors, 0).is_some());
    }
    // Two families at 0.1 %: 4 expected, and more than 12 with a probability of 0.1 %.
    assert!(warnings <= 12, "{warnings}");
}
