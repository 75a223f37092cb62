//! The electronics box of 8 nodes as a study folder: the same network, phases and readings as
//! `tests/verification/network8_data.rs`, written as a user would write them.

use std::fmt::Write as _;
use std::path::Path;

use bmv::measurement::Rows;
use serde_json::{Map, Value, json};

use super::network8_data;

const INPUTS: [(&str, &str, f64); 6] = [
    ("Q0", "W", 10.0),
    ("Q1", "W", 6.0),
    ("Q2", "W", 25.0),
    ("S", "W/m^2", 0.0),
    ("T_base", "K", 290.0),
    ("T_space", "K", 4.0),
];
const PARAMETERS: [(&str, &str); 4] = [("G_tim", "W/K"), ("eps_rad", "1"), ("eps_mli", "1"), ("alpha", "1")];
const CAPACITIES: [f64; 8] = [900.0, 1200.0, 1500.0, 400.0, 400.0, 400.0, 150.0, 150.0];
const CONDUCTORS: [(&str, &str, &str); 12] = [
    ("n0", "n1", "1.2 W/K"),
    ("n1", "n2", "2.0 W/K"),
    ("n0", "n2", "0.6 W/K"),
    ("n3", "n4", "1.5 W/K"),
    ("n4", "n5", "1.5 W/K"),
    ("n0", "n6", "0.05 W/K"),
    ("n1", "n7", "0.05 W/K"),
    ("n6", "n7", "0.3 W/K"),
    ("n0", "base", "0.25 W/K"),
    ("n2", "base", "0.10 W/K"),
    ("n5", "base", "0.05 W/K"),
    ("n2", "n3", "G_tim"),
];
const RADIATIONS: [(&str, &str, &str); 8] = [
    ("n0", "n6", "0.010 m^2"),
    ("n1", "n7", "0.010 m^2"),
    ("n2", "n7", "0.006 m^2"),
    ("n3", "space", "0.06 * eps_rad"),
    ("n4", "space", "0.06 * eps_rad"),
    ("n5", "space", "0.06 * eps_rad"),
    ("n6", "space", "0.40 * eps_mli"),
    ("n7", "space", "0.40 * eps_mli"),
];

fn named<T>(entries: impl IntoIterator<Item = (String, T)>, write: impl Fn(T) -> Value) -> Value {
    Value::Object(entries.into_iter().map(|(name, entry)| (name, write(entry))).collect::<Map<_, _>>())
}

/// A number with a unit, or an expression.
fn amount(text: &str) -> Value {
    match text.split_once(' ') {
        Some((number, unit)) if !unit.contains('*') => match number.parse::<f64>() {
            Ok(value) => json!({ "value": value, "unit": unit }),
            Err(_) => json!(text),
        },
        _ => json!(text),
    }
}

fn links(list: &[(&str, &str, &str)], what: &str) -> Value {
    let link = |(from, to, size): (&str, &str, &str)| json!({ "between": [from, to], what: amount(size) });
    named(list.iter().map(|link| (format!("{} {}", link.0, link.1), *link)), link)
}

fn model() -> Value {
    let priors = network8_data::priors();
    let parameters = PARAMETERS.iter().zip(network8_data::TRUTH).zip(priors).map(|((own, nominal), prior)| {
        let (lower, upper) = prior.support();
        (own.0.to_owned(), json!({ "unit": own.1, "nominal": nominal, "prior": { "uniform": [lower, upper] } }))
    });
    let mut nodes: Map<String, Value> =
        CAPACITIES.iter().enumerate().map(|(i, c)| (format!("n{i}"), json!({ "capacity": c }))).collect();
    nodes.insert("base".into(), json!({ "boundary": "T_base" }));
    nodes.insert("space".into(), json!({ "boundary": "T_space" }));
    let sun = [3, 4, 5].map(|node| (format!("sun {node}"), (format!("n{node}"), "0.06 * alpha * S".to_owned())));
    let heat = [0, 1, 2].map(|node| (format!("heat {node}"), (format!("n{node}"), format!("Q{node}"))));
    json!({
        "format": "bmv-network/1",
        "title": "Electronics box of 8 nodes",
        "description": "A box on a baseplate with a radiator and a tent of insulation.",
        "inputs": named(INPUTS.map(|(name, unit, nominal)| (name.to_owned(), json!({ "unit": unit, "nominal": nominal }))), |v| v),
        "parameters": named(parameters, |v| v),
        "nodes": nodes,
        "conductors": links(&CONDUCTORS, "conductance"),
        "radiations": links(&RADIATIONS, "exchange_area"),
        "loads": named(sun.into_iter().chain(heat), |(node, power)| json!({ "into": node, "power": power })),
    })
}

/// Writes the study with one calibration.
pub fn write(folder: &Path, sampler: &str, chains: u64, warmup: u64, draws: u64) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let built = network8_data::model();
    let measurement = network8_data::measurement(&built);
    let Rows::Steady(phases) = &measurement.rows else { return Ok(()) };
    let mut csv = String::from("phase");
    for (name, unit, _) in INPUTS {
        let _ = write!(csv, ",{name} [{unit}]");
    }
    for sensor in &measurement.sensors {
        let _ = write!(csv, ",{} [K]", sensor.name);
    }
    for (row, phase) in phases.iter().enumerate() {
        let _ = write!(csv, "\n{}", phase.name);
        for value in &phase.inputs {
            let _ = write!(csv, ",{value}");
        }
        for sensor in 0..measurement.sensors.len() {
            let _ = write!(csv, ",{}", measurement.reading(row, sensor).unwrap_or(f64::NAN));
        }
    }
    csv.push('\n');
    let sensor = |name: &str| json!({ "measures": name.replace('s', "n"), "sigma": { "value": network8_data::SIGMA_K, "unit": "K" } });
    let sensors = named(measurement.sensors.iter().map(|s| (s.name.clone(), s.name.as_str())), sensor);
    let parameters: Vec<&str> = PARAMETERS.iter().map(|own| own.0).collect();
    let mut settings = json!({ "data": ["balance test"], "parameters": parameters, "sampler": sampler, "chains": chains, "draws": draws });
    if warmup > 0 {
        settings["warmup"] = json!(warmup);
    }
    let pass = json!({
        "format": "bmv-pass/1",
        "title": "Calibration of the box",
        "parent": null,
        "model": "model.json",
        "seed": 1,
        "measurements": { "balance test": { "steady": { "file": "balance-test.csv", "sensors": sensors } } },
        "jobs": { "tuned": { "calibrate": settings } },
    });
    std::fs::write(folder.join("balance-test.csv"), csv)?;
    std::fs::write(folder.join("model.json"), serde_json::to_string_pretty(&model())?)?;
    std::fs::write(folder.join("pass-1.json"), serde_json::to_string_pretty(&pass)?)
}
