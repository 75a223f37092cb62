//! Every effect of the catalogue at every place of a small model: nothing at amplitude 0, exact derivatives, closed
//! heat balances.

use bmv::document::Diagnostics;
use bmv::effect::{
    Candidate, Catalogue, Effect, GroupPlace, Instance, REFERENCE_K, SensorPlace, Site, apply, candidates,
};
use bmv::expression::{Graph, Symbol};
use bmv::thermal::element::cooler::{Cooler, Drive};
use bmv::thermal::element::{Element, ElementKind};
use bmv::thermal::{Clock, Model, Network, NodeKind, Start};

use super::build::Build;

/// A cooled detector in a box on a plate, seeing a shroud; one of each kind of element, inputs of several kinds.
pub fn model() -> Model {
    let mut b = Build::default();
    let plate_k = b.input("T_plate", 290.0);
    let shroud_k = b.input("T_shroud", 120.0);
    let power = b.input("Q", 6.0);
    let pressure = b.input("p", 2.0);
    let current = b.input("i", 0.8);
    b.input("angle", 0.7);
    b.input("T_bay", 260.0);
    for (input, unit) in ["K", "K", "W", "Pa", "A", "deg", "K"].into_iter().enumerate() {
        b.model.inputs[input].unit = unit.into();
        b.model.inputs[input].range = Some([0.5 * b.model.inputs[input].nominal, 1.5 * b.model.inputs[input].nominal]);
    }
    let plate = b.boundary("plate", plate_k);
    let shroud = b.boundary("shroud", shroud_k);
    let case = b.diffusion("box", 900.0);
    let panel = b.diffusion("panel", 300.0);
    let blanket = b.arithmetic("blanket");
    let detector = b.diffusion("detector", 20.0);
    let bolts = b.parameter("G", 0.6);
    b.conductor("bolts", [case, plate], bolts);
    let strap = b.n(0.25);
    b.conductor("strap", [case, panel], strap);
    let area = b.n(0.03);
    b.radiation("panel to shroud", [panel, shroud], area);
    let (inner, outer) = (b.n(0.002), b.n(0.05));
    b.radiation("blanket inside", [case, blanket], inner);
    b.radiation("blanket outside", [blanket, shroud], outer);
    let leak = b.n(0.01);
    b.conductor("leads", [detector, case], leak);
    b.load("board", case, power);
    let (set_point, band, most) = (b.n(265.0), b.n(20.0), b.n(3.0));
    let control = bmv::thermal::element::HeaterControl::Proportional { set_point, band };
    let heater = bmv::thermal::element::Heater { into: panel, senses: panel, power: most, control };
    b.element("panel heater", ElementKind::Heater(heater));
    let cooler = Cooler {
        nodes: vec![detector, case],
        couples: vec![b.n(17.0)],
        drive: Drive::Current(current),
        seebeck: b.n(4e-4),
        resistance: b.n(0.02),
        conductance: b.n(1.5e-3),
        lead_resistance: b.n(0.0),
    };
    b.element("cooler", ElementKind::Cooler(cooler));
    for node in 0..b.model.nodes.len() {
        let name = b.model.nodes[node].name.clone();
        b.temperature(&name, node);
    }
    for quantity in &mut b.model.quantities {
        quantity.is_temperature = true;
    }
    b.quantity("pressure", pressure);
    // Heat of an element as the study's format gives it.
    let element = b.model.elements.iter().position(|element| element.name == "bolts").expect("there");
    let through = b.model.elements[element].clone().contribution(b.graph(), &mut Vec::new(), false).through;
    b.quantity("leak", through.expect("a conductor"));
    // Three days, and runs of half an hour.
    for (clock, last) in [(Clock::Date, 259_200.0), (Clock::Elapsed, 1800.0)] {
        let input = b.model.clock_input(clock);
        b.model.inputs[input].range = Some([0.0, last]);
    }
    b.model
}

