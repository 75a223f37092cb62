//! Which law a sensor's discrepancy has: all laws fitted and scored, the simplest that does about as well as the best chosen; or
//! the one that was inferred together with the parameters.
//!
//! A law is scored by the log densities of readings left out, with hyperparameters that did not see them. A more complex one is
//! chosen only where it is ahead of the simpler one by more than the standard error of the difference, reading by reading (the
//! rule of one standard error, Breiman et al. 1984, Classification and Regression Trees, section 3.4.3).

use super::expected::scaled;
use super::laws::{Given, Question, mixture, two};
use super::output::{Law, LawScore};
use crate::inference::gaussian_process::cross_validation::{left_out, score};
use crate::inference::gaussian_process::fit::{Fit, Search, fit};
use crate::inference::gaussian_process::process::{LeftOut, Process};
use crate::inference::gaussian_process::{Form, GaussianProcessError, Training, hyperparameters};
use crate::math::functions::ln;
use crate::math::special::ln_normal_density;
use crate::statistics::quantile::{quantile_sorted, sorted};

/// Descents from further starts.
const FURTHER: usize = 6;
/// R-hat above which draws of hyperparameters count as not converged.
const LARGEST_R_HAT: f64 = 1.05;

/// A law with its hyperparameters.
pub(super) struct Chosen {
    pub law: Law,
    pub form: Form,
    /// Why this law.
    pub because: String,
    /// All laws that were scored.
    pub scores: Vec<LawScore>,
    /// Draws of the hyperparameters; one where they are not drawn.
    pub draws: Vec<Vec<f64>>,
    pub r_hat: Option<f64>,
    /// The most probable hyperparameters; of draws with the parameters their medians.
    pub central: Vec<f64>,
    /// Hyperparameters that ended at a bound of the search.
    pub at_bound: Vec<usize>,
    /// Descents of the search, and how many agreed.
    pub descents: [u64; 2],
    /// Each value from the others.
    pub left_out: Vec<LeftOut>,
    /// A Gaussian process with its hyperparameters, as it is or would be free beside the parameters.
    pub free: Option<(Form, Vec<f64>)>,
    /// Warnings.
    pub findings: Vec<String>,
}

/// A law that was fitted.
struct Fitted {
    law: Law,
    form: Form,
    fit: Fit,
    left_out: Vec<LeftOut>,
}

