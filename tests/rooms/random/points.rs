//! Tests of `core/src/random/points.rs`.

use bmv::random::points::*;
use bmv::random::stream::StreamKey;

const KINDS: [PointKind; 3] = [PointKind::MonteCarlo, PointKind::LatinHypercube, PointKind::Sobol];

fn key() -> StreamKey {
    StreamKey::new(11, "propagate", "points")
}

fn all(kind: PointKind, samples: usize, dimensions: usize) -> Vec<f64> {
    let mut rows = vec![0.0; samples * dimensions];
    Points::new(kind, key(), samples, dimensions).unwrap().fill_rows(0, &mut rows);
    rows
}

#[test]
fn rows_alone_and_in_blocks_have_the_same_bits() {
    for kind in KINDS {
        let (samples, d) = (500, 7);
        let points = Points::new(kind, key(), samples, d).unwrap();
        let whole = all(kind, samples, d);
        let mut row = vec![0.0; d];
        for index in (0..samples).rev() {
            points.fill_row(index, &mut row);
            assert_eq!(row, whole[index * d..(index + 1) * d], "{kind:?} {index}");
        }
        let mut block = vec![0.0; 100 * d];
        points.fill_rows(133, &mut block);
        assert_eq!(block, whole[133 * d..233 * d]);
        assert!(whole.iter().all(|x| 0.0 < *x && *x < 1.0));
    }
}

#[test]
fn more_samples_keep_the_first_ones() {
    for kind in [PointKind::MonteCarlo, PointKind::Sobol] {
        assert_eq!(all(kind, 1000, 5), all(kind, 2000, 5)[..5000], "{kind:?}");
    }
}

#[test]
fn latin_hypercube_has_one_point_a_slice() {
    for samples in [1, 2, 3, 10, 97, 1000, 4097] {
        let rows = all(PointKind::LatinHypercube, samples, 4);
        for d in 0..4 {
            let mut seen = vec![0; samples];
            rows.chunks_exact(4).for_each(|row| seen[(row[d] * samples as f64) as usize] += 1);
            assert!(seen.iter().all(|&count| count == 1), "{samples} samples, dimension {d}");
        }
    }
}

#[test]
fn orders_are_all_equally_likely_and_dimensions_uncorrelated() {
    // 24 orders of 4 slices over 4800 seeds: chi square with 23 degrees of freedom, 99.99 % point 57.
    let mut counts = std::collections::BTreeMap::new();
    for seed in 0..4800 {
        *counts.entry(permutation(4, StreamKey::new(seed, "t", "permutation").stream(0))).or_insert(0) += 1;
    }
    let chi_square: f64 = counts.values().map(|&c| (f64::from(c) - 200.0) * (f64::from(c) - 200.0) / 200.0).sum();
    assert!(counts.len() == 24 && chi_square < 57.0, "{chi_square}");
    let n = 2000;
    let rows = all(PointKind::LatinHypercube, n, 6);
    for a in 0..6 {
        for b in 0..a {
            let product: f64 = rows.chunks_exact(6).map(|r| (r[a] - 0.5) * (r[b] - 0.5)).sum();
            // Five standard errors of the correlation of independent columns.
            assert!((12.0 * product / n as f64).abs() < 5.0 / (n as f64).sqrt());
        }
    }
}

#[test]
fn impossible_sets_are_refused() {
    let error = |kind, samples, d| Points::new(kind, key(), samples, d).unwrap_err().to_string();
    assert!(error(PointKind::Sobol, 10, 2000).contains("2000 dimensions are too many"));
    assert!(error(PointKind::MonteCarlo, 0, 2).contains("0 points of 2 dimensions"));
}
