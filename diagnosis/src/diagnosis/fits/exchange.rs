//! Exchanged channels that no linearisation shows: a large exchange bends the fit of the baseline model so far that its
//! predictions there say nothing of what the sensors would read.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::diagnosis::FitError;
use crate::diagnosis::linearisation::signature;
use crate::diagnosis::{Problem, Refit};
use crate::effect::Effect;
use crate::inference::target::{LeastSquares, Target};
use crate::math::sort::sort_by;

/// Exchanges that are tried one by one in steady phases: all those of twenty sensors.
const MOST_ONE_BY_ONE: usize = 200;
/// Of more, so many times those wanted are chosen by predictions and then tried; so they are of long transients, where each
/// exchange takes two courses of all rows.
const MORE_THAN_WANTED: usize = 4;

/// Candidates that exchange channels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exchanges {
    /// Those that, nothing being refitted, leave less than the baseline model does: at its fit or at the priors' medians.
    /// Positions, those that leave least first.
    pub likeliest: Vec<usize>,
    /// Those of which no model can be made: position and why.
    pub impossible: Vec<(usize, FitError)>,
}

/// The candidates that exchange channels, at most `count` of the likeliest.
///
/// # Errors
/// Why nothing can be predicted without any of them.
pub fn exchanges(problem: &Problem, baseline: &Refit, count: usize) -> Result<Exchanges, FitError> {
    let is_one = |effect: &str| problem.catalogue.get(effect).is_some_and(Effect::exchanges_channels);
    let mut all: Vec<usize> =
        (0..problem.candidates.len()).filter(|&candidate| is_one(&problem.candidates[candidate].effect)).collect();
    let (mut improving, mut impossible) = (Vec::new(), Vec::new());
    if all.is_empty() {
        return Ok(Exchanges::default());
    }
    let without = left(problem, baseline, &[])?;
    // Known errors of inputs would be those of the exchanged sensors.
    let are_inputs_exact = problem.input_errors.iter().all(|error| error.sigma.is_none());
    let most = if problem.has_long_transients() {
        MORE_THAN_WANTED * count
    } else if problem.has_transients() {
        usize::MAX
    } else {
        MOST_ONE_BY_ONE
    };
    if all.len() > most && are_inputs_exact {
        all = likeliest_by_predictions(problem, baseline, &all, MORE_THAN_WANTED * count)?;
    }
    let tried: Vec<(usize, Result<[f64; 2], FitError>)> =
        all.into_par_iter().map(|position| (position, left(problem, baseline, &[position]))).collect();
    for (position, with) in tried {
        match with {
            Ok(with) if with[0] < without[0] || with[1] < without[1] => {
                improving.push((with[0].min(with[1]), position))
            }
            Ok(_) => {}
            Err(why) => impossible.push((position, why)),
        }
    }
    sort_by(&mut improving, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    improving.truncate(count);
    Ok(Exchanges { likeliest: improving.into_iter().map(|(_, position)| position).collect(), impossible })
}

/// Of many candidates those that leave least if predictions are exchanged where they stand, ascending: a model for each would
/// take minutes. Predictions at the medians of all priors are left out where the model has no solution there.
///
/// # Errors
/// Why nothing can be predicted at the fit.
fn likeliest_by_predictions(
    problem: &Problem,
    baseline: &Refit,
    all: &[usize],
    count: usize,
) -> Result<Vec<usize>, FitError> {
    let likelihood = problem.hypothesis(&[], 1.0)?.likelihood(problem)?;
    let medians: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    let mut least: BTreeMap<usize, f64> = BTreeMap::new();
    for (unknowns, is_fit) in [(&baseline.unknowns, true), (&medians, false)] {
        let mut residuals = vec![0.0; likelihood.residual_count()];
        if let Err(why) = likelihood.residuals(unknowns, &mut likelihood.workspace(), &mut residuals) {
            if is_fit {
                return Err(why.into());
            }
            continue;
        }
        signature::for_each_direction(problem, &likelihood, unknowns, all, &mut |directions| {
            for direction in directions {
                let errors = residuals.iter().zip(direction.column(0)).map(|(own, change)| own - change);
                let square = errors.map(|error| error * error).sum::<f64>();
                let before = least.entry(direction.candidate).or_insert(f64::INFINITY);
                *before = before.min(square);
            }
        })?;
    }
    let mut order: Vec<(f64, usize)> = least.into_iter().map(|(candidate, square)| (square, candidate)).collect();
    sort_by(&mut order, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut likeliest: Vec<usize> = order.into_iter().take(count).map(|(_, candidate)| candidate).collect();
    likeliest.sort_unstable();
    Ok(likeliest)
}

/// Sums of squares with effects at the baseline model's fit and at the medians of all priors; infinite where the model has
/// no solution.
///
/// # Errors
/// Why no model can be made with these effects.
fn left(problem: &Problem, baseline: &Refit, effects: &[usize]) -> Result<[f64; 2], FitError> {
    let hypothesis = problem.hypothesis(effects, 1.0).and_then(|extended| extended.likelihood(problem));
    let likelihood = hypothesis?;
    let baseline_values = baseline.by_name();
    let medians: Vec<f64> = likelihood.priors().iter().map(|prior| prior.quantile(0.5)).collect();
    let fitted: Vec<f64> = (likelihood.names().iter().zip(&medians))
        .map(|(name, median)| baseline_values.get(name).copied().unwrap_or(*median))
        .collect();
    let mut workspace = likelihood.workspace();
    let mut residuals = vec![0.0; likelihood.residual_count()];
    Ok([fitted, medians].map(|at| match likelihood.residuals(&at, &mut workspace, &mut residuals) {
        Ok(_) => residuals.iter().map(|r| r * r).sum(),
        Err(_) => f64::INFINITY,
    }))
}
