//! Exact derivatives of many effects at once: sensitivities of a model that holds them all with amplitude 0.

use super::form::{Form, bounds, plausible, shapes};
use super::{Base, Found};
use crate::diagnosis::hypothesis::HypothesisError;
use crate::diagnosis::linear::Direction;
use crate::effect::{Effect, EffectParameter};
use crate::inference::likelihood::Likelihood;
use crate::inference::target::{LeastSquares, Target};
use crate::random::Distribution;

/// An effect with one value of its shape.
struct Variant<'a> {
    /// Position in the list asked for.
    asked: usize,
    candidate: usize,
    effect: &'a Effect,
    parameters: Vec<EffectParameter>,
    shape: Vec<f64>,
}

/// The directions of each candidate asked for.
pub(super) fn directions(base: &Base<'_>, asked: &[(usize, &Form)]) -> Vec<Found> {
    let mut variants = Vec::new();
    for (place, &(candidate, form)) in asked.iter().enumerate() {
        let Form::Smooth { effect } = form else { continue };
        let parameters = effect.parameters(&base.problem.model, &base.problem.candidates[candidate].bound);
        for shape in shapes(&parameters) {
            let mut values = shape.iter();
            let parameters = parameters
                .iter()
                .map(|parameter| {
                    // Any prior with spread makes an unknown of an amplitude.
                    let (prior, nominal) = if parameter.amplitude {
                        (Distribution::Uniform { lower: -1.0, upper: 1.0 }, 0.0)
                    } else {
                        let value = values.next().copied().unwrap_or(parameter.nominal);
                        (Distribution::Fixed(value), value)
                    };
                    EffectParameter { prior, nominal, ..parameter.clone() }
                })
                .collect();
            variants.push(Variant { asked: place, candidate, effect, parameters, shape });
        }
    }
    let mut found: Vec<Found> = asked.iter().map(|_| Ok(Vec::new())).collect();
    solve(base, &variants, &mut found);
    for (found, &(candidate, _)) in found.iter_mut().zip(asked) {
        if found.as_ref().is_ok_and(Vec::is_empty) {
            let steady = !base.problem.candidates[candidate].transient;
            *found = Err(if steady { "none of the steady readings depends on it" } else { "no reading depends on it" }
                .to_owned());
        }
    }
    found
}

/// Solves variants together; where they do not go together, in halves, so that one that fails spoils no other.
fn solve(base: &Base<'_>, variants: &[Variant<'_>], found: &mut [Found]) {
    if variants.is_empty() {
        return;
    }
    match together(base, variants) {
        Ok(directions) => {
            for (variant, direction) in variants.iter().zip(directions) {
                if let (Ok(found), Some(direction)) = (&mut found[variant.asked], direction) {
                    found.push(direction);
                }
            }
        }
        Err(reason) => {
            if let [variant] = variants {
                if found[variant.asked].as_ref().is_ok_and(Vec::is_empty) {
                    found[variant.asked] = Err(reason);
                }
                return;
            }
            let (first, second) = variants.split_at(variants.len() / 2);
            solve(base, first, found);
            solve(base, second, found);
        }
    }
}

/// A direction for each variant; `None` where nothing depends on it.
fn together(base: &Base<'_>, variants: &[Variant<'_>]) -> Result<Vec<Option<Direction>>, String> {
    let (likelihood, widths) = extended(base, variants).map_err(|error| error.to_string())?;
    let own = base.likelihood.model_parameters();
    let added: usize = widths.iter().sum();
    let mut unknowns = base.unknowns[..own].to_vec();
    unknowns.extend(std::iter::repeat_n(0.0, added));
    unknowns.extend(&base.unknowns[own..]);
    let (readings, n) = (likelihood.residual_count(), unknowns.len());
    if readings != base.residuals.len() || n != likelihood.dimension() {
        return Err("it changes what is measured".to_owned());
    }
    let mut jacobian = vec![0.0; readings * n];
    let (mut residuals, mut gradient) = (vec![0.0; readings], vec![0.0; n]);
    let mut memory = likelihood.workspace();
    likelihood
        .jacobian(&unknowns, &mut memory, &mut residuals, &mut jacobian, &mut gradient)
        .map_err(|rejected| rejected.to_string())?;
    let mut first = own;
    let mut directions = Vec::with_capacity(variants.len());
    for (variant, width) in variants.iter().zip(widths) {
        let columns = (first..first + width).map(|place| {
            let readings = (0..readings).map(|row| -jacobian[row * n + place]);
            readings.collect::<Vec<f64>>()
        });
        directions.push(direction(base, variant, columns)?);
        first += width;
    }
    Ok(directions)
}

/// The likelihood of the model with all variants, and the number of amplitudes of each.
fn extended(base: &Base<'_>, variants: &[Variant<'_>]) -> Result<(Likelihood, Vec<usize>), HypothesisError> {
    let problem = base.problem;
    let mut hypothesis = problem.hypothesis(&[], 1.0)?;
    let mut widths = Vec::with_capacity(variants.len());
    for (number, variant) in variants.iter().enumerate() {
        let candidate = &problem.candidates[variant.candidate];
        let name = format!("{} ({number})", candidate.id);
        hypothesis.add_as(candidate, variant.effect, &name, variant.parameters.clone())?;
        widths.push(variant.parameters.iter().filter(|parameter| parameter.amplitude).count());
    }
    Ok((hypothesis.likelihood(problem)?, widths))
}

/// The direction of a variant from its whitened columns, without those that are 0.
fn direction(
    base: &Base<'_>,
    variant: &Variant<'_>,
    columns: impl Iterator<Item = Vec<f64>>,
) -> Result<Option<Direction>, String> {
    let original = variant.effect.parameters(&base.problem.model, &base.problem.candidates[variant.candidate].bound);
    let mut direction =
        Direction { candidate: variant.candidate, shape: variant.shape.clone(), ..Direction::default() };
    let amplitudes = (0..original.len()).filter(|&position| original[position].amplitude);
    for (position, column) in amplitudes.zip(columns) {
        if column.iter().any(|value| !value.is_finite()) {
            return Err("its derivatives are not finite numbers".to_owned());
        }
        if column.iter().all(|value| *value == 0.0) {
            continue;
        }
        let (lower, upper) = bounds(&original[position]);
        direction.parameters.push(position);
        direction.columns.extend(column);
        direction.columns.resize(direction.parameters.len() * base.rows, 0.0);
        direction.lower.push(lower);
        direction.upper.push(upper);
        direction.plausible.push(plausible(&original[position]));
    }
    Ok((!direction.parameters.is_empty()).then_some(direction))
}
