//! Controlled heaters: a thermostat with hysteresis and a proportional controller.
//!
//! A thermostat switches on when its sensing node falls below `on` and off when it rises above `off`. In a steady
//! solution, which has no history, it delivers the average that its cycling would: the duty falls linearly from 1
//! at `on` to 0 at `off`. A proportional heater's duty falls linearly from 1 to 0 over `band` about its set point.

use serde_json::{Value, json};

use crate::expression::{Binary, ExprId, Graph, Symbol, Unary};

use super::{Contribution, Description, Drawing, Physics, Source};
use super::conductor::temperature;

/// How a heater is controlled. Temperatures in K, free of node temperatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeaterControl {
    /// On below `on`, off above `off`.
    Thermostat {
        /// Switches on below, K.
        on: ExprId,
        /// Switches off above, K.
        off: ExprId,
    },
    /// Duty 1 at `set_point - band / 2`, 0 at `set_point + band / 2`.
    Proportional {
        /// Middle of the band, K.
        set_point: ExprId,
        /// Width of the band, K.
        band: ExprId,
    },
}

/// A controlled heater.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heater {
    /// The node that is heated.
    pub into: usize,
    /// The node that the controller senses.
    pub senses: usize,
    /// Power when fully on, W.
    pub power: ExprId,
    /// How it is controlled.
    pub control: HeaterControl,
}

impl Physics for Heater {
    fn kind(&self) -> &'static str {
        "heater"
    }

    fn contribution(&self, graph: &mut Graph, switches: &mut Vec<Switch>, switched: bool) -> Contribution {
        let sensed = temperature(graph, self.senses);
        let band = match self.control {
            HeaterControl::Thermostat { on, off } => graph.subtract(off, on),
            HeaterControl::Proportional { band, .. } => band,
        };
        let duty = match self.control {
            HeaterControl::Thermostat { on, off } if switched => {
                let mode = Symbol::Mode(u32::try_from(switches.len()).unwrap_or(u32::MAX));
                let below = graph.subtract(on, sensed);
                let above = graph.subtract(sensed, off);
                switches.push(Switch { on: below, off: above });
                graph.symbol(mode)
            }
            HeaterControl::Thermostat { off, .. } => falling_ramp(graph, sensed, off, band),
            HeaterControl::Proportional { set_point, .. } => {
                let half = graph.number(0.5);
                let half_band = graph.multiply(half, band);
                let end = graph.add(set_point, half_band);
                falling_ramp(graph, sensed, end, band)
            }
        };
        let heat = graph.multiply(duty, self.power);
        let balance_scale = graph.unary(Unary::Abs, self.power);
        Contribution {
            heat: vec![(self.into, heat)],
            balance_scale: vec![(self.into, balance_scale)],
            through: Some(heat),
            duty: Some(duty),
            band: Some(band),
            ..Contribution::default()
        }
    }

    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        json!({
            "into": self.into,
            "senses": self.senses,
            "power": number(self.power),
            "control": match self.control {
                HeaterControl::Thermostat { on, off } => json!({"thermostat": [number(on), number(off)]}),
                HeaterControl::Proportional { set_point, band } => {
                    json!({"proportional": [number(set_point), number(band)]})
                }
            },
        })
    }

    fn description(&self, name: &dyn Fn(usize) -> String) -> Description {
        let others = match self.control {
            HeaterControl::Thermostat { on, off } => vec![on, off],
            HeaterControl::Proportional { set_point, band } => vec![set_point, band],
        };
        let ends = format!("into {}, senses {}", name(self.into), name(self.senses));
        Description { what: "heater", ends, value: self.power, unit: "W", others }
    }

    fn drawing(&self) -> Drawing {
        Drawing::Source(Source::Heater)
    }

    fn heated(&self) -> Option<usize> {
        Some(self.into)
    }

    fn anchored(&self, _graph: &Graph) -> Option<usize> {
        Some(self.into)
    }

    fn scaled(&mut self) -> Option<&mut ExprId> {
        Some(&mut self.power)
    }

    fn is_switched(&self) -> bool {
        matches!(self.control, HeaterControl::Thermostat { .. })
    }
}

/// A two-state element of a transient: mode 1 is entered when `on` crosses zero from below, mode 0 when `off` does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Switch {
    /// Positive where the element must be on, K.
    pub on: ExprId,
    /// Positive where the element must be off, K.
    pub off: ExprId,
}

/// 1 below `end - band`, 0 above `end`, linear between.
fn falling_ramp(graph: &mut Graph, sensed: ExprId, end: ExprId, band: ExprId) -> ExprId {
    let distance = graph.subtract(end, sensed);
    let share = graph.divide(distance, band);
    let (zero, one) = (graph.number(0.0), graph.number(1.0));
    let limited = graph.binary(Binary::Minimum, share, one);
    graph.binary(Binary::Maximum, limited, zero)
}
