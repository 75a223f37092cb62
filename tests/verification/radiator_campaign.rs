//! The radiator's synthetic tests made again: the coupon with the emittance as it truly is, and the panel as a spatial
//! model of 20 x 20 nodes.
//!
//! Truth: emittance 0.88; the coupon's leak 0.006 W/K. The panel has 0.55 m x 0.545 m of 3 mm aluminium (167 W/(m K)); the heat enters
//! evenly over the middle 0.15 m x 0.15 m (by the area that each node shares with it), and every node radiates from one side
//! to the shroud. Noise: 0.5 K on every reading.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use bmv::random::StreamKey;
use bmv::study::Pass;
use bmv::thermal::{Network, Start};

const ZERO_C: f64 = 273.15;
const SIGMA: f64 = 5.670_374_419e-8;
/// Seed of the noise.
const SEED: u64 = 2015;
const EMITTANCE: f64 = 0.88;
const LEAK: f64 = 0.006;
const NOISE_K: f64 = 0.5;
/// Nodes along each side.
const SIDE: usize = 20;
const LENGTHS_M: [f64; 2] = [0.55, 0.545];

/// Heater and shroud of the coupon: the three phases that the design of pass 1 picks, each done twice.
const COUPON: [(f64, f64); 3] = [(25.0, 250.0), (5.0, 100.0), (25.0, 200.0)];
/// Heater and shroud of the panel's phases.
const PANEL: [(f64, f64); 5] = [(60.0, 100.0), (100.0, 100.0), (120.0, 100.0), (100.0, 150.0), (100.0, 200.0)];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/radiator")
}

fn load(file: &Path) -> Pass {
    match bmv::job::load(file) {
        Ok(pass) => pass,
        Err(diagnostics) => panic!("{}", diagnostics.render(false, 20)),
    }
}

/// Steady temperatures of all nodes, K.
fn solved(pass: &Pass, parameters: &[(&str, f64)], inputs: &[(&str, f64)]) -> Vec<f64> {
    let model = &pass.model;
    let network = Network::compile(model, &[]).unwrap();
    let mut workspace = network.workspace();
    let mut values = network.nominal_parameters().to_vec();
    for (name, value) in parameters {
        values[model.parameters.iter().position(|p| p.name == *name).unwrap()] = *value;
    }
    let mut given = network.nominal_inputs().to_vec();
    for (name, value) in inputs {
        given[model.inputs.iter().position(|p| p.name == *name).unwrap()] = *value;
    }
    network.set_parameters(&mut workspace, &values);
    network.set_inputs(&mut workspace, &given);
    network.solve_steady(&mut workspace, Start::Default).unwrap();
    workspace.temperatures().to_vec()
}

/// Length that a node shares with the heated middle of a side.
fn heated_m(place: usize, length_m: f64) -> f64 {
    let step = length_m / SIDE as f64;
    let (low, high) = (place as f64 * step, (place + 1) as f64 * step);
    let (from, to) = (0.5 * length_m - 0.075, 0.5 * length_m + 0.075);
    (high.min(to) - low.max(from)).max(0.0)
}

