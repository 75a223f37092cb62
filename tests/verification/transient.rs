//! Transients against closed forms, conservation and the scheme's order.

use bmv::expression::{Table, Unary};
use bmv::thermal::{
    InitialState, InputColumn, InputTable, Model, Network, QuantityValue, Start, Transient, TransientError,
    TransientOptions, TransientRequest,
};

use super::build::Build;
use super::orbit::{PERIOD_S, network8, panel200, tight};

const SIGMA: f64 = 5.670374419e-8;

fn run(network: &Network, start: &[f64], outputs: &[f64], options: TransientOptions) -> Transient {
    let inputs = InputTable::default();
    let request = TransientRequest {
        options,
        ..TransientRequest::new(network.nominal_parameters(), &inputs, InitialState::Temperatures(start), outputs)
    };
    network.solve_transient(&request).unwrap()
}

#[test]
fn radiating_sphere_cools_by_the_inverse_cube_law() {
    // C dT/dt = -sigma A T^4 towards 0 K: T^-3 = T0^-3 + 3 sigma A t / C (separation of variables).
    let mut b = Build::default();
    let sphere = b.diffusion("sphere", 500.0);
    let space = b.n(1e-6);
    let space = b.boundary("space", space);
    let area = b.n(0.1);
    b.radiation("cooling", [sphere, space], area);
    let network = Network::compile(&b.model, &[]).unwrap();
    let outputs: Vec<f64> = (1..=50).map(|i| 400.0 * f64::from(i)).collect();
    let result = run(&network, &[400.0, 0.0], &outputs, TransientOptions::default());
    for (i, t) in outputs.iter().enumerate() {
        let inverse: f64 = 1.0 / (400.0f64 * 400.0 * 400.0) + 3.0 * SIGMA * 0.1 * t / 500.0;
        let exact = 1.0 / libm::cbrt(inverse);
        // Default tolerance: about 1 mK.
        assert!((result.temperatures[2 * i] - exact).abs() < 1.5e-3, "{t}: {} {exact}", result.temperatures[2 * i]);
    }
}

#[test]
fn two_nodes_without_a_boundary_meet_exponentially_and_keep_their_heat() {
    // T1 - T2 falls with rate G (1/C1 + 1/C2), C1 T1 + C2 T2 stays.
    let mut b = Build::default();
    b.diffusion("one", 100.0);
    b.diffusion("two", 50.0);
    let g = b.n(0.8);
    b.conductor("link", [0, 1], g);
    let network = Network::compile(&b.model, &[]).unwrap();
    assert!(network.isolated_nodes().is_some());
    let outputs: Vec<f64> = (1..=30).map(|i| 10.0 * f64::from(i)).collect();
    let result = run(&network, &[350.0, 250.0], &outputs, TransientOptions::default());
    let mean = (100.0 * 350.0 + 50.0 * 250.0) / 150.0;
    for (i, t) in outputs.iter().enumerate() {
        let gap = 100.0 * libm::exp(-0.8 * (1.0 / 100.0 + 1.0 / 50.0) * t);
        let (one, two) = (result.temperatures[2 * i], result.temperatures[2 * i + 1]);
        assert!((one - two - gap).abs() < 1e-3, "{t}: {one} {two} {gap}");
        // Every stage closes its heat; what is left comes from the iteration's tolerance.
        assert!(((100.0 * one + 50.0 * two) / 150.0 - mean).abs() < 2e-6, "{t}");
    }
}

