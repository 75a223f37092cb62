//! `bmv export`: the draws of a calibration read back from the file. A plate on a wall has one unknown, so that what belongs
//! to a draw is known in closed form.

use std::fs;
use std::path::Path;

use bmv::math::functions::ln;
use bmv::statistics::chain_diagnostics;
use hdf5_reader::Hdf5File;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::studies::{bmv, code, printed, text};

/// Wall, K; noise, K; phases with their power, W, and reading, K.
const WALL_K: f64 = 293.15;
const SIGMA_K: f64 = 0.3;
const PHASES: [(&str, f64, f64); 3] = [("P1", 5.0, 303.3), ("P2", 10.0, 312.9), ("P3", 20.0, 333.6)];

/// The plate with a calibration of 2 chains of 100 draws; the phase P3 is held out.
fn study() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("plate");
    fs::create_dir_all(folder.join("data")).unwrap();
    let model = json!({"format": "bmv-network/1", "title": "Plate",
        "inputs": {"Q": {"unit": "W", "nominal": 0}},
        "parameters": {"G": {"unit": "mW/K", "nominal": 500, "prior": {"uniform": [400, 600]}}},
        "nodes": {"wall": {"boundary": WALL_K}, "plate": {"capacity": 500}},
        "conductors": {"mount": {"between": ["plate", "wall"], "conductance": "G"}},
        "loads": {"heater": {"into": "plate", "power": "Q"}}});
    fs::write(folder.join("model.json"), model.to_string()).unwrap();
    let pass = json!({"format": "bmv-pass/1", "title": "Plate", "parent": null, "model": "model.json", "seed": 5,
        "measurements": {"balance": {"steady": {"file": "data/balance.csv",
            "sensors": {"T": {"measures": "plate", "sigma": {"value": SIGMA_K, "unit": "K"}}},
            "held_out": {"phases": ["P3"]}}}},
        "jobs": {"tuned": {"calibrate": {"chains": 2, "warmup": 50, "draws": 100}}}});
    fs::write(folder.join("pass-1.json"), pass.to_string()).unwrap();
    let mut table = "phase,Q [W],T [K]\n".to_owned();
    for (phase, power_w, reading_k) in PHASES {
        table.push_str(&format!("{phase},{power_w},{reading_k}\n"));
    }
    fs::write(folder.join("data/balance.csv"), table).unwrap();
    root
}

fn numbers(file: &Hdf5File, path: &str) -> Vec<f64> {
    let array = file.dataset(path).unwrap().read_array::<f64>().unwrap();
    array.iter().copied().collect()
}

/// Exports and gives the bytes; few draws may not satisfy the diagnostics, which is status 4.
fn export(root: &Path, out: &str, further: &[&str]) -> Vec<u8> {
    let mut arguments = vec!["export", "plate/pass-1.json", "--out", out];
    arguments.extend(further);
    let output = bmv(root, &arguments);
    assert!([0, 4].contains(&code(&output)), "{}", text(&output.stderr));
    fs::read(root.join(out)).unwrap_or_default()
}

