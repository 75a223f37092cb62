//! Histograms of one and two variables.

use super::quantile::quantile_sorted;
use crate::math::functions::pow;

/// Fewest and most bins that the rule gives.
const BINS: (f64, f64) = (5.0, 60.0);

/// Equal bins over the range of a sorted sample of finite values: width `2 IQR / n^(1/3)` (Freedman & Diaconis 1981),
/// the number of bins kept within 5..=60; one bin of some width about a sample that does not vary. Empty for no values.
pub fn edges_sorted(sorted: &[f64]) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (sorted.first(), sorted.last()) else { return Vec::new() };
    let range = last - first;
    if range.is_nan() || range <= 4.0 * f64::EPSILON * first.abs().max(last.abs()) {
        let half = 0.5 * first.abs().max(1.0) * 1e-3;
        return vec![first - half, last + half];
    }
    let spread = quantile_sorted(sorted, 0.75) - quantile_sorted(sorted, 0.25);
    let width = 2.0 * spread / pow(sorted.len() as f64, 1.0 / 3.0);
    let bins = if width > 0.0 { (range / width).ceil() } else { BINS.1 };
    let bins = bins.clamp(BINS.0, BINS.1) as usize;
    let edge = |k: usize| if k == bins { last } else { first + range * (k as f64 / bins as f64) };
    (0..=bins).map(edge).collect()
}

/// The bin of a value: lower edge included, the last bin also its upper edge. `None` outside and for NaN.
fn bin(edges: &[f64], value: f64) -> Option<usize> {
    let last = edges.len().checked_sub(1)?;
    if value.is_nan() || last == 0 || value < edges[0] || value > edges[last] {
        return None;
    }
    Some(edges.partition_point(|&edge| edge <= value).clamp(1, last) - 1)
}

/// Counts of values between rising edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Edges, one more than bins.
    pub edges: Vec<f64>,
    /// Values in each bin.
    pub counts: Vec<u64>,
    /// Values in no bin.
    pub outside: u64,
}

impl Histogram {
    /// Counts values between given edges.
    pub fn new(edges: Vec<f64>, values: &[f64]) -> Self {
        let mut counts = vec![0; edges.len().saturating_sub(1)];
        let mut outside = 0;
        for &value in values {
            match bin(&edges, value) {
                Some(bin) => counts[bin] += 1,
                None => outside += 1,
            }
        }
        Self { edges, counts, outside }
    }

    /// Counts sorted values between given edges, with a search an edge instead of one a value.
    pub fn of_sorted(edges: Vec<f64>, sorted: &[f64]) -> Self {
        let below = |edge: f64| sorted.partition_point(|&value| value < edge);
        let mut places: Vec<usize> = edges.iter().map(|&edge| below(edge)).collect();
        // The last bin holds its upper edge.
        if let (Some(place), Some(&edge)) = (places.last_mut(), edges.last()) {
            *place = sorted.partition_point(|&value| value <= edge);
        }
        let counts: Vec<u64> = places.windows(2).map(|pair| (pair[1] - pair[0]) as u64).collect();
        let outside = sorted.len() as u64 - counts.iter().sum::<u64>();
        Self { edges, counts, outside }
    }
}

/// Counts of pairs in a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct PairHistogram {
    /// Edges along x.
    pub x_edges: Vec<f64>,
    /// Edges along y.
    pub y_edges: Vec<f64>,
    /// Pairs in each cell, x index times the number of y bins plus y index.
    pub counts: Vec<u64>,
    /// Pairs in no cell.
    pub outside: u64,
}

impl PairHistogram {
    /// Counts pairs (of two samples of one length) between given edges.
    pub fn new(x_edges: Vec<f64>, y_edges: Vec<f64>, x: &[f64], y: &[f64]) -> Self {
        let lines = y_edges.len().saturating_sub(1);
        let mut counts = vec![0; x_edges.len().saturating_sub(1) * lines];
        let mut outside = 0;
        for (&x, &y) in x.iter().zip(y) {
            match (bin(&x_edges, x), bin(&y_edges, y)) {
                (Some(i), Some(j)) => counts[i * lines + j] += 1,
                _ => outside += 1,
            }
        }
        Self { x_edges, y_edges, counts, outside }
    }
}
