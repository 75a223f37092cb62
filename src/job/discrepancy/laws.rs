//! The law of a sensor's discrepancy with what it says: of its readings, along its inputs, of the parameters beside it.

use super::chosen::Chosen;
use super::expected::scaled;
use super::output::{Check, Curve, Hyperparameter, Law, PhaseResidual, SensorDiscrepancy};
use crate::inference::gaussian_process::confounding::Information;
use crate::inference::gaussian_process::hyperparameters::Beforehand;
use crate::inference::gaussian_process::process::Process;
use crate::inference::gaussian_process::tested_range::TestedRange;
use crate::inference::gaussian_process::{Kernel, Training, Trend};
use crate::job::JobError;
use crate::random::StreamKey;
use crate::statistics::quantile::{quantile_sorted, sorted};

/// Half of a 95 % interval, in standard deviations.
const HALF_WIDTH: f64 = 1.959_963_984_540_054;
/// Points of a curve.
const CURVE_POINTS: u32 = 41;

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
    /// What is known of the hyperparameters beforehand.
    pub beforehand: &'q Beforehand,
    /// What was inferred together with the parameters.
    pub given: Option<Given<'q>>,
    /// Of the random numbers.
    pub key: StreamKey,
}

/// A law whose hyperparameters were drawn together with the parameters.
#[derive(Clone, Copy)]
pub(super) struct Given<'q> {
    /// The law.
    pub law: Law,
    /// Draws of its hyperparameters.
    pub draws: &'q [Vec<f64>],
    /// Their largest R-hat.
    pub r_hat: Option<f64>,
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
        let chosen = match self.given {
            None => self.chosen(&training),
            Some(given) => self.drawn_together(&training, given),
        };
        let mut chosen = chosen.map_err(failed)?;
        let draws = std::mem::take(&mut chosen.draws);
        let mut findings = std::mem::take(&mut chosen.findings);
        let processes = draws.iter().map(|draw| Process::new(training.clone(), chosen.form, draw));
        let processes: Vec<Process> = processes.collect::<Result<_, _>>().map_err(|error| failed(error.to_string()))?;
        for (&place, own) in behind.iter().zip(&chosen.left_out) {
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
                    "readings {what} lie farther from what the law predicts than it says: {} times its standard deviation",
                    two(own.rms)
                ));
            }
        }
        if chosen.form.kernel.is_some() && chosen.at_bound.contains(&0) {
            findings.push("the size of the process ended at a bound of the search".to_owned());
        }
        let information = chosen.free.as_ref().and_then(|(form, hyperparameters)| {
            let process = Process::new(training.clone(), *form, hyperparameters).ok()?;
            let noise = training.noise();
            // Slopes of predicted readings are those of residuals with the other sign.
            let slopes =
                behind.iter().map(|&i| self.residuals[i].slopes.iter().map(|s| -s).collect()).collect::<Vec<_>>();
            noise
                .iter()
                .all(|variance| *variance > 0.0)
                .then(|| Information::new(&process.precision(), noise, &slopes, training.values()))
        });
        let hyperparameters = self.by_name(&chosen, &processes, &draws);
        let curves = self.curves(&processes);
        let [sensor, quantity, unit] = self.names.map(str::to_owned);
        let answer = SensorDiscrepancy {
            sensor,
            quantity,
            unit,
            law: chosen.law,
            because: chosen.because,
            laws: chosen.scores,
            form: chosen.form,
            draws,
            r_hat: chosen.r_hat,
            hyperparameters,
            descents: chosen.descents,
            residuals: self.residuals,
            left_out,
            held_out,
            curves,
            findings,
        };
        Ok((answer, information))
    }

    fn by_name(&self, chosen: &Chosen, processes: &[Process], draws: &[Vec<f64>]) -> Vec<Hyperparameter> {
        let unit = self.names[2];
        let exp = crate::math::functions::exp;
        let mut named = Vec::new();
        let widths: Vec<f64> = self.ranges.iter().map(|range| range.upper - range.lower).collect();
        let lengths = if chosen.form.kernel.is_some() { widths.len() } else { 0 };
        for (place, fitted) in chosen.central.iter().enumerate() {
            let is_length = chosen.form.kernel.is_some() && (1..=lengths).contains(&place);
            let is_size = place == 0 && chosen.form.kernel.is_some();
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
            let at_bound = chosen.at_bound.contains(&place);
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
pub(super) fn mixture(processes: &[Process], point: &[f64]) -> (f64, f64) {
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

/// A number with two decimals.
pub(super) fn two(value: f64) -> String {
    format!("{value:.2}")
}
