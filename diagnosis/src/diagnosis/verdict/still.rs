//! Channels that stand still while the model moves: frozen or saturated, which no physics of the hardware explains.

use crate::diagnosis::{Problem, Refit};
use crate::expression::Unit;
use crate::measurement::Rows;
use crate::measurement::prediction::Predictor;
use crate::measurement::unknown::with_unknowns;

/// Fewest readings in a row that are the same.
const LEAST_READINGS: usize = 8;
/// The model moves meanwhile by this many standard deviations of the noise and steps of the channel.
const MOVES: f64 = 5.0;

/// A stretch of readings that are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Still {
    /// First and last row.
    pub rows: [usize; 2],
    /// The reading, SI.
    pub reading: f64,
    /// By how much the prediction moves meanwhile, SI.
    pub moves: f64,
}

/// What is said of channels of transients that stand still at a fit of the baseline model.
pub(crate) fn warnings(problem: &Problem, baseline: &Refit) -> Vec<String> {
    let mut said = Vec::new();
    let Ok(hypothesis) = problem.hypothesis(&[], 1.0) else { return said };
    let (Ok(likelihood), Ok(predictor)) = (hypothesis.likelihood(problem), Predictor::new(&hypothesis.model, &[]))
    else {
        return said;
    };
    let full = likelihood.full_parameters(&baseline.unknowns);
    let known = baseline.by_name();
    let inputs: Vec<String> = hypothesis.model.inputs.iter().map(|input| input.name.clone()).collect();
    let nodes: Vec<String> = hypothesis.model.nodes.iter().map(|node| node.name.clone()).collect();
    let mut workspace = predictor.workspace();
    for measurement in &problem.measurements {
        let Rows::Transient { inputs: table, .. } = &measurement.rows else { continue };
        let fixed = with_unknowns(measurement, &inputs, &nodes, &|name: &str| known.get(name).copied());
        let predicted = predictor.predict(&mut workspace, &fixed, &full).readings;
        let width = measurement.sensors.len();
        for (place, sensor) in measurement.sensors.iter().enumerate() {
            let readings: Vec<Option<f64>> =
                (0..measurement.len()).map(|row| measurement.reading(row, place)).collect();
            let own: Vec<f64> = predicted.iter().skip(place).step_by(width.max(1)).copied().collect();
            let sigma = fixed.sensors[place].total_sd();
            let Some(still) = still(&readings, &own, sigma) else { continue };
            let unit = Unit::parse(&sensor.unit).ok();
            let shown = |si: f64| unit.as_ref().map_or(si, |unit| unit.from_si(si));
            let [from, to] = still.rows.map(|row| table.times_s[row]);
            said.push(format!(
                "sensor `{}` of `{}` reads {} {} without a change from {from} s to {to} s, while the model moves by {:.1} {}. If the channel \
                 froze, or was at the end of its range, empty its cells there, and diagnose again; if something held the hardware, as \
                 melting or a thermostat does, the model lacks that",
                sensor.name,
                measurement.name,
                (shown(still.reading) * 1e6).round() / 1e6,
                sensor.unit,
                still.moves,
                hypothesis.model.quantities[sensor.quantity].unit,
            ));
        }
    }
    said
}

/// The longest stretch that stands still. Coarse steps make readings that are the same too, but not while the temperature goes
/// through several of them.
pub fn still(readings: &[Option<f64>], predicted: &[f64], sigma: f64) -> Option<Still> {
    let present: Vec<(usize, f64)> = (0..).zip(readings).filter_map(|(row, own)| Some((row, (*own)?))).collect();
    let differences = present.windows(2).map(|two| (two[1].1 - two[0].1).abs()).filter(|by| *by > 0.0);
    let step = differences.fold(f64::INFINITY, f64::min);
    let step = if step.is_finite() { step } else { 0.0 };
    let stretches = present.chunk_by(|a, b| a.1 == b.1).filter(|stretch| stretch.len() >= LEAST_READINGS);
    let moving = stretches.filter_map(|stretch| {
        let of = stretch.iter().map(|(row, _)| predicted[*row]);
        let (least, most) =
            of.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), own| (own.min(least), own.max(most)));
        let (moves, rows) = (most - least, [stretch[0].0, stretch[stretch.len() - 1].0]);
        (moves > MOVES * (sigma + step)).then_some((stretch.len(), Still { rows, reading: stretch[0].1, moves }))
    });
    moving.reduce(|a, b| if b.0 > a.0 { b } else { a }).map(|(_, still)| still)
}
