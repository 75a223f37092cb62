//! Speed of screening: the signatures of every candidate.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use bmv::diagnosis::Problem;
use bmv::diagnosis::linearisation::signature::{for_each_direction, linearise};
use bmv::document::Diagnostics;
use bmv::effect::{Catalogue, candidates};
use bmv::inference::likelihood::Likelihood;
use bmv::measurement::sensor_places;
use bmv::measurement::{Measurement, Phase, Rows, Sensor, Uncertain};
use bmv::random::Distribution;
use criterion::{Criterion, criterion_group, criterion_main};

#[path = "../tests/verification/build.rs"]
#[allow(dead_code)]
mod build;
use build::Build;

const NODES: usize = 500;

fn problem(path: &Path) -> Option<Problem> {
    let pass = bmv::job::load(path).ok()?;
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let sensors = sensor_places(pass.measurements.iter());
    let candidates = candidates(&pass.model, &[], &sensors, &catalogue);
    Some(Problem {
        parameters: (0..pass.priors.len()).filter(|&i| !pass.priors[i].is_fixed()).collect(),
        model: Arc::new(pass.model),
        priors: pass.priors,
        measurements: pass.measurements,
        input_errors: Vec::new(),
        catalogue,
        candidates: Arc::new(candidates),
        joint: Vec::new(),
        most_steps: Vec::new(),
        noise_freedom: None,
        is_misspecified: false,
        independent_readings: 0.0,
        considered: Vec::new(),
        working_temperatures_k: Default::default(),
        places: Default::default(),
        missing_probability: Default::default(),
        tolerance: 1.0,
    })
}

fn likelihood(problem: &Problem) -> Likelihood {
    problem.hypothesis(&[], 1.0).unwrap().likelihood(problem).unwrap()
}

fn middle(likelihood: &Likelihood) -> Vec<f64> {
    likelihood.unknowns().priors.iter().map(|prior| prior.quantile(0.5)).collect()
}

fn campaign(c: &mut Criterion) {
    let Some(path) = std::env::var_os("BMV_DIAGNOSE") else { return };
    let problem = problem(Path::new(&path)).unwrap();
    let likelihood = likelihood(&problem);
    let unknowns = middle(&likelihood);
    let all: Vec<usize> = (0..problem.candidates.len()).collect();
    let mut count = 0;
    let unseen = for_each_direction(&problem, &likelihood, &unknowns, &all, &mut |_| count += 1).unwrap();
    eprintln!("{} candidates: {count} directions, {} unseen", problem.candidates.len(), unseen.len());
    let mut group = c.benchmark_group("campaign");
    group.sample_size(10);
    group.bench_function("linearise", |b| b.iter(|| linearise(black_box(&likelihood), &unknowns)));
    group.bench_function("directions", |b| {
        b.iter(|| {
            for_each_direction(black_box(&problem), &likelihood, &unknowns, &all, &mut |one| drop(black_box(one)))
        });
    });
    group.finish();
}

