//! The gaps, between two levels of the fitted rows, in which a set has its thresholds. Within a gap the likelihood is flat, and no
//! slope leads from one to the next: they are fitted one after another, and the evidence is the sum over them.

use crate::diagnosis::FitError;
use crate::diagnosis::fits::refit::Begin;
use crate::diagnosis::linearisation::threshold_levels::{beside, gap, is_crossed, log_share};
use crate::diagnosis::{Problem, Refit};
use crate::effect::EffectParameter;
use crate::inference::estimate::point_estimate::PointEstimate;
use crate::inference::likelihood::Likelihood;
use crate::inference::target::Target;
use crate::math::functions::{exp, sqrt};
use crate::math::sum::log_sum_exp;
use crate::random::StreamKey;

/// Most gaps that are fitted for a set.
const MOST: usize = 24;
/// Falls of the log likelihood below that of the best gap at which the search goes no further.
const NEAR: f64 = 4.6;
/// Falls of the log evidence below that of the best gap at which a gap is unlikely.
const LIKELY: f64 = 4.6;

/// A threshold of a set.
struct Threshold {
    /// Position of the candidate that has it.
    candidate: usize,
    /// The effect's parameter.
    parameter: EffectParameter,
    /// Name of the unknown.
    name: String,
}

/// An unknown that the data place in a gap and no closer.
pub(crate) struct Flat {
    /// Its place among the unknowns.
    pub place: usize,
    /// The levels about it, SI.
    pub gap: [f64; 2],
    /// Logarithm of the share of its prior between them.
    pub log_share: f64,
}

impl Problem {
    /// The fits of a set, one for each gap that its thresholds may lie in; a single one without thresholds.
    ///
    /// # Errors
    /// As those of a fit.
    pub(crate) fn refits_over_gaps(
        &self,
        effects: &[usize],
        begin: &Begin,
        key: &StreamKey,
    ) -> Result<Vec<Refit>, FitError> {
        let thresholds = self.thresholds_of(effects);
        if thresholds.is_empty() {
            return Ok(vec![self.refit_here(effects, begin, key, true)?]);
        }
        let at = |start, from: &Refit| Begin {
            starts: vec![start],
            scale: begin.scale,
            widths: from.widths(),
            least_log_likelihood: begin.least_log_likelihood,
            is_near: true,
            ..Begin::default()
        };
        let mut refits = vec![self.refit_here(effects, begin, key, false)?];
        for threshold in thresholds {
            let highest = refits[best(&refits)].clone();
            let from = highest.by_name();
            for upwards in [false, true] {
                let mut value = from.get(&threshold.name).copied();
                while let Some(next) = value.and_then(|value| self.beside(&threshold, value)[usize::from(upwards)]) {
                    value = Some(next);
                    let mut start = from.clone();
                    start.insert(threshold.name.clone(), next);
                    let Ok(refit) = self.refit_here(effects, &at(start, &highest), key, false) else { break };
                    let highest = &refits[best(&refits)];
                    let is_near = refit.log_likelihood + NEAR >= highest.log_likelihood;
                    self.add(&mut refits, refit);
                    if !is_near || refits.len() >= MOST {
                        break;
                    }
                }
            }
        }
        // A threshold that no reading crosses is none: what changes then is what was there.
        let is_crossed = |refit: &Refit| {
            let fitted_values = refit.by_name();
            let mut all = self.thresholds_of(effects).into_iter();
            all.all(|threshold| {
                fitted_values.get(&threshold.name).is_some_and(|&value| self.is_crossed(&threshold, value))
            })
        };
        if refits.iter().any(is_crossed) {
            refits.retain(is_crossed);
        }
        // Moments take longer than fits; only those of likely gaps count.
        let highest = refits[best(&refits)].log_evidence;
        for refit in refits.iter_mut().filter(|refit| refit.log_evidence + LIKELY >= highest) {
            *refit = self.refit_here(effects, &at(refit.by_name(), refit), key, true)?;
        }
        Ok(refits)
    }

    /// Adds a fit; of two in the same gaps, as a descent may leave its own, the better one stays.
    fn add(&self, refits: &mut Vec<Refit>, refit: Refit) {
        let gaps = self.gaps_of(&refit);
        match refits.iter_mut().find(|refit_of_gaps| self.gaps_of(refit_of_gaps) == gaps) {
            Some(refit_of_gaps) if refit.log_evidence > refit_of_gaps.log_evidence => *refit_of_gaps = refit,
            Some(_) => {}
            None => refits.push(refit),
        }
    }

    /// Whether a set has thresholds that lie between levels.
    pub(crate) fn has_thresholds(&self, effects: &[usize]) -> bool {
        !self.thresholds_of(effects).is_empty()
    }

