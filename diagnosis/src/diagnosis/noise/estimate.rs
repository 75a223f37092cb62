//! Noise of sensors whose noise is not wholly known, estimated so that missing physics is not taken for noise.
//!
//! The residuals of the fit hold noise and whatever the model lacks. So they are first freed of the parameters and of the
//! pair of effects that explains most, by least squares on the linearised problem; what is left is given, sensor by
//! sensor, the most likely Ornstein-Uhlenbeck process with white noise beside it (`inference::likelihood::noise`), its variance
//! enlarged by the freedom that the fit took. A stated sigma stands: then only the share and the time of the correlation
//! are sought, at that size or a smaller one. White noise and noise with any share and time are as likely beforehand: the likelihood's
//! mean over shares and times is weighed against that of white noise, which charges their freedom for what it is worth in these data
//! (Schwarz' price of `ln n` charges three times as much for what some hundred readings tell of a slow part). What the fit has taken of
//! the slow part is made good by the restricted likelihood ([`crate::diagnosis::noise::restricted_likelihood`]).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::diagnosis::noise::like_sensors::{Errors, sizes};
use crate::diagnosis::noise::restricted_likelihood::LinearFit;
use crate::inference::likelihood::noise::{Filter, Noise, Series};
use crate::math::functions::{exp, ln};
use crate::math::sum::log_sum_exp;
use crate::measurement::unknown::Value;
use crate::measurement::{Measurement, Rows, Uncertain, total_sd};
use crate::watch;

/// Readings of one sensor in the order of time, with their places among the rows of a linearised problem.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorRows {
    /// Position of the measurement.
    pub measurement: usize,
    /// Position of the sensor.
    pub sensor: usize,
    /// Rows of the linearised problem, in the order of time.
    pub rows: Vec<usize>,
    /// Instants, s; in steady data the phases' numbers.
    pub times_s: Vec<f64>,
}

/// Noise of a sensor as it was estimated, SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimatedNoise {
    /// Standard deviation of the correlated part; of all noise where there is no correlation.
    pub sigma: f64,
    /// Correlation time, s.
    pub correlation_time_s: Option<f64>,
    /// Standard deviation of white noise beside the correlated part.
    pub white: Option<f64>,
}

impl EstimatedNoise {
    /// White noise.
    pub fn white(sigma: f64) -> Self {
        Self { sigma, correlation_time_s: None, white: None }
    }

    /// Standard deviation of one reading.
    pub fn total(&self) -> f64 {
        let white = self.white.unwrap_or(0.0);
        total_sd(self.sigma, white)
    }

    /// Whether another noise is another by more than a tenth.
    pub fn differs(&self, other: &Self) -> bool {
        let apart = |a: f64, b: f64| (a - b).abs() > 0.1 * a.abs().max(b.abs());
        let time = |one: &Self| one.correlation_time_s.unwrap_or(0.0);
        apart(self.sigma, other.sigma)
            || apart(time(self), time(other))
            || apart(self.white.unwrap_or(0.0), other.white.unwrap_or(0.0))
    }

    fn noise(&self) -> Noise {
        Noise {
            sigma: Value::Known(self.sigma),
            correlation_time_s: self.correlation_time_s.map(Value::Known),
            white: self.white.map(Value::Known),
        }
    }

    /// The whitening of any values of a sensor at these instants, s.
    pub fn filter(&self, times_s: &[f64]) -> Filter {
        // Noise that is settled is above 0.
        self.noise().filter(&[], times_s).unwrap_or(Filter::White(1.0))
    }

    /// Whitens a sensor's values in place; returns the sum of the logarithms of the standard deviations, negative.
    pub fn whiten(&self, times_s: &[f64], values: &mut [f64]) -> f64 {
        let mut scales = vec![0.0; values.len()];
        let mut series =
            Series { times_s, values, jacobian: &mut [], log_scales: &mut scales, scale_gradient: &mut [] };
        // Noise that is settled is above 0.
        let _ = self.noise().whiten(&[], &mut series);
        scales.iter().sum()
    }
}

