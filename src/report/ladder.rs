//! The states of a model, from as delivered to tuned with effects, each with its error, the criteria that it keeps and
//! its worst sensor: what every summary says of a model against its measurements.

use crate::job::compare::{Deviation, Output, SensorSummary, Verdict};

/// The sensor with the largest root mean square of measured minus predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct WorstSensor {
    /// Its name.
    pub name: String,
    /// Mean of measured minus predicted over its readings, in the comparison's unit.
    pub mean: f64,
    /// Largest magnitude of the same.
    pub largest: f64,
}

/// A state of the model against the measurements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Standing {
    /// Root mean square of measured minus predicted over the readings for fitting; `None` where there are none.
    pub fitted: Option<f64>,
    /// The same over the readings held out.
    pub held_out: Option<f64>,
    /// How many criteria are kept, of how many; `None` where none is judged.
    pub kept: Option<[usize; 2]>,
    /// The worst sensor.
    pub worst: Option<WorstSensor>,
}

impl Standing {
    /// The error that counts: of the readings held out, where there are any.
    pub fn error(&self) -> Option<f64> {
        self.held_out.or(self.fitted)
    }

    /// Whether a criterion is broken.
    pub fn fails(&self) -> bool {
        self.kept.is_some_and(|[kept, of]| kept < of)
    }
}

/// SI unit of the statistics over several sensors: kelvin where any sensor reads in it, else that of the first.
pub fn unit(output: &Output) -> &str {
    let has_kelvin = output.sensors.iter().any(|sensor| sensor.unit == "K");
    if has_kelvin { "K" } else { output.sensors.first().map_or("", |sensor| sensor.unit.as_str()) }
}

/// The model of a comparison as delivered and, where it was tuned, tuned.
pub fn standings(output: &Output) -> Vec<Standing> {
    let delivered = standing(output, [&output.train, &output.held_out], &output.verdicts, |sensor| {
        Some([&sensor.train, &sensor.held_out])
    });
    let tuned = output.tuned.as_ref().map(|tuned| {
        standing(output, [&tuned.train, &tuned.held_out], &output.tuned_verdicts(), |sensor| {
            sensor.tuned.as_ref().map(|tuned| [&tuned.train, &tuned.held_out])
        })
    });
    std::iter::once(delivered).chain(tuned).collect()
}

fn standing(
    output: &Output,
    [train, held_out]: [&Deviation; 2],
    verdicts: &[Verdict],
    of: impl Fn(&SensorSummary) -> Option<[&Deviation; 2]>,
) -> Standing {
    let rmse = |deviation: &Deviation| (deviation.count > 0).then_some(deviation.rmse);
    let unit = unit(output);
    let worst = (output.sensors.iter())
        .filter(|sensor| sensor.unit == unit)
        .filter_map(|sensor| Some((sensor, over_all(of(sensor)?)?)))
        .filter(|(_, [square, ..])| square.is_finite())
        .max_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    Standing {
        fitted: rmse(train),
        held_out: rmse(held_out),
        kept: (!verdicts.is_empty()).then(|| [verdicts.iter().filter(|verdict| verdict.kept).count(), verdicts.len()]),
        worst: worst.map(|(sensor, [_, mean, largest])| WorstSensor { name: sensor.sensor.clone(), mean, largest }),
    }
}

/// Mean square, mean and largest magnitude over the readings for fitting and those held out together.
pub fn over_all(parts: [&Deviation; 2]) -> Option<[f64; 3]> {
    let count: u64 = parts.iter().map(|part| part.count).sum();
    let mean = |pick: fn(&Deviation) -> f64| {
        let sum: f64 = parts.iter().filter(|part| part.count > 0).map(|part| part.count as f64 * pick(part)).sum();
        sum / count as f64
    };
    let largest = parts.iter().filter(|part| part.count > 0).map(|part| part.max).fold(0.0, f64::max);
    (count > 0).then(|| [mean(|part| part.rmse * part.rmse), mean(|part| part.mean), largest])
}
