//! Hyperparameters of the highest marginal likelihood between bounds, from several starts.
//!
//! The likelihood of a Gaussian process has several maxima, as a short length may take noise for signal (Rasmussen & Williams
//! 2006, figure 5.5). Starts are scrambled Sobol points between the bounds. Where there are many points, the starts compete on
//! some of them, spread over all, and the best few go on
//! with all, the best of them to its end: a start then costs a small part of a descent.

use super::descent::{Descended, descend};
use super::marginal::with_gradient;
use super::{FEWEST_POINTS, Form, GaussianProcessError, Training};
use crate::math::functions::ln;
use crate::math::sort::sort_by;
use crate::random::{PointKind, Points, StreamKey};

/// Points on which starts compete.
const COMPETING: usize = 50;
/// Starts that are looked at for each descent.
const LOOKED_AT: usize = 4;
/// Ends that go on with all points, where starts competed on some, and the evaluations after which the best alone does.
const GO_ON: usize = 3;
const RACE: u64 = 25;
/// What is predicted to be gained when a descent among competing starts ends, nats.
const ROUGH_GAIN: f64 = 1e-2;
/// What is predicted to be gained when a descent ends, nats.
const LEAST_GAIN: f64 = 1e-9;
/// Most evaluations of a descent.
const MOST_EVALUATIONS: u64 = 300;

/// Settings of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Bounds of each hyperparameter (logarithms).
    pub bounds: Vec<[f64; 2]>,
    /// First start.
    pub start: Vec<f64>,
    /// Descents from further starts.
    pub further: usize,
}

/// Hyperparameters found.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Logarithms, as [`Form::hyperparameters`] says.
    pub hyperparameters: Vec<f64>,
    /// Logarithm of the marginal likelihood there.
    pub log_likelihood: f64,
    /// Descents that were begun, and how many of them ended within 0.01 nats of the best.
    pub descents: [u64; 2],
    /// Evaluations with gradient, each counted by its share `(n / all)^3`.
    pub evaluations: f64,
    /// Hyperparameters that ended at a bound.
    pub at_bound: Vec<usize>,
}

impl Search {
    /// Bounds and a start by the size of the values and the spread of the points: lengths from a twentieth to ten times each
    /// input's spread, variances from a ten-thousandth to a thousand times the mean square of the values.
    pub fn usual(training: &Training, form: &Form, further: usize) -> Self {
        let noise = training.noise().iter().sum::<f64>() / training.len().max(1) as f64;
        let size = ln(training.mean_square(form.trend).max(1e-2 * noise).max(f64::MIN_POSITIVE));
        let (mut bounds, mut start) = (Vec::new(), Vec::new());
        if form.kernel.is_some() {
            bounds.push([size - ln(1e4), size + ln(1e3)]);
            start.push(size);
            for input in 0..training.inputs() {
                let values = (0..training.len()).map(|i| training.point(i)[input]);
                let [low, high] =
                    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
                let spread = ln(if high > low { high - low } else { 1.0 });
                bounds.push([spread - ln(20.0), spread + ln(10.0)]);
                start.push(spread + ln(0.5));
            }
        }
        if form.scatter {
            bounds.push([size - ln(1e6), size + ln(10.0)]);
            start.push(size - ln(10.0));
        }
        Self { bounds, start, further }
    }
}

