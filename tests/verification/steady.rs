//! Steady solutions against golden and analytic ones.

use bmv::expression::Symbol;
use bmv::thermal::{
    InitialState, InputColumn, InputTable, Network, Start, SteadyError, TransientError, TransientRequest,
};

use super::build::{Build, radiator, sxm};

/// Independent of the engine: the closed form of the radiator.
fn radiator_temperature(p: &[f64]) -> f64 {
    let [q, eps, alpha, q_sun, theta, q_alb, q_ir] = p.try_into().unwrap();
    let absorbed = q / 0.3 + alpha * (q_sun * libm::cos(theta) + q_alb) + eps * q_ir;
    (absorbed / (eps * 5.670374419e-8) + 81.0).sqrt().sqrt()
}

#[test]
fn radiator_has_its_published_temperature_and_slopes() {
    let model = radiator();
    let symbols: Vec<Symbol> = (0..7).map(Symbol::Parameter).collect();
    let network = Network::compile(&model, &symbols).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    // Case study 3.4, nine digits; 1e-6 relative is the acceptance tolerance.
    assert!((ws.temperatures()[0] - 301.978924).abs() < 1e-6);
    assert!((ws.temperatures()[0] - radiator_temperature(network.nominal_parameters())).abs() < 1e-10);
    let mut slopes = [0.0; 7];
    network.quantity_tangent(&mut ws, &mut slopes).unwrap();
    let golden = [0.62785, -85.050, 47.537, 0.0065415, -50.714, 0.037671, 0.16010];
    for (slope, golden) in slopes.iter().zip(golden) {
        // Golden values have five digits.
        assert!((slope / golden - 1.0).abs() < 2e-5, "{slope} {golden}");
    }
    for (i, slope) in slopes.iter().enumerate() {
        let mut p = network.nominal_parameters().to_vec();
        let h = p[i] * 1e-4;
        p[i] += h;
        let up = radiator_temperature(&p);
        p[i] -= 2.0 * h;
        let down = radiator_temperature(&p);
        let difference = (up - down) / (2.0 * h);
        // A central difference with a relative step of 1e-4 is good to about 1e-8.
        assert!((slope / difference - 1.0).abs() < 1e-6, "{i}: {slope} {difference}");
    }
}

#[test]
fn coupon_has_its_published_temperatures() {
    for (watt, shroud, eps, leak, golden) in [
        (20.0, 100.0, 0.85, 0.02, 287.605769),
        (5.0, 250.0, 0.85, 0.02, 275.592874),
        (25.0, 100.0, 0.78, 0.0, 326.792524),
    ] {
        let mut b = Build::default();
        let node = b.diffusion("coupon", 100.0);
        let wall = b.n(shroud);
        let wall = b.boundary("shroud", wall);
        let area = b.n(eps * 0.05);
        b.radiation("to shroud", [node, wall], area);
        let leak = b.n(leak);
        b.conductor("leads", [node, wall], leak);
        let watt = b.n(watt);
        b.load("heater", node, watt);
        let network = Network::compile(&b.model, &[]).unwrap();
        let mut ws = network.workspace();
        network.solve_steady(&mut ws, Start::Default).unwrap();
        // Case study 3.5, printed to 1e-6 K.
        assert!((ws.temperatures()[0] - golden).abs() < 1e-6, "{} {golden}", ws.temperatures()[0]);
    }
}

