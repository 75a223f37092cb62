//! The law of a sensor's discrepancy: all laws fitted and scored, the simplest that does about as well as the best taken.
//!
//! A law is scored by the log densities of readings left out, with hyperparameters that did not see them. A more complex one is
//! taken only where it is ahead of the simpler one by more than the standard error of the difference, reading by reading (the
//! rule of one standard error, Breiman et al. 1984, Classification and Regression Trees, section 3.4.3).

use super::output::{Check, Curve, Hyperparameter, Law, LawScore, PhaseResidual, SensorDiscrepancy};
use crate::inference::gaussian_process::confounding::Information;
use crate::inference::gaussian_process::cross_validation::{left_out, score};
use crate::inference::gaussian_process::fit::{Fit, Search, fit};
use crate::inference::gaussian_process::process::{LeftOut, Process};
use crate::inference::gaussian_process::tested_range::TestedRange;
use crate::inference::gaussian_process::{Form, Kernel, Training, Trend, hyperparameters};
use crate::job::JobError;
use crate::math::functions::ln;
use crate::math::special::ln_normal_density;
use crate::random::StreamKey;
use crate::statistics::quantile::{quantile_sorted, sorted};

use super::expected::scaled;

/// Descents from further starts.
const FURTHER: usize = 6;
/// Half of a 95 % interval, in standard deviations.
const HALF_WIDTH: f64 = 1.959_963_984_540_054;
/// Points of a curve.
const CURVE_POINTS: u32 = 41;
/// R-hat above which draws of hyperparameters count as not converged.
const LARGEST_R_HAT: f64 = 1.05;

/// What a sensor's law is fitted to, and how.
pub(super) struct Question<'q> {
    /// Sensor, quantity, SI unit.
    pub names: [&'q str; 3],
    /// Residuals; what is expected of them is not filled in yet.
    pub residuals: Vec<PhaseResidual>,
    /// The inputs, with what was tested of them.
    pub ranges: &'q [TestedRange],
    /// Covariance and trend of the Gaussian process.
    pub kernel: Kernel,
    pub trend: Trend,
    /// The law, where it is not chosen.
    pub law: Option<Law>,
    /// Whether hyperparameters are drawn.
    pub sampled: bool,
    /// Of the random numbers.
    pub key: StreamKey,
}

/// A law that was fitted.
struct Fitted {
    law: Law,
    form: Form,
    fit: Fit,
    left_out: Vec<LeftOut>,
}