/// Solution `300 + 20 sin(w t)` in a node with capacity `100 + T / 2`, conductance `0.5 + T / 1000` to a wall at 280 K
/// through an arithmetic node at the middle, made so by a load that is an expression of time.
fn manufactured(with_arithmetic: bool) -> (Model, impl Fn(f64) -> f64) {
    let w = 2.0 * std::f64::consts::PI / 1000.0;
    let mut b = Build::default();
    let own = b.t(0);
    let half = b.scale(0.5, own);
    let fixed = b.n(100.0);
    let capacity = b.add(fixed, half);
    let node = b.diffusion_of("node", capacity);
    let wall_t = b.n(280.0);
    let wall = b.boundary("wall", wall_t);
    let time = b.time();
    let phase = b.scale(w, time);
    let (sine, cosine) = (b.sin(phase), b.cos(phase));
    let swing = b.scale(20.0, sine);
    let mean = b.n(300.0);
    let exact = b.add(mean, swing);
    let conductance_at = |b: &mut Build, t| {
        let share = b.scale(1e-3, t);
        let fixed = b.n(0.5);
        b.add(fixed, share)
    };
    let own = b.t(node);
    let conductance = conductance_at(&mut b, own);
    let conductance_exact = conductance_at(&mut b, exact);
    let half = b.scale(0.5, exact);
    let fixed = b.n(100.0);
    let stored = b.add(fixed, half);
    let rate = b.scale(20.0 * w, cosine);
    let stored = b.mul(stored, rate);
    let gap = b.sub(exact, wall_t);
    if with_arithmetic {
        // Two equal conductances in series through the arithmetic node.
        let middle = b.arithmetic("middle");
        b.conductor("near", [node, middle], conductance);
        b.conductor("far", [middle, wall], conductance);
        let lost = b.mul(conductance_exact, gap);
        let lost = b.scale(0.5, lost);
        let load = b.add(stored, lost);
        b.load("made", node, load);
    } else {
        b.conductor("link", [node, wall], conductance);
        let lost = b.mul(conductance_exact, gap);
        let load = b.add(stored, lost);
        b.load("made", node, load);
    }
    (b.model, move |t: f64| 300.0 + 20.0 * libm::sin(w * t))
}

#[test]
fn manufactured_solution_is_met_and_the_order_is_four() {
    for with_arithmetic in [false, true] {
        let (model, exact) = manufactured(with_arithmetic);
        let network = Network::compile(&model, &[]).unwrap();
        let nodes = network.nodes();
        let end = 800.0;
        let error = |options: TransientOptions| {
            let result = run(&network, &vec![300.0; nodes], &[end], options);
            (result.end[0] - exact(end)).abs().max(if with_arithmetic {
                (result.end[2] - 0.5 * (exact(end) + 280.0)).abs()
            } else {
                0.0
            })
        };
        assert!(error(TransientOptions::default()) < 1e-3);
        let fixed = |steps: f64| TransientOptions {
            fixed_step_s: Some(end / steps),
            newton_share: 1e-8,
            ..TransientOptions::default()
        };
        let errors: Vec<f64> = [16.0, 32.0, 64.0].into_iter().map(|steps| error(fixed(steps))).collect();
        for pair in errors.windows(2) {
            let order = libm::log2(pair[0] / pair[1]);
            assert!((3.7..4.6).contains(&order), "{with_arithmetic}: {errors:?} order {order}");
        }
    }
}

#[test]
fn heat_that_goes_in_is_stored_or_flows_out() {
    // Sum of C (T_end - T_start) = time integral of sources minus heat into the wall, both as means over time.
    let mut b = Build::default();
    let node = b.diffusion("node", 400.0);
    let skin = b.arithmetic("skin");
    let wall = b.n(250.0);
    let wall = b.boundary("wall", wall);
    let g = b.n(2.0);
    b.conductor("inner", [node, skin], g);
    let area = b.n(0.05);
    b.radiation("outer", [skin, wall], area);
    let time = b.time();
    let phase = b.scale(0.01, time);
    let wave = b.sin(phase);
    let swing = b.scale(8.0, wave);
    let mean = b.n(10.0);
    let power = b.add(mean, swing);
    b.load("source", node, power);
    let (ta, tb) = (b.t(node), b.t(skin));
    let gap = b.sub(ta, tb);
    let out = b.mul(g, gap);
    let net = b.sub(power, out);
    b.quantity("net", net);
    b.model.quantities[0].value = QuantityValue::TimeMean(net);
    let network = Network::compile(&b.model, &[]).unwrap();
    let result = run(&network, &[300.0, 300.0, 0.0], &[2000.0], tight());
    let stored = 400.0 * (result.end[0] - result.start[0]);
    let integral = result.over_time[0].unwrap() * 2000.0;
    assert!(stored.abs() > 1.0);
    // Boole's rule on the interpolant over tight steps.
    assert!((stored - integral).abs() < 1e-3, "{stored} {integral}");
}

