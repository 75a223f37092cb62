//! Tests of `core/src/random/sobol.rs`.
#![expect(clippy::disallowed_methods, reason = "the standard library as an independent reference")]

use bmv::random::sobol::*;
use bmv::random::stream::StreamKey;

fn points(sobol: &Sobol, count: u64) -> Vec<Vec<f64>> {
    let (mut words, mut row) = (vec![0; sobol.dimensions], vec![0.0; sobol.dimensions]);
    (0..count)
        .map(|index| {
            sobol.words(index, &mut words);
            sobol.coordinates(&words, &mut row);
            row.clone()
        })
        .collect()
}

#[test]
fn plain_points_are_the_reference_points() {
    // First points of new-joe-kuo-6.21201 in Gray code order, as scipy 1.17 (qmc.Sobol) gives them.
    let expected = [
        [0.0; 8],
        [0.5; 8],
        [0.75, 0.25, 0.25, 0.25, 0.75, 0.75, 0.25, 0.75],
        [0.25, 0.75, 0.75, 0.75, 0.25, 0.25, 0.75, 0.25],
        [0.375, 0.375, 0.625, 0.875, 0.375, 0.125, 0.375, 0.875],
        [0.875, 0.875, 0.125, 0.375, 0.875, 0.625, 0.875, 0.375],
        [0.625, 0.125, 0.875, 0.625, 0.625, 0.875, 0.125, 0.125],
        [0.125, 0.625, 0.375, 0.125, 0.125, 0.375, 0.625, 0.625],
    ];
    let sobol = Sobol::plain(8).unwrap();
    let (mut words, mut running) = ([0; 8], [0; 8]);
    for (index, expected) in expected.iter().enumerate() {
        sobol.words(index as u64, &mut words);
        if index > 0 {
            sobol.advance(index as u64, &mut running);
        }
        assert_eq!(words, running);
        for (word, expected) in words.iter().zip(expected) {
            assert_eq!(*word as f64 / 2_f64.powi(64), *expected, "point {index}");
        }
    }
}

#[test]
fn far_points_in_high_dimensions_are_the_reference_points() {
    // Dimensions 10, 100, 500 and 1024 (counted from 1) as scipy 1.17 gives them; the crate sobol 1.0.2 agrees up to 500.
    let sobol = Sobol::plain(1024).unwrap();
    let mut words = [0; 1024];
    REFERENCE.iter().for_each(|(index, expected)| {
        sobol.words(*index, &mut words);
        for (dimension, expected) in [10, 100, 500, 1024].into_iter().zip(expected) {
            assert_eq!(words[dimension - 1] as f64 / 2_f64.powi(64), *expected, "point {index}, {dimension}");
        }
    });
    assert!(Sobol::plain(1025).is_none());
    assert_eq!(DIRECTIONS.lines().count(), MAX_DIMENSIONS - 1);
}

const REFERENCE: [(u64, [f64; 4]); 3] = [
    (5, [0.125, 0.375, 0.125, 0.375]),
    (1000, [0.0693359375, 0.1865234375, 0.2548828125, 0.7138671875]),
    (123457, [0.7490615844726562, 0.42577362060546875, 0.41883087158203125, 0.9469680786132812]),
];

#[test]
fn scrambled_points_stratify() {
    let dimensions = 60;
    let key = StreamKey::new(5, "test", "net");
    let rows = points(&Sobol::scrambled(dimensions, &key).unwrap(), 256);
    // Every dimension alone is a (0, m, 1)-net: one point in each of 256 slices.
    for d in 0..dimensions {
        let mut seen = [0; 256];
        rows.iter().for_each(|row| seen[(row[d] * 256.0) as usize] += 1);
        assert_eq!(seen, [1; 256], "dimension {d}");
    }
    // The first two form a (0, m, 2)-net: one point in each box of every shape of area 1/256.
    for level in 0..=8 {
        let (columns, lines) = ((1 << level) as f64, (256 >> level) as f64);
        let mut seen = [0; 256];
        for row in &rows {
            seen[(row[0] * columns) as usize * (256 >> level) + (row[1] * lines) as usize] += 1;
        }
        assert_eq!(seen, [1; 256], "level {level}");
    }
    // Property A (Sobol 1976) of the first dimensions: 2^3 points fall into the 2^3 half-cubes of the first three.
    let mut octants = [0; 8];
    for row in &rows[..8] {
        octants[(0..3).map(|d| ((row[d] * 2.0) as usize) << d).sum::<usize>()] += 1;
    }
    assert_eq!(octants, [1; 8]);
}

#[test]
fn scrambled_coordinates_are_uniform_and_independent_over_keys() {
    // Any one point is uniform over the scrambles; the flips of neighbouring subtrees are independent.
    let n = 4000_u32;
    let (mut sum, mut squares, mut product, mut agree) = (0.0, 0.0, 0.0, 0);
    for seed in 0..n {
        let sobol = Sobol::scrambled(2, &StreamKey::new(u64::from(seed), "t", "u")).unwrap();
        let rows = points(&sobol, 3);
        let (x, y) = (rows[2][0] - 0.5, rows[2][1] - 0.5);
        sum += x;
        squares += x * x;
        product += x * y;
        // Points 0 (word 0) and 1 (0.5) lie in different halves: their second digits flip independently.
        agree += u32::from(((rows[0][0] * 4.0) as u32 & 1) == ((rows[1][0] * 4.0) as u32 & 1));
    }
    let n = f64::from(n);
    // Five standard errors of each statistic of uniform numbers.
    assert!((sum / n).abs() < 5.0 * (1.0 / 12.0 / n).sqrt());
    assert!((squares / n - 1.0 / 12.0).abs() < 5.0 * (1.0 / 180.0 / n).sqrt());
    assert!((product / n).abs() < 5.0 * (1.0 / 144.0 / n).sqrt());
    assert!((f64::from(agree) / n - 0.5).abs() < 5.0 * 0.5 / n.sqrt());
}

#[test]
fn integration_error_of_a_smooth_function_falls_faster_than_one_over_n() {
    // Product of 1 + (x - 1/2) / (d + 1) over 6 dimensions integrates to 1; Owen (1997): error near N^-1.5.
    let rms = |count: u64| {
        let mut total = 0.0;
        let keys = 24;
        for seed in 0..keys {
            let sobol = Sobol::scrambled(6, &StreamKey::new(seed, "t", "i")).unwrap();
            let f = |row: &Vec<f64>| -> f64 {
                row.iter().enumerate().map(|(d, x)| 1.0 + (x - 0.5) / (d as f64 + 1.0)).product()
            };
            let mean = points(&sobol, count).iter().map(f).sum::<f64>() / count as f64;
            total += (mean - 1.0) * (mean - 1.0);
        }
        (total / keys as f64).sqrt()
    };
    let order = (rms(64) / rms(4096)).ln() / 64_f64.ln();
    assert!(order > 1.3, "the error falls as N^-{order}");
}
