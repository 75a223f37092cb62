//! Heat of the Earth.

use super::assembly::Assembly;
use super::component::Component;

/// `EarthHeat`: `k` times the visible solid angle of the Earth, and `k2` times that again by the Earth's phase.
///
/// The solid angle follows from orbit and attitude by a grid that belongs to xija: it is an input here.
pub fn heat(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    for argument in ["orbitephem0_x", "orbitephem0_y", "orbitephem0_z", "aoattqt1", "aoattqt2", "aoattqt3", "aoattqt4"]
    {
        let name = component.arguments.required_text(argument)?;
        assembly.class_of(name).ok_or_else(|| format!("`{argument}` is `{name}`, which is no component of `comps`"))?;
    }
    let k = assembly.parameter(component, "k", "W", |power| power)?;
    let has_phase =
        ["solarephem0_x", "solarephem0_y", "solarephem0_z"].iter().all(|name| component.arguments.has(name));
    let k2 = if component.arguments.number("k2")?.is_some() {
        Some(assembly.parameter(component, "k2", "W", |power| power)?)
    } else {
        None
    };
    let description =
        "solid angle in sr of the Earth seen from the cold radiator (xija: data of the EarthHeat component)";
    let angle = assembly.input("earth_solid_angle", "1", 0.0, description);
    let factor = match k2 {
        Some(k2) if has_phase => {
            let description = "lit part of the Earth, (1 + cos(angle at the Earth from Chandra to the Sun)) / 2";
            let phase = assembly.input("earth_phase", "1", 0.5, description);
            format!("({k} + {k2} * {phase})")
        }
        None if has_phase => return Err("with `solarephem0_x`, `_y`, `_z` it needs the argument `k2`".to_owned()),
        _ => k,
    };
    let message = "the Earth's solid angle and phase are inputs: xija computes them from orbit and attitude with a grid of \
                   the radiator's view; export the component's dvals and earth_phase";
    assembly.note(component, message);
    assembly.load(component, format!("{factor} * {angle}"))
}
