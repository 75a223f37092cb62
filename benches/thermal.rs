//! Speed of the network's solvers against their targets (in the names).
#![allow(missing_docs, clippy::unwrap_used)]

#[allow(dead_code)]
#[path = "../tests/verification/build.rs"]
mod build;
#[allow(dead_code)]
#[path = "../tests/verification/orbit.rs"]
mod orbit;

use std::hint::black_box;

use bmv::thermal::{InitialState, InputTable, Model, Network, Start, TransientOptions, TransientRequest};
use build::Build;
use criterion::{Criterion, criterion_group, criterion_main};

/// Splitmix64 uniforms: a reproducible network needs no more.
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A panel of `side x side` nodes: 6 conductors and 4 radiations a node, all to near neighbours, and space.
fn mesh(side: usize) -> Model {
    let mut b = Build::default();
    let mut random = Uniform(1);
    for k in 0..side * side {
        b.diffusion(&format!("n{k}"), 20.0 + 10.0 * random.next());
    }
    let base = b.n(290.0);
    let base = b.boundary("base", base);
    let space = b.n(4.0);
    let space = b.boundary("space", space);
    let sun = orbit::sun(&mut b);
    let scale = b.parameter("scale", 1.0);
    let at = |i: usize, j: usize| i * side + j;
    for i in 0..side {
        for j in 0..side {
            let own = at(i, j);
            for (di, dj) in [(0, 1), (1, 0), (1, 1)] {
                if i + di < side && j + dj < side {
                    let value = b.n(0.1 + random.next());
                    let value = b.mul(scale, value);
                    b.conductor(&format!("c{own}{di}{dj}"), [own, at(i + di, j + dj)], value);
                }
            }
            let area = b.n(0.008 * (1.0 + random.next()));
            b.radiation(&format!("s{own}"), [own, space], area);
            for (di, dj) in [(0, 2), (2, 0)] {
                if random.next() < 0.75 && i + di < side && j + dj < side {
                    let area = b.n(0.001 * random.next());
                    b.radiation(&format!("r{own}{di}{dj}"), [own, at(i + di, j + dj)], area);
                }
            }
            if i == 0 {
                let edge = b.n(0.1);
                b.conductor(&format!("e{own}"), [own, base], edge);
            }
            let absorbed = b.scale(0.2 * 0.01, sun);
            b.load(&format!("q{own}"), own, absorbed);
            let watt = b.n(3.0 * random.next());
            b.load(&format!("h{own}"), own, watt);
        }
    }
    b.temperature("corner", 0);
    b.model
}

fn steady(c: &mut Criterion) {
    let network = Network::compile(&build::sxm(), &[]).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let nominal = ws.temperatures().to_vec();
    let mut parameters = network.nominal_parameters().to_vec();
    let mut random = Uniform(3);
    c.bench_function("solar monitor, warm steady solve (target 10 us)", |bench| {
        bench.iter(|| {
            for (p, n) in parameters.iter_mut().zip(network.nominal_parameters()) {
                *p = n * (0.95 + 0.1 * random.next());
            }
            network.set_parameters(&mut ws, &parameters);
            network.solve_steady(&mut ws, Start::Temperatures(&nominal)).unwrap();
            black_box(network.quantity(&ws, 0))
        });
    });
    let mut batch = network.batch::<8>();
    c.bench_function("solar monitor, 8 warm steady solves in lanes", |bench| {
        bench.iter(|| {
            for lane in 0..8 {
                for (i, n) in network.nominal_parameters().iter().enumerate() {
                    batch.set_parameter(lane, i, n * (0.95 + 0.1 * random.next()));
                }
            }
            network.solve_steady_batch(&mut batch, Start::Temperatures(&nominal));
            black_box(batch.quantity(&network, 0, 0))
        });
    });

    let network = Network::compile(&build::radiator(), &[]).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let nominal = ws.temperatures().to_vec();
    let mut batch = network.batch::<16>();
    let mut group = c.benchmark_group("radiator");
    group.sample_size(10);
    group.bench_function("10^6 samples in lanes of 16 (target 0.3 s)", |bench| {
        bench.iter(|| {
            let mut total = 0.0;
            for _ in 0..62_500 {
                for lane in 0..16 {
                    for (i, n) in network.nominal_parameters().iter().enumerate() {
                        batch.set_parameter(lane, i, n * (0.95 + 0.1 * random.next()));
                    }
                }
                network.solve_steady_batch(&mut batch, Start::Temperatures(&nominal));
                for lane in 0..16 {
                    total += batch.quantity(&network, lane, 0);
                }
            }
            black_box(total)
        });
    });
    group.finish();
}

fn transient(c: &mut Criterion) {
    let network = Network::compile(&orbit::network8(), &[]).unwrap();
    let outputs = orbit::every_minute();
    c.bench_function("8 nodes, 10 orbits (target 5 ms)", |bench| {
        bench.iter(|| black_box(orbit::orbits(&network, TransientOptions::default(), &outputs)));
    });
    let network = Network::compile(&orbit::panel200(), &[]).unwrap();
    let mut group = c.benchmark_group("panel");
    group.sample_size(10);
    group.bench_function("200 nodes, 10 orbits (target 0.3 s)", |bench| {
        bench.iter(|| black_box(orbit::orbits(&network, TransientOptions::default(), &outputs)));
    });
    group.finish();
}

fn large(c: &mut Criterion) {
    let mut group = c.benchmark_group("10,000 nodes");
    group.sample_size(10);
    let model = mesh(100);
    group.bench_function("compile", |bench| bench.iter(|| black_box(Network::compile(&model, &[]).unwrap().nodes())));
    let network = Network::compile(&model, &[]).unwrap();
    let mut ws = network.workspace();
    group.bench_function("steady from cold (target 1 s)", |bench| {
        bench.iter(|| black_box(network.solve_steady(&mut ws, Start::Default).unwrap()));
    });
    let start = vec![290.0; network.nodes()];
    let inputs = InputTable::default();
    let outputs = [orbit::PERIOD_S];
    let request =
        TransientRequest::new(network.nominal_parameters(), &inputs, InitialState::Temperatures(&start), &outputs);
    group.bench_function("one orbit (target 30 s)", |bench| {
        bench.iter(|| black_box(network.solve_transient(&request).unwrap().stats));
    });
    group.finish();
}

criterion_group!(benches, steady, transient, large);
criterion_main!(benches);
