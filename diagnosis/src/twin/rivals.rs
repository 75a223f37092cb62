//! Rivals of a truth: candidates whose refitted predictions come near the true ones.
//!
//! With `r` what the baseline model leaves of the noise-free readings (whitened), `g` a candidate's column and
//! `g~ = (I - P_J) g` what the model's own free parameters cannot do: the cosine is `r . g~ / (|r| |g~|)`, and a candidate
//! refitted leaves `|r|^2 (1 - cos^2)` to first order. The nearest by that are refitted in full. A candidate with more
//! parameters than the truth's effects (a curve, a hidden node) is no rival: it pays for its freedom. The baseline model
//! itself is one: what it leaves may be too little to show. Distances are measured with the noise that there truly is.
//! A threshold is tried between each two of the data's levels: each is a rival of its own, of which the nearest counts.

use crate::math::dense::dot_in_order as dot;
use std::collections::BTreeSet;

use super::inject::{Hidden, InjectError, with_stated_noise};
use super::refit::{self, Refit};
use super::truth::{NoiseTruth, Rival};
use crate::diagnosis::Problem;
use crate::diagnosis::linearisation::threshold_levels::thresholds;
use crate::effect::{Candidate, EffectParameter};
use crate::inference::target::{LeastSquares, Target};
use crate::math::sort::sort_by;
use crate::measurement::Uncertain;

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
    let mut problem = with_stated_noise(problem);
    if let NoiseTruth::Correlated { correlation_time_s, share } = noise {
        for sensor in problem.measurements.iter_mut().flat_map(|measurement| &mut measurement.sensors) {
            let nominal = |value: &Option<Uncertain>| value.as_ref().map_or(0.0, Uncertain::nominal);
            let (correlated, white) = (nominal(&sensor.sigma), nominal(&sensor.white));
            let variance = correlated * correlated + white * white;
            sensor.sigma = Some(Uncertain::Known((variance * share).sqrt()));
            sensor.white = (share < 1.0).then(|| Uncertain::Known((variance * (1.0 - share)).sqrt()));
            sensor.correlation_time_s = Some(Uncertain::Known(correlation_time_s));
        }
    }
    problem
}

