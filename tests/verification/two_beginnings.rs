//! Two effects at once, of which a curve alone looks better than either: a cell whose loss grows with the square of the current, read
//! by a thermometer that follows late. The curve predicts the third run no better than nothing does.

use bmv::diagnosis::{Diagnosis, Output, Settings};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A cell discharged at three currents",
  "inputs": {"I": {"unit": "A", "nominal": 20, "range": [0, 80]}},
  "parameters": {
    "C": {"unit": "J/K", "nominal": 500, "prior": {"uniform": [300, 900]}, "source": "assumed"},
    "G": {"unit": "W/K", "nominal": 0.5, "prior": {"loguniform": [0.05, 5]}, "source": "assumed"},
    "k": {"unit": "V", "nominal": 0.1, "prior": {"loguniform": [0.01, 1]}, "source": "assumed"}},
  "nodes": {"air": {"boundary": "298.15"}, "cell": {"capacity": "C"}},
  "conductors": {"to air": {"between": ["cell", "air"], "conductance": "G"}},
  "loads": {"loss": {"into": "cell", "power": "k * I"}}
}"#;

/// Lag of the thermometer, s.
const LAG_S: f64 = 30.0;

/// Discharges at 20, 40 and 60 A with rests, in steps of half a second by Euler's rule; the last run is held out.
fn diagnosed() -> Output {
    let mut noise = StreamKey::new(1, "cell", "noise").stream(0);
    let mut files = Vec::new();
    let mut measurements = Vec::new();
    for (name, current, seconds) in [("1C", 20.0, 3000.0), ("2C", 40.0, 1500.0), ("3C", 60.0, 1000.0)] {
        let (mut cell, mut read) = (298.15, 298.15);
        let mut table = String::from("time [s],I [A],cell [K]\n");
        for half in 0..=(2.8 * seconds) as u32 {
            let t = 0.5 * f64::from(half);
            let i: f64 = if t < seconds { current } else { 0.0 };
            if half.is_multiple_of(40) {
                table.push_str(&format!("{t},{i},{:.4}\n", read + 0.02 * noise.normal()));
            }
            cell += 0.5 * (0.004 * i * i - 0.6 * (cell - 298.15)) / 600.0;
            read += 0.5 * (cell - read) / LAG_S;
        }
        files.push((format!("{name}.csv"), table));
        let held_out = if name == "3C" { r#", "held_out": {"all": {}}"# } else { "" };
        measurements.push(format!(
            r#""{name}": {{"transient": {{"file": "{name}.csv", "hold": ["I"],
            "initial": {{"temperatures": {{"all": {{"value": 298.15, "unit": "K"}}}}}}, "sensors": {{"cell": {{"measures": "cell",
            "sigma": {{"prior": {{"lognormal": {{"median": 0.1, "factor": 3}}}}, "unit": "K"}}}}}}{held_out}}}}}"#
        ));
    }
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Cell", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{{}}}, "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#,
        measurements.join(", ")
    );
    files.extend([("model.json".to_owned(), MODEL.to_owned()), ("pass-1.json".to_owned(), pass)]);
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let problem = small_study::problem(&files);
    Diagnosis::new(problem, Settings::default(), StreamKey::new(7, "cell", "diagnosis")).run().expect("a diagnosis")
}

/// A loss that grows with its current from nothing on is one with the square of it.
#[test]
#[ignore = "thorough"]
fn a_story_begins_where_it_leads_further() {
    let output = diagnosed();
    let of_square = |id: &String| ["joule-heating:cell:I", "input-dependent-load:loss:I"].contains(&id.as_str());
    let first = output.steps.first().and_then(|step| step.effect.as_ref()).expect("a step");
    assert!(of_square(first), "{first}: {:?}", output.words);
    assert!(output.selected.iter().any(|id| id == "sensor-lag:cell"), "{:?}", output.words);
    assert!(output.selected.iter().all(|id| !id.contains("function")), "{:?}", output.words);
    let left = output.steps.iter().filter_map(|step| step.rmse_k.held_out[1]).next_back().expect("held-out rows");
    assert!(left < 0.2, "{left}");
}
