//! A hypothesis fitted to the data: evidence, amplitudes, errors on the rows that it saw and on those that it did not.

use crate::diagnosis::FitError;
use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::diagnosis::fits::other_noise::{self, Direction, directions};
use crate::diagnosis::fits::out_of_range::OUT_OF_RANGE;
use crate::diagnosis::fits::size::is_within_model;
use crate::diagnosis::fits::threshold_gaps::{Flat, together};
use crate::diagnosis::odds::narrow_prior::is_prior;
use crate::diagnosis::odds::prior_scale::{Amplitudes, IMPLAUSIBLE, WIDTHS};
use crate::diagnosis::reference_temperature::extended;
use crate::diagnosis::{Hypothesis, Problem};
use crate::document::packed;
use crate::effect::Site;
use crate::expression::Unit;
use crate::inference::estimate::point_estimate::{PointEstimate, PointSettings, estimate};
use crate::inference::estimate::truncated_moments::Moments;
use crate::inference::likelihood::Likelihood;
use crate::inference::target::Target;
use crate::math::functions::sqrt;
use crate::measurement::prediction::Predictor;
use crate::measurement::unknown::with_unknowns;
use crate::random::StreamKey;

/// A parameter of an effect after the fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Amplitude {
    /// Its name in the effect.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Most probable value, in the unit.
    pub mode: f64,
    /// Mean between the bounds of all parameters ([`crate::inference::estimate::truncated_moments`]), in the unit.
    pub mean: f64,
    /// Standard deviation between them, in the unit.
    pub sd: f64,
    /// Whether the fit pressed it against a bound.
    pub at_bound: bool,
}

/// A held-out reading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Position of the measurement.
    pub measurement: usize,
    /// Row.
    pub row: usize,
    /// Position of the sensor.
    pub sensor: usize,
    /// Reading minus prediction, SI.
    pub error: f64,
    /// Standard deviation of the noise, SI.
    pub sigma: f64,
}

/// A hypothesis at its most probable point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refit {
    /// Effects by their positions in the problem's list.
    pub effects: Vec<usize>,
    /// How many times as wide as the catalogue's each effect's priors are.
    pub widths: Vec<f64>,
    /// Of each effect whether it carries heat, and no more than the model moves; asked where its prior is wider than the catalogue's.
    pub within_model: Vec<bool>,
    /// Laplace log evidence, bounds considered; with the odds of the widths beforehand.
    pub log_evidence: f64,
    /// Log likelihood.
    pub log_likelihood: f64,
    /// Sum of squares of the whitened residuals.
    pub chi_square: f64,
    /// Most probable unknowns, SI: the model's parameters, the effects', what is inferred of the data.
    pub unknowns: Vec<f64>,
    /// Their names.
    pub names: Vec<String>,
    /// Which of the unknowns are held at a bound.
    pub held: Vec<bool>,
    /// What the data and the priors say along each direction of the free unknowns.
    pub directions: Vec<Direction>,
    /// Parameters of each effect.
    pub amplitudes: Vec<Vec<Amplitude>>,
    /// Whitened residuals of the readings that were fitted.
    #[serde(with = "packed")]
    pub residuals: Vec<f64>,
    /// Readings that were fitted minus predictions, SI, in the order of [`Problem::fitted_readings`].
    #[serde(with = "packed")]
    pub errors: Vec<f64>,
    /// Root mean square error of the fitted readings in K; `None` where no sensor is in kelvin.
    pub rmse_train_k: Option<f64>,
    /// The same of the held-out readings.
    pub rmse_held_out_k: Option<f64>,
    /// The held-out readings.
    pub held_out: Vec<HeldOut>,
    /// Points of the fit at which a transient took too many steps and was given up.
    #[serde(default)]
    pub given_up: u64,
}