#[test]
fn solar_monitor_has_its_three_golden_solutions() {
    let model = sxm();
    let network = Network::compile(&model, &[]).unwrap();
    let mut ws = network.workspace();
    // Case study 4.6.
    let golden = [
        (
            303.15,
            2.75,
            [234.4233, 275.4979, 315.9947, 315.5040, 316.7059, 309.2359, 309.4607, 306.8015, 255.8919],
            0.356666,
        ),
        (253.15, 0.0, [257.7426, 257.3354, 257.1997, 257.1990, 264.4125, 257.0929, 257.8350, 255.5157, 252.4292], 0.0),
        (
            323.15,
            2.5,
            [248.6944, 288.8033, 333.0220, 332.6239, 335.0532, 327.6139, 327.5834, 325.8284, 257.5632],
            0.311653,
        ),
    ];
    for (deck, voltage, temperatures, current) in golden {
        network.set_inputs(&mut ws, &[deck, voltage, 1367.0 / (0.897 * 0.897), 3.0]);
        network.solve_steady(&mut ws, Start::Default).unwrap();
        for (node, golden) in temperatures.into_iter().enumerate() {
            assert!((ws.temperatures()[node] - golden).abs() < 1e-3, "{node}: {} {golden}", ws.temperatures()[node]);
        }
        assert!((network.quantity(&ws, 9) - current).abs() < 1e-6);
        let balance = network.heat_balance(&mut ws);
        assert!((balance.source_w - balance.boundary_w).abs() < 1e-9, "{balance:?}");
        assert!(balance.source_w > 1.0);
    }
}

#[test]
fn nodes_without_a_path_to_a_boundary_are_refused_by_name() {
    let mut b = Build::default();
    let t = b.n(300.0);
    let wall = b.boundary("wall", t);
    let a = b.diffusion("a", 1.0);
    let lost = b.diffusion("lost", 1.0);
    let alone = b.arithmetic("alone");
    let g = b.n(1.0);
    b.conductor("a wall", [a, wall], g);
    b.conductor("lost alone", [lost, alone], g);
    let network = Network::compile(&b.model, &[]).unwrap();
    let mut ws = network.workspace();
    let error = network.solve_steady(&mut ws, Start::Default).unwrap_err();
    assert_eq!(error, SteadyError::Isolated { nodes: vec!["lost".into(), "alone".into()] });
    assert!(error.to_string().contains("`lost`, `alone`"));
}

#[test]
fn any_sensible_start_leads_to_the_same_bits_of_closure() {
    let network = Network::compile(&sxm(), &[]).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let reference = ws.temperatures().to_vec();
    for start in [3.0, 20.0, 150.0, 300.0, 450.0] {
        let guess = vec![start; 11];
        let stats = network.solve_steady(&mut ws, Start::Temperatures(&guess)).unwrap();
        for (a, b) in ws.temperatures().iter().zip(&reference) {
            // The last Newton step is below 1e-4 K, its square over the temperature is what is left.
            assert!((a - b).abs() < 1e-8, "from {start} K: {a} {b} {stats:?}");
        }
    }
}

#[test]
fn lanes_have_the_bits_of_single_solves() {
    let network = Network::compile(&sxm(), &[]).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let nominal = ws.temperatures().to_vec();
    let mut batch = network.batch::<8>();
    let sample = |lane: usize| -> Vec<f64> {
        let scale = |i: usize| 1.0 + 0.3 * libm::sin((lane * 13 + i * 7) as f64);
        network.nominal_parameters().iter().enumerate().map(|(i, p)| p * scale(i)).collect()
    };
    for lane in 0..8 {
        batch.set_parameters(&network, lane, &sample(lane));
        if lane == 5 {
            batch.set_inputs(&network, lane, &[f64::NAN, 1.0, 1.0, 3.0]);
        }
    }
    network.solve_steady_batch(&mut batch, Start::Temperatures(&nominal));
    for lane in 0..8 {
        if lane == 5 {
            assert!(batch.outcome(lane).is_err());
            assert!(batch.quantity(&network, lane, 0).is_nan());
            continue;
        }
        network.set_parameters(&mut ws, &sample(lane));
        let stats = network.solve_steady(&mut ws, Start::Temperatures(&nominal)).unwrap();
        assert_eq!(batch.outcome(lane), &Ok(stats));
        for node in 0..11 {
            assert_eq!(batch.temperature(lane, node).to_bits(), ws.temperatures()[node].to_bits());
        }
        for quantity in 0..network.quantities() {
            let alone = network.quantity(&ws, quantity);
            assert_eq!(batch.quantity(&network, lane, quantity).to_bits(), alone.to_bits());
        }
    }
}

