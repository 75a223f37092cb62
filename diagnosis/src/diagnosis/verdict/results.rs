//! What is written out of the fits: effects, sets, errors and noise.

use crate::diagnosis::engine::{Diagnosis, SensorNoise, State};
use crate::diagnosis::fits::effect_heat_flow::effect_heat_flow;
use crate::diagnosis::fits::refit::{Amplitude, Begin};
use crate::diagnosis::hypothesis::InferredStart;
use crate::diagnosis::odds::narrow_prior::{SEPARATE, TITLE};
use crate::diagnosis::odds::posterior_odds::{LEAST_RIVAL, MOST_RIVALS};
use crate::diagnosis::output::{
    Amount, Detectable, EffectHeat, EffectResult, Level, Misfit, ModelResult, NoiseResult, Rmse, RmseChange,
    StartResult, StoryStep, Test, Unseen,
};
use crate::diagnosis::problem::{FittedReading, is_idle};
use crate::diagnosis::story::step::Step;
use crate::diagnosis::verdict::effect_words;
use crate::diagnosis::verdict::findings::Findings;
use crate::diagnosis::verdict::hints::hints;
use crate::diagnosis::verdict::surroundings;
use crate::diagnosis::{Problem, Refit};
use crate::effect::form::ParameterForm;
use crate::effect::{Bound, Candidate, Like};
use crate::expression::Unit;
use crate::math::functions::exp;
use crate::math::sort::sort_by;
use crate::math::sum::log_sum_exp;
use crate::measurement::unknown::start_name;
use crate::measurement::{Rows, sensor_places, total_sd};
use crate::random::Distribution;
use std::collections::BTreeMap;

use rayon::prelude::*;

/// Sets and effects that are written out.
const MOST_WRITTEN: usize = 60;
/// Probability of an effect below which the heat that it would carry is not stated.
const LEAST_STATED: f64 = 1e-3;
/// Length of the change of all predictions, in standard deviations of the noise, below which an effect changes nothing.
const MOVES_NOTHING: f64 = 0.01;

/// Parameters of an effect as a result states them.
fn amounts(amplitudes: &[Amplitude]) -> BTreeMap<String, Amount> {
    let one = |amplitude: &Amplitude| {
        let at_bound = amplitude.at_bound;
        let (value, sd) = if at_bound { (amplitude.mode, 0.0) } else { (amplitude.mean, amplitude.sd) };
        let amount =
            Amount { value, sd, most_probable: amplitude.mode, unit: amplitude.unit.clone(), at_bound, level: None };
        (amplitude.name.clone(), amount)
    };
    amplitudes.iter().map(one).collect()
}

/// Parameters of an effect at a place as a result states them, each with what it is a value of.
pub(super) fn parameters(
    problem: &Problem,
    candidate: &Candidate,
    amplitudes: &[Amplitude],
) -> BTreeMap<String, Amount> {
    let mut amounts = amounts(amplitudes);
    let Some(file) = problem.catalogue.get(&candidate.effect) else { return amounts };
    let level = |form: &ParameterForm| match file.like(form)? {
        Like::OwnTemperature => Some(Level { of: candidate.place.join(", "), is_temperature: true }),
        Like::Input(position) => {
            let bound = *candidate.bound.get(position).filter(|bound| !bound.is_clock(&problem.model))?;
            let is_temperature = match bound {
                Bound::Node(_) => true,
                Bound::Input(index) => {
                    Unit::parse(&problem.model.inputs[index].unit).is_ok_and(|unit| unit.has_offset())
                }
            };
            Some(Level { of: bound.name(&problem.model).to_owned(), is_temperature })
        }
    };
    for (name, amount) in &mut amounts {
        amount.level = file.form.parameters.get(name).and_then(|form| level(&form.value));
    }
    amounts
}

/// The smallest and the largest heat into the node to which an effect gives most, W.
pub(super) fn watts(carries: &[EffectHeat]) -> Option<[f64; 2]> {
    let node = &carries.first()?.node;
    let into = carries.iter().filter(|one| one.node == *node).map(|one| one.watts);
    into.fold(None, |range: Option<[f64; 2]>, watts| {
        let [least, most] = range.unwrap_or([watts; 2]);
        Some([least.min(watts), most.max(watts)])
    })
}

