//! The second regime of a diagnosis: the model is a little wrong everywhere, so that no set of effects leaves the noise
//! alone. Then a model error is allowed for beside every set ([`crate::diagnosis::noise::model_error`]), estimated beside
//! the most probable one, and the search begins anew with it.
//!
//! Transients whose noise is not stated are in this regime from the start: what slow errors of an estimated noise would
//! take up is physics as well. Measurements whose noise is stated enter it where the sets that were found owe it more
//! than that noise allows.

use std::collections::BTreeMap;

use crate::diagnosis::channel::resolution;
use crate::diagnosis::engine::{Diagnosis, FitRequest, SensorNoise, State};
use crate::diagnosis::fits::{held_out, other_noise};
use crate::diagnosis::heat;
use crate::diagnosis::noise::estimate::EstimatedNoise;
use crate::diagnosis::noise::model_error::{
    Errors, ModelError, STEADY_READINGS_OF_ONE, most_likely, quiet_scatter, readings_of_one,
};
use crate::diagnosis::odds::posterior_odds::{best, posterior_odds};
use crate::diagnosis::odds::prior_odds::PriorOdds;
use crate::diagnosis::problem::FittedReading;
use crate::diagnosis::screening::screen::Lead;
use crate::diagnosis::{FitError, Problem, Refit};
use crate::effect::{Effect, Site};
use crate::math::functions::{exp, ln};
use crate::math::sort::{sort_by, sort_by_key};
use crate::measurement::{Measurement, Rows, total_sd};

/// Times that a model error is estimated.
const MOST_TIMES: u32 = 3;
/// Rounds in which a model error and the set beside which it stands are sought.
const ROUNDS: usize = 4;
/// Share of the baseline model's root mean square error that a transient's errors are taken to have at first: fits
/// follow what is large, whatever the size.
const AT_FIRST: f64 = 0.3;
/// Sets that are fitted anew with a model error.
const MOST_AGAIN: usize = 20;
/// Effects of a set beside which a model error is estimated.
const MOST_BESIDE: usize = 2;
/// Laws of groups and of single nodes, and laws of elements, that are fitted whatever their linearisation says.
const MOST_PLAIN_LAWS: usize = 32;
/// Log odds by which an effect of several inputs stands behind one of one input, for each further input.
const FURTHER_INPUT: f64 = 1.1;
/// Standard deviation of the logarithm of a model error about that of the best set.
const APART: f64 = 0.35;
/// Relative change of the size with which readings count that matters.
const CHANGES: f64 = 0.15;
/// Share of the noise below which a model error is none.
const NONE: f64 = 0.2;
/// Least noise, as a share of the errors' root mean square: nothing is known without any.
const LEAST_NOISE: f64 = 1e-3;

/// Whether the noise of a transient is not stated.
pub(crate) fn is_unstated(measurement: &Measurement) -> bool {
    let is_inferred = |sensor: &crate::measurement::Sensor| {
        sensor.sigma.as_ref().is_none_or(|sigma| sigma.prior().is_some())
            || sensor.white.as_ref().is_some_and(|white| white.prior().is_some())
    };
    matches!(measurement.rows, Rows::Transient { .. }) && measurement.sensors.iter().any(is_inferred)
}

/// What a model error costs that is larger than that of the best set: sizes are alike whatever the set is.
fn owes_more(sd: f64, first: f64) -> f64 {
    let times = (ln(sd / first) / APART).max(0.0);
    if sd > first && first > 0.0 { 0.5 * times * times } else { 0.0 }
}

fn is_temperature(problem: &Problem, reading: &FittedReading) -> bool {
    let sensor = &problem.measurements[reading.measurement].sensors[reading.sensor];
    problem.model.quantities[sensor.quantity].unit == "K"
}

/// Errors of one sensor of one measurement, in their order.
fn series(readings: &[FittedReading], errors: &[f64], measurement: usize, sensor: usize) -> Vec<f64> {
    let fitted_errors = readings.iter().zip(errors);
    fitted_errors
        .filter(|(reading, _)| reading.measurement == measurement && reading.sensor == sensor)
        .map(|(_, error)| *error)
        .collect()
}

fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0), |(sum, count), error| (sum + error * error, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

/// Positions of the measurements that have one model error: all transients, and all steady phases.
fn alike(problem: &Problem) -> impl Iterator<Item = Vec<usize>> {
    let is_steady = |place: &usize| matches!(problem.measurements[*place].rows, Rows::Steady(_));
    let (steady, transient): (Vec<usize>, Vec<usize>) = (0..problem.measurements.len()).partition(is_steady);
    [steady, transient].into_iter().filter(|alike| !alike.is_empty())
}

/// A set with the most likely model errors: its evidence has the likelihood exchanged, and the prior density and the volume
/// that the parameters have with it.
fn beside(problem: &Problem, readings: &[FittedReading], refit: &Refit, instruments: &[Errors]) -> Beside {
    let of = |measurement: usize| (0..readings.len()).filter(move |&k| readings[k].measurement == measurement);
    let errors = |&measurement: &usize| Errors {
        errors: of(measurement).map(|k| refit.errors[k]).collect(),
        ..instruments[measurement].clone()
    };
    let (mut log, mut sds, mut widening, mut count) = (0.0, vec![0.0; instruments.len()], 0.0, 0.0);
    for alike in alike(problem) {
        let (sd, value) = most_likely(&alike.iter().map(errors).collect::<Vec<_>>(), 1.0);
        log += value;
        for measurement in alike {
            sds[measurement] = sd;
            for (k, noise) in of(measurement).zip(&instruments[measurement].noise) {
                let before = problem.measurements[measurement].sensors[readings[k].sensor].total_sd();
                let variance = (noise * noise + sd * sd) * instruments[measurement].readings_of_one;
                widening += ln(variance / (before * before));
                count += 1.0;
            }
        }
    }
    let times = exp(widening / f64::max(count, 1.0));
    log += refit.log_evidence - refit.log_likelihood + other_noise::gain(&refit.directions, times);
    let determined = other_noise::determined(&refit.directions, times);
    Beside { place: 0, log_evidence: log, log_weight: log, sds, determined }
}

/// A set with the model errors that are most likely beside it.
pub(super) struct Beside {
    /// Position of the set.
    pub(super) place: usize,
    /// Log evidence of the set with them.
    log_evidence: f64,
    /// Log posterior weight of the set with them; of [`beside`] the log evidence alone.
    log_weight: f64,
    /// Standard deviations of the model error, SI, by measurement; one for those that are alike.
    pub(super) sds: Vec<f64>,
    /// Parameters that the data determine with them.
    determined: f64,
}

impl Diagnosis {
    /// The noise with which transients of unstated noise are fitted first.
    pub(crate) fn noise_at_first(&self, declared: &Refit) -> Vec<SensorNoise> {
        let problem = self.problem();
        let readings = problem.fitted_readings();
        let mut noise = Vec::new();
        for (measurement, measured) in
            problem.measurements.iter().enumerate().filter(|(_, measured)| is_unstated(measured))
        {
            // As large as elsewhere in a measurement that is held out as a whole.
            let of = |wanted: &dyn Fn(&FittedReading) -> bool| {
                let all = readings.iter().zip(&declared.errors);
                rms(all.filter(|(reading, _)| wanted(reading)).map(|(_, error)| *error))
            };
            for sensor in 0..measured.sensors.len() {
                let here = of(&|reading| reading.measurement == measurement);
                let size = if here > 0.0 { here } else { of(&|_| true) };
                let white = EstimatedNoise::white((AT_FIRST * size).max(f64::MIN_POSITIVE.sqrt()));
                noise.push(SensorNoise { measurement, sensor, noise: white, model_error: None });
            }
        }
        noise
    }

    /// Whether the noise is that of a transient which is not stated.
    pub(crate) fn is_at_first(&self, one: &SensorNoise) -> bool {
        is_unstated(&self.problem().measurements[one.measurement])
    }

    /// Allows for a model error where the fitted sets want one, or for another than before: the diagnosis then begins
    /// anew with it. `None` where it stays.
    pub(crate) fn allow_for_model_error(&self, state: &State) -> Result<Option<State>, FitError> {
        let unstated = self.problem().measurements.iter().any(is_unstated);
        if state.model_errors >= MOST_TIMES || !(unstated || self.finds(&state.screening) || state.model_errors > 0) {
            return Ok(None);
        }
        let Some(noise) = self.with_model_error(state) else { return Ok(None) };
        let mut next = self.screen_with(&state.refits[0], noise, state.most_steps.clone())?;
        next.rounds = state.rounds;
        next.model_errors = state.model_errors + 1;
        next.stated_family = if self.problem().measurements.iter().any(is_unstated) {
            None
        } else {
            state.stated_family.clone().or_else(|| Some(state.screening.family.clone()))
        };
        next.warnings.clone_from(&state.warnings);
        next.failed.clone_from(&state.failed);
        let beside = self.beside_sets(state, &self.instruments(state, 0));
        for beside in beside.iter().take(MOST_AGAIN) {
            let refit = &state.refits[beside.place];
            let request = FitRequest { effects: refit.effects.clone(), starts: vec![refit.by_name()], from: 0 };
            if let Some(pending_order) =
                next.pending.iter_mut().find(|pending_order| pending_order.effects == request.effects)
            {
                pending_order.starts = request.starts;
            } else if !next.is_known(&request.effects) {
                next.pending.push(request);
            }
        }
        Ok(Some(next))
    }

    /// Orders the laws of whole groups, of no input before those of one, and in a small network those of single nodes and elements: about
    /// a fit that a strong effect has distorted their linearisation tells little.
    pub(crate) fn order_plain_laws(&self, problem: &Problem, state: &mut State) {
        let candidates = &self.problem().candidates;
        let inputs =
            |place: usize| self.problem().catalogue.get(&candidates[place].effect).map_or(0, Effect::levels_and_inputs);
        let is_law = |&place: &usize| {
            let is_timed = self.problem().catalogue.get(&candidates[place].effect).is_some_and(Effect::depends_on_time);
            inputs(place) < 2 && !is_timed && !self.is_unknown_function(place)
        };
        let mut wanted: Vec<usize> =
            (0..candidates.len()).filter(is_law).filter(|&place| candidates[place].is_group()).collect();
        // What a group melts at is no input: without a start there its linearisation tells nothing at all.
        sort_by_key(&mut wanted, |&place| candidates[place].bound.len());
        wanted.truncate(MOST_PLAIN_LAWS);
        let at_node =
            |&place: &usize| !candidates[place].is_group() && matches!(candidates[place].site, Site::Nodes(_));
        for count in [0, 1] {
            let of_nodes = (0..candidates.len()).filter(is_law).filter(at_node).filter(|&place| inputs(place) == count);
            let of_nodes: Vec<usize> = of_nodes.collect();
            if wanted.len() + of_nodes.len() > MOST_PLAIN_LAWS {
                break;
            }
            wanted.extend(of_nodes);
        }
        let at_element = |&place: &usize| matches!(candidates[place].site, Site::Elements(_)) && inputs(place) == 0;
        let of_elements: Vec<usize> = (0..candidates.len()).filter(is_law).filter(at_element).collect();
        if of_elements.len() <= MOST_PLAIN_LAWS {
            wanted.extend(of_elements);
        }
        for candidate in wanted {
            if state.is_known(&[candidate]) {
                continue;
            }
            let starts = problem.starts_at_levels(&state.refits[0], candidate);
            let starts = if starts.is_empty() { vec![BTreeMap::new()] } else { starts };
            state.order(&[&Lead { candidate, fall: 0.0, starts }], &[], 0);
        }
    }

    /// Log evidences and log posterior weights of the sets, each with the model error that is most likely beside it; minus infinity where an
    /// effect does nothing and the set without it was fitted too.
    pub(crate) fn log_weights_of_story(&self, state: &State) -> (Vec<f64>, Vec<f64>) {
        let mut logs = vec![f64::NEG_INFINITY; state.refits.len()];
        let mut evidences = logs.clone();
        let Some((first, instruments)) = self.reference(state) else { return (evidences, logs) };
        let is_smaller_set = |place: usize| {
            let refit = &state.refits[place];
            let rest: Vec<usize> =
                refit.effects.iter().copied().filter(|&effect| !refit.does_nothing(effect)).collect();
            rest.len() < refit.effects.len() && state.refits.iter().any(|other| other.effects == rest)
        };
        for one in self.beside_sets(state, &instruments).into_iter().filter(|one| !is_smaller_set(one.place)) {
            let inputs = |&effect: &usize| self.problem().candidates[effect].bound.len().saturating_sub(1) as f64;
            let owed: f64 = alike(self.problem()).map(|alike| owes_more(one.sds[alike[0]], first.sds[alike[0]])).sum();
            let more: f64 = state.refits[one.place].effects.iter().map(inputs).sum();
            evidences[one.place] = one.log_evidence - owed;
            logs[one.place] = one.log_weight - FURTHER_INPUT * more - owed;
        }
        (evidences, logs)
    }

    /// The noise with the model error that the fitted sets want; `None` where it is that of before.
    fn with_model_error(&self, state: &State) -> Option<Vec<SensorNoise>> {
        let unstated = self.problem().measurements.iter().any(is_unstated);
        let (first, instruments) = self.reference(state)?;
        if !unstated && state.model_errors == 0 && !self.owes(state, &first, &instruments) {
            return None;
        }
        let refit = &state.refits[first.place];
        let freedom = self.freedom(&first, &instruments);
        let mut sds = vec![0.0; instruments.len()];
        for alike in alike(self.problem()) {
            let errors: Vec<Errors> = alike.iter().map(|&measurement| instruments[measurement].clone()).collect();
            let (sd, _) = most_likely(&errors, freedom);
            alike.into_iter().for_each(|measurement| sds[measurement] = sd);
        }
        let noise = self.sensors_with(state, refit, &sds, &instruments);
        let size = |one: &SensorNoise| one.weighed().total();
        let is_other = |one: &SensorNoise| {
            let same = |old: &&SensorNoise| old.measurement == one.measurement && old.sensor == one.sensor;
            let before = state.noise.iter().find(same).map_or_else(|| self.stated(one), size);
            if state.model_errors > 0 {
                // What a set leaves need not be more than another was seen to leave.
                return size(one) < (1.0 - CHANGES) * before;
            }
            (size(one) - before).abs() > CHANGES * size(one).max(before)
        };
        // The size with which fits of unstated noise begin is a guess, whatever comes out.
        let is_guess = unstated && state.model_errors == 0;
        (is_guess || noise.iter().any(is_other)).then_some(noise)
    }

    /// The most probable plain set with the model error that is most likely beside it, and the instruments' noise.
    pub(super) fn reference(&self, state: &State) -> Option<(Beside, Vec<Errors>)> {
        let mut place = best(&posterior_odds(self.problem(), &state.refits, None)).unwrap_or(0);
        let mut chosen = None;
        for _ in 0..ROUNDS {
            let instruments = self.instruments(state, place);
            let mut sets = self.beside_sets(state, &instruments);
            // A curve, or a third effect, could take model error for physics.
            let is_plain = |effects: &[usize]| {
                effects.len() <= MOST_BESIDE && effects.iter().all(|&effect| !self.is_unknown_function(effect))
            };
            sets.retain(|one| is_plain(&state.refits[one.place].effects));
            let first = sets.into_iter().next()?;
            let settled = first.place == place && chosen.is_some();
            place = first.place;
            chosen = Some((first, instruments));
            if settled {
                break;
            }
        }
        chosen
    }

    /// Whether the best set leaves more than the stated noise: tests find something beside it, heat whatever its cause is
    /// more probable, or it fails on the held-out rows.
    fn owes(&self, state: &State, first: &Beside, instruments: &[Errors]) -> bool {
        let is_none = |(sd, errors): (&f64, &Errors)| *sd <= NONE * rms(errors.noise.iter().copied());
        if first.sds.iter().zip(instruments).all(is_none) {
            return false;
        }
        let problem = self.with_noise(&state.noise, &state.most_steps);
        let missing = heat::missing_heat(&problem, &state.refits[0]).ok();
        let weights = posterior_odds(&problem, &state.refits, missing.map(|missing| missing.log_evidence));
        let Some(place) = best(&weights) else { return false };
        let left = state.remainders.iter().find(|one| one.effects == state.refits[place].effects);
        let finds = left.is_some_and(|left| left.p <= self.settings().false_alarm);
        let fails =
            || held_out::test(&problem, &state.refits[0], &state.refits[place], problem.noise_freedom.is_none());
        finds || weights.unexplained > 0.5 || fails().is_some_and(|test| test.veto)
    }

    /// Standard deviation of a sensor's readings as the study states it, SI.
    fn stated(&self, one: &SensorNoise) -> f64 {
        self.problem().measurements[one.measurement].sensors[one.sensor].total_sd()
    }

    /// Share of the independent readings that the fit of a set does not use up.
    fn freedom(&self, set: &Beside, instruments: &[Errors]) -> f64 {
        let independent: f64 =
            instruments.iter().map(|errors| errors.errors.len() as f64 / errors.readings_of_one).sum();
        (1.0 - set.determined / independent.max(1.0)).max(0.3)
    }

    /// By measurement: the errors of a set, and the instruments' noise as it is known or as quiet stretches of these show it.
    fn instruments(&self, state: &State, place: usize) -> Vec<Errors> {
        let problem = self.problem();
        let readings = problem.fitted_readings();
        let refit = &state.refits[place];
        let mut all = Vec::new();
        for (measurement, measured) in problem.measurements.iter().enumerate() {
            let of_sensors: Vec<Vec<f64>> = (0..measured.sensors.len())
                .map(|sensor| series(&readings, &refit.errors, measurement, sensor))
                .collect();
            let noise: Vec<f64> = (0..measured.sensors.len())
                .map(|sensor| self.instrument(state, measurement, sensor, &of_sensors[sensor]))
                .collect();
            let mine: Vec<usize> = (0..readings.len()).filter(|&k| readings[k].measurement == measurement).collect();
            let mut errors = Errors {
                errors: mine.iter().map(|&k| refit.errors[k]).collect(),
                noise: mine.iter().map(|&k| noise[readings[k].sensor]).collect(),
                readings_of_one: 1.0,
            };
            errors.readings_of_one = match measured.rows {
                Rows::Transient { .. } => readings_of_one(&of_sensors),
                Rows::Steady(_) => {
                    let error = most_likely(std::slice::from_ref(&errors), 1.0).0;
                    let noise = rms(errors.noise.iter().copied());
                    let (error, noise) = (error * error, noise * noise);
                    (noise + STEADY_READINGS_OF_ONE * error) / (noise + error)
                }
            };
            all.push(errors);
        }
        all
    }

    /// Standard deviation of the noise of one instrument.
    fn instrument(&self, state: &State, measurement: usize, sensor: usize, errors: &[f64]) -> f64 {
        let measured = &self.problem().measurements[measurement];
        if is_unstated(measured) {
            let readings: Vec<f64> = (0..measured.len()).filter_map(|row| measured.reading(row, sensor)).collect();
            // What is rounded to whole steps errs by up to half a step, evenly.
            let rounded = resolution(&readings) / 12.0_f64.sqrt();
            let least = rounded.max(LEAST_NOISE * rms(errors.iter().copied())).max(f64::MIN_POSITIVE.sqrt());
            return quiet_scatter(errors).max(least);
        }
        let estimated = state.noise.iter().find(|one| one.measurement == measurement && one.sensor == sensor);
        estimated.map_or_else(|| measured.sensors[sensor].total_sd(), |one| one.noise.total())
    }

    /// The noise of all sensors beside a set, with a model error by measurement.
    fn sensors_with(&self, state: &State, refit: &Refit, sds: &[f64], instruments: &[Errors]) -> Vec<SensorNoise> {
        let problem = self.problem();
        let readings = problem.fitted_readings();
        let mut all = Vec::new();
        for (measurement, measured) in problem.measurements.iter().enumerate() {
            let is_fitted = |m: usize| readings.iter().any(|reading| reading.measurement == m);
            // A measurement that is held out as a whole is as another is.
            let like = if is_fitted(measurement) { Some(measurement) } else { (0..sds.len()).find(|&m| is_fitted(m)) };
            let Some(like) = like else { continue };
            for sensor in 0..measured.sensors.len() {
                let same =
                    problem.measurements[like].sensors.iter().position(|one| one.name == measured.sensors[sensor].name);
                let source = if like == measurement { Some(sensor) } else { same };
                let at = source.unwrap_or(0);
                let noise = self.instrument(state, like, at, &series(&readings, &refit.errors, like, at));
                let probe = FittedReading { measurement, row: 0, sensor };
                let sd = if is_temperature(problem, &probe) { sds[like] } else { 0.0 };
                let in_transient = total_sd(noise, sd) * instruments[like].readings_of_one.sqrt();
                let error = ModelError { sd, counts_as: in_transient };
                let model_error = Some(match measured.rows {
                    Rows::Steady(_) => ModelError { counts_as: error.in_steady_phases(noise), ..error },
                    Rows::Transient { .. } => error,
                });
                all.push(SensorNoise { measurement, sensor, noise: EstimatedNoise::white(noise), model_error });
            }
        }
        all
    }

    /// All sets with the model errors that are most likely beside them, the most probable first.
    pub(super) fn beside_sets(&self, state: &State, instruments: &[Errors]) -> Vec<Beside> {
        let problem = self.with_noise(&state.noise, &state.most_steps);
        let (readings, odds) = (problem.fitted_readings(), PriorOdds::new(&problem));
        let mut sets: Vec<Beside> = (0..state.refits.len())
            .map(|place| {
                let refit = &state.refits[place];
                let set = beside(&problem, &readings, refit, instruments);
                Beside { place, log_weight: set.log_weight + odds.of(&problem, &refit.effects), ..set }
            })
            .filter(|one| one.log_weight.is_finite())
            .collect();
        sort_by(&mut sets, |a, b| b.log_weight.total_cmp(&a.log_weight).then(a.place.cmp(&b.place)));
        sets
    }
}
