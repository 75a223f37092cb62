//! What a diagnosis found, as those read it who act upon it: the part of the document of `diagnose --json` that says
//! which effects are supported, how well, and what they are confused with. Fields that are not needed are skipped, so
//! that a diagnosis may say more.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;

use super::JobError;
use crate::diagnosis::Verdict;
use crate::diagnosis::output::OneThing;
use crate::inference::measurement::Doubt;

/// A diagnosis.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Findings {
    /// What is said of the model.
    pub verdict: Verdict,
    /// Effects at places, best first.
    #[serde(default)]
    pub effects: Vec<Finding>,
    /// Ids of the set that the diagnosis would adopt.
    #[serde(default)]
    pub selected: Vec<String>,
    /// Sets of effects with their odds, best first.
    #[serde(default)]
    pub models: Vec<Odds>,
    /// What is doubtful about the data.
    #[serde(default)]
    pub doubts: Vec<Doubt>,
    /// Effects that the data cannot see.
    #[serde(default)]
    pub unseen: Vec<Unseen>,
    /// The experiment that would tell rivals apart.
    #[serde(default)]
    pub separating_experiment: Option<Experiment>,
    /// Rivals that no settable phase tells apart.
    #[serde(default)]
    pub one_thing: Option<OneThing>,
}

/// A set of effects and its odds.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Odds {
    /// Ids; none for the model as it is believed.
    pub effects: Vec<String>,
    /// Probability.
    pub probability: Option<f64>,
}

/// An effect at a place.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Finding {
    /// Such as `conductive-path:baseplate:board`.
    pub id: String,
    /// Name of the effect.
    pub effect: String,
    /// Names of the place.
    #[serde(rename = "where")]
    pub place: Vec<String>,
    /// Kind of the place.
    pub where_kind: String,
    /// What the effect's inputs stand for; several joined by `*`.
    #[serde(default)]
    pub input: Option<String>,
    /// Probability that it is there.
    #[serde(default)]
    pub probability: Option<f64>,
    /// Natural logarithm of the Bayes factor for it.
    #[serde(default)]
    pub log_bayes_factor: Option<f64>,
    /// Number of the group of effects that these data cannot tell apart.
    #[serde(default)]
    pub group: Option<i64>,
    /// Amplitudes by name.
    #[serde(default)]
    pub amplitudes: BTreeMap<String, Amplitude>,
    /// How many times as wide as the catalogue's the priors of its amplitudes had to be.
    #[serde(default)]
    pub prior_width: Option<f64>,
    /// RMSE before and after, K.
    #[serde(default)]
    pub rmse_k: Rmse,
}

/// An amplitude as fitted.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Amplitude {
    /// Value.
    pub value: Option<f64>,
    /// Standard deviation.
    #[serde(default)]
    pub sd: Option<f64>,
    /// Value of the fit.
    #[serde(default)]
    pub most_probable: Option<f64>,
    /// Unit of all.
    pub unit: String,
}

/// Root mean square of measured minus predicted, before and after, K.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Rmse {
    /// Of the readings for fitting.
    #[serde(default)]
    pub train: Option<[Option<f64>; 2]>,
    /// Of the readings held out.
    #[serde(default)]
    pub held_out: Option<[Option<f64>; 2]>,
}

/// An effect that the data cannot see.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Unseen {
    /// Its id.
    pub id: String,
    /// Why.
    #[serde(default)]
    pub why: String,
}

/// Conditions that would tell rivals apart.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Experiment {
    /// Ids of the rivals.
    #[serde(default)]
    pub between: Vec<String>,
    /// Inputs to set.
    #[serde(default)]
    pub conditions: BTreeMap<String, Condition>,
    /// Probability of telling them apart.
    #[serde(default)]
    pub probability: Option<f64>,
    /// The same of repeating a phase that was measured already.
    #[serde(default)]
    pub repeat_probability: Option<f64>,
}

/// A value of an input.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Condition {
    /// Value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

impl Findings {
    /// From the result of the diagnosis of this name.
    ///
    /// # Errors
    /// A result that does not have this form.
    pub fn from_result(job: &str, result: &Value) -> Result<Self, JobError> {
        Self::deserialize(result)
            .map_err(|error| JobError::Failed(format!("the result of `{job}` is no diagnosis: {error}")))
    }

    /// An effect by its id.
    pub fn find(&self, id: &str) -> Option<&Finding> {
        self.effects.iter().find(|effect| effect.id == id)
    }

