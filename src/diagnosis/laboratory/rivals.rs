//! Rivals of a truth: candidates whose refitted predictions come near the true ones.
//!
//! With `r` what the believed model leaves of the noise-free readings (whitened), `g` a candidate's column and
//! `g~ = (I - P_J) g` what the model's own free parameters cannot do: the cosine is `r . g~ / (|r| |g~|)`, and a candidate
//! refitted leaves `|r|^2 (1 - cos^2)` to first order. The nearest by that are refitted in full. A candidate with more
//! parameters than the truth's effects (a curve, a hidden node) is no rival: it pays for its freedom. The believed model
//! itself is one: what it leaves may be too little to show. Distances are measured with the noise that there truly is.

use super::hide::{Hidden, HideError, told};
use super::refit::{self, Refit};
use super::truth::{NoiseTruth, Rival};
use crate::diagnosis::Problem;
use crate::effect::Candidate;
use crate::inference::measurement::Uncertain;
use crate::inference::target::{LeastSquares, Target};

/// Rivals kept.
const KEPT: usize = 8;
/// Rivals refitted in full.
const REFITTED: usize = 6;
/// Candidates whose columns are found at once.
const CHUNK: usize = 24;
/// Rivals farther than this by the linear estimate, in squared standard deviations, are not refitted.
const FAR: f64 = 60.0;

/// The problem with its noise known as it truly is.
fn with_true_noise(problem: &Problem, noise: NoiseTruth) -> Problem {
    let mut problem = told(problem);
    if let NoiseTruth::Correlated { correlation_time_s } = noise {
        for sensor in problem.measurements.iter_mut().flat_map(|measurement| &mut measurement.sensors) {
            let nominal = |value: &Option<Uncertain>| value.as_ref().map_or(0.0, Uncertain::nominal);
            let (correlated, white) = (nominal(&sensor.sigma), nominal(&sensor.white));
            sensor.sigma = Some(Uncertain::Known((correlated * correlated + white * white).sqrt()));
            sensor.white = None;
            sensor.correlation_time_s = Some(Uncertain::Known(correlation_time_s));
        }
    }
    problem
}

/// The nearest rivals of what is hidden, nearest first; without effects the believed model.
///
/// # Errors
/// [`HideError`] where the believed model has no likelihood.
pub fn rivals(problem: &Problem, hidden: &Hidden) -> Result<Vec<Rival>, HideError> {
    let problem = with_true_noise(problem, hidden.truth.noise);
    let truth: Vec<usize> = (0..problem.candidates.len())
        .filter(|&position| hidden.truth.effects.iter().any(|own| own.id == problem.candidates[position].id))
        .collect();
    if hidden.truth.is_null() {
        return Ok(Vec::new());
    }
    let likelihood = refit::likelihood(&problem, &hidden.clean)?;
    let known = hidden.refit.names.iter().cloned().zip(hidden.refit.unknowns.iter().copied());
    let start = refit::start(&likelihood, &known.collect::<Vec<_>>());
    let hidden = &Hidden { refit: refit::fit(&likelihood, &[start])?, ..hidden.clone() };
    let freedom = truth.iter().map(|&position| parameters(&problem, position).len()).max().unwrap_or(usize::MAX);
    let basis = Basis::new(&hidden.refit);
    let spans: Vec<(usize, Vec<Vec<f64>>)> = columns(&problem, hidden, freedom)?
        .into_iter()
        .map(|(position, columns)| (position, basis.orthonormal(&columns, &[])))
        .collect();
    let left = &hidden.refit.residuals;
    let total: f64 = left.iter().map(|r| r * r).sum();
    let explained = |span: &[Vec<f64>]| span.iter().map(|q| square(dot(q, left))).sum::<f64>();
    let mut found: Vec<(Vec<usize>, f64)> = Vec::new();
    for (position, span) in &spans {
        if truth.len() != 1 || truth[0] != *position {
            found.push((vec![*position], explained(span)));
        }
    }
    if truth.len() == 2 {
        // One of the two, with something else in place of the other.
        for &kept in &truth {
            let Some((_, own)) = spans.iter().find(|(position, _)| *position == kept) else { continue };
            for (position, span) in spans.iter().filter(|(position, _)| !truth.contains(position)) {
                let rest = basis.orthonormal(span, own);
                found.push((vec![kept, *position], explained(own) + explained(&rest)));
            }
        }
    }
    found.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    found.truncate(KEPT);
    let mut rivals = vec![Rival { effects: Vec::new(), cosine: 0.0, delta2: hidden.refit.chi_square() }];
    for (rank, (positions, share)) in found.into_iter().enumerate() {
        let cosine = (share / total.max(f64::MIN_POSITIVE)).min(1.0).sqrt();
        let mut delta2 = (total - share).max(0.0);
        if rank < REFITTED
            && delta2 < FAR
            && let Ok(refit) = refitted(&problem, hidden, &positions)
        {
            delta2 = refit;
        }
        let id = |position: &usize| problem.candidates[*position].id.clone();
        rivals.push(Rival { effects: positions.iter().map(id).collect(), cosine, delta2 });
    }
    rivals.sort_by(|a, b| a.delta2.total_cmp(&b.delta2).then_with(|| a.effects.cmp(&b.effects)));
    Ok(rivals)
}

