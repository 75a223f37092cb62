//! Where a comparison fails, in words: sensor, direction, when, and what the error goes with.

use super::deviation::{KELVIN, deviation};
use super::output::{Deviation, SensorSummary, Trend};
use super::readings::{Readings, Row};
use super::stretch;
use crate::document::suggest::listed;
use crate::document::time;
use crate::math::sort::sort_by;
use crate::measurement::{Measurement, Rows};

/// Most trends named for a sensor.
const TRENDS_NAMED: usize = 2;
/// Fewest sensors besides the worst one that share a sentence.
const FEWEST_ALIKE: usize = 3;
/// Least RMSE of a sensor that fails like another, as a share of that one's; the other one's share of it is at least that too.
const LEAST_ALIKE: f64 = 0.5;
/// How a sensor fails whose errors have no direction.
const BOTH_DIRECTIONS: &str = "the model is wrong in both directions";
/// Sensors that such a sentence names.
const NAMED: usize = 6;

/// A temperature difference (or another unit's) with its sign and two or three useful digits.
pub fn signed(value: f64, unit: &str) -> String {
    let digits = if value.abs() >= 9.95 { 1 } else { 2 };
    let text = format!("{value:+.digits$} {unit}");
    text.replace('-', "\u{2212}")
}

/// One sentence a sensor that fails, the worst sensor first; one for several that fail like a worse one.
///
/// A sensor fails where its RMSE on the readings for fitting or on those held out is above what the noise would give to so
/// many readings (95 %), or, where the noise is not known, where any reading in kelvin is beyond `limit_k`.
pub fn fails(
    sensors: &[SensorSummary],
    measurements: &[Measurement],
    trends: &[Trend],
    rows: &Readings,
    limit_k: Option<f64>,
) -> Vec<String> {
    // By how many times a sensor is beyond what is allowed, which compares sensors of different units.
    let excess = |sensor: &SensorSummary| {
        let sets = [&sensor.train, &sensor.held_out].into_iter().filter(|set| set.count > 0);
        let shares = sets.filter_map(|set| match (sensor.noise_rmse_of(set), limit_k) {
            (Some([_, high]), _) => Some(set.rmse / high),
            (None, Some(limit)) if sensor.unit == KELVIN => Some(set.max / limit),
            (None, _) => None,
        });
        shares.fold(0.0, f64::max)
    };
    let mut failing: Vec<(&SensorSummary, f64)> =
        sensors.iter().map(|sensor| (sensor, excess(sensor))).filter(|(_, excess)| *excess > 1.0).collect();
    sort_by(&mut failing, |a, b| b.1.total_cmp(&a.1));
    let mut rest: Vec<Failing<'_>> =
        failing.into_iter().map(|(sensor, _)| Failing::new(sensor, sensors, trends, rows)).collect();
    let mut sentences = Vec::new();
    while !rest.is_empty() {
        let first = rest.remove(0);
        sentences.push(first.sentence(measurements));
        if rest.iter().filter(|own| own.is_like(&first)).count() >= FEWEST_ALIKE {
            let alike: Vec<Failing<'_>> = rest.extract_if(.., |own| own.is_like(&first)).collect();
            sentences.push(together(&first, &alike));
        }
    }
    sentences
}

/// The last instant of a record, s.
fn longest_s(measurement: &Measurement) -> f64 {
    match &measurement.rows {
        Rows::Steady(_) => 0.0,
        Rows::Transient { inputs, .. } => inputs.longest_s(),
    }
}

/// A sensor that fails.
struct Failing<'a> {
    sensor: &'a SensorSummary,
    rows: Vec<Row<&'a str>>,
    /// All its deviations together.
    overall: Deviation,
    /// Which way the model is wrong.
    direction: &'static str,
    /// The trends of its error that are significant, strongest first.
    trends: Vec<&'a Trend>,
    /// ` in MEASUREMENT` where several measurements have the sensor: a transient in parts has each sensor once a part.
    of: String,
}

impl<'a> Failing<'a> {
    fn new(sensor: &'a SensorSummary, sensors: &[SensorSummary], trends: &'a [Trend], rows: &'a Readings) -> Self {
        let rows: Vec<Row<&str>> = rows.of(&sensor.measurement, &sensor.sensor).collect();
        let all: Vec<f64> = rows.iter().map(Row::deviation).collect();
        let overall = deviation(&all, None);
        let is_of_mean = |d: &&f64| (**d > 0.0) == (overall.mean > 0.0);
        let one_sided = all.iter().filter(is_of_mean).count() as f64 / all.len().max(1) as f64;
        let direction = match (overall.mean > 0.0, sensor.unit == KELVIN) {
            _ if one_sided < 0.75 => BOTH_DIRECTIONS,
            (true, true) => "the model is too cold",
            (false, true) => "the model is too hot",
            (true, false) => "the model is too low",
            (false, false) => "the model is too high",
        };
        let is_in_several =
            sensors.iter().any(|own| own.sensor == sensor.sensor && own.measurement != sensor.measurement);
        let of = if is_in_several { format!(" in {}", sensor.measurement) } else { String::new() };
        let is_own = |t: &&Trend| {
            t.measurement == sensor.measurement && t.sensor == sensor.sensor && t.slope.abs() > 3.0 * t.slope_error
        };
        let trends = trends.iter().filter(is_own).take(TRENDS_NAMED).collect();
        Self { sensor, rows, overall, direction, trends, of }
    }