    /// The thresholds of a set that lie between levels.
    fn thresholds_of(&self, effects: &[usize]) -> Vec<Threshold> {
        let mut thresholds = Vec::new();
        for &position in effects {
            let candidate = &self.candidates[position];
            let Some(effect) = self.catalogue.get(&candidate.effect) else { continue };
            for parameter in effect.parameters(&self.model, &candidate.bound) {
                let is_one = !parameter.amplitude
                    && gap(self, candidate, effect, &parameter, parameter.prior.quantile(0.5)).is_some();
                if is_one {
                    let name = format!("{}.{}", candidate.id, parameter.name);
                    thresholds.push(Threshold { candidate: position, parameter, name });
                }
            }
        }
        thresholds
    }

    fn gap(&self, threshold: &Threshold, value: f64) -> Option<[f64; 2]> {
        let candidate = &self.candidates[threshold.candidate];
        gap(self, candidate, self.catalogue.get(&candidate.effect)?, &threshold.parameter, value)
    }

    fn beside(&self, threshold: &Threshold, value: f64) -> [Option<f64>; 2] {
        let candidate = &self.candidates[threshold.candidate];
        let effect = self.catalogue.get(&candidate.effect);
        effect.map_or([None; 2], |effect| beside(self, candidate, effect, &threshold.parameter, value))
    }

    /// Whether rows lie on both sides of a threshold.
    fn is_crossed(&self, threshold: &Threshold, value: f64) -> bool {
        let candidate = &self.candidates[threshold.candidate];
        let effect = self.catalogue.get(&candidate.effect);
        effect.is_some_and(|effect| is_crossed(self, candidate, effect, &threshold.parameter, value))
    }

    /// The gaps in which a fit has its thresholds, SI.
    fn gaps_of(&self, refit: &Refit) -> Vec<Option<[f64; 2]>> {
        let fitted_values = refit.by_name();
        let thresholds = self.thresholds_of(&refit.effects);
        thresholds.iter().map(|threshold| self.gap(threshold, *fitted_values.get(&threshold.name)?)).collect()
    }

    /// The thresholds of a fit that the data place in a gap and no closer. One that they see better is held where they say, and
    /// its curvature is known.
    pub(crate) fn flat(&self, effects: &[usize], likelihood: &Likelihood, point_estimate: &PointEstimate) -> Vec<Flat> {
        let sds = point_estimate.sd();
        let one = |threshold: Threshold| {
            let place = likelihood.names().iter().position(|name| *name == threshold.name)?;
            let gap = self.gap(&threshold, point_estimate.parameters[place])?;
            let log_share = log_share(&threshold.parameter, gap);
            let (lower, upper) = threshold.parameter.prior.support();
            let is_flat = sds[place] == 0.0 || sds[place] > exp(log_share) * (upper - lower);
            is_flat.then_some(Flat { place, gap, log_share })
        };
        self.thresholds_of(effects).into_iter().filter_map(one).collect()
    }
}

impl Flat {
    /// Mean and standard deviation in the gap, SI.
    pub fn moments(&self) -> [f64; 2] {
        let [below, above] = self.gap;
        [0.5 * (below + above), (above - below) / sqrt(12.0)]
    }
}

/// Position of the fit with the highest evidence.
fn best(refits: &[Refit]) -> usize {
    let better = |a: usize, b: usize| if refits[b].log_evidence > refits[a].log_evidence { b } else { a };
    (0..refits.len()).reduce(better).unwrap_or(0)
}

/// The best of the fits over the gaps, with the evidence of all of them, and with sizes that mix theirs. `None` of none.
pub(crate) fn together(mut refits: Vec<Refit>) -> Option<Refit> {
    if refits.len() < 2 {
        return refits.pop();
    }
    let logs: Vec<f64> = refits.iter().map(|refit| refit.log_evidence).collect();
    let total = log_sum_exp(&logs);
    let weights: Vec<f64> = logs.iter().map(|log| exp(log - total)).collect();
    let mut best = refits[best(&refits)].clone();
    best.log_evidence = total;
    for (effect, list) in best.amplitudes.iter_mut().enumerate() {
        for (place, amplitude) in list.iter_mut().enumerate().filter(|(_, amplitude)| !amplitude.at_bound) {
            let weighted_amplitudes =
                || weights.iter().zip(&refits).map(|(weight, refit)| (weight, &refit.amplitudes[effect][place]));
            let mean: f64 = weighted_amplitudes().map(|(weight, one)| weight * one.mean).sum();
            let square = |value: f64| value * value;
            let variance: f64 =
                weighted_amplitudes().map(|(weight, one)| weight * (square(one.sd) + square(one.mean - mean))).sum();
            (amplitude.mean, amplitude.sd) = (mean, sqrt(variance));
        }
    }
    Some(best)
}
