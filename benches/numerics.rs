//! Speed of the numeric kernels: dense and sparse LU, sampling.
#![allow(missing_docs)]

use std::hint::black_box;
use std::sync::Arc;

use bmv::math::dense;
use bmv::math::sparse::Pattern;
use bmv::math::sparse_lu::{SparseLu, SymbolicLu};
use bmv::math::special::normal_quantile;
use bmv::random::{PointKind, Points, StreamKey};
use criterion::{Criterion, criterion_group, criterion_main};

/// A diagonally dominant unsymmetric matrix of size n.
fn dense_matrix(n: usize) -> Vec<f64> {
    (0..n * n).map(|k| if k % (n + 1) == 0 { 10.0 } else { ((k * 37 % 101) as f64 - 50.0) / 100.0 }).collect()
}

/// Rows x columns mesh, each node coupled with the nodes at most `reach` away in the sum of squares.
fn mesh(width: usize, height: usize, reach: usize) -> (Pattern, Vec<f64>) {
    let mut entries = Vec::new();
    for i in 0..width * height {
        let (x, y) = (i % width, i / width);
        for v in y.saturating_sub(2)..(y + 3).min(height) {
            for u in x.saturating_sub(2)..(x + 3).min(width) {
                let distance = x.abs_diff(u) * x.abs_diff(u) + y.abs_diff(v) * y.abs_diff(v);
                if distance <= reach {
                    entries.push((i, v * width + u));
                }
            }
        }
    }
    let pattern = Pattern::new(width * height, &entries).expect("inside");
    let mut values: Vec<f64> = (0..pattern.stored()).map(|k| -0.5 - ((k * 37 % 101) as f64) / 202.0).collect();
    for &slot in pattern.diagonal() {
        values[slot] = 14.0;
    }
    (pattern, values)
}

fn dense_lu(criterion: &mut Criterion) {
    for n in [9, 30, 50] {
        let matrix = dense_matrix(n);
        let (mut a, mut pivots, mut x) = (matrix.clone(), vec![0; n], vec![0.0; n]);
        criterion.bench_function(&format!("dense LU n = {n}, factor and solve"), |bench| {
            bench.iter(|| {
                a.copy_from_slice(black_box(&matrix));
                let result = dense::factor(&mut a, &mut pivots);
                x.fill(1.0);
                dense::solve(&a, &pivots, &mut x);
                black_box((result, x[0]))
            });
        });
    }
}

fn sparse_lu(criterion: &mut Criterion) {
    // Mean degree near 8 (reach 2) and 12 (reach 4).
    for (width, height, reach) in [(20, 10, 2), (20, 10, 4), (100, 100, 2), (100, 100, 4)] {
        let (pattern, values) = mesh(width, height, reach);
        let nodes = width * height;
        let name = format!("sparse LU {nodes} nodes, degree {:.1}", pattern.stored() as f64 / nodes as f64 - 1.0);
        let symbolic = Arc::new(SymbolicLu::new(pattern.clone()));
        println!(
            "{name}: {} factor entries, {:.1} million multiplications",
            symbolic.factor_entries(),
            symbolic.multiplications() / 1e6
        );
        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        let mut lu = SparseLu::<f64>::new(Arc::clone(&symbolic));
        group.bench_function("analysis", |bench| bench.iter(|| SymbolicLu::new(black_box(pattern.clone()))));
        group.bench_function("refactorisation", |bench| bench.iter(|| lu.refactor(black_box(&values))[0]));
        let mut x = vec![1.0; nodes];
        group.bench_function("solution", |bench| {
            bench.iter(|| {
                x.fill(1.0);
                lu.solve(black_box(&mut x));
            });
        });
        group.finish();
    }
}

fn sampling(criterion: &mut Criterion) {
    let (rows, dimensions) = (1_000_000, 7);
    let mut values = vec![0.0; rows * dimensions];
    let mut group = criterion.benchmark_group("1e6 x 7 variates");
    group.sample_size(10);
    for kind in [PointKind::MonteCarlo, PointKind::LatinHypercube, PointKind::Sobol] {
        let points = Points::new(kind, StreamKey::new(1, "bench", "points"), rows, dimensions).expect("valid");
        group.bench_function(format!("{kind:?}"), |bench| bench.iter(|| points.fill_rows(0, black_box(&mut values))));
    }
    group.bench_function("normal quantiles", |bench| {
        bench.iter(|| values.iter().map(|&u| normal_quantile(u)).sum::<f64>());
    });
    group.finish();
}

criterion_group!(benches, dense_lu, sparse_lu, sampling);
criterion_main!(benches);