/// The panel as a study of its own.
fn panel() -> Pass {
    let [dx, dy] = LENGTHS_M.map(|length| length / SIDE as f64);
    let across = 167.0 * 0.003;
    let (mut nodes, mut conductors, mut radiations, mut loads) =
        (String::new(), String::new(), String::new(), String::new());
    for i in 0..SIDE {
        for j in 0..SIDE {
            write!(nodes, r#""n{i}_{j}": {{}}, "#).unwrap();
            write!(
                radiations,
                r#""r{i}_{j}": {{"between": ["n{i}_{j}", "shroud"], "exchange_area": {}}},"#,
                EMITTANCE * dx * dy
            )
            .unwrap();
            if i + 1 < SIDE {
                let g = across * dy / dx;
                write!(conductors, r#""x{i}_{j}": {{"between": ["n{i}_{j}", "n{}_{j}"], "conductance": {g}}},"#, i + 1)
                    .unwrap();
            }
            if j + 1 < SIDE {
                let g = across * dx / dy;
                write!(conductors, r#""y{i}_{j}": {{"between": ["n{i}_{j}", "n{i}_{}"], "conductance": {g}}},"#, j + 1)
                    .unwrap();
            }
            let share = heated_m(i, LENGTHS_M[0]) * heated_m(j, LENGTHS_M[1]) / (0.15 * 0.15);
            if share > 0.0 {
                write!(loads, r#""h{i}_{j}": {{"into": "n{i}_{j}", "power": "{share} * P"}},"#).unwrap();
            }
        }
    }
    let strip = |text: String| text.trim_end_matches(',').to_owned();
    let model = format!(
        r#"{{"format": "bmv-network/1", "title": "panel",
            "inputs": {{"P": {{"unit": "W", "nominal": 100}}, "T_sink": {{"unit": "K", "nominal": 100}}}},
            "nodes": {{{nodes} "shroud": {{"boundary": "T_sink"}}}}, "conductors": {{{}}}, "radiations": {{{}}}, "loads": {{{}}}}}"#,
        strip(conductors),
        strip(radiations),
        strip(loads)
    );
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("model.json"), model).unwrap();
    let file = folder.path().join("pass-1.json");
    std::fs::write(&file, r#"{"format": "bmv-pass/1", "title": "panel", "model": "model.json"}"#).unwrap();
    load(&file)
}

/// Mean of the nodes round the middle of the panel and round the middles of its quarters; mean over the heated middle.
fn readings(temperatures: &[f64]) -> [f64; 2] {
    let at = |i: usize, j: usize| temperatures[i * SIDE + j];
    let round = |i: usize, j: usize| 0.25 * (at(i - 1, j - 1) + at(i - 1, j) + at(i, j - 1) + at(i, j));
    let five = [(10, 10), (5, 5), (5, 15), (15, 5), (15, 15)];
    let mean = five.map(|(i, j)| round(i, j)).iter().sum::<f64>() / 5.0;
    let (mut sum, mut area) = (0.0, 0.0);
    for i in 0..SIDE {
        for j in 0..SIDE {
            let own = heated_m(i, LENGTHS_M[0]) * heated_m(j, LENGTHS_M[1]);
            sum += own * at(i, j);
            area += own;
        }
    }
    [mean, sum / area]
}

fn same(file: &str, text: &str) {
    let stored = std::fs::read_to_string(folder().join(file)).unwrap_or_default();
    if stored != text {
        let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join(Path::new(file).file_name().unwrap());
        std::fs::write(&made, text).unwrap();
        panic!("studies/radiator/{file} is not what the truth and the seed give: see {}", made.display());
    }
}

#[test]
fn the_coupons_readings_are_made_again_byte_for_byte() {
    let pass = load(&folder().join("pass-1.json"));
    let place = pass.model.nodes.iter().position(|node| node.name == "coupon").unwrap();
    let noise = StreamKey::new(SEED, "coupon", "noise");
    let mut text = String::from("phase,W [W],T_s [K],coupon [degC]\n");
    for (index, (heater, shroud)) in COUPON.iter().chain(&COUPON).enumerate() {
        let truth = solved(&pass, &[("eps", EMITTANCE), ("G_leak", LEAK)], &[("W", *heater), ("T_s", *shroud)])[place];
        let reading = truth - ZERO_C + NOISE_K * noise.stream(index as u64).normal();
        writeln!(text, "C{},{heater},{shroud},{reading:.3}", index + 1).unwrap();
    }
    same("data/coupon.csv", &text);
}

#[test]
fn the_panels_readings_are_made_again_byte_for_byte() {
    let pass = panel();
    let noise = StreamKey::new(SEED, "panel", "noise");
    let mut text = String::from("phase,flight [1],P [W],T_sink [K],panel [degC],footprint [degC]\n");
    for (index, (heater, shroud)) in PANEL.into_iter().enumerate() {
        let temperatures = solved(&pass, &[], &[("P", heater), ("T_sink", shroud)]);
        // What goes in goes out: to 1e-6 W with residuals below 1e-9 W a node.
        let area = EMITTANCE * LENGTHS_M[0] * LENGTHS_M[1] / (SIDE * SIDE) as f64;
        let fourth = |t: f64| t * t * t * t;
        let out: f64 = temperatures[..SIDE * SIDE].iter().map(|t| SIGMA * area * (fourth(*t) - fourth(shroud))).sum();
        assert!((out - heater).abs() < 1e-6, "{out}");
        let mut stream = noise.stream(index as u64);
        write!(text, "B{},0,{heater},{shroud}", index + 1).unwrap();
        for truth in readings(&temperatures) {
            write!(text, ",{:.3}", truth - ZERO_C + NOISE_K * stream.normal()).unwrap();
        }
        text.push('\n');
    }
    same("data/thermal-balance.csv", &text);
}