impl Findings<'_> {
    /// The steps of the story to the selected set.
    pub(super) fn steps_of_story(&self) -> Vec<StoryStep> {
        let Some(story) = &self.story else { return Vec::new() };
        let refits = &self.state.refits;
        let result = |(step, &earlier): (&Step, &usize)| {
            let place = step.chosen.unwrap_or(step.before);
            let (before, after) = (&refits[step.before], &refits[place]);
            let added = step.additions.iter().find(|one| step.chosen == Some(one.place));
            let others = step.additions.iter().filter(|one| step.chosen != Some(one.place));
            let likely = others.filter(|one| one.probability >= LEAST_RIVAL).take(MOST_RIVALS);
            let group = self.groups.iter().find(|group| added.is_some_and(|one| group[0] == one.effect));
            let mut alternatives: Vec<usize> = likely.map(|one| one.effect).collect();
            let others = group.iter().flat_map(|group| &group[1..]);
            let others: Vec<usize> = others.copied().filter(|effect| !alternatives.contains(effect)).collect();
            alternatives.extend(others);
            StoryStep {
                effect: added.map(|one| self.id(one.effect).to_owned()),
                probability: added.map_or(step.stays, |one| self.probability_at_step(one)),
                rmse_k: RmseChange {
                    train: [before.rmse_train_k, after.rmse_train_k],
                    held_out: [before.rmse_held_out_k, after.rmse_held_out_k],
                },
                beside_later: step.before != earlier,
                alternatives: alternatives.into_iter().map(|effect| self.id(effect).to_owned()).collect(),
                open: story.is_open && step.chosen.is_none(),
            }
        };
        story.steps.iter().zip(&story.sets).map(result).collect()
    }
}

impl Diagnosis {
    /// The selected effects in their order, then all others that were fitted by probability.
    pub(super) fn effects(&self, findings: &Findings<'_>) -> Vec<EffectResult> {
        let state = findings.state;
        let mut seen: Vec<usize> = state.refits.iter().flat_map(|refit| refit.effects.iter().copied()).collect();
        seen.sort_unstable();
        seen.dedup();
        let mut ranked: Vec<(f64, f64, usize)> = seen
            .into_iter()
            .map(|effect| {
                let alone = state.refits.iter().find(|refit| refit.effects == [effect]);
                (findings.probability(effect), alone.map_or(f64::NEG_INFINITY, |refit| refit.log_evidence), effect)
            })
            .collect();
        // What is selected in its order, then what else is probable.
        let steps = findings.in_order();
        let step = |effect: usize| steps.iter().position(|&one| one == effect).unwrap_or(steps.len());
        sort_by(&mut ranked, |a, b| {
            step(a.2).cmp(&step(b.2)).then(b.0.total_cmp(&a.0)).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2))
        });
        ranked.truncate(MOST_WRITTEN);
        // Those that are grouped are fitted again.
        let mut results: Vec<EffectResult> =
            ranked.par_iter().map(|&(probability, _, effect)| self.effect(findings, effect, probability)).collect();
        for law in self.laws(findings, &results) {
            let is_curve =
                |result: &EffectResult| law.confused_with.contains(&result.effect) && result.group == law.group;
            let curve = results.iter().position(is_curve).map_or(results.len(), |position| position + 1);
            results.insert(curve, law);
        }
        for result in &mut results {
            result.since = effect_words::since(result, findings.problem);
        }
        results
    }

    fn effect(&self, findings: &Findings<'_>, effect: usize, probability: f64) -> EffectResult {
        let (problem, state) = (findings.problem, findings.state);
        let candidate = &problem.candidates[effect];
        let file = problem.catalogue.get(&candidate.effect);
        let sensors = sensor_places(problem.measurements.iter());
        // Its best set: the selected one where it belongs to it, else the most probable.
        let with = |place: &usize| state.refits[*place].effects.contains(&effect);
        let better = |a: usize, b: usize| if findings.weights.sets[b] > findings.weights.sets[a] { b } else { a };
        let own = Some(findings.selected).filter(with).or_else(|| (0..state.refits.len()).filter(with).reduce(better));
        let own = own.unwrap_or(0);
        let step = findings.step_of(effect);
        let after = step.map_or(own, |(_, place)| place);
        let refit = &state.refits[after];
        let rest: Vec<usize> = refit.effects.iter().copied().filter(|&other| other != effect).collect();
        let without = || state.refits.iter().position(|other| other.effects == rest);
        let without = step.map(|(before, _)| before).or_else(without).unwrap_or(0);
        let before = &state.refits[without];
        let log_bayes_factor = findings.log_bayes_factor(without, after);
        let position = refit.effects.iter().position(|&other| other == effect);
        let amplitudes =
            position.map(|position| parameters(problem, candidate, &refit.amplitudes[position])).unwrap_or_default();
        // What leads a group is no rival in another one.
        let groups = &findings.groups;
        let led = groups.iter().position(|group| group[0] == effect);
        let group =
            led.or_else(|| groups.iter().position(|group| group.contains(&effect))).map(|group| group as u64 + 1);
        let scales = group.and_then(|_| self.at_scales(findings, refit, log_bayes_factor));
        let is_stated = probability >= LEAST_STATED || group.is_some();
        let carries = if is_stated { effect_heat_flow(problem, refit, effect) } else { Vec::new() };
        let watts = watts(&carries);
        let mut hints = if is_stated { hints(problem, refit, effect) } else { Vec::new() };
        hints.extend(surroundings::hint(problem, candidate, &amplitudes).filter(|_| is_stated));
        let starts = position.map(|position| starts(problem, refit, position)).unwrap_or_default();
        EffectResult {
            hints,
            starts,
            file: None,
            id: candidate.id.clone(),
            effect: candidate.effect.clone(),
            title: file
                .map_or_else(|| TITLE.to_owned(), |file| file.title_at(candidate, &problem.model, &sensors).to_owned()),
            place: candidate.place.clone(),
            where_kind: candidate.where_kind.to_owned(),
            input: candidate.input.clone(),
            probability,
            model_error: findings.model_error(effect),
            log_bayes_factor,
            log_bayes_factor_scales: scales,
            changes_nothing: changes_nothing(before, refit),
            group,
            precedence: findings.precedence(effect),
            amplitudes,
            since: None,
            reference_k: problem.stated_reference_k(candidate),
            rmse_k: RmseChange {
                train: [before.rmse_train_k, refit.rmse_train_k],
                held_out: [before.rmse_held_out_k, refit.rmse_held_out_k],
            },
            watts,
            prior_width: position.map_or(1.0, |position| refit.widths[position]),
            within_model: position.is_some_and(|position| refit.within_model[position]),
            carries,
            confused_with: file
                .map(|file| file.form.confused_with.iter().map(|name| name.value.clone()).collect())
                .unwrap_or_default(),
            separate: file
                .map_or_else(|| Some(SEPARATE.to_owned()), |file| file.form.separate.clone())
                .unwrap_or_default(),
        }
    }

    /// Log Bayes factors with the amplitudes' priors at half and at double scale.
    fn at_scales(&self, findings: &Findings<'_>, refit: &Refit, log_bayes_factor: f64) -> Option<[f64; 2]> {
        let at = |scale: f64| {
            let begin = Begin { starts: vec![refit.by_name()], scale, is_near: true, ..Begin::default() };
            let found = findings.problem.refit(&refit.effects, &begin, self.key()).ok()?;
            Some(log_bayes_factor + found.log_evidence - refit.log_evidence).filter(|value| value.is_finite())
        };
        let (half, double) = rayon::join(|| at(0.5), || at(2.0));
        Some([half?, double?])
    }
}

