//! Predictive scores of steady phases: the log density that the rest of the data gave to a phase's readings, all of its
//! sensors together.
//!
//! Held out: `ln mean_s N(z; f(s) + bias, diag(sd^2) + F S F')` over posterior draws `s`, with what known errors of the
//! inputs add, as in the likelihood. Fitted: leave-one-group-out by Pareto-smoothed importance sampling (Vehtari, Gelman &
//! Gabry 2017) with a phase as the group.

use super::output::{HeldOutScore, PhaseScore};
use super::predictive::{Draws, InputSpread};
use crate::inference::likelihood::{Datum, HALF_LN_TAU};
use crate::inference::sampler::psis::LeaveOneOut;
use crate::math::cholesky;
use crate::math::functions::ln;
use crate::math::sum::log_sum_exp;
use crate::measurement::{Measurement, Rows};

/// A fitted phase: its measurement and row, and how many readings it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Group {
    pub measurement: usize,
    pub row: usize,
    readings: u64,
}

/// Sums the log densities of each steady phase's readings: the phases, and `draws x phases`, draw by draw.
pub(super) fn by_phase(measurements: &[&Measurement], data: &[Datum], pointwise: &[f64]) -> (Vec<Group>, Vec<f64>) {
    let mut groups: Vec<Group> = Vec::new();
    // Group of each datum; those of transients have none.
    let mut places = Vec::with_capacity(data.len());
    for datum in data {
        if !matches!(measurements[datum.measurement].rows, Rows::Steady(_)) {
            places.push(None);
            continue;
        }
        // A phase's data stand together.
        match groups.last_mut() {
            Some(last) if last.measurement == datum.measurement && last.row == datum.row => last.readings += 1,
            _ => groups.push(Group { measurement: datum.measurement, row: datum.row, readings: 1 }),
        }
        places.push(Some(groups.len() - 1));
    }
    let mut summed = Vec::with_capacity(pointwise.len() / data.len().max(1) * groups.len());
    for draw in pointwise.chunks_exact(data.len().max(1)) {
        let first = summed.len();
        summed.resize(first + groups.len(), 0.0);
        for (place, value) in places.iter().zip(draw) {
            if let Some(place) = place {
                summed[first + place] += value;
            }
        }
    }
    (groups, summed)
}

/// Scores of all steady phases that have readings and are not ignored, in their order.
pub(super) fn phases(
    measurements: &[&Measurement],
    groups: &[Group],
    left_out: Option<&LeaveOneOut>,
    good: f64,
    order: &[String],
    posterior: &Draws,
    spread: &InputSpread,
) -> Vec<PhaseScore> {
    let mut scores = Vec::new();
    let mut first = 0;
    for (index, measurement) in measurements.iter().enumerate() {
        let width = measurement.sensors.len();
        if let Rows::Steady(phases) = &measurement.rows {
            let noise: Vec<Vec<f64>> = (0..width).map(|sensor| posterior.noise(measurement, sensor, order)).collect();
            for (row, phase) in phases.iter().enumerate() {
                let score = |readings: u64, log_density: f64, held_out: bool, reliable: bool| PhaseScore {
                    measurement: measurement.name.clone(),
                    phase: phase.name.clone(),
                    readings,
                    log_density,
                    held_out,
                    reliable,
                };
                if measurement.held_out(row) && !measurement.ignored(row) {
                    let (readings, density) =
                        density(measurement, row, first, &noise, posterior, spread[index][row].as_deref());
                    if readings > 0 && density.is_finite() {
                        scores.push(score(readings, density, true, true));
                    }
                } else if let Some(place) = groups.iter().position(|g| g.measurement == index && g.row == row)
                    && let Some(cross_validated) = left_out
                {
                    let reliable = cross_validated.pareto_k[place] <= good;
                    scores.push(score(groups[place].readings, cross_validated.pointwise[place], false, reliable));
                }
            }
        }
        first += measurement.len() * width;
    }
    scores
}

/// Readings of a row and the log of their joint predictive density, `inputs` the covariance that the inputs' errors give
/// to all sensors. Sensors without a stated noise are left out.
fn density(
    measurement: &Measurement,
    row: usize,
    first: usize,
    noise: &[Vec<f64>],
    posterior: &Draws,
    inputs: Option<&[f64]>,
) -> (u64, f64) {
    let width = measurement.sensors.len();
    let whole = posterior.predicted.readings.len() / posterior.values.len().max(1);
    let read: Vec<(usize, f64)> = (0..width)
        .filter(|&sensor| noise[sensor].iter().all(|sd| *sd > 0.0))
        .filter_map(|sensor| Some((sensor, measurement.reading(row, sensor)?)))
        .collect();
    let of_draw = |draw: usize| {
        let deviation = |&(sensor, measured): &(usize, f64)| {
            measured - posterior.predicted.readings[draw * whole + first + row * width + sensor]
        };
        let Some(inputs) = inputs else {
            return read.iter().fold(0.0, |log, reading| {
                let sd = noise[reading.0][draw];
                let scaled = deviation(reading) / sd;
                log - (0.5 * scaled * scaled + ln(sd) + HALF_LN_TAU)
            });
        };
        let size = read.len();
        let mut factor: Vec<f64> = read.iter().flat_map(|a| read.iter().map(|b| inputs[a.0 * width + b.0])).collect();
        for (place, (sensor, _)) in read.iter().enumerate() {
            factor[place * (size + 1)] += noise[*sensor][draw] * noise[*sensor][draw];
        }
        let mut whitened: Vec<f64> = read.iter().map(deviation).collect();
        if cholesky::factor(&mut factor, size).is_err() {
            return f64::NAN;
        }
        cholesky::solve_lower(&factor, &mut whitened);
        let square: f64 = whitened.iter().map(|value| value * value).sum();
        -0.5 * (square + cholesky::log_determinant(&factor, size)) - HALF_LN_TAU * size as f64
    };
    let mut logs: Vec<f64> = (0..posterior.values.len()).map(of_draw).collect();
    // A draw at which the model failed says nothing.
    logs.retain(|log| log.is_finite());
    (read.len() as u64, log_sum_exp(&logs) - ln(logs.len() as f64))
}

/// The phases held out, together.
pub(super) fn held_out(phases: &[PhaseScore]) -> Option<HeldOutScore> {
    let held_out_scores: Vec<&PhaseScore> = phases.iter().filter(|phase| phase.held_out).collect();
    if held_out_scores.is_empty() {
        return None;
    }
    let count = held_out_scores.len() as f64;
    let log_density: f64 = held_out_scores.iter().map(|phase| phase.log_density).sum();
    let mean = log_density / count;
    let squares: f64 =
        held_out_scores.iter().map(|phase| (phase.log_density - mean) * (phase.log_density - mean)).sum();
    Some(HeldOutScore {
        log_density,
        standard_error: (held_out_scores.len() > 1).then(|| (squares * count / (count - 1.0)).sqrt()),
        phases: held_out_scores.len() as u64,
        readings: held_out_scores.iter().map(|phase| phase.readings).sum(),
    })
}
