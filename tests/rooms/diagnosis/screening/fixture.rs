//! Small linear problems with known answers, for the tests of this room.

use bmv::diagnosis::{Direction, Linear};
use bmv::math::dense::dot_of_columns as dot;
use bmv::random::{Stream, StreamKey};

/// A stream of random numbers of its own.
pub(crate) fn stream(purpose: &str, index: u64) -> Stream {
    StreamKey::new(1, "diagnosis", purpose).stream(index)
}

/// Normal `J` and residuals, no bounds.
pub(crate) fn problem(rows: usize, parameters: usize, stream: &mut Stream) -> Linear {
    Linear {
        rows,
        readings: rows,
        jacobian: (0..rows * parameters).map(|_| stream.normal()).collect(),
        residuals: (0..rows).map(|_| stream.normal()).collect(),
        lower: vec![f64::NEG_INFINITY; parameters],
        upper: vec![f64::INFINITY; parameters],
    }
}

/// A direction of these columns (one after the other), no bounds, plausible size 1.
pub(crate) fn direction(candidate: usize, columns: Vec<f64>, amplitudes: usize) -> Direction {
    Direction {
        candidate,
        columns,
        lower: vec![f64::NEG_INFINITY; amplitudes],
        upper: vec![f64::INFINITY; amplitudes],
        plausible: vec![1.0; amplitudes],
        ..Direction::default()
    }
}

/// Normal columns.
pub(crate) fn random_direction(candidate: usize, rows: usize, amplitudes: usize, stream: &mut Stream) -> Direction {
    direction(candidate, (0..rows * amplitudes).map(|_| stream.normal()).collect(), amplitudes)
}

/// `H` and `b` of columns and residuals.
pub(crate) fn products(columns: &[Vec<f64>], residuals: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let h = columns.iter().flat_map(|a| columns.iter().map(move |b| dot(a, b))).collect();
    (h, columns.iter().map(|a| dot(a, residuals)).collect())
}

/// Columns of `J`.
pub(crate) fn columns(linear: &Linear) -> Vec<Vec<f64>> {
    let p = linear.parameters();
    (0..p).map(|k| (0..linear.rows).map(|row| linear.jacobian[row * p + k]).collect()).collect()
}

/// The greatest fall `2 b' x - x' H x` between bounds: every choice of places in turn.
pub(crate) fn enumerated(h: &[f64], b: &[f64], lower: &[f64], upper: &[f64]) -> f64 {
    let n = b.len();
    let mut best = 0.0_f64;
    for code in 0..3_usize.pow(n as u32) {
        let choice: Vec<usize> = (0..n).map(|i| code / 3_usize.pow(i as u32) % 3).collect();
        let mut x: Vec<f64> = (0..n).map(|i| [0.0, lower[i], upper[i]][choice[i]]).collect();
        if x.iter().any(|x| !x.is_finite()) {
            continue;
        }
        let free: Vec<usize> = (0..n).filter(|&i| choice[i] == 0).collect();
        let a = nalgebra::DMatrix::from_fn(free.len(), free.len(), |i, j| h[free[i] * n + free[j]]);
        let right = nalgebra::DVector::from_fn(free.len(), |i, _| {
            b[free[i]] - (0..n).map(|j| h[free[i] * n + j] * x[j]).sum::<f64>()
        });
        let solved = if free.is_empty() { Some(right) } else { a.lu().solve(&right) };
        let Some(solved) = solved else { continue };
        free.iter().zip(solved.iter()).for_each(|(&i, &value)| x[i] = value);
        if (0..n).all(|i| lower[i] - 1e-12 <= x[i] && x[i] <= upper[i] + 1e-12) {
            let hx = |i: usize| (0..n).map(|j| h[i * n + j] * x[j]).sum::<f64>();
            best = best.max((0..n).map(|i| x[i] * (2.0 * b[i] - hx(i))).sum());
        }
    }
    best
}
