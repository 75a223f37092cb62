//! What was said of a case: the part of a diagnosis that is judged.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::diagnosis::Verdict;
use crate::expression::Unit;

/// A set of effects with its stated probability.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatedModel {
    /// Ids of its effects; none for the believed model.
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

impl Answer {
    /// Reads the document that `diagnose --json` prints; `None` where it has no verdict.
    pub fn of_document(document: &Value) -> Option<Self> {
        let verdict = serde_json::from_value(document.get("verdict")?.clone()).ok()?;
        let list = |name: &str| document.get(name).and_then(Value::as_array).cloned().unwrap_or_default();
        let number = |name: &str| document.get(name).and_then(Value::as_f64).unwrap_or(0.0);
        let effects = list("effects");
        let id = |effect: &Value| effect.get("id").and_then(Value::as_str).unwrap_or_default().to_owned();
        let mut groups: Vec<(u64, Vec<String>)> = Vec::new();
        for effect in &effects {
            let Some(group) = effect.get("group").and_then(Value::as_u64) else { continue };
            match groups.iter_mut().find(|(own, _)| *own == group) {
                Some((_, members)) => members.push(id(effect)),
                None => groups.push((group, vec![id(effect)])),
            }
        }
        let probability = |value: &Value| value.get("probability").and_then(Value::as_f64).unwrap_or(0.0);
        let stated =
            |model: &Value| StatedModel { effects: strings(model.get("effects")), probability: probability(model) };
        Some(Self {
            verdict,
            selected: strings(document.get("selected")),
            groups: groups.into_iter().map(|(_, members)| members).collect(),
            probabilities: effects.iter().map(|effect| (id(effect), probability(effect))).collect(),
            models: list("models").iter().map(stated).collect(),
            nothing: number("probability_nothing"),
            unexplained: number("probability_unexplained"),
            amplitudes: effects.iter().flat_map(|effect| amplitudes(&id(effect), effect)).collect(),
        })
    }

    /// Effects of the group of one, it among them; itself alone where it is in none.
    pub fn group_of(&self, id: &str) -> Vec<&str> {
        match self.groups.iter().find(|group| group.iter().any(|member| member == id)) {
            Some(group) => group.iter().map(String::as_str).collect(),
            None => self.selected.iter().map(String::as_str).filter(|own| *own == id).collect(),
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
            let mut own: Vec<&str> = model.effects.iter().map(String::as_str).collect();
            own.sort_unstable();
            own == wanted
        };
        self.models.iter().find(same).map_or(0.0, |model| model.probability)
    }
}

fn strings(value: Option<&Value>) -> Vec<String> {
    let items = value.and_then(Value::as_array).into_iter().flatten();
    items.filter_map(Value::as_str).map(str::to_owned).collect()
}

/// Intervals of an effect that no bound cuts off: `lower` and `upper` where they are stated, else the normal ones of `value` and `sd`.
fn amplitudes(id: &str, effect: &Value) -> Vec<StatedAmplitude> {
    let entries = effect.get("amplitudes").and_then(Value::as_object);
    let mut found = Vec::new();
    for (parameter, body) in entries.into_iter().flatten() {
        if body.get("at_bound").and_then(Value::as_bool) == Some(true) {
            continue;
        }
        let number = |name: &str| body.get(name).and_then(Value::as_f64);
        let unit = body.get("unit").and_then(Value::as_str).and_then(|unit| Unit::parse(unit).ok());
        let si = |value: f64| unit.as_ref().map_or(value, |unit| unit.to_si(value));
        let ends = match (number("lower"), number("upper"), number("value"), number("sd")) {
            (Some(lower), Some(upper), ..) => Some((lower, upper)),
            (_, _, Some(value), Some(sd)) => Some((value - TWO_SIDED_95 * sd, value + TWO_SIDED_95 * sd)),
            _ => None,
        };
        if let Some((lower, upper)) = ends {
            let (id, parameter) = (id.to_owned(), parameter.clone());
            found.push(StatedAmplitude { id, parameter, lower: si(lower), upper: si(upper) });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_printed_document_is_read() {
        let document = serde_json::json!({
            "verdict": "ambiguous", "probability_nothing": 0.001, "probability_unexplained": 0.02,
            "effects": [
                {"id": "a:x", "probability": 0.6, "group": 1,
                 "amplitudes": {"conductance": {"value": 50.0, "sd": 2.0, "unit": "mW/K"}}},
                {"id": "b:x", "probability": 0.35, "group": 1, "amplitudes": {}},
                {"id": "c:y", "probability": 0.01, "group": 2, "amplitudes": {}}],
            "models": [{"effects": ["a:x"], "log_evidence": -3.0, "probability": 0.6}],
            "selected": ["a:x"]});
        let answer = Answer::of_document(&document).expect("a verdict");
        assert_eq!(answer.verdict, Verdict::Ambiguous);
        assert_eq!(answer.group_of("b:x"), ["a:x", "b:x"]);
        assert_eq!(answer.probability_of(&["a:x"]), 0.6);
        assert_eq!((answer.probability_of(&[]), answer.probability_of(&["b:x"])), (0.001, 0.0));
        let interval = &answer.amplitudes[0];
        assert!((interval.lower - 0.04608).abs() < 1e-5 && (interval.upper - 0.05392).abs() < 1e-5, "{interval:?}");
        assert_eq!(Answer::of_document(&serde_json::json!({"verdict": "perhaps"})), None);
    }
}
