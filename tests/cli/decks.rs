//! Public models of other tools, from their files to a comparison with what the other tool computed.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::studies::printed;

/// A file below the repository.
fn file(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).to_str().expect("a UTF-8 path").to_owned()
}

/// The study of these files, and what the import says as JSON.
fn imported(files: &[String]) -> (tempfile::TempDir, Value) {
    let root = tempfile::tempdir().unwrap();
    let mut arguments = vec!["import"];
    arguments.extend(files.iter().map(String::as_str));
    arguments.extend(["--into", "study", "--json"]);
    let said = serde_json::from_str(&printed(root.path(), &arguments)).unwrap();
    (root, said)
}

/// The largest deviation of any node from what the other tool computed, in K.
fn largest_deviation_k(root: &Path) -> f64 {
    let result: Value = serde_json::from_str(&printed(root, &["compare", "study/pass-1.json", "--json"])).unwrap();
    let sensors = result["sensors"].as_object().expect("sensors");
    let largest = |sensor: &Value| sensor["delivered"]["max"].as_f64().unwrap_or(f64::NAN).abs();
    assert!(!sensors.is_empty());
    sensors.values().map(largest).fold(0.0, |worst, one| if one > worst || one.is_nan() { one } else { worst })
}

/// ESATAN integrates 3000 s in steps of 30 s with its own tolerances; at a quarter of that step an independent Crank-Nicolson
/// solution comes within 1.1 mK, so 1 mK at all instants tells that every conductor and heat is there.
#[test]
#[ignore = "thorough"]
fn a_transient_of_esatan_is_reproduced_to_a_millikelvin() {
    let (root, said) = imported(&[file("decks/tests/esatan/DISCTR_TRANSIENT.TMD")]);
    assert_eq!((&said["closure"]["rows"], closing(&said)), (&Value::from(101), 100));
    assert!(largest_deviation_k(root.path()) < 1e-3);
}

/// Nodes that balance within the tolerance, slopes allowed for.
fn closing(said: &Value) -> usize {
    let number = |value: &Value| value.as_f64().expect("a number");
    let tolerance_k = number(&said["closure"]["tolerance_k"]);
    let closes = |node: &&Value| {
        let (watt, kelvin) = (number(&node["imbalance_w"]).abs(), number(&node["imbalance_k"]).abs());
        kelvin * (1.0 - number(&node["allowed_w"]) / watt).max(0.0) <= tolerance_k
    };
    said["closure"]["nodes"].as_array().expect("nodes").iter().filter(closes).count()
}

/// The files of a public deck below the folder in `BMV_DECKS`, or none where it is not set.
fn public(names: &[&str]) -> Option<Vec<String>> {
    let folder = PathBuf::from(std::env::var_os("BMV_DECKS")?);
    Some(names.iter().map(|name| folder.join(name).to_str().expect("a UTF-8 path").to_owned()).collect())
}

/// Decks without a licence stay outside of the repository: a folder with `txrx` (`bpar907/APSS-2-Thermal-TXRX` at 243eefc),
/// `oresat05` (`oresat/oresat-thermal` at 8673eeb, `OreSat0.5`), `ucdavis` (`Working CubeSat Model`) and `browser`
/// (`2. ModelBrowser_63`), both of `Space-and-Satellite-Systems-UC-Davis/Structure-Thermal-Desktop` at c7424e7, each with the
/// files named here. SINDA/FLUINT prints 0.01 K, so a node may differ by half of that and by what its solver's tolerance of
/// 0.001 K leaves.
#[test]
#[ignore = "needs public decks in the folder BMV_DECKS"]
fn steady_states_of_sinda_are_reproduced_to_the_printed_digits() {
    let decks: [(&[&str], usize); 4] = [
        (&["browser/case0.inp", "browser/case0.cc", "browser/case0.out"], 11),
        (
            &[
                "ucdavis/HC_7Orb.inp",
                "ucdavis/HC_7Orb.cc",
                "ucdavis/C8A0.hra",
                "ucdavis/C8A0.hrl",
                "ucdavis/C8A1.k",
                "ucdavis/C8A2.k",
                "ucdavis/HC_7Orb.out",
            ],
            152,
        ),
        (&["txrx/case0.inp", "txrx/case0.cc", "txrx/C0A0.k", "txrx/C0A1.k", "txrx/case0.out"], 126),
        (
            &[
                "oresat05/case0.inp",
                "oresat05/case0.cc",
                "oresat05/C0A0.k",
                "oresat05/C0A2.k",
                "oresat05/C0A1.hra",
                "oresat05/C0A1.hrl",
                "oresat05/case0.out",
            ],
            658,
        ),
    ];
    for (names, nodes) in decks {
        let Some(files) = public(names) else { return };
        let (root, said) = imported(&files);
        assert_eq!(closing(&said), nodes, "{}", names[0]);
        let largest_k = largest_deviation_k(root.path());
        assert!(largest_k < 0.006, "{}: {largest_k} K", names[0]);
    }
}

/// A result that leaves out conductors (`harper25/ESATAN_PostProcessing` at dccb444, `GSG_SAT_POLAR.TMD`): the import says where.
#[test]
#[ignore = "needs public decks in the folder BMV_DECKS"]
fn a_result_without_its_fluid_conductors_does_not_balance() {
    let Some(files) = public(&["gsg/GSG_SAT_POLAR.TMD"]) else { return };
    let (_root, said) = imported(&files);
    let worst = &said["closure"]["nodes"][0];
    assert!(worst["imbalance_w"].as_f64().is_some_and(|watt| watt.abs() > 10.0), "{worst}");
}
