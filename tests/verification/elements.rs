//! Elements against closed forms: coolers, by couples and by response surfaces, a fin, a proportional heater.

use bmv::expression::ExprId;
use bmv::thermal::element::Physics;
use bmv::thermal::element::{
    ElementKind, Heater, HeaterControl, SurfaceCooler,
    cooler::{Cooler, Drive},
};
use bmv::thermal::{Network, Start};

use super::build::Build;

/// Couples of the stages, from cold to hot.
const COUPLES: [f64; 2] = [8.0, 24.0];

/// A cooler between a loaded cold plate and a wall at 300 K; quantities: pumped heat, current, cold temperature.
fn cooled(stages: usize, by_current: bool, drive: f64, load_w: f64) -> Build {
    let mut b = Build::default();
    let drive = b.parameter("drive", drive);
    let nodes: Vec<usize> = (0..stages).map(|i| b.diffusion(&format!("stage {i}"), 1.0)).collect();
    let wall = b.n(300.0);
    let wall = b.boundary("wall", wall);
    let nodes: Vec<usize> = nodes.into_iter().chain([wall]).collect();
    let load = b.n(load_w);
    b.load("load", 0, load);
    let couples: Vec<ExprId> = (0..stages).map(|i| b.n(COUPLES[i])).collect();
    let cooler = Cooler {
        nodes,
        couples,
        drive: if by_current { Drive::Current(drive) } else { Drive::Voltage(drive) },
        seebeck: b.n(3.95e-4),
        resistance: b.n(0.185),
        conductance: b.n(3.8e-4),
        lead_resistance: b.n(0.35),
    };
    let contribution = cooler.contribution(b.graph(), &mut Vec::new(), false);
    b.element("tec", ElementKind::Cooler(cooler));
    b.quantity("pumped", contribution.through.unwrap());
    b.quantity("current", contribution.current.unwrap());
    b.temperature("cold", 0);
    b
}

