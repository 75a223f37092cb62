//! The course of a diagnosis: screen everything, fit the best sets, go on from the best of these until nothing is left,
//! conclude. Every step is a pure function of the problem and of what was found before.

use crate::diagnosis::FitError;
use crate::diagnosis::Unfitted;
use crate::diagnosis::left_out::{Excursion, LeftOut};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Arc, Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::diagnosis::fits::exchange::exchanges;
use crate::diagnosis::fits::refit::Begin;
use crate::diagnosis::noise::estimate::{EstimatedNoise, fix};
use crate::diagnosis::noise::model_error::ModelError;
use crate::diagnosis::odds::posterior_odds::posterior_odds;
use crate::diagnosis::places::{Choice, Places};
use crate::diagnosis::problem::FittedReading;
use crate::diagnosis::screening::screen::{FamilySummary, Foremost, Lead, Screening};
use crate::diagnosis::{Problem, Refit, Settings};
use crate::effect::Candidate;
use crate::inference::prior::joint_prior::JointPrior;
use crate::measurement::total_sd;
use crate::random::StreamKey;

/// Single effects that are fitted at first.
pub(crate) const SINGLES: usize = 30;
/// Pairs that are fitted at first.
const PAIRS: usize = 30;
/// Failures from which a set is not ordered again: another start may lead to a fit, but not every time.
const MOST_FAILURES: usize = 3;
/// Single effects, and pairs, that are fitted before the noise of transients is estimated beside the best of them.
const PILOTS: usize = 8;
/// Most exchanges of channels that are fitted whatever their linearisation says.
const EXCHANGES: usize = 4;
/// Single effects that are fitted beside those that were fitted before, where a model error is allowed for.
const SINGLES_AGAIN: usize = 15;
/// Single effects that are fitted where no test finds anything.
const SINGLES_OF_NOTHING: usize = 10;
/// Single effects that are fitted beside those where the screening of a model at the edge of its priors says so.
const SINGLES_AT_PRIOR_MEDIANS: usize = 12;
/// A parameter this near the ends of its prior, as a probability, distorts the model.
const PRIOR_EDGE: f64 = 0.02;
/// Starts of the baseline model.
const STARTS: usize = 8;
/// A transient of a hypothesis may take this many times the steps of the baseline model.
pub(crate) const TIMES_THE_STEPS: u64 = 50;
/// And so many in any case: they cost nothing.
const LEAST_OF_MOST_STEPS: u64 = 2000;

/// A diagnosis of a problem.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    problem: Problem,
    settings: Settings,
    key: StreamKey,
    /// Which places are tried.
    pub choice: Choice,
    /// What was last at chosen places: every fit asks for it.
    placed: LastPlaced,
}

/// Places with the candidates at them.
type LastPlaced = Arc<Mutex<Option<(Places, Arc<Vec<Candidate>>)>>>;

/// A set of effects to be fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitRequest {
    /// Positions of the effects, ascending.
    pub effects: Vec<usize>,
    /// Starts of the effects' parameters by name, SI.
    pub starts: Vec<BTreeMap<String, f64>>,
    /// Position of the fit whose other unknowns are the start.
    pub from: usize,
}

/// The noise of a sensor as it was estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorNoise {
    /// Position of the measurement.
    pub measurement: usize,
    /// Position of the sensor.
    pub sensor: usize,
    /// Its noise.
    pub noise: EstimatedNoise,
    /// The model error that is allowed for beside it.
    #[serde(default)]
    pub model_error: Option<ModelError>,
}

impl SensorNoise {
    /// The noise that stands for both in the likelihood: white, and larger by what the correlation takes from the readings.
    pub fn weighed(&self) -> EstimatedNoise {
        self.model_error.map_or(self.noise, |error| EstimatedNoise::white(error.counts_as))
    }

    /// Independent readings that one is worth beside the model error that is allowed for; 0 where none is.
    pub fn independent_readings(&self) -> f64 {
        let share = |error: ModelError| total_sd(self.noise.total(), error.sd) / error.counts_as;
        self.model_error.map_or(0.0, |error| share(error) * share(error))
    }
}

/// What a set of effects leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Remainder {
    /// The set.
    pub effects: Vec<usize>,
    /// Its family-wise p.
    pub p: f64,
    /// The effects that explain most of it; none where the set was fitted anew since.
    #[serde(default)]
    pub leads: Vec<Lead>,
}