pub fn sensors(model: &Model) -> Vec<SensorPlace> {
    (["box", "panel", "detector"].into_iter())
        .map(|name| SensorPlace {
            name: format!("TC {name}"),
            quantity: model.quantities.iter().position(|quantity| quantity.name == name).expect("there"),
            steady: true,
            transient: true,
        })
        .collect()
}

pub fn groups(model: &Model) -> Vec<GroupPlace> {
    let node = |name: &str| model.nodes.iter().position(|node| node.name == name).expect("there");
    let element = |name: &str| model.elements.iter().position(|element| element.name == name).expect("there");
    vec![
        GroupPlace { name: "surfaces".into(), site: Site::Nodes([(node("box"), 1.0), (node("panel"), 0.5)].into()) },
        GroupPlace { name: "joints".into(), site: Site::Elements([element("bolts"), element("strap")].into()) },
        GroupPlace {
            name: "layers".into(),
            site: Site::Elements([element("blanket inside"), element("blanket outside")].into()),
        },
        GroupPlace { name: "bonded".into(), site: Site::Sensors(sensors(model)[..2].to_vec()) },
    ]
}

pub fn catalogue() -> Catalogue {
    Catalogue::embedded(&mut Diagnostics::new())
}

fn all(catalogue: &Catalogue) -> Vec<Candidate> {
    let model = model();
    candidates(&model, &groups(&model), &sensors(&model), catalogue)
}

/// The model with a candidate, and its parameters at 0 amplitude and at a probe.
fn applied(effect: &Effect, candidate: &Candidate) -> (Model, Vec<f64>, Vec<f64>, Vec<usize>) {
    let mut model = model();
    let parameters = effect.parameters(&model, &candidate.bound);
    let mut zero: Vec<f64> = model.parameters.iter().map(|parameter| parameter.nominal).collect();
    let mut probe = zero.clone();
    let mut amplitudes = Vec::new();
    for parameter in &parameters {
        if parameter.amplitude {
            amplitudes.push(zero.len());
        }
        zero.push(if parameter.amplitude { 0.0 } else { parameter.nominal });
        let value = parameter.probes.last().copied().unwrap_or(parameter.nominal);
        probe.push(if parameter.amplitude { value } else { parameter.nominal });
    }
    let (site, bound) = (candidate.site.clone(), candidate.bound.clone());
    let instance = Instance { name: "it", effect, site, bound, parameters, reference_k: REFERENCE_K, switch: None };
    apply(&mut model, &instance).unwrap_or_else(|error| panic!("{}: {error}", candidate.id));
    (model, zero, probe, amplitudes)
}

/// Steady values of all quantities; of an expression of time at 1000 s.
fn solve(network: &Network, parameters: &[f64]) -> (Vec<f64>, Vec<f64>, bmv::thermal::Workspace) {
    let mut workspace = network.workspace();
    network.set_parameters(&mut workspace, parameters);
    network.set_time(&mut workspace, 1000.0);
    network.solve_steady(&mut workspace, Start::Default).expect("solved");
    let quantities = (0..network.quantities()).map(|quantity| network.quantity(&workspace, quantity)).collect();
    (workspace.temperatures().to_vec(), quantities, workspace)
}

