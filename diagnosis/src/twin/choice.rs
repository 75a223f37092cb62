//! Places and amplitudes of what is hidden, drawn.

use super::draw::{Draw, short};
use super::inject::InjectError;
use super::truth::{HiddenEffect, HiddenValue, Outside};
use crate::diagnosis::Problem;
use crate::diagnosis::odds::prior_odds::PriorOdds;
use crate::effect::{Effect, EffectParameter};
use crate::measurement::{Measurement, Rows};
use crate::thermal::NodeKind;

/// Amplitudes beyond this multiple of their plausible scale are not drawn.
const REACH: f64 = 3.0;

/// An effect at a place, with the parameters that it will have, SI.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    /// Position of the candidate.
    pub candidate: usize,
    parameters: Vec<EffectParameter>,
    values: Vec<f64>,
}

impl Chosen {
    pub fn has_amplitude(&self) -> bool {
        self.parameters.iter().any(|parameter| parameter.amplitude)
    }

    pub fn scaled(&self, scale: f64) -> Vec<f64> {
        (self.parameters.iter().zip(&self.values))
            .map(|(parameter, value)| if parameter.amplitude { scale * value } else { *value })
            .collect()
    }

    pub fn scale(&mut self, scale: f64) {
        self.values = self.scaled(scale);
    }

    /// Sets the first amplitude; the others follow in proportion.
    pub fn set(&mut self, value: f64) {
        let first = self.parameters.iter().position(|parameter| parameter.amplitude);
        if let Some(first) = first.filter(|&first| self.values[first] != 0.0) {
            self.scale(value / self.values[first]);
        }
    }

    /// The largest factor at which the amplitudes stay within the priors' supports and within reach.
    pub fn most(&self) -> f64 {
        let largest = |(parameter, value): (&EffectParameter, &f64)| {
            let (lower, upper) = parameter.prior.support();
            let end = if *value < 0.0 { -lower } else { upper };
            // A share short of the support's end, where some expressions have no value.
            (0.98 * end).min(REACH * parameter.plausible) / value.abs().max(f64::MIN_POSITIVE)
        };
        let pairs = self.parameters.iter().zip(&self.values).filter(|(parameter, _)| parameter.amplitude);
        pairs.map(largest).fold(f64::INFINITY, f64::min)
    }

    pub fn hidden(&self, problem: &Problem, alone: f64) -> HiddenEffect {
        let candidate = &problem.candidates[self.candidate];
        let value = |(parameter, value): (&EffectParameter, &f64)| {
            let name = parameter.name.clone();
            let unit = crate::expression::Unit::si(parameter.unit.dimension).text;
            HiddenValue { name, value: *value, unit, amplitude: parameter.amplitude }
        };
        HiddenEffect {
            id: candidate.id.clone(),
            effect: candidate.effect.clone(),
            place: candidate.place.clone(),
            input: candidate.input.clone(),
            parameters: self.parameters.iter().zip(&self.values).map(value).collect(),
            alone,
        }
    }
}

/// Whether a candidate can be hidden in the problem's test: something sees it.
fn is_seen(problem: &Problem, position: usize) -> bool {
    let candidate = &problem.candidates[position];
    let has =
        |transient: bool| problem.measurements.iter().any(|m| matches!(m.rows, Rows::Transient { .. }) == transient);
    (candidate.steady && has(false)) || (candidate.transient && has(true))
}

