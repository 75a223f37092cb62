//! The data of `studies/disctr`, made again from its truth by a solution of its own: balances of the deck's 100 nodes,
//! radiation linearised about the last iterate, and elimination. And the deck's files as `bmv import` writes them.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use bmv::random::StreamKey;
use serde_json::Value;

const ZERO_C: f64 = 273.15;
/// Stefan-Boltzmann constant, W/(m2 K4) (CODATA 2018).
const SIGMA: f64 = 5.670374419e-8;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/disctr")
}

fn read(path: &str) -> String {
    std::fs::read_to_string(folder().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// A coupling: ends, parameter, the number that it is multiplied by.
type Coupling = (String, String, String, f64);

/// The rows of a table of couplings, all of which have a parameter. Names stand in quotes for their commas.
fn couplings(path: &str) -> Vec<Coupling> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.rsplit('"').next().unwrap().split(',').skip(1).collect();
        let [from, to, _, parameter, factor] = cells[..] else { panic!("{line}") };
        (from.to_owned(), to.to_owned(), parameter.to_owned(), factor.parse().unwrap())
    };
    read(path).lines().skip(1).map(row).collect()
}

/// The network at its true parameters.
struct Truth {
    nodes: Vec<String>,
    conductors: Vec<(String, String, f64)>,
    radiations: Vec<(String, String, f64)>,
    /// Node and its share of the power.
    heated: Vec<(usize, f64)>,
}

impl Truth {
    fn new(truth: &Value) -> Self {
        let model: Value = serde_json::from_str(&read("model.json")).unwrap();
        let inner = |(_, node): &(&String, &Value)| node.get("boundary").is_none();
        let nodes: Vec<String> =
            model["nodes"].as_object().unwrap().iter().filter(inner).map(|(n, _)| n.clone()).collect();
        let value = |(from, to, parameter, factor): Coupling| {
            (from, to, factor * truth["parameters"][parameter.as_str()].as_f64().unwrap_or(1.0))
        };
        let mut conductors: Vec<_> = couplings("data/conductors.csv").into_iter().map(value).collect();
        let cable = &truth["cable"];
        let end = |index: usize| cable["between"][index].as_str().unwrap().to_owned();
        conductors.push((end(0), end(1), cable["conductance"].as_f64().unwrap()));
        let heated = (nodes.iter().enumerate())
            .filter_map(|(index, node)| {
                let power = model["loads"][format!("Q({node})")]["power"].as_str()?;
                Some((index, power.strip_suffix(" * Q_ring").or(power.strip_prefix("Q_ring * "))?.parse().unwrap()))
            })
            .collect();
        let radiations = couplings("data/radiations.csv").into_iter().map(value).collect();
        Self { nodes, conductors, radiations, heated }
    }

    /// Temperatures of the inner nodes in K.
    fn solved(&self, power_w: f64, chamber_k: f64) -> Vec<f64> {
        let count = self.nodes.len();
        let index: HashMap<&str, usize> = self.nodes.iter().enumerate().map(|(i, node)| (node.as_str(), i)).collect();
        let mut at = vec![chamber_k + 30.0; count];
        for _ in 0..40 {
            let mut matrix = vec![vec![0.0; count + 1]; count];
            let kelvin = |node: &str| index.get(node).map_or(chamber_k, |&i| at[i]);
            // Newton: sigma A (Ta^4 - Tb^4) about the last iterate.
            let linear = self.conductors.iter().map(|(a, b, g)| (a, b, [*g, *g], 0.0));
            let radiative = self.radiations.iter().map(|(a, b, area)| {
                let (from, to) = (kelvin(a), kelvin(b));
                let cube = |t: f64| t * t * t;
                let slopes = [4.0 * SIGMA * area * cube(from), 4.0 * SIGMA * area * cube(to)];
                let heat = SIGMA * area * (cube(from) * from - cube(to) * to);
                (a, b, slopes, heat - slopes[0] * from + slopes[1] * to)
            });
            for (a, b, [slope_a, slope_b], constant) in linear.chain(radiative) {
                for (own, other, slope_own, slope_other, sign) in
                    [(a, b, slope_a, slope_b, 1.0), (b, a, slope_b, slope_a, -1.0)]
                {
                    let Some(&row) = index.get(own.as_str()) else { continue };
                    matrix[row][row] += slope_own;
                    matrix[row][count] -= sign * constant;
                    match index.get(other.as_str()) {
                        Some(&column) => matrix[row][column] -= slope_other,
                        None => matrix[row][count] += slope_other * chamber_k,
                    }
                }
            }
            for &(node, share) in &self.heated {
                matrix[node][count] += share * power_w;
            }
            let next = eliminated(matrix);
            let change = next.iter().zip(&at).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            at = next;
            if change < 1e-9 {
                return at;
            }
        }
        panic!("no balance at {power_w} W and {chamber_k} K")
    }
}

