//! Speed of screening: the signatures of every candidate.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use bmv::diagnosis::Problem;
use bmv::diagnosis::signature::{for_each_direction, linearise};
use bmv::document::Diagnostics;
use bmv::effect::{Catalogue, candidates};
use bmv::inference::likelihood::Likelihood;
use bmv::study::resolve::adopt::sensor_places;
use criterion::{Criterion, criterion_group, criterion_main};

fn problem(path: &Path) -> Option<Problem> {
    let pass = bmv::study::load(path).ok()?;
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
        candidates,
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
    let mut count = 0;
    let unseen = for_each_direction(&problem, &likelihood, &unknowns, &mut |_| count += 1).unwrap();
    eprintln!("{} candidates: {count} directions, {} unseen", problem.candidates.len(), unseen.len());
    let mut group = c.benchmark_group("campaign");
    group.sample_size(10);
    group.bench_function("linearise", |b| b.iter(|| linearise(black_box(&likelihood), &unknowns)));
    group.bench_function("directions", |b| {
        b.iter(|| for_each_direction(black_box(&problem), &likelihood, &unknowns, &mut |one| drop(black_box(one))));
    });
    group.finish();
}

criterion_group!(benches, campaign);
criterion_main!(benches);