/// What was found so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Rounds of fits that were finished.
    pub rounds: u32,
    /// How often another set than the best was extended.
    #[serde(default)]
    pub aside: u32,
    /// How often probable sets were fitted without each of their members.
    #[serde(default)]
    pub without_members: u32,
    /// How often a model error was estimated.
    #[serde(default)]
    pub model_errors: u32,
    /// Whether only few sets were fitted yet, to estimate the noise beside the best of them.
    #[serde(default)]
    pub is_pilot: bool,
    /// Noise that was estimated.
    pub noise: Vec<SensorNoise>,
    /// Attempted steps after which a hypothesis's transient is given up, by measurement; empty without transients.
    #[serde(default)]
    pub most_steps: Vec<u64>,
    /// What screening of the baseline model found.
    pub screening: Screening,
    /// What the tests found with the stated noise, where a model error is allowed for.
    #[serde(default)]
    pub stated_family: Option<FamilySummary>,
    /// Fits; the first is the baseline model's.
    pub refits: Vec<Refit>,
    /// Sets to be fitted.
    pub pending: Vec<FitRequest>,
    /// What sets leave.
    pub remainders: Vec<Remainder>,
    /// Sets from whose levels their members were fitted alone.
    #[serde(default)]
    pub at_levels: Vec<Vec<usize>>,
    /// Sets that could not be fitted, each as often as that was tried.
    #[serde(default)]
    pub unfitted: Vec<Vec<usize>>,
    /// Effects that cannot be fitted alone, and why; the state is stored, so reasons are texts here.
    #[serde(default)]
    pub failed: Vec<(usize, String)>,
    /// Readings that are left out as faults of the data.
    #[serde(default)]
    pub left_out: Vec<LeftOut>,
    /// What looks like faults but is shown by several sensors, and stays.
    #[serde(default)]
    pub excursions: Vec<Excursion>,
    /// Pairs of nodes that are places, where the model is too large for all.
    #[serde(default)]
    pub places: Places,
    /// What went wrong.
    pub warnings: Vec<String>,
}

impl State {
    /// Takes the fits of the pending sets, in order. Of two fits of a set the better one stays.
    pub fn take(&mut self, refits: Vec<Result<Refit, Unfitted>>) {
        for (request, refit) in std::mem::take(&mut self.pending).into_iter().zip(refits) {
            match refit {
                Ok(refit) => {
                    match self.refits.iter_mut().find(|earlier_refit| earlier_refit.effects == refit.effects) {
                        Some(earlier_refit) if refit.log_evidence > earlier_refit.log_evidence => {
                            self.remainders
                                .iter_mut()
                                .filter(|left| left.effects == refit.effects)
                                .for_each(|left| left.leads.clear());
                            *earlier_refit = refit;
                        }
                        Some(_) => {}
                        None => self.refits.push(refit),
                    }
                }
                Err(why) => {
                    self.unfitted.push(request.effects.clone());
                    // A set of several is one of many that were tried.
                    if let [effect] = request.effects[..] {
                        self.failed.push((effect, why.reason.clone()));
                        self.warn(why);
                    }
                }
            }
        }
    }

    /// Orders a set once more where it was fitted, with a fit of a larger set as its start.
    pub(crate) fn order_again(&mut self, effects: Vec<usize>, from: usize) {
        if !self.pending.iter().any(|request| request.effects == effects) {
            self.pending.push(FitRequest { effects, starts: vec![BTreeMap::new()], from });
        }
    }

    /// Whether a model error is allowed for.
    pub(crate) fn is_misspecified(&self) -> bool {
        self.noise.iter().any(|one| one.model_error.is_some())
    }

    /// Whether nothing was screened yet with the noise that was estimated.
    fn is_unscreened(&self) -> bool {
        self.remainders.is_empty()
    }

    /// Whether what a set leaves was tested and went into orders.
    pub(crate) fn was_extended(&self, place: usize) -> bool {
        self.remainders.iter().any(|remainder| remainder.effects == self.refits[place].effects)
    }

    pub(crate) fn warn(&mut self, why: impl Display) {
        let why = why.to_string();
        if !self.warnings.contains(&why) {
            self.warnings.push(why);
        }
    }

