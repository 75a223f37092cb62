//! Measurements, resolved: SI units, one row a phase or an instant, one column a sensor.
//!
//! `unknown`: what of them is inferred, and measurements with such values put in. `prediction`: what a network predicts of
//! their readings (`timing`: of sensors that follow slowly, which `lag` knows, or whose clock is off). `scatter`: what repeated readings say of the noise. `clock`: when
//! they were taken. May not know priors of models,
//! likelihoods or effects beyond what they change of a sensor.

mod clock;
pub mod lag;
pub mod prediction;
pub mod scatter;
mod sensor_places;
pub mod timing;
pub mod unknown;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::document::canonical::canonical;
use crate::document::{Diagnostic, code, hash};
use crate::effect::SensorChange;
use crate::expression::Symbol;
use crate::random::Distribution;
use crate::thermal::Model;
pub use crate::thermal::transient::{InputColumn, InputTable};
pub use clock::calendar;
pub use sensor_places::sensor_places;
use timing::Timing;

/// A number that is known, or has a prior and is inferred.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Uncertain {
    /// Known, SI.
    Known(f64),
    /// Inferred under this prior, SI; its median is the nominal value.
    Inferred(Distribution),
    /// Inferred under a prior that is not centred on the nominal value, such as a start temperature that an earlier pass found.
    InferredFrom {
        /// The prior, SI.
        prior: Distribution,
        /// The nominal value, SI.
        nominal: f64,
    },
    /// A parameter of the model, such as an adopted effect's.
    Parameter {
        /// Its index in the model.
        index: usize,
        /// Its nominal value, SI.
        nominal: f64,
    },
}

impl Uncertain {
    /// The known value, the stated nominal value, or the prior's median.
    pub fn nominal(&self) -> f64 {
        match self {
            Self::Known(value) => *value,
            Self::Inferred(prior) => prior.quantile(0.5),
            Self::InferredFrom { nominal, .. } | Self::Parameter { nominal, .. } => *nominal,
        }
    }

    /// The value at given parameters of the model: where it is no parameter, its nominal value.
    pub fn at(&self, parameters: &[f64]) -> f64 {
        match self {
            Self::Parameter { index, nominal } => parameters.get(*index).copied().unwrap_or(*nominal),
            Self::Known(_) | Self::Inferred(_) | Self::InferredFrom { .. } => self.nominal(),
        }
    }

    /// The prior under which it is inferred beside the model's parameters; `None` where it is known or one of these.
    pub fn prior(&self) -> Option<&Distribution> {
        match self {
            Self::Known(_)
            | Self::Inferred(Distribution::Fixed(_))
            | Self::InferredFrom { prior: Distribution::Fixed(_), .. }
            | Self::Parameter { .. } => None,
            Self::Inferred(prior) | Self::InferredFrom { prior, .. } => Some(prior),
        }
    }
}

/// A sensor: what it measures and how well.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensor {
    /// Name, the column of the data.
    pub name: String,
    /// Index of the measured quantity in the model's list.
    pub quantity: usize,
    /// Unit of the readings as written, for people.
    pub unit: String,
    /// Standard deviation of the noise, SI.
    pub sigma: Option<Uncertain>,
    /// Additive error of the sensor, SI.
    pub bias: Option<Uncertain>,
    /// Time constant of the sensor, s.
    pub lag_s: Option<Uncertain>,
    /// Times by which the clock of its rows is behind that of the inputs, s: what is declared and what effects add; their sum counts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub behind_s: Vec<Uncertain>,
    /// Correlation time of the noise, s; `None`: white.
    pub correlation_time_s: Option<Uncertain>,
    /// Standard deviation of white noise beside correlated noise, SI; `None`: none.
    pub white: Option<Uncertain>,
}

impl Sensor {
    /// Standard deviation of one reading, SI, where noise is nominal; 0 where none is stated.
    pub fn total_sd(&self) -> f64 {
        let part = |value: &Option<Uncertain>| value.as_ref().map_or(0.0, Uncertain::nominal);
        total_sd(part(&self.sigma), part(&self.white))
    }

    /// When it shows what happens, at given parameters of the model.
    pub fn timing(&self, parameters: &[f64]) -> Timing {
        let lag_s = self.lag_s.as_ref().map_or(0.0, |lag| lag.at(parameters));
        Timing { lag_s, behind_s: self.behind_s.iter().map(|behind| behind.at(parameters)).sum() }
    }
}

/// Standard deviation of noise with two independent parts, one of which may be white beside correlated.
pub fn total_sd(sigma: f64, white: f64) -> f64 {
    if white == 0.0 { sigma } else { (sigma * sigma + white * white).sqrt() }
}

/// How a transient begins.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Initial {
    /// At given or fitted temperatures.
    Temperatures {
        /// Temperature of every node (boundaries' entries are ignored), K.
        values: Vec<Uncertain>,
        /// Nodes whose temperature is one and the same value: where it is fitted, it is one unknown.
        shared: Vec<usize>,
        /// Nodes without a start temperature of their own, which start in balance with the others whether they store heat
        /// or not; their values are first guesses.
        balanced: Vec<usize>,
    },
    /// The steady state at the first row's inputs.
    Steady,
    /// The periodic state of the inputs' cycle.
    Periodic,
}

