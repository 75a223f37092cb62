//! What is inferred of the data beside the model's parameters: its names, and measurements with such values put in.

use crate::measurement::{Initial, Measurement, Rows, Uncertain};
use crate::random::Distribution;

/// A number of the likelihood: known, or one of the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Known, SI.
    Known(f64),
    /// Place among the unknowns.
    Unknown(usize),
}

impl Value {
    /// The value at given unknowns.
    #[inline]
    pub fn at(self, unknowns: &[f64]) -> f64 {
        match self {
            Self::Known(value) => value,
            Self::Unknown(place) => unknowns[place],
        }
    }

    /// Its place among the unknowns.
    #[inline]
    pub fn place(self) -> Option<usize> {
        match self {
            Self::Known(_) => None,
            Self::Unknown(place) => Some(place),
        }
    }
}

/// The unknowns of a likelihood, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unknowns {
    /// Names.
    pub names: Vec<String>,
    /// Priors, SI.
    pub priors: Vec<Distribution>,
    /// Units in which people read them; the values are SI.
    pub units: Vec<String>,
    /// Index in the model of each unknown that is a parameter of the model; these come first.
    pub model: Vec<usize>,
}

impl Unknowns {
    /// Appends an unknown.
    pub fn push(&mut self, name: String, prior: Distribution, unit: &str) -> Value {
        self.names.push(name);
        self.priors.push(prior);
        self.units.push(unit.to_owned());
        Value::Unknown(self.names.len() - 1)
    }

    /// A value as it stands, the unknown that it is already, or a further one where it is inferred; `parameters` are
    /// the values of the model's parameters.
    pub fn add(&mut self, name: String, value: &Uncertain, unit: &str, parameters: &[f64]) -> Value {
        if let Uncertain::Parameter { index, .. } = value {
            let place = self.model.iter().position(|model_index| model_index == index);
            return place.map_or(Value::Known(value.at(parameters)), Value::Unknown);
        }
        match value.prior() {
            Some(prior) => self.push(name, *prior, unit),
            None => Value::Known(value.nominal()),
        }
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }
}

/// Name of something inferred of a sensor: `sigma`, `white`, `correlation_time`, `bias`, `lag`, `clock_behind`.
pub fn sensor_name(measurement: &str, sensor: &str, what: &str) -> String {
    format!("{measurement}.{sensor}.{what}")
}

/// Name of a fitted start temperature; `all` for one that nodes share.
pub fn start_name(measurement: &str, node: &str) -> String {
    format!("{measurement}.start.{node}")
}

/// Name of the constant error of an input.
pub fn bias_name(input: &str) -> String {
    format!("{input}.bias")
}

/// The name that stands for nodes with a common start temperature.
pub const ALL: &str = "all";

/// A measurement in which everything inferred that `find` knows by its name has that value, and inputs are shifted by
/// their constant errors; `inputs` and `nodes` are the model's names.
pub fn with_unknowns(
    measurement: &Measurement,
    inputs: &[String],
    nodes: &[String],
    find: &dyn Fn(&str) -> Option<f64>,
) -> Measurement {
    let mut fixed = measurement.clone();
    let set = |value: &mut Uncertain, name: String| {
        if value.prior().is_some()
            && let Some(fitted) = find(&name)
        {
            *value = Uncertain::Known(fitted);
        }
    };
    for sensor in &mut fixed.sensors {
        let entries = [
            (&mut sensor.sigma, "sigma"),
            (&mut sensor.white, "white"),
            (&mut sensor.correlation_time_s, "correlation_time"),
            (&mut sensor.bias, "bias"),
            (&mut sensor.lag_s, "lag"),
        ];
        for (value, what) in entries {
            if let Some(value) = value {
                set(value, sensor_name(&measurement.name, &sensor.name, what));
            }
        }
        for value in &mut sensor.behind_s {
            set(value, sensor_name(&measurement.name, &sensor.name, "clock_behind"));
        }
    }
    let shifts: Vec<f64> = inputs.iter().map(|input| find(&bias_name(input)).unwrap_or(0.0)).collect();
    match &mut fixed.rows {
        Rows::Steady(phases) => {
            for phase in phases {
                for (value, shift) in phase.inputs.iter_mut().zip(&shifts) {
                    *value += shift;
                }
            }
        }
        Rows::Transient { inputs: table, initial, .. } => {
            *table = shifted(table, &shifts);
            if let Initial::Temperatures { values, shared, .. } = initial {
                for (node, value) in values.iter_mut().enumerate() {
                    let name = if shared.contains(&node) { ALL } else { nodes.get(node).map_or("", String::as_str) };
                    set(value, start_name(&measurement.name, name));
                }
            }
        }
    }
    fixed
}

/// A table of inputs with constants added to each input.
pub(crate) fn shifted(table: &crate::measurement::InputTable, shifts: &[f64]) -> crate::measurement::InputTable {
    let mut table = table.clone();
    for (value, shift) in table.base.iter_mut().zip(shifts) {
        *value += shift;
    }
    for column in &mut table.columns {
        let shift = shifts.get(column.input).copied().unwrap_or(0.0);
        for value in &mut column.values {
            *value += shift;
        }
    }
    table
}