    /// Whether a set is fitted, is to be, or could not be.
    pub(crate) fn is_known(&self, effects: &[usize]) -> bool {
        self.refits.iter().any(|refit| refit.effects == effects)
            || self.pending.iter().any(|request| request.effects == effects)
            || self.unfitted.iter().filter(|own| *own == effects).count() >= MOST_FAILURES
    }

    /// Orders a fit of a set, unless it is there.
    pub(crate) fn order(&mut self, leads: &[&Lead], with: &[usize], from: usize) {
        let mut effects: Vec<usize> = leads.iter().map(|lead| lead.candidate).chain(with.iter().copied()).collect();
        effects.sort_unstable();
        effects.dedup();
        if effects.len() != leads.len() + with.len() || self.is_known(&effects) {
            return;
        }
        let mut starts = vec![BTreeMap::new()];
        for lead in leads {
            let mut longer = Vec::new();
            for lead_start in &lead.starts {
                for start in &starts {
                    let mut both = start.clone();
                    both.extend(lead_start.iter().map(|(name, value)| (name.clone(), *value)));
                    longer.push(both);
                }
            }
            starts = longer;
        }
        starts.truncate(4);
        self.pending.push(FitRequest { effects, starts, from });
    }
}

impl Diagnosis {
    /// A diagnosis; all random numbers come from `key`.
    pub fn new(mut problem: Problem, settings: Settings, key: StreamKey) -> Self {
        problem.missing_probability.clone_from(&settings.missing_probability);
        Self { problem, settings, key, choice: Choice::default(), placed: LastPlaced::default() }
    }

    /// The same with joint priors of some of the problem's parameters, by their places in its list, which share none.
    pub fn with_joint_priors(mut self, joint: Vec<JointPrior>) -> Self {
        self.problem.joint = joint;
        self
    }

    /// What is diagnosed.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The streams of random numbers.
    pub(crate) fn key(&self) -> &StreamKey {
        &self.key
    }