/// Where a fit begins and how hard it tries.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Begin {
    /// Starts by name of the unknown, SI; the prior's median where a name is left out.
    pub starts: Vec<BTreeMap<String, f64>>,
    /// Further starts from the prior.
    pub from_prior: usize,
    /// Factor of the priors' scales of the effects' amplitudes.
    pub scale: f64,
    /// Widths of effects in the fit from which it starts: where the model is wrong everywhere, it begins with these.
    pub widths: BTreeMap<usize, f64>,
    /// A log likelihood that a fit of any use exceeds, such as that without the effects.
    pub least_log_likelihood: Option<f64>,
    /// Whether the starts come from a fit of the same set: long transients are not fitted on fewer rows first.
    pub is_near: bool,
}

/// Most steps of a descent.
const MOST_STEPS: u64 = 60;
/// Steps that gain less in log posterior density end it: sets differ by far more, and no estimate moves by a hundredth of its
/// standard deviation.
const LEAST_GAIN: f64 = 1e-5;
/// The same of transients, whose steps take a thousand times as long: a twentieth of a standard deviation.
const LEAST_GAIN_OF_TRANSIENTS: f64 = 1e-3;
/// The same of long ones, whose derivatives are of fewer rows: a fifth; two thirds where no step along these descends any more.
const LEAST_GAIN_OF_LONG_TRANSIENTS: f64 = 2e-2;
/// Log evidence that a curve with a wider prior may lack beside the model error that is allowed for. Where it halves the errors, the
/// model error that is left adds `n (ln 2 - 3/8)`: 10 where a record is worth 30 readings.
const MAY_LACK: f64 = 6.0;
/// Standard deviations of a size below which it is none.
const IS_NOTHING: f64 = 1e-6;
/// Attempted steps for each row of a transient after which effects have no prediction of it, held-out rows among these: a thermostat that cycles
/// every few seconds within rows of an hour takes some thousands. Where a fitted law makes held-out rows unstable, an integrator would
/// crawl through them for minutes.
const STEPS_A_ROW: u64 = 5000;
/// Times the usual local error of a step where a fit only begins: some millikelvins.
pub(crate) const TOLERANCE_ON_FEWER_ROWS: f64 = 10.0;

impl Problem {
    /// Fits the model with effects.
    ///
    /// The priors of its amplitudes are mixtures of widths: wider ones are fitted, narrower ones counted. Thresholds are
    /// sought in all gaps between the data's levels, and the evidence is the sum over them.
    ///
    /// # Errors
    /// Why there is no fit: effects that do not go together, a likelihood that cannot be evaluated.
    pub fn refit(&self, effects: &[usize], begin: &Begin, key: &StreamKey) -> Result<Refit, FitError> {
        together(self.refits_over_gaps(effects, begin, key)?).ok_or(FitError::NoFit)
    }

    /// Fits with thresholds where the starts, and what descends from there, have them. Without `moments` the amplitudes have
    /// the most probable values for means, and standard deviations by the curvature.
    pub(crate) fn refit_here(
        &self,
        effects: &[usize],
        begin: &Begin,
        key: &StreamKey,
        moments: bool,
    ) -> Result<Refit, FitError> {
        let fitted_width = |effect: &usize| begin.widths.get(effect).filter(|_| self.is_misspecified);
        let place = |width: &f64| {
            WIDTHS.iter().rposition(|prior_width| begin.scale * prior_width.factor <= *width).unwrap_or(0)
        };
        let mut places: Vec<usize> = effects.iter().map(|effect| fitted_width(effect).map_or(0, place)).collect();
        let (mut best, mut amplitudes) = self.refit_of_widths(effects, &places, begin, key, moments)?;
        let is_far = self.are_far(effects, begin);
        if self.is_misspecified
            && effects.iter().zip(&is_far).any(|(effect, is_far)| *is_far && fitted_width(effect).is_none())
        {
            // From far the written priors lead back to nothing.
            let far = places.iter().zip(&is_far).map(|(&place, &is_far)| if is_far { IMPLAUSIBLE } else { place });
            let far: Vec<usize> = far.collect();
            if let Ok(refit_from_far) = self.refit_of_widths(effects, &far, begin, key, moments)
                && refit_from_far.0.log_evidence > best.log_evidence
            {
                (best, amplitudes, places) = (refit_from_far.0, refit_from_far.1, far);
            }
        }
        let is_curve = |effect: &usize| self.is_unknown_function(*effect);
        // Five values cost more evidence beside a large model error than beside the smaller one that they leave.
        let may_lack = if self.independent_readings > 0.0 && effects.iter().any(is_curve) { MAY_LACK } else { 0.0 };
        let again = |best: &Refit, places: &[usize]| {
            let begin = Begin {
                starts: vec![best.by_name()],
                scale: begin.scale,
                least_log_likelihood: begin.least_log_likelihood,
                is_near: true,
                ..Begin::default()
            };
            let next = self.refit_of_widths(effects, places, &begin, key, moments);
            let more = |next: &(Refit, Amplitudes)| {
                self.log_evidence_of_own_noise(&next.0) > self.log_evidence_of_own_noise(best)
            };
            next.ok().filter(more)
        };
        for is_wider in [true, false] {
            loop {
                let others =
                    if is_wider { amplitudes.wider(&places, -may_lack) } else { amplitudes.less_wide(&places) };
                if others == places {
                    break;
                }
                let Some(better) = again(&best, &others) else { break };
                (best, amplitudes) = better;
                places = others;
            }
        }
        // A prior that is wider than the written one is none of the catalogue's, and no narrower one stands beside it.
        let place_at_least_written =
            |(&effect, &place): (&usize, &usize)| place.max(usize::from(is_prior(&self.candidates[effect])));
        best.log_evidence +=
            amplitudes.narrower(&effects.iter().zip(&places).map(place_at_least_written).collect::<Vec<usize>>());
        Ok(best)
    }