/// The nearest rivals of what is hidden, nearest first; without effects the baseline model.
///
/// # Errors
/// [`InjectError`] where the baseline model has no likelihood.
pub fn rivals(problem: &Problem, hidden: &Hidden) -> Result<Vec<Rival>, InjectError> {
    let mut problem = with_true_noise(problem, hidden.truth.noise);
    problem.measurements = refit::with_readings(&problem.measurements, &hidden.clean);
    let truth: Vec<usize> = (0..problem.candidates.len())
        .filter(|&position| hidden.truth.effects.iter().any(|effect| effect.id == problem.candidates[position].id))
        .collect();
    if hidden.truth.is_null() {
        return Ok(Vec::new());
    }
    let likelihood = refit::likelihood(&problem, &hidden.clean)?;
    let unknowns = hidden.refit.names.iter().cloned().zip(hidden.refit.unknowns.iter().copied());
    let start = refit::start(&likelihood, &unknowns.collect::<Vec<_>>());
    let hidden = &Hidden { refit: refit::fit(&likelihood, &[start])?, ..hidden.clone() };
    let freedom = truth.iter().map(|&position| parameters(&problem, position).len()).max().unwrap_or(usize::MAX);
    let basis = Basis::new(&hidden.refit);
    let left = &hidden.refit.residuals;
    let spans: Vec<Reach> = columns(&problem, hidden, freedom)?
        .into_iter()
        .map(|reach| {
            let columns = basis.orthonormal(&reach.columns, &[]);
            let likeliest = match (columns.as_slice(), reach.columns.as_slice(), reach.amplitude) {
                ([q], [column], Some((name, _))) => Some((name, dot(q, left) / dot(q, column))),
                _ => None,
            };
            Reach { columns, amplitude: likeliest, ..reach }
        })
        .collect();
    let total: f64 = left.iter().map(|r| r * r).sum();
    let explained = |span: &[Vec<f64>]| span.iter().map(|q| square(dot(q, left))).sum::<f64>();
    let mut ranked: Vec<(Vec<usize>, &Reach, f64)> = Vec::new();
    for span in &spans {
        if truth.len() != 1 || truth[0] != span.position {
            ranked.push((vec![span.position], span, explained(&span.columns)));
        }
    }
    if truth.len() == 2 {
        // One of the two, with something else in place of the other.
        for true_span in spans.iter().filter(|true_span| truth.contains(&true_span.position)) {
            for span in spans.iter().filter(|span| !truth.contains(&span.position)) {
                let rest = basis.orthonormal(&span.columns, &true_span.columns);
                let share = explained(&true_span.columns) + explained(&rest);
                ranked.push((vec![true_span.position, span.position], span, share));
            }
        }
    }
    sort_by(&mut ranked, |a, b| b.2.total_cmp(&a.2).then_with(|| a.0.cmp(&b.0)));
    let mut seen = BTreeSet::new();
    ranked.retain(|(positions, ..)| seen.insert(positions.clone()));
    ranked.truncate(KEPT);
    let mut rivals = vec![Rival { effects: Vec::new(), cosine: 0.0, delta2: hidden.refit.chi_square() }];
    for (rank, (positions, reach, share)) in ranked.into_iter().enumerate() {
        let cosine = (share / total.max(f64::MIN_POSITIVE)).min(1.0).sqrt();
        let mut delta2 = (total - share).max(0.0);
        if rank < REFITTED
            && delta2 < FAR
            && let Ok(refit) = refitted(&problem, hidden, &positions, reach)
        {
            delta2 = refit;
        }
        let id = |position: &usize| problem.candidates[*position].id.clone();
        rivals.push(Rival { effects: positions.iter().map(id).collect(), cosine, delta2 });
    }
    sort_by(&mut rivals, |a, b| a.delta2.total_cmp(&b.delta2).then_with(|| a.effects.cmp(&b.effects)));
    Ok(rivals)
}

/// What candidates leave when they are refitted with all parameters, from the shape and the amplitude of one of them.
fn refitted(problem: &Problem, hidden: &Hidden, positions: &[usize], reach: &Reach) -> Result<f64, InjectError> {
    // A prior ten times as wide: whether the readings tell, not whether it is plausible.
    let hypothesis = problem.hypothesis(positions, 10.0).map_err(InjectError::Hypothesis)?;
    let likelihood = refit::hypothesis_likelihood(problem, &hypothesis, &hidden.clean)?;
    let refitted: Vec<(String, f64)> =
        hidden.refit.names.iter().cloned().zip(hidden.refit.unknowns.iter().copied()).collect();
    let mut starts = Vec::new();
    for (sign, share) in [(1.0, 0.02), (-1.0, 0.02), (1.0, 0.3)] {
        let mut values = refitted.clone();
        for parameter in hypothesis.amplitudes.iter().flat_map(Clone::clone) {
            let prior = &hypothesis.priors[parameter];
            let amplitude = (prior.quantile(0.84) - prior.quantile(0.16)) * share * sign;
            let (lower, upper) = prior.support();
            let median = prior.quantile(0.5);
            // An effect's amplitudes may be 0; what cannot is a shape, which begins at its median.
            let start = if lower <= 0.0 && upper >= 0.0 { amplitude.clamp(lower, upper) } else { median };
            let name = &hypothesis.model.parameters[parameter].name;
            let start =
                reach.shape.iter().find(|(shape_name, _)| shape_name == name).map_or(start, |(_, value)| *value);
            values.push((name.clone(), start));
        }
        if let (true, Some((name, value))) = (starts.is_empty(), &reach.amplitude) {
            let mut likeliest = values.clone();
            likeliest
                .iter_mut()
                .filter(|(entry, _)| entry == name)
                .for_each(|(_, likeliest_value)| *likeliest_value = *value);
            starts.push(refit::start(&likelihood, &likeliest));
        }
        starts.push(refit::start(&likelihood, &values));
    }
    Ok(refit::fit(&likelihood, &starts)?.chi_square())
}