#[test]
fn every_effect_has_a_place_here() {
    let catalogue = catalogue();
    let all = all(&catalogue);
    for effect in catalogue.effects() {
        assert!(all.iter().any(|candidate| candidate.effect == effect.name), "{}", effect.name);
    }
    let mut ids: Vec<&str> = all.iter().map(|candidate| candidate.id.as_str()).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), all.len(), "ids are unique");
    let find = |id: &str| all.iter().find(|candidate| candidate.id == id).unwrap_or_else(|| panic!("{id}"));
    let pair = find("conductive-path:box:detector");
    assert_eq!((pair.where_kind, pair.steady, pair.transient, &pair.input), ("nodes", true, true, &None));
    assert_eq!(find("gas-conduction:box:plate:p").input.as_deref(), Some("p"));
    assert_eq!(find("product-load:box:Q*i").bound.len(), 2);
    assert!(!all.iter().any(|candidate| candidate.id == "product-load:box:i*Q"), "the order is of no account");
    assert_eq!(find("path-to-ambient:surfaces").where_kind, "group");
    assert_eq!(find("sensor-conduction:TC box:plate").place, ["TC box", "plate"]);
    let mass = find("thermal-mass:box");
    assert_eq!((mass.steady, mass.transient), (false, true), "steady phases see no capacity");
    assert!(!all.iter().any(|c| c.id == "conductive-path:plate:shroud"), "two boundaries exchange nothing of use");
    let logged = all.iter().filter(|c| c.effect == "path-to-logged-temperature");
    assert!(logged.map(|c| c.input.as_deref()).all(|input| input == Some("T_bay")), "boundaries have their own path");
    assert!(!all.iter().any(|c| c.effect == "gas-conduction" && c.input.as_deref() != Some("p")));
}

/// Without amplitude the temperatures are those of before. A contact keeps a resistance of 1e-6 K/W, a hidden path
/// 1e-12 W/K; all else is exact to rounding.
#[test]
fn no_amplitude_changes_nothing() {
    let catalogue = catalogue();
    let base = model();
    let before = Network::compile(&base, &[]).expect("compiled");
    let (temperatures, quantities, _) = solve(&before, before.nominal_parameters());
    for candidate in all(&catalogue) {
        let effect = catalogue.get(&candidate.effect).expect("there");
        let (model, zero, ..) = applied(effect, &candidate);
        let network = Network::compile(&model, &[]).expect("compiled");
        let (with, values, _) = solve(&network, &zero);
        let tolerance = if candidate.effect == "cooler-contact" { 1e-4 } else { 1e-7 };
        for (node, before) in temperatures.iter().enumerate() {
            assert!((with[node] - before).abs() < tolerance, "{} node {node}: {} {before}", candidate.id, with[node]);
        }
        for (quantity, before) in quantities.iter().enumerate() {
            let change = values[quantity] - before;
            assert!(change.abs() < tolerance, "{} quantity {quantity}: {change}", candidate.id);
        }
    }
}

/// Derivatives of every temperature and reading against central differences: step 1e-4 of the probe, so that
/// truncation (square of the step) and rounding (1e-10 K over the step) stay below 1e-5 of the largest derivative.
#[test]
fn derivatives_are_exact_and_balances_close() {
    let catalogue = catalogue();
    for candidate in all(&catalogue) {
        let effect = catalogue.get(&candidate.effect).expect("there");
        let (model, _, probe, amplitudes) = applied(effect, &candidate);
        let symbols: Vec<Symbol> = (1..model.parameters.len()).map(|index| Symbol::Parameter(index as u32)).collect();
        let network = Network::compile(&model, &symbols).expect("compiled");
        let (_, values, mut workspace) = solve(&network, &probe);
        let balance = network.heat_balance(&mut workspace);
        let lost_w = balance.source_w - balance.boundary_w - balance.stored_w;
        assert!(lost_w.abs() < 1e-6, "{}: {lost_w} W are lost", candidate.id);
        if symbols.is_empty() {
            continue;
        }
        let mut tangent = vec![0.0; values.len() * symbols.len()];
        let (_, _, mut workspace) = solve(&network, &probe);
        network.quantity_tangent(&mut workspace, &mut tangent).expect("solved");
        for &amplitude in &amplitudes {
            let step = 1e-4 * probe[amplitude].abs().max(1e-12);
            let at = |sign: f64| {
                let mut parameters = probe.clone();
                parameters[amplitude] += sign * step;
                solve(&network, &parameters).1
            };
            let (above, below) = (at(1.0), at(-1.0));
            let column = amplitude - 1;
            let largest = (0..values.len()).map(|q| tangent[q * symbols.len() + column].abs()).fold(0.0, f64::max);
            for quantity in 0..values.len() {
                let exact = tangent[quantity * symbols.len() + column];
                let difference = (above[quantity] - below[quantity]) / (2.0 * step);
                let tolerance = 1e-5 * largest + 2e-8 / step;
                assert!(
                    (exact - difference).abs() <= tolerance,
                    "{} {} of {}: {exact} against {difference}",
                    candidate.id,
                    model.parameters[amplitude].name,
                    model.quantities[quantity].name
                );
            }
        }
    }
}