/// The hyperparameters of the highest marginal likelihood. `key` gives the starts.
///
/// # Errors
/// Fewer than five points or constant values under a kernel, points at the same place without noise, a covariance that is
/// indefinite at every start.
pub fn fit(training: &Training, form: &Form, search: &Search, key: &StreamKey) -> Result<Fit, GaussianProcessError> {
    check(training, form)?;
    let dimension = search.start.len();
    if dimension == 0 {
        let factored = super::marginal::Factored::new(training, form, &[])?;
        let log_likelihood = factored.log_likelihood();
        return Ok(Fit {
            hyperparameters: vec![],
            log_likelihood,
            descents: [0, 0],
            evaluations: 1.0,
            at_bound: vec![],
        });
    }
    let n = training.len();
    let competing =
        (n > 2 * COMPETING).then(|| training.some(&(0..COMPETING).map(|k| k * n / COMPETING).collect::<Vec<usize>>()));
    let contest = competing.as_ref().unwrap_or(training);
    let part = contest.len() as f64 / n as f64;
    let share = part * part * part;
    let mut evaluations = 0.0;
    let mut failed = GaussianProcessError::Indefinite;
    let mut objective =
        |training: &Training, x: &[f64], gradient: &mut [f64]| match with_gradient(training, form, x, gradient) {
            Ok(value) => {
                gradient.iter_mut().for_each(|g| *g = -*g);
                Some(-value)
            }
            Err(error) => {
                failed = error;
                None
            }
        };
    let mut starts = vec![search.start.clone()];
    if search.further > 0 {
        // The best of several points each, so that few descents begin where nothing is to be found.
        let looked_at = LOOKED_AT * search.further;
        if let Ok(points) = Points::new(PointKind::Sobol, *key, looked_at, dimension) {
            let mut rows = vec![0.5; looked_at * dimension];
            points.fill_rows(0, &mut rows);
            let mut ranked: Vec<(f64, Vec<f64>)> = Vec::new();
            for row in rows.chunks_exact(dimension) {
                let point: Vec<f64> =
                    row.iter().zip(&search.bounds).map(|(u, [lower, upper])| lower + u * (upper - lower)).collect();
                let value =
                    super::marginal::Factored::new(contest, form, &point).map(|factored| -factored.log_likelihood());
                evaluations += share / 3.0;
                ranked.push((value.unwrap_or(f64::INFINITY), point));
            }
            sort_by(&mut ranked, |a, b| a.0.total_cmp(&b.0));
            starts.extend(ranked.into_iter().take(search.further).map(|(_, point)| point));
        }
    }
    let rough = if competing.is_some() { ROUGH_GAIN } else { LEAST_GAIN };
    let mut ends: Vec<Descended> = Vec::new();
    for start in &starts {
        let ended = descend(|x, g| objective(contest, x, g), start, &search.bounds, None, rough, MOST_EVALUATIONS);
        evaluations += share * ended.as_ref().map_or(1.0, |ended| ended.evaluations as f64);
        ends.extend(ended);
    }
    sort_by(&mut ends, |a, b| a.value.total_cmp(&b.value));
    let agreeing = ends.iter().filter(|end| end.value < ends[0].value + 0.01 + 2.0 * rough).count() as u64;
    let descents = [starts.len() as u64, agreeing];
    if competing.is_some() {
        let factor = contest.len() as f64 / n as f64;
        let mut whole: Vec<Descended> = Vec::new();
        ends.dedup_by(|later, earlier| later.value < earlier.value + ROUGH_GAIN);
        for end in ends.iter().take(GO_ON) {
            // Curvature grows with the number of points.
            let curvature: Vec<f64> = end.curvature.iter().map(|entry| entry * factor).collect();
            let ended =
                descend(|x, g| objective(training, x, g), &end.x, &search.bounds, Some(&curvature), LEAST_GAIN, RACE);
            evaluations += ended.as_ref().map_or(1.0, |ended| ended.evaluations as f64);
            whole.extend(ended);
        }
        sort_by(&mut whole, |a, b| a.value.total_cmp(&b.value));
        if let Some(first) = whole.first_mut()
            && first.evaluations >= RACE
        {
            let (start, curvature) = (first.x.clone(), first.curvature.clone());
            let ended = descend(
                |x, g| objective(training, x, g),
                &start,
                &search.bounds,
                Some(&curvature),
                LEAST_GAIN,
                MOST_EVALUATIONS,
            );
            evaluations += ended.as_ref().map_or(1.0, |ended| ended.evaluations as f64);
            if let Some(ended) = ended {
                *first = ended;
            }
        }
        ends = whole;
        sort_by(&mut ends, |a, b| a.value.total_cmp(&b.value));
    }
    let Some(best) = ends.into_iter().next() else { return Err(failed) };
    let at_bound = (0..dimension).filter(|&i| best.x[i] <= search.bounds[i][0] || best.x[i] >= search.bounds[i][1]);
    Ok(Fit {
        at_bound: at_bound.collect(),
        hyperparameters: best.x,
        log_likelihood: -best.value,
        descents,
        evaluations,
    })
}

/// What no process fits.
fn check(training: &Training, form: &Form) -> Result<(), GaussianProcessError> {
    if form.kernel.is_none() {
        return Ok(());
    }
    if training.len() < FEWEST_POINTS {
        return Err(GaussianProcessError::TooFew { points: training.len() });
    }
    let first = training.values()[0];
    if training.values().iter().all(|value| *value == first) {
        return Err(GaussianProcessError::Constant { value: first });
    }
    match training.same_points() {
        Some([first, second]) if !form.scatter && training.noise()[first] + training.noise()[second] == 0.0 => {
            Err(GaussianProcessError::SamePoint { first, second })
        }
        _ => Ok(()),
    }
}
