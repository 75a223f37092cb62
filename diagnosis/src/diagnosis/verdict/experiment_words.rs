//! A test that would part rivals, in words, and what it goes beyond.

use crate::diagnosis::Problem;
use crate::diagnosis::output::{DiscriminatingExperiment, DiscriminatingStep, OneThing, OnlyInTransients, Setting};
use crate::diagnosis::verdict::discriminating_experiment::is_worth_a_test;
use crate::diagnosis::verdict::numbers::{joined, rounded, short};
use crate::diagnosis::verdict::tested::{self, FAR_BEYOND_K, Tested};
use crate::document::time::unit_of_time;
use crate::document::{percent, upper};
use crate::expression::Unit;
use crate::expression::unit::CELSIUS_ZERO_K;
use crate::thermal::Model;

/// Probability from which a repeated phase tells more than guessing.
const LEAST_OF_REPEATED: f64 = 0.505;

impl OnlyInTransients {
    /// That no steady phase can part the sets, and the step that does, in sentences.
    pub fn in_words(&self, model: &Model) -> String {
        format!("{}.", upper(&self.clause(model)))
    }

    /// The same in short.
    pub fn in_brief(&self, model: &Model) -> String {
        let none = "No steady phase can tell what stores heat apart";
        let Some(step) = &self.step else { return format!("{none}.") };
        let (what, time, probability) = (step.in_words(model), time(step.duration_s), percent(step.probability));
        let guess = if is_worth_a_test(step.probability) { "" } else { ", guessing with 50 %" };
        format!("{none}; {what}, watched for {time}, would with probability {probability}{guess}.")
    }

    /// The same at length, to follow a semicolon.
    pub fn clause(&self, model: &Model) -> String {
        let none = format!(
            "no steady phase can tell {} apart: they differ in what stores heat, which shows while temperatures change",
            sets_apart(&self.between)
        );
        let Some(step) = &self.step else {
            return format!("{none}; a step of an input would, but none that can be set has a range");
        };
        let about = match (step.limits_ok, step.near_tested) {
            (false, _) => ", but red limits of a node are passed",
            (true, false) => ", but sensors would read far beyond all readings so far",
            (true, true) if step.ends_early => {
                ", and must end then: later limits are passed, or sensors read far beyond all readings so far"
            }
            (true, true) => "",
        };
        let beyond = if step.was_set { "" } else { ", farther than it was set so far" };
        let what = format!(
            "{}{beyond}, the other inputs as at the beginning of {}, watched for {} ({} time constants of {}, the slowest)",
            step.in_words(model),
            step.like,
            time(step.duration_s),
            rounded(step.duration_s / step.time_constant_s, 2),
            step.slowest,
        );
        let probability = percent(step.probability);
        match is_worth_a_test(step.probability) {
            true => format!("{none}; {what}, would with probability {probability}{about}"),
            false => format!(
                "{none}; no step within the stated ranges is worth a test by itself: the best, {what}, would with probability {probability}, guessing with 50 %{about}"
            ),
        }
    }
}

impl DiscriminatingStep {
    /// The step, as in `a step of P_heater from 0 to 10 W`.
    pub fn in_words(&self, model: &Model) -> String {
        let written = model.inputs.iter().find(|input| input.name == self.input).map(|input| input.unit.as_str());
        let unit = written.unwrap_or(self.from.unit.as_str());
        let parsed = Unit::parse(unit).ok();
        let shown =
            |setting: &Setting| rounded(parsed.as_ref().map_or(setting.value, |unit| unit.from_si(setting.value)), 3);
        let text = if unit == "1" { String::new() } else { format!(" {unit}") };
        format!("a step of {} from {} to {}{text}", self.input, shown(&self.from), shown(&self.to))
    }
}

/// A duration in the unit that suits it.
pub fn time(seconds: f64) -> String {
    let (length, unit) = unit_of_time(seconds);
    format!("{} {unit}", rounded(seconds / length, 2))
}

impl OneThing {
    /// That no phase parts the sets, in a sentence.
    pub fn in_words(&self) -> String {
        format!("{}.", upper(&self.clause()))
    }

    /// The same, to follow a semicolon.
    pub fn clause(&self) -> String {
        format!(
            "no steady phase within the stated ranges reliably tells {} apart: the best one does so with probability {}, {}guessing with 50 %",
            sets_apart(&self.sets),
            percent(self.probability),
            repeated(self.repeat_probability)
                .map_or_else(String::new, |p| format!("a repeated one with {}, ", percent(p)))
        )
    }
}

impl DiscriminatingExperiment {
    /// What the phase would tell, in a sentence.
    pub(super) fn in_words(&self) -> String {
        let (sets, probability) = (sets_apart(&self.between), percent(self.probability));
        if !is_worth_a_test(self.probability) {
            return format!(
                "No steady phase within the stated ranges is worth a test by itself: the best one would tell {sets} apart with probability {probability}, while guessing does so with 50 %."
            );
        }
        let again = repeated(self.repeat_probability);
        format!(
            "A steady phase at the conditions stated below would tell {sets} apart with probability {probability}{}.",
            again.map_or_else(String::new, |p| format!("; repeating the best old phase with {}", percent(p)))
        )
    }
}