/// The whitening of the rows of each sensor.
pub fn whitening<'n>(series: &[SensorRows], noises: impl Iterator<Item = &'n EstimatedNoise>) -> Vec<Filter> {
    series.iter().zip(noises).map(|(series, noise)| noise.filter(&series.times_s)).collect()
}

/// Whitens the rows of the sensors in a column.
pub fn whiten(series: &[SensorRows], filters: &[Filter], column: &mut [f64]) {
    for (series, filter) in series.iter().zip(filters) {
        let mut own: Vec<f64> = series.rows.iter().map(|&row| column[row]).collect();
        filter.apply(&mut own);
        for (&row, value) in series.rows.iter().zip(own) {
            column[row] = value;
        }
    }
}

/// Whether a sensor's noise leaves something to estimate.
pub fn is_open(measurement: &Measurement, sensor: usize) -> bool {
    let measured_sensor = &measurement.sensors[sensor];
    let inferred = |value: &Option<Uncertain>| value.as_ref().is_some_and(|value| value.prior().is_some());
    let unstated = measured_sensor.correlation_time_s.is_none() && matches!(measurement.rows, Rows::Transient { .. });
    measured_sensor.sigma.is_none()
        || inferred(&measured_sensor.sigma)
        || inferred(&measured_sensor.white)
        || inferred(&measured_sensor.correlation_time_s)
        || unstated
}

/// What is known of a sensor's noise beforehand.
struct Known {
    /// Standard deviation of one reading, where it is stated.
    total: Option<f64>,
    /// Shares of the correlated part in the variance that are tried.
    shares: Vec<f64>,
    /// Correlation times that are tried, s.
    times_s: Vec<f64>,
}

/// Shares of the correlated part that are tried where nothing is stated.
const SHARES: [f64; 13] = [0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.75, 0.87, 0.95, 0.99, 1.0];
/// Number of correlation times that are tried.
const TIMES: usize = 18;
/// Falls of the log likelihood of the errors within which noise is tried with what the fit has taken.
const NEAR: f64 = 25.0;
/// Falls of the log likelihood within which noise is likely.
const LIKELY: f64 = 2.0;
/// Log odds beforehand by which a sensor has the noise of the others rather than its own.
const LIKE_THE_OTHERS: f64 = 3.0;
/// Relative standard deviation of stated sizes about the truth.
const STATED_WITHIN: f64 = 0.1;
/// Fewest readings of a sensor whose correlation is estimated.
const LEAST_READINGS: usize = 30;

fn known(measurement: &Measurement, sensor: usize, times_s: &[f64]) -> Known {
    let measured_sensor = &measurement.sensors[sensor];
    let fixed = |value: &Option<Uncertain>| match value {
        Some(value) if value.prior().is_none() => Some(value.nominal()),
        _ => None,
    };
    let white_is_open = measured_sensor.white.as_ref().is_some_and(|white| white.prior().is_some());
    let total = match (fixed(&measured_sensor.sigma), &measured_sensor.white) {
        (Some(sigma), None) => Some(sigma),
        (Some(sigma), Some(_)) if !white_is_open => {
            let white = fixed(&measured_sensor.white).unwrap_or(0.0);
            Some(total_sd(sigma, white))
        }
        _ => None,
    };
    let steady = matches!(measurement.rows, Rows::Steady(_));
    let span = times_s.last().copied().unwrap_or(0.0) - times_s.first().copied().unwrap_or(0.0);
    let step = span / times_s.len().saturating_sub(1).max(1) as f64;
    let (shares, times) = if steady || times_s.len() < LEAST_READINGS || !(step > 0.0) {
        (vec![0.0], vec![1.0])
    } else {
        let range = match &measured_sensor.correlation_time_s {
            Some(value) => value.prior().map_or([value.nominal(); 2], |prior| {
                [prior.quantile(0.001).max(0.2 * step), prior.quantile(0.999).min(span)]
            }),
            // A stated size bounds what slow noise can take up; else it could take up all that is slow.
            None => [0.5 * step, if total.is_some() { 0.3 * span } else { 0.1 * span }],
        };
        let times = if range[1] > range[0] {
            let ratio = ln(range[1] / range[0]) / (TIMES - 1) as f64;
            (0..TIMES).map(|k| range[0] * exp(ratio * k as f64)).collect()
        } else {
            vec![range[0]]
        };
        let shares = match (&measured_sensor.correlation_time_s, &measured_sensor.white) {
            (Some(_), None) => vec![1.0],
            (Some(_), Some(_)) if total.is_some() => {
                let sigma = fixed(&measured_sensor.sigma).unwrap_or(0.0);
                vec![sigma * sigma / total.map_or(1.0, |total| total * total)]
            }
            _ => SHARES.to_vec(),
        };
        (shares, times)
    };
    Known { total, shares, times_s: times }
}