    /// Log evidence of a fit with the size of the model error that is most likely beside it in place of the one that is allowed for.
    pub(crate) fn log_evidence_of_own_noise(&self, refit: &Refit) -> f64 {
        other_noise::with_own_noise(refit.log_evidence, refit.chi_square, self.independent_readings, &refit.directions)
    }

    /// Of each effect whether a start has an amplitude beyond its written prior.
    fn are_far(&self, effects: &[usize], begin: &Begin) -> Vec<bool> {
        let Ok(hypothesis) = self.hypothesis(effects, begin.scale) else { return vec![false; effects.len()] };
        let is_far = |index: usize| {
            let (name, prior) = (&hypothesis.model.parameters[index].name, &hypothesis.priors[index]);
            let (least, most) = (prior.quantile(0.001), prior.quantile(0.999));
            begin.starts.iter().filter_map(|start| start.get(name)).any(|value| *value < least || *value > most)
        };
        hypothesis.amplitudes.iter().map(|range| range.clone().any(is_far)).collect()
    }

    fn refit_of_widths(
        &self,
        effects: &[usize],
        places: &[usize],
        begin: &Begin,
        key: &StreamKey,
        moments: bool,
    ) -> Result<(Refit, Amplitudes), FitError> {
        let widths: Vec<f64> = places.iter().map(|&place| begin.scale * WIDTHS[place].factor).collect();
        let hypothesis = self.hypothesis_of_widths(effects, &widths)?;
        let thinned = self.thinned(TOLERANCE_ON_FEWER_ROWS);
        let fewer = thinned.as_ref().filter(|thinned| effects.iter().all(|&effect| thinned.leads_to(effect)));
        let fewer = fewer.map(|thinned| (thinned, thinned.problem.hypothesis_of_widths(effects, &widths)));
        let fewer = fewer.and_then(|(thinned, on_fewer)| Some((thinned, on_fewer.ok()?)));
        let mut likelihood = hypothesis.likelihood(self)?;
        if let Some((thinned, on_fewer)) = &fewer {
            likelihood = likelihood.with_slopes_on(&thinned.slopes_on(&on_fewer.measurements));
        }
        let mut settings = PointSettings {
            starts: begin.from_prior,
            most_iterations: MOST_STEPS,
            least_gain: match (self.has_transients(), fewer.is_some()) {
                (false, _) => LEAST_GAIN,
                (true, false) => LEAST_GAIN_OF_TRANSIENTS,
                (true, true) => LEAST_GAIN_OF_LONG_TRANSIENTS,
            },
            findings: false,
            least_log_likelihood: begin.least_log_likelihood,
            moments,
            ..PointSettings::default()
        };
        let mut starts: Vec<Vec<f64>> = begin.starts.iter().map(|start| place(&likelihood, start)).collect();
        if !begin.is_near
            && let Some((thinned, on_fewer)) = &fewer
            && let Some(point) = point_on_fewer_rows(&thinned.problem, on_fewer, &settings, key, begin)
        {
            starts = vec![place(&likelihood, &point)];
            settings.starts = 0;
        }
        let point_estimate = estimate(&likelihood, &settings, key, &starts)?;
        let log_evidence =
            point_estimate.log_evidence.filter(|value| value.is_finite()).ok_or(FitError::NoCurvature)?;
        let widths_at = Amplitudes::at(&hypothesis, &point_estimate, &self.which_are_amplitudes(effects));
        // Laplace's evidence is too high where the likelihood is flat in a gap and falls beyond it, which no curvature tells.
        let flat = self.flat(effects, &likelihood, &point_estimate);
        let mut refit = Refit {
            effects: effects.to_vec(),
            widths,
            within_model: vec![false; effects.len()],
            log_evidence: log_evidence + flat.iter().map(|flat| flat.log_share).sum::<f64>(),
            log_likelihood: point_estimate.log_likelihood,
            chi_square: point_estimate.chi_square,
            held: point_estimate.held.iter().map(Option::is_some).collect(),
            directions: directions(&point_estimate, likelihood.priors()),
            amplitudes: amplitudes(&hypothesis, &likelihood, &point_estimate, &flat),
            given_up: point_estimate.work.rejections.given_up,
            unknowns: point_estimate.parameters,
            names: likelihood.names().to_vec(),
            residuals: point_estimate.residuals,
            errors: Vec::new(),
            rmse_train_k: None,
            rmse_held_out_k: None,
            held_out: Vec::new(),
        };
        refit.score(&hypothesis, &likelihood)?;
        self.weigh_sizes(&mut refit, places);
        refit.log_evidence -= OUT_OF_RANGE * self.values_out_of_range(&refit) as f64;
        Ok((refit, widths_at))
    }