#[test]
fn a_model_without_nodes_has_quantities_alone() {
    let mut b = Build::default();
    let (x, y) = (b.parameter("x", 3.0), b.input("y", 4.0));
    let product = b.mul(x, y);
    let sum = b.add(product, x);
    b.quantity("xy + x", sum);
    let network = Network::compile(&b.model, &[Symbol::Parameter(0), Symbol::Input(0)]).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    assert_eq!(network.quantity(&ws, 0), 15.0);
    let mut slopes = [0.0; 2];
    network.quantity_tangent(&mut ws, &mut slopes).unwrap();
    assert_eq!(slopes, [5.0, 3.0]);
    network.set_parameters(&mut ws, &[5.0]);
    assert!(network.quantity_tangent(&mut ws, &mut slopes).is_err(), "derivatives of an old solution are refused");
    let mut batch = network.batch::<4>();
    batch.set_parameter(2, 0, 10.0);
    network.solve_steady_batch(&mut batch, Start::Default);
    assert_eq!(batch.quantity(&network, 2, 0), 50.0);
    assert_eq!(batch.quantity(&network, 1, 0), 15.0);
}

#[test]
fn what_is_not_a_number_is_named_with_its_temperatures() {
    let mut b = Build::default();
    let node = b.diffusion("plate", 10.0);
    let wall = b.n(300.0);
    let wall = b.boundary("wall", wall);
    let g = b.n(1.0);
    b.conductor("good", [node, wall], g);
    // A real power of a negative base.
    let own = b.t(node);
    let limit = b.n(1000.0);
    let below = b.sub(own, limit);
    let exponent = b.n(1.25);
    let heat = b.graph().binary(bmv::expression::Binary::Power, below, exponent);
    b.flow("odd path", [node, wall], heat);
    let network = Network::compile(&b.model, &[]).unwrap();
    let mut ws = network.workspace();
    let error = network.solve_steady(&mut ws, Start::Default).unwrap_err();
    let SteadyError::NotFinite { element, temperatures } = &error else { panic!("{error}") };
    assert_eq!(element, "odd path");
    assert_eq!(temperatures[0].0, "plate");
    assert!(error.to_string().contains("`odd path`") && error.to_string().contains("`plate` 300 K"), "{error}");
}

#[test]
fn balances_that_cannot_close_name_the_node() {
    // 5 W into a node whose only path carries at most 1 W.
    let mut b = Build::default();
    let node = b.diffusion("plate", 10.0);
    let wall = b.n(300.0);
    let wall = b.boundary("wall", wall);
    let (own, far) = (b.t(node), b.t(wall));
    let gap = b.sub(own, far);
    let scaled = b.scale(0.01, gap);
    let heat = b.graph().unary(bmv::expression::Unary::Tanh, scaled);
    b.flow("choked", [node, wall], heat);
    let power = b.n(5.0);
    b.load("load", node, power);
    let network = Network::compile(&b.model, &[]).unwrap();
    let mut ws = network.workspace();
    let error = network.solve_steady(&mut ws, Start::Default).unwrap_err();
    match &error {
        SteadyError::NotConverged { node, imbalance_w, .. } => {
            assert_eq!(node, "plate");
            assert!((imbalance_w - 4.0).abs() < 1e-3, "{imbalance_w}");
        }
        SteadyError::Singular { node } => assert_eq!(node, "plate"),
        other => panic!("{other}"),
    }
}

