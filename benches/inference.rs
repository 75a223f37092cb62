//! Speed of inference: likelihood and gradient of the electronics box of 8 nodes and of the X-ray monitor (43 steady
//! phases each), and effective draws a second of the box.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use bmv::inference::chains::Chains;
use bmv::inference::convergence::{ConvergenceLimits, judge};
use bmv::inference::likelihood::{Definition, Likelihood};
use bmv::inference::nuts::{self, NutsSettings};
use bmv::inference::target::Target;
use bmv::random::StreamKey;
use bmv::study::JobSpec;
use criterion::{Criterion, criterion_group, criterion_main};

#[path = "../tests/verification/build.rs"]
#[allow(dead_code)]
mod build;
#[path = "../tests/verification/network8_data.rs"]
#[allow(dead_code)]
mod network8_data;

/// The likelihood of a pass's first calibration, or of all its parameters and data.
fn of_pass(path: &Path) -> Option<Likelihood> {
    let pass = bmv::study::load(path).ok()?;
    let spec = pass.jobs.iter().find_map(|job| match &job.spec {
        JobSpec::Calibrate(spec) => Some(spec.clone()),
        _ => None,
    });
    let free = (0..pass.priors.len()).filter(|&i| !pass.priors[i].is_fixed()).collect();
    let parameters = spec.map_or(free, |spec| spec.parameters);
    let measurements: Vec<_> = pass.measurements.iter().collect();
    let (model, priors) = (&pass.model, pass.priors.as_slice());
    let definition =
        Definition { model, priors, parameters: &parameters, measurements: &measurements, input_errors: &[] };
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
    for pass in ["studies/sxm/pass-2.json", "studies/sxm/pass-3.json"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(pass);
        if let Some(target) = path.exists().then(|| of_pass(&path)).flatten() {
            evaluate(c, pass, &target);
        }
    }
}

fn effective_draws(_: &mut Criterion) {
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

criterion_group!(benches, likelihoods, effective_draws);
criterion_main!(benches);
