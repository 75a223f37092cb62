//! Speed of inference: likelihood and gradient of the electronics box of 8 nodes and of the X-ray monitor (43 steady
//! phases each), and effective draws a second of the box, in memory and of the whole program.
//!
//! `BMV_PEERS` names a folder with `c_calibrate.py`, the same calibration with tools in Python, and `BMV_PYTHON` the
//! interpreter: then these run in turn with the program, process start counted.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use bmv::inference::likelihood::{Definition, Likelihood};
use bmv::inference::sampler::chains::Chains;
use bmv::inference::sampler::convergence::{ConvergenceLimits, judge};
use bmv::inference::sampler::nuts::{self, NutsSettings};
use bmv::inference::target::Target;
use bmv::measurement::Rows;
use bmv::random::StreamKey;
use criterion::{Criterion, criterion_group, criterion_main};

#[path = "support/box_study.rs"]
mod box_study;
#[path = "../tests/verification/build.rs"]
#[allow(dead_code)]
mod build;
#[path = "../tests/verification/network8_data.rs"]
#[allow(dead_code)]
mod network8_data;

/// The likelihood of the monitor with all 43 phases: of these parameters, or of all uncertain ones.
fn monitor(parameters: Option<&[&str]>) -> Option<Likelihood> {
    let pass = bmv::job::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies/sxm/pass-3.json")).ok()?;
    let chosen: Vec<usize> = (0..pass.priors.len())
        .filter(|&i| match parameters {
            Some(names) => names.contains(&pass.model.parameters[i].name.as_str()),
            None => !pass.priors[i].is_fixed(),
        })
        .collect();
    let mut measurements = pass.measurements.clone();
    for measurement in &mut measurements {
        if let Rows::Steady(phases) = &mut measurement.rows {
            phases.iter_mut().for_each(|phase| phase.held_out = false);
        }
    }
    let measurements: Vec<_> = measurements.iter().collect();
    let (model, priors) = (&pass.model, pass.priors.as_slice());
    let definition = Definition { model, priors, parameters: &chosen, measurements: &measurements, input_errors: &[] };
    Likelihood::new(&definition).ok()
}

/// Value and gradient at points that wander through the middle half of the priors.
fn evaluate(c: &mut Criterion, name: &str, target: &Likelihood) {
    let n = target.dimension();
    let points: Vec<Vec<f64>> = (0..16)
        .map(|k| {
            let share = |i: usize| 0.25 + 0.5 * ((k * 7 + i * 3) % 16) as f64 / 16.0;
            (0..n).map(|i| target.priors()[i].quantile(share(i))).collect()
        })
        .collect();
    let (mut memory, mut gradient, mut at) = (target.workspace(), vec![0.0; n], 0);
    c.bench_function(&format!("{name}: gradient of {n} parameters"), |b| {
        b.iter(|| {
            at = (at + 1) % points.len();
            target.log_likelihood_gradient(black_box(&points[at]), &mut memory, &mut gradient)
        });
    });
    c.bench_function(&format!("{name}: likelihood"), |b| {
        b.iter(|| {
            at = (at + 1) % points.len();
            target.log_likelihood(black_box(&points[at]), &mut memory)
        });
    });
}

fn likelihoods(c: &mut Criterion) {
    evaluate(c, "box of 8 nodes", &network8_data::likelihood());
    for parameters in [Some(&["Gh", "Gsub", "Gb"][..]), None] {
        if let Some(target) = monitor(parameters) {
            evaluate(c, "X-ray monitor", &target);
        }
    }
}

fn in_memory(_: &mut Criterion) {
    let target = network8_data::likelihood();
    let key = StreamKey::new(1, "bench", "nuts");
    let began = Instant::now();
    let chains: Vec<_> = (0..4)
        .map(|chain| nuts::sample(&target, &NutsSettings::default(), &key, chain, Some(&network8_data::TRUTH)).unwrap())
        .collect();
    let seconds = began.elapsed().as_secs_f64();
    let chains = Chains { names: target.names().to_vec(), chains };
    let judged = judge(&chains, target.priors(), &ConvergenceLimits::default());
    let least = judged.parameters.iter().filter_map(|p| p.ess_bulk).fold(f64::INFINITY, f64::min);
    let gradients = chains.work().gradients;
    println!(
        "box of 8 nodes, NUTS, 4 x (500 + 1000) on one thread: {seconds:.2} s, {gradients} gradients, least bulk ESS {least:.0}, \
         {:.0} effective draws a second",
        least / seconds
    );
}