/// What candidates leave when they are refitted with all parameters.
fn refitted(problem: &Problem, hidden: &Hidden, positions: &[usize]) -> Result<f64, HideError> {
    // A prior ten times as wide: whether the readings tell, not whether it is plausible.
    let hypothesis = problem.hypothesis(positions, 10.0).map_err(HideError::Hypothesis)?;
    let likelihood = refit::hypothesis_likelihood(problem, &hypothesis, &hidden.clean)?;
    let known: Vec<(String, f64)> =
        hidden.refit.names.iter().cloned().zip(hidden.refit.unknowns.iter().copied()).collect();
    let mut starts = Vec::new();
    for (sign, share) in [(1.0, 0.02), (-1.0, 0.02), (1.0, 0.3)] {
        let mut values = known.clone();
        for parameter in hypothesis.amplitudes.iter().flat_map(Clone::clone) {
            let prior = &hypothesis.priors[parameter];
            let amplitude = (prior.quantile(0.84) - prior.quantile(0.16)) * share * sign;
            let (lower, upper) = prior.support();
            let median = prior.quantile(0.5);
            // An effect's amplitudes may be 0; what cannot is a shape, which begins at its median.
            let start = if lower <= 0.0 && upper >= 0.0 { amplitude.clamp(lower, upper) } else { median };
            values.push((hypothesis.model.parameters[parameter].name.clone(), start));
        }
        starts.push(refit::start(&likelihood, &values));
    }
    Ok(refit::fit(&likelihood, &starts)?.chi_square())
}

/// Whitened columns of all candidates that the test sees and that have no more parameters than `freedom` (one at least),
/// by position; rows of the priors are 0.
fn columns(problem: &Problem, hidden: &Hidden, freedom: usize) -> Result<Found, HideError> {
    let rows = hidden.refit.residuals.len();
    let mut all = Vec::new();
    let seen: Vec<usize> = (0..problem.candidates.len())
        .filter(|&p| sees(problem, &problem.candidates[p]) && parameters(problem, p).len() <= freedom.max(1))
        .collect();
    let mut begin = 0;
    while begin < seen.len() {
        let effect = &problem.candidates[seen[begin]].effect;
        let same = seen[begin..].iter().take_while(|&&p| problem.candidates[p].effect == *effect).count();
        // Effects that add nodes, lags or another order of channels are not smooth at 0.
        let smooth = problem.catalogue.get(effect).is_some_and(|effect| {
            let adds = &effect.form.adds.value;
            adds.node.is_none()
                && adds.within.is_none()
                && adds.contact.is_none()
                && adds.lag.is_none()
                && adds.swap.is_none()
        });
        let take = if smooth { same.min(CHUNK) } else { 1 };
        let chunk = &seen[begin..begin + take];
        begin += take;
        let found = if smooth { slopes(problem, hidden, chunk) } else { probed(problem, hidden, chunk[0]) };
        for (position, mut columns) in found.unwrap_or_default() {
            for column in &mut columns {
                column.resize(rows, 0.0);
            }
            all.push((position, columns));
        }
    }
    Ok(all)
}

fn sees(problem: &Problem, candidate: &Candidate) -> bool {
    use crate::inference::measurement::Rows;
    let has =
        |transient: bool| problem.measurements.iter().any(|m| matches!(m.rows, Rows::Transient { .. }) == transient);
    (candidate.steady && has(false)) || (candidate.transient && has(true))
}

/// Columns by position of the candidate.
type Found = Vec<(usize, Vec<Vec<f64>>)>;

