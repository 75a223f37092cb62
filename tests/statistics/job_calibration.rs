//! Simulation-based calibration of the whole job (Talts, Betancourt, Simpson, Vehtari & Gelman 2018): true values from
//! the priors, readings from them, then estimate, sampling and summary as a study has them. The ranks of the true values
//! are uniform and the 95 % intervals hold 95 % of them, for every sampler.

use std::sync::Arc;

use bmv::job::calibrate::{Calibrate, Inputs, Output, Sampler, Spec};
use bmv::measurement::{Measurement, Phase, Rows, Uncertain};
use bmv::random::{Distribution, StreamKey};
use bmv::thermal::{Model, Network, Start};

use crate::verification::build::Build;
use crate::verification::network8_data::sensor;
use crate::verification::radiator::run;

/// Draws compared with the truth: ranks of 0 to 63, in eight bins.
const DRAWS: usize = 63;
const BINS: usize = 8;
const SIGMA_K: f64 = 0.5;

/// Two nodes, a joint between them, a radiator with an uncertain emittance, and an uncertain load.
fn model() -> Model {
    let mut b = Build::default();
    let joint = b.parameter("G", 1.0);
    let emittance = b.parameter("eps", 0.8);
    let load = b.parameter("Q", 10.0);
    let heater = b.input("P", 0.0);
    let room = b.input("T_room", 290.0);
    b.diffusion("box", 900.0);
    b.diffusion("radiator", 400.0);
    let room = b.boundary("room", room);
    let cold = b.n(4.0);
    let space = b.boundary("space", cold);
    b.conductor("joint", [0, 1], joint);
    let leak = b.n(0.2);
    b.conductor("leak", [0, room], leak);
    let area = b.scale(0.1, emittance);
    b.radiation("radiator", [1, space], area);
    b.load("heater", 0, heater);
    b.load("electronics", 0, load);
    b.temperature("box", 0);
    b.temperature("radiator", 1);
    b.model
}

fn priors() -> Vec<Distribution> {
    vec![
        Distribution::Uniform { lower: 0.5, upper: 2.0 },
        Distribution::Uniform { lower: 0.6, upper: 0.95 },
        Distribution::Normal { mean: 10.0, sd: 2.0, lower: None, upper: None },
    ]
}

/// Prior of the second sensor's noise.
fn noise_prior() -> Distribution {
    Distribution::LogNormal { median: SIGMA_K, factor: 1.5 }
}

/// True values and a campaign with them.
fn campaign(model: &Model, network: &Network, set: u64) -> (Vec<f64>, Measurement) {
    let mut stream = StreamKey::new(3, "job calibration", "data").stream(set);
    let mut truth: Vec<f64> = priors().iter().map(|prior| prior.quantile(stream.uniform())).collect();
    let noise = noise_prior().quantile(stream.uniform());
    let mut workspace = network.workspace();
    network.set_parameters(&mut workspace, &truth);
    truth.push(noise);
    let (mut phases, mut readings) = (Vec::new(), Vec::new());
    for row in 0..6 {
        let inputs = vec![8.0 * f64::from(row), if row % 2 == 0 { 280.0 } else { 310.0 }];
        network.set_inputs(&mut workspace, &inputs);
        network.solve_steady(&mut workspace, Start::Default).unwrap();
        for (node, sd) in [SIGMA_K, noise].into_iter().enumerate() {
            readings.push(Some(workspace.temperatures()[node] + sd * stream.normal()));
        }
        phases.push(Phase { name: format!("P{row}"), inputs, held_out: false, ignored: None, stabilisation: None });
    }
    let sensors =
        vec![sensor("box", 0, Uncertain::Known(SIGMA_K)), sensor("radiator", 1, Uncertain::Inferred(noise_prior()))];
    assert_eq!(model.quantities.len(), 2);
    let measurement = Measurement {
        name: "test".into(),
        rows: Rows::Steady(phases),
        sensors,
        readings,
        file: "data.csv".into(),
        sha256: String::new(),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    (truth, measurement)
}

fn check(sampler: Sampler, sets: u64, warmup: u64, draws: u64, coverage: std::ops::RangeInclusive<f64>) {
    let model = model();
    let network = Network::compile(&model, &[]).unwrap();
    let shared = Arc::new(model.clone());
    let mut bins = [[0_u32; BINS]; 4];
    let mut inside = [0_u32; 4];
    for set in 0..sets {
        let (truth, measurement) = campaign(&model, &network, set);
        let spec =
            Spec { data: vec![0], parameters: vec![0, 1, 2], sampler, chains: 2, warmup, draws, acceptance: None };
        let inputs = Inputs {
            model: Arc::clone(&shared),
            priors: priors(),
            measurements: Arc::new(vec![measurement]),
            input_errors: vec![],
        };
        let output: Output = run(&Calibrate::new(spec, inputs, set, "tuned").unwrap());
        let kept = &output.draws.values;
        assert!(kept.len() >= DRAWS);
        for (place, (name, &value)) in output.order.iter().zip(&truth).enumerate() {
            let rank = (0..DRAWS).filter(|k| kept[(2 * k + 1) * kept.len() / (2 * DRAWS)][place] < value).count();
            bins[place][rank * BINS / (DRAWS + 1)] += 1;
            let own = &output.parameters[name];
            // Units are SI here.
            inside[place] += u32::from(own.q025 <= value && value <= own.q975);
        }
    }
    let expected = sets as f64 / BINS as f64;
    let uneven = bins
        .map(|row| row.iter().map(|&n| (f64::from(n) - expected) * (f64::from(n) - expected) / expected).sum::<f64>());
    let covered = inside.map(|n| f64::from(n) / sets as f64);
    println!("{}: {sets} data sets, chi-square of the ranks {uneven:.1?}, coverage {covered:.3?}", sampler.name());
    for place in 0..4 {
        // Seven degrees of freedom, 99.9 %.
        assert!(uneven[place] < 24.32, "{}: {uneven:?} {bins:?}", sampler.name());
        assert!(coverage.contains(&covered[place]), "{}: {covered:?}", sampler.name());
    }
}

/// The 99.9 % range of a binomial share of 95 % in 1000.
const OF_1000: std::ops::RangeInclusive<f64> = 0.926..=0.971;
/// The same in 40: 32 or more.
const OF_40: std::ops::RangeInclusive<f64> = 0.8..=1.0;

#[test]
#[ignore = "thorough"]
fn the_job_is_calibrated_over_few_data_sets() {
    check(Sampler::Nuts, 40, 100, 100, OF_40);
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly"]
    fn the_job_is_calibrated_with_nuts() {
        check(Sampler::Nuts, 1000, 300, 500, OF_1000);
    }

    #[test]
    #[ignore = "nightly"]
    fn the_job_is_calibrated_with_metropolis() {
        check(Sampler::AdaptiveMetropolis, 1000, 1500, 3000, OF_1000);
    }

    #[test]
    #[ignore = "nightly"]
    fn the_job_is_calibrated_with_smc() {
        check(Sampler::Smc, 1000, 0, 500, OF_1000);
    }
}