#[test]
fn cooler_obeys_the_first_law_with_one_and_two_stages_and_both_drives() {
    for stages in [1, 2] {
        for by_current in [false, true] {
            let drive = if by_current { 0.3 } else { 2.0 / f64::from(3 - stages as i32) };
            let b = cooled(stages, by_current, drive, 0.02);
            let network = Network::compile(&b.model, &[]).unwrap();
            let mut ws = network.workspace();
            network.solve_steady(&mut ws, Start::Default).unwrap();
            let (pumped, current) = (network.quantity(&ws, 0), network.quantity(&ws, 1));
            // Voltage over the stages from its definition, outside the engine.
            let mut voltage = 0.0;
            for stage in 0..stages {
                let n = COUPLES[stage];
                let difference = ws.temperatures()[stage + 1] - ws.temperatures()[stage];
                voltage += n * (3.95e-4 * difference + current * 0.185);
            }
            let balance = network.heat_balance(&mut ws);
            let hot = balance.into_boundaries[0].1;
            let power = voltage * current;
            assert!(power > 0.01);
            assert!((pumped - 0.02).abs() < 1e-9);
            // Everything into the wall came from the load and the wires: 1e-12 of the terms plus the solve's 1e-9 W.
            assert!((hot - pumped - power).abs() < 1e-12 * hot + 2e-9, "{stages} {by_current}: {hot} {pumped} {power}");
            if !by_current {
                assert!((voltage + 0.35 * current - drive).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn cooler_power_is_heat_out_less_heat_in_to_twelve_digits_at_any_state() {
    // As an identity of the expressions, away from any solution.
    for stages in [1, 2] {
        for by_current in [false, true] {
            let b = cooled(stages, by_current, 0.31, 0.0);
            let mut graph = b.model.graph.clone();
            let contribution = b.model.elements[1].contribution(&mut graph, &mut Vec::new(), false);
            let temperatures = [231.0, 268.0, 300.0];
            let lookup = |symbol| match symbol {
                bmv::expression::Symbol::Node(n) if n as usize == stages => 300.0,
                bmv::expression::Symbol::Node(n) => temperatures[n as usize],
                _ => 0.31,
            };
            let net: f64 = contribution.heat.iter().map(|&(_, id)| graph.evaluate(id, &lookup)).sum();
            let current = graph.evaluate(contribution.current.unwrap(), &lookup);
            let mut voltage = 0.0;
            for stage in 0..stages {
                let hot = if stage + 1 == stages { 300.0 } else { temperatures[stage + 1] };
                voltage += COUPLES[stage] * (3.95e-4 * (hot - temperatures[stage]) + current * 0.185);
            }
            let size = contribution.balance_scale.iter().map(|&(_, id)| graph.evaluate(id, &lookup)).sum::<f64>();
            assert!((net - voltage * current).abs() < 1e-12 * size, "{net} {}", voltage * current);
        }
    }
}

#[test]
fn largest_difference_of_a_cooler_is_half_z_times_the_cold_temperature_squared() {
    // No load, current a Tc / R (case study 6.1): dT = Z Tc^2 / 2.
    let z = 3.95e-4 * 3.95e-4 / (0.185 * 3.8e-4);
    let cold = ((1.0f64 + 2.0 * z * 300.0).sqrt() - 1.0) / z;
    let optimum = 3.95e-4 * cold / 0.185;
    let at = |current: f64| {
        let b = cooled(1, true, current, 0.0);
        let network = Network::compile(&b.model, &[]).unwrap();
        let mut ws = network.workspace();
        network.solve_steady(&mut ws, Start::Default).unwrap();
        ws.temperatures()[0]
    };
    assert!((at(optimum) - cold).abs() < 1e-6, "{} {cold}", at(optimum));
    assert!((300.0 - at(optimum) - 0.5 * z * cold * cold).abs() < 1e-6);
    assert!(at(optimum * 1.02) > at(optimum) && at(optimum * 0.98) > at(optimum));
}

#[test]
fn fin_converges_to_the_cosh_solution_with_second_order() {
    // T'' = m^2 (T - T_inf) with an adiabatic tip: (T - T_inf) / (T_0 - T_inf) = cosh(m (L - x)) / cosh(m L).
    let (length, conductivity_area, film) = (0.2, 0.01, 0.6);
    let m = f64::sqrt(film / conductivity_area);
    let error = |cells: usize| {
        let mut b = Build::default();
        let (root, air) = (b.n(350.0), b.n(290.0));
        let root = b.boundary("root", root);
        let air = b.boundary("air", air);
        let h = length / cells as f64;
        // Nodes at the cells' middles: half a cell from the root.
        let along = b.n(conductivity_area / h);
        let first = b.n(2.0 * conductivity_area / h);
        let side = b.n(film * h);
        let mut last = root;
        for i in 0..cells {
            let node = b.arithmetic(&format!("x{i}"));
            b.conductor(&format!("a{i}"), [last, node], if i == 0 { first } else { along });
            b.conductor(&format!("s{i}"), [node, air], side);
            last = node;
        }
        let network = Network::compile(&b.model, &[]).unwrap();
        let mut ws = network.workspace();
        network.solve_steady(&mut ws, Start::Default).unwrap();
        (0..cells)
            .map(|i| {
                let x = (i as f64 + 0.5) * h;
                let exact = 290.0 + 60.0 * libm::cosh(m * (length - x)) / libm::cosh(m * length);
                (ws.temperatures()[2 + i] - exact).abs()
            })
            .fold(0.0, f64::max)
    };
    let errors: Vec<f64> = [10, 20, 40, 80].into_iter().map(error).collect();
    for pair in errors.windows(2) {
        let order = libm::log2(pair[0] / pair[1]);
        assert!((order - 2.0).abs() < 0.1, "{errors:?}");
    }
}

/// `i = p + q x`, `x = T - 300`, on a housing that loses `G (T - 290)`: `V i - i^2 R = G (x + 10)` is a quadratic of `x`.
#[test]
fn a_cooler_by_surfaces_heats_its_housing_by_its_power_less_that_of_the_leads() {
    let (voltage, p, q, resistance, loss) = (2.5, 0.3, -0.002, 0.35, 0.4);
    let mut b = Build::default();
    let housing = b.diffusion("housing", 12.0);
    let wall = b.n(290.0);
    let wall = b.boundary("wall", wall);
    let conductance = b.n(loss);
    b.conductor("joint", [housing, wall], conductance);
    let (v, p_id, q_id, r) = (b.n(voltage), b.parameter("p", p), b.parameter("q", q), b.n(resistance));
    let temperature = b.graph().symbol(bmv::expression::Symbol::Node(0));
    let reference = b.n(300.0);
    let warmer = b.graph().subtract(temperature, reference);
    let rising = b.graph().multiply(q_id, warmer);
    let current = b.graph().add(p_id, rising);
    let drop = b.n(60.0);
    let cold_side = b.graph().subtract(temperature, drop);
    let cooler = SurfaceCooler { hot: housing, voltage: v, current, cold_side, lead_resistance: r };
    let contribution = cooler.contribution(b.graph(), &mut Vec::new(), false);
    b.element("tec", ElementKind::SurfaceCooler(cooler));
    b.quantity("current", contribution.current.unwrap());
    b.quantity("cold side", contribution.cold_side.unwrap());
    b.quantity("heat", contribution.through.unwrap());
    let network = Network::compile(&b.model, &[]).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let (a2, a1) = (resistance * q * q, loss - voltage * q + 2.0 * resistance * p * q);
    let a0 = resistance * p * p - voltage * p + 10.0 * loss;
    let x = 2.0 * -a0 / (a1 + (a1 * a1 - 4.0 * a2 * a0).sqrt());
    let i = p + q * x;
    for (place, exact) in [i, 240.0 + x, voltage * i - resistance * i * i].into_iter().enumerate() {
        assert!(
            (network.quantity(&ws, place) - exact).abs() < 1e-8,
            "{place}: {} {exact}",
            network.quantity(&ws, place)
        );
    }
}

#[test]
fn steady_heaters_deliver_their_average() {
    // A thermostat 290..295 K holding 270 K surroundings through 0.5 W/K with 20 W: duty d = (295 - T) / 5 = 0.5 (T - 270) / 20.
    let mut b = Build::default();
    let node = b.diffusion("tank", 300.0);
    let other = b.diffusion("box", 300.0);
    let wall = b.n(270.0);
    let wall = b.boundary("wall", wall);
    let g = b.n(0.5);
    let (power, on, off) = (b.n(20.0), b.n(290.0), b.n(295.0));
    b.conductor("loss", [node, wall], g);
    b.conductor("box loss", [other, wall], g);
    b.thermostat("heater", node, power, on, off);
    let (set_point, band) = (b.n(292.5), b.n(5.0));
    let control = HeaterControl::Proportional { set_point, band };
    b.element("controller", ElementKind::Heater(Heater { into: other, senses: other, power, control }));
    let network = Network::compile(&b.model, &[]).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let exact = (20.0 * 295.0 / 5.0 + 0.5 * 270.0) / (20.0 / 5.0 + 0.5);
    assert!((ws.temperatures()[0] - exact).abs() < 1e-9);
    assert!((ws.temperatures()[1] - exact).abs() < 1e-9);
}
