//! A surrogate in the place of the model that it stands for: of each output it gives the mean, by what the error changes with the
//! number of each anchor, and the standard deviation of the rest of the error.

use std::sync::OnceLock;

use super::Surrogate;
use crate::inference::gaussian_process::emulator::Predicted;
use crate::thermal::external::SlopesAt;
use crate::thermal::{Evaluator, Fault, Point};

/// What answers in a model's place, once its surrogate is there.
#[derive(Debug, Default)]
pub struct Answers {
    /// Anchors of an output's error; those that a surrogate lacks have no part in it.
    anchors: usize,
    surrogate: OnceLock<Surrogate>,
}

impl Answers {
    /// Of a surrogate that is not there yet, with so many anchors of each output's error.
    pub fn with_anchors(anchors: usize) -> Self {
        Self { anchors, surrogate: OnceLock::new() }
    }

    /// Of a surrogate that is there.
    pub fn of(surrogate: Surrogate, anchors: usize) -> Self {
        Self { anchors, surrogate: OnceLock::from(surrogate) }
    }

    /// Takes the surrogate; one that is there already is the same, and stays.
    pub fn take(&self, surrogate: Surrogate) {
        self.surrogate.get_or_init(|| surrogate);
    }

    /// Whether the surrogate is there.
    pub fn is_ready(&self) -> bool {
        self.surrogate.get().is_some()
    }

    /// The surrogate, or that it is not there.
    fn surrogate(&self) -> Result<&Surrogate, Fault> {
        let fault = || Fault { what: "the surrogate was not asked", detail: "it has no result yet".to_owned() };
        self.surrogate.get().ok_or_else(fault)
    }

    /// The numbers of an output: mean, parts, rest.
    fn numbers<'f>(&self, predicted: &'f Predicted) -> impl Iterator<Item = f64> + 'f {
        let missing = self.anchors.saturating_sub(predicted.parts.len());
        let parts = predicted.parts.iter().copied().chain(std::iter::repeat_n(0.0, missing));
        std::iter::once(predicted.mean).chain(parts).chain(std::iter::once(predicted.rest))
    }

    fn slopes_at(&self, surrogate: &Surrogate, asked: &SlopesAt) -> Result<Vec<f64>, Fault> {
        let coordinates = surrogate.coordinates(&asked.point)?;
        let axes: Vec<Option<(usize, f64)>> =
            asked.by.iter().map(|&place| surrogate.space.slope(&asked.point, place)).collect();
        let mut slopes = Vec::new();
        for of_output in surrogate.slopes(&coordinates) {
            let mut row = |values: Option<&Vec<f64>>| {
                let by = |axis: &Option<(usize, f64)>| {
                    let (axis, scale) = (*axis)?;
                    Some(scale * values?.get(axis)?)
                };
                slopes.extend(axes.iter().map(|axis| by(axis).unwrap_or(0.0)));
            };
            row(of_output.as_ref().map(|own| &own.mean));
            for part in 0..self.anchors {
                row(of_output.as_ref().and_then(|own| own.parts.get(part)));
            }
            row(of_output.as_ref().map(|own| &own.rest));
        }
        let Some(weights) = &asked.weights else { return Ok(slopes) };
        let mut sum = vec![0.0; asked.by.len()];
        for (row, weight) in slopes.chunks_exact(asked.by.len().max(1)).zip(weights) {
            sum.iter_mut().zip(row).for_each(|(slot, slope)| *slot += weight * slope);
        }
        Ok(sum)
    }
}

impl Evaluator for Answers {
    fn ready(&self) -> Result<(), String> {
        match self.surrogate.get() {
            Some(_) => Ok(()),
            None => Err("the model's surrogate has no result yet: run the pass".to_owned()),
        }
    }

    fn evaluate(&self, points: &[Point]) -> Vec<Result<Vec<f64>, Fault>> {
        let surrogate = match self.surrogate() {
            Ok(surrogate) => surrogate,
            Err(fault) => return vec![Err(fault); points.len()],
        };
        // Neighbours that differ in what the surrogate does not see have one answer.
        let mut distinct: Vec<Vec<f64>> = Vec::new();
        let place = |point: &Point| {
            let coordinates = surrogate.coordinates(point)?;
            if distinct.last() != Some(&coordinates) {
                distinct.push(coordinates);
            }
            Ok(distinct.len() - 1)
        };
        let places: Vec<Result<usize, Fault>> = points.iter().map(place).collect();
        let predicted = surrogate.predicted(&distinct);
        let answer = |place: Result<usize, Fault>| {
            let place = place?;
            let own = predicted.iter().filter_map(|of_output| of_output.get(place));
            Ok(own.flat_map(|own| self.numbers(own)).collect())
        };
        places.into_iter().map(answer).collect()
    }

    fn slopes(&self, asked: &[SlopesAt]) -> Vec<Result<Vec<f64>, Fault>> {
        match self.surrogate() {
            Ok(surrogate) => asked.iter().map(|asked| self.slopes_at(surrogate, asked)).collect(),
            Err(fault) => vec![Err(fault); asked.len()],
        }
    }

    fn broken(&self) -> Option<String> {
        None
    }
}
