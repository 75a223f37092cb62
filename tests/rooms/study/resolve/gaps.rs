//! Tests of `src/study/resolve/gaps.rs`.

use bmv::study::resolve::gaps::gaps;

#[test]
fn a_gap_is_far_longer_than_the_usual_distance() {
    let mut times: Vec<f64> = (0..100).map(|row| 60.0 * f64::from(row)).collect();
    assert!(gaps(&times).is_empty());
    // One lost row, and six hours.
    times.remove(50);
    times.iter_mut().skip(80).for_each(|time| *time += 21_600.0);
    assert_eq!(gaps(&times), [[4800.0, 26_460.0]]);
    assert!(gaps(&[]).is_empty() && gaps(&[1.0]).is_empty() && gaps(&[0.0, 5.0]).is_empty());
}

#[test]
fn rows_that_get_rarer_have_no_gaps() {
    // Even in the logarithm of time, as instruments log a cooling after a step; and from seconds to minutes at once.
    let cooling: Vec<f64> = std::iter::successors(Some(1e-6), |last| Some(1.1 * last)).take(200).collect();
    assert!(gaps(&cooling).is_empty());
    let decades =
        (0..6).flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| digit * [1.0, 10.0, 100.0, 1e3, 1e4, 1e5][decade]));
    assert!(gaps(&decades.collect::<Vec<f64>>()).is_empty());
    let mut slower: Vec<f64> = (0..300).map(f64::from).collect();
    slower.extend((1..20).map(|row| 299.0 + 60.0 * f64::from(row)));
    assert!(gaps(&slower).is_empty());
    // Lone rows between gaps are in none.
    let mut lone: Vec<f64> = (0..100).map(f64::from).collect();
    lone.extend([500.0, 1000.0, 1500.0, 1501.0, 1502.0, 1503.0]);
    assert_eq!(gaps(&lone), [[99.0, 500.0], [500.0, 1000.0], [1000.0, 1500.0]]);
    // A record may end with one.
    lone.push(2500.0);
    assert_eq!(gaps(&lone).len(), 4);
}
