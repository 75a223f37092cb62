//! Tests drawn at random: steady campaigns, steps on a bench, orbits, long flights; and the sensors that watch them.

use serde::{Deserialize, Serialize};

use super::draw::{Draw, decimals, short};
use super::specification::{NetworkSpecification, NodeSketch};
use crate::expression::Symbol;
use crate::math::functions::cos;
use crate::measurement::{Initial, InputColumn, InputTable, Measurement, Phase, Rows, Sensor, Uncertain};
use crate::thermal::{Model, Quantity, QuantityValue};

/// Kinds of test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TestKind {
    /// Steady phases with inputs over their ranges.
    Steady,
    /// Inputs that step now and then, rows every minute or so.
    Steps,
    /// Inputs that follow an orbit, rows every minute.
    Orbit,
    /// Inputs that wander, rows every hours.
    Flight,
}

impl TestKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Steady, Self::Steps, Self::Orbit, Self::Flight];

    /// Whether it is a transient.
    pub fn is_transient(self) -> bool {
        self != Self::Steady
    }
}

/// Share of the rows that is held out.
const HELD_OUT: f64 = 0.25;
/// Period of a low orbit, s.
const ORBIT_S: f64 = 5560.0;
/// Where transients start that state a temperature, K.
const ROOM_K: f64 = 293.15;

/// A measurement without readings (all 0); the model receives the quantities that its sensors measure.
pub fn measurement(
    kind: TestKind,
    specification: &NetworkSpecification,
    model: &mut Model,
    draw: &mut Draw,
) -> Measurement {
    let sensors = sensors(specification, model, draw);
    let rows = if kind.is_transient() { transient(kind, specification, draw) } else { steady(specification, draw) };
    let mut measurement = Measurement {
        name: "test".to_owned(),
        rows,
        sensors,
        readings: Vec::new(),
        file: "data/test.csv".to_owned(),
        sha256: String::new(),
        unused_columns: Vec::new(),
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    measurement.readings = vec![Some(0.0); measurement.len() * measurement.sensors.len()];
    measurement
}

/// Sensors at most nodes, three at least, of one quality or two.
fn sensors(specification: &NetworkSpecification, model: &mut Model, draw: &mut Draw) -> Vec<Sensor> {
    let coarse = draw.scale(0.05, 0.5);
    let fine = if draw.happens(0.3) { short(0.05_f64.max(0.5 * coarse)) } else { coarse };
    let inner: Vec<usize> = (0..specification.nodes.len())
        .filter(|&node| matches!(specification.nodes[node].1, NodeSketch::Capacity(_)))
        .collect();
    let mut watched: Vec<usize> = inner.iter().copied().filter(|_| draw.happens(0.85)).collect();
    for node in inner {
        if watched.len() < 3 && !watched.contains(&node) {
            watched.push(node);
        }
    }
    watched.sort_unstable();
    let mut sensors = Vec::new();
    for node in watched {
        let name = specification.nodes[node].0.clone();
        // Networks are far smaller than what this type counts.
        let value = model.graph.symbol(Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX)));
        model.quantities.push(Quantity {
            name: name.clone(),
            unit: "K".to_owned(),
            is_temperature: true,
            value: QuantityValue::Instant(value),
        });
        let sigma = if draw.happens(0.5) { coarse } else { fine };
        sensors.push(Sensor {
            name,
            quantity: model.quantities.len() - 1,
            unit: "K".to_owned(),
            sigma: Some(Uncertain::Known(sigma)),
            bias: None,
            lag_s: None,
            behind_s: Vec::new(),
            correlation_time_s: None,
            white: None,
        });
    }
    sensors
}

/// A value of an input: pressures uniform in the logarithm, all others uniform.
fn value(specification: &NetworkSpecification, input: usize, draw: &mut Draw) -> f64 {
    let [lower, upper] = specification.inputs[input].range;
    if specification.inputs[input].unit == "Pa" { draw.scale(lower, upper) } else { draw.between(lower, upper) }
}