/// A phase of a steady measurement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Phase {
    /// Name.
    pub name: String,
    /// Value of every input of the model, SI.
    pub inputs: Vec<f64>,
    /// Kept from every fit.
    pub held_out: bool,
    /// Why it is left out altogether.
    pub ignored: Option<String>,
    /// How steady it was, where a time series was given.
    pub stabilisation: Option<Stabilisation>,
}

/// What a window of a time series says about steadiness, by sensor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stabilisation {
    /// Begin of the window, s.
    pub from_s: f64,
    /// End of the window, s.
    pub to_s: f64,
    /// Slope of each sensor, SI unit a second.
    pub slopes: Vec<Option<f64>>,
    /// Standard error of each slope.
    pub slope_errors: Vec<Option<f64>>,
    /// Probability of each slope from the sensor's scatter alone.
    pub chances: Vec<Option<f64>>,
    /// Standard error of each sensor's mean over the window, SI.
    pub mean_errors: Vec<Option<f64>>,
}

/// Probability with which scatter alone makes any sensor of a phase drift.
const DRIFT_CHANCE: f64 = 0.01;

impl Stabilisation {
    /// The steepest of these sensors that drift: their slope is above the limit (SI unit a second), and steeper than scatter
    /// explains, with a probability of 1 % over all of them.
    pub fn drifting(&self, sensors: &[usize], limit: f64) -> Option<usize> {
        let is_clear = |sensor: usize| {
            self.chances[sensor].is_some_and(|chance| chance * (sensors.len() as f64) < DRIFT_CHANCE)
                && self.slopes[sensor].is_some_and(|slope| slope.abs() > limit)
        };
        self.steepest(sensors.iter().copied().filter(|&sensor| is_clear(sensor)))
    }

    /// The sensor with the steepest slope.
    pub fn steepest(&self, sensors: impl Iterator<Item = usize>) -> Option<usize> {
        let slopes = sensors.filter_map(|sensor| Some((sensor, self.slopes[sensor]?.abs())));
        slopes.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(sensor, _)| sensor)
    }
}

/// Steady phases or a transient.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rows {
    /// One row a phase.
    Steady(Vec<Phase>),
    /// One row an instant.
    Transient {
        /// Inputs, whose `times_s` are the rows' instants.
        inputs: InputTable,
        /// How it begins.
        initial: Initial,
        /// Rows kept from every fit.
        held_out: Vec<bool>,
        /// Rows left out altogether, with the reason.
        ignored: Vec<Option<String>>,
    },
}

/// Something doubtful about the data of a measurement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Doubt {
    /// Name of its kind, such as `start-apart` (`bmv explain`).
    pub code: String,
    /// What is doubtful, in a sentence without its full stop.
    pub message: String,
    /// What to do about it, likewise.
    pub repair: Option<String>,
}

impl From<&Diagnostic> for Doubt {
    /// The warning, as a result repeats it: without the signs that mark names in a terminal.
    fn from(warning: &Diagnostic) -> Self {
        let plain = |text: &String| text.replace('`', "");
        Self {
            code: warning.code.name.to_owned(),
            message: plain(&warning.message),
            repair: warning.help.as_ref().map(plain),
        }
    }
}

impl Doubt {
    /// Whether it is a start of a transient that its own first readings contradict: all that follows shows it then.
    pub fn is_of_start(&self) -> bool {
        self.code == code::START_APART.name
    }

    /// What to check before relying on a result, and how it is mended.
    pub fn in_words(&self) -> String {
        let repair = self.repair.as_ref().map_or_else(String::new, |repair| format!(" Repair: {repair}."));
        format!("Check this before relying on the result: {}.{repair}", self.message)
    }
}

/// A measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Name.
    pub name: String,
    /// Phases or instants.
    pub rows: Rows,
    /// Sensors.
    pub sensors: Vec<Sensor>,
    /// Readings, SI, row by row (`rows x sensors`); `None` is missing.
    pub readings: Vec<Option<f64>>,
    /// File within the study.
    pub file: String,
    /// SHA-256 of the file's bytes, lower-case hex.
    pub sha256: String,
    /// Columns of the file that nothing uses.
    pub unused_columns: Vec<String>,
    /// When its time is 0, s since 1970-01-01 of the clock that the record was taken by; for people.
    pub time_zero_s: Option<f64>,
    /// Whether it goes on after a gap in a record: parts that no sensor shows then begin at no known temperature.
    pub follows_gap: bool,
    /// What is doubtful about the data: inputs without a value, a start beside the first readings, phases that drift.
    /// Results that rest on the data repeat it.
    pub doubts: Vec<Doubt>,
}

