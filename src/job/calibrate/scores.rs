//! Predictive scores of steady phases: the log density that the rest of the data gave to a phase's readings, all of its
//! sensors together.
//!
//! Held out: `ln mean_s prod_i N(z_i; f_i(s) + bias_i, sd_i)` over posterior draws `s`. Fitted: leave-one-group-out by
//! Pareto-smoothed importance sampling (Vehtari, Gelman & Gabry 2017) with a phase as the group. Known errors of the
//! inputs widen a fitted phase's density; a held-out phase is scored by its sensors' noise alone.

use super::output::{HeldOutScore, PhaseScore};
use super::predictive::Draws;
use crate::inference::likelihood::Datum;
use crate::inference::measurement::{Measurement, Rows};
use crate::inference::psis::LeaveOneOut;
use crate::math::functions::ln;
use crate::math::sum::log_sum_exp;

/// Half of ln(2 pi).
const HALF_LN_TAU: f64 = 0.918_938_533_204_672_7;

/// A fitted phase: its measurement and row, and how many readings it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Group {
    measurement: usize,
    row: usize,
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
                    let (readings, density) = density(measurement, row, first, &noise, posterior);
                    if readings > 0 && density.is_finite() {
                        scores.push(score(readings, density, true, true));
                    }
                } else if let Some(place) = groups.iter().position(|g| g.measurement == index && g.row == row)
                    && let Some(found) = left_out
                {
                    let reliable = found.pareto_k[place] <= good;
                    scores.push(score(groups[place].readings, found.pointwise[place], false, reliable));
                }
            }
        }
        first += measurement.len() * width;
    }
    scores
}

/// Readings of a row and the log of their joint predictive density. Sensors without a stated noise are left out.
fn density(measurement: &Measurement, row: usize, first: usize, noise: &[Vec<f64>], posterior: &Draws) -> (u64, f64) {
    let width = measurement.sensors.len();
    let whole = posterior.predicted.readings.len() / posterior.values.len().max(1);
    let mut logs = vec![0.0; posterior.values.len()];
    let mut readings = 0;
    for sensor in 0..width {
        let Some(measured) = measurement.reading(row, sensor) else { continue };
        if !noise[sensor].iter().all(|sd| *sd > 0.0) {
            continue;
        }
        readings += 1;
        for (draw, log) in logs.iter_mut().enumerate() {
            let predicted = posterior.predicted.readings[draw * whole + first + row * width + sensor];
            let sd = noise[sensor][draw];
            let deviation = (measured - predicted) / sd;
            *log -= 0.5 * deviation * deviation + ln(sd) + HALF_LN_TAU;
        }
    }
    // A draw at which the model failed says nothing.
    logs.retain(|log| log.is_finite());
    (readings, log_sum_exp(&logs) - ln(logs.len() as f64))
}

/// The phases held out, together.
pub(super) fn held_out(phases: &[PhaseScore]) -> Option<HeldOutScore> {
    let own: Vec<&PhaseScore> = phases.iter().filter(|phase| phase.held_out).collect();
    if own.is_empty() {
        return None;
    }
    let count = own.len() as f64;
    let log_density: f64 = own.iter().map(|phase| phase.log_density).sum();
    let mean = log_density / count;
    let squares: f64 = own.iter().map(|phase| (phase.log_density - mean) * (phase.log_density - mean)).sum();
    Some(HeldOutScore {
        log_density,
        standard_error: (own.len() > 1).then(|| (squares * count / (count - 1.0)).sqrt()),
        phases: own.len() as u64,
        readings: own.iter().map(|phase| phase.readings).sum(),
    })
}