/// What is left of a sensor's readings, and what its noise may be.
struct Sought<'a> {
    series: &'a SensorRows,
    /// What is left, SI.
    errors: &'a [f64],
    /// Share of the rows that the fit did not take.
    freedom: f64,
    known: Known,
}

/// Its log likelihood or evidence, and noise.
type Weighed = (f64, EstimatedNoise);

impl Sought<'_> {
    fn count(&self) -> f64 {
        self.errors.len().max(1) as f64
    }

    /// Its errors, as if the fit took none.
    fn total_errors(&self) -> Errors {
        Errors { count: self.count(), square: self.errors.iter().map(|e| e * e).sum::<f64>() / self.freedom }
    }

    /// Noise of which a share of the variance is correlated, of its most likely size.
    fn at(&self, share: f64, time_s: f64) -> Weighed {
        let unit = split(1.0, share, time_s);
        let mut whitened = self.errors.to_vec();
        let scales = unit.whiten(&self.series.times_s, &mut whitened);
        let square = whitened.iter().map(|e| e * e).sum::<f64>() / self.freedom;
        let count = self.count();
        let free = (square / count).max(f64::MIN_POSITIVE);
        let (variance, penalty) = self.known.total.map_or((free, 0.0), |total| size(free, total * total));
        let log_likelihood = scales - 0.5 * count * ln(variance) - 0.5 * square / variance - penalty;
        (log_likelihood, split(self.known.total.unwrap_or(variance.sqrt()), share, time_s))
    }

    /// Its noise whatever that of the others is: the most likely of the kind, white or correlated, that has the greater evidence.
    fn alone(&self) -> Weighed {
        let white = self.known.shares.contains(&0.0).then(|| self.at(0.0, self.known.times_s[0]));
        let all = grid(&self.known).map(|(share, time)| self.at(share, time));
        match (white, of_grid(all, |one| one.0)) {
            (Some(white), Some((evidence, _))) if white.0 >= evidence => white,
            (_, Some((evidence, best))) => (evidence, best.1),
            (Some(white), None) => white,
            (None, None) => (f64::NEG_INFINITY, EstimatedNoise::white(1.0)),
        }
    }
}

/// Shares and times of correlated noise that are tried.
fn grid(stated: &Known) -> impl Iterator<Item = (f64, f64)> {
    let correlated = stated.shares.iter().filter(|share| **share > 0.0);
    correlated.flat_map(|&share| stated.times_s.iter().map(move |&time| (share, time)))
}

/// The mean of what is tried, as the logarithm of that of the exponentials, and the best.
fn of_grid<T>(tried: impl Iterator<Item = T>, value: impl Fn(&T) -> f64) -> Option<(f64, T)> {
    let mut logs = Vec::new();
    let mut best: Option<T> = None;
    for one in tried {
        watch::check();
        logs.push(value(&one));
        if best.as_ref().is_none_or(|best_so_far| value(&one) > value(best_so_far)) {
            best = Some(one);
        }
    }
    best.map(|best| (log_sum_exp(&logs) - ln(logs.len() as f64), best))
}