    /// The diagnosis without the readings that a state leaves out, at the places that it chose.
    pub(crate) fn at(&self, state: &State) -> Cow<'_, Self> {
        if state.left_out.is_empty() && state.places == self.problem.places {
            return Cow::Borrowed(self);
        }
        let mut remaining = self.without(&state.left_out);
        if state.places != self.problem.places {
            remaining = remaining.at_places_of(state);
        }
        Cow::Owned(remaining)
    }

    /// The same at the places of a state, with the candidates of the last time where these are the same places.
    fn at_places_of(&self, state: &State) -> Self {
        if self.problem.places != Places::default() {
            return self.with_places(state.places.clone());
        }
        // A fit that ended in a panic left what was there.
        let mut last = self.placed.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((places, candidates)) = last.as_ref().filter(|(places, _)| *places == state.places) {
            let problem =
                Problem { candidates: Arc::clone(candidates), places: places.clone(), ..self.problem.clone() };
            return self.with_problem(problem);
        }
        let placed = self.with_places(state.places.clone());
        *last = Some((state.places.clone(), Arc::clone(&placed.problem.candidates)));
        placed
    }

    /// The same of another problem.
    pub(crate) fn with_problem(&self, problem: Problem) -> Self {
        Self { problem, ..self.clone() }
    }

    /// Forgets a reading.
    pub(crate) fn forget(&mut self, measurement: usize, row: usize, sensor: usize) {
        let measurement_of_reading = &mut self.problem.measurements[measurement];
        let place = row * measurement_of_reading.sensors.len() + sensor;
        measurement_of_reading.readings[place] = None;
    }

    /// Takes the temperatures about which the hardware worked from the readings that are left.
    pub(crate) fn work_where_read(&mut self) {
        self.problem.work_where_read();
    }

    /// The problem with the estimated noise as if it were known, and bounds on the steps of transients.
    pub(crate) fn with_noise(&self, noise: &[SensorNoise], most_steps: &[u64]) -> Problem {
        let mut problem = Problem { most_steps: most_steps.to_vec(), ..self.problem.clone() };
        for one in noise {
            fix(&mut problem.measurements[one.measurement], one.sensor, &one.weighed());
        }
        problem.noise_freedom = self.noise_freedom(noise);
        problem.is_misspecified = noise.iter().any(|one| one.model_error.is_some() || self.is_at_first(one));
        let of = |reading: &FittedReading| {
            let same = |one: &&SensorNoise| one.measurement == reading.measurement && one.sensor == reading.sensor;
            noise.iter().find(same).map(SensorNoise::independent_readings)
        };
        problem.independent_readings = problem.fitted_readings().iter().filter_map(of).sum();
        problem
    }

    /// Fits the baseline model, estimates the noise and screens all effects and pairs.
    ///
    /// # Errors
    /// Why the baseline model cannot be fitted.
    pub fn screen(&self) -> Result<State, FitError> {
        let begin = Begin { from_prior: STARTS, scale: 1.0, ..Begin::default() };
        let declared = self.problem.refit(&[], &begin, &self.key)?;
        let (faults, excursions) = self.problem.faults_of_channels(&declared);
        if !faults.is_empty() {
            let without_faulty_readings = self.without(&faults);
            let declared = without_faulty_readings.problem.refit(&[], &begin, &self.key)?;
            let placed = without_faulty_readings.at_chosen_places(&declared)?;
            return Ok(State { left_out: faults, excursions, ..placed.screen_beside_noise(declared)? });
        }
        Ok(State { excursions, ..self.at_chosen_places(&declared)?.screen_beside_noise(declared)? })
    }

    /// Estimates the noise beside the baseline model as it was fitted, and screens.
    fn screen_beside_noise(&self, declared: Refit) -> Result<State, FitError> {
        let most_steps = self.most_steps(&declared)?;
        let at_first = self.noise_at_first(&declared);
        let at_first_noise = self.with_noise(&at_first, &most_steps);
        let (mut noise, foremost) = self.estimate_noise(&at_first_noise, &declared, true)?;
        noise.extend(at_first);
        if let Some(Foremost { leads, pairs }) =
            foremost.filter(|_| !self.with_noise(&noise, &most_steps).is_misspecified)
        {
            // Of a long record all directions take their time: with another noise they are found once.
            let baseline = self.fitted_with(&declared, &noise, &most_steps)?;
            let family = FamilySummary { p: 0.0, tests: Vec::new() };
            let screening = Screening { leads, pairs, family, ..Screening::default() };
            let mut state =
                State { is_pilot: true, ..self.begun(noise.clone(), most_steps.clone(), baseline, screening) };
            self.order_pilots(&mut state);
            if !state.pending.is_empty() {
                return Ok(state);
            }
        }
        let (problem, mut state) = self.screened_with(&declared, noise, most_steps)?;
        // Steady phases are fitted in no time.
        state.is_pilot = !state.noise.is_empty() && !state.most_steps.is_empty() && !problem.is_misspecified;
        if state.is_pilot {
            self.order_pilots(&mut state);
        } else {
            self.order_first(&problem, &mut state);
        }
        Ok(state)
    }

    /// Attempted steps after which a transient is given up: many times those of the baseline model at its fit. In a wrong
    /// hypothesis an integrator may crawl, and what it would find there counts for nothing.
    fn most_steps(&self, fitted: &Refit) -> Result<Vec<u64>, FitError> {
        if !self.problem.has_transients() {
            return Ok(Vec::new());
        }
        let baseline = self.problem.hypothesis(&[], 1.0).and_then(|hypothesis| hypothesis.likelihood(&self.problem));
        let likelihood = baseline?;
        let steps = likelihood.transient_steps(&fitted.unknowns)?;
        Ok(steps.into_iter().map(|steps| steps.saturating_mul(TIMES_THE_STEPS).max(LEAST_OF_MOST_STEPS)).collect())
    }

    /// Fits the baseline model, from another fit of it, with estimated noise, and screens all effects and pairs.
    pub(crate) fn screen_with(
        &self,
        fitted: &Refit,
        noise: Vec<SensorNoise>,
        most_steps: Vec<u64>,
    ) -> Result<State, FitError> {
        let (problem, mut state) = self.screened_with(fitted, noise, most_steps)?;
        self.order_first(&problem, &mut state);
        Ok(state)
    }

    /// The same before anything is ordered, with the problem of that noise.
    fn screened_with(
        &self,
        fitted: &Refit,
        noise: Vec<SensorNoise>,
        most_steps: Vec<u64>,
    ) -> Result<(Problem, State), FitError> {
        let problem = self.with_noise(&noise, &most_steps);
        let baseline = self.fitted_with(fitted, &noise, &most_steps)?;
        let screening = self.screen_problem(&problem, &baseline, true)?;
        let remainders = vec![Remainder { effects: Vec::new(), p: screening.family.p, leads: Vec::new() }];
        Ok((problem, State { remainders, ..self.begun(noise, most_steps, baseline, screening) }))
    }

    /// The baseline model fitted with estimated noise, from another fit of it.
    fn fitted_with(&self, fitted: &Refit, noise: &[SensorNoise], most_steps: &[u64]) -> Result<Refit, FitError> {
        if noise.is_empty() {
            return Ok(fitted.clone());
        }
        let begin = Begin { starts: vec![fitted.by_name()], from_prior: 2, scale: 1.0, ..Begin::default() };
        self.with_noise(noise, most_steps).refit(&[], &begin, &self.key)
    }

    /// What is known before anything else than the baseline model is fitted.
    fn begun(&self, noise: Vec<SensorNoise>, most_steps: Vec<u64>, baseline: Refit, screening: Screening) -> State {
        State {
            rounds: 0,
            aside: 0,
            without_members: 0,
            model_errors: 0,
            is_pilot: false,
            noise,
            most_steps,
            screening,
            stated_family: None,
            refits: vec![baseline],
            pending: Vec::new(),
            remainders: Vec::new(),
            at_levels: Vec::new(),
            unfitted: Vec::new(),
            failed: Vec::new(),
            left_out: Vec::new(),
            excursions: Vec::new(),
            places: self.problem.places.clone(),
            warnings: Vec::new(),
        }
    }

    /// Orders the sets that are fitted first: those that screening found, and those that it may have missed.
    pub(crate) fn order_first(&self, problem: &Problem, state: &mut State) {
        let screening = state.screening.clone();
        // A model error is allowed for where a misfit is certain.
        let finds = self.finds(&screening) || state.is_misspecified();
        let singles = match (state.is_misspecified(), finds) {
            (true, _) => SINGLES_AGAIN,
            (false, true) => SINGLES,
            (false, false) => SINGLES_OF_NOTHING,
        };
        let is_asked = |lead: &&Lead| !(problem.is_misspecified && self.is_last_resort(lead.candidate));
        for lead in screening.leads.iter().filter(is_asked).take(singles) {
            state.order(&[lead], &[], 0);
        }
        if finds {
            match exchanges(problem, &state.refits[0], EXCHANGES) {
                Ok(exchange_search) => {
                    for candidate in exchange_search.likeliest {
                        state.order(&[&Lead { candidate, fall: 0.0, starts: vec![BTreeMap::new()] }], &[], 0);
                    }
                    let impossible = exchange_search.impossible.into_iter();
                    state.failed.extend(impossible.map(|(candidate, why)| (candidate, why.to_string())));
                }
                Err(why) => state.warn(why),
            }
            match self.leads_at_prior_medians(problem, &state.refits[0]) {
                Ok(leads) => leads.iter().take(SINGLES_AT_PRIOR_MEDIANS).for_each(|lead| state.order(&[lead], &[], 0)),
                // The model may have no solution there.
                Err(why) => state.warn(why),
            }
        }
        if problem.is_misspecified {
            self.order_plain_laws(problem, state);
        } else if finds && self.settings.most > 1 {
            for pair in screening.pairs.iter().take(PAIRS) {
                state.order(&[&pair[0], &pair[1]], &[], 0);
            }
        }
    }

    /// Orders few sets, beside the best of which the noise is estimated before the others are fitted: with another noise
    /// all would be fitted again.
    fn order_pilots(&self, state: &mut State) {
        let screening = state.screening.clone();
        for lead in screening.leads.iter().take(PILOTS) {
            state.order(&[lead], &[], 0);
        }
        let is_with_pairs = self.settings.most > 1 && self.finds(&screening);
        for pair in screening.pairs.iter().take(if is_with_pairs { PILOTS } else { 0 }) {
            state.order(&[&pair[0], &pair[1]], &[], 0);
        }
    }

    /// What stands out where the parameters are at the medians of their priors, if the fit drives them far from there: about
    /// a fit that a strong effect has distorted, its linearisation may not look like it any more. The starts hold the parameters.
    pub(crate) fn leads_at_prior_medians(&self, problem: &Problem, baseline: &Refit) -> Result<Vec<Lead>, FitError> {
        let Some(medians) = self.medians_if_far(baseline) else { return Ok(Vec::new()) };
        let mut at_medians = baseline.clone();
        for (name, value) in at_medians.names.iter().zip(&mut at_medians.unknowns) {
            if let Some(&median) = medians.get(name) {
                *value = median;
            }
        }
        let mut leads = self.leads_beside(problem, &at_medians)?;
        for start in leads.iter_mut().flat_map(|lead| &mut lead.starts) {
            let screened_start = std::mem::replace(start, at_medians.by_name());
            start.extend(screened_start);
        }
        Ok(leads)
    }

    /// The medians of the priors of the baseline model's parameters, by name, where a fit drives one of these far from there. Effects
    /// that were added stay as they were fitted.
    fn medians_if_far(&self, fitted: &Refit) -> Option<BTreeMap<String, f64>> {
        let priors = self.problem.priors_of_unknowns();
        let is_far = (fitted.unknowns.iter().zip(&priors))
            .any(|(value, prior)| *value <= prior.quantile(PRIOR_EDGE) || *value >= prior.quantile(1.0 - PRIOR_EDGE));
        let medians = fitted.names.iter().cloned().zip(priors.iter().map(|prior| prior.quantile(0.5)));
        is_far.then(|| medians.collect())
    }

    /// Whether the tests find that something is missing.
    pub(crate) fn finds(&self, screening: &Screening) -> bool {
        screening.family.p <= self.settings.false_alarm
    }

    /// The sets to be fitted now; none: it is time to conclude.
    pub fn requests(&self, state: &State) -> Vec<FitRequest> {
        state.pending.clone()
    }

    /// Where the fit of a set starts, by the names of the unknowns.
    pub fn starts(&self, problem: &Problem, state: &State, request: &FitRequest) -> Vec<BTreeMap<String, f64>> {
        let base = state.refits.get(request.from).map(Refit::by_name).unwrap_or_default();
        let beside = |base: &BTreeMap<String, f64>, start: &BTreeMap<String, f64>| {
            let both = base.iter().chain(start).map(|(name, value)| (name.clone(), *value));
            both.collect::<BTreeMap<String, f64>>()
        };
        let mut starts: Vec<BTreeMap<String, f64>> = request.starts.iter().map(|start| beside(&base, start)).collect();
        // No slope may lead from where a strong effect that is missing has driven the parameters to where they are with it.
        if state.is_misspecified()
            && request.effects.len() == 1
            && request.from == 0
            && !problem.has_long_transients()
            && let Some(medians) = self.medians_if_far(&state.refits[0])
        {
            let own_start = |start: &&BTreeMap<String, f64>| !medians.keys().any(|name| start.contains_key(name));
            let at_medians = beside(&base, &medians);
            starts.extend(request.starts.iter().filter(own_start).map(|start| beside(&at_medians, start)));
        }
        starts
    }

    /// Fits a set.
    ///
    /// # Errors
    /// Why it cannot be fitted.
    pub fn refit(&self, state: &State, request: &FitRequest) -> Result<Refit, Unfitted> {
        let problem = self.at(state).with_noise(&state.noise, &state.most_steps);
        let starts = self.starts(&problem, state, request);
        // Where something is missing, the baseline model may be driven far from where its parameters are with the effect.
        let from_prior = usize::from(self.finds(&state.screening) && !state.is_misspecified());
        let widths = state.refits.get(request.from).map(Refit::widths).unwrap_or_default();
        // Effects that can only harm, as an exchange of channels, need not be fitted to the end.
        let least_log_likelihood = state.refits.first().map(|baseline| baseline.log_likelihood);
        let begin = Begin { starts, from_prior, scale: 1.0, widths, least_log_likelihood, is_near: false };
        problem.refit(&request.effects, &begin, &self.key).map_err(|error| {
            let ids = request.effects.iter().map(|&effect| problem.candidates[effect].id.clone());
            Unfitted { effects: ids.collect(), reason: error.to_string() }
        })
    }

    pub(crate) fn is_unknown_function(&self, effect: usize) -> bool {
        self.problem.is_unknown_function(effect)
    }

    /// Whether an effect is an unknown function in which several inputs meet, which is asked where no law of plausible size is found.
    pub(crate) fn is_last_resort(&self, effect: usize) -> bool {
        self.is_unknown_function(effect) && self.problem().candidates[effect].bound.len() > 1
    }

    /// Estimates the noise anew beside the best fitted effect or pair; before, it was estimated beside a linearised one. Where it
    /// changes, everything is screened and fitted again, as where nothing was screened yet. `None` where it stays.
    pub(crate) fn estimate_noise_again(&self, state: &State) -> Result<Option<State>, FitError> {
        let (noise, failure) = match self.noise_beside_best(state) {
            Ok(Some(noise)) => (Some(noise), None),
            // Where nothing was screened yet, all is to come.
            Ok(None) if state.is_unscreened() => (None, None),
            Err(why) if state.is_unscreened() => (None, Some(why)),
            other => return other.map(|_| None),
        };
        let is_changed = noise.is_some();
        let noise = noise.unwrap_or_else(|| state.noise.clone());
        let mut next = self.screen_with(&state.refits[0], noise, state.most_steps.clone())?;
        // After a pilot it is estimated once more, beside the best of all sets.
        next.rounds = if state.is_pilot { 0 } else { state.rounds };
        let warnings = std::mem::replace(&mut next.warnings, state.warnings.clone());
        warnings.into_iter().for_each(|why| next.warn(why));
        failure.into_iter().for_each(|why| next.warn(why));
        let failed = std::mem::replace(&mut next.failed, state.failed.clone());
        next.failed.extend(failed);
        let fitted = &state.refits[1..];
        let is_fitted = |request: &FitRequest| fitted.iter().any(|refit| refit.effects == request.effects);
        if !is_changed && !next.pending.iter().all(is_fitted) {
            next.pending.retain(|request| !is_fitted(request));
            next.refits.extend(fitted.iter().cloned());
            return Ok(Some(next));
        }
        for refit in fitted {
            let request = FitRequest { effects: refit.effects.clone(), starts: vec![refit.by_name()], from: 0 };
            if !next.is_known(&request.effects) {
                next.pending.push(request);
            }
        }
        Ok(Some(next))
    }

    /// The noise beside the best fitted effect or pair, where it is another one.
    fn noise_beside_best(&self, state: &State) -> Result<Option<Vec<SensorNoise>>, FitError> {
        let weights = posterior_odds(&self.problem, &state.refits, None);
        // An unknown function, or a third effect, could take noise for physics.
        let plain = |place: &usize| {
            let effects = &state.refits[*place].effects;
            (1..=2).contains(&effects.len()) && effects.iter().all(|&effect| !self.is_unknown_function(effect))
        };
        let better = |a: usize, b: usize| if weights.sets[b] > weights.sets[a] { b } else { a };
        let best = (0..state.refits.len()).filter(plain).reduce(better);
        let (false, Some(best)) = (state.noise.is_empty(), best) else { return Ok(None) };
        let best = &state.refits[best];
        let fixed: Vec<SensorNoise> = state.noise.iter().filter(|one| self.is_at_first(one)).copied().collect();
        let with = self.with_noise(&fixed, &state.most_steps).with(best)?;
        let (mut noise, _) = self.estimate_noise(&with, best, false)?;
        noise.extend(fixed);
        let changed = noise.iter().zip(&state.noise).any(|(new, old)| new.noise.differs(&old.noise));
        Ok(changed.then_some(noise))
    }

    /// Screens what a fitted set leaves.
    pub(crate) fn screen_beside(&self, problem: &Problem, refit: &Refit) -> Result<Screening, FitError> {
        let with = problem.with(refit)?;
        self.screen_problem(&with, refit, false)
    }

    /// The whole diagnosis, step after step.
    ///
    /// # Errors
    /// As [`Diagnosis::screen`].
    pub fn run(&self) -> Result<crate::diagnosis::Output, FitError> {
        let mut state = self.screen()?;
        loop {
            let requests = self.requests(&state);
            if requests.is_empty() {
                return Ok(self.conclude(&state));
            }
            let refits = requests.iter().map(|request| self.refit(&state, request)).collect();
            state.take(refits);
            state = self.extend(state);
        }
    }
}
