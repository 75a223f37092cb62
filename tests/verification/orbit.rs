//! The orbit benchmarks: an electronics box of 8 nodes and a panel of 200 nodes under a sun that rises and sets.
//!
//! Reference end states by Radau IIA (SciPy 1.x) at relative tolerance 1e-10, broken at every kink of the sun.

use bmv::expression::ExprId;
use bmv::thermal::{InitialState, InputTable, Model, Network, Transient, TransientOptions, TransientRequest};

use super::build::Build;

pub const PERIOD_S: f64 = 5400.0;

/// `1361 max(0, cos(2 pi t / P))`.
pub fn sun(b: &mut Build) -> ExprId {
    let time = b.time();
    let phase = b.scale(2.0 * std::f64::consts::PI / PERIOD_S, time);
    let cosine = b.cos(phase);
    let lit = b.max0(cosine);
    b.scale(1361.0, lit)
}

/// Parameters: G_tim, eps_rad, eps_mli, alpha.
pub fn network8() -> Model {
    let mut b = Build::default();
    let g_tim = b.parameter("G_tim", 4.0);
    let eps_rad = b.parameter("eps_rad", 0.85);
    let eps_mli = b.parameter("eps_mli", 0.03);
    let alpha = b.parameter("alpha", 0.15);
    let capacities = [900.0, 1200.0, 1500.0, 400.0, 400.0, 400.0, 150.0, 150.0];
    for (i, capacity) in capacities.into_iter().enumerate() {
        b.diffusion(&format!("n{i}"), capacity);
    }
    let base = b.n(290.0);
    let base = b.boundary("base", base);
    let space = b.n(4.0);
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
        let sun = sun(&mut b);
        let absorbed = b.mul(alpha, sun);
        let absorbed = b.scale(0.06, absorbed);
        b.load(&format!("sun {node}"), node, absorbed);
    }
    for node in [6, 7] {
        let area = b.scale(0.40, eps_mli);
        b.radiation(&format!("mli {node}"), [node, space], area);
    }
    for (node, watt) in [(0, 10.0), (1, 6.0), (2, 25.0)] {
        let watt = b.n(watt);
        b.load(&format!("q{node}"), node, watt);
    }
    for node in 0..8 {
        b.temperature(&format!("T{node}"), node);
    }
    b.model
}

pub fn panel200() -> Model {
    let (nx, ny) = (10, 20);
    let mut b = Build::default();
    for k in 0..200 {
        b.diffusion(&format!("n{k}"), 20.0 + 5.0 * (k % 4) as f64);
    }
    let base = b.n(290.0);
    let base = b.boundary("base", base);
    let space = b.n(4.0);
    let space = b.boundary("space", space);
    let index = |i: usize, j: usize| i * ny + j;
    let along = b.n(0.4);
    let edge = b.n(0.05);
    let sun = sun(&mut b);
    let absorbed = b.scale(0.2 * 0.01, sun);
    for i in 0..nx {
        for j in 0..ny {
            let own = index(i, j);
            if i + 1 < nx {
                b.conductor(&format!("x{own}"), [own, index(i + 1, j)], along);
            }
            if j + 1 < ny {
                b.conductor(&format!("y{own}"), [own, index(i, j + 1)], along);
            }
            let area = b.n(0.85 * 0.01 * (1.0 + 0.2 * (j % 3) as f64));
            b.radiation(&format!("r{own}"), [own, space], area);
            if i == 0 {
                b.conductor(&format!("e{own}"), [own, base], edge);
            }
            b.load(&format!("s{own}"), own, absorbed);
        }
    }
    let cross = b.n(1e-3);
    // The reference builds its matrix by assignment: a pair that occurs twice counts once.
    let mut pairs = std::collections::BTreeSet::new();
    for i in (0..nx).step_by(3) {
        for j in 0..ny {
            let (p, q) = (index(i, j), index(nx - 1 - i, ny - 1 - j));
            if p != q && pairs.insert((p.min(q), p.max(q))) {
                b.radiation(&format!("cross{p}"), [p, q], cross);
            }
        }
    }
    let watt = b.n(4.0);
    for node in [33, 34, 53, 54, 133, 134, 153, 154] {
        b.load(&format!("h{node}"), node, watt);
    }
    b.model
}

