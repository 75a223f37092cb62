//! What was said of a case: the part of a diagnosis that is judged.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::diagnosis::output::{Amount, EffectResult, ModelResult};
use crate::diagnosis::{Output, Verdict};
use crate::expression::Unit;

/// A set of effects with its stated probability.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatedModel {
    /// Ids of its effects; none for the baseline model.
    pub effects: Vec<String>,
    /// The probability.
    pub probability: f64,
}

/// An amplitude with its interval, SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatedAmplitude {
    /// Id of the effect.
    pub id: String,
    /// Name of the parameter in the effect.
    pub parameter: String,
    /// Lower end of the interval that holds 95 %.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// What was said of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The verdict.
    pub verdict: Verdict,
    /// Ids of the effects that would be adopted.
    pub selected: Vec<String>,
    /// Effects that the data cannot tell apart, by group.
    pub groups: Vec<Vec<String>>,
    /// Ids of the first step's effect and of what else is likely there; none without steps.
    pub first_step: Vec<String>,
    /// Stated probability of each effect, by id.
    pub probabilities: Vec<(String, f64)>,
    /// Stated probabilities of sets of effects.
    pub models: Vec<StatedModel>,
    /// Stated probability that nothing is missing.
    pub nothing: f64,
    /// Stated probability that something outside the catalogue is missing.
    pub unexplained: f64,
    /// Intervals of the amplitudes.
    pub amplitudes: Vec<StatedAmplitude>,
}

/// The normal quantile of 97.5 %.
const TWO_SIDED_95: f64 = 1.959_963_984_540_054;

impl From<&Output> for Answer {
    fn from(output: &Output) -> Self {
        let mut groups: BTreeMap<u64, Vec<String>> = BTreeMap::new();
        for effect in &output.effects {
            if let Some(group) = effect.group {
                groups.entry(group).or_default().push(effect.id.clone());
            }
        }
        let stated =
            |model: &ModelResult| StatedModel { effects: model.effects.clone(), probability: model.probability };
        Self {
            verdict: output.verdict,
            selected: output.selected.clone(),
            groups: groups.into_values().collect(),
            first_step: (output.steps.iter().take(1))
                .flat_map(|step| step.effect.iter().chain(&step.alternatives).cloned())
                .collect(),
            probabilities: output.effects.iter().map(|effect| (effect.id.clone(), effect.probability)).collect(),
            models: output.models.iter().map(stated).collect(),
            nothing: output.probability_nothing,
            unexplained: output.probability_unexplained,
            amplitudes: output.effects.iter().flat_map(intervals).collect(),
        }
    }
}

/// Intervals of the amplitudes that no bound cuts off.
pub fn intervals(effect: &EffectResult) -> impl Iterator<Item = StatedAmplitude> {
    let free = effect.amplitudes.iter().filter(|(_, amount)| !amount.at_bound);
    free.map(|(parameter, amount)| StatedAmplitude {
        id: effect.id.clone(),
        parameter: parameter.clone(),
        lower: si(amount, amount.value - TWO_SIDED_95 * amount.sd),
        upper: si(amount, amount.value + TWO_SIDED_95 * amount.sd),
    })
}

/// A value in the unit of an amplitude, SI. The unit is one that a unit was written as, so that it is read.
fn si(amount: &Amount, value: f64) -> f64 {
    Unit::parse(&amount.unit).map_or(value, |unit| unit.to_si(value))
}

impl Answer {
    /// Effects of the group of one, it among them; itself alone where it is in none.
    pub fn group_of(&self, id: &str) -> Vec<&str> {
        match self.groups.iter().find(|group| group.iter().any(|member| member == id)) {
            Some(group) => group.iter().map(String::as_str).collect(),
            None => self.selected.iter().map(String::as_str).filter(|selected| *selected == id).collect(),
        }
    }

    /// The stated probability of a set of effects, 0 where it is not mentioned.
    pub fn probability_of(&self, effects: &[&str]) -> f64 {
        if effects.is_empty() {
            return self.nothing;
        }
        let mut wanted = effects.to_vec();
        wanted.sort_unstable();
        let same = |model: &&StatedModel| {
            let mut stated: Vec<&str> = model.effects.iter().map(String::as_str).collect();
            stated.sort_unstable();
            stated == wanted
        };
        self.models.iter().find(same).map_or(0.0, |model| model.probability)
    }
}