#[test]
fn every_draw_comes_back_with_its_closed_form_and_the_same_bytes() {
    let root = study();
    let bytes = export(root.path(), "one.nc", &["--threads", "1"]);
    assert_eq!(
        bytes,
        export(root.path(), "two.nc", &["--threads", "3", "--cache", "other"]),
        "another cache, more threads"
    );
    // A cache that has lost its blocks, but not the result.
    printed(root.path(), &["cache", "prune", "plate"]);
    assert_eq!(bytes, export(root.path(), "three.nc", &[]), "sampled again");

    let file = Hdf5File::from_bytes(&bytes).unwrap();
    let draws = numbers(&file, "posterior/G");
    assert_eq!(file.dataset("posterior/G").unwrap().shape(), [2, 100]);
    let unit = file.dataset("posterior/G").unwrap().attribute("units").unwrap().read_string().unwrap();
    assert_eq!(unit, "W/K", "numbers are in SI, whatever unit the file has");
    let shown = bmv(root.path(), &["show", "plate/pass-1.json", "tuned", "--json"]);
    let own: Value = serde_json::from_slice(&shown.stdout).unwrap();
    let chains: Vec<&[f64]> = draws.chunks(100).collect();
    let expected = |what: &str| own["parameters"]["G"][what].as_f64().unwrap();
    // The same function of the same numbers: to the bit.
    assert_eq!(chain_diagnostics::r_hat(&chains).unwrap(), expected("rhat"));
    assert_eq!(chain_diagnostics::ess_bulk(&chains).unwrap(), expected("ess_bulk"));

    // Normal noise about 293.15 K + Q / G, solved to 1e-9 W: 2e-9 K at 0.5 W/K.
    let prediction = |draw: f64, phase: usize| WALL_K + PHASES[phase].1 / draw;
    let pointwise = numbers(&file, "log_likelihood/readings");
    let total = numbers(&file, "sample_stats/log_likelihood");
    for (index, &draw) in draws.iter().enumerate() {
        let mut sum = 0.0;
        for phase in 0..2 {
            let scaled = (PHASES[phase].2 - prediction(draw, phase)) / SIGMA_K;
            let density = -0.5 * scaled * scaled - ln(SIGMA_K) - 0.5 * ln(2.0 * std::f64::consts::PI);
            let found = pointwise[2 * index + phase];
            assert!((found - density).abs() < 1e-6, "{found} {density}");
            sum += found;
        }
        assert!((sum - total[index]).abs() < 1e-6, "{sum} {}", total[index]);
    }
    // Noise of replicates: of 400 standard normal numbers mean and variance are within five standard errors.
    let replicated = numbers(&file, "posterior_predictive/readings");
    let deviates: Vec<f64> = (0..400).map(|k| (replicated[k] - prediction(draws[k / 2], k % 2)) / SIGMA_K).collect();
    let mean = deviates.iter().sum::<f64>() / 400.0;
    let variance = deviates.iter().map(|e| e * e).sum::<f64>() / 400.0;
    assert!(mean.abs() < 5.0 / 20.0 && (variance - 1.0).abs() < 5.0 * (2.0_f64 / 400.0).sqrt(), "{mean} {variance}");

    assert_eq!(numbers(&file, "observed_data/readings"), [303.3, 312.9]);
    assert_eq!(numbers(&file, "constant_data/inputs"), [5.0, 10.0]);
    let labels = file.dataset("observed_data/reading").unwrap().read_strings().unwrap();
    assert_eq!(labels, ["balance/P1/T", "balance/P2/T"]);
    assert_eq!(numbers(&file, "predictions_constant_data/measured"), [333.6], "the phase that was held out");
    assert_eq!(file.dataset("predictions/readings").unwrap().shape(), [2, 100, 1]);
    let prior = numbers(&file, "prior/G");
    assert!(prior.len() == 256 && prior.iter().all(|draw| (0.4..=0.6).contains(draw)));
}

#[test]
fn other_formats_hold_the_same_numbers_and_nothing_is_overwritten() {
    let root = study();
    let file = Hdf5File::from_bytes(&export(root.path(), "by.nc", &["--by", "phase", "--thin", "10"])).unwrap();
    let draws = numbers(&file, "posterior/G");
    assert_eq!(file.dataset("log_likelihood/readings").unwrap().shape(), [2, 10, 2], "every tenth draw, two phases");
    assert_eq!(file.dataset("posterior/G").unwrap().shape(), [2, 100], "all draws");

    export(root.path(), "npy", &["--format", "npy"]);
    let index: Value = serde_json::from_slice(&fs::read(root.path().join("npy/index.json")).unwrap()).unwrap();
    let array = index["groups"]["posterior"]["variables"]["G"]["file"].as_str().unwrap();
    let bytes = fs::read(root.path().join("npy").join(array)).unwrap();
    let expected: Vec<u8> = draws.iter().flat_map(|draw| draw.to_le_bytes()).collect();
    assert!(bytes.ends_with(&expected) && bytes.len() == 128 + expected.len());

    export(root.path(), "csv", &["--format", "csv"]);
    let table = fs::read_to_string(root.path().join("csv/posterior.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!((lines.len(), lines[0]), (201, "chain,draw,G [W/K]"));
    assert_eq!(lines[200], format!("1,99,{}", draws[199]));

    let again = bmv(root.path(), &["export", "plate/pass-1.json", "--out", "by.nc"]);
    assert_eq!(code(&again), 2);
    assert!(text(&again.stderr).contains("`by.nc` is there already: name another --out"), "{}", text(&again.stderr));
    let none = bmv(root.path(), &["export", "plate/pass-1.json", "--job", "prior", "--out", "x.nc"]);
    assert_eq!(code(&none), 2);
    assert!(text(&none.stderr).contains("no `calibrate` job `prior`; it has `tuned`"), "{}", text(&none.stderr));
}
