//! Additions to sensors: a law of the reading, a lag, a clock that is off, exchanged channels.
//!
//! A law is an expression over the model, so a sensor that has one measures a quantity of its own: solutions and
//! derivatives follow without more.

use crate::expression::{ExprId, Symbol, Term};
use crate::thermal::{Model, Node, NodeKind, Quantity, QuantityValue};

use super::{ApplyError, Work};
use crate::effect::Limits;
use crate::effect::place::{SensorPlace, Site};

/// What becomes of a sensor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SensorChange {
    /// It reads another quantity than it measures.
    Reading {
        /// The sensor.
        sensor: String,
        /// The quantity that it measures.
        from: usize,
        /// The quantity that it reads.
        to: usize,
    },
    /// It follows late.
    Lag {
        /// The sensor.
        sensor: String,
        /// The parameter of the model that is its time constant, s.
        parameter: usize,
    },
    /// Its clock is behind.
    Clock {
        /// The sensor.
        sensor: String,
        /// The parameter of the model that is the time by which it is, s.
        parameter: usize,
    },
    /// Two sensors' channels are exchanged.
    Swap {
        /// The sensors.
        sensors: [String; 2],
    },
}

/// 0 degC in K, about which slopes of thermometers turn.
const CELSIUS_ZERO_K: f64 = crate::expression::unit::CELSIUS_ZERO_K;

impl SensorChange {
    /// The sensor whose reading changes by itself.
    pub fn of_sensor(&self) -> Option<&str> {
        match self {
            Self::Reading { sensor, .. } | Self::Lag { sensor, .. } | Self::Clock { sensor, .. } => Some(sensor),
            Self::Swap { .. } => None,
        }
    }

    /// The parameter of the model that is a time of the sensor.
    pub fn time(&self) -> Option<usize> {
        match self {
            Self::Lag { parameter, .. } | Self::Clock { parameter, .. } => Some(*parameter),
            Self::Reading { .. } | Self::Swap { .. } => None,
        }
    }
}

impl Work<'_, '_> {
    /// `reading`, `lag`, `clock` and `swap`.
    pub(super) fn sensors(&mut self) -> Result<(), ApplyError> {
        let adds = &self.instance.effect.form.adds.value;
        if let Some(reading) = &adds.reading {
            for sensor in self.place_sensors()? {
                let to = self.reading(&sensor, &reading.value)?;
                self.applied.sensors.push(SensorChange::Reading { sensor: sensor.name, from: sensor.quantity, to });
            }
        }
        if let Some(lag) = &adds.lag {
            self.at_other_times(&lag.value, |sensor, parameter| SensorChange::Lag { sensor, parameter })?;
        }
        if let Some(clock) = &adds.clock {
            self.at_other_times(&clock.value, |sensor, parameter| SensorChange::Clock { sensor, parameter })?;
        }
        if adds.swap.is_some() {
            let sensors: Vec<String> = self.place_sensors()?.into_iter().map(|sensor| sensor.name).collect();
            let sensors: [String; 2] = sensors.try_into().map_err(|_| self.misplaced())?;
            self.applied.sensors.push(SensorChange::Swap { sensors });
        }
        Ok(())
    }

    /// Changes when the sensors show what happens, by a time that is one of the parameters.
    fn at_other_times(&mut self, time: &str, change: fn(String, usize) -> SensorChange) -> Result<(), ApplyError> {
        let id = self.expression(time, &[])?;
        let Term::Symbol(Symbol::Parameter(parameter)) = self.model.graph.term(id) else {
            return Err(self.misplaced());
        };
        for sensor in self.place_sensors()? {
            self.applied.sensors.push(change(sensor.name, parameter as usize));
        }
        Ok(())
    }

    fn place_sensors(&self) -> Result<Vec<SensorPlace>, ApplyError> {
        match &self.instance.site {
            Site::Sensors(sensors) => Ok(sensors.clone()),
            _ => Err(self.misplaced()),
        }
    }

    /// Adds the quantity that a sensor reads and gives its index.
    fn reading(&mut self, sensor: &SensorPlace, text: &str) -> Result<usize, ApplyError> {
        let Some(measured) = self.model.quantities.get(sensor.quantity).cloned() else { return Err(self.misplaced()) };
        let truth = measured.value.expression();
        let zero = self.model.graph.number(if measured.is_temperature { CELSIUS_ZERO_K } else { 0.0 });
        let mut locals = vec![("T", truth), ("zero", zero)];
        // In a large model the balance costs more than everything else here, and most laws name no rate.
        if !Limits::default().choose_members(self.model) || self.names_rate(text) {
            match self.rate(truth) {
                Some(rate) => locals.push(("rate", rate)),
                None if self.names_rate(text) => {
                    let reason = self.without_rate(truth, &measured.name);
                    return Err(ApplyError::NoRate { sensor: sensor.name.clone(), reason });
                }
                None => {}
            }
        }
        let value = self.expression(text, &locals)?;
        self.model.quantities.push(Quantity {
            name: format!("{} with {}", sensor.name, self.instance.name),
            unit: measured.unit,
            is_temperature: measured.is_temperature,
            value: QuantityValue::Instant(value),
        });
        Ok(self.model.quantities.len() - 1)
    }

    /// Why what is measured has no rate, of a quantity of this name.
    fn without_rate(&self, truth: ExprId, name: &str) -> String {
        let Term::Symbol(Symbol::Node(node)) = self.model.graph.term(truth) else {
            return format!("it is `{name}`, which is computed and no temperature of a node by itself");
        };
        match self.model.nodes.get(node as usize) {
            Some(Node { name, kind: NodeKind::Boundary { .. }, .. }) => {
                format!("the temperature of the boundary `{name}` is given")
            }
            _ => format!("node `{name}` has no heat capacity"),
        }
    }

    /// Whether an expression names the rate: it does where its value follows a stand-in for it.
    fn names_rate(&mut self, text: &str) -> bool {
        let stand_in = self.model.graph.symbol(Symbol::Local(0));
        let locals = [("T", stand_in), ("zero", stand_in)];
        self.expression(text, &locals).is_err()
    }

    /// Rate of change of a node's temperature, K/s: its balance over its capacity. Controlled heaters count with
    /// their average duty.
    fn rate(&mut self, truth: ExprId) -> Option<ExprId> {
        let Term::Symbol(Symbol::Node(node)) = self.model.graph.term(truth) else { return None };
        let node = node as usize;
        let NodeKind::Diffusion { capacity } = self.model.nodes.get(node)?.kind else { return None };
        let mut heats = Vec::new();
        let Model { graph, elements, .. } = &mut *self.model;
        for element in elements.iter() {
            let contribution = element.contribution(graph, &mut Vec::new(), false);
            heats.extend(contribution.heat.into_iter().filter(|(into, _)| *into == node).map(|(_, heat)| heat));
        }
        let balance = self.model.graph.sum(&heats);
        Some(self.model.graph.divide(balance, capacity))
    }
}
