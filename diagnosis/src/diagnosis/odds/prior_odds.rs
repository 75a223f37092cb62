//! Log odds of effects beforehand.
//!
//! Each kind of effect is missing with probability 0.05 if the study does not say otherwise, at any of its places in this
//! network alike, and so is physics that no kind describes: so the number of places is paid for. What is out of place, such
//! as convection in vacuum, is less probable, and so is what needs something rare, such as a wet surface. Heat that was logged beside a model that does not use it is more probable. A hidden node between two nodes that the model does not join is two things at
//! once, a path and a part. What changes at a date is the less probable the shorter the record is: hardware changes over weeks, not
//! within the minutes of a bench test.

use std::collections::BTreeMap;

use crate::diagnosis::Problem;
use crate::diagnosis::odds::logged_heat::{are_laws_of_logged_power, are_of_unused_heat, warms};
use crate::diagnosis::odds::medium::{is_pressure, is_temperature, is_vacuum};
use crate::effect::{Bound, Effect, Site};
use crate::math::functions::ln;
use crate::measurement::{Measurement, Rows};
use crate::thermal::element::Element;
use crate::thermal::{Clock, Input};

/// Probability beforehand that a kind of effect is missing: a convention. It makes an effect of one place pay a log odds of
/// 2.9, and a study may say another ([`Problem::missing_probability`]).
const MISSING: f64 = 0.05;
/// Log odds by which an unknown function stands behind an effect that has a name.
pub(crate) const CURVE_COST: f64 = 3.0;
/// Log odds by which an effect stands behind others where its physics is out of place: a twentieth, not nothing, as the
/// model may say too little of where it is.
const OUT_OF_PLACE: f64 = 3.0;
/// Log odds by which heat in proportion to a logged power or irradiance stands before heat in proportion to another input, where the
/// model uses that power or irradiance nowhere: it was logged for a reason. A convention.
const LOGGED_HEAT: f64 = 1.5;
/// Log odds by which a path that follows a logged power, irradiance, electric current or frequency of electronics stands behind one
/// that follows anything else: these warm, and a path follows a flow, a speed, a pressure or a temperature. It may be that of a fan, so
/// that the odds are not those of what is out of place. A convention.
const PATH_BY_HEAT: f64 = 1.5;
/// Log odds by which a logged power that follows the temperature of what it heats stands behind other effects: a meter has read it at
/// that temperature. What was logged may be a command or a rating, so that the odds are not those of what is out of place. A convention.
const LAW_OF_LOGGED_POWER: f64 = 1.5;

/// Time in which a change at a date is as probable as another kind of effect, s: a day. A convention.
const CHANGES_WITHIN_S: f64 = 86_400.0;
/// Least share of that probability, in whatever short record.
const LEAST_CHANGES: f64 = 0.01;

/// Log prior odds, against "nothing", of one instance of each kind of effect.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorOdds {
    kinds: BTreeMap<String, f64>,
    vacuum: bool,
    /// Of each candidate whether it is heat in proportion to a logged power or irradiance that the model does not use.
    are_of_unused_heat: Vec<bool>,
    /// Of each candidate whether it lets a logged power follow temperature.
    are_laws_of_logged_power: Vec<bool>,
}

impl PriorOdds {
    /// Counts the places of each kind.
    pub fn new(problem: &Problem) -> Self {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for candidate in problem.candidates.iter() {
            *counts.entry(candidate.effect.clone()).or_default() += 1;
        }
        let changes = log_share_of_changes(&problem.measurements);
        let odds = |effect: &str, count: usize| {
            let is = |of: fn(&Effect) -> bool| problem.catalogue.get(effect).is_some_and(of);
            let behind = if is(Effect::is_unknown_function) { CURVE_COST } else { 0.0 };
            let behind = if is(|own| own.depends_on(Clock::Date)) { behind - changes } else { behind };
            // A study that says how probable a kind is has thought of where it is rare.
            let said = problem.missing_probability.get(effect).copied();
            let behind = if said.is_none() && is(Effect::is_rare) { behind + OUT_OF_PLACE } else { behind };
            let missing = said.unwrap_or(MISSING);
            ln(missing / (1.0 - missing)) - ln(count.max(1) as f64) - behind
        };
        let kinds = counts.into_iter().map(|(effect, count)| (effect.clone(), odds(&effect, count))).collect();
        let (are_of_unused_heat, are_laws_of_logged_power) =
            (are_of_unused_heat(problem), are_laws_of_logged_power(problem));
        Self { kinds, vacuum: is_vacuum(problem), are_of_unused_heat, are_laws_of_logged_power }
    }