impl Question<'_> {
    /// Fits, scores and takes a law. The second value is what the readings say of the unknowns beside a free Gaussian process;
    /// `None` where it could not be fitted or a reading has no noise.
    pub fn answer(mut self) -> Result<(SensorDiscrepancy, Option<Information>), JobError> {
        let failed = |reason: String| JobError::Failed(format!("sensor `{}`: {reason}", self.names[0]));
        let behind: Vec<usize> = (0..self.residuals.len()).filter(|&i| !self.residuals[i].held_out).collect();
        let training = Training::new(
            self.ranges.len(),
            behind.iter().flat_map(|&i| scaled(self.ranges, &self.residuals[i].inputs)).collect(),
            behind.iter().map(|&i| self.residuals[i].residual).collect(),
            behind.iter().map(|&i| self.residuals[i].noise_sd * self.residuals[i].noise_sd).collect(),
        )
        .map_err(|error| failed(error.to_string()))?;
        let mut scores = Vec::new();
        let mut fitted_laws: Vec<Fitted> = Vec::new();
        for law in Law::ALL {
            let (refused, fitted) = match self.fitted(&training, law) {
                Ok(fitted) => (None, Some(fitted)),
                Err(reason) => (Some(reason), None),
            };
            scores.push(self.score(&training, law, refused, fitted.as_ref()));
            fitted_laws.extend(fitted);
        }
        compare(&mut scores, &fitted_laws);
        let (taken, because) = match self.law {
            Some(law) => {
                let refused = scores.iter().find(|own| own.law == law).and_then(|own| own.refused.clone());
                if let Some(reason) = refused {
                    return Err(failed(format!("the law `{}` cannot be fitted: {reason}", law.words())));
                }
                (law, "the study asks for it".to_owned())
            }
            None => choose(&scores).ok_or_else(|| failed("no law can be fitted to the residuals".to_owned()))?,
        };
        let position = fitted_laws.iter().position(|fitted| fitted.law == taken);
        let Some(taken) = position.map(|position| &fitted_laws[position]) else {
            return Err(failed("no law can be fitted to the residuals".to_owned()));
        };
        let mut findings = Vec::new();
        let (draws, r_hat) = self.draws(&training, taken, &mut findings);
        let processes = draws.iter().map(|draw| Process::new(training.clone(), taken.form, draw));
        let processes: Vec<Process> = processes.collect::<Result<_, _>>().map_err(|error| failed(error.to_string()))?;
        for (&place, own) in behind.iter().zip(&taken.left_out) {
            (self.residuals[place].expected, self.residuals[place].expected_sd) = (own.mean, own.sd);
        }
        for place in (0..self.residuals.len()).filter(|place| !behind.contains(place)) {
            let noise = self.residuals[place].noise_sd;
            let (mean, sd) = mixture(&processes, &scaled(self.ranges, &self.residuals[place].inputs));
            self.residuals[place].expected = mean;
            self.residuals[place].expected_sd = (sd * sd + noise * noise).sqrt();
        }
        let check = |held_out: bool| checked(self.residuals.iter().filter(|residual| residual.held_out == held_out));
        let (left_out, held_out) = (check(false), check(true));
        for (what, own) in [("left out one by one", left_out), ("held out", held_out)] {
            // About four standard errors of a root mean square.
            if own.count >= 5 && own.rms > 1.0 + 4.0 / (2.0 * own.count as f64).sqrt() {
                findings.push(format!(
                    "readings {what} lie farther from what the law foretells than it says: {} times its standard deviation",
                    two(own.rms)
                ));
            }
        }
        if taken.fit.at_bound.iter().any(|&place| place == 0 && taken.form.kernel.is_some()) {
            findings.push("the size of the process ended at a bound of the search".to_owned());
        }
        let free = fitted_laws.iter().find(|fitted| fitted.law == Law::GaussianProcess);
        let information = free.and_then(|free| {
            let process = Process::new(training.clone(), free.form, &free.fit.hyperparameters).ok()?;
            let noise = training.noise();
            // Slopes of predicted readings are those of residuals with the other sign.
            let slopes =
                behind.iter().map(|&i| self.residuals[i].slopes.iter().map(|s| -s).collect()).collect::<Vec<_>>();
            noise
                .iter()
                .all(|variance| *variance > 0.0)
                .then(|| Information::new(&process.precision(), noise, &slopes, training.values()))
        });
        let hyperparameters = self.by_name(taken, &processes, &draws);
        let curves = self.curves(&processes);
        let [sensor, quantity, unit] = self.names.map(str::to_owned);
        let (law, form, descents) = (taken.law, taken.form, taken.fit.descents);
        let answer = SensorDiscrepancy {
            sensor,
            quantity,
            unit,
            law,
            because,
            laws: scores,
            form,
            draws,
            r_hat,
            hyperparameters,
            descents,
            residuals: self.residuals,
            left_out,
            held_out,
            curves,
            findings,
        };
        Ok((answer, information))
    }

    fn fitted(&self, training: &Training, law: Law) -> Result<Fitted, String> {
        if law == Law::GaussianProcess && self.ranges.is_empty() {
            return Err("no input varies".to_owned());
        }
        let form = law.form(self.kernel, self.trend);
        let search = Search::usual(training, &form, FURTHER);
        let fit = fit(training, &form, &search, &self.key).map_err(|error| error.to_string())?;
        let left_out = left_out(training, &form, &search.bounds, &fit.hyperparameters, &self.key);
        Ok(Fitted { law, form, fit, left_out: left_out.map_err(|error| error.to_string())? })
    }

    fn score(&self, training: &Training, law: Law, refused: Option<String>, fitted: Option<&Fitted>) -> LawScore {
        let densities: Option<Vec<f64>> =
            fitted.map(|fitted| fitted.left_out.iter().map(|own| own.log_density).collect());
        let own = densities.as_ref().map(|densities| score(densities));
        let process =
            fitted.and_then(|fitted| Process::new(training.clone(), fitted.form, &fitted.fit.hyperparameters).ok());
        let held_out = self.residuals.iter().filter(|residual| residual.held_out);
        let held_out: Vec<f64> = process
            .iter()
            .flat_map(|process| {
                held_out.clone().map(|residual| {
                    let (mean, sd) = mixture(std::slice::from_ref(process), &scaled(self.ranges, &residual.inputs));
                    let total = (sd * sd + residual.noise_sd * residual.noise_sd).sqrt();
                    ln_normal_density((residual.residual - mean) / total) - ln(total)
                })
            })
            .collect();
        LawScore {
            law,
            refused,
            score: own.map(|own| own.0),
            score_se: own.map(|own| own.1),
            behind: None,
            behind_se: None,
            held_out_score: (!held_out.is_empty()).then(|| held_out.iter().sum::<f64>()).filter(|sum| sum.is_finite()),
            log_marginal_likelihood: fitted.map(|fitted| fitted.fit.log_likelihood),
        }
    }

    /// Draws of the hyperparameters, or the fitted ones.
    fn draws(&self, training: &Training, taken: &Fitted, findings: &mut Vec<String>) -> (Vec<Vec<f64>>, Option<f64>) {
        let fitted = vec![taken.fit.hyperparameters.clone()];
        if !self.sampled || taken.fit.hyperparameters.is_empty() {
            return (fitted, None);
        }
        match hyperparameters::sample(training, &taken.form, &taken.fit.hyperparameters, &self.key) {
            Ok(sampled) => {
                if !sampled.r_hat.is_some_and(|r_hat| r_hat <= LARGEST_R_HAT) {
                    let text = sampled.r_hat.map_or_else(|| "has no value".to_owned(), two);
                    findings.push(format!("the chains of the hyperparameters did not converge: R-hat {text}"));
                }
                (sampled.draws, sampled.r_hat)
            }
            Err(error) => {
                findings.push(format!("the hyperparameters could not be drawn ({error}): those fitted stand alone"));
                (fitted, None)
            }
        }
    }

    fn by_name(&self, taken: &Fitted, processes: &[Process], draws: &[Vec<f64>]) -> Vec<Hyperparameter> {
        let unit = self.names[2];
        let exp = crate::math::functions::exp;
        let mut named = Vec::new();
        let widths: Vec<f64> = self.ranges.iter().map(|range| range.upper - range.lower).collect();
        let lengths = if taken.form.kernel.is_some() { widths.len() } else { 0 };
        for (place, fitted) in taken.fit.hyperparameters.iter().enumerate() {
            let is_length = taken.form.kernel.is_some() && (1..=lengths).contains(&place);
            let is_size = place == 0 && taken.form.kernel.is_some();
            let is_scatter = !(is_length || is_size);
            let value = |logarithm: f64| {
                if is_length { exp(logarithm) * widths[place - 1] } else { exp(0.5 * logarithm) }
            };
            let (name, unit) = if is_length {
                let range = &self.ranges[place - 1];
                (format!("length in {}", range.input), range.unit.clone())
            } else {
                (if is_scatter { "scatter" } else { "standard deviation" }.to_owned(), unit.to_owned())
            };
            let column = sorted(&draws.iter().map(|draw| value(draw[place])).collect::<Vec<_>>());
            let interval = (draws.len() > 1).then(|| [0.025, 0.975].map(|share| quantile_sorted(&column, share)));
            let at_bound = taken.fit.at_bound.contains(&place);
            named.push(Hyperparameter { name, unit, value: value(*fitted), interval, at_bound });
        }
        let coefficients = processes.first().map_or(0, |process| process.trend().len());
        for place in 0..coefficients {
            let mean = processes.iter().map(|process| process.trend()[place]).sum::<f64>() / processes.len() as f64;
            let (name, unit) = match place.checked_sub(1).map(|input| &self.ranges[input]) {
                None => ("constant".to_owned(), unit.to_owned()),
                Some(range) => (format!("slope over the range of {}", range.input), unit.to_owned()),
            };
            named.push(Hyperparameter { name, unit, value: mean, interval: None, at_bound: false });
        }
        named
    }

    fn curves(&self, processes: &[Process]) -> Vec<Curve> {
        let curve = |input: usize| {
            let range = &self.ranges[input];
            let mut curve = Curve {
                input: range.input.clone(),
                unit: range.unit.clone(),
                at: vec![],
                mean: vec![],
                lower: vec![],
                upper: vec![],
            };
            for step in 0..CURVE_POINTS {
                let share = f64::from(step) / f64::from(CURVE_POINTS - 1);
                let mut point = vec![0.5; self.ranges.len()];
                point[input] = share;
                let (mean, sd) = mixture(processes, &point);
                curve.at.push(range.lower + share * (range.upper - range.lower));
                curve.mean.push(mean);
                curve.lower.push(mean - HALF_WIDTH * sd);
                curve.upper.push(mean + HALF_WIDTH * sd);
            }
            curve
        };
        (0..self.ranges.len()).map(curve).collect()
    }
}

