//! Hiding physics in a model: a truth is drawn, sized so that it leaves what was asked for when the baseline model is
//! refitted, and simulated.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::choice::{Chosen, OutsideDraw, draw_effect, draw_outside};
use super::draw::{Draw, short};
use super::finer::Finer;
use super::refit::{self, Refit};
use super::truth::{NoiseTruth, Truth};
use super::world::World;
use crate::diagnosis::{FitError, Problem};
use crate::math::functions::{exp, ln};
use crate::measurement::{Rows, Uncertain};

/// Why nothing was hidden.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum InjectError {
    /// Effects that do not go together, or a problem without a likelihood.
    #[error(transparent)]
    Hypothesis(FitError),
    /// No place for what was asked.
    #[error("there is no place for it in this model and test")]
    NoPlace,
    /// A truth without a solution, or at temperatures that nobody tests.
    #[error("the model has no plausible solution with it")]
    Implausible,
    /// A size that no amplitude within reach gives.
    #[error("no amplitude up to three times its plausible scale reaches the size {size}")]
    OutOfReach {
        /// The size asked for.
        size: f64,
    },
    /// A fit that fails.
    #[error("the refit of the baseline model failed: {0}")]
    Fit(String),
}

/// What is to be hidden.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InjectionRequest {
    /// Number of effects of the catalogue.
    pub effects: usize,
    /// Name of an effect, or id of a candidate: the first effect is one of these.
    pub only: Option<String>,
    /// Size to be left by the refit, in standard deviations; amplitudes are drawn from their priors without it.
    pub size: Option<f64>,
    /// Amplitude of the first effect, SI, instead of a size.
    pub amplitude: Option<f64>,
    /// Physics that the catalogue lacks, instead of effects.
    pub outside: bool,
    /// Size of what a network with finer nodes leaves by itself, in standard deviations, beside all else that is hidden: a law then, no
    /// unknown function.
    pub finer: Option<f64>,
    /// Whether noise is correlated in transients that do not say so; drawn with even odds if `None`.
    pub correlated: Option<bool>,
}

impl Default for InjectionRequest {
    fn default() -> Self {
        Self { effects: 1, only: None, size: Some(1.0), amplitude: None, outside: false, finer: None, correlated: None }
    }
}

/// Something hidden, and the readings without noise.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// What is true; rivals not yet looked for.
    pub truth: Truth,
    /// Readings without noise: by measurement, `rows x sensors`, SI.
    pub clean: Vec<Vec<f64>>,
    /// The baseline model refitted to them, its noise known.
    pub refit: Refit,
}

impl Hidden {
    /// The same in the believed network, where the truth's is finer.
    ///
    /// # Errors
    /// [`InjectError`] where it has no plausible solution there.
    pub(super) fn without_finer_nodes(&self, problem: &Problem) -> Result<Self, InjectError> {
        let problem = with_stated_noise(problem);
        let find = |id: &String| {
            problem.candidates.iter().position(|candidate| candidate.id == *id).ok_or(InjectError::NoPlace)
        };
        let effects: Vec<usize> =
            self.truth.effects.iter().map(|effect| find(&effect.id)).collect::<Result<_, InjectError>>()?;
        let values: Vec<f64> = self
            .truth
            .effects
            .iter()
            .flat_map(|effect| effect.parameters.iter().map(|parameter| parameter.value))
            .collect();
        let model_parameters: Vec<f64> = self.truth.parameters.iter().map(|(_, value)| *value).collect();
        let clean = World::new(&problem, &effects, &model_parameters, &values)?.readings()?;
        let likelihood = refit::likelihood(&problem, &clean)?;
        let refit = refit::fit(&likelihood, &[refit::start(&likelihood, &self.truth.parameters)])?;
        Ok(Self { truth: self.truth.clone(), clean, refit })
    }
}

