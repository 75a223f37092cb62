//! Exchanged channels that no linearisation shows: a large exchange bends the fit of the believed model so far that its
//! predictions there say nothing of what the sensors would read.

use super::{Problem, Refit};
use crate::inference::target::{LeastSquares, Target};

/// The candidates that exchange channels and leave the least sum of squares at the believed model's fit or at its priors'
/// medians, nothing being refitted: positions, at most `count`.
pub(super) fn likeliest(problem: &Problem, believed: &Refit, count: usize) -> Vec<usize> {
    let exchanges = |effect: &str| problem.catalogue.get(effect).is_some_and(|own| own.form.adds.value.swap.is_some());
    let known = believed.by_name();
    let left = |position: usize| -> Option<f64> {
        let likelihood = problem.hypothesis(&[position], 1.0).ok()?.likelihood(problem).ok()?;
        let medians: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
        let fitted: Vec<f64> = (likelihood.names().iter().zip(&medians))
            .map(|(name, median)| known.get(name).copied().unwrap_or(*median))
            .collect();
        let mut workspace = likelihood.workspace();
        let mut residuals = vec![0.0; likelihood.residual_count()];
        let mut square = |at: &[f64]| {
            likelihood.residuals(at, &mut workspace, &mut residuals).ok()?;
            Some(residuals.iter().map(|r| r * r).sum::<f64>())
        };
        [square(&fitted), square(&medians)].into_iter().flatten().reduce(f64::min)
    };
    let mut found: Vec<(f64, usize)> = (0..problem.candidates.len())
        .filter(|&position| exchanges(&problem.candidates[position].effect))
        .filter_map(|position| Some((left(position)?, position)))
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.truncate(count);
    found.into_iter().map(|(_, position)| position).collect()
}
