//! Heaters that the model controls.

use super::assembly::Assembly;
use super::class::Class;
use super::component::Component;
use crate::CELSIUS_ZERO_K;

/// Width in K of the band in which a thermostat's power falls from all to nothing.
const THERMOSTAT_BAND_K: f64 = 0.1;

/// `PropHeater`: `k (T_set - T)` below the set point.
pub fn proportional(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let control = control(assembly, component)?;
    if let Some(rate) = assembly.next_value().filter(|_| control == "T") {
        let node = assembly.predicted_node(component, "node")?;
        assembly.heater_rates_per_ks.push((node, rate));
    }
    let k = assembly.parameter(component, "k", "W/K", |k| k)?;
    let set_point = assembly.parameter(component, "T_set", "K", |celsius| celsius + CELSIUS_ZERO_K)?;
    assembly.load(component, format!("{k} * max({set_point} - {control}, 0)"))
}

/// `ThermostatHeater`: `P` below the set point. A jump there has no solution that stays at it, so that the power falls over
/// a narrow band instead.
pub fn thermostat(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let control = control(assembly, component)?;
    let power = assembly.parameter(component, "P", "W", |power| power)?;
    let set_point = assembly.parameter(component, "T_set", "K", |celsius| celsius + CELSIUS_ZERO_K)?;
    let message = format!(
        "{} switches without a dead band in xija; here its power falls from all to nothing over {THERMOSTAT_BAND_K} K around \
         the set point",
        component.name
    );
    assembly.note(component, message);
    assembly.load(component, format!("{power} * clamp(({set_point} - {control}) / {THERMOSTAT_BAND_K} + 0.5, 0, 1)"))
}

/// The temperature that controls it: its node's, or a measured one.
fn control(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<String, String> {
    let node = component.arguments.required_text("node")?;
    let Some(control) = component.arguments.text("node_control")?.filter(|control| *control != node) else {
        return Ok("T".to_owned());
    };
    if assembly.class_of(control) == Some(Class::TelemData) {
        return Ok(assembly.input(control, "K", 293.15, "measured temperature; degC in xija"));
    }
    let at = assembly.node(component, "node_control")?;
    match assembly.deck.nodes.get(at) {
        Some(control) if !super::network::is_predicted(control) => {
            let name = control.name.clone();
            Ok(assembly.input(&name, "K", 293.15, "measured temperature; degC in xija"))
        }
        _ => Err(format!(
            "it heats `{node}` but is controlled by the predicted node `{control}`, which a load cannot depend on; control it \
             by its own node or by TelemData"
        )),
    }
}
