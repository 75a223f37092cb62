//! Tests of `core/src/thermal/lanes_lu.rs`.

use bmv::thermal::lanes_lu::*;

/// Four matrices that need different row exchanges, side by side and alone.
#[test]
fn each_lane_has_the_bits_it_has_alone_and_solves_its_system() {
    let size = 5;
    let value = |lane: usize, row: usize, column: usize| {
        let mixed = (lane * 31 + row * 17 + column * 7) % 13;
        if (row + lane) % size == column { 20.0 } else { mixed as f64 - 6.0 }
    };
    let mut lanes = LanesLu::<[f64; 4]>::new(size);
    let mut rhs = vec![[0.0; 4]; size];
    let mut transposed = rhs.clone();
    for row in 0..size {
        for column in 0..size {
            lanes.matrix[row * size + column] = std::array::from_fn(|lane| value(lane, row, column));
        }
        // The right-hand sides of the solution 1, 2, ..., 5.
        rhs[row] = std::array::from_fn(|lane| (0..size).map(|c| value(lane, row, c) * (c + 1) as f64).sum());
        transposed[row] = std::array::from_fn(|lane| (0..size).map(|c| value(lane, c, row) * (c + 1) as f64).sum());
    }
    let (given, given_transposed) = (rhs.clone(), transposed.clone());
    lanes.factor();
    lanes.solve(&mut rhs);
    lanes.solve_transposed(&mut transposed);
    for lane in 0..4 {
        let mut alone = LanesLu::<f64>::new(size);
        for row in 0..size {
            for column in 0..size {
                alone.matrix[row * size + column] = value(lane, row, column);
            }
        }
        alone.factor();
        let mut x: Vec<f64> = given.iter().map(|v| v[lane]).collect();
        let mut y: Vec<f64> = given_transposed.iter().map(|v| v[lane]).collect();
        let mut columns: Vec<f64> = given.iter().zip(&given_transposed).flat_map(|(a, b)| [a[lane], b[lane]]).collect();
        let mut other: Vec<f64> = given_transposed.iter().map(|v| v[lane]).collect();
        alone.solve(&mut x);
        alone.solve(&mut other);
        alone.solve_transposed(&mut y);
        alone.solve_columns(&mut columns, 2);
        for (row, pair) in columns.chunks_exact(2).enumerate() {
            assert_eq!([pair[0].to_bits(), pair[1].to_bits()], [x[row].to_bits(), other[row].to_bits()]);
        }
        for row in 0..size {
            assert_eq!(x[row].to_bits(), rhs[row][lane].to_bits());
            assert_eq!(y[row].to_bits(), transposed[row][lane].to_bits());
            // Entries below 21, conditions below some hundred: 1e-12 leaves room.
            assert!((x[row] - (row + 1) as f64).abs() < 1e-12, "{x:?}");
            assert!((y[row] - (row + 1) as f64).abs() < 1e-12, "{y:?}");
        }
    }
}

/// A chain of nodes in which the first also joins the last, in an order that fills in: what is passed over must not matter.
#[test]
fn entries_that_are_zero_are_passed_over_without_a_trace() {
    let size = 9;
    let mut lu = LanesLu::<f64>::new(size);
    let mut rhs = vec![0.0; size];
    for row in 0..size {
        for (column, value) in [(row, 4.0 + row as f64), ((row + 1) % size, -1.0), ((row + size - 1) % size, -1.5)] {
            lu.matrix[row * size + column] = value;
            rhs[row] += value * (column + 1) as f64;
        }
    }
    lu.factor();
    let transposed = rhs.clone();
    lu.solve(&mut rhs);
    // Diagonally dominant, entries below 13.
    assert!(rhs.iter().enumerate().all(|(row, x)| (x - (row + 1) as f64).abs() < 1e-13), "{rhs:?}");
    assert!(lu.columns.len() < size * (size - 1) / 2, "{} entries", lu.columns.len());
    // b' (A^-1 b) = (A^-T b)' b.
    let mut y = transposed.clone();
    lu.solve_transposed(&mut y);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    assert!((dot(&transposed, &rhs) / dot(&y, &transposed) - 1.0).abs() < 1e-13);
}
