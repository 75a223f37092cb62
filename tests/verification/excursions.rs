//! Excursions of the article beside faults of its sensors and of the logger, in one record.

use bmv::diagnosis::{Diagnosis, Settings};
use bmv::random::StreamKey;

use super::small_study;

const MODEL: &str = r#"{
  "format": "bmv-network/1",
  "title": "Three layers",
  "inputs": {"T_top": {"unit": "degC", "nominal": 0, "range": [-12, 12]}, "door": {"unit": "1", "nominal": 0, "range": [0, 1]}},
  "parameters": {"k": {"unit": "W/K", "nominal": 0.4, "prior": {"loguniform": [0.2, 0.8]}, "source": "assumed"}},
  "nodes": {"top": {"boundary": "T_top"}, "a": {"capacity": 1000}, "b": {"capacity": 1000}, "d": {"capacity": 1000}},
  "conductors": {
    "top-a": {"between": ["top", "a"], "conductance": "k"},
    "a-b": {"between": ["a", "b"], "conductance": "k"},
    "b-d": {"between": ["b", "d"], "conductance": "k"}
  }
}"#;

/// Rows at which water runs down, one sensor is off, the reference is off, and the logger writes a code.
const WATER: usize = 100;
const SPIKE: usize = 150;
const OFFSET: usize = 200;
const CODE: usize = 250;
/// Rows in which one sensor shows one value, and that from which the door is open: about it the hardware may answer.
const DROPPED: std::ops::Range<usize> = 300..307;
const DOOR: usize = 303;

#[test]
#[ignore = "thorough"]
fn what_several_sensors_show_stays_and_faults_are_left_out() {
    let mut stream = StreamKey::new(5, "water", "noise").stream(0);
    let mut table = String::from("time [s],T_top [degC],door [1],a [degC],b [degC],d [degC]\n");
    let mut layers = [0.0_f64; 3];
    let top_at = |time_s: f64| 6.0 * libm::sin(time_s / 20_000.0);
    for row in 0..400_usize {
        let time_s = 300.0 * row as f64;
        let mut read = layers.map(|value| value + 0.02 * stream.normal());
        // Each layer has its own share of it, and the deeper ones keep some of it for a row.
        let water = match row - row.min(WATER) {
            0 if row == WATER => [1.2, 0.8, 0.5],
            1 => [0.0, 0.6, 0.4],
            _ => [0.0; 3],
        };
        read = [0, 1, 2].map(|layer| read[layer] + water[layer]);
        match row {
            SPIKE => read[1] += 2.0,
            OFFSET => read = read.map(|value| value + 1.5),
            CODE => read = [-50.0; 3],
            _ if DROPPED.contains(&row) => read[2] = -40.0,
            _ => {}
        }
        let door = u8::from(row >= DOOR);
        table.push_str(&format!("{time_s},{:e},{door},{:e},{:e},{:e}\n", top_at(time_s), read[0], read[1], read[2]));
        for step in 0..300_u32 {
            let [a, b, d] = layers;
            let top = top_at(time_s + f64::from(step));
            let through = [0.4 * (top - a), 0.4 * (a - b), 0.4 * (b - d), 0.0];
            layers = [0, 1, 2].map(|layer| layers[layer] + (through[layer] - through[layer + 1]) / 1000.0);
        }
    }
    let sensor = |name: &str| format!(r#""{name}": {{"measures": "{name}", "sigma": {{"value": 0.02, "unit": "K"}}}}"#);
    let pass = format!(
        r#"{{"format": "bmv-pass/1", "title": "Water", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {{"spring": {{"transient": {{"file": "data.csv",
            "initial": {{"temperatures": {{"all": {{"value": 0, "unit": "degC"}}}}}}, "sensors": {{{}, {}, {}}}}}}}}},
        "jobs": {{"missing": {{"diagnose": {{}}}}}}}}"#,
        sensor("a"),
        sensor("b"),
        sensor("d")
    );
    let files = [("model.json", MODEL), ("data.csv", table.as_str()), ("pass-1.json", pass.as_str())];
    let problem = small_study::problem(&files);
    let diagnosis = Diagnosis::new(problem, Settings::default(), StreamKey::new(7, "water", "diagnosis"));
    let state = diagnosis.screen().expect("a fit");
    let left_out: Vec<(usize, usize)> = state.left_out.iter().map(|one| (one.sensor, one.row)).collect();
    let mut expected = vec![(1, SPIKE)];
    expected.extend([0, 1, 2].into_iter().flat_map(|sensor| [OFFSET, CODE].map(|row| (sensor, row))));
    expected.extend(DROPPED.filter(|row| !(DOOR - 1..DOOR + 3).contains(row)).map(|row| (2, row)));
    expected.sort_unstable();
    assert_eq!(left_out, expected);
    let kept: Vec<(usize, &[usize])> = state.excursions.iter().map(|one| (one.row, one.sensors.as_slice())).collect();
    assert_eq!(kept, [(WATER, &[0, 1, 2][..])]);
}