/// The start temperatures of the nodes that a member of a set adds, where they were inferred.
fn starts(problem: &Problem, refit: &Refit, member: usize) -> Vec<StartResult> {
    let Ok(hypothesis) = problem.hypothesis_of_widths(&refit.effects, &refit.widths) else { return Vec::new() };
    let one = |start: &InferredStart| {
        let measurement = &hypothesis.measurements[start.measurement].name;
        let node = &hypothesis.model.nodes[start.node].name;
        let unknown = start_name(measurement, node);
        let place = refit.names.iter().position(|name| *name == unknown)?;
        let Distribution::Normal { mean, sd, lower: Some(lower), upper: Some(upper) } = start.prior else {
            return None;
        };
        Some(StartResult {
            measurement: measurement.clone(),
            node: node.clone(),
            most_probable_k: refit.unknowns[place],
            prior_k: [mean, sd],
            bounds_k: [lower, upper],
        })
    };
    hypothesis.starts.iter().filter(|start| start.effect == member).filter_map(one).collect()
}

/// Whether two fits predict the same, to less than any table shows.
fn changes_nothing(before: &Refit, after: &Refit) -> bool {
    let moved = before.residuals.iter().zip(&after.residuals).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    before.residuals.len() == after.residuals.len() && moved.sqrt() < MOVES_NOTHING
}

/// Sum of squares of the baseline model's errors in standard deviations of the instruments' noise, where a model error is
/// allowed for beside it.
fn by_noise_alone(problem: &Problem, state: &State) -> Option<f64> {
    let of = |(reading, error): (FittedReading, &f64)| {
        let same = |own: &&SensorNoise| own.measurement == reading.measurement && own.sensor == reading.sensor;
        let own = state.noise.iter().find(same).filter(|own| own.model_error.is_some())?;
        Some((error / own.noise.total()) * (error / own.noise.total()))
    };
    problem.fitted_readings().into_iter().zip(&state.refits[0].errors).map(of).sum()
}