/// The most likely noise of sensors, from what a fit has left of their readings, SI; `freedom` is the share of the rows that the
/// fit did not take (above 0, at most 1), `current` the noise that others have while that of one measurement is sought.
///
/// Sensors of a measurement of whose correlation nothing is stated hang on one logger and in one chamber: they have the same
/// share and time, or all have white noise, and a sensor departs from the others only at a price. What the parameters and the
/// best pair took of a sensor's slow noise would else make white noise of it, and whatever moves that sensor alone would be found.
pub fn most_likely(
    measurements: &[Measurement],
    series: &[SensorRows],
    fit: &LinearFit,
    freedom: f64,
    current: &[EstimatedNoise],
) -> Vec<EstimatedNoise> {
    let errors: Vec<Vec<f64>> =
        series.iter().map(|one| one.rows.iter().map(|&row| fit.errors[row]).collect()).collect();
    let sought: Vec<Sought<'_>> = (series.iter().zip(&errors))
        .map(|(series, errors)| {
            let stated = known(&measurements[series.measurement], series.sensor, &series.times_s);
            Sought { series, errors, freedom, known: stated }
        })
        .collect();
    let alone: Vec<Weighed> = sought.par_iter().map(Sought::alone).collect();
    let mut noises: Vec<EstimatedNoise> = alone.iter().map(|(_, noise)| *noise).collect();
    for (position, measurement) in measurements.iter().enumerate() {
        let is_open = |one: &Sought<'_>| {
            let measured_sensor = &measurement.sensors[one.series.sensor];
            one.series.measurement == position
                && measured_sensor.correlation_time_s.is_none()
                && measured_sensor.white.is_none()
        };
        let members: Vec<usize> = (0..sought.len()).filter(|&place| is_open(&sought[place])).collect();
        let correction = |noises: &[Weighed]| {
            let mut all = current.to_vec();
            members.iter().zip(noises).for_each(|(&place, (_, noise))| all[place] = *noise);
            fit.correction(series, &all)
        };
        for (place, noise) in together(&sought, &alone, &members, correction) {
            noises[place] = noise;
        }
        if matches!(measurement.rows, Rows::Steady(_)) {
            for (place, sigma) in alike(measurement, &sought, &members) {
                noises[place] = EstimatedNoise::white(sigma);
            }
        }
    }
    noises
}

