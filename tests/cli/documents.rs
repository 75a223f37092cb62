//! What other programs read: one document on standard output, names and numbers where the documentation says.

use serde_json::{Value, json};

use super::studies::{plate, printed};

fn document(arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(plate().path(), arguments)).expect("one document")
}

fn near(value: &Value, expected: f64) {
    let value = value.as_f64().expect("a number");
    assert!((value - expected).abs() < 1e-9, "{value} instead of {expected}");
}

#[test]
fn compare_gives_rows_and_statistics_by_sensor() {
    let found = document(&["compare", "plate/pass-1.json", "--json"]);
    assert_eq!(found["rows"].as_array().unwrap().len(), 2);
    let row = &found["rows"][0];
    assert_eq!(
        (&row["measurement"], &row["phase"], &row["time_s"], &row["sensor"], &row["unit"]),
        (&json!("balance"), &json!("P1"), &Value::Null, &json!("plate"), &json!("K"))
    );
    // 20 degC + 10 W / 0.5 W/K, and a reading of 43 degC.
    near(&row["predicted"], 313.15);
    near(&row["measured"], 316.15);
    assert_eq!((&row["predicted_tuned"], &row["held_out"]), (&Value::Null, &json!(false)));
    let sensor = &found["sensors"]["plate"];
    near(&sensor["delivered"]["mean"], 3.0);
    near(&sensor["delivered"]["rmse"], 3.0);
    near(&sensor["delivered"]["max"], 3.0);
    near(&sensor["delivered"]["rmse_held_out"], 3.0);
    assert_eq!(sensor["tuned"], json!({}));
    // One reading: sigma times the square root of the chi-square quantiles 0.00098207 and 5.02389 (tables).
    let noise = |name: &str| sensor["noise"][name].as_f64().unwrap();
    assert!((noise("rmse_low") - 0.5 * 0.000_982_07f64.sqrt()).abs() < 1e-5);
    assert!((noise("rmse_high") - 0.5 * 5.023_886f64.sqrt()).abs() < 1e-5);
    assert_eq!(found["fails"].as_array().unwrap().len(), 1);
    near(&found["heat"][0]["into_boundaries_w"]["wall"], 10.0);
    assert!(document(&["compare", "plate", "--json", "--rows", "none"]).get("rows").is_none());
    assert_eq!(document(&["show", "plate", "delivered", "--json", "--run"]), found, "the same document");
}

#[test]
fn propagate_gives_quantities_and_probabilities_by_name() {
    let found = document(&["show", "plate", "prior", "--json", "--run"]);
    let quantity = &found["quantities"]["plate temperature"];
    assert_eq!(quantity["unit"], "K");
    // 293.15 K + 10 W / G with G uniform from 0.4 to 0.6 W/K: 10 ln(1.5) / 0.2 = 20.273 K; 64 Sobol points.
    assert!((quantity["mean"].as_f64().unwrap() - 313.423).abs() < 0.05);
    // The median of G is 0.5 W/K.
    assert!((quantity["quantiles"]["0.5"].as_f64().unwrap() - 313.15).abs() < 0.2);
    // Below 41 degC: G above 10/21 W/K, of the uniform 0.619.
    let probability = &found["probability"]["plate"];
    assert!((probability["value"].as_f64().unwrap() - 0.619).abs() < 0.03);
    assert!(probability["lower"].as_f64() < probability["upper"].as_f64());
    assert_eq!(found["probability"]["all"], *probability);
    assert_eq!((&found["samples"], &found["failed"]), (&json!(64), &json!(0)));
    let all = document(&["show", "plate", "--json", "--run"]);
    assert_eq!(all["prior"], found);
}

#[test]
fn sensitivity_gives_indices_by_quantity_and_parameter() {
    let root = plate();
    let file = root.path().join("plate/pass-1.json");
    let mut pass: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    pass["jobs"]["effects"] = json!({"sensitivity": {"samples": 64}});
    std::fs::write(&file, pass.to_string()).unwrap();
    let found: Value = serde_json::from_str(&printed(root.path(), &["show", "plate", "effects", "--json", "--run"]))
        .expect("one document");
    // The conductance alone is uncertain: all of the variance is its own.
    for kind in ["main", "total"] {
        let index = &found[kind]["plate temperature"]["G"];
        assert!((index["value"].as_f64().unwrap() - 1.0).abs() < 0.05, "{kind}: {index}");
        assert!(
            index["lower"].as_f64() <= index["value"].as_f64() && index["value"].as_f64() <= index["upper"].as_f64()
        );
    }
    // 293.15 K + 10 W / G: -10 / 0.25.
    near(&found["local"]["plate temperature"]["G"]["derivative"], -40.0);
    assert_eq!((&found["samples"], &found["scrambles"], &found["failed"]), (&json!(64), &json!(8), &json!(0)));
}