fn steady(specification: &NetworkSpecification, draw: &mut Draw) -> Rows {
    let count = draw.whole(8, 40);
    let mut phases: Vec<Phase> = (1..=count)
        .map(|number| Phase {
            name: format!("P{number:02}"),
            inputs: (0..specification.inputs.len()).map(|input| value(specification, input, draw)).collect(),
            held_out: false,
            ignored: None,
            stabilisation: None,
        })
        .collect();
    let mut left = (HELD_OUT * count as f64) as usize;
    while left > 0 {
        let phase = &mut phases[draw.position(count)];
        if !phase.held_out {
            phase.held_out = true;
            left -= 1;
        }
    }
    Rows::Steady(phases)
}

fn transient(kind: TestKind, specification: &NetworkSpecification, draw: &mut Draw) -> Rows {
    // Every row of a flight is an integration from corner to corner over hours: fewer do.
    let rows = draw.whole(100, if kind == TestKind::Flight { 250 } else { 600 });
    let step_s = match kind {
        TestKind::Orbit => 60.0,
        TestKind::Flight => 600.0 * draw.whole(6, 24) as f64,
        _ => 20.0 * draw.whole(1, 6) as f64,
    };
    let times_s: Vec<f64> = (0..rows).map(|row| step_s * row as f64).collect();
    let columns = (0..specification.inputs.len())
        .map(|input| {
            let hold = kind == TestKind::Steps;
            let values = match kind {
                TestKind::Orbit if specification.inputs[input].unit == "W/m2" => sun(&times_s, draw),
                TestKind::Orbit | TestKind::Flight => wander(specification, input, rows, draw),
                _ => steps(specification, input, rows, draw),
            };
            InputColumn { input, values, hold }
        })
        .collect();
    let base = specification.inputs.iter().map(|input| input.nominal).collect();
    let initial = if draw.happens(0.5) {
        Initial::Steady
    } else {
        let nodes = specification.nodes.len();
        Initial::Temperatures {
            values: vec![Uncertain::Known(ROOM_K); nodes],
            shared: (0..nodes).collect(),
            balanced: Vec::new(),
        }
    };
    let kept = rows - (HELD_OUT * rows as f64) as usize;
    Rows::Transient {
        inputs: InputTable { times_s, columns, base },
        initial,
        held_out: (0..rows).map(|row| row >= kept).collect(),
        ignored: vec![None; rows],
    }
}

/// Levels that hold for a while.
fn steps(specification: &NetworkSpecification, input: usize, rows: usize, draw: &mut Draw) -> Vec<f64> {
    let mut values = Vec::with_capacity(rows);
    while values.len() < rows {
        let level = value(specification, input, draw);
        let length = draw.whole(rows / 12 + 1, rows / 4 + 2);
        values.extend(std::iter::repeat_n(level, length.min(rows - values.len())));
    }
    values
}

/// Sun on a panel over orbits with an eclipse, W/m2.
fn sun(times_s: &[f64], draw: &mut Draw) -> Vec<f64> {
    let (phase, turn) = (draw.share(), draw.between(0.6, 2.4));
    let eclipse = draw.between(0.3, 0.4);
    times_s
        .iter()
        .map(|time| {
            let share = time / ORBIT_S - (time / ORBIT_S).floor();
            if share < eclipse {
                return 0.0;
            }
            let angle = core::f64::consts::TAU * (turn * time / ORBIT_S + phase);
            decimals(1361.0 * cos(angle).max(0.0), 1)
        })
        .collect()
}

/// Straight lines between levels.
fn wander(specification: &NetworkSpecification, input: usize, rows: usize, draw: &mut Draw) -> Vec<f64> {
    let mut values = vec![value(specification, input, draw)];
    while values.len() < rows {
        let from = values[values.len() - 1];
        let to = value(specification, input, draw);
        let length = draw.whole(rows / 16 + 1, rows / 5 + 2);
        values.extend((1..=length).map(|row| short(from + (to - from) * row as f64 / length as f64)));
    }
    values.truncate(rows);
    values
}