/// Columns of effects that are smooth at 0: derivatives there, shapes at two quantiles of their priors.
fn slopes(problem: &Problem, hidden: &Hidden, chunk: &[usize]) -> Result<Found, HideError> {
    let hypothesis = problem.hypothesis(chunk, 1.0).map_err(HideError::Hypothesis)?;
    let likelihood = refit::hypothesis_likelihood(problem, &hypothesis, &hidden.clean)?;
    let mut found: Found = chunk.iter().map(|&position| (position, Vec::new())).collect();
    let shaped = (0..hypothesis.amplitudes.len()).any(|place| is_shaped(problem, chunk[place]));
    let mut memory = likelihood.workspace();
    let n = likelihood.dimension();
    let m = likelihood.residual_count();
    for share in if shaped { &[0.25, 0.5, 0.75][..] } else { &[0.5][..] } {
        let mut values: Vec<(String, f64)> =
            hidden.refit.names.iter().cloned().zip(hidden.refit.unknowns.iter().copied()).collect();
        for (place, range) in hypothesis.amplitudes.iter().enumerate() {
            let parameters = parameters(problem, chunk[place]);
            for (index, parameter) in range.clone().zip(&parameters) {
                let value = if parameter.amplitude { 0.0 } else { parameter.prior.quantile(*share) };
                values.push((hypothesis.model.parameters[index].name.clone(), value));
            }
        }
        let at = refit::start(&likelihood, &values);
        let (mut residuals, mut jacobian, mut offset) = (vec![0.0; m], vec![0.0; m * n], vec![0.0; n]);
        if likelihood.jacobian(&at, &mut memory, &mut residuals, &mut jacobian, &mut offset).is_err() {
            continue;
        }
        for (place, range) in hypothesis.amplitudes.iter().enumerate() {
            let parameters = parameters(problem, chunk[place]);
            for (index, _) in range.clone().zip(&parameters).filter(|(_, parameter)| parameter.amplitude) {
                let name = &hypothesis.model.parameters[index].name;
                let Some(unknown) = likelihood.names().iter().position(|own| own == name) else { continue };
                found[place].1.push(jacobian.iter().skip(unknown).step_by(n).map(|slope| -slope).collect());
            }
        }
    }
    Ok(found)
}

/// Columns of an effect that is not smooth at 0: what it does at each of some plausible sizes.
fn probed(problem: &Problem, hidden: &Hidden, position: usize) -> Result<Found, HideError> {
    let hypothesis = problem.hypothesis(&[position], 1.0).map_err(HideError::Hypothesis)?;
    let likelihood = refit::hypothesis_likelihood(problem, &hypothesis, &hidden.clean)?;
    let mut memory = likelihood.workspace();
    let m = likelihood.residual_count();
    let believed = &hidden.refit.residuals[..hidden.refit.readings];
    let parameters = parameters(problem, position);
    let mut columns = Vec::new();
    for share in [0.1, 1.0] {
        let mut values: Vec<(String, f64)> =
            hidden.refit.names.iter().cloned().zip(hidden.refit.unknowns.iter().copied()).collect();
        for (index, parameter) in hypothesis.amplitudes[0].clone().zip(&parameters) {
            let value = if parameter.amplitude { share * parameter.plausible } else { parameter.nominal };
            values.push((hypothesis.model.parameters[index].name.clone(), value));
        }
        let at = refit::start(&likelihood, &values);
        let mut residuals = vec![0.0; m];
        if likelihood.residuals(&at, &mut memory, &mut residuals).is_ok() {
            columns.push(believed.iter().zip(&residuals).map(|(before, after)| before - after).collect());
        }
        if parameters.is_empty() {
            break;
        }
    }
    Ok(vec![(position, columns)])
}

fn parameters(problem: &Problem, position: usize) -> Vec<crate::effect::EffectParameter> {
    let candidate = &problem.candidates[position];
    let effect = problem.catalogue.get(&candidate.effect);
    effect.map(|effect| effect.parameters(&problem.model, &candidate.bound)).unwrap_or_default()
}

fn is_shaped(problem: &Problem, position: usize) -> bool {
    parameters(problem, position).iter().any(|parameter| !parameter.amplitude)
}

/// Orthonormal columns that span what the free parameters can do.
struct Basis {
    free: Vec<Vec<f64>>,
}

/// Columns whose part outside a span is smaller than this, relatively, are in it.
const WITHIN: f64 = 1e-5;

impl Basis {
    fn new(refit: &Refit) -> Self {
        let mut basis = Self { free: Vec::new() };
        basis.free = basis.orthonormal(&refit.free, &[]);
        basis
    }

    /// Orthonormal columns of a span outside the free parameters' and another one: Gram-Schmidt, twice.
    fn orthonormal(&self, columns: &[Vec<f64>], beside: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut span: Vec<Vec<f64>> = Vec::new();
        for column in columns {
            let before = dot(column, column).sqrt();
            let mut rest = column.clone();
            for _ in 0..2 {
                for q in self.free.iter().chain(beside).chain(&span) {
                    let along = dot(q, &rest);
                    rest.iter_mut().zip(q).for_each(|(value, q)| *value -= along * q);
                }
            }
            let norm = dot(&rest, &rest).sqrt();
            if norm > WITHIN * before && norm.is_finite() {
                rest.iter_mut().for_each(|value| *value /= norm);
                span.push(rest);
            }
        }
        span
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn square(value: f64) -> f64 {
    value * value
}
