//! A further step of which the place is open is none: the output names the places.

use bmv::diagnosis::Output;
use bmv::document::percent;
use bmv::random::StreamKey;

use super::small_study;

/// A panel under a lamp, and a box with a lid under a beam that the lid passes on at once; the lid has no thermometer.
const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "A panel, and a box with a lid",
  "inputs": {"lamp": {"unit": "W/m2", "nominal": 0, "range": [0, 1000]}, "beam": {"unit": "W/m2", "nominal": 0, "range": [0, 1000]}},
  "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"lognormal": {"median": 0.5, "factor": 2}}, "source": "assumed"}},
  "nodes": {"sink": {"boundary": {"value": 20, "unit": "degC"}}, "panel": {"capacity": 300}, "box": {"capacity": 400}, "lid": {}},
  "conductors": {"panel feet": {"between": ["panel", "sink"], "conductance": "G"},
    "box feet": {"between": ["box", "sink"], "conductance": "G"}, "rim": {"between": ["lid", "box"], "conductance": 2}}
}"#;
const NOISE_K: f64 = 0.05;
const AREA_OF_PANEL_M2: f64 = 0.02;
const AREA_OF_LID_M2: f64 = 0.004;

/// The diagnosis of four hours in which the lamp is on in turn for 40 minutes, and the beam for 25, which falls on the lid. The last hour is
/// held out. Whether the lid has a thermometer.
fn diagnosed(lid_has_thermometer: bool) -> Output {
    let mut stream = StreamKey::new(31, "open place", "noise").stream(0);
    let on = |second: usize, period: usize| f64::from(u8::from(second / period % 2 == 1)) * 800.0;
    let mut table = String::from("time [s],lamp [W/m2],beam [W/m2],panel [degC],box [degC],lid [degC]\n");
    let [mut panel, mut own] = [20.0_f64; 2];
    for second in 0..14_400_usize {
        let [lamp, beam] = [on(second, 2400), on(second, 1500)];
        if second.is_multiple_of(60) {
            let read = [panel, own, own + AREA_OF_LID_M2 * beam / 2.0].map(|own| own + NOISE_K * stream.normal());
            table.push_str(&format!("{second},{lamp},{beam},{:.3},{:.3},{:.3}\n", read[0], read[1], read[2]));
        }
        // By hand, in steps of a second of time constants of 600 s and more.
        panel += (AREA_OF_PANEL_M2 * lamp - 0.5 * (panel - 20.0)) / 300.0;
        own += (AREA_OF_LID_M2 * beam - 0.5 * (own - 20.0)) / 400.0;
    }
    let sensor = r#""sigma": {"prior": {"lognormal": {"median": 0.1, "factor": 4}}, "unit": "K"}"#;
    let lid = if lid_has_thermometer { format!(r#", "lid": {{"measures": "lid", {sensor}}}"#) } else { String::new() };
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Two beams", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"day": {{"transient": {{"file": "data.csv", "hold": ["lamp", "beam"],
            "initial": {{"temperatures": {{"all": {{"value": 20, "unit": "degC"}}}}}},
            "sensors": {{"panel": {{"measures": "panel", {sensor}}}, "box": {{"measures": "box", {sensor}}}{lid}}},
            "held_out": {{"intervals": [{{"from": {{"value": 10800, "unit": "s"}}}}]}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{"effects": ["input-proportional-load"]}}}}}}}}"#
    );
    let folder = tempfile::tempdir().unwrap();
    let files = [("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass.as_str())];
    small_study::diagnosed(&small_study::loaded(folder.path(), &files))
}

#[test]
fn a_further_step_whose_place_is_open_is_named_and_not_added() {
    let output = diagnosed(false);
    assert_eq!(output.selected, ["input-proportional-load:panel:lamp"], "{:?}", output.words);
    let [_, last] = output.steps.as_slice() else { panic!("{:?}", output.steps) };
    assert!(last.effect.is_none() && last.open, "{last:?}");
    let mut next = last.alternatives.clone();
    next.sort();
    assert_eq!(next, ["input-proportional-load:box:beam", "input-proportional-load:lid:beam"]);
    let said = "where more is missing is open; the likeliest are input-proportional-load:";
    let end = output.words.iter().find(|words| words.contains(said)).expect("the end of the steps");
    // The sentence and the list of effects state the same probabilities, and those of one step are of things that exclude one another.
    let of = |id: &String| output.effects.iter().find(|effect| effect.id == *id).expect("a listed effect").probability;
    for id in &next {
        assert!(end.contains(&format!("{id} ({})", percent(of(id)))), "{end}");
    }
    assert!(next.iter().map(of).sum::<f64>() <= 1.0, "{end}");
}

#[test]
fn a_further_step_whose_place_is_seen_is_added() {
    let output = diagnosed(true);
    let selected = ["input-proportional-load:panel:lamp", "input-proportional-load:lid:beam"];
    assert_eq!(output.selected, selected, "{:?}", output.words);
    assert!(output.steps.iter().all(|step| !step.open), "{:?}", output.steps);
}
