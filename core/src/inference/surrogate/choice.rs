//! Where further runs of the model tell most: points are chosen one after the other where the error weighs most, each as if
//! the runs before it were there. What a run changes of the errors elsewhere depends on where it lies alone, not on what it gives
//! (Rasmussen & Williams 2006, eq. 2.26).

use super::Surrogate;
use crate::thermal::Point;

/// Share of an error's largest variance that counts as known.
const KNOWN: f64 = 1e-12;

/// A point where the surrogate is needed.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The point.
    pub point: Point,
    /// Weight of the variance of each output's error there.
    pub weights: Vec<f64>,
}

/// Places of at most so many candidates, the most telling first.
pub fn choose(surrogate: &Surrogate, candidates: &[Candidate], count: usize) -> Vec<usize> {
    let known: Vec<(usize, Vec<f64>)> = (candidates.iter().enumerate())
        .filter_map(|(place, candidate)| Some((place, surrogate.coordinates(&candidate.point).ok()?)))
        .collect();
    let coordinates: Vec<Vec<f64>> = known.iter().map(|(_, coordinates)| coordinates.clone()).collect();
    let (n, outputs) = (known.len(), candidates.first().map_or(0, |candidate| candidate.weights.len()));
    let mut covariances: Vec<Vec<f64>> =
        (0..outputs).map(|output| surrogate.covariance(output, &coordinates)).collect();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count.min(n) {
        let score = |row: usize| -> f64 {
            let weights = &candidates[known[row].0].weights;
            weights
                .iter()
                .zip(&covariances)
                .map(|(weight, covariance)| weight * covariance[row * n + row].max(0.0))
                .sum()
        };
        let mut best: Option<(usize, f64)> = None;
        for row in (0..n).filter(|row| !chosen.contains(row)) {
            let own = score(row);
            if best.is_none_or(|(_, other)| own > other) {
                best = Some((row, own));
            }
        }
        let Some((best, _)) = best.filter(|(_, score)| *score > 0.0) else { break };
        for covariance in &mut covariances {
            let column: Vec<f64> = (0..n).map(|row| covariance[row * n + best]).collect();
            let largest = (0..n).map(|row| covariance[row * n + row]).fold(0.0, f64::max);
            if column[best] <= KNOWN * largest {
                continue;
            }
            for row in 0..n {
                let share = column[row] / column[best];
                covariance[row * n..(row + 1) * n]
                    .iter_mut()
                    .zip(&column)
                    .for_each(|(value, own)| *value -= share * own);
            }
        }
        chosen.push(best);
    }
    chosen.into_iter().map(|row| known[row].0).collect()
}