    /// What its error goes with most.
    fn goes_with(&self) -> Option<&str> {
        self.trends.first().map(|trend| trend.against.as_str())
    }

    /// Whether it fails like a worse one of its measurement: in the same direction, by about as much, with the same input.
    fn is_like(&self, worse: &Self) -> bool {
        let [own, other] = [self.overall.rmse, worse.overall.rmse];
        self.sensor.measurement == worse.sensor.measurement
            && self.sensor.unit == worse.sensor.unit
            && self.direction == worse.direction
            && self.direction != BOTH_DIRECTIONS
            && self.goes_with() == worse.goes_with()
            && own >= LEAST_ALIKE * other
            && other >= LEAST_ALIKE * own
    }

    fn sentence(&self, measurements: &[Measurement]) -> String {
        let Self { sensor, rows, overall, direction, trends, of } = self;
        let mut text = format!(
            "{}{of}: {direction}; measured minus predicted is {} on average, RMSE {}",
            sensor.sensor,
            signed(overall.mean, &sensor.unit),
            signed(overall.rmse, &sensor.unit).trim_start_matches('+'),
        );
        if sensor.train.count > 0 && sensor.held_out.count > 0 {
            text.push_str(&format!(
                " ({} on the readings for fitting, {} on those held out)",
                signed(sensor.train.rmse, &sensor.unit).trim_start_matches('+'),
                signed(sensor.held_out.rmse, &sensor.unit).trim_start_matches('+'),
            ));
        }
        let worst = rows.iter().max_by(|a, b| a.deviation().abs().total_cmp(&b.deviation().abs()));
        if let Some(row) = worst {
            let place = match (row.phase, row.time_s) {
                (Some(phase), _) => format!("in phase {phase}"),
                (None, Some(time_s)) => {
                    let deviations: Vec<(f64, f64)> =
                        rows.iter().filter_map(|row| Some((row.time_s?, row.deviation()))).collect();
                    let own = measurements.iter().find(|own| own.name == sensor.measurement);
                    let at = time::instant(time_s, own.map_or(time_s, longest_s));
                    match own.and_then(|own| stretch::worst(own, &deviations)) {
                        Some(stretch) => format!("at {at}; worst stretch {stretch}"),
                        None => format!("at {at}"),
                    }
                }
                (None, None) => String::new(),
            };
            text.push_str(&format!(", at worst {} {place}", signed(row.deviation(), &sensor.unit)));
        }
        let named: Vec<String> = trends
            .iter()
            .map(|t| format!("{} ({} over its range)", t.against, signed(t.change, &sensor.unit)))
            .collect();
        if !named.is_empty() {
            text.push_str(&format!("; the error goes with {}", named.join(" and ")));
        }
        text.push('.');
        text
    }
}

/// A sentence on sensors that fail like a worse one.
fn together(first: &Failing<'_>, alike: &[Failing<'_>]) -> String {
    let unit = &first.sensor.unit;
    let range = |of: fn(&Deviation) -> f64, shown: fn(&str) -> &str| {
        let values = || alike.iter().map(|own| of(&own.overall));
        let ends = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
        let [least, most] = ends.map(|value| shown(&signed(value, unit)).to_owned());
        let number = least.strip_suffix(&format!(" {unit}")).unwrap_or(&least);
        if least == most { most } else { format!("{number} to {most}") }
    };
    let goes_with = first.goes_with().map_or_else(String::new, |input| format!("; the errors go with {input}"));
    format!(
        "{} fail like `{}`{}: {}; measured minus predicted is {} on average, RMSE {}{goes_with}.",
        listed(alike.iter().map(|own| own.sensor.sensor.as_str()), NAMED),
        first.sensor.sensor,
        alike.iter().map(|own| own.of.as_str()).find(|of| !of.is_empty()).unwrap_or(&first.of),
        first.direction,
        range(|own| own.mean, |text| text),
        range(|own| own.rmse, |text| text.trim_start_matches('+')),
    )
}