    /// Adds the odds of the widths of a fit's priors. A size that carries no more heat than the model moves is as probable as another.
    fn weigh_sizes(&self, refit: &mut Refit, places: &[usize]) {
        let are_amplitudes = self.which_are_amplitudes(&refit.effects);
        for (position, &place) in places.iter().enumerate().filter(|(_, place)| **place > 0) {
            let effect = refit.effects[position];
            let flagged = refit.amplitudes[position].iter().zip(&are_amplitudes[position]);
            let amplitudes: Vec<&Amplitude> = flagged.filter(|(_, flag)| **flag).map(|(own, _)| own).collect();
            refit.within_model[position] = is_within_model(self, refit, effect, &amplitudes);
            if !refit.within_model[position] {
                let of_sensors = matches!(self.candidates[effect].site, Site::Sensors(_));
                refit.log_evidence += WIDTHS[place].log_odds(of_sensors);
            }
        }
    }

    /// The problem whose baseline model has the effects of a fit, with priors as wide as the fit took them. The candidates
    /// are the same.
    ///
    /// # Errors
    /// [`FitError::Apply`] where they do not fit.
    pub fn with(&self, fit: &Refit) -> Result<Problem, FitError> {
        let Hypothesis { model, priors, parameters, measurements, .. } =
            self.hypothesis_of_widths(&fit.effects, &fit.widths)?;
        let working_temperatures_k = Arc::new(extended(&model, &self.working_temperatures_k));
        Ok(Problem { model: Arc::new(model), priors, parameters, measurements, working_temperatures_k, ..self.clone() })
    }

    /// Of each effect's parameters, which are amplitudes.
    fn which_are_amplitudes(&self, effects: &[usize]) -> Vec<Vec<bool>> {
        let of = |&effect: &usize| {
            let candidate = &self.candidates[effect];
            if is_prior(candidate) {
                return vec![true];
            }
            let catalogue_effect = self.catalogue.get(&candidate.effect);
            let parameters = catalogue_effect
                .map(|catalogue_effect| catalogue_effect.parameters(&self.model, &candidate.bound))
                .unwrap_or_default();
            parameters.iter().map(|parameter| parameter.amplitude).collect()
        };
        effects.iter().map(of).collect()
    }
}