#[test]
fn a_large_network_agrees_with_its_heat_balance_and_its_differences() {
    // 200 nodes: sparse factors, at the instant of full sun.
    let network = Network::compile(&super::orbit::panel200(), &[]).unwrap();
    let mut ws = network.workspace();
    let stats = network.solve_steady(&mut ws, Start::Default).unwrap();
    assert!(stats.iterations < 12, "{stats:?}");
    let balance = network.heat_balance(&mut ws);
    assert!((balance.source_w - (32.0 + 200.0 * 0.2 * 0.01 * 1361.0)).abs() < 1e-9);
    assert!((balance.source_w - balance.boundary_w - balance.stored_w).abs() < 1e-9, "{balance:?}");
    // Each of 200 nodes may be open by 1e-9 W.
    assert!((balance.source_w - balance.boundary_w).abs() < 2e-7);
    let reference = ws.temperatures().to_vec();
    let mut batch = network.batch::<2>();
    network.solve_steady_batch(&mut batch, Start::Default);
    for (node, value) in reference.iter().enumerate() {
        assert_eq!(batch.temperature(1, node).to_bits(), value.to_bits());
    }
}

/// Surfaces that all exchange radiation, each heated by its own parameter, and the fourth powers of their temperatures by a
/// dense solution of the balances, which are linear in these.
#[test]
fn factors_that_serve_several_steps_lead_to_the_exact_enclosure() {
    const NODES: usize = 120;
    let sigma = 5.670374419e-8;
    let area = |i: usize, j: usize| 1e-3 * (1.0 + 0.5 * libm::sin((i * j) as f64));
    let power = |i: usize| 5.0 + 4.0 * libm::cos(i as f64);
    let mut b = Build::default();
    let nodes: Vec<usize> = (0..NODES).map(|i| b.diffusion(&format!("n{i}"), 1.0)).collect();
    let cold = b.n(80.0);
    let space = b.boundary("space", cold);
    let mut balances = nalgebra::DMatrix::zeros(NODES, NODES);
    let mut heats = nalgebra::DVector::zeros(NODES);
    for i in 0..NODES {
        let heat = b.parameter(&format!("p{i}"), power(i));
        b.load(&format!("q{i}"), nodes[i], heat);
        let outside = 0.01;
        let exchange = b.n(outside);
        b.radiation(&format!("s{i}"), [nodes[i], space], exchange);
        balances[(i, i)] += sigma * outside;
        heats[i] += sigma * outside * (80.0 * 80.0 * 80.0 * 80.0);
        for j in 0..i {
            let exchange = b.n(area(i, j));
            b.radiation(&format!("r{i}-{j}"), [nodes[i], nodes[j]], exchange);
            balances[(i, i)] += sigma * area(i, j);
            balances[(j, j)] += sigma * area(i, j);
            balances[(i, j)] -= sigma * area(i, j);
            balances[(j, i)] -= sigma * area(i, j);
        }
    }
    b.temperature("first", nodes[0]);
    let network = Network::compile(&b.model, &[Symbol::Parameter(7)]).unwrap();
    let factors = balances.lu();
    let exact = |changed: f64| -> Vec<f64> {
        let mut heats = heats.clone();
        (0..NODES).for_each(|i| heats[i] += power(i));
        heats[7] += changed;
        factors.solve(&heats).unwrap().iter().map(|u: &f64| u.sqrt().sqrt()).collect()
    };
    let mut ws = network.workspace();
    let stats = network.solve_steady(&mut ws, Start::Default).unwrap();
    assert!(2 * stats.factorisations <= stats.iterations, "{stats:?}");
    let reference = ws.temperatures().to_vec();
    for (value, exact) in reference.iter().zip(exact(0.0)) {
        // A balance may be open by 1e-9 W, which is 2e-9 K at these surfaces.
        assert!((value - exact).abs() < 1e-8, "{value} {exact}");
    }
    // Derivatives are made with slopes of the solution itself, not with those that served on the way.
    let mut slope = [0.0];
    network.quantity_tangent(&mut ws, &mut slope).unwrap();
    let difference = (exact(0.1)[0] - exact(-0.1)[0]) / 0.2;
    assert!((slope[0] / difference - 1.0).abs() < 1e-5, "{} {difference}", slope[0]);
    // A lane has the bits of a solution alone.
    let mut batch = network.batch::<8>();
    network.solve_steady_batch(&mut batch, Start::Default);
    for (node, value) in reference.iter().enumerate() {
        assert_eq!(batch.temperature(3, node).to_bits(), value.to_bits());
    }
    // From near the solution one factorisation is enough.
    let near: Vec<f64> = reference.iter().map(|value| value + 3.0).collect();
    let stats = network.solve_steady(&mut ws, Start::Temperatures(&near)).unwrap();
    assert_eq!(stats.factorisations, 1, "{stats:?}");
    for (value, first) in ws.temperatures().iter().zip(&reference) {
        assert!((value - first).abs() < 1e-9, "{value} {first}");
    }
}