/// What an effect between two nodes takes from one it gives to the other, at any temperatures.
#[test]
fn pairs_exchange_heat_and_make_none() {
    let catalogue = catalogue();
    let mut seen = 0;
    for candidate in all(&catalogue).iter().filter(|candidate| candidate.where_kind == "nodes") {
        let effect = catalogue.get(&candidate.effect).expect("there");
        let (mut model, _, probe, _) = applied(effect, candidate);
        let from = self::model().elements.len();
        let added: Vec<Element> = model.elements[from..].to_vec();
        let mut sums = vec![0.0; model.nodes.len()];
        for element in added {
            let contribution = element.contribution(&mut model.graph, &mut Vec::new(), false);
            for (node, heat) in contribution.heat {
                sums[node] += evaluate(&model.graph, heat, &probe);
            }
        }
        let Site::Pair(ends) = candidate.site else { panic!("a pair") };
        let inside: f64 = sums.iter().sum();
        let size: f64 = sums.iter().map(|heat| heat.abs()).sum();
        assert!(inside.abs() <= 1e-12 * size, "{}: {inside} W from nothing", candidate.id);
        assert!(sums[ends[0]] != 0.0 && sums[ends[1]] != 0.0, "{} acts at both ends", candidate.id);
        seen += 1;
    }
    assert!(seen > 50, "{seen}");
}

fn evaluate(graph: &Graph, id: bmv::expression::ExprId, parameters: &[f64]) -> f64 {
    // The last is the date at which what is dated sets in: half of it is there.
    let inputs = [290.0, 120.0, 6.0, 2.0, 0.8, 0.7, 260.0, 129_600.0, 900.0];
    graph.evaluate(id, &|symbol| match symbol {
        Symbol::Parameter(index) => parameters[index as usize],
        Symbol::Input(index) => inputs[index as usize],
        Symbol::Node(index) => 250.0 + 7.0 * f64::from(index),
        _ => 0.0,
    })
}