/// Where the fit of a hypothesis on fewer rows leads, by name of the unknown, SI. `None` where there is no fit.
fn point_on_fewer_rows(
    problem: &Problem,
    hypothesis: &Hypothesis,
    settings: &PointSettings,
    key: &StreamKey,
    begin: &Begin,
) -> Option<BTreeMap<String, f64>> {
    let likelihood = hypothesis.likelihood(problem).ok()?;
    let settings = PointSettings { least_log_likelihood: None, moments: false, ..settings.clone() };
    let starts: Vec<Vec<f64>> = begin.starts.iter().map(|start| place(&likelihood, start)).collect();
    let found = estimate(&likelihood, &settings, key, &starts).ok()?;
    Some(likelihood.names().iter().cloned().zip(found.parameters).collect())
}

/// A start's unknowns, SI: within the priors' support, at their medians where it says nothing.
pub(crate) fn place(likelihood: &Likelihood, start: &BTreeMap<String, f64>) -> Vec<f64> {
    let unknowns = likelihood.names().iter().zip(likelihood.priors());
    // A start may come from a set with a wider prior.
    let (least, most) = (1e-3, 1.0 - 1e-3);
    unknowns
        .map(|(name, prior)| match start.get(name).copied() {
            Some(value) if value < prior.support().0 => prior.quantile(least),
            Some(value) if value > prior.support().1 => prior.quantile(most),
            value => value.unwrap_or_else(|| prior.quantile(0.5)),
        })
        .collect()
}

fn amplitudes(
    hypothesis: &Hypothesis,
    likelihood: &Likelihood,
    point_estimate: &PointEstimate,
    flat: &[Flat],
) -> Vec<Vec<Amplitude>> {
    let full = likelihood.full_parameters(&point_estimate.parameters);
    let moments = point_estimate.truncated_moments.clone();
    let mut moments = moments.unwrap_or_else(|| by_curvature(likelihood, point_estimate));
    for flat in flat {
        [moments.mean[flat.place], moments.sd[flat.place]] = flat.moments();
    }
    let one = |index: usize| {
        let parameter = &hypothesis.model.parameters[index];
        let unit = Unit::parse(&parameter.unit).ok();
        let place = hypothesis.parameters.iter().position(|&inferred| inferred == index);
        let shown = |value: f64| unit.as_ref().map_or(value, |unit| unit.from_si(value));
        let spread = |value: f64| unit.as_ref().map_or(value, |unit| unit.difference_from_si(value));
        Amplitude {
            name: parameter.name.rsplit('.').next().unwrap_or(&parameter.name).to_owned(),
            unit: parameter.unit.clone(),
            mode: shown(full[index]),
            mean: shown(place.map_or(full[index], |place| moments.mean[place])),
            sd: place.map_or(0.0, |place| spread(moments.sd[place])),
            at_bound: place.is_some_and(|place| point_estimate.held[place].is_some()),
        }
    };
    hypothesis.amplitudes.iter().map(|range| range.clone().map(one).collect()).collect()
}

/// Moments where the normal approximation between bounds has none: the point, and standard deviations by the curvature. Of a variable
/// between two ends it is at most that of the uniform distribution there, which says nothing of it.
fn by_curvature(likelihood: &Likelihood, point_estimate: &PointEstimate) -> Moments {
    let widest = likelihood.priors().iter().map(|prior| {
        let (lower, upper) = prior.support();
        (upper - lower) / sqrt(12.0)
    });
    let sd = point_estimate.sd().into_iter().zip(widest).map(|(sd, widest)| sd.min(widest)).collect();
    Moments { mean: point_estimate.parameters.clone(), sd }
}

impl Refit {
    /// The widths of its effects' priors.
    pub fn widths(&self) -> BTreeMap<usize, f64> {
        self.effects.iter().copied().zip(self.widths.iter().copied()).collect()
    }

