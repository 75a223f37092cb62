//! The campaign of `studies/sxm-leak` made again from its truth, and what its diagnosis says of it. The network that gives the
//! readings has its golden solutions in `monitor_campaign`; here it gets one conductor more.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use bmv::random::StreamKey;
use bmv::study::Pass;
use serde_json::Value;

use super::monitor_campaign::{ZERO_C, phases, solved};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/sxm-leak")
}

fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap()
}

/// The study's first pass on a model with the leak.
fn true_pass(truth: &Value) -> Pass {
    let study = tempfile::tempdir().unwrap();
    let mut model = json(&folder().join("model.json"));
    model["conductors"]["leak"] = truth["leak"].clone();
    std::fs::write(study.path().join("model.json"), model.to_string()).unwrap();
    std::fs::create_dir(study.path().join("data")).unwrap();
    for file in ["pass-1.json", "data/thermal-vacuum.csv"] {
        std::fs::copy(folder().join(file), study.path().join(file)).unwrap();
    }
    let Ok(pass) = bmv::job::load(&study.path().join("pass-1.json")) else { panic!("the study loads") };
    pass
}

#[test]
fn the_believed_model_is_the_monitor_and_its_truth_is_within_the_priors() {
    let model = json(&folder().join("model.json"));
    assert!(model == json(&folder().with_file_name("sxm").join("model.json")));
    for (name, value) in json(&folder().join("truth.json"))["parameters"].as_object().unwrap() {
        let end = |index: usize| model["parameters"][name]["prior"]["uniform"][index].as_f64().unwrap();
        assert!((end(0)..=end(1)).contains(&value.as_f64().unwrap()), "{name}");
    }
}

#[test]
fn the_campaign_is_made_again_from_its_truth() {
    let truth = json(&folder().join("truth.json"));
    let pass = true_pass(&truth);
    let parameters: Vec<(&str, f64)> =
        truth["parameters"].as_object().unwrap().iter().map(|(n, v)| (n.as_str(), v.as_f64().unwrap())).collect();
    let noise = &truth["noise"];
    let key = StreamKey::new(noise["seed"].as_u64().unwrap(), noise["stream"].as_str().unwrap(), "noise");
    let sensors = ["sdd_hsg", "sxm_hsg", "bracket", "preamp", "sdd"];
    let mut text = String::from("phase,V [V],T_orex [degC],T_sky [K],q_sun [W/m^2]");
    sensors.iter().for_each(|name| write!(text, ",{name} [degC]").unwrap());
    text.push('\n');
    for (index, (voltage, deck_c)) in phases().into_iter().enumerate() {
        // Every deck temperature with every shroud temperature.
        let shroud = truth["shroud_k"][(index + index / 6) % 3].as_f64().unwrap();
        let inputs = [("T_orex", deck_c + ZERO_C), ("V", voltage), ("q_sun", 0.0), ("T_sky", shroud)];
        let (temperatures, _) = solved(&pass, &parameters, inputs);
        let mut stream = key.stream(index as u64);
        write!(text, "T{:02},{voltage},{deck_c},{shroud},0", index + 1).unwrap();
        for name in sensors {
            let node = pass.model.nodes.iter().position(|node| node.name == name).unwrap();
            let reading = temperatures[node] + noise["sigma_k"][name].as_f64().unwrap() * stream.normal();
            write!(text, ",{reading:.3}").unwrap();
        }
        text.push('\n');
    }
    if std::fs::read_to_string(folder().join("data/thermal-vacuum.csv")).unwrap_or_default() != text {
        let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("thermal-vacuum-leak.csv");
        std::fs::write(&made, &text).unwrap();
        panic!("studies/sxm-leak/data/thermal-vacuum.csv is not what truth.json gives: see {}", made.display());
    }
}

/// What the committed reports say, which the gate renders anew.
#[test]
fn the_diagnosis_finds_the_leak_and_its_adoption_lowers_the_error() {
    let truth = json(&folder().join("truth.json"));
    let reports = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/sxm-leak");
    let [before, after] =
        ["pass-1", "pass-2"].map(|pass| json(&reports.join(pass).join("results.json"))["jobs"].clone());
    let missing = &before["missing"]["output"];
    assert_eq!(missing["selected"], serde_json::json!(["conductive-path:preamp:sky"]));
    assert_eq!(missing["verdict"], "identified");
    // Four of the standard deviations that the diagnosis states: a draw of the noise within them is no matter of luck.
    let leak = &after["tuned"]["output"]["parameters"];
    let own = leak.as_object().unwrap().iter().find(|(name, _)| name.ends_with(".conductance")).unwrap().1;
    let number = |which: &str| own[which].as_f64().unwrap();
    let distance = number("mean") - truth["leak"]["conductance"].as_f64().unwrap();
    assert!(distance.abs() < 4.0 * number("sd"), "{distance}");
    assert_eq!(after["missing"]["output"]["selected"], serde_json::json!([]));
    let held_out = |jobs: &Value| jobs["delivered"]["output"]["tuned"]["held_out"]["rmse"].as_f64().unwrap();
    assert!(held_out(&after) < 0.5 * held_out(&before), "{} {}", held_out(&before), held_out(&after));
}