/// Heats by hand: each formula of the catalogue at one state, box 264 K, panel 271 K, detector 285 K.
#[test]
fn heats_follow_their_equations() {
    let catalogue = catalogue();
    let all = all(&catalogue);
    let sigma = 5.670374419e-8;
    let fourth = |kelvin: f64| kelvin * kelvin * kelvin * kelvin;
    let (cabinet, panel): (f64, f64) = (250.0 + 14.0, 250.0 + 21.0);
    // The surroundings are the seventh node of the evaluation below.
    let ambient = 250.0 + 6.0 * 7.0;
    let cases: &[(&str, f64)] = &[
        ("conductive-path:box:panel", 0.1 * (cabinet - panel)),
        ("radiative-path:box:panel", sigma * 1e-2 * (fourth(cabinet) - fourth(panel))),
        ("gas-conduction:box:panel:p", 1.0 * 2.0 * (cabinet - panel)),
        ("convection:box:panel", 0.1 * (cabinet - panel) * (panel - cabinet).sqrt().sqrt()),
        ("path-to-ambient:box", 0.1 * (cabinet - ambient)),
        ("path-to-logged-temperature:box:T_bay", 0.1 * (260.0 - cabinet)),
        ("radiation-to-ambient:box", sigma * 1e-2 * (fourth(cabinet) - fourth(ambient))),
        ("free-convection:box", 0.5 * (cabinet - ambient) * (ambient - cabinet).sqrt().sqrt()),
        ("heat-load:box", 0.5),
        ("input-proportional-load:box:Q", 0.5 / 9.0 * 6.0),
        ("joule-heating:box:i", 0.5 / (1.2 * 1.2) * 0.64),
        ("product-load:box:Q*i", 0.5 / (9.0 * 1.2) * 6.0 * 0.8),
        ("input-function-load:box:Q", 0.5),
        ("product-function-load:box:Q*i", 0.5 / 9.0 * 6.0),
        ("periodic-load:box:angle", 0.5 * (bmv::math::functions::cos(0.7) + bmv::math::functions::sin(0.7))),
        // A day and a half after the start.
        ("daily-load:box", -0.5),
        // Noon is its peak as the catalogue has it, five hours long.
        ("daily-hours-load:box", 0.5),
        ("dated-load:box", 0.5 * 0.5),
        ("event-load:box", 0.5 * 0.5),
        // Far below its threshold of 300 K.
        ("missing-heater:box:box", 1.0),
        ("evaporation:box", -0.1 * bmv::math::functions::exp(5309.0 * (1.0 / 293.15 - 1.0 / cabinet))),
    ];
    for &(id, expected) in cases {
        let candidate = all.iter().find(|candidate| candidate.id == id).unwrap_or_else(|| panic!("{id}"));
        let effect = catalogue.get(&candidate.effect).expect("there");
        let (mut model, _, probe, _) = applied(effect, candidate);
        let element = model.elements.last().expect("added").clone();
        let through = element.contribution(&mut model.graph, &mut Vec::new(), false).through.expect("one heat");
        let heat = evaluate(&model.graph, through, &probe);
        // The prior of the surroundings is cut, which moves its median by less than a microkelvin.
        assert!((heat - expected).abs() <= 1e-9 * expected.abs().max(0.01), "{id}: {heat}, by hand {expected}");
    }
}

/// A reading that adds a minute's change: all heat into the box over its 900 J/K.
#[test]
fn the_rate_of_a_reading_is_that_of_the_node() {
    let mut catalogue = catalogue();
    let own = r#"{"format": "bmv-effect/1", "title": "Early", "applies": {"sensor": {}},
        "parameters": {"behind": {"unit": "s", "prior": {"halfnormal": 60}, "sign": "positive", "probes": [60]}},
        "adds": {"reading": "T + behind * rate"}, "source": "a test"}"#;
    catalogue.read("early", "early.json", own.as_bytes(), &mut Diagnostics::new()).expect("read");
    let candidate = all(&catalogue).into_iter().find(|own| own.id == "early:TC box").expect("there");
    let (mut model, _, probe, _) = applied(catalogue.get("early").expect("there"), &candidate);
    let reading = model.quantities.last().expect("added").value.expression();
    let cabinet = model.nodes.iter().position(|node| node.name == "box").expect("there");
    let mut heat = 0.0;
    for element in model.elements.clone() {
        let contribution = element.contribution(&mut model.graph, &mut Vec::new(), false);
        let own = contribution.heat.into_iter().filter(|(node, _)| *node == cabinet);
        heat += own.map(|(_, heat)| evaluate(&model.graph, heat, &probe)).sum::<f64>();
    }
    let expected = 250.0 + 7.0 * cabinet as f64 + 60.0 * heat / 900.0;
    assert!(heat.abs() > 1.0, "{heat} W");
    assert!((evaluate(&model.graph, reading, &probe) - expected).abs() < 1e-9);
}

/// A power of a share that grows from 0 to 1, rounded off near 0.
fn rounded_power(share: f64, exponent: f64) -> f64 {
    let power = |base: f64| libm::pow(base, exponent);
    (power(share + 0.01) - power(0.01)) / (power(1.01) - power(0.01))
}