    /// Whether an effect of the set is larger than plausible: a hundred times, and its heat speaks for no such size.
    pub fn is_implausible(&self, effect: usize) -> bool {
        let least = WIDTHS[IMPLAUSIBLE].factor;
        let position = self.effects.iter().position(|&own| own == effect);
        position.is_some_and(|position| self.widths[position] >= least && !self.within_model[position])
    }

    /// Its unknowns by name, SI.
    pub fn by_name(&self) -> BTreeMap<String, f64> {
        self.names.iter().cloned().zip(self.unknowns.iter().copied()).collect()
    }

    /// Whether an effect of the set is above 0: its first parameter is.
    pub fn is_positive(&self, effect: usize) -> bool {
        let position = self.effects.iter().position(|&own| own == effect);
        position.and_then(|position| self.amplitudes[position].first()).is_some_and(|first| first.mean > 0.0)
    }

    /// Whether an effect of the set does nothing: its first parameter is 0, or too little to matter.
    pub fn does_nothing(&self, effect: usize) -> bool {
        let position = self.effects.iter().position(|&fitted_effect| fitted_effect == effect);
        let first = position.and_then(|position| self.amplitudes[position].first());
        first.is_some_and(|amplitude| amplitude.mode.abs() <= IS_NOTHING * amplitude.sd)
    }

    /// Predicts all rows at the fit and scores them.
    ///
    /// # Errors
    /// A row, held out perhaps, in which the model has no solution.
    fn score(&mut self, hypothesis: &Hypothesis, likelihood: &Likelihood) -> Result<(), FitError> {
        let most_steps = (!self.effects.is_empty()).then_some(STEPS_A_ROW);
        let predictor = Predictor::new(&hypothesis.model, &[])?.with_most_steps_a_row(most_steps);
        let full = likelihood.full_parameters(&self.unknowns);
        let names = likelihood.names();
        let find = |name: &str| names.iter().position(|unknown| unknown == name).map(|place| self.unknowns[place]);
        let inputs: Vec<String> = hypothesis.model.inputs.iter().map(|input| input.name.clone()).collect();
        let nodes: Vec<String> = hypothesis.model.nodes.iter().map(|node| node.name.clone()).collect();
        let mut workspace = predictor.workspace();
        let (mut train, mut held_out) = (Squares::default(), Squares::default());
        let (mut fitted, mut errors) = (Vec::new(), Vec::new());
        for (index, measurement) in hypothesis.measurements.iter().enumerate() {
            let fixed = with_unknowns(measurement, &inputs, &nodes, &find);
            let predicted = predictor.predict(&mut workspace, &fixed, &full).readings;
            let width = measurement.sensors.len();
            for row in (0..measurement.len()).filter(|&row| !measurement.ignored(row)) {
                for sensor in 0..width {
                    let Some(reading) = measurement.reading(row, sensor) else { continue };
                    let error = reading - predicted[row * width + sensor];
                    if !error.is_finite() {
                        // What has no solution where nothing was fitted predicts nothing there.
                        return Err(FitError::NoSolution { row: row + 1, measurement: measurement.name.clone() });
                    }
                    let kelvin = hypothesis.model.quantities[measurement.sensors[sensor].quantity].unit == "K";
                    if measurement.held_out(row) {
                        let sigma = fixed.sensors[sensor].total_sd();
                        errors.push(HeldOut { measurement: index, row, sensor, error, sigma });
                        held_out.add(kelvin, error);
                    } else {
                        fitted.push(error);
                        train.add(kelvin, error);
                    }
                }
            }
        }
        self.rmse_train_k = train.rmse();
        self.rmse_held_out_k = held_out.rmse();
        self.errors = fitted;
        self.held_out = errors;
        Ok(())
    }
}

#[derive(Default)]
struct Squares {
    sum: f64,
    count: usize,
}

impl Squares {
    fn add(&mut self, kelvin: bool, error: f64) {
        if kelvin {
            self.sum += error * error;
            self.count += 1;
        }
    }

    fn rmse(&self) -> Option<f64> {
        let rmse = (self.sum / self.count.max(1) as f64).sqrt();
        (self.count > 0 && rmse.is_finite()).then_some(rmse)
    }
}