/// Values of shapes by the names of their parameters, SI; empty: those of the priors' medians.
type Shape = Vec<(String, f64)>;

/// What a candidate can do.
struct Reach {
    /// Its position.
    position: usize,
    /// The shape it has here.
    shape: Shape,
    /// Name of its amplitude where it has only one, with its likeliest value, SI, once that is known.
    amplitude: Option<(String, f64)>,
    /// Whitened columns, each over all rows.
    columns: Vec<Vec<f64>>,
}

/// Whitened columns of all candidates that the test sees and that have no more parameters than `freedom` (one at least),
/// by position; rows of the priors are 0.
fn columns(problem: &Problem, hidden: &Hidden, freedom: usize) -> Result<Vec<Reach>, InjectError> {
    let rows = hidden.refit.residuals.len();
    let mut all = Vec::new();
    let seen: Vec<usize> = (0..problem.candidates.len())
        .filter(|&p| sees(problem, &problem.candidates[p]) && parameters(problem, p).len() <= freedom.max(1))
        .collect();
    let mut begin = 0;
    while begin < seen.len() {
        let effect = &problem.candidates[seen[begin]].effect;
        let same = seen[begin..].iter().take_while(|&&p| problem.candidates[p].effect == *effect).count();
        // Effects that add nodes, times of sensors or another order of channels are not smooth at 0.
        let smooth = problem.catalogue.get(effect).is_some_and(|effect| {
            let adds = &effect.form.adds.value;
            adds.node.is_none()
                && adds.within.is_none()
                && adds.contact.is_none()
                && adds.lag.is_none()
                && adds.clock.is_none()
                && adds.swap.is_none()
        });
        let take = if smooth { same.min(CHUNK) } else { 1 };
        let chunk = &seen[begin..begin + take];
        begin += take;
        let reaches = if smooth { slopes(problem, hidden, chunk) } else { probed(problem, hidden, chunk[0]) };
        for mut reach in reaches.unwrap_or_default() {
            for column in &mut reach.columns {
                column.resize(rows, 0.0);
            }
            all.push(reach);
        }
    }
    Ok(all)
}

fn sees(problem: &Problem, candidate: &Candidate) -> bool {
    use crate::measurement::Rows;
    let has =
        |transient: bool| problem.measurements.iter().any(|m| matches!(m.rows, Rows::Transient { .. }) == transient);
    (candidate.steady && has(false)) || (candidate.transient && has(true))
}

/// Shapes at which a candidate is tried: one reach for each threshold between the data's levels; else a single reach, of
/// columns at quantiles of the priors.
fn shapes(problem: &Problem, position: usize) -> Vec<Vec<Shape>> {
    let candidate = &problem.candidates[position];
    let named = |parameter: &EffectParameter, value: f64| (format!("{}.{}", candidate.id, parameter.name), value);
    let shape_parameters: Vec<EffectParameter> =
        parameters(problem, position).into_iter().filter(|shape_parameters| !shape_parameters.amplitude).collect();
    if let [parameter] = shape_parameters.as_slice()
        && let Some(effect) = problem.catalogue.get(&candidate.effect)
        && let Some(levels) = thresholds(problem, candidate, effect, parameter)
    {
        return levels.into_iter().map(|level| vec![vec![named(parameter, level)]]).collect();
    }
    let shares = if shape_parameters.is_empty() { &[0.5][..] } else { &[0.25, 0.5, 0.75][..] };
    let at = |share: &f64| {
        shape_parameters.iter().map(|parameter| named(parameter, parameter.prior.quantile(*share))).collect()
    };
    vec![shares.iter().map(at).collect()]
}

