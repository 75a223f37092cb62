//! The ladder of `studies/sxm-ladder`: the same model and readings as `studies/sxm`, and rungs that fail where the next one
//! begins. What each rung found is read from its committed report, which the gate renders anew.

use std::path::Path;

use serde_json::Value;

use super::monitor_campaign::TRUTH;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Result of the calibration of a rung.
fn rung(number: usize) -> Value {
    let results: Value =
        serde_json::from_str(&read(&format!("reports/sxm-ladder/pass-{number}/results.json"))).unwrap();
    let job = results["jobs"].get("tuned").unwrap_or_else(|| panic!("rung {number} has no calibration"));
    assert_eq!(job["output"]["converged"], true, "rung {number}");
    job["output"].clone()
}

fn check<'r>(rung: &'r Value, sensor: &str) -> &'r Value {
    rung["predictive"].as_array().unwrap().iter().find(|check| check["sensor"] == sensor).unwrap()
}

/// Share of the readings for fits inside a band of a sensor.
fn inside(rung: &Value, sensor: &str, which: &str) -> f64 {
    let train = &check(rung, sensor)["train"];
    train[which].as_f64().unwrap() / train["count"].as_f64().unwrap()
}

/// Whether the reading of a sensor in phase T36 is inside the prior's band and the posterior's.
fn phase_36(rung: &Value, sensor: &str) -> [bool; 2] {
    let rows = check(rung, sensor)["rows"].as_array().unwrap();
    let row = rows.iter().find(|row| row["phase"] == "T36").unwrap();
    let measured = row["measured"].as_f64().unwrap();
    ["prior_band", "band_with_noise"].map(|band| {
        let end = |index: usize| row[band][index].as_f64().unwrap();
        (end(0)..=end(1)).contains(&measured)
    })
}

#[test]
fn model_and_readings_are_those_of_the_monitor() {
    for file in ["model.json", "data/thermal-vacuum.csv"] {
        assert!(read(&format!("studies/sxm-ladder/{file}")) == read(&format!("studies/sxm/{file}")), "{file}");
    }
}

#[test]
fn each_rung_fails_where_the_next_one_begins() {
    let rungs: Vec<Value> = (1..=5).map(rung).collect();
    let p_value = |rung: usize| rungs[rung - 1]["p_value"].as_f64().unwrap();
    let at_bound = |rung: usize, name: &str| rungs[rung - 1]["parameters"][name]["at_bound"].as_f64().unwrap();
    let unknowns = |rung: &Value| rung["order"].as_array().unwrap().len();
    assert_eq!(rungs.iter().map(unknowns).collect::<Vec<_>>(), [1, 2, 2, 3, 3]);
    // Gh alone, and Gsub within its prior, do not predict the monitor housing: neither before nor after calibration.
    for rung in [&rungs[0], &rungs[1]] {
        assert!(inside(rung, "sxm_hsg", "inside_prior") < 0.5 && inside(rung, "sxm_hsg", "inside") < 0.6);
        assert_eq!(phase_36(rung, "sxm_hsg"), [false, false]);
    }
    assert!(at_bound(1, "Gh") < 0.05 && at_bound(2, "Gsub") > 0.9);
    // With its bound relaxed the prior predicts, and the fit is still no good.
    assert!(inside(&rungs[2], "sxm_hsg", "inside_prior") > 0.9 && phase_36(&rungs[2], "sxm_hsg")[0]);
    assert!(at_bound(3, "Gsub") < 0.05);
    // With Gb the bracket is predicted; the chain is at the bound of Gh.
    assert!(inside(&rungs[3], "bracket", "inside") > inside(&rungs[2], "bracket", "inside"));
    assert!(at_bound(4, "Gh") > 0.5 && at_bound(4, "Gsub") < 0.05 && at_bound(4, "Gb") < 0.05);
    assert!((1..=4).all(|rung| p_value(rung) < 1e-3), "each rung below the last is refused");
    // The last one holds: no bound, no misfit, and the truth within the intervals.
    assert!(p_value(5) > 0.05);
    for (name, truth) in TRUTH {
        let summary = &rungs[4]["parameters"][name];
        assert!(at_bound(5, name) < 0.05, "{name}");
        let end = |which: &str| summary[which].as_f64().unwrap();
        assert!(end("q025") < truth && truth < end("q975"), "{name}");
    }
    for sensor in ["sdd_hsg", "sxm_hsg", "bracket", "preamp", "sdd"] {
        assert!(inside(&rungs[4], sensor, "inside") > 0.9, "{sensor}");
        assert_eq!(phase_36(&rungs[4], sensor), [true, true], "{sensor}");
    }
    let evidence = |rung: &Value| rung["log_evidence"]["value"].as_f64().unwrap();
    assert!(rungs.windows(2).all(|pair| evidence(&pair[1]) > evidence(&pair[0]) + 5.0), "each rung is better by far");
}