impl Measurement {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match &self.rows {
            Rows::Steady(phases) => phases.len(),
            Rows::Transient { inputs, .. } => inputs.times_s.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What inputs, nominal parameters and the time are in a row, SI; no number for what else an expression may use.
    pub fn value_in(&self, model: &Model, row: usize) -> impl Fn(Symbol) -> f64 {
        move |symbol| match (symbol, &self.rows) {
            (Symbol::Input(own), Rows::Steady(phases)) => {
                phases[row].inputs.get(own as usize).copied().unwrap_or(f64::NAN)
            }
            (Symbol::Input(own), Rows::Transient { inputs, .. }) => inputs.in_row(row, own as usize),
            (Symbol::Time, Rows::Steady(_)) => 0.0,
            (Symbol::Time, Rows::Transient { inputs, .. }) => inputs.times_s[row],
            (Symbol::Parameter(own), _) => model.parameters[own as usize].nominal,
            _ => f64::NAN,
        }
    }

    /// What of the measurement decides a result, for a job's key: the file's hash, and a hash of everything that was
    /// read from it and declared for it.
    pub fn identity(&self) -> Value {
        let resolved = json!([self.rows, self.sensors, self.readings]);
        // What was read is finite, and JSON has no other numbers.
        let text = canonical(&resolved).unwrap_or_else(|_| resolved.to_string());
        let mut identity =
            json!({"name": self.name, "file": self.sha256, "resolved": hash::sha256_hex(text.as_bytes())});
        if !self.doubts.is_empty() {
            identity["doubts"] = json!(self.doubts);
        }
        if let Some(zero) = self.time_zero_s {
            identity["time_zero_s"] = json!(zero);
        }
        if self.follows_gap {
            identity["follows_gap"] = json!(true);
        }
        identity
    }

    /// Reading of a sensor in a row.
    pub fn reading(&self, row: usize, sensor: usize) -> Option<f64> {
        self.readings[row * self.sensors.len() + sensor]
    }

    /// Positions of the sensors whose quantities are in kelvin.
    pub fn sensors_in_kelvin(&self, model: &Model) -> Vec<usize> {
        let unit = |sensor: &Sensor| model.quantities[sensor.quantity].unit.as_str();
        (0..self.sensors.len()).filter(|&position| unit(&self.sensors[position]) == "K").collect()
    }

    /// Whether a row is kept from every fit.
    pub fn held_out(&self, row: usize) -> bool {
        match &self.rows {
            Rows::Steady(phases) => phases[row].held_out,
            Rows::Transient { held_out, .. } => held_out[row],
        }
    }

    /// Whether a row is left out altogether.
    pub fn ignored(&self, row: usize) -> bool {
        match &self.rows {
            Rows::Steady(phases) => phases[row].ignored.is_some(),
            Rows::Transient { ignored, .. } => ignored[row].is_some(),
        }
    }

    /// Whether a row takes part in fits.
    pub fn is_fitted(&self, row: usize) -> bool {
        !self.held_out(row) && !self.ignored(row)
    }

    /// The rows that take part in fits, in order.
    pub fn fitted_rows(&self) -> impl DoubleEndedIterator<Item = usize> + Clone + '_ {
        (0..self.len()).filter(|&row| self.is_fitted(row))
    }

    /// Gives a node that was added a start temperature: that of its host.
    pub fn begin_like(&mut self, node: usize, host: usize) {
        if let Rows::Transient { initial: Initial::Temperatures { values, shared, balanced }, .. } = &mut self.rows
            && let Some(value) = values.get(host).cloned()
        {
            if shared.contains(&host) {
                shared.push(node);
            }
            if balanced.contains(&host) {
                balanced.push(node);
            }
            // Boundaries that effects added before it have no start temperature.
            values.resize(node.max(values.len()), Uncertain::Known(0.0));
            values.push(value);
        }
    }

    /// Changes what sensors read, as an effect on them does; `nominal` is the nominal value of a time that the effect gives, s. A
    /// sensor that has a lag already gets the new one; times of clocks add up.
    pub fn change_sensors(&mut self, change: &SensorChange, nominal: f64) {
        match change {
            SensorChange::Reading { sensor, from, to } => {
                for matching in
                    self.sensors.iter_mut().filter(|matching| matching.name == *sensor && matching.quantity == *from)
                {
                    matching.quantity = *to;
                }
            }
            SensorChange::Lag { sensor, parameter } => {
                for matching in self.sensors.iter_mut().filter(|matching| matching.name == *sensor) {
                    matching.lag_s = Some(Uncertain::Parameter { index: *parameter, nominal });
                }
            }
            SensorChange::Clock { sensor, parameter } => {
                for matching in self.sensors.iter_mut().filter(|matching| matching.name == *sensor) {
                    matching.behind_s.push(Uncertain::Parameter { index: *parameter, nominal });
                }
            }
            SensorChange::Swap { sensors: [a, b] } => {
                let find = |name: &str| self.sensors.iter().position(|sensor| sensor.name == name);
                let (Some(a), Some(b)) = (find(a), find(b)) else { return };
                // Everything but the channel's own name and unit goes over.
                self.sensors.swap(a, b);
                let first = (self.sensors[a].name.clone(), self.sensors[a].unit.clone());
                let second = (self.sensors[b].name.clone(), self.sensors[b].unit.clone());
                (self.sensors[a].name, self.sensors[a].unit) = second;
                (self.sensors[b].name, self.sensors[b].unit) = first;
            }
        }
    }
}