/// Solves a linear system by elimination; diagonally dominant, so that no pivots are sought.
fn eliminated(mut matrix: Vec<Vec<f64>>) -> Vec<f64> {
    let count = matrix.len();
    for row in 0..count {
        let (above, below) = matrix.split_at_mut(row + 1);
        let pivot = &above[row];
        for other in below {
            let factor = other[row] / pivot[row];
            if factor != 0.0 {
                other[row..].iter_mut().zip(&pivot[row..]).for_each(|(value, upper)| *value -= factor * upper);
            }
        }
    }
    let mut solution = vec![0.0; count];
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|column| matrix[row][column] * solution[column]).sum();
        solution[row] = (matrix[row][count] - known) / matrix[row][row];
    }
    solution
}

#[test]
#[ignore = "thorough"]
fn the_data_are_what_the_truth_and_the_seed_give() {
    let truth: Value = serde_json::from_str(&read("truth.json")).unwrap();
    let network = Truth::new(&truth);
    assert_eq!((network.nodes.len(), network.heated.len()), (100, 10));
    let sensors: Vec<&str> = truth["sensors"].as_array().unwrap().iter().map(|node| node.as_str().unwrap()).collect();
    let place = |sensor: &&str| network.nodes.iter().position(|node| node == sensor).unwrap();
    let places: Vec<usize> = sensors.iter().map(place).collect();
    let noise = &truth["noise"];
    let key = StreamKey::new(noise["seed"].as_u64().unwrap(), noise["stream"].as_str().unwrap(), "noise");
    let columns: Vec<String> = sensors.iter().map(|sensor| format!("TC {sensor} [degC]")).collect();
    let mut text = format!("phase,T_chamber [degC],Q_ring [W],{}\n", columns.join(","));
    for (index, phase) in truth["phases"].as_array().unwrap().iter().enumerate() {
        let [power_w, chamber_c] = [0, 1].map(|column| phase[column].as_f64().unwrap());
        write!(text, "B{:02},{chamber_c},{power_w}", index + 1).unwrap();
        let mut stream = key.stream(index as u64);
        let solution = network.solved(power_w, chamber_c + ZERO_C);
        for &place in &places {
            let reading = solution[place] - ZERO_C + noise["sigma_k"].as_f64().unwrap() * stream.normal();
            write!(text, ",{reading:.2}").unwrap();
        }
        text.push('\n');
    }
    if std::fs::read_to_string(folder().join("data/balance-test.csv")).unwrap_or_default() != text {
        let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("disctr-balance-test.csv");
        std::fs::write(&made, &text).unwrap();
        panic!("studies/disctr/data/balance-test.csv is not what truth.json gives: see {}", made.display());
    }
}

#[test]
#[ignore = "thorough"]
fn the_deck_is_what_the_import_makes_of_it() {
    let root = tempfile::tempdir().unwrap();
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (from, name) in [
        ("decks/tests/esatan/DISCTR_TRANSIENT.TMD", "DISCTR_TRANSIENT.TMD"),
        ("studies/disctr/data/parts.csv", "parts.csv"),
    ] {
        std::fs::copy(repository.join(from), root.path().join(name)).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_bmv"))
        .current_dir(root.path())
        .args(["import", "DISCTR_TRANSIENT.TMD", "--parts", "parts.csv", "--into", "disctr"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for file in
        ["model.json", "pass-1.json", "data/conductors.csv", "data/radiations.csv", "data/record.csv", "data/parts.csv"]
    {
        let made = std::fs::read_to_string(root.path().join("disctr").join(file)).unwrap();
        assert!(made == read(file), "studies/disctr/{file} is not what the import makes");
    }
}
