//! Sensors that follow late, or whose clocks are off: what they read of the temperatures at the fit with times that are tried.

use super::blank::{Predictions, blank, blank_truth, predictions};
use super::probe::{Probes, share};
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::diagnosis::thinned::times;
use crate::effect::{Effect, SensorChange};
use crate::inference::likelihood::Datum;
use crate::measurement::timing::Timing;
use crate::measurement::{Measurement, Rows};

/// Share of the longest transient above which an offset of clocks is not tried: little of what is shown is known then.
const MOST_OFFSET: f64 = 0.5;
/// Shares of it that are tried where all others are longer.
const SHORT_OFFSETS: [f64; 3] = [0.01, 0.03, 0.1];

/// What sensors read in every row, found when first asked for.
#[derive(Default)]
pub(super) struct Timings {
    found: Option<Result<Readings, FitError>>,
}

/// What sensors read at the fit.
struct Readings {
    /// What happens when it does.
    truths: Predictions,
    /// When the sensors show it.
    present: Option<Predictions>,
}

impl Readings {
    fn of(base: &Base<'_>) -> Result<Self, FitError> {
        let measurements = &base.problem.measurements;
        let mut sensors = measurements.iter().flat_map(|measurement| &measurement.sensors);
        let has_times = sensors.any(|one| one.lag_s.is_some() || !one.behind_s.is_empty());
        let truths = predictions(base, measurements.iter().map(blank_truth).collect())?;
        let present = has_times.then(|| predictions(base, measurements.iter().map(blank).collect())).transpose()?;
        Ok(Self { truths, present })
    }
}

impl Timings {
    /// The directions of an effect's times.
    pub fn directions(&mut self, base: &Base<'_>, position: usize, effect: &Effect) -> Found {
        let found = self.found.get_or_insert_with(|| Readings::of(base)).as_ref().map_err(Clone::clone)?;
        let Probes { applied, values, .. } = Probes::new(base, position, effect)?;
        let measurements = &base.problem.measurements;
        let place_of = |change: &SensorChange| change.time()?.checked_sub(applied.first_parameter);
        let is_clock = |change: &&SensorChange| matches!(change, SensorChange::Clock { .. });
        let values = match applied.sensors.iter().find(is_clock).and_then(place_of) {
            Some(place) => within(longest_s(measurements), values, place),
            None => values,
        };
        let change_of = |name: &str| applied.sensors.iter().find(|change| change.of_sensor() == Some(name));
        let read = |measurement: usize, sensor: usize, probe: &[f64]| -> Option<Vec<f64>> {
            let Measurement { sensors, rows: Rows::Transient { inputs, .. }, .. } = &measurements[measurement] else {
                return None;
            };
            let change = change_of(&sensors[sensor].name)?;
            let time_s = *probe.get(place_of(change)?)?;
            let present = base.likelihood.timing(measurement, sensor, base.unknowns);
            let timing = match change {
                SensorChange::Clock { .. } => Timing { behind_s: present.behind_s + time_s, ..present },
                _ => Timing { lag_s: time_s, ..present },
            };
            let truth = found.truths[measurement].iter().skip(sensor).step_by(sensors.len());
            Some(timing.reading(&inputs.times_s, &truth.copied().collect::<Vec<f64>>()))
        };
        let present = found.present.as_ref().unwrap_or(&found.truths);
        let mut directions = Vec::new();
        for probe in values {
            let readings: Vec<Vec<Option<Vec<f64>>>> = (measurements.iter().enumerate())
                .map(|(place, own)| (0..own.sensors.len()).map(|sensor| read(place, sensor, &probe)).collect())
                .collect();
            let change = |&Datum { measurement, row, sensor }: &Datum| {
                let now = present[measurement][row * measurements[measurement].sensors.len() + sensor];
                readings[measurement][sensor].as_ref().map_or(0.0, |read| read[row] - now)
            };
            let mut column: Vec<f64> = base.likelihood.data().iter().map(change).collect();
            base.whitening.apply(&mut column)?;
            column.resize(base.rows, 0.0);
            if column.iter().all(|value| value.is_finite()) && column.iter().any(|value| *value != 0.0) {
                directions.push(share(position, column, probe));
            }
        }
        if directions.is_empty() { Err(NoDirection::NoReading.into()) } else { Ok(directions) }
    }
}

/// Of the values of an effect's parameters those whose time, at this place, is no large share of the longest transient; small shares
/// of it, of the same signs, where none is.
fn within(longest_s: f64, values: Vec<Vec<f64>>, place: usize) -> Vec<Vec<f64>> {
    let time = |probe: &Vec<f64>| probe.get(place).copied().unwrap_or(0.0);
    let within: Vec<Vec<f64>> =
        values.iter().filter(|probe| time(probe).abs() <= MOST_OFFSET * longest_s).cloned().collect();
    if !within.is_empty() {
        return within;
    }
    let of_sign = |sign: f64| values.iter().find(move |probe| time(probe) * sign > 0.0).map(|probe| (probe, sign));
    let signs = [-1.0, 1.0].into_iter().filter_map(of_sign);
    let at = |(probe, sign): (&Vec<f64>, f64), share: f64| {
        let mut probe = probe.clone();
        probe[place] = sign * share * longest_s;
        probe
    };
    signs.flat_map(|signed| SHORT_OFFSETS.map(|share| at(signed, share))).collect()
}

/// How long the longest transient is, s.
fn longest_s(measurements: &[Measurement]) -> f64 {
    let spans = measurements.iter().map(times).filter_map(|times_s| Some(times_s.last()? - times_s.first()?));
    spans.fold(0.0, f64::max)
}