/// An effect first, then a place of it: each effect is as frequent as the others. With `laws_only` no unknown function is drawn.
pub(super) fn draw_effect(
    problem: &Problem,
    only: Option<&str>,
    laws_only: bool,
    chosen: &[Chosen],
    draw: &mut Draw,
) -> Result<Chosen, InjectError> {
    let odds = PriorOdds::new(problem);
    let fits = |position: &usize| {
        let candidate = &problem.candidates[*position];
        is_seen(problem, *position)
            && (only.is_some() || !odds.is_out_of_place(problem, *position))
            && !(laws_only && problem.catalogue.get(&candidate.effect).is_some_and(Effect::is_unknown_function))
            && only.is_none_or(|only| candidate.id == only || candidate.effect == only)
            && !chosen.iter().any(|other| problem.candidates[other.candidate].effect == candidate.effect)
    };
    let open: Vec<usize> = (0..problem.candidates.len()).filter(fits).collect();
    let mut names: Vec<&str> = open.iter().map(|&position| problem.candidates[position].effect.as_str()).collect();
    names.dedup();
    if names.is_empty() {
        return Err(InjectError::NoPlace);
    }
    let name = names[draw.position(names.len())];
    let places: Vec<usize> =
        open.iter().copied().filter(|&position| problem.candidates[position].effect == name).collect();
    let candidate = places[draw.position(places.len())];
    let bound = &problem.candidates[candidate].bound;
    let effect = problem.catalogue.get(name).ok_or(InjectError::NoPlace)?;
    let parameters = effect.parameters(&problem.model, bound);
    let values = (parameters.iter())
        .map(|parameter| {
            let (share, other) = (draw.share(), draw.share());
            if !parameter.amplitude {
                return parameter.prior.quantile(0.1 + 0.8 * share);
            }
            let size = parameter.plausible * (0.3 + 0.7 * share);
            let (lower, _) = parameter.prior.support();
            if lower >= 0.0 || other < 0.5 { size } else { -size }
        })
        .collect();
    Ok(Chosen { candidate, parameters, values })
}

/// Physics that the catalogue lacks, the phase of its swing, and the states of its switch by measurement and row.
pub(super) type OutsideDraw = (Outside, f64, Vec<Vec<f64>>);

pub(super) fn draw_outside(problem: &Problem, draw: &mut Draw) -> Result<OutsideDraw, InjectError> {
    let model = &problem.model;
    let nodes: Vec<&str> = (model.nodes.iter())
        .filter(|node| matches!(node.kind, NodeKind::Diffusion { .. }))
        .map(|node| node.name.as_str())
        .collect();
    if nodes.is_empty() {
        return Err(InjectError::NoPlace);
    }
    let node = nodes[draw.position(nodes.len())].to_owned();
    let kind = draw.position(3);
    let input = draw.position(model.inputs.len());
    let (share, phase) = (draw.share(), draw.between(0.0, core::f64::consts::TAU));
    let transients: Vec<&Measurement> =
        problem.measurements.iter().filter(|m| matches!(m.rows, Rows::Transient { .. })).collect();
    let span_s = transients.iter().filter_map(|measurement| match &measurement.rows {
        Rows::Transient { inputs, .. } => Some(inputs.times_s.last()? - inputs.times_s.first()?),
        Rows::Steady(_) => None,
    });
    let span_s = span_s.fold(0.0, f64::max);
    let outside = match kind {
        0 if !model.inputs.is_empty() => Outside::Root { node, input: model.inputs[input].name.clone() },
        1 if span_s > 0.0 => {
            // Three to fifteen swings within the test.
            let period_s = short(span_s / (3.0 + 12.0 * share));
            Outside::Swing { node, period_s }
        }
        _ => Outside::Unlogged { node },
    };
    let mut switch = Vec::new();
    for measurement in &problem.measurements {
        let hold = matches!(measurement.rows, Rows::Transient { .. });
        switch.push(if hold { toggled(measurement.len(), draw) } else { steady_states(measurement.len(), draw) });
    }
    Ok((outside, phase, switch))
}

/// On and off, for twenty rows on average.
fn toggled(rows: usize, draw: &mut Draw) -> Vec<f64> {
    let mut state = 0.0;
    let toggle = |_| {
        if draw.happens(0.05) {
            state = 1.0 - state;
        }
        state
    };
    (0..rows).map(toggle).collect()
}

/// On in two of five phases.
fn steady_states(phases: usize, draw: &mut Draw) -> Vec<f64> {
    (0..phases).map(|_| if draw.happens(0.4) { 1.0 } else { 0.0 }).collect()
}
