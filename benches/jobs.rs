//! Speed of propagation from settings to result: blocks on two threads, in memory, summaries included.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use bmv::job::propagate::{Propagate, Sampling, Spec};
use bmv::job::{Next, NoParts, Runnable};
use bmv::study::Pass;
use criterion::{Criterion, criterion_group, criterion_main};
use rayon::prelude::*;

/// A pass of this repository, loaded.
fn load(pass: &str) -> Pass {
    match bmv::job::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(pass)) {
        Ok(pass) => pass,
        Err(_) => panic!("{pass} does not load"),
    }
}

/// The pass's first propagation with so many Monte Carlo samples of one case.
fn propagation(pass: &Pass, samples: u64) -> Propagate {
    let spec = pass.jobs.iter().find_map(|job| job.spec.get::<bmv::job::propagate::Spec>().cloned());
    let spec = Spec { samples, sampling: Sampling::MonteCarlo, sweep: None, ..spec.unwrap() };
    Propagate::new(spec, Arc::new(pass.model.clone()), pass.priors.clone(), pass.seed, "bench").unwrap()
}

/// The whole job on the threads of a pool, as an engine without a disk would run it.
fn run(job: &Propagate, pool: &rayon::ThreadPool) -> serde_json::Value {
    let mut next = job.begin().unwrap();
    loop {
        match next {
            Next::Done(result) => return result.json,
            Next::Stage(stage) => {
                let blocks = (0..stage.inputs.len()).into_par_iter();
                let block = |index| job.block(&stage, index, &NoParts).unwrap();
                let outputs: Vec<Vec<u8>> = pool.install(|| blocks.map(block).collect());
                next = job.reduce(&stage, outputs).unwrap();
            }
        }
    }
}

fn propagate(c: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let mut group = c.benchmark_group("propagate");
    group.sample_size(10);
    for (name, pass, samples) in [
        ("radiator network, 10^6 (target 0.2 s)", "studies/radiator/pass-1.json", 1_000_000),
        ("algebraic heat flux, 10^6", "tests/verification/flux/pass-1.json", 1_000_000),
        ("solar monitor, 10^5, 3 quantities", "tests/verification/sxm/pass-1.json", 100_000),
    ] {
        let pass = load(pass);
        let job = propagation(&pass, samples);
        group.bench_function(name, |bench| bench.iter(|| black_box(run(&job, &pool))));
    }
    let pass = load("studies/radiator/pass-1.json");
    let job = propagation(&pass, 1_000_000);
    let Ok(Next::Stage(stage)) = job.begin() else { panic!("blocks") };
    let block = |index| job.block(&stage, index, &NoParts).unwrap();
    let outputs: Vec<Vec<u8>> = (0..stage.inputs.len()).map(block).collect();
    group.bench_function("radiator network, one block of 8192", |bench| {
        bench.iter(|| black_box(block(0)));
    });
    group.bench_function("radiator network, summary of 10^6", |bench| {
        bench.iter(|| black_box(job.reduce(&stage, outputs.clone()).unwrap()));
    });
    group.finish();
}

criterion_group!(benches, propagate);
criterion_main!(benches);
