//! The data of `studies/hidden-effect`, made again from its truth by a solution of its own: five balances, radiation
//! linearised about the last iterate, and elimination.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use bmv::random::StreamKey;
use serde_json::Value;

const ZERO_C: f64 = 273.15;
/// Stefan-Boltzmann constant, W/(m2 K4) (CODATA 2018).
const SIGMA: f64 = 5.670374419e-8;
const HEADER: &str = "phase,T_panel [degC],T_shroud [degC],Q_box [W],Q_ccd [W],bracket [degC],housing [degC],box [degC],ccd [degC],baffle [degC]";
/// Panel and shroud in degC, powers of box and detector in W. Cold and warm panels with cold and warm shrouds, so that
/// conduction and radiation differ.
const PHASES: [[f64; 4]; 14] = [
    [20.0, -150.0, 6.0, 0.4],
    [-25.0, -175.0, 2.0, 0.2],
    [45.0, -150.0, 8.0, 1.0],
    [10.0, -120.0, 5.0, 0.6],
    [45.0, 0.0, 1.0, 0.1],
    [-25.0, -60.0, 9.0, 1.2],
    [30.0, -170.0, 7.0, 0.3],
    [0.0, -20.0, 0.0, 1.4],
    [-10.0, -175.0, 10.0, 0.0],
    [25.0, -80.0, 3.0, 0.9],
    [50.0, -175.0, 0.5, 0.5],
    [15.0, 10.0, 9.5, 0.7],
    [-20.0, -140.0, 4.0, 1.1],
    [35.0, -100.0, 6.5, 0.0],
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/hidden-effect")
}

/// Solves a small linear system by elimination; diagonally dominant, so that no pivots are sought.
fn eliminated(mut matrix: [[f64; 6]; 5]) -> [f64; 5] {
    for row in 0..5 {
        for below in row + 1..5 {
            let factor = matrix[below][row] / matrix[row][row];
            for column in row..6 {
                matrix[below][column] -= factor * matrix[row][column];
            }
        }
    }
    let mut solution = [0.0; 5];
    for row in (0..5).rev() {
        let known: f64 = (row + 1..5).map(|column| matrix[row][column] * solution[column]).sum();
        solution[row] = (matrix[row][5] - known) / matrix[row][row];
    }
    solution
}

/// Bracket, housing, box, detector and baffle in K.
fn solved(truth: &Value, [panel_c, shroud_c, box_w, ccd_w]: [f64; 4]) -> [f64; 5] {
    let of = |name: &str| truth["parameters"][name].as_f64().unwrap();
    let view = truth["effect"]["radiative-path"]["parameters"]["exchange_area"]["nominal"].as_f64().unwrap();
    let (panel, shroud) = (panel_c + ZERO_C, shroud_c + ZERO_C);
    let mut at = [panel; 5];
    for _ in 0..200 {
        let mut matrix = [[0.0; 6]; 5];
        let radiative = |area: f64, a: f64, b: f64| SIGMA * area * (a * a + b * b) * (a + b);
        let pairs = [
            (0, 1, of("G_housing")),
            (1, 2, of("G_box")),
            (1, 3, of("G_ccd")),
            (1, 4, of("G_baffle")),
            (2, 4, radiative(view, at[2], at[4])),
        ];
        for (a, b, conductance) in pairs {
            for (own, other) in [(a, b), (b, a)] {
                matrix[own][own] += conductance;
                matrix[own][other] -= conductance;
            }
        }
        let sinks = [
            (0, of("G_foot"), panel),
            (1, radiative(of("e_mli") * 0.12, at[1], shroud), shroud),
            (4, radiative(of("eps_baffle") * 0.018, at[4], shroud), shroud),
        ];
        for (node, conductance, sink) in sinks {
            matrix[node][node] += conductance;
            matrix[node][5] += conductance * sink;
        }
        matrix[2][5] += box_w;
        matrix[3][5] += ccd_w;
        at = eliminated(matrix);
    }
    at
}

#[test]
fn the_data_are_what_the_truth_and_the_seed_give() {
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(folder().join("truth.json")).unwrap()).unwrap();
    let noise = &truth["noise"];
    let key = StreamKey::new(noise["seed"].as_u64().unwrap(), noise["stream"].as_str().unwrap(), "noise");
    let mut text = format!("{HEADER}\n");
    for (index, phase) in PHASES.into_iter().enumerate() {
        let [panel, shroud, box_w, ccd_w] = phase;
        write!(text, "B{:02},{panel},{shroud},{box_w},{ccd_w}", index + 1).unwrap();
        let mut stream = key.stream(index as u64);
        for temperature in solved(&truth, phase) {
            let reading = temperature - ZERO_C + noise["sigma_k"].as_f64().unwrap() * stream.normal();
            write!(text, ",{reading:.3}").unwrap();
        }
        text.push('\n');
    }
    let stored = std::fs::read_to_string(folder().join("data/balance-test.csv")).unwrap_or_default();
    if stored != text {
        let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("balance-test.csv");
        std::fs::write(&made, &text).unwrap();
        panic!("studies/hidden-effect/data/balance-test.csv is not what truth.json gives: see {}", made.display());
    }
}