/// The probability of a repeated phase, where it is more than guessing: there may be no steady phase at all.
pub fn repeated(probability: f64) -> Option<f64> {
    Some(probability).filter(|probability| *probability >= LEAST_OF_REPEATED)
}

/// The ids of a set. Each has a colon, which no name may have: a part without one belongs to a name with ` + ` in it.
fn ids_of(set: &str) -> Vec<String> {
    let mut ids: Vec<String> = Vec::new();
    for part in set.split(" + ") {
        match ids.last_mut() {
            Some(last) if !part.contains(':') => last.extend([" + ", part]),
            _ => ids.push(part.to_owned()),
        }
    }
    ids
}

/// The sets of a list, with what all of them have named once, where each has something else too.
pub fn sets_apart(sets: &[String]) -> String {
    let parts: Vec<Vec<String>> = sets.iter().map(|set| ids_of(set)).collect();
    let [first, others @ ..] = parts.as_slice() else { return String::new() };
    let common: Vec<String> = first.iter().filter(|id| others.iter().all(|set| set.contains(id))).cloned().collect();
    if common.is_empty() {
        return joined(sets);
    }
    let rest = |set: &Vec<String>| {
        let own: Vec<String> = set.iter().filter(|id| !common.contains(id)).cloned().collect();
        own.join(" + ")
    };
    let rests: Vec<String> = parts.iter().map(rest).collect();
    match rests.iter().any(String::is_empty) {
        true => joined(sets),
        false => format!("{} (each beside {})", joined(&rests), common.join(" + ")),
    }
}

/// That a proposed phase goes far beyond all readings so far.
pub(super) fn beyond_what_was_measured(experiment: &DiscriminatingExperiment, problem: &Problem) -> Option<String> {
    let tested = Tested::of(problem);
    let [low, high] = tested.temperatures_k?;
    let is_temperature = |name: &str| {
        let mut own = problem.measurements.iter().flat_map(|own| &own.sensors).filter(|sensor| sensor.name == name);
        own.any(|sensor| problem.model.quantities[sensor.quantity].is_temperature)
    };
    let predicted = experiment.predictions.iter().filter(|(sensor, _)| is_temperature(sensor));
    let predicted = predicted.flat_map(|(sensor, values)| values.iter().map(move |value| (sensor, *value)));
    let predicted = predicted.filter(|(_, value)| value.is_finite());
    let (sensor, value) = predicted.max_by(|a, b| tested.beyond_k(a.1).total_cmp(&tested.beyond_k(b.1)))?;
    (tested.beyond_k(value) > FAR_BEYOND_K).then(|| {
        format!(
            "There `{sensor}` would read {:.0} degC, while all readings so far lie between {:.0} and {:.0} degC: is the hardware made for that?",
            value - CELSIUS_ZERO_K,
            low - CELSIUS_ZERO_K,
            high - CELSIUS_ZERO_K
        )
    })
}

/// Inputs that the words on a proposed phase name.
const MOST_SETTINGS: usize = 4;

/// Share of the tested span by which a setting may lie outside it and count as tested.
const NEARLY_TESTED: f64 = 0.02;

/// That a proposed phase sets inputs to what no fitted data have: within the stated ranges, and perhaps beyond what the test can do.
pub fn beyond_what_was_set(experiment: &DiscriminatingExperiment, problem: &Problem) -> Option<String> {
    let mut outside: Vec<String> = Vec::new();
    for (index, input) in problem.model.inputs.iter().enumerate() {
        let Some(setting) = experiment.conditions.get(&input.name) else { continue };
        let Some([low, high]) = tested::input(problem, index) else { continue };
        let near = NEARLY_TESTED * (high - low).abs();
        if (low - near..=high + near).contains(&setting.value) {
            continue;
        }
        let unit = Unit::parse(&input.unit).ok();
        let shown = |si: f64| short(unit.as_ref().map_or(si, |unit| unit.from_si(si)), 3);
        let text = if input.unit == "1" { String::new() } else { format!(" {}", input.unit) };
        let so_far = if low == high { shown(low) } else { format!("{} to {}", shown(low), shown(high)) };
        outside.push(format!("`{}` at {}{text} (so far {so_far}{text})", input.name, shown(setting.value)));
    }
    let more = outside.len().saturating_sub(MOST_SETTINGS);
    outside.truncate(MOST_SETTINGS);
    if more > 0 {
        outside.push(format!("{more} more"));
    }
    (!outside.is_empty()).then(|| {
        format!(
            "It sets what these data do not have: {}. What the test cannot set is kept out by a narrower `range` of that input in the model.",
            outside.join(", ")
        )
    })
}