#[test]
fn thermostat_cycles_with_the_period_of_the_closed_form() {
    // Between thresholds the node relaxes to 270 K (off) or 270 + 20 / 0.5 = 310 K (on) with tau = 300 / 0.5 s.
    let mut b = Build::default();
    let node = b.diffusion("tank", 300.0);
    let twin = b.diffusion("twin", 300.0);
    let wall = b.n(270.0);
    let wall = b.boundary("wall", wall);
    let g = b.n(0.5);
    let (power, on, off) = (b.n(20.0), b.n(290.0), b.n(295.0));
    for (name, node) in [("tank", node), ("twin", twin)] {
        b.conductor(&format!("{name} loss"), [node, wall], g);
        b.thermostat(&format!("{name} heater"), node, power, on, off);
    }
    let network = Network::compile(&b.model, &[]).unwrap();
    let result = run(&network, &[288.0, 288.0, 0.0], &[5000.0], TransientOptions::default());
    let tau = 600.0;
    let falling = tau * libm::log(25.0 / 20.0);
    let rising = tau * libm::log(20.0 / 15.0);
    assert!(result.events.len() > 10);
    for pair in result.events.chunks_exact(2) {
        // Twins switch at one instant.
        assert_eq!(pair[0].time_s, pair[1].time_s);
        assert_eq!(pair[0].on, pair[1].on);
        assert_ne!(pair[0].element, pair[1].element);
    }
    assert!(!result.events[0].on, "on at the start below `on`");
    let times: Vec<(f64, bool)> = result.events.iter().step_by(2).map(|e| (e.time_s, e.on)).collect();
    for pair in times.windows(2) {
        let expected = if pair[1].1 { falling } else { rising };
        assert_ne!(pair[0].1, pair[1].1);
        // 1 mK at slopes of 0.03 K/s.
        assert!((pair[1].0 - pair[0].0 - expected).abs() < 0.05, "{pair:?} {expected}");
    }
    insta::assert_snapshot!(format!("{:?}", result.stats), @"TransientStats { steps: 46, rejected: 0, unsolved: 0, jacobians: 47, factorisations: 78, solves: 572, residual_evaluations: 605, events: 64 }");
}

