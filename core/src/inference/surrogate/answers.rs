//! A surrogate in the place of the model that it stands for: it gives each output's mean, and behind all means the standard
//! deviation of each output's error.

use std::sync::OnceLock;

use super::{Expected, Surrogate};
use crate::thermal::{Evaluator, Fault, Point};

/// What answers in a model's place, once its surrogate is there.
#[derive(Debug, Default)]
pub struct Answers(OnceLock<Surrogate>);

impl Answers {
    /// Of a surrogate that is there.
    pub fn of(surrogate: Surrogate) -> Self {
        Self(OnceLock::from(surrogate))
    }

    /// Takes the surrogate; one that is there already is the same, and stays.
    pub fn take(&self, surrogate: Surrogate) {
        self.0.get_or_init(|| surrogate);
    }

    /// Whether the surrogate is there.
    pub fn is_ready(&self) -> bool {
        self.0.get().is_some()
    }
}

impl Evaluator for Answers {
    fn ready(&self) -> Result<(), String> {
        match self.0.get() {
            Some(_) => Ok(()),
            None => Err("the model's surrogate has no result yet: run the pass".to_owned()),
        }
    }

    fn evaluate(&self, points: &[Point]) -> Vec<Result<Vec<f64>, Fault>> {
        let Some(surrogate) = self.0.get() else {
            let fault = Fault { what: "the surrogate was not asked", detail: "it has no result yet".to_owned() };
            return vec![Err(fault); points.len()];
        };
        // Neighbours that differ in what the surrogate does not see have one answer.
        let mut last: Option<(Vec<f64>, Vec<f64>)> = None;
        let answer = |point: &Point| {
            let coordinates = surrogate.coordinates(point)?;
            if let Some((_, outputs)) = last.as_ref().filter(|(at, _)| *at == coordinates) {
                return Ok(outputs.clone());
            }
            let expected: Vec<Expected> = surrogate.at(&coordinates);
            let outputs: Vec<f64> =
                expected.iter().map(|own| own.mean).chain(expected.iter().map(|own| own.sd)).collect();
            last = Some((coordinates, outputs.clone()));
            Ok(outputs)
        };
        points.iter().map(answer).collect()
    }

    fn broken(&self) -> Option<String> {
        None
    }
}
