//! Exchanged channels that no linearisation shows: a large exchange bends the fit of the believed model so far that its
//! predictions there say nothing of what the sensors would read.

use super::{Problem, Refit};
use crate::effect::Effect;
use crate::inference::target::{LeastSquares, Target};

/// The candidates that exchange channels and, nothing being refitted, leave less than the believed model does: at its fit or
/// at the priors' medians. Positions, at most `count`, those that leave least first.
pub(super) fn likeliest(problem: &Problem, believed: &Refit, count: usize) -> Vec<usize> {
    let exchanges = |effect: &str| problem.catalogue.get(effect).is_some_and(Effect::exchanges_channels);
    let Some(without) = left(problem, believed, &[]) else { return Vec::new() };
    let mut found: Vec<(f64, usize)> = (0..problem.candidates.len())
        .filter(|&position| exchanges(&problem.candidates[position].effect))
        .filter_map(|position| {
            let with = left(problem, believed, &[position])?;
            (with[0] < without[0] || with[1] < without[1]).then(|| (with[0].min(with[1]), position))
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.truncate(count);
    found.into_iter().map(|(_, position)| position).collect()
}

/// Sums of squares with effects at the believed model's fit and at the medians of all priors; infinite where the model has
/// no solution.
fn left(problem: &Problem, believed: &Refit, effects: &[usize]) -> Option<[f64; 2]> {
    let likelihood = problem.hypothesis(effects, 1.0).ok()?.likelihood(problem).ok()?;
    let known = believed.by_name();
    let medians: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    let fitted: Vec<f64> = (likelihood.names().iter().zip(&medians))
        .map(|(name, median)| known.get(name).copied().unwrap_or(*median))
        .collect();
    let mut workspace = likelihood.workspace();
    let mut residuals = vec![0.0; likelihood.residual_count()];
    Some([fitted, medians].map(|at| match likelihood.residuals(&at, &mut workspace, &mut residuals) {
        Ok(_) => residuals.iter().map(|r| r * r).sum(),
        Err(_) => f64::INFINITY,
    }))
}
