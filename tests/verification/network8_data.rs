//! The electronics box of 8 nodes in 43 steady phases with five sensors, and its noise: a benchmark whose posterior was
//! had apart (Python, SciPy: least squares, and importance sampling with 30 000 draws).

use bmv::expression::Symbol;
use bmv::inference::likelihood::{Definition, Likelihood};
use bmv::measurement::{Measurement, Phase, Rows, Sensor, Uncertain};
use bmv::random::Distribution;
use bmv::thermal::{Model, Network, Start};

use super::build::Build;

pub const TRUTH: [f64; 4] = [4.0, 0.85, 0.03, 0.15];
pub const SIGMA_K: f64 = 0.5;
const SENSORS: [usize; 5] = [0, 2, 3, 5, 7];
pub const PHASES: usize = 43;

/// Parameters: G_tim, eps_rad, eps_mli, alpha; inputs: Q0, Q1, Q2 (W), S (W/m2), T_base, T_space (K).
pub fn model() -> Model {
    let mut b = Build::default();
    let g_tim = b.parameter("G_tim", 4.0);
    let eps_rad = b.parameter("eps_rad", 0.85);
    let eps_mli = b.parameter("eps_mli", 0.03);
    let alpha = b.parameter("alpha", 0.15);
    let heat: Vec<_> = (0..3).map(|i| b.input(&format!("Q{i}"), 10.0)).collect();
    let sun = b.input("S", 0.0);
    let base = b.input("T_base", 290.0);
    let space = b.input("T_space", 4.0);
    for (i, capacity) in [900.0, 1200.0, 1500.0, 400.0, 400.0, 400.0, 150.0, 150.0].into_iter().enumerate() {
        b.diffusion(&format!("n{i}"), capacity);
    }
    let base = b.boundary("base", base);
    let space = b.boundary("space", space);
    let links = [
        (0, 1, 1.2),
        (1, 2, 2.0),
        (0, 2, 0.6),
        (3, 4, 1.5),
        (4, 5, 1.5),
        (0, 6, 0.05),
        (1, 7, 0.05),
        (6, 7, 0.3),
        (0, base, 0.25),
        (2, base, 0.10),
        (5, base, 0.05),
    ];
    for (i, (from, to, conductance)) in links.into_iter().enumerate() {
        let conductance = b.n(conductance);
        b.conductor(&format!("c{i}"), [from, to], conductance);
    }
    b.conductor("tim", [2, 3], g_tim);
    for (from, to, area) in [(0, 6, 0.010), (1, 7, 0.010), (2, 7, 0.006)] {
        let area = b.n(area);
        b.radiation(&format!("r{from}{to}"), [from, to], area);
    }
    for node in [3, 4, 5] {
        let area = b.scale(0.06, eps_rad);
        b.radiation(&format!("radiator {node}"), [node, space], area);
        let absorbed = b.mul(alpha, sun);
        let power = b.scale(0.06, absorbed);
        b.load(&format!("sun {node}"), node, power);
    }
    for node in [6, 7] {
        let area = b.scale(0.40, eps_mli);
        b.radiation(&format!("mli {node}"), [node, space], area);
    }
    for (node, power) in heat.into_iter().enumerate() {
        b.load(&format!("heat {node}"), node, power);
    }
    for node in SENSORS {
        let value = b.graph().symbol(Symbol::Node(node as u32));
        b.quantity(&format!("n{node}"), value);
    }
    b.model
}

fn inputs(i: usize) -> Vec<f64> {
    vec![
        5.0 + 10.0 * ((i * 7) % 11) as f64 / 10.0,
        2.0 + 8.0 * ((i * 5) % 13) as f64 / 12.0,
        10.0 + 30.0 * ((i * 3) % 7) as f64 / 6.0,
        1361.0 * ((i * 2) % 5) as f64 / 4.0 * 0.5,
        263.15 + 50.0 * ((i * 4) % 9) as f64 / 8.0,
        if i.is_multiple_of(3) { 100.0 } else { 4.0 },
    ]
}

/// splitmix64 to uniform numbers, Box and Muller to normal ones, cosine before sine.
fn normals(count: usize) -> Vec<f64> {
    let mut state: u64 = 20_260_101;
    let mut uniform = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        ((z >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    let mut out = Vec::new();
    while out.len() < count {
        let (u, v) = (uniform(), uniform());
        let radius = (-2.0 * libm::log(u)).sqrt();
        let angle = 2.0 * std::f64::consts::PI * v;
        out.extend([radius * libm::cos(angle), radius * libm::sin(angle)]);
    }
    out.truncate(count);
    out
}

pub fn sensor(name: &str, quantity: usize, sigma: Uncertain) -> Sensor {
    Sensor {
        name: name.into(),
        quantity,
        unit: "K".into(),
        sigma: Some(sigma),
        bias: None,
        lag_s: None,
        behind_s: Vec::new(),
        correlation_time_s: None,
        white: None,
    }
}

/// The 43 phases with their noise.
pub fn measurement(model: &Model) -> Measurement {
    let network = Network::compile(model, &[]).expect("compiles");
    let mut workspace = network.workspace();
    network.set_parameters(&mut workspace, &TRUTH);
    let noise = normals(PHASES * 5);
    let (mut phases, mut readings) = (Vec::new(), Vec::new());
    for i in 0..PHASES {
        network.set_inputs(&mut workspace, &inputs(i));
        network.solve_steady(&mut workspace, Start::Default).expect("solves");
        for (s, &node) in SENSORS.iter().enumerate() {
            readings.push(Some(workspace.temperatures()[node] + SIGMA_K * noise[5 * i + s]));
        }
        phases.push(Phase {
            name: format!("P{i:02}"),
            inputs: inputs(i),
            held_out: false,
            ignored: None,
            stabilisation: None,
        });
    }
    Measurement {
        name: "balance test".into(),
        rows: Rows::Steady(phases),
        sensors: SENSORS
            .iter()
            .enumerate()
            .map(|(s, node)| sensor(&format!("s{node}"), s, Uncertain::Known(SIGMA_K)))
            .collect(),
        readings,
        file: "data.csv".into(),
        sha256: String::new(),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    }
}

pub fn priors() -> [Distribution; 4] {
    [(1.0, 8.0), (0.70, 0.95), (0.005, 0.08), (0.05, 0.35)].map(|(lower, upper)| Distribution::Uniform { lower, upper })
}

pub fn likelihood() -> Likelihood {
    let model = model();
    let measurement = measurement(&model);
    Likelihood::new(&Definition {
        model: &model,
        priors: &priors(),
        parameters: &[0, 1, 2, 3],
        measurements: &[&measurement],
        input_errors: &[],
    })
    .expect("a likelihood")
}
