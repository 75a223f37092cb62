//! Controlled heaters as written.

use super::{ElementForm, refuse};
use crate::document::formula::Expected;
use crate::document::{Diagnostic, Diagnostics, Scalar, Spanned, code, written_struct};
use crate::expression::Dimension;
use crate::study::model::resolve::ResolvedModel;
use crate::thermal::element::{ElementKind, Heater, HeaterControl};

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
        model: &mut ResolvedModel,
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
        let values =
            order.map(|(low, high, place)| (model.model.graph.constant(low), model.model.graph.constant(high), place));
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