    /// The effects that the diagnosis would adopt; where it names none of several that explain the data alike, the best.
    fn leading(&self) -> Vec<&Finding> {
        if self.selected.is_empty() && self.verdict == Verdict::Ambiguous {
            return self.effects.iter().find(|effect| effect.group.is_some()).into_iter().collect();
        }
        self.selected.iter().filter_map(|id| self.find(id)).collect()
    }

    /// Probability of exactly these effects; that of a single one where its set was not weighed alone.
    pub fn odds(&self, chosen: &[&Finding]) -> Option<f64> {
        let is_own = |odds: &&Odds| {
            odds.effects.len() == chosen.len() && chosen.iter().all(|finding| odds.effects.contains(&finding.id))
        };
        let known = self.models.iter().find(is_own).and_then(|odds| odds.probability);
        known.or(if let [one] = chosen { one.probability } else { None })
    }

    /// What else the data allow in place of these effects, best first, each with its probability: what shares a group with
    /// one of them, or, where nothing does, other sets.
    pub fn rivals(&self, chosen: &[&Finding]) -> Vec<(String, Option<f64>)> {
        const LEAST: f64 = 0.01;
        let is_chosen = |id: &str| chosen.iter().any(|finding| finding.id == id);
        let mut rivals: Vec<(String, Option<f64>)> = Vec::new();
        for rival in chosen.iter().flat_map(|finding| self.confused_with(finding)).filter(|own| !is_chosen(&own.id)) {
            if !rivals.iter().any(|(id, _)| *id == rival.id) {
                rivals.push((rival.id.clone(), rival.probability));
            }
        }
        if rivals.is_empty() {
            let is_own =
                |odds: &Odds| odds.effects.len() == chosen.len() && odds.effects.iter().all(|id| is_chosen(id));
            let others = self.models.iter().filter(|odds| !odds.effects.is_empty() && !is_own(odds));
            let likely = others.filter(|odds| odds.probability.is_some_and(|probability| probability >= LEAST));
            rivals.extend(likely.map(|odds| (odds.effects.join(" + "), odds.probability)));
        }
        rivals
    }

    /// Whether the diagnosis supports an effect: it is selected, or these data cannot tell it from one that is.
    pub fn supports(&self, effect: &Finding) -> bool {
        let alike = |other: &&Finding| other.id == effect.id || (effect.group.is_some() && other.group == effect.group);
        self.leading().iter().any(alike)
    }

    /// All effects that these data cannot tell from this one, itself left out, best first. Members of the selected set
    /// stand beside it, not in its place.
    pub fn confused_with<'f>(&'f self, effect: &'f Finding) -> impl Iterator<Item = &'f Finding> {
        let is_selected = |id: &String| self.selected.contains(id);
        let together = is_selected(&effect.id);
        self.effects.iter().filter(move |other| {
            let rival = other.id != effect.id && other.group.is_some() && other.group == effect.group;
            rival && !(together && is_selected(&other.id))
        })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_diagnosis_may_say_more_and_must_say_enough() {
        let said = json!({"verdict": "ambiguous", "probability_nothing": 1e-9, "misfit": {"reduced_chi2": 3.0},
            "effects": [
                {"id": "a:x", "effect": "a", "where": ["x"], "where_kind": "node", "input": null, "group": 1,
                 "amplitudes": {"power": {"value": 0.5, "sd": 0.1, "unit": "W"}}, "rmse_k": {"train": [0.7, 0.3], "held_out": null}},
                {"id": "b:x", "effect": "b", "where": ["x"], "where_kind": "node", "group": 1},
                {"id": "c:x", "effect": "c", "where": ["x"], "where_kind": "node", "group": 2},
                {"id": "d:x", "effect": "d", "where": ["x"], "where_kind": "node", "group": null}],
            "selected": ["a:x"], "unseen": [{"id": "e:x", "why": "steady data see no capacity"}]});
        let found = Findings::from_result("missing", &said).unwrap();
        let supported: Vec<bool> = found.effects.iter().map(|effect| found.supports(effect)).collect();
        assert_eq!(supported, [true, true, false, false]);
        let confused: Vec<&str> = found.confused_with(&found.effects[0]).map(|other| other.id.as_str()).collect();
        assert_eq!(confused, ["b:x"]);
        assert_eq!(found.effects[0].rmse_k.train, Some([Some(0.7), Some(0.3)]));
        let error = Findings::from_result("missing", &json!({"effects": []})).unwrap_err().to_string();
        assert!(error.starts_with("the result of `missing` is no diagnosis: missing field `verdict`"), "{error}");
    }
}