/// Seconds of a command, process start counted, and its output.
fn timed(command: &mut Command) -> (f64, String) {
    let began = Instant::now();
    let output = command.output().unwrap();
    let seconds = began.elapsed().as_secs_f64();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (seconds, String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The whole program on a study folder with an empty cache: seconds, and least bulk effective sample size.
fn program(sampler: &str, warmup: u64, draws: u64, repeat: u64) -> (f64, f64) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("box-{sampler}-{draws}-{repeat}"));
    let _ = std::fs::remove_dir_all(&folder);
    box_study::write(&folder, sampler, 4, warmup, draws).unwrap();
    // `just bench` builds it first.
    let program = &Path::new(env!("CARGO_TARGET_TMPDIR")).join("../release/bmv");
    let cache = folder.join("cache");
    let (seconds, _) = timed(Command::new(program).args(["run", "--threads", "2", "--cache"]).arg(&cache).arg(&folder));
    let show = ["show", "--json", "--cache"];
    let (_, shown) = timed(Command::new(program).args(show).arg(&cache).arg(folder.join("pass-1.json")).arg("tuned"));
    let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
    let least = least_ess(&shown).unwrap();
    let _ = std::fs::remove_dir_all(&folder);
    (seconds, least)
}

/// The least `ess_bulk` anywhere in a result.
fn least_ess(value: &serde_json::Value) -> Option<f64> {
    let smaller = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
    match value {
        serde_json::Value::Object(map) => {
            map.iter().fold(map.get("ess_bulk").and_then(|ess| ess.as_f64()), |least, (_, inner)| {
                smaller(least, least_ess(inner))
            })
        }
        serde_json::Value::Array(list) => list.iter().fold(None, |least, inner| smaller(least, least_ess(inner))),
        _ => None,
    }
}

fn whole_program(_: &mut Criterion) {
    for (sampler, warmup, draws) in
        [("nuts", 0, 1000), ("nuts", 0, 10_000), ("adaptive-metropolis", 0, 50_000), ("smc", 0, 4000)]
    {
        let mut runs: Vec<(f64, f64)> = (0..5).map(|repeat| program(sampler, warmup, draws, repeat)).collect();
        runs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (seconds, least) = runs[2];
        println!(
            "box of 8 nodes, bmv run, {sampler}, 4 x {draws}: median of 5 runs {seconds:.2} s, least bulk ESS {least:.0}, \
             {:.0} effective draws a second",
            least / seconds
        );
    }
    let Some(peers) = std::env::var_os("BMV_PEERS") else { return };
    let python = std::env::var_os("BMV_PYTHON").unwrap_or_else(|| "python3".into());
    for peer in ["am", "emcee", "nuts"] {
        let mut command = Command::new(&python);
        command.current_dir(&peers).env("OMP_NUM_THREADS", "2").args(["c_calibrate.py", peer]);
        let (seconds, line) = timed(&mut command);
        let result: serde_json::Value = serde_json::from_str(line.trim()).unwrap();
        let least = result["ess_bulk_min"].as_f64().unwrap();
        println!("{}: {seconds:.2} s, least bulk ESS {least:.0}, {:.0} a second", result["peer"], least / seconds);
        if let Some(compiled) = result["warmup_plus_compile_s"].as_f64() {
            let sampling = result["wall_s"].as_f64().unwrap() - compiled;
            println!("    without warm-up and compilation: {sampling:.2} s, {:.0} a second", least / sampling);
        }
    }
}

criterion_group!(benches, likelihoods, in_memory, whole_program);
criterion_main!(benches);
