//! Nodes, couplings and heat sinks; what only xija's fit uses.

use std::collections::HashMap;

use crate::deck::{Coupling, CouplingKind, Deck, Node, NodeKind, Note, Value};

use super::assembly::Assembly;
use super::class::Class;
use super::component::Component;
use super::parameters::TimeConstant;
use crate::CELSIUS_ZERO_K;

/// xija's Stefan-Boltzmann constant in W/(m2 K4).
const STEFAN_BOLTZMANN: &str = "0.00000005670374419";

/// Adds a node: its index in the deck.
pub fn node(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<usize, String> {
    let arguments = &component.arguments;
    let msid = if component.class == Class::Node { arguments.required_text("msid")? } else { "fptemp_11" };
    if let Some(unit) = arguments.text("units")?.filter(|unit| *unit != "degC") {
        return Err(format!("its unit is `{unit}`; only temperatures in degC are read"));
    }
    let celsius = arguments.number("data")?;
    let kind = if arguments.is_false("predict") {
        let input = assembly.input(component.name, "K", 293.15, &format!("measured temperature {msid}; degC in xija"));
        NodeKind::Boundary { temperature: Value::Expression(input) }
    } else {
        NodeKind::Diffusion { capacity: Value::Number(assembly.capacity_j_per_k) }
    };
    if let Some(sigma) = arguments.number("sigma")?.filter(|sigma| *sigma == 0.0 || *sigma >= 1000.0) {
        let message =
            format!("xija's fit gives node {} no weight (sigma {sigma}): a node without a sensor", component.name);
        assembly.note(component, message);
    }
    assembly.deck.nodes.push(Node {
        name: component.name.to_owned(),
        label: (msid != component.name).then(|| msid.to_owned()),
        kind,
        initial_temperature_k: celsius.map(|celsius| celsius + CELSIUS_ZERO_K),
    });
    Ok(assembly.deck.nodes.len() - 1)
}

/// `Coupling`: `dT1/dt = (T2 - T1) / tau`, of the first node alone.
pub fn coupling(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let between = ends(assembly, component)?;
    let tau = assembly.time_constant(component)?;
    push(assembly, component.name, CouplingKind::OneWay, between, format!("1 / {}", tau.name), Some(tau.value_ks));
    Ok(())
}

/// `RadiativeCoupling`, of xija's version of 2022: `dT1/dt = sigma factor (T2^4 - T1^4)`, of the first node alone.
pub fn radiative_coupling(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let between = ends(assembly, component)?;
    let factor = assembly.parameter(component, "factor", "m2", |factor| factor)?;
    let conductance = format!("{STEFAN_BOLTZMANN} * {factor} * (Ta + Tb) * (Ta ^ 2 + Tb ^ 2)");
    push(assembly, component.name, CouplingKind::OneWay, between, conductance, None);
    assembly.note(component, format!("`{}` acts on its first node alone, as a radiative conductance", component.name));
    Ok(())
}

/// `HeatSink`: `dT/dt = (Tsink - T) / tau`.
pub fn heat_sink(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let temperature = assembly.parameter(component, "T", "K", |celsius| celsius + CELSIUS_ZERO_K)?;
    let tau = assembly.time_constant(component)?;
    sink(assembly, component, Value::Scaled { parameter: temperature, factor: 1.0 }, tau)
}

/// `HeatSinkRef`: `dT/dt = P + (Tref - T) / tau`, a sink at `P tau + Tref`.
pub fn heat_sink_with_reference(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let power = assembly.parameter(component, "P", "W", |power| power)?;
    let tau = assembly.time_constant(component)?;
    let reference = assembly.parameter(component, "T_ref", "K", |celsius| celsius + CELSIUS_ZERO_K)?;
    sink(assembly, component, Value::Expression(format!("{power} * {} + {reference}", tau.name)), tau)
}

fn sink(
    assembly: &mut Assembly<'_>,
    component: &Component<'_>,
    temperature: Value,
    tau: TimeConstant,
) -> Result<(), String> {
    let node = assembly.predicted_node(component, "node")?;
    let nodes = &mut assembly.deck.nodes;
    nodes.push(Node {
        name: component.name.to_owned(),
        label: None,
        kind: NodeKind::Boundary { temperature },
        initial_temperature_k: None,
    });
    let boundary = nodes.len() - 1;
    push(
        assembly,
        component.name,
        CouplingKind::Linear,
        [boundary, node],
        format!("1 / {}", tau.name),
        Some(tau.value_ks),
    );
    Ok(())
}

fn push(
    assembly: &mut Assembly<'_>,
    name: &str,
    kind: CouplingKind,
    between: [usize; 2],
    value: String,
    tau_ks: Option<f64>,
) {
    assembly.taus_ks.push(tau_ks);
    assembly.deck.couplings.push(Coupling { name: name.to_owned(), kind, between, value: Value::Expression(value) });
}

/// The node that acts and the node that it acts on: the arguments `node2` and `node1`.
fn ends(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<[usize; 2], String> {
    let on = assembly.predicted_node(component, "node1")?;
    let from = component.arguments.required_text("node2")?;
    if assembly.class_of(from) == Some(Class::TelemData) {
        return telemetered(assembly, from).map(|boundary| [boundary, on]);
    }
    let from = assembly.node(component, "node2")?;
    if from == on {
        return Err("it couples a node to itself; `node1` and `node2` must differ".to_owned());
    }
    Ok([from, on])
}

/// A boundary at a measured temperature.
fn telemetered(assembly: &mut Assembly<'_>, name: &str) -> Result<usize, String> {
    if let Some(at) = assembly.deck.nodes.iter().position(|node| node.name == name) {
        return Ok(at);
    }
    let input = assembly.input(name, "K", 293.15, "measured temperature; degC in xija");
    assembly.deck.nodes.push(Node {
        name: name.to_owned(),
        label: None,
        kind: NodeKind::Boundary { temperature: Value::Expression(input) },
        initial_temperature_k: None,
    });
    Ok(assembly.deck.nodes.len() - 1)
}

/// `Delay`: reported temperatures are those of an earlier instant.
pub fn delay(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let node = component.arguments.required_text("node")?.to_owned();
    assembly.node(component, "node")?;
    let delay = assembly.fitted("delay")?.value;
    if delay != 0.0 {
        let message =
            format!("xija reports node {node} {delay} ks late: shift its readings by as much; the deck does not");
        assembly.note(component, message);
    }
    Ok(())
}

/// `Mask` and `MaskBox`: which readings xija's fit uses.
pub fn mask(assembly: &mut Assembly<'_>, component: &Component<'_>) -> Result<(), String> {
    let node = component.arguments.required_text("node")?;
    let rule = if component.class == Class::Mask {
        let operator = component.arguments.required_text("op")?;
        let Some(sign) = [("ge", ">="), ("gt", ">"), ("le", "<="), ("lt", "<"), ("eq", "=="), ("ne", "!=")]
            .iter()
            .find(|row| row.0 == operator)
        else {
            return Err(format!("`op` is `{operator}`; it must be ge, gt, le, lt, eq or ne"));
        };
        format!("{node} {} {} degC", sign.1, assembly.fitted("val")?.value)
    } else {
        let (lower, upper) = (assembly.fitted("val0")?.value, assembly.fitted("val1")?.value);
        format!("{lower} degC < {node} < {upper} degC")
    };
    assembly.note(
        component,
        format!("{} is left out: where a node names it, xija's fit uses readings at {rule} alone", component.name),
    );
    Ok(())
}

/// Makes one conductance of two equal and opposite one-way couplings; `taus_ks` belongs to the couplings.
pub fn merge_opposite(deck: &mut Deck, taus_ks: &mut Vec<Option<f64>>) {
    let mut at_ends: HashMap<[usize; 2], usize> = HashMap::new();
    let mut kept: Vec<(Coupling, Option<f64>)> = Vec::new();
    for (coupling, tau) in std::mem::take(&mut deck.couplings).into_iter().zip(taus_ks.drain(..)) {
        let [from, to] = coupling.between;
        let opposite = at_ends.get(&[to, from]).and_then(|&at| kept.get_mut(at));
        match opposite {
            Some((other, other_tau)) if tau.is_some() && tau == *other_tau && other.kind == CouplingKind::OneWay => {
                other.kind = CouplingKind::Linear;
                let (name, dropped) = (&other.name, &coupling.name);
                let message =
                    format!("{name} and {dropped} are equal and opposite: one conductance of both, called {name}");
                deck.notes.push(Note::new(message));
            }
            _ => {
                if coupling.kind == CouplingKind::OneWay {
                    at_ends.insert(coupling.between, kept.len());
                }
                kept.push((coupling, tau));
            }
        }
    }
    (deck.couplings, *taus_ks) = kept.into_iter().unzip();
}

/// The sum of `1 / tau` that act on each node and of `heaters`, in 1/ks; radiative couplings count as nothing.
pub fn rates_per_ks(deck: &Deck, taus_ks: &[Option<f64>], heaters: &[(usize, f64)]) -> Vec<f64> {
    let mut rates = vec![0.0; deck.nodes.len()];
    let mut add = |node: usize, rate: f64| {
        let predicted = deck.nodes.get(node).is_some_and(is_predicted);
        if let Some(sum) = rates.get_mut(node).filter(|_| predicted) {
            *sum += rate;
        }
    };
    for (coupling, tau) in deck.couplings.iter().zip(taus_ks) {
        let [from, to] = coupling.between;
        let rate = tau.map_or(0.0, |tau| 1.0 / tau);
        add(to, rate);
        if coupling.kind == CouplingKind::Linear {
            add(from, rate);
        }
    }
    for (node, rate) in heaters {
        add(*node, *rate);
    }
    rates
}

/// Whether the model computes its temperature.
pub fn is_predicted(node: &Node) -> bool {
    matches!(node.kind, NodeKind::Diffusion { .. })
}