#[test]
fn a_boundary_below_absolute_zero_is_refused_wherever_it_comes_from() {
    // -30, meant in degC but read in K: radiation to it would go with (-30 K)^4.
    let mut b = Build::default();
    let sink = b.input("T_sink", -30.0);
    let plate = b.diffusion("plate", 900.0);
    let sink = b.boundary("sink", sink);
    let (area, power) = (b.n(0.05), b.n(5.0));
    b.radiation("to sink", [plate, sink], area);
    b.load("board", plate, power);
    let network = Network::compile(&b.model, &[]).unwrap();
    let refused = SteadyError::Boundary { node: "sink".into(), temperature_k: -30.0 };
    let mut workspace = network.workspace();
    assert_eq!(network.solve_steady(&mut workspace, Start::Default).unwrap_err(), refused);
    let mut batch = network.batch::<4>();
    batch.set_inputs(&network, 2, &[250.0]);
    network.solve_steady_batch(&mut batch, Start::Default);
    assert_eq!(batch.outcome(1).as_ref().unwrap_err(), &refused);
    // 5 W = sigma 0.05 m2 (T^4 - 250^4); the solution closes to 1e-9 W.
    let exact = libm::pow(libm::pow(250.0, 4.0) + 5.0 / (5.670374419e-8 * 0.05), 0.25);
    assert!((batch.temperature(2, plate) - exact).abs() < 1e-8, "{}", batch.temperature(2, plate));
    let inputs = InputTable {
        times_s: vec![0.0, 10.0, 20.0],
        columns: vec![InputColumn { input: 0, values: vec![250.0, -30.0, 250.0], hold: false }],
        base: vec![250.0],
    };
    let request = TransientRequest::new(&[], &inputs, InitialState::Temperatures(&[300.0, 0.0]), &[20.0]);
    assert_eq!(network.solve_transient(&request).unwrap_err(), TransientError::Steady(refused));
}

#[test]
fn a_thermostat_upside_down_is_refused_in_a_steady_solution() {
    // Off above 285 K, on below 290 K: the average of its cycling has no meaning.
    let mut b = Build::default();
    let sink = b.n(280.0);
    let battery = b.diffusion("battery", 100.0);
    let sink = b.boundary("sink", sink);
    let (conductance, power, on) = (b.n(0.1), b.n(10.0), b.n(290.0));
    b.conductor("link", [battery, sink], conductance);
    let off = b.parameter("off", 285.0);
    b.thermostat("heater", battery, power, on, off);
    let network = Network::compile(&b.model, &[]).unwrap();
    let mut workspace = network.workspace();
    let refused = SteadyError::Band { element: "heater".into(), band_k: -5.0 };
    assert_eq!(network.solve_steady(&mut workspace, Start::Default).unwrap_err(), refused);
    network.set_parameters(&mut workspace, &[295.0]);
    assert!(network.solve_steady(&mut workspace, Start::Default).is_ok());
}
