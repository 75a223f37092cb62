//! A comparison with so many readings that they stand as arrays beside its JSON: in the cache, in a report, for other programs.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use bmv::job::array::Array;
use serde_json::{Value, json};

const ROWS: usize = 10_500;

/// A block that cools, read by two sensors, one of which says nothing in every fiftieth row; the last rows are held out.
fn study() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let model = json!({
        "format": "bmv-network/1", "title": "A block that cools",
        "parameters": {"G": {"unit": "W/K", "nominal": 0.2, "prior": {"uniform": [0.1, 0.3]}}},
        "nodes": {"block": {"capacity": 120}, "shell": {"capacity": 40}, "room": {"boundary": 293.15}},
        "conductors": {"leak": {"between": ["shell", "room"], "conductance": "G"},
                       "joint": {"between": ["block", "shell"], "conductance": "1.5 * G"}}
    });
    let pass = json!({
        "format": "bmv-pass/1", "title": "Cooling", "parent": null, "model": "model.json", "seed": 3,
        "measurements": {"cooling": {"transient": {
            "file": "cooling.csv", "initial": {"temperatures": {"all": 330}},
            "held_out": {"intervals": [{"from": {"value": 20_800, "unit": "s"}}]},
            "sensors": {"block": {"measures": "block", "sigma": 0.2}, "shell": {"measures": "shell", "sigma": 0.2}}
        }}},
        "jobs": {"delivered": {"compare": {"data": ["cooling"]}}}
    });
    let mut table = String::from("time [s],block [K],shell [K]\n");
    for row in 0..ROWS {
        let block = 293.0 + 1100.0 / (30.0 + row as f64);
        let shell = if row % 50 == 0 { String::new() } else { format!("{}", block - 0.5) };
        writeln!(table, "{},{block},{shell}", 2 * row).unwrap();
    }
    fs::create_dir(folder.path().join("cooling")).unwrap();
    for (name, text) in [("model.json", model.to_string()), ("pass-1.json", pass.to_string()), ("cooling.csv", table)] {
        fs::write(folder.path().join("cooling").join(name), text).unwrap();
    }
    folder
}

fn bmv(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bmv")).current_dir(folder).args(arguments).output().unwrap()
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = bmv(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn numbers(path: &Path) -> Vec<f64> {
    let bytes = fs::read(path).unwrap();
    let (array, rest) = Array::split_npy(&bytes).unwrap();
    assert!(rest.is_empty());
    array.numbers().to_vec()
}

/// Objects of the cache, largest last.
fn objects(folder: &Path) -> Vec<PathBuf> {
    let files = walkdir::WalkDir::new(folder.join("cache/objects")).into_iter().flatten();
    let mut files: Vec<_> = files.filter(|entry| entry.file_type().is_file()).map(|entry| entry.into_path()).collect();
    files.sort_by_key(|path| path.metadata().unwrap().len());
    files
}

fn flip(path: &Path, from_end: usize) {
    let mut bytes = fs::read(path).unwrap();
    let at = bytes.len() - from_end;
    bytes[at] ^= 1;
    fs::write(path, bytes).unwrap();
}

#[test]
#[ignore = "thorough"]
fn many_readings_lie_beside_the_results_and_are_verified() {
    let folder = study();
    let pass = "cooling/pass-1.json";
    let cache = ["--cache", "cache"];
    let with = |arguments: &[&'static str]| [arguments, &cache].concat();
    let shown = succeeds(folder.path(), &with(&["compare", pass]));
    succeeds(folder.path(), &with(&["report", pass, "--out", "reports"]));
    let report = folder.path().join("reports/cooling/pass-1");
    let results: Value = serde_json::from_slice(&fs::read(report.join("results.json")).unwrap()).unwrap();
    let table = &results["jobs"]["delivered"]["output"]["rows"]["tables"][0];
    let read =
        |array: &Value| numbers(&report.join(results["files"][array["sha256"].as_str().unwrap()].as_str().unwrap()));
    let (measured, predicted, times) = (read(&table["measured"]), read(&table["predicted"]), read(&table["time_s"]));
    assert_eq!((measured.len(), times.len(), times[7]), (2 * ROWS, ROWS, 14.0));
    assert!(measured[1].is_nan() && predicted[1].is_nan() && !measured[3].is_nan());
    assert_eq!(read(&table["held_out"]).iter().sum::<f64>(), 100.0);
    assert!(report.join("results/delivered-measured-cooling.npy").is_file());
    assert!(fs::metadata(report.join("results.json")).unwrap().len() < 20_000);

    // The same numbers, a row each, for who asks for them.
    let document: Value =
        serde_json::from_str(&succeeds(folder.path(), &with(&["show", pass, "delivered", "--json"]))).unwrap();
    let rows = document["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2 * ROWS - ROWS / 50);
    let of = |name: &str| -> Vec<u64> { rows.iter().map(|row| row[name].as_f64().unwrap().to_bits()).collect() };
    let known = |values: &[f64]| -> Vec<u64> { values.iter().filter(|v| !v.is_nan()).map(|v| v.to_bits()).collect() };
    assert_eq!((of("measured"), of("predicted")), (known(&measured), known(&predicted)));

    // Any byte of an array is one of the report.
    assert!(succeeds(folder.path(), &["verify", "reports/cooling/pass-1"]).contains("the report is as it was written"));
    let array = report.join("results/delivered-predicted-cooling.npy");
    flip(&array, 20);
    let altered = bmv(folder.path(), &["verify", "reports/cooling/pass-1"]);
    let text = String::from_utf8_lossy(&altered.stdout).into_owned();
    assert!(
        !altered.status.success() && text.contains("output changed: results/delivered-predicted-cooling.npy"),
        "{text}"
    );
    // Nor is it hidden by a manifest that lists the altered one.
    let manifest = report.join("manifest.json");
    let sha256 = |bytes: &[u8]| bmv::document::hash::sha256_hex(bytes);
    let new = sha256(&fs::read(&array).unwrap());
    flip(&array, 20);
    let old = sha256(&fs::read(&array).unwrap());
    flip(&array, 20);
    let listed = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, listed.replace(&old, &new)).unwrap();
    let text = String::from_utf8(bmv(folder.path(), &["verify", "reports/cooling/pass-1"]).stdout).unwrap();
    assert!(text.contains(&format!("does not list the array {old}")), "{text}");
    assert!(text.contains("the seal of report.md is that of other figures"), "{text}");

    // A damaged object of the cache is computed again, to the same bytes.
    let result = objects(folder.path()).pop().unwrap();
    let whole = fs::read(&result).unwrap();
    flip(&result, 400);
    assert_eq!(succeeds(folder.path(), &with(&["compare", pass])), shown);
    assert_eq!(fs::read(&result).unwrap(), whole);
}