/// A panel of 500 nodes in a row of 20, conductors between neighbours, radiation to space, ten stand-offs to a plate,
/// loads from four inputs; 40 phases read by 60 sensors.
fn panel() -> Problem {
    let mut b = Build::default();
    let (plate_k, space_k, pressure) = (b.input("T_plate", 290.0), b.input("T_space", 80.0), b.input("p", 1.0));
    let powers: Vec<_> = (0..4).map(|k| b.input(&format!("Q_{k}"), 10.0)).collect();
    for (input, unit) in ["K", "K", "Pa", "W", "W", "W", "W"].into_iter().enumerate() {
        let nominal = b.model.inputs[input].nominal;
        b.model.inputs[input].unit = unit.into();
        b.model.inputs[input].range = Some([0.5 * nominal, 1.5 * nominal]);
    }
    let conductances: Vec<_> = (0..30).map(|k| b.parameter(&format!("G_{k}"), 0.2 + 0.01 * f64::from(k))).collect();
    let (plate, space) = (b.boundary("plate", plate_k), b.boundary("space", space_k));
    let nodes: Vec<usize> = (0..NODES).map(|k| b.diffusion(&format!("n{k}"), 100.0)).collect();
    for k in 0..NODES {
        let g = conductances[k % 30];
        if k % 20 != 19 {
            b.conductor(&format!("along {k}"), [nodes[k], nodes[k + 1]], g);
        }
        if k + 20 < NODES {
            b.conductor(&format!("across {k}"), [nodes[k], nodes[k + 20]], g);
        }
        let area = b.n(0.003);
        b.radiation(&format!("face {k}"), [nodes[k], space], area);
        if k % 50 == 7 {
            b.conductor(&format!("stand-off {k}"), [nodes[k], plate], g);
        }
        if k % 125 == 60 {
            b.load(&format!("unit {k}"), nodes[k], powers[k / 125]);
        }
        b.temperature(&format!("n{k}"), nodes[k]);
    }
    b.quantity("p", pressure);
    for quantity in &mut b.model.quantities[..NODES] {
        (quantity.is_temperature, quantity.unit) = (true, "K".into());
    }
    let sensors = (0..60).map(|k| Sensor {
        name: format!("S{k}"),
        quantity: 8 * k + 3,
        unit: "K".into(),
        sigma: Some(Uncertain::Known(0.3)),
        bias: None,
        lag_s: None,
        behind_s: Vec::new(),
        correlation_time_s: None,
        white: None,
    });
    let phases = (0..40).map(|k: usize| Phase {
        name: format!("P{k}"),
        inputs: (b.model.inputs.iter().enumerate())
            .map(|(i, input)| input.nominal * (0.6 + 0.8 * ((k * (2 * i + 3) + i) % 11) as f64 / 10.0))
            .collect(),
        held_out: false,
        ignored: None,
        stabilisation: None,
    });
    let measurement = Measurement {
        name: "balance".into(),
        rows: Rows::Steady(phases.collect()),
        sensors: sensors.collect(),
        readings: vec![Some(285.0); 40 * 60],
        file: String::new(),
        sha256: String::new(),
        unused_columns: vec![],
        time_zero_s: None,
        follows_gap: false,
        doubts: vec![],
    };
    let catalogue = Arc::new(Catalogue::embedded(&mut Diagnostics::new()));
    let began = Instant::now();
    let mut all = candidates(&b.model, &[], &sensor_places([&measurement].into_iter()), &catalogue);
    eprintln!("panel: {} candidates listed in {:.1?}", all.len(), began.elapsed());
    let every = all.len() / 100_000;
    let mut position = 0;
    all.retain(|_| {
        position += 1;
        position % every.max(1) == 0
    });
    Problem {
        priors: vec![Distribution::LogNormal { median: 0.3, factor: 1.5 }; 30],
        parameters: (0..30).collect(),
        model: Arc::new(b.model),
        measurements: vec![measurement],
        input_errors: Vec::new(),
        catalogue,
        candidates: Arc::new(all),
        joint: Vec::new(),
        most_steps: Vec::new(),
        noise_freedom: None,
        is_misspecified: false,
        independent_readings: 0.0,
        considered: Vec::new(),
        working_temperatures_k: Default::default(),
        places: Default::default(),
        missing_probability: Default::default(),
        tolerance: 1.0,
    }
}

/// Largest memory of this process, MiB.
fn peak_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap_or("");
    line.split_whitespace().nth(1).and_then(|kib| kib.parse::<f64>().ok()).unwrap_or(f64::NAN) / 1024.0
}

/// One pass over everything: a repetition would tell no more.
fn large(_: &mut Criterion) {
    let problem = panel();
    let likelihood = likelihood(&problem);
    let unknowns = middle(&likelihood);
    let began = Instant::now();
    let linear = linearise(&likelihood, &unknowns).unwrap();
    eprintln!("panel: linearised ({} rows, {} unknowns) in {:.2?}", linear.rows, linear.parameters(), began.elapsed());
    let began = Instant::now();
    let all: Vec<usize> = (0..problem.candidates.len()).collect();
    let mut count = 0_usize;
    let unseen = for_each_direction(&problem, &likelihood, &unknowns, &all, &mut |one| {
        black_box(one);
        count += 1;
    });
    eprintln!(
        "panel: {} candidates, {count} directions, {} unseen in {:.1?}, peak {:.0} MiB",
        problem.candidates.len(),
        unseen.unwrap().len(),
        began.elapsed(),
        peak_mib()
    );
}

criterion_group!(benches, campaign, large);
criterion_main!(benches);
