//! A diagnosis of a hub with many like leaves: a path from a leaf with a thermometer to one that no thermometer sees, since the hub's
//! temperature is given. What it carries goes with the other leaf's power.

use std::fmt::Write as _;
use std::process::Command;

use bmv::random::StreamKey;
use serde_json::{Map, Value, json};

const LEAVES: usize = 120;
/// W/K from the hub to each leaf, and between the two.
const TO_HUB: f64 = 0.5;
const PATH: f64 = 0.2;
const ENDS: [usize; 2] = [3, 77];
const SIGMA_K: f64 = 0.1;

#[test]
fn a_path_to_a_leaf_that_no_sensor_sees_is_found() {
    let root = tempfile::tempdir().unwrap();
    let mut stream = StreamKey::new(1, "leaves", "study").stream(0);
    // Each leaf has its share of one of three powers.
    let shares: Vec<f64> = (0..LEAVES).map(|_| stream.uniform()).collect();
    let named = |each: &dyn Fn(usize) -> (String, Value)| -> Map<String, Value> { (0..LEAVES).map(each).collect() };
    let mut inputs = json!({"T_hub": {"unit": "K", "nominal": 290}});
    (0..3).for_each(|k| inputs[format!("P{k}")] = json!({"unit": "W", "nominal": 5}));
    let mut nodes = named(&|k| (format!("leaf{k}"), json!({"capacity": 100})));
    nodes.insert("hub".to_owned(), json!({"boundary": "T_hub"}));
    let joint = |k: usize| json!({"between": ["hub", format!("leaf{k}")], "conductance": "G"});
    let load = |k: usize| json!({"into": format!("leaf{k}"), "power": format!("{} * P{}", shares[k], k % 3)});
    let model = json!({
        "format": "bmv-network/1", "inputs": inputs, "nodes": nodes,
        "parameters": {"G": {"nominal": TO_HUB, "unit": "W/K", "prior": {"lognormal": {"median": TO_HUB, "factor": 1.2}}}},
        "conductors": named(&|k| (format!("c{k}"), joint(k))), "loads": named(&|k| (format!("q{k}"), load(k))),
    });
    let mut table =
        "phase,T_hub [K],P0 [W],P1 [W],P2 [W],leaf0 [K],leaf1 [K],leaf2 [K],leaf3 [K],leaf4 [K]\n".to_owned();
    for phase in 0..12 {
        let hub = 270.0 + 40.0 * stream.uniform();
        let powers: Vec<f64> = (0..3).map(|_| 20.0 * stream.uniform()).collect();
        let heat = |leaf: usize| shares[leaf] * powers[leaf % 3];
        write!(table, "F{phase:02},{hub},{},{},{}", powers[0], powers[1], powers[2]).unwrap();
        for leaf in 0..5 {
            // The two balances with the path, solved by Cramer's rule.
            let sum = TO_HUB + PATH;
            let with_path = (sum * heat(ENDS[0]) + PATH * heat(ENDS[1])) / (sum * sum - PATH * PATH);
            let above = if leaf == ENDS[0] { with_path } else { heat(leaf) / TO_HUB };
            write!(table, ",{}", hub + above + SIGMA_K * stream.normal()).unwrap();
        }
        table.push('\n');
    }
    let sensor = json!({"sigma": {"value": SIGMA_K, "unit": "K"}});
    let sensors: Map<String, Value> = (0..5).map(|k| (format!("leaf{k}"), sensor.clone())).collect();
    let mut pass = json!({
        "format": "bmv-pass/1", "title": "Leaves", "parent": null, "model": "model.json", "seed": 1,
        "measurements": {"test": {"steady": {"file": "test.csv", "sensors": sensors}}},
        "jobs": {"missing": {"diagnose": {"effects": ["conductive-path", "heat-load"], "most": 1}}},
    });
    (0..5).for_each(|k| {
        let name = format!("leaf{k}");
        pass["measurements"]["test"]["steady"]["sensors"][&name]["measures"] = json!(name);
    });
    std::fs::write(root.path().join("test.csv"), table).unwrap();
    for (file, value) in [("model.json", &model), ("pass-1.json", &pass)] {
        std::fs::write(root.path().join(file), value.to_string()).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_bmv"))
        .current_dir(root.path())
        .args(["diagnose", "pass-1.json", "--json"])
        .output()
        .unwrap();
    let found: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    // Leaves whose loads go alike cannot be told apart: the true one is among the probable ones, the hub is not.
    let probability = |id: &str| {
        let effects = found["effects"].as_array().expect("effects");
        let own = effects.iter().find(|effect| effect["id"] == id);
        own.and_then(|effect| effect["probability"].as_f64()).unwrap_or(0.0)
    };
    assert!(probability("conductive-path:leaf3:leaf77") > 0.05, "{:#}", found["words"]);
    assert!(probability("conductive-path:hub:leaf3") < 0.01, "{:#}", found["words"]);
}
