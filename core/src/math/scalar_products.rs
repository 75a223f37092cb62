//! Scalar products of long columns, in a fixed order.

use rayon::prelude::*;

use crate::math::dense::dot_of_columns as dot;
use crate::math::functions::sqrt;
use crate::watch;

/// `y += factor x`.
#[inline]
pub fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

/// Takes from a column its components along orthonormal columns (one after the other in `basis`); where less than half of its
/// square is left, twice, so that what is left is orthogonal to rounding (Daniel, Gragg, Kaufman & Stewart 1976; Giraud, Langou
/// & Rozloznik 2005).
pub fn project_out(column: &mut [f64], basis: &[f64]) {
    let square = dot(column, column);
    take_out(column, basis);
    if !(2.0 * dot(column, column) > square) {
        take_out(column, basis);
    }
}

fn take_out(column: &mut [f64], basis: &[f64]) {
    for q in basis.chunks_exact(column.len().max(1)) {
        let along = dot(q, column);
        add_scaled(column, -along, q);
    }
}

/// Orthonormal columns with the span of the given ones, which are scaled to length 1 first: Gram and Schmidt's process, the
/// longest remainder next, ties by index, until remainders are shorter than `tolerance`.
/// Also the position of the column behind each. `start` are orthonormal columns that are taken out and stay in front.
pub fn orthonormal(columns: &[&[f64]], start: Vec<f64>, tolerance: f64) -> (Vec<f64>, Vec<usize>) {
    let mut basis = start;
    let mut chosen = Vec::new();
    let mut rest: Vec<(usize, Vec<f64>)> = Vec::with_capacity(columns.len());
    for (index, column) in columns.iter().enumerate() {
        let norm = dot(column, column).sqrt();
        if norm > 0.0 && norm.is_finite() {
            let mut column: Vec<f64> = column.iter().map(|x| x / norm).collect();
            project_out(&mut column, &basis);
            rest.push((index, column));
        }
    }
    loop {
        watch::check();
        let mut best: Option<(usize, f64)> = None;
        for (place, (_, column)) in rest.iter().enumerate() {
            let square = dot(column, column);
            if square > tolerance * tolerance && best.is_none_or(|(_, longest)| square > longest) {
                best = Some((place, square));
            }
        }
        let Some((place, square)) = best else { return (basis, chosen) };
        let (index, mut column) = rest.remove(place);
        let norm = square.sqrt();
        column.iter_mut().for_each(|x| *x /= norm);
        // A short remainder holds rounding along the columns before.
        project_out(&mut column, &basis);
        let norm = dot(&column, &column).sqrt();
        column.iter_mut().for_each(|x| *x /= norm);
        for (_, other) in &mut rest {
            let along = dot(&column, other);
            add_scaled(other, -along, &column);
        }
        basis.extend_from_slice(&column);
        chosen.push(index);
    }
}

/// Products of columns with one.
pub fn products(columns: &[Vec<f64>], column: &[f64]) -> Vec<f64> {
    columns.par_iter().map(|own| dot(own, column)).collect()
}

/// Products of columns with one another: of each those with the columns up to it.
pub fn products_of_all<C: AsRef<[f64]> + Sync>(columns: &[C]) -> Vec<Vec<f64>> {
    let row = |place: usize| products_along(&columns[..=place], columns[place].as_ref());
    (0..columns.len()).into_par_iter().map(row).collect()
}

/// Products of columns with others: of each of the former those with all of the latter.
pub fn products_between(columns: &[&[f64]], others: &[&[f64]]) -> Vec<Vec<f64>> {
    columns.par_iter().map(|column| products_along(others, column)).collect()
}

fn products_along<C: AsRef<[f64]>>(columns: &[C], column: &[f64]) -> Vec<f64> {
    watch::check();
    columns.iter().map(|other| dot(other.as_ref(), column)).collect()
}

/// What is left of columns without their components along an orthonormal basis of `rows` rows, scaled to length 1. Shorter columns go
/// on with zeros. Columns that keep less than `least_share` of their square are left out.
pub fn remainders(columns: &[Vec<f64>], basis: &[f64], rows: usize, least_share: f64) -> Vec<Vec<f64>> {
    let remainder = |column: &Vec<f64>| {
        watch::check();
        let mut column = column.clone();
        column.resize(rows, 0.0);
        let whole = dot(&column, &column);
        project_out(&mut column, basis);
        let square = dot(&column, &column);
        let is_seen = square > least_share * whole && square.is_finite();
        column.iter_mut().for_each(|value| *value /= sqrt(square));
        is_seen.then_some(column)
    };
    columns.par_iter().filter_map(remainder).collect()
}

/// Coordinates of columns of length 1 in an orthonormal basis of their span, one column's after the other: the rows of the
/// Cholesky factor of their products, where a column whose remainder's square is below 1e-9 adds no dimension. With their
/// number; `None` where it would exceed `largest`. Cost: columns x dimensions x rows.
pub fn coordinates(columns: &[&[f64]], largest: usize) -> Option<(Vec<f64>, usize)> {
    let mut pivots: Vec<usize> = Vec::new();
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(columns.len());
    for (index, column) in columns.iter().enumerate() {
        let mut row: Vec<f64> = Vec::with_capacity(pivots.len() + 1);
        for (k, &pivot) in pivots.iter().enumerate() {
            let pivot_row = &rows[pivot];
            let product = dot(column, columns[pivot]) - dot(&row, &pivot_row[..k]);
            row.push(product / pivot_row[k]);
        }
        let left = 1.0 - dot(&row, &row);
        if left > 1e-9 {
            if pivots.len() == largest {
                return None;
            }
            pivots.push(index);
            row.push(left.sqrt());
        } else {
            let norm = dot(&row, &row).sqrt();
            row.iter_mut().for_each(|x| *x /= norm);
        }
        rows.push(row);
    }
    let dimensions = pivots.len();
    let mut all = Vec::with_capacity(rows.len() * dimensions);
    // Row by row, so that they are not held twice.
    for (before, row) in rows.into_iter().enumerate() {
        all.extend_from_slice(&row);
        all.resize((before + 1) * dimensions, 0.0);
    }
    Some((all, dimensions))
}