/// A size is hit when it is this near, relatively.
const NEAR: f64 = 0.005;
/// Largest power outside the catalogue, W.
const MOST_OUTSIDE_W: f64 = 5.0;
/// Largest resistance within a node, K/W.
const MOST_COARSENESS_K_PER_W: f64 = 100.0;
/// Rounds of the search for a size.
const MOST_ROUNDS: usize = 24;
/// Least share of the largest factor.
const LEAST_SCALE: f64 = 1e-8;
/// Places tried before giving up.
const TRIES: usize = 40;
/// Places at which an effect that was asked for by name is too small, before giving up: a test that is too short for it is so
/// everywhere, and each place costs a fit.
const MOST_OUT_OF_REACH: usize = 4;
/// What a permutation of channels must leave to be a case, in standard deviations.
const LEAST_SWAP: f64 = 0.3;

/// The problem with the noise known at its nominal values: what sizes are measured with.
pub fn with_stated_noise(problem: &Problem) -> Problem {
    let mut stated = problem.clone();
    for sensor in stated.measurements.iter_mut().flat_map(|measurement| &mut measurement.sensors) {
        for value in [&mut sensor.sigma, &mut sensor.white, &mut sensor.correlation_time_s].into_iter().flatten() {
            *value = Uncertain::Known(value.nominal());
        }
    }
    stated
}

/// Draws a truth for a problem. The same draws come from the same `draw`.
///
/// # Errors
/// [`InjectError`], of the last try where several places were tried.
pub fn inject(problem: &Problem, request: &InjectionRequest, draw: &mut Draw) -> Result<Hidden, InjectError> {
    let problem = with_stated_noise(problem);
    let mut last = InjectError::NoPlace;
    let mut out_of_reach = 0;
    for _ in 0..TRIES {
        match attempt(&problem, request, draw) {
            Ok(hidden) => return Ok(hidden),
            Err(error) => last = error,
        }
        out_of_reach += usize::from(matches!(last, InjectError::OutOfReach { .. }));
        if request.only.is_some() && out_of_reach == MOST_OUT_OF_REACH {
            break;
        }
    }
    Err(last)
}

fn attempt(problem: &Problem, request: &InjectionRequest, draw: &mut Draw) -> Result<Hidden, InjectError> {
    let model_parameters = own_parameters(problem, draw);
    let noise = noise(problem, request, draw);
    let finer = request.finer.map(|size| (Finer::draw(problem, draw), size));
    let outside = if request.outside { Some(draw_outside(problem, draw)?) } else { None };
    let mut chosen = Vec::new();
    if outside.is_none() {
        for number in 0..request.effects {
            let only = request.only.as_deref().filter(|_| number == 0);
            chosen.push(draw_effect(problem, only, request.finer.is_some(), &chosen, draw)?);
        }
    }
    let scene = Scene {
        problem,
        model_parameters: &model_parameters,
        finer: finer.as_ref().map(|(finer, _)| finer),
        outside: outside.as_ref(),
    };
    let coarseness = match &finer {
        Some((_, size)) => {
            let form = |coarseness| Sizes { coarseness, ..Sizes::default() };
            scene.solve(*size, MOST_COARSENESS_K_PER_W, form, &[])?.0
        }
        None => 0.0,
    };
    let base = Sizes { coarseness, ..Sizes::default() };
    let mut alone = vec![0.0; chosen.len()];
    if chosen.len() > 1
        && let Some(size) = request.size
    {
        for (effect, alone) in chosen.iter_mut().zip(&mut alone) {
            if effect.has_amplitude() {
                let one = std::slice::from_ref(effect);
                let (scale, _) = scene.solve(size, effect.most(), |effects| Sizes { effects, ..base }, one)?;
                effect.scale(scale);
                *alone = size;
            }
        }
    }
    if let (Some(value), Some(effect)) = (request.amplitude, chosen.first_mut()) {
        effect.set(value);
    }
    let sized = outside.is_some() || chosen.iter().any(Chosen::has_amplitude);
    let asked = request.size.filter(|_| request.amplitude.is_none() && sized);
    let (scale, hidden) = match asked {
        Some(size) => {
            let most = chosen.iter().filter(|effect| effect.has_amplitude()).map(Chosen::most);
            let most = if outside.is_some() { MOST_OUTSIDE_W } else { most.fold(f64::INFINITY, f64::min) };
            let form = |scale: f64| match outside {
                Some(_) => Sizes { outside: scale, ..base },
                None => Sizes { effects: scale, ..base },
            };
            scene.solve(size, most, form, &chosen)?
        }
        None => {
            let at = Sizes { effects: 1.0, outside: 1.0, ..base };
            (1.0, scene.measure(at, &chosen, None)?)
        }
    };
    let (clean, refit) = hidden;
    if !chosen.is_empty() && !sized && request.only.is_none() && refit.size() < LEAST_SWAP {
        return Err(InjectError::NoPlace);
    }
    let effects = chosen.iter_mut().zip(alone).map(|(effect, alone)| {
        effect.scale(scale);
        effect.hidden(problem, alone * scale)
    });
    let truth = Truth {
        effects: effects.collect(),
        outside: outside.map(|(outside, ..)| outside),
        finer: request.finer,
        parameters: (problem.model.parameters.iter().zip(&model_parameters))
            .map(|(parameter, value)| (parameter.name.clone(), *value))
            .collect(),
        noise,
        size: refit.size(),
        asked,
        rivals: None,
    };
    Ok(Hidden { truth, clean, refit })
}

