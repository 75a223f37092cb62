//! Tests of `diagnosis/src/diagnosis/linearisation/bounded.rs`.

use crate::rooms::diagnosis::screening::fixture::enumerated;
use bmv::diagnosis::linearisation::bounded::*;
use bmv::random::StreamKey;

#[test]
fn agrees_with_all_choices_of_active_bounds() {
    let mut stream = StreamKey::new(1, "bounded", "test").stream(0);
    for case in 0..120 {
        let n = 1 + case % 5;
        let rows = n + 2;
        let j: Vec<f64> = (0..rows * n).map(|_| stream.normal()).collect();
        let r: Vec<f64> = (0..rows).map(|_| 2.0 * stream.normal()).collect();
        let mut h = vec![0.0; n * n];
        let mut b = vec![0.0; n];
        for row in 0..rows {
            for i in 0..n {
                b[i] += j[row * n + i] * r[row];
                for k in 0..n {
                    h[i * n + k] += j[row * n + i] * j[row * n + k];
                }
            }
        }
        let bound = |u: f64, x: f64| {
            if u < 0.3 {
                0.0
            } else if u < 0.6 {
                f64::INFINITY
            } else {
                x
            }
        };
        let lower: Vec<f64> = (0..n).map(|_| -bound(stream.uniform(), stream.uniform())).collect();
        let upper: Vec<f64> = (0..n).map(|_| bound(stream.uniform(), stream.uniform())).collect();
        let minimum = minimise(&h, &b, &lower, &upper, &vec![Place::Free; n]);
        let expected = enumerated(&h, &b, &lower, &upper);
        assert!(minimum.converged, "{case}");
        // The ridge of 1e-12 and conditions up to 1e4.
        assert!((minimum.fall - expected).abs() < 1e-7 * (1.0 + expected), "{case}: {} {expected}", minimum.fall);
    }
}

#[test]
fn columns_that_depend_on_each_other_share_a_step() {
    let minimum = minimise(&[1.0, 1.0, 1.0, 1.0], &[3.0, 3.0], &[0.0, 0.0], &[1.0, 9.0], &[Place::Free; 2]);
    assert!((minimum.fall - 9.0).abs() < 1e-9, "{minimum:?}");
    assert!((minimum.x[0] + minimum.x[1] - 3.0).abs() < 1e-6);
}