pub fn orbits(network: &Network, options: TransientOptions, outputs_s: &[f64]) -> Transient {
    let start = vec![290.0; network.nodes()];
    let inputs = InputTable::default();
    let request = TransientRequest {
        options,
        ..TransientRequest::new(network.nominal_parameters(), &inputs, InitialState::Temperatures(&start), outputs_s)
    };
    network.solve_transient(&request).unwrap()
}

pub fn every_minute() -> Vec<f64> {
    (0..=900).map(|i| 60.0 * f64::from(i)).collect()
}

pub fn tight() -> TransientOptions {
    TransientOptions {
        relative_tolerance: 1e-10,
        absolute_tolerance_k: 1e-8,
        newton_share: 1e-3,
        ..TransientOptions::default()
    }
}

#[test]
fn box_of_8_nodes_ends_at_the_reference_and_outputs_are_within_1_5_mk() {
    let network = Network::compile(&network8(), &[]).unwrap();
    let outputs = every_minute();
    let reference = orbits(&network, tight(), &outputs);
    let golden = [293.0041487, 290.8184305, 289.2778931, 283.5083226, 273.9727839];
    for (value, golden) in reference.end.iter().zip(golden) {
        assert!((value - golden).abs() < 1e-6, "{value} {golden}");
    }
    let least = reference.end[..8].iter().copied().fold(f64::INFINITY, f64::min);
    assert!((least - 262.2871615).abs() < 1e-6, "{least}");
    let result = orbits(&network, TransientOptions::default(), &outputs);
    let worst = result.temperatures.iter().zip(&reference.temperatures).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1.5e-3, "{worst} {:?}", result.stats);
    // Work is a result too: more of it without more accuracy is a fault.
    insta::assert_snapshot!(format!("{:?}", result.stats), @"TransientStats { steps: 282, rejected: 49, unsolved: 0, jacobians: 283, factorisations: 331, solves: 2169, residual_evaluations: 2190, events: 0 }");
}

#[test]
fn panel_of_200_nodes_ends_at_the_reference() {
    let network = Network::compile(&panel200(), &[]).unwrap();
    let outputs = [10.0 * PERIOD_S];
    let result = orbits(&network, TransientOptions::default(), &outputs);
    let golden = [250.5813376, 249.4819071, 248.4530937, 248.6763546, 248.8474821];
    for (value, golden) in result.end.iter().zip(golden) {
        assert!((value - golden).abs() < 1.5e-3, "{value} {golden}");
    }
    let most = result.end[..200].iter().copied().fold(0.0, f64::max);
    assert!((most - 257.9759954).abs() < 1.5e-3, "{most}");
    insta::assert_snapshot!(format!("{:?}", result.stats), @"TransientStats { steps: 508, rejected: 50, unsolved: 0, jacobians: 53, factorisations: 163, solves: 4774, residual_evaluations: 4795, events: 0 }");
}

#[test]
fn the_error_follows_the_tolerance_over_four_decades() {
    let network = Network::compile(&network8(), &[]).unwrap();
    let outputs = every_minute();
    let reference = orbits(&network, tight(), &outputs);
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let options = TransientOptions {
            absolute_tolerance_k: tolerance,
            relative_tolerance: 1e-2 * tolerance,
            ..TransientOptions::default()
        };
        let result = orbits(&network, options, &outputs);
        let worst =
            result.temperatures.iter().zip(&reference.temperatures).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // 60 K orbit swings, some hundred steps: the global error is some ten local ones (measured 18 to 48).
        assert!(worst < 80.0 * tolerance && worst > 4.0 * tolerance, "{tolerance}: {worst}");
    }
}