/// Values of the baseline model's parameters: chosen ones from their priors, others as they are.
fn own_parameters(problem: &Problem, draw: &mut Draw) -> Vec<f64> {
    (problem.model.parameters.iter().enumerate())
        .map(|(index, parameter)| match problem.priors.get(index) {
            // The same draws for each, so that one prior more does not move the others.
            Some(prior) => {
                let share = draw.share();
                if problem.parameters.contains(&index) {
                    prior.quantile(share)
                } else {
                    fixed(prior, parameter.nominal)
                }
            }
            None => parameter.nominal,
        })
        .collect()
}

fn fixed(prior: &crate::random::Distribution, nominal: f64) -> f64 {
    match prior {
        crate::random::Distribution::Fixed(value) => *value,
        _ => nominal,
    }
}

/// The noise of a case: correlated over two to thirty rows of the fastest transient, if at all, wholly in every second case
/// and in others with white noise beside it.
fn noise(problem: &Problem, request: &InjectionRequest, draw: &mut Draw) -> NoiseTruth {
    let rows = draw.scale(2.0, 30.0);
    let correlated = draw.happens(0.5);
    let share = if draw.happens(0.5) { 1.0 } else { draw.between(0.2, 1.0) };
    let steps = problem.measurements.iter().filter_map(|measurement| match &measurement.rows {
        Rows::Transient { inputs, .. } if inputs.times_s.len() > 1 => {
            let last = inputs.times_s.len() - 1;
            Some((inputs.times_s[last] - inputs.times_s[0]) / last as f64)
        }
        _ => None,
    });
    let step_s = steps.fold(f64::INFINITY, f64::min);
    if step_s.is_finite() && request.correlated.unwrap_or(correlated) {
        NoiseTruth::Correlated { correlation_time_s: short(rows * step_s), share: short(share) }
    } else {
        NoiseTruth::AsStated
    }
}

/// Factors of what is hidden.
#[derive(Clone, Copy, Debug, Default)]
struct Sizes {
    /// Of the effects' amplitudes.
    effects: f64,
    /// Of the power outside the catalogue, W.
    outside: f64,
    /// Resistance within the nodes, K/W.
    coarseness: f64,
}

/// Readings without noise by measurement, and the refit to them.
type Measured = (Vec<Vec<f64>>, Refit);

/// What a truth is made of beside its sizes.
struct Scene<'a> {
    problem: &'a Problem,
    model_parameters: &'a [f64],
    finer: Option<&'a Finer>,
    outside: Option<&'a OutsideDraw>,
}