pub(super) fn misfit(problem: &Problem, state: &State) -> Misfit {
    let baseline = &state.refits[0];
    // As in a calibration: a parameter at a bound counts too, so that both tell one figure where their noise is one.
    let unknowns = baseline.names.iter().filter(|name| !is_idle(name)).count();
    let freedom = (baseline.residuals.len() as f64 - unknowns as f64).max(1.0);
    let family = state.stated_family.as_ref().unwrap_or(&state.screening.family);
    let tests = family.tests.iter();
    Misfit {
        reduced_chi2: by_noise_alone(problem, state).unwrap_or(baseline.chi_square) / freedom,
        family_wise_p: family.p,
        rmse_k: Rmse { train: baseline.rmse_train_k, held_out: baseline.rmse_held_out_k },
        tests: tests.map(|test| Test { name: test.name.clone(), at: test.at.clone(), p: test.p }).collect(),
    }
}

/// Probabilities of the sets: those with which the steps of a story are weighed, where there is one.
fn probabilities_of_sets(findings: &Findings<'_>) -> Vec<f64> {
    let Some(story) = &findings.story else { return findings.weights.sets.clone() };
    let total = log_sum_exp(&story.logs);
    let explained = 1.0 - findings.weights.unexplained;
    story.logs.iter().map(|log| explained * exp(log - total)).collect()
}

/// The most probable sets; whatever their number, nothing and those that lead to the selected one are among them.
pub(super) fn models(findings: &Findings<'_>) -> Vec<ModelResult> {
    let story = findings.story.iter().flat_map(|story| story.sets.iter().copied());
    let always: Vec<usize> = [0, findings.selected].into_iter().chain(story).collect();
    let refits = &findings.state.refits;
    let mut order: Vec<usize> = (0..refits.len()).collect();
    let probabilities = probabilities_of_sets(findings);
    sort_by(&mut order, |&a, &b| probabilities[b].total_cmp(&probabilities[a]).then(a.cmp(&b)));
    let result = |place: usize| {
        let refit = &refits[place];
        ModelResult {
            effects: refit.effects.iter().map(|&effect| findings.id(effect).to_owned()).collect(),
            log_evidence: refit.log_evidence,
            probability: probabilities[place],
            chi_square: refit.chi_square,
            rmse_k: Rmse { train: refit.rmse_train_k, held_out: refit.rmse_held_out_k },
        }
    };
    let ranked = order.into_iter().enumerate();
    let written = ranked.filter(|(rank, place)| *rank < MOST_WRITTEN || always.contains(place));
    written.map(|(_, place)| result(place)).collect()
}

pub(super) fn unseen(findings: &Findings<'_>) -> Vec<Unseen> {
    let unseen_effect = |effect: usize, why: String| Unseen { id: findings.id(effect).to_owned(), why };
    let mut list: Vec<Unseen> =
        findings.state.screening.unseen.iter().map(|(effect, why)| unseen_effect(*effect, why.clone())).collect();
    // What no set was fitted with is not judged either.
    let is_fitted = |effect: &usize| findings.state.refits.iter().any(|refit| refit.effects.contains(effect));
    for (effect, why) in findings.state.failed.iter().filter(|(effect, _)| !is_fitted(effect)) {
        let id = findings.id(*effect);
        if !list.iter().any(|known| known.id == id) {
            list.push(unseen_effect(*effect, format!("it cannot be fitted: {why}")));
        }
    }
    list
}

pub(super) fn detectable(findings: &Findings<'_>) -> BTreeMap<String, Detectable> {
    let list = findings.state.screening.detectable.iter();
    list.map(|(effect, value, unit)| {
        (findings.id(*effect).to_owned(), Detectable { value: *value, unit: unit.clone() })
    })
    .collect()
}

pub(super) fn noise(problem: &Problem, state: &State) -> BTreeMap<String, NoiseResult> {
    let mut results = BTreeMap::new();
    for (index, measurement) in problem.measurements.iter().enumerate() {
        for (place, sensor) in measurement.sensors.iter().enumerate() {
            let part = |value: &Option<crate::measurement::Uncertain>| value.as_ref().map(|v| v.nominal());
            let (sigma, white) = (part(&sensor.sigma).unwrap_or(0.0), part(&sensor.white).unwrap_or(0.0));
            let total = total_sd(sigma, white);
            let time = part(&sensor.correlation_time_s).filter(|_| matches!(measurement.rows, Rows::Transient { .. }));
            let share = if time.is_some() && total > 0.0 { sigma * sigma / (total * total) } else { 0.0 };
            let own = state.noise.iter().find(|one| one.measurement == index && one.sensor == place);
            let estimated = own.is_some();
            let error = own.and_then(|one| one.model_error);
            results.insert(
                sensor.name.clone(),
                NoiseResult {
                    sigma: own.filter(|_| error.is_some()).map_or(total, |one| one.noise.total()),
                    model_error: error.map(|error| error.sd),
                    counts_as: error.map(|_| total),
                    correlation_time_s: time,
                    correlated_share: share,
                    unit: problem.model.quantities[sensor.quantity].unit.clone(),
                    estimated,
                },
            );
        }
    }
    results
}