    /// Whether a candidate's physics is out of place: it needs a gas in vacuum, or something that any input may stand for
    /// is a pressure (heat moves through a gas between two temperatures; no pressure is a source of it), or of heat a
    /// temperature (heat goes with the difference of two, which a path is; with one alone it is nearly constant).
    pub fn is_out_of_place(&self, problem: &Problem, candidate: usize) -> bool {
        let candidate = &problem.candidates[candidate];
        let Some(effect) = problem.catalogue.get(&candidate.effect) else { return false };
        let is_heat = effect.form.adds.value.load.is_some() || effect.form.adds.value.curve.is_some();
        let is_no_cause = |input: &Input| is_pressure(input) || is_heat && is_temperature(input);
        let mut bound = effect.form.inputs.iter().zip(&candidate.bound);
        self.vacuum && effect.needs_gas()
            || bound.any(|(form, bound)| {
                form.value.unit.is_none()
                    && matches!(bound, Bound::Input(input) if is_no_cause(&problem.model.inputs[*input]))
            })
    }

    /// Of a set of candidates.
    pub fn of(&self, problem: &Problem, effects: &[usize]) -> f64 {
        let one = |&effect: &usize| {
            let odds = self.kinds.get(&problem.candidates[effect].effect)?;
            let place = if self.is_out_of_place(problem, effect) { OUT_OF_PLACE } else { 0.0 };
            let second = if is_path_and_part(problem, effect) { ln(MISSING / (1.0 - MISSING)) } else { 0.0 };
            let logged = if self.are_of_unused_heat.get(effect) == Some(&true) { LOGGED_HEAT } else { 0.0 };
            let by_heat = if is_path_by_heat(problem, effect) { PATH_BY_HEAT } else { 0.0 };
            let law = if self.are_laws_of_logged_power.get(effect) == Some(&true) { LAW_OF_LOGGED_POWER } else { 0.0 };
            Some(odds + second + logged - place - by_heat - law)
        };
        effects.iter().filter_map(one).sum()
    }

    /// Of "something else".
    pub fn unexplained() -> f64 {
        ln(MISSING / (1.0 - MISSING))
    }
}

/// Logarithm of the share of the probability of a change at a date that the measured time leaves; 0 where phases are steady, which
/// take hours each.
pub fn log_share_of_changes(measurements: &[Measurement]) -> f64 {
    let mut measured_s = 0.0;
    for measurement in measurements {
        let Rows::Transient { inputs, .. } = &measurement.rows else { return 0.0 };
        let times = &inputs.times_s;
        measured_s += times.first().zip(times.last()).map_or(0.0, |(first, last)| last - first);
    }
    ln((measured_s / CHANGES_WITHIN_S).clamp(LEAST_CHANGES, 1.0))
}

/// Whether an effect makes paths between nodes follow nothing but powers, irradiances, electric currents and frequencies of
/// electronics. An effect that states the unit of its input, such as that of a switch that is driven by a current, means it.
fn is_path_by_heat(problem: &Problem, effect: usize) -> bool {
    let candidate = &problem.candidates[effect];
    let (Site::Elements(elements), Some(own)) = (&candidate.site, problem.catalogue.get(&candidate.effect)) else {
        return false;
    };
    let is_path =
        |&place: &usize| problem.model.elements.get(place).is_some_and(|own| own.physics().between().is_some());
    let warms = |bound: &Bound| matches!(bound, Bound::Input(input) if warms(&problem.model.inputs[*input]));
    let mut inputs = own.form.inputs.iter().zip(&candidate.bound);
    !candidate.bound.is_empty()
        && elements.iter().all(is_path)
        && inputs.all(|(form, bound)| form.value.unit.is_none() && warms(bound))
}

/// Whether an effect is a hidden node between two nodes that nothing in the baseline model joins.
fn is_path_and_part(problem: &Problem, effect: usize) -> bool {
    let candidate = &problem.candidates[effect];
    let Site::Pair([a, b]) = candidate.site else { return false };
    let has_node = problem.catalogue.get(&candidate.effect).is_some_and(|own| own.form.adds.value.node.is_some());
    let joins =
        |element: &Element| element.physics().between().is_some_and(|between| between == [a, b] || between == [b, a]);
    has_node && !problem.model.elements.iter().any(joins)
}