impl Scene<'_> {
    /// Readings without noise, and the baseline model's refit to them: from the unknowns of a fit before where there is
    /// one, else from the truth and the priors' medians.
    fn measure(&self, sizes: Sizes, chosen: &[Chosen], before: Option<&[f64]>) -> Result<Measured, InjectError> {
        let effects: Vec<usize> = chosen.iter().map(|effect| effect.candidate).collect();
        let values: Vec<f64> = chosen.iter().flat_map(|effect| effect.scaled(sizes.effects)).collect();
        let mut world = World::new(self.problem, &effects, self.model_parameters, &values)?;
        if let Some((outside, phase, switch)) = self.outside {
            world.add_outside(outside, *phase, switch)?;
        }
        if let Some(finer) = self.finer {
            world.refine(finer)?;
        }
        for (place, value) in [(world.outside, sizes.outside), (world.coarseness, sizes.coarseness)] {
            if let Some(place) = place {
                world.parameters[place] = value;
            }
        }
        let clean = world.readings()?;
        let likelihood = refit::likelihood(self.problem, &clean)?;
        let names = self.problem.model.parameters.iter().zip(self.model_parameters);
        let values: Vec<(String, f64)> = names.map(|(parameter, value)| (parameter.name.clone(), *value)).collect();
        let refit = match before {
            Some(before) => refit::fit(&likelihood, &[before.to_vec()])?,
            None => refit::fit(&likelihood, &[refit::start(&likelihood, &values), refit::start(&likelihood, &[])])?,
        };
        Ok((clean, refit))
    }

    /// The factor at which the refit leaves a size: safeguarded false position in the logarithms, from the largest
    /// factor down.
    fn solve(
        &self,
        size: f64,
        most: f64,
        form: impl Fn(f64) -> Sizes,
        chosen: &[Chosen],
    ) -> Result<(f64, Measured), InjectError> {
        let out_of_reach = InjectError::OutOfReach { size };
        let (mut below, mut above): (Option<[f64; 2]>, Option<[f64; 2]>) = (None, None);
        let mut scale = most;
        let mut before: Option<Vec<f64>> = None;
        for round in 0..MOST_ROUNDS {
            match self.measure(form(scale), chosen, before.as_deref()) {
                Ok((clean, refit)) => {
                    let mut measured = (clean, refit);
                    if (measured.1.size() / size - 1.0).abs() < NEAR && before.is_some() {
                        // A fit from elsewhere may leave less.
                        measured = self.measure(form(scale), chosen, None)?;
                    }
                    let ratio = measured.1.size() / size;
                    if (ratio - 1.0).abs() < NEAR {
                        return Ok((scale, measured));
                    }
                    let point = Some([ln(scale), ln(ratio.max(1e-12))]);
                    if ratio < 1.0 {
                        below = point
                    } else {
                        above = point
                    }
                    before = Some(measured.1.unknowns);
                }
                Err(InjectError::Implausible | InjectError::Fit(_)) => {
                    above = Some([ln(scale), f64::INFINITY]);
                    before = None;
                }
                Err(error) => return Err(error),
            }
            scale = match (below, above) {
                (Some([x, _]), Some([y, _])) if (y - x).abs() < 1e-4 => return Err(out_of_reach),
                (Some([x, _]), Some([y, v])) if !v.is_finite() || round % 4 == 3 => exp(0.5 * (x + y)),
                (Some([x, u]), Some([y, v])) => exp(x - u * (y - x) / (v - u)),
                (None, Some([y, v])) if v.is_finite() => exp(y - v.clamp(0.01, ln(30.0))),
                (None, Some([y, _])) => exp(y - ln(4.0)),
                // Too little at the largest factor.
                (_, None) => return Err(out_of_reach),
            };
            if scale < LEAST_SCALE * most {
                return Err(out_of_reach);
            }
        }
        Err(out_of_reach)
    }
}