#[test]
#[ignore = "thorough"]
fn a_thermostat_that_cycles_without_end_is_refused_with_its_band() {
    // 20 W against a loss of 12.5 W heat 300 J/K by 25 mK/s, then 42 mK/s down: a band of 1e-7 K cycles every 6.4 us.
    let network = |band_k: f64| {
        let mut b = Build::default();
        let node = b.diffusion("tank", 300.0);
        let wall = b.n(270.0);
        let wall = b.boundary("wall", wall);
        let g = b.n(0.5);
        let (power, on, off) = (b.n(20.0), b.n(295.0), b.n(295.0 + band_k));
        b.conductor("loss", [node, wall], g);
        b.thermostat("tank heater", node, power, on, off);
        Network::compile(&b.model, &[]).unwrap()
    };
    let inputs = InputTable::default();
    let outputs: Vec<f64> = (1..=600).map(f64::from).collect();
    let request = TransientRequest::new(&[], &inputs, InitialState::Temperatures(&[295.0, 270.0]), &outputs);
    let error = network(1e-7).solve_transient(&request).unwrap_err();
    let TransientError::Cycling { element, switchings, expected, band_k, wider_k, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!((element.as_str(), *switchings), ("tank heater", 10_000), "refused as soon as it is clear");
    // Two switchings a cycle of 1e-7 K / (20 W - 12.5 W) x 300 J/K + 1e-7 K / 12.5 W x 300 J/K = 6.4e-6 s.
    assert!((expected / (2.0 * 600.0 / 6.4e-6) - 1.0).abs() < 0.05, "{expected:e}");
    assert!((band_k / 1e-7 - 1.0).abs() < 1e-3 && *wider_k > 1e-4, "{band_k} {wider_k}");
    let said = error.to_string();
    assert!(said.contains("band of 1.0e-7 K is too narrow: write one of 2e-4 K or more"), "{said}");
    // What it says to write works.
    let result = network(*wider_k).solve_transient(&request).unwrap();
    assert!(result.stats.events > 10_000);
}

#[test]
fn a_solve_under_way_is_left_when_its_thread_is_asked_to_stop() {
    let left = |solve: fn(&Network)| {
        let run = move || {
            let mut b = Build::default();
            let node = b.diffusion("node", 300.0);
            let wall = b.n(270.0);
            let wall = b.boundary("wall", wall);
            let g = b.n(0.5);
            b.conductor("path", [node, wall], g);
            let network = Network::compile(&b.model, &[]).unwrap();
            let flag = bmv::watch::Flag::default();
            bmv::watch::lend(&flag);
            solve(&network);
            flag.stop();
            solve(&network);
        };
        let ended = std::thread::spawn(run).join();
        assert!(ended.is_err_and(|payload| bmv::watch::Stopped::is(payload.as_ref())));
    };
    left(|network| drop(run(network, &[288.0, 0.0], &[5000.0], TransientOptions::default())));
    left(|network| {
        network.solve_steady(&mut network.workspace(), Start::Default).unwrap();
    });
    left(|network| network.solve_steady_batch(&mut network.batch::<4>(), Start::Default));
}

#[test]
fn thermostat_without_hysteresis_is_refused() {
    let mut b = Build::default();
    let node = b.diffusion("tank", 300.0);
    let (power, on, off) = (b.n(20.0), b.n(295.0), b.n(295.0));
    b.thermostat("heater", node, power, on, off);
    let network = Network::compile(&b.model, &[]).unwrap();
    let inputs = InputTable::default();
    let request = TransientRequest::new(&[], &inputs, InitialState::Temperatures(&[290.0]), &[1.0]);
    let error = network.solve_transient(&request).unwrap_err();
    assert_eq!(error, TransientError::NoHysteresis { element: "heater".into(), band_k: 0.0 });
}

#[test]
fn held_inputs_step_exactly_at_their_rows() {
    // A node alone integrates its load: T = T0 + (energy in) / C, exact for every scheme that stops at the steps.
    let mut b = Build::default();
    let node = b.diffusion("node", 10.0);
    let power = b.input("power", 0.0);
    b.load("load", node, power);
    let network = Network::compile(&b.model, &[]).unwrap();
    let inputs = InputTable {
        times_s: vec![0.0, 7.0, 13.0, 40.0],
        columns: vec![InputColumn { input: 0, values: vec![5.0, 100.0, -20.0, 3.0], hold: true }],
        base: vec![0.0],
    };
    let outputs = [3.5, 7.0, 10.0, 13.0, 40.0, 50.0];
    let request = TransientRequest::new(&[], &inputs, InitialState::Temperatures(&[300.0]), &outputs);
    let result = network.solve_transient(&request).unwrap();
    let energies = [17.5, 35.0, 335.0, 635.0, 95.0, 125.0];
    for (value, energy) in result.temperatures.iter().zip(energies) {
        assert!((value - (300.0 + energy / 10.0)).abs() < 1e-8, "{value} {energy}");
    }
}

#[test]
fn a_held_input_that_steps_at_the_kink_of_an_expression_is_not_missed() {
    // A load of 1 W from 100 s on, and a held input that steps from 0 to 5 W at the same instant: at 200 s the node
    // has taken up 100 s x 6 W.
    let mut b = Build::default();
    let node = b.diffusion("node", 10.0);
    let power = b.input("power", 0.0);
    let (time, start) = (b.time(), b.n(100.0));
    let since = b.sub(time, start);
    let on = b.graph().unary(Unary::Step, since);
    let both = b.add(on, power);
    b.load("load", node, both);
    let network = Network::compile(&b.model, &[]).unwrap();
    let inputs = InputTable {
        times_s: vec![0.0, 100.0, 200.0],
        columns: vec![InputColumn { input: 0, values: vec![0.0, 5.0, 5.0], hold: true }],
        base: vec![0.0],
    };
    let outputs = [100.0, 200.0];
    let request = TransientRequest::new(&[], &inputs, InitialState::Temperatures(&[300.0]), &outputs);
    let result = network.solve_transient(&request).unwrap();
    assert!((result.temperatures[0] - 300.0).abs() < 1e-8, "{:?}", result.temperatures);
    assert!((result.temperatures[1] - 360.0).abs() < 1e-8, "{:?}", result.temperatures);
}

#[test]
fn a_discontinuity_within_rounding_of_a_corner_of_an_input_is_passed() {
    // A load of 1 W from the last instant before 5700 s on, where a held input steps from 0 to 5 W.
    let mut b = Build::default();
    let node = b.diffusion("node", 10.0);
    let power = b.input("power", 0.0);
    let (time, start) = (b.time(), b.n(5700.0 * (1.0 - 2.0 * f64::EPSILON)));
    let since = b.sub(time, start);
    let on = b.graph().unary(Unary::Step, since);
    let both = b.add(on, power);
    b.load("load", node, both);
    let network = Network::compile(&b.model, &[]).unwrap();
    let inputs = InputTable {
        times_s: vec![0.0, 5700.0, 5800.0],
        columns: vec![InputColumn { input: 0, values: vec![0.0, 5.0, 5.0], hold: true }],
        base: vec![0.0],
    };
    let request = TransientRequest::new(&[], &inputs, InitialState::Temperatures(&[300.0]), &[5700.0, 5800.0]);
    let result = network.solve_transient(&request).unwrap();
    assert!((result.temperatures[0] - 300.0).abs() < 1e-8, "{:?}", result.temperatures);
    assert!((result.temperatures[1] - 360.0).abs() < 1e-8, "{:?}", result.temperatures);
}

#[test]
fn a_pulse_in_a_table_over_time_is_not_stepped_over() {
    // 100 W for 10 s with ramps of 0.1 s in the middle of a day at rest: 1010 J into 10 J/K.
    let mut b = Build::default();
    let node = b.diffusion("node", 10.0);
    let time = b.time();
    let table = b.graph().table(Table {
        x: vec![0.0, 50_000.0, 50_000.1, 50_010.1, 50_010.2, 90_000.0],
        y: vec![0.0, 0.0, 100.0, 100.0, 0.0, 0.0],
    });
    let pulse = b.graph().interpolate(table, time);
    b.load("pulse", node, pulse);
    let network = Network::compile(&b.model, &[]).unwrap();
    let result = run(&network, &[300.0], &[40_000.0, 86_400.0], TransientOptions::default());
    assert!((result.temperatures[0] - 300.0).abs() < 1e-8, "{:?}", result.temperatures);
    assert!((result.temperatures[1] - 401.0).abs() < 1e-6, "{:?}", result.temperatures);
}

#[test]
fn a_model_without_nodes_has_its_periodic_state() {
    let mut b = Build::default();
    let q = b.input("Q", 3.0);
    let twice = b.scale(2.0, q);
    b.quantity("twice", twice);
    let network = Network::compile(&b.model, &[]).unwrap();
    let inputs = InputTable {
        times_s: vec![0.0, 10.0],
        columns: vec![InputColumn { input: 0, values: vec![1.0, 2.0], hold: false }],
        base: vec![3.0],
    };
    let outputs = [0.0, 5.0, 10.0];
    let request = TransientRequest::new(&[], &inputs, InitialState::Periodic, &outputs);
    let result = network.solve_transient(&request).unwrap();
    assert_eq!(result.quantities, [2.0, 3.0, 4.0]);
}

/// The sun of the orbit as a table of one period with linear columns.
fn table_of_one_orbit() -> InputTable {
    InputTable { times_s: vec![0.0, PERIOD_S], columns: vec![], base: vec![] }
}

#[test]
fn periodic_state_is_that_of_a_long_integration() {
    for (model, orbits, nodes) in [(network8(), 60.0, 8), (panel200(), 12.0, 200)] {
        let network = Network::compile(&model, &[]).unwrap();
        let start = vec![280.0; network.nodes()];
        let long = run(&network, &start, &[orbits * PERIOD_S], TransientOptions::default());
        let inputs = table_of_one_orbit();
        let request = TransientRequest::new(network.nominal_parameters(), &inputs, InitialState::Periodic, &[PERIOD_S]);
        let periodic = network.solve_transient(&request).unwrap();
        for node in 0..nodes {
            let (start, end) = (periodic.start[node], periodic.end[node]);
            assert!((start - end).abs() < 2e-3, "node {node} returns: {start} {end}");
            // Both carry the integrator's error, amplified by the slowest mode.
            assert!((long.end[node] - start).abs() < 1e-2, "node {node}: {} {start}", long.end[node]);
        }
    }
}

#[test]
fn a_transient_settles_in_the_steady_state() {
    let network = Network::compile(&super::build::sxm(), &[]).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let result = run(&network, &[300.0; 11], &[2e5], TransientOptions::default());
    for (a, b) in result.end.iter().zip(ws.temperatures()) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}
