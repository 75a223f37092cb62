//! Loads that do not follow their drive as believed, in steady phases by hand: a lamp whose heat grows with the square of its
//! voltage, a heater on a bus whose voltage changes. Both are found among the whole catalogue.

use bmv::diagnosis::{Diagnosis, Output, Settings};
use bmv::random::StreamKey;

use super::small_study;

const SIGMA_K: f64 = 0.1;

/// A box on a plate on a sink; `load` is the believed power into the box.
fn model(load: &str) -> String {
    format!(
        r#"{{
  "format": "bmv-network/1",
  "title": "A box on a plate on a sink",
  "inputs": {{"U": {{"unit": "V", "nominal": 6, "range": [0, 12]}}, "P": {{"unit": "W", "nominal": 5, "range": [0, 10]}}}},
  "parameters": {{
    "k": {{"unit": "W/V", "nominal": 0.5, "prior": {{"loguniform": [0.05, 5]}}, "source": "assumed"}},
    "G": {{"unit": "W/K", "nominal": 0.5, "prior": {{"normal": {{"mean": 0.5, "sd": 0.1}}}}, "source": "assumed"}},
    "H": {{"unit": "W/K", "nominal": 0.3, "prior": {{"normal": {{"mean": 0.3, "sd": 0.1}}}}, "source": "assumed"}}}},
  "nodes": {{"sink": {{"boundary": "290"}}, "plate": {{"capacity": 200}}, "box": {{"capacity": 100}}}},
  "conductors": {{"feet": {{"between": ["plate", "sink"], "conductance": "G"}}, "strap": {{"between": ["box", "plate"], "conductance": "H"}}}},
  "loads": {{"lamp": {{"into": "box", "power": "k * U"}}, "heater": {{"into": "plate", "power": "{load}"}}}}
}}"#
    )
}

/// Eighteen phases with a lamp and a heater whose true powers are functions of voltage and commanded power.
fn diagnosed(lamp: impl Fn(f64) -> f64, heater: impl Fn(f64, f64) -> f64) -> Output {
    let mut noise = StreamKey::new(5, "drive", "noise").stream(0);
    let mut table = String::from("phase,U [V],P [W],plate [K],box [K]\n");
    for row in 0..18_u32 {
        let (u, p) = (1.0 + 0.6 * f64::from(row * 7 % 18), 1.0 + 0.5 * f64::from(row * 5 % 18));
        let (into_box, into_plate) = (lamp(u), heater(p, u));
        let plate = 290.0 + (into_box + into_plate) / 0.55;
        let read = [plate, plate + into_box / 0.28].map(|value| value + SIGMA_K * noise.normal());
        table.push_str(&format!("P{row:02},{u},{p},{:.4},{:.4}\n", read[0], read[1]));
    }
    let sensor =
        |name: &str| format!(r#""{name}": {{"measures": "{name}", "sigma": {{"value": {SIGMA_K}, "unit": "K"}}}}"#);
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Drives", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"test": {{"steady": {{"file": "data.csv", "sensors": {{{}, {}}}}}}}}}, "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#,
        sensor("plate"),
        sensor("box")
    );
    let problem =
        small_study::problem(&[("model.json", model("P").as_str()), ("data.csv", &table), ("pass-1.json", &pass)]);
    Diagnosis::new(problem, Settings::default(), StreamKey::new(7, "drive", "diagnosis")).run().expect("a diagnosis")
}

#[test]
#[ignore = "thorough"]
fn a_lamp_whose_heat_grows_with_the_square_of_its_voltage_is_named() {
    let output = diagnosed(|u| 0.06 * u * u, |p, _| p);
    assert_eq!(output.selected.first().map(String::as_str), Some("joule-heating:box:U"), "{:?}", output.words);
    let own = &output.effects[0].amplitudes["resistance"];
    assert!((own.value - 0.06).abs() < 4.0 * own.sd && own.sd < 0.002, "{own:?}");
}

#[test]
#[ignore = "thorough"]
fn a_heater_on_a_bus_whose_voltage_changes_is_named() {
    let output = diagnosed(|u| 0.4 * u, |p, u| p * (1.0 + 0.4 * u / 12.0));
    // Heat by the product of power and voltage is nearly the same where the conductances are inferred.
    let effect = output.effects.iter().find(|own| own.id == "input-dependent-load:heater:U").expect("listed");
    assert!(effect.group == Some(1) || output.selected.contains(&effect.id), "{:?}", output.words);
    let own = &effect.amplitudes["change"];
    assert!((own.value - 0.4).abs() < 4.0 * own.sd && own.sd < 0.05, "{own:?}");
}
