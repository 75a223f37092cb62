//! Factor and inverse of a covariance, four rows at a time: rows lie in one piece, and each number that is loaded serves four
//! scalar products, whose interleaved sums have a fixed order.

use super::GaussianProcessError;

/// Scalar products of four rows with one; all are as long as `other`.
#[inline(always)]
fn dots(rows: [&[f64]; 4], other: &[f64]) -> [f64; 4] {
    let n = other.len();
    let [a, b, c, d] = rows.map(|row| &row[..n]);
    let mut sums = [[0.0; 4]; 4];
    let whole = n - n % 4;
    let blocks =
        a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0).zip(c.as_chunks::<4>().0).zip(d.as_chunks::<4>().0);
    for ((((a, b), c), d), other) in blocks.zip(other.as_chunks::<4>().0) {
        for lane in 0..4 {
            sums[0][lane] += a[lane] * other[lane];
            sums[1][lane] += b[lane] * other[lane];
            sums[2][lane] += c[lane] * other[lane];
            sums[3][lane] += d[lane] * other[lane];
        }
    }
    for (lane, at) in (whole..n).enumerate() {
        for (sum, row) in sums.iter_mut().zip([a, b, c, d]) {
            sum[lane] += row[at] * other[at];
        }
    }
    sums.map(|sum| (sum[0] + sum[2]) + (sum[1] + sum[3]))
}

/// The same of one row.
#[inline(always)]
pub(super) fn dot(row: &[f64], other: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (blocks, others) = (row.as_chunks::<4>(), other.as_chunks::<4>());
    for (x, y) in blocks.0.iter().zip(others.0) {
        for lane in 0..4 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    for (lane, (x, y)) in blocks.1.iter().zip(others.1).enumerate() {
        sums[lane] += x * y;
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// Replaces the rows of a matrix (n x n) up to the diagonal by those of its lower factor. Cost: n^3 / 6 products.
///
/// # Errors
/// A pivot that is not above 0.
pub fn factor(matrix: &mut [f64], n: usize) -> Result<(), GaussianProcessError> {
    let mut first = 0;
    while first < n {
        let rows = 4.min(n - first);
        let (above, rest) = matrix.split_at_mut(first * n);
        for j in 0..first {
            let other = &above[j * n..j * n + j + 1];
            let products = if rows == 4 {
                dots([&rest[..n], &rest[n..2 * n], &rest[2 * n..3 * n], &rest[3 * n..4 * n]], &other[..j])
            } else {
                let mut products = [0.0; 4];
                for (row, product) in products.iter_mut().enumerate().take(rows) {
                    *product = dot(&rest[row * n..row * n + j], &other[..j]);
                }
                products
            };
            for (row, product) in products.iter().enumerate().take(rows) {
                rest[row * n + j] = (rest[row * n + j] - product) / other[j];
            }
        }
        for row in 0..rows {
            let (before, own) = rest.split_at_mut(row * n);
            let i = first + row;
            for j in first..i {
                let other = &before[(j - first) * n..(j - first) * n + j + 1];
                own[j] = (own[j] - dot(&own[..j], &other[..j])) / other[j];
            }
            let pivot = own[i] - dot(&own[..i], &own[..i]);
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(GaussianProcessError::Indefinite);
            }
            own[i] = pivot.sqrt();
        }
        first += rows;
    }
    Ok(())
}

/// Rows up to the diagonal of the inverse of `L L'`, from the factor. Cost: n^3 / 3 products.
pub fn inverse(lower: &[f64], n: usize) -> Vec<f64> {
    // Row j holds column j of L^-1: zeros before the diagonal.
    let mut columns = vec![0.0; n * n];
    let mut inverse = vec![0.0; n * n];
    let mut first = 0;
    while first < n {
        let rows = 4.min(n - first);
        let group = &mut columns[first * n..(first + rows) * n];
        for k in first..n {
            let other = &lower[k * n + first..k * n + k];
            let products = if rows == 4 {
                let [a, b, c, d] = [0, 1, 2, 3].map(|row| &group[row * n + first..row * n + k]);
                dots([a, b, c, d], other)
            } else {
                let mut products = [0.0; 4];
                for (row, product) in products.iter_mut().enumerate().take(rows) {
                    *product = dot(&group[row * n + first..row * n + k], other);
                }
                products
            };
            for (row, product) in products.iter().enumerate().take(rows) {
                let unit = f64::from(u8::from(k == first + row));
                if k >= first + row {
                    group[row * n + k] = (unit - product) / lower[k * n + k];
                }
            }
        }
        first += rows;
    }
    for i in 0..n {
        let own = &columns[i * n + i..(i + 1) * n];
        let mut j = 0;
        while j + 4 <= i + 1 {
            let [a, b, c, d] = [j, j + 1, j + 2, j + 3].map(|j| &columns[j * n + i..(j + 1) * n]);
            inverse[i * n + j..i * n + j + 4].copy_from_slice(&dots([a, b, c, d], own));
            j += 4;
        }
        for j in j..=i {
            inverse[i * n + j] = dot(&columns[j * n + i..(j + 1) * n], own);
        }
    }
    inverse
}

/// Solves `L x = b` in place.
pub(super) fn solve_lower(lower: &[f64], x: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let (done, rest) = x.split_at_mut(i);
        rest[0] = (rest[0] - dot(&lower[i * n..i * n + i], done)) / lower[i * n + i];
    }
}