/// Mean and standard deviation over draws of the hyperparameters, scatter included.
fn mixture(processes: &[Process], point: &[f64]) -> (f64, f64) {
    let expected: Vec<_> = processes.iter().map(|process| process.at(point)).collect();
    let count = expected.len().max(1) as f64;
    let mean = expected.iter().map(|own| own.mean).sum::<f64>() / count;
    let square = expected.iter().map(|own| own.variance + own.scatter + (own.mean - mean) * (own.mean - mean));
    (mean, (square.sum::<f64>() / count).max(0.0).sqrt())
}

/// How standardised errors lie.
fn checked<'r>(residuals: impl Iterator<Item = &'r PhaseResidual>) -> Check {
    let errors: Vec<f64> = residuals
        .map(|own| (own.residual - own.expected) / own.expected_sd)
        .filter(|error| error.is_finite())
        .collect();
    let count = errors.len().max(1) as f64;
    Check {
        count: errors.len() as u64,
        mean: errors.iter().sum::<f64>() / count,
        rms: (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt(),
        inside: errors.iter().filter(|error| error.abs() <= HALF_WIDTH).count() as u64,
    }
}

/// Holds the laws against the best.
fn compare(scores: &mut [LawScore], fitted: &[Fitted]) {
    let densities = |law: Law| fitted.iter().find(|own| own.law == law).map(|own| &own.left_out);
    let best = scores
        .iter()
        .filter(|own| own.score.is_some())
        .max_by(|a, b| a.score.unwrap_or(f64::NEG_INFINITY).total_cmp(&b.score.unwrap_or(f64::NEG_INFINITY)));
    let Some(best) = best.and_then(|own| densities(own.law)) else { return };
    for own in scores.iter_mut() {
        let Some(other) = densities(own.law) else { continue };
        let differences: Vec<f64> = best.iter().zip(other).map(|(a, b)| a.log_density - b.log_density).collect();
        let (behind, error) = score(&differences);
        (own.behind, own.behind_se) = (Some(behind), Some(error));
    }
}

/// The simplest law that is not behind the best by more than the standard error of the difference.
fn choose(scores: &[LawScore]) -> Option<(Law, String)> {
    let taken =
        scores.iter().find(|own| own.behind.zip(own.behind_se).is_some_and(|(behind, error)| behind <= error))?;
    let best = scores.iter().find(|own| own.behind == Some(0.0)).unwrap_or(taken);
    let because = if taken.law == best.law {
        "it foretells readings left out best".to_owned()
    } else {
        format!(
            "the simplest that foretells readings left out about as well as the best ({}), {} behind with a standard error of {}",
            best.law.words(),
            two(taken.behind.unwrap_or(0.0)),
            two(taken.behind_se.unwrap_or(0.0))
        )
    };
    Some((taken.law, because))
}

/// A number with two decimals.
pub(super) fn two(value: f64) -> String {
    format!("{value:.2}")
}