/// Columns of effects that are smooth at 0: derivatives there, at the shapes at which they are tried.
fn slopes(problem: &Problem, hidden: &Hidden, chunk: &[usize]) -> Result<Vec<Reach>, InjectError> {
    let hypothesis = problem.hypothesis(chunk, 1.0).map_err(InjectError::Hypothesis)?;
    let likelihood = refit::hypothesis_likelihood(problem, &hypothesis, &hidden.clean)?;
    let mut reaches: Vec<Reach> = Vec::new();
    let mut memory = likelihood.workspace();
    let n = likelihood.dimension();
    let m = likelihood.residual_count();
    // The shapes of all candidates of the chunk side by side: by round, the reach and the shape of each.
    let mut rounds: Vec<Vec<(usize, usize, Shape)>> = Vec::new();
    for (place, &position) in chunk.iter().enumerate() {
        let mut round = 0;
        for tried in shapes(problem, position) {
            let reach = reaches.len();
            reaches.push(Reach {
                position,
                shape: if tried.len() == 1 { tried[0].clone() } else { Shape::new() },
                amplitude: only_amplitude(problem, position).map(|name| (name, 0.0)),
                columns: Vec::new(),
            });
            for shape in tried {
                rounds.resize_with(rounds.len().max(round + 1), Vec::new);
                rounds[round].push((place, reach, shape));
                round += 1;
            }
        }
    }
    for round in rounds {
        let mut values: Vec<(String, f64)> =
            hidden.refit.names.iter().cloned().zip(hidden.refit.unknowns.iter().copied()).collect();
        for (place, range) in hypothesis.amplitudes.iter().enumerate() {
            for (index, parameter) in range.clone().zip(&parameters(problem, chunk[place])) {
                let value = if parameter.amplitude { 0.0 } else { parameter.prior.quantile(0.5) };
                values.push((hypothesis.model.parameters[index].name.clone(), value));
            }
        }
        for (name, value) in round.iter().flat_map(|(_, _, shape)| shape) {
            values.iter_mut().filter(|(entry, _)| entry == name).for_each(|(_, start)| *start = *value);
        }
        let at = refit::start(&likelihood, &values);
        let (mut residuals, mut jacobian, mut offset) = (vec![0.0; m], vec![0.0; m * n], vec![0.0; n]);
        if likelihood.jacobian(&at, &mut memory, &mut residuals, &mut jacobian, &mut offset).is_err() {
            continue;
        }
        for (place, reach, _) in round {
            let amplitudes = hypothesis.amplitudes[place].clone().zip(parameters(problem, chunk[place]));
            for (index, _) in amplitudes.filter(|(_, parameter)| parameter.amplitude) {
                let name = &hypothesis.model.parameters[index].name;
                let Some(unknown) = likelihood.names().iter().position(|entry| entry == name) else { continue };
                reaches[reach].columns.push(jacobian.iter().skip(unknown).step_by(n).map(|slope| -slope).collect());
            }
        }
    }
    Ok(reaches)
}

/// Columns of an effect that is not smooth at 0: what it does at each of some plausible sizes.
fn probed(problem: &Problem, hidden: &Hidden, position: usize) -> Result<Vec<Reach>, InjectError> {
    let hypothesis = problem.hypothesis(&[position], 1.0).map_err(InjectError::Hypothesis)?;
    let likelihood = refit::hypothesis_likelihood(problem, &hypothesis, &hidden.clean)?;
    let mut memory = likelihood.workspace();
    let m = likelihood.residual_count();
    let baseline = &hidden.refit.residuals[..hidden.refit.readings];
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
            columns.push(baseline.iter().zip(&residuals).map(|(before, after)| before - after).collect());
        }
        if parameters.is_empty() {
            break;
        }
    }
    Ok(vec![Reach { position, shape: Shape::new(), amplitude: None, columns }])
}

fn parameters(problem: &Problem, position: usize) -> Vec<EffectParameter> {
    let candidate = &problem.candidates[position];
    let effect = problem.catalogue.get(&candidate.effect);
    effect.map(|effect| effect.parameters(&problem.model, &candidate.bound)).unwrap_or_default()
}

/// Name of a candidate's amplitude, if it has one alone.
fn only_amplitude(problem: &Problem, position: usize) -> Option<String> {
    let effect_parameters = parameters(problem, position);
    let mut amplitudes = effect_parameters.iter().filter(|parameter| parameter.amplitude);
    let first = amplitudes.next()?;
    amplitudes.next().is_none().then(|| format!("{}.{}", problem.candidates[position].id, first.name))
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

fn square(value: f64) -> f64 {
    value * value
}
