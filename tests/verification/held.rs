//! Balances with some temperatures held, and transients in which nodes start in balance with others.

use bmv::expression::Symbol;
use bmv::thermal::{InitialState, InputTable, Network, TransientRequest};

use super::build::Build;

const SIGMA: f64 = 5.670374419e-8;

/// A cold boundary, a plate with a load, a foil without storage, a lid that radiates to the boundary, an island of two
/// nodes; parameters: the conductance from plate to lid, the plate's load.
fn network(differentiate: &[Symbol]) -> Network {
    let mut b = Build::default();
    let cold = b.n(200.0);
    b.boundary("cold", cold);
    b.diffusion("plate", 900.0);
    b.arithmetic("foil");
    b.diffusion("lid", 50.0);
    b.diffusion("buoy", 10.0);
    b.diffusion("tail", 20.0);
    let (g, q) = (b.parameter("G", 0.5), b.parameter("Q", 6.0));
    let (one, area) = (b.n(1.0), b.n(0.01));
    b.conductor("arm", [1, 3], g);
    b.conductor("stud", [3, 2], one);
    b.conductor("edge", [2, 0], one);
    b.radiation("view", [3, 0], area);
    b.conductor("rope", [4, 5], one);
    b.load("heater", 1, q);
    b.temperature("lid", 3);
    Network::compile(&b.model, differentiate).unwrap()
}

/// Plate, buoy and tail held.
const HELD: [bool; 5] = [false, true, false, false, true];

/// The lid's temperature with the plate at 300 K: G (300 - T) = (T - 200) / 2 + sigma 0.01 (T^4 - 200^4), by bisection.
fn lid_k(conductance: f64) -> f64 {
    let surplus = |t: f64| {
        conductance * (300.0 - t) - 0.5 * (t - 200.0) - SIGMA * 0.01 * (t * t * t * t - 200.0 * 200.0 * 200.0 * 200.0)
    };
    let (mut low, mut high) = (200.0, 300.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if surplus(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

#[test]
fn the_others_balance_with_what_is_held() {
    let network = network(&[Symbol::Parameter(0), Symbol::Parameter(1)]);
    let mut workspace = network.workspace();
    let given = [0.0, 300.0, 250.0, 250.0, 280.0, 400.0];
    network.solve_held(&mut workspace, &given, &HELD).unwrap();
    let found = workspace.temperatures().to_vec();
    let lid = lid_k(0.5);
    assert_eq!((found[0], found[1], found[4]), (200.0, 300.0, 280.0), "held as given, the boundary its own");
    assert!((found[3] - lid).abs() < 1e-8 && (found[2] - 0.5 * (lid + 200.0)).abs() < 1e-8, "{found:?} {lid}");
    assert!((found[5] - 280.0).abs() < 1e-9, "the tail goes with the buoy, no boundary is needed");
    // Derivatives are with the held temperatures constant.
    let mut slopes = [0.0; 2 * 6];
    network.temperature_tangent(&mut workspace, &mut slopes).unwrap();
    let expected = (lid_k(0.501) - lid_k(0.499)) / 0.002;
    assert!((slopes[2 * 3] - expected).abs() < 1e-4 * expected, "{} {expected}", slopes[6]);
    // A held temperature stands under a diagonal of 1e30 W/K.
    assert!(slopes[2].abs() < 1e-20 && slopes[3 * 2 + 1].abs() < 1e-20, "what heats a held node moves nothing");
}

#[test]
fn a_guess_far_away_leads_to_the_same_balance() {
    let network = network(&[]);
    let mut workspace = network.workspace();
    for guess in [1.0, 5000.0] {
        let given = [0.0, 300.0, guess, guess, 280.0, guess];
        network.solve_held(&mut workspace, &given, &HELD).unwrap();
        assert!((workspace.temperatures()[3] - lid_k(0.5)).abs() < 1e-8, "from {guess} K");
    }
    // The next steady solve holds nothing.
    assert!(matches!(
        network.solve_steady(&mut workspace, bmv::thermal::Start::Default),
        Err(bmv::thermal::SteadyError::Isolated { .. })
    ));
}

#[test]
fn a_transient_starts_in_the_balance_and_is_differentiated_through_it() {
    let given = [0.0, 300.0, 250.0, 250.0, 280.0, 400.0];
    let inputs = InputTable::default();
    let outputs = [0.0, 5.0, 100.0];
    let run = |network: &Network, conductance: f64, sensitivities: bool| {
        let initial = InitialState::Temperatures(&given);
        let parameters = [conductance, 6.0];
        let balanced = [2, 3, 5];
        let request = TransientRequest {
            sensitivities,
            balanced: &balanced,
            ..TransientRequest::new(&parameters, &inputs, initial, &outputs)
        };
        network.solve_transient(&request).unwrap()
    };
    let network_of = network(&[Symbol::Parameter(0)]);
    let result = run(&network_of, 0.5, true);
    assert!((result.quantities[0] - lid_k(0.5)).abs() < 1e-8);
    let (low, high) = (run(&network_of, 0.4995, false), run(&network_of, 0.5005, false));
    for output in 0..3 {
        let expected = (high.quantities[output] - low.quantities[output]) / 0.001;
        let found = result.quantity_tangent[output];
        assert!((found - expected).abs() < 2e-3 * expected.abs(), "{output}: {found} {expected}");
    }
    // Beginning at the given temperatures alone the lid's derivative would be 0 at once.
    assert!(result.quantity_tangent[0] > 10.0, "{}", result.quantity_tangent[0]);
}
