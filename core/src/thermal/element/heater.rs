//! Controlled heaters: a thermostat with hysteresis and a proportional controller.
//!
//! A thermostat switches on when its sensing node falls below `on` and off when it rises above `off`. In a steady
//! solution, which has no history, it delivers the average that its cycling would: the duty falls linearly from 1
//! at `on` to 0 at `off`. A proportional heater's duty falls linearly from 1 to 0 over `band` about its set point.

use serde_json::{Value, json};

use crate::document::formula::Expected;
use crate::document::{Diagnostic, Diagnostics, Scalar, Spanned, code, written_struct};
use crate::expression::{Binary, Dimension, ExprId, Graph, Symbol, Unary};

use super::conductor::temperature;
use super::form::{ElementForm, Lookup, refuse};
use super::{Contribution, Description, Drawing, ElementKind, Physics, Source};

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

const POWER: Expected = Expected::value(Dimension::POWER, "a power");
const SET_POINT: Expected = Expected::value(Dimension::TEMPERATURE, "a set point").given();
const BAND: Expected = Expected::value(Dimension::TEMPERATURE, "a band").given().difference();

written_struct! {
    /// A controlled heater: with exactly one of `thermostat` and `proportional`.
    pub struct HeaterForm: "a heater" {
        /// The node that is heated.
        required into: Spanned<String>,
        /// The node that the controller senses; the heated one where it is left out.
        optional senses: Spanned<String>,
        /// Power when fully on, W.
        required power: Scalar,
        /// Two-point control.
        optional thermostat: ThermostatForm,
        /// Proportional control.
        optional proportional: ProportionalForm,
        /// Description, for the report.
        optional description: String,
        /// Where the values come from.
        optional source: String,
    }
}

written_struct! {
    /// Two-point control.
    pub struct ThermostatForm: "a thermostat" {
        /// Switches on below, K.
        required on_below: Scalar,
        /// Switches off above, K.
        required off_above: Scalar,
    }
}

written_struct! {
    /// Proportional control: duty 1 half a band below the set point, 0 half a band above.
    pub struct ProportionalForm: "a proportional control" {
        /// Middle of the band, K.
        required set_point: Scalar,
        /// Width of the band, K.
        required band: Scalar,
    }
}

impl ElementForm for HeaterForm {
    fn resolve(
        &self,
        name: &Spanned<String>,
        model: &mut dyn Lookup,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        let into = model.find_node(&self.into.value, &self.into.place, diagnostics);
        let senses = match &self.senses {
            Some(sensing) => model.find_node(&sensing.value, &sensing.place, diagnostics),
            None => into,
        };
        let mut formulas = model.formulas();
        let locals: Vec<_> = into.map(|node| ("T", formulas.node(node))).into_iter().collect();
        let power = match into {
            Some(_) => formulas.scalar(&self.power, POWER, &locals, diagnostics),
            None => None,
        };
        let mut order = None;
        let control = match (&self.thermostat, &self.proportional) {
            (Some(thermostat), None) => {
                let on = formulas.scalar(&thermostat.on_below, SET_POINT, &[], diagnostics);
                let off = formulas.scalar(&thermostat.off_above, SET_POINT, &[], diagnostics);
                order = Some((on?, off?, thermostat.off_above.place()));
                Some(HeaterControl::Thermostat { on: on?, off: off? })
            }
            (None, Some(proportional)) => {
                let set_point = formulas.scalar(&proportional.set_point, SET_POINT, &[], diagnostics);
                let band = formulas.scalar(&proportional.band, BAND, &[], diagnostics);
                let zero = formulas.graph.number(0.0);
                order = Some((zero, band?, proportional.band.place()));
                Some(HeaterControl::Proportional { set_point: set_point?, band: band? })
            }
            (both, _) => {
                let message = match both {
                    Some(_) => "a heater has either `thermostat` or `proportional`, and this one has both",
                    None => "a heater has either `thermostat` or `proportional`, and this one has neither",
                };
                let mut diagnostic = Diagnostic::error(&code::ONE_KIND, &name.place, message)
                    .expected("exactly one of `thermostat`, `proportional`");
                if both.is_none() {
                    diagnostic = diagnostic.help("a heater without control is one of the `loads`");
                }
                diagnostics.push(diagnostic);
                None
            }
        };
        let values = order.map(|(low, high, place)| {
            (model.formulas().graph.constant(low), model.formulas().graph.constant(high), place)
        });
        if let Some((Some(low), Some(high), place)) = values
            && low >= high
        {
            let (message, expected) = match self.thermostat {
                Some(_) => (
                    format!("the heater switches off above {high} K and on below {low} K"),
                    "`off_above` above `on_below`",
                ),
                None => (format!("a band of {high} K"), "a width above 0"),
            };
            refuse(place, message, expected, diagnostics);
            return None;
        }
        Some(ElementKind::Heater(Heater { into: into?, senses: senses?, power: power?, control: control? }))
    }
}
