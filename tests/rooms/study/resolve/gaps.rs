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