impl Question<'_> {
    /// Fits and scores all laws, and takes one.
    pub(super) fn chosen(&self, training: &Training) -> Result<Chosen, String> {
        let mut scores = Vec::new();
        let mut fitted_laws: Vec<Fitted> = Vec::new();
        for law in Law::ALL {
            let (refused, fitted) = match self.fitted(training, law) {
                Ok(fitted) => (None, Some(fitted)),
                Err(reason) => (Some(reason), None),
            };
            scores.push(self.score(training, law, refused, fitted.as_ref()));
            fitted_laws.extend(fitted);
        }
        compare(&mut scores, &fitted_laws);
        let (chosen, because) = match self.law {
            Some(law) => {
                let refused = scores.iter().find(|own| own.law == law).and_then(|own| own.refused.clone());
                if let Some(reason) = refused {
                    return Err(format!(
                        "the law `{}`, which `law` asks for, cannot be fitted to the residuals: {reason}; without `law` the \
                         simplest one that describes them is taken",
                        law.words()
                    ));
                }
                (law, "the study asks for it".to_owned())
            }
            None => choose(&scores).ok_or_else(|| "no law can be fitted to the residuals".to_owned())?,
        };
        let free = fitted_laws.iter().find(|fitted| fitted.law == Law::GaussianProcess);
        let free = free.map(|free| (free.form, free.fit.hyperparameters.clone()));
        let position = fitted_laws.iter().position(|fitted| fitted.law == chosen);
        let chosen = position.map(|position| fitted_laws.swap_remove(position));
        let chosen = chosen.ok_or_else(|| "no law can be fitted to the residuals".to_owned())?;
        let mut findings = Vec::new();
        let (draws, r_hat) = self.draws(training, &chosen, &mut findings);
        Ok(Chosen {
            law: chosen.law,
            form: chosen.form,
            because,
            scores,
            draws,
            r_hat,
            central: chosen.fit.hyperparameters,
            at_bound: chosen.fit.at_bound,
            descents: chosen.fit.descents,
            left_out: chosen.left_out,
            free,
            findings,
        })
    }

    /// The law whose hyperparameters were drawn together with the parameters.
    pub(super) fn drawn_together(&self, training: &Training, given: Given<'_>) -> Result<Chosen, String> {
        let Given { law, draws, r_hat } = given;
        let form = law.form(self.kernel, self.trend);
        let column = |place: usize| sorted(&draws.iter().map(|draw| draw[place]).collect::<Vec<_>>());
        let central: Vec<f64> =
            (0..form.hyperparameters(training.inputs())).map(|place| quantile_sorted(&column(place), 0.5)).collect();
        let of = |draw: &Vec<f64>| Ok(Process::new(training.clone(), form, draw)?.left_out());
        let all = draws.iter().map(of).collect::<Result<Vec<Vec<LeftOut>>, GaussianProcessError>>();
        let all = all.map_err(|error| error.to_string())?;
        let count = all.len().max(1) as f64;
        let over_draws = |place: usize| {
            let mean = all.iter().map(|own| own[place].mean).sum::<f64>() / count;
            let square = all
                .iter()
                .map(|own| own[place].sd * own[place].sd + (own[place].mean - mean) * (own[place].mean - mean));
            let sd = (square.sum::<f64>() / count).sqrt();
            let standardised = (training.values()[place] - mean) / sd;
            LeftOut { mean, sd, log_density: ln_normal_density(standardised) - ln(sd), standardised }
        };
        let left_out: Vec<LeftOut> = (0..training.len()).map(over_draws).collect();
        let (own_score, own_error) = score(&left_out.iter().map(|own| own.log_density).collect::<Vec<_>>());
        let scored = LawScore {
            law,
            refused: None,
            score: Some(own_score),
            score_se: Some(own_error),
            behind: None,
            behind_se: None,
            held_out_score: None,
            log_marginal_likelihood: None,
        };
        Ok(Chosen {
            law,
            form,
            because: "inferred together with the parameters".to_owned(),
            scores: vec![scored],
            draws: draws.to_vec(),
            r_hat,
            free: (law == Law::GaussianProcess).then(|| (form, central.clone())),
            central,
            at_bound: Vec::new(),
            descents: [0, 0],
            left_out,
            findings: Vec::new(),
        })
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
    fn draws(&self, training: &Training, chosen: &Fitted, findings: &mut Vec<String>) -> (Vec<Vec<f64>>, Option<f64>) {
        let fitted = vec![chosen.fit.hyperparameters.clone()];
        if !self.sampled || chosen.fit.hyperparameters.is_empty() {
            return (fitted, None);
        }
        let priors = hyperparameters::priors(training, &chosen.form, self.beforehand);
        match hyperparameters::sample(training, &chosen.form, priors, &chosen.fit.hyperparameters, &self.key) {
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
    let chosen =
        scores.iter().find(|own| own.behind.zip(own.behind_se).is_some_and(|(behind, error)| behind <= error))?;
    let best = scores.iter().find(|own| own.behind == Some(0.0)).unwrap_or(chosen);
    let because = if chosen.law == best.law {
        "it predicts readings left out best".to_owned()
    } else {
        format!(
            "the simplest that predicts readings left out about as well as the best ({}), {} behind with a standard error of {}",
            best.law.words(),
            two(chosen.behind.unwrap_or(0.0)),
            two(chosen.behind_se.unwrap_or(0.0))
        )
    };
    Some((chosen.law, because))
}
