//! Effects that are smooth at amplitude 0, each with one value of its shape.

use super::form::{Form, bounds, plausible, shapes};
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::diagnosis::linearisation::linear::Direction;
use crate::diagnosis::linearisation::threshold_levels::thresholds;
use crate::effect::{Effect, EffectParameter};
use crate::random::Distribution;

/// An effect with one value of its shape.
pub struct Variant<'a> {
    /// Position in the list asked for.
    pub asked: usize,
    /// Position of the candidate.
    pub candidate: usize,
    /// The effect, as the data see it.
    pub effect: &'a Effect,
    /// Its parameters: the amplitudes with a nominal value of 0 and a prior with spread, the others fixed.
    pub parameters: Vec<EffectParameter>,
    /// Its parameters as written.
    written: Vec<EffectParameter>,
    /// Values of the parameters that shape it, SI.
    shape: Vec<f64>,
}

/// The variants of each candidate asked for.
pub fn variants<'a>(base: &Base<'_>, asked: &[(usize, &Form<'a>)]) -> Vec<Variant<'a>> {
    let mut variants = Vec::new();
    for (place, &(candidate, form)) in asked.iter().enumerate() {
        let &Form::Smooth { effect } = form else { continue };
        let written = effect.parameters(&base.problem.model, &base.problem.candidates[candidate].bound);
        let bound_candidate = &base.problem.candidates[candidate];
        let usual = || shapes(&written, |parameter| thresholds(base.problem, bound_candidate, effect, parameter));
        for shape in base.shapes.get(&candidate).cloned().unwrap_or_else(usual) {
            let mut values = shape.iter();
            let parameters = (written.iter())
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
            variants.push(Variant { asked: place, candidate, effect, parameters, written: written.clone(), shape });
        }
    }
    variants
}

/// Adds what was found of a variant to what was found of its candidate.
pub(super) fn put(directions: &mut Found, direction: Result<Option<Direction>, FitError>) {
    match (directions, direction) {
        (Ok(directions), Ok(Some(direction))) => directions.push(direction),
        (directions, Err(reason)) if directions.as_ref().is_ok_and(Vec::is_empty) => *directions = Err(reason),
        (directions @ Err(_), Ok(Some(direction))) => *directions = Ok(vec![direction]),
        _ => {}
    }
}

impl Variant<'_> {
    /// Its direction from whitened columns of the readings, one an amplitude, without those that are 0; none where all
    /// are. The columns of the direction have so many `rows`.
    pub fn direction(
        &self,
        rows: usize,
        columns: impl Iterator<Item = Vec<f64>>,
    ) -> Result<Option<Direction>, FitError> {
        let mut direction = Direction { candidate: self.candidate, shape: self.shape.clone(), ..Direction::default() };
        let amplitudes = (0..self.written.len()).filter(|&position| self.written[position].amplitude);
        for (position, column) in amplitudes.zip(columns) {
            if column.iter().any(|value| !value.is_finite()) {
                return Err(NoDirection::NotFinite.into());
            }
            if column.iter().all(|value| *value == 0.0) {
                continue;
            }
            let (lower, upper) = bounds(&self.written[position]);
            direction.parameters.push(position);
            direction.columns.extend(column);
            direction.columns.resize(direction.parameters.len() * rows, 0.0);
            direction.lower.push(lower);
            direction.upper.push(upper);
            direction.plausible.push(plausible(&self.written[position]));
        }
        Ok((!direction.parameters.is_empty()).then_some(direction))
    }
}