/// The noise of like sensors of steady phases whose size is open: those of one unit with one prior, or without any.
fn alike(measurement: &Measurement, sought: &[Sought<'_>], members: &[usize]) -> Vec<(usize, f64)> {
    let sensor = |place: usize| &measurement.sensors[sought[place].series.sensor];
    let prior = |place: usize| sensor(place).sigma.as_ref().and_then(|sigma| sigma.prior().copied());
    let kind = |place: usize| (sensor(place).unit.as_str(), prior(place));
    let mut open: Vec<usize> = members.iter().copied().filter(|&place| sought[place].known.total.is_none()).collect();
    let mut found = Vec::new();
    while let Some(&first) = open.first() {
        let (like, others): (Vec<usize>, Vec<usize>) = open.iter().partition(|&&place| kind(place) == kind(first));
        let errors: Vec<Errors> = like.iter().map(|&place| sought[place].total_errors()).collect();
        found.extend(like.into_iter().zip(sizes(&errors, prior(first).as_ref())));
        open = others;
    }
    found
}

/// The noise of sensors of which, in their measurement, so many readings are fitted: where none is, as in one that is
/// held out as a whole, that of the sensor of the same name with most readings, else that of the one with most.
pub fn where_nothing_is_fitted(names: &[&str], fitted: &[usize], estimates: &[EstimatedNoise]) -> Vec<EstimatedNoise> {
    let of = |place: usize| {
        let others = (0..estimates.len()).filter(|&other| fitted[other] > 0);
        // The first of equals.
        let best = others.rev().max_by_key(|&other| (names[other] == names[place], fitted[other]));
        best.filter(|_| fitted[place] == 0).map_or(estimates[place], |best| estimates[best])
    };
    (0..estimates.len()).map(of).collect()
}

/// The noise of those members that have the same.
fn together(
    sought: &[Sought<'_>],
    alone: &[Weighed],
    members: &[usize],
    correction: impl Fn(&[Weighed]) -> f64 + Sync,
) -> Vec<(usize, EstimatedNoise)> {
    // Times that are allowed for all: those of a sensor whose size is not stated, if there is one.
    let tried = members.iter().copied().filter(|&place| sought[place].known.shares.len() > 1);
    let longest = tried.max_by_key(|&place| (sought[place].known.total.is_none(), sought[place].errors.len()));
    let Some(longest) = longest.map(|place| &sought[place].known) else { return Vec::new() };
    // With the same noise, but for those that depart.
    let at = |share: f64, time: f64| -> (f64, Vec<Weighed>) {
        let at_common =
            members.iter().map(|&m| (sought[m].at(share, time), (alone[m].0 - LIKE_THE_OTHERS, alone[m].1)));
        let all: Vec<Weighed> =
            at_common.map(|(common, departs)| if common.0 >= departs.0 { common } else { departs }).collect();
        (all.iter().map(|(value, _)| value).sum(), all)
    };
    let of_grid: Vec<(f64, f64)> = grid(longest).collect();
    let one = |&(share, time): &(f64, f64)| {
        watch::check();
        let (value, all) = at(share, time);
        (value, share * time, all)
    };
    let mut tried: Vec<(f64, f64, Vec<Weighed>)> = of_grid.par_iter().map(one).collect();
    let best = tried.iter().map(|(value, ..)| *value).fold(f64::NEG_INFINITY, f64::max);
    tried.par_iter_mut().for_each(|(value, _, all)| {
        // What is far from the best stays so: the correction changes little from one noise to the next.
        *value += if best - *value < NEAR { correction(all) } else { f64::NEG_INFINITY };
    });
    let (white, all) = at(0.0, longest.times_s[0]);
    let white = (white + correction(&all), all);
    let logs: Vec<f64> = tried.iter().map(|(value, ..)| *value).collect();
    let total = log_sum_exp(&logs);
    let same = if total - ln(logs.len() as f64) > white.0 {
        // Of what is likely, the one whose slow part is as strong as it is on the average: what is tested for is slow, and the most
        // likely noise is as often too weak there as it is too strong.
        let mean: f64 = tried.iter().map(|(value, slow, _)| exp(value - total) * slow).sum();
        let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let far = |slow: f64| ln(slow / mean).abs();
        let likely = tried.into_iter().filter(|(value, ..)| best - value < LIKELY);
        likely.min_by(|a, b| far(a.1).total_cmp(&far(b.1))).map_or(white.1, |(_, _, all)| all)
    } else {
        white.1
    };
    members.iter().copied().zip(same.into_iter().map(|(_, noise)| noise)).collect()
}

/// The variance that errors have whose size is stated, and half the square of the deviate by which it lies below. Stated
/// sizes are often too large: at the stated one a correlated part that never shows would take up what is too much. But they
/// are near, and never taken for too small: readings that are close in time tell the ratio of variance and correlation time
/// only, so that a size left free makes the time wrong, and with it the noise of every difference.
fn size(free: f64, stated: f64) -> (f64, f64) {
    let variance = free.min(stated);
    let deviate = 0.5 * ln(variance / stated) / STATED_WITHIN;
    (variance, 0.5 * deviate * deviate)
}

/// Noise of a standard deviation of which a share of the variance is correlated.
pub fn split(total: f64, share: f64, time_s: f64) -> EstimatedNoise {
    if share <= 0.0 {
        return EstimatedNoise::white(total);
    }
    let white = (share < 1.0).then(|| total * (1.0 - share).sqrt());
    EstimatedNoise { sigma: total * share.sqrt(), correlation_time_s: Some(time_s), white }
}

/// Writes noise into a measurement as known.
pub fn fix(measurement: &mut Measurement, sensor: usize, noise: &EstimatedNoise) {
    let measured_sensor = &mut measurement.sensors[sensor];
    measured_sensor.sigma = Some(Uncertain::Known(noise.sigma));
    measured_sensor.correlation_time_s = noise.correlation_time_s.map(Uncertain::Known);
    measured_sensor.white = noise.white.map(Uncertain::Known);
}
