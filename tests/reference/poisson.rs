//! A network of 961 unknown temperatures against published solutions (`poisson/README.md`), and its derivatives.
//!
//! Bilinear elements on a square mesh are a network: an element of conductivity `a` joins its neighbouring corners by
//! `a / 6` and its opposite ones by `a / 3`.

use std::time::Instant;

use bmv::expression::Symbol;
use bmv::thermal::{Network, Start};
use serde::Deserialize;

use crate::verification::build::Build;

/// Elements a side, squares of one conductivity a side, points of readings a side.
const ELEMENTS: usize = 32;
const SQUARES: usize = 8;
const POINTS: usize = 13;

#[derive(Deserialize)]
struct Case {
    conductivities: Vec<f64>,
    readings: Vec<f64>,
}

fn cases() -> Vec<Case> {
    serde_json::from_str(include_str!("poisson/cases.json")).expect("the cases")
}

/// The network; its parameters are the conductivities, its quantities the readings.
fn network() -> Network {
    let mut b = Build::default();
    let conductivities: Vec<_> = (0..SQUARES * SQUARES).map(|k| b.parameter(&format!("a{k}"), 1.0)).collect();
    let inner = ELEMENTS - 1;
    for k in 0..inner * inner {
        b.arithmetic(&format!("n{k}"));
    }
    let cold = b.n(0.0);
    let rim = b.boundary("rim", cold);
    let node = |x: usize, y: usize| {
        let is_inside = (1..ELEMENTS).contains(&x) && (1..ELEMENTS).contains(&y);
        if is_inside { (y - 1) * inner + x - 1 } else { rim }
    };
    for y in 0..ELEMENTS {
        for x in 0..ELEMENTS {
            let conductivity = conductivities[y / (ELEMENTS / SQUARES) * SQUARES + x / (ELEMENTS / SQUARES)];
            let corners = [node(x, y), node(x + 1, y), node(x, y + 1), node(x + 1, y + 1)];
            for (one, other, share) in [(0, 1, 6.0), (2, 3, 6.0), (0, 2, 6.0), (1, 3, 6.0), (0, 3, 3.0), (1, 2, 3.0)] {
                let between = [corners[one], corners[other]];
                if between[0] != between[1] {
                    let conductance = b.scale(1.0 / share, conductivity);
                    b.conductor(&format!("c{x}-{y}-{one}{other}"), between, conductance);
                }
            }
        }
    }
    for k in 0..inner * inner {
        let power = b.n(10.0 / (ELEMENTS * ELEMENTS) as f64);
        b.load(&format!("q{k}"), k, power);
    }
    for point in 0..POINTS * POINTS {
        let place = |k: usize| (k + 1) as f64 / (POINTS + 1) as f64 * ELEMENTS as f64;
        let (x, y) = (place(point / POINTS), place(point % POINTS));
        let mut reading = b.n(0.0);
        for (right, above) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = |at: f64, side: usize| if side == 1 { at.fract() } else { 1.0 - at.fract() };
            let corner = node(x as usize + right, y as usize + above);
            let temperature = b.t(corner);
            let part = b.scale(weight(x, right) * weight(y, above), temperature);
            reading = b.add(reading, part);
        }
        b.quantity(&format!("z{point}"), reading);
    }
    let symbols: Vec<Symbol> = (0..(SQUARES * SQUARES) as u32).map(Symbol::Parameter).collect();
    Network::compile(&b.model, &symbols).expect("a network")
}

#[test]
#[ignore = "thorough"]
fn ten_published_solutions_come_out_alone_and_side_by_side() {
    let (network, cases) = (network(), cases());
    let start = vec![0.5; network.nodes()];
    let mut batch = network.batch::<8>();
    for (lane, case) in cases.iter().take(8).enumerate() {
        batch.set_parameters(&network, lane, &case.conductivities);
    }
    network.solve_steady_batch(&mut batch, Start::Temperatures(&start));
    let mut workspace = network.workspace();
    for (number, case) in cases.iter().enumerate() {
        network.set_parameters(&mut workspace, &case.conductivities);
        network.solve_steady(&mut workspace, Start::Temperatures(&start)).expect("a solution");
        for (point, published) in case.readings.iter().enumerate() {
            let found = network.quantity(&workspace, point);
            // The published ones have errors of up to 3e-12 of their own.
            assert!((found - published).abs() < 4e-12, "case {number}, point {point}: {found} {published}");
            if number < 8 {
                assert_eq!(batch.quantity(&network, number, point).to_bits(), found.to_bits());
            }
        }
    }
}

#[test]
#[ignore = "thorough"]
fn derivatives_of_the_network_are_those_of_a_homogeneous_function() {
    let (network, case) = (network(), cases().swap_remove(3));
    let (readings, parameters) = (case.readings.len(), case.conductivities.len());
    let mut workspace = network.workspace();
    network.set_parameters(&mut workspace, &case.conductivities);
    network.solve_steady(&mut workspace, Start::Default).expect("a solution");
    let mut tangent = vec![0.0; readings * parameters];
    network.quantity_tangent(&mut workspace, &mut tangent).expect("derivatives");
    let weights: Vec<f64> = (0..readings).map(|k| libm::sin(k as f64)).collect();
    let mut gradient = vec![0.0; parameters];
    network.quantity_gradient(&mut workspace, &weights, &mut gradient).expect("a gradient");
    for (row, published) in tangent.chunks_exact(parameters).zip(&case.readings) {
        // A solution goes with the inverse of all conductivities together (Euler's theorem).
        let sum: f64 = row.iter().zip(&case.conductivities).map(|(slope, a)| slope * a).sum();
        assert!((sum + published).abs() < 4e-12, "{sum} {published}");
    }
    for (place, slope) in gradient.iter().enumerate() {
        let sum: f64 = (0..readings).map(|row| weights[row] * tangent[row * parameters + place]).sum();
        // Both sum 169 terms below 1.
        assert!((sum - slope).abs() < 1e-11, "{place}: {sum} {slope}");
    }
    // Eight copies side by side have the same gradient to the bit.
    let mut batch = network.batch::<8>();
    let mut slopes = vec![[0.0; 8]; parameters];
    for lane in 0..8 {
        batch.set_parameters(&network, lane, &case.conductivities);
    }
    network.solve_steady_batch(&mut batch, Start::Default);
    let weights: Vec<[f64; 8]> = weights.iter().map(|&weight| [weight; 8]).collect();
    network.quantity_gradient_batch(&mut batch, &weights, &mut slopes);
    for (lanes, slope) in slopes.iter().zip(&gradient) {
        assert!(lanes.iter().all(|lane| lane.to_bits() == slope.to_bits()), "{lanes:?} {slope}");
    }
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "timing: run alone, in release"]
    fn thirty_gradients_a_second() {
        let (network, case) = (network(), cases().swap_remove(3));
        let mut workspace = network.workspace();
        let (weights, mut gradient) = (vec![1.0; case.readings.len()], vec![0.0; case.conductivities.len()]);
        let mut conductivities = case.conductivities;
        let clock = Instant::now();
        for repeat in 0..100 {
            conductivities[repeat % 64] *= 1.01;
            network.set_parameters(&mut workspace, &conductivities);
            network.solve_steady(&mut workspace, Start::Current).expect("a solution");
            network.quantity_gradient(&mut workspace, &weights, &mut gradient).expect("a gradient");
        }
        let rate = 100.0 / clock.elapsed().as_secs_f64();
        println!("{rate:.0} gradients a second");
        assert!(rate > 30.0, "{rate}");
    }
}