/// Factors and readings by hand.
#[test]
fn changes_of_what_is_there_follow_their_equations() {
    let catalogue = catalogue();
    let all = all(&catalogue);
    let (cabinet, panel, shroud): (f64, f64, f64) = (264.0, 271.0, 257.0);
    let cases: &[(&str, &str, f64)] = &[
        ("temperature-dependent-conductance:strap", "strap", 0.25 * (1.0 + 0.003 * (0.5 * (cabinet + panel) - 293.15))),
        ("temperature-dependent-emittance:panel to shroud", "panel to shroud", 0.03 * (1.0 + 0.003 * (panel - 293.15))),
        (
            "mli-effective-emittance:panel to shroud",
            "panel to shroud",
            0.03 * (1.0 + 180_000.0 / (panel * panel + shroud * shroud)),
        ),
        ("conductance-step:strap:Q", "strap", 0.25 * 1.25),
        ("input-dependent-conductance:strap:Q", "strap", 0.25 * (1.0 + rounded_power(0.5, 0.7))),
        ("conductance-lost-below:strap:box", "strap", 0.25 * (1.0 - 0.5)),
        ("dated-conductance:strap", "strap", 0.25 * (1.0 + 0.5 * 0.5)),
        ("event-conductance:strap", "strap", 0.25 * (1.0 + 0.5 * 0.5)),
        ("dated-conductance:panel to shroud", "panel to shroud", 0.03 * (1.0 + 0.5 * 0.5)),
        ("dissipation-temperature:board", "board", 6.0 * (1.0 + 0.005 * (cabinet - 293.15))),
        ("heater-efficiency:board", "board", 6.0 * 1.1),
    ];
    for &(id, name, expected) in cases {
        let candidate = all.iter().find(|candidate| candidate.id == id).unwrap_or_else(|| panic!("{id}"));
        let (model, _, probe, _) = applied(catalogue.get(&candidate.effect).expect("there"), candidate);
        let element = model.elements.iter().find(|element| element.name == name).expect("there");
        let value = match &element.kind {
            ElementKind::Conductor(element) => element.conductance,
            ElementKind::Radiation(element) => element.exchange_area,
            ElementKind::Load(element) => element.power,
            _ => panic!("{id}"),
        };
        let value = evaluate(&model.graph, value, &probe);
        assert!((value - expected).abs() <= 1e-12 * expected.abs(), "{id}: {value}, by hand {expected}");
    }
    let readings: &[(&str, f64)] = &[
        ("sensor-bias:TC box", cabinet + 0.5),
        ("dated-bias:TC box", cabinet + 0.5 * 0.5),
        ("sensor-gain:TC box", cabinet + 0.01 * (cabinet - 273.15)),
        ("sensor-conduction:TC box:panel", cabinet + 0.05 * (panel - cabinet)),
        ("sensor-self-heating:TC box", cabinet + 0.5),
        // The input is at two thirds of its range.
        ("sensor-gradient:TC box:Q", cabinet + 1.0 * 6.0 / 9.0),
    ];
    for &(id, expected) in readings {
        let candidate = all.iter().find(|candidate| candidate.id == id).unwrap_or_else(|| panic!("{id}"));
        let (model, _, probe, _) = applied(catalogue.get(&candidate.effect).expect("there"), candidate);
        let reading = model.quantities.last().expect("added").value.expression();
        assert!((evaluate(&model.graph, reading, &probe) - expected).abs() < 1e-10, "{id}");
    }
    let offset = all.iter().find(|candidate| candidate.id == "sink-offset:plate").expect("there");
    let (model, _, probe, _) = applied(catalogue.get("sink-offset").expect("there"), offset);
    let NodeKind::Boundary { temperature } = model.nodes[0].kind else { panic!("a boundary") };
    assert_eq!(evaluate(&model.graph, temperature, &probe), 293.0);
}
