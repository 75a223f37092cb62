//! The heat that fitted effects carry: what each gives the nodes of the model, at the temperatures of the fit.
//!
//! With net heats `q` and capacities `C` of the model with the effect, `q'` and `C'` without it, at the same temperatures,
//! a node that stores heat gets `C' q / C - q'` from the effect, one that does not (and every node in a steady state)
//! `q - q'`. An effect that acts on sensors carries none.

use std::collections::BTreeMap;

use crate::diagnosis::output::EffectHeat;
use crate::diagnosis::{Hypothesis, Problem, Refit};
use crate::math::sort::sort_by;
use crate::measurement::prediction::Predictor;
use crate::measurement::unknown::with_unknowns;
use crate::measurement::{Measurement, Rows};
use crate::thermal::{Network, NodeHeat, Workspace};

/// Stretches of time of a transient.
const STRETCHES: usize = 12;
/// Nodes of which it is stated.
const MOST_NODES: usize = 6;
/// Heat below this share of the largest is rounding.
const LEAST: f64 = 1e-6;
/// Heat below which nothing is carried, W.
const LEAST_W: f64 = 1e-9;

/// Heat of a node in a row.
struct Row {
    measurement: usize,
    row: usize,
    /// By node of the model without the effect, W.
    watts: BTreeMap<String, f64>,
}

/// The heat that an effect of a fitted set carries into nodes over the fitted rows, the nodes with most first. Empty for
/// effects on sensors and where the model cannot be solved.
pub(crate) fn effect_heat_flow(problem: &Problem, refit: &Refit, effect: usize) -> Vec<EffectHeat> {
    let Some((with, rows)) = of_effect(problem, refit, effect) else { return Vec::new() };
    let largest = largest(&rows);
    let most = largest.values().copied().fold(0.0, f64::max);
    if !(most > LEAST_W) {
        return Vec::new();
    }
    let mut hosts: Vec<(&str, f64)> = largest.into_iter().filter(|(_, watts)| *watts > LEAST * most).collect();
    sort_by(&mut hosts, |a, b| b.1.total_cmp(&a.1).then(a.0.cmp(b.0)));
    hosts.truncate(MOST_NODES);
    hosts.iter().flat_map(|(node, _)| of_node(node, &rows, &with.measurements)).collect()
}

/// The most heat that an effect of a fitted set carries into a node, W; 0 where it carries none.
pub(crate) fn largest_heat(problem: &Problem, refit: &Refit, effect: usize) -> f64 {
    let rows = of_effect(problem, refit, effect).map(|(_, rows)| rows).unwrap_or_default();
    largest(&rows).into_values().fold(0.0, f64::max)
}

/// The set, and the heat of an effect of it in every fitted row.
fn of_effect(problem: &Problem, refit: &Refit, effect: usize) -> Option<(Hypothesis, Vec<Row>)> {
    let rest: Vec<usize> = refit.effects.iter().copied().filter(|&other| other != effect).collect();
    let (with, without) = (problem.hypothesis(&refit.effects, 1.0).ok()?, problem.hypothesis(&rest, 1.0).ok()?);
    let rows = rows(problem, refit, &with, &without)?;
    Some((with, rows))
}

/// The largest heat of each node.
fn largest(rows: &[Row]) -> BTreeMap<&str, f64> {
    let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
    for row in rows {
        for (node, watts) in &row.watts {
            let most = largest.entry(node).or_default();
            *most = most.max(watts.abs());
        }
    }
    largest
}

/// A node's heat by phase, or its mean over stretches of time.
fn of_node(node: &str, rows: &[Row], measurements: &[Measurement]) -> Vec<EffectHeat> {
    let mut effect_heats = Vec::new();
    for (index, measurement) in measurements.iter().enumerate() {
        let node_watts: Vec<(usize, f64)> = rows
            .iter()
            .filter(|row| row.measurement == index)
            .filter_map(|row| Some((row.row, *row.watts.get(node)?)))
            .collect();
        let one = |phase: Option<String>, time_s: Option<f64>, part: &[(usize, f64)]| EffectHeat {
            node: node.to_owned(),
            measurement: measurement.name.clone(),
            phase,
            time_s,
            watts: part.iter().map(|(_, watts)| watts).sum::<f64>() / part.len() as f64,
        };
        match &measurement.rows {
            Rows::Steady(phases) => {
                effect_heats
                    .extend(node_watts.iter().map(|part| one(Some(phases[part.0].name.clone()), None, &[*part])));
            }
            Rows::Transient { inputs, .. } => {
                for part in node_watts.chunks(node_watts.len().div_ceil(STRETCHES).max(1)) {
                    effect_heats.push(one(None, Some(inputs.times_s[part[part.len() / 2].0]), part));
                }
            }
        }
    }
    effect_heats
}

/// The heat of the effect in every fitted row. `None` where a model does not compile.
fn rows(problem: &Problem, refit: &Refit, with: &Hypothesis, without: &Hypothesis) -> Option<Vec<Row>> {
    let likelihood = with.likelihood(problem).ok()?;
    let predictor = Predictor::new(&with.model, &[]).ok()?;
    let other = Network::compile(&without.model, &[]).ok()?;
    let full = likelihood.full_parameters(&refit.unknowns);
    let value_of =
        |name: &str| with.model.parameters.iter().position(|parameter| parameter.name == name).map(|place| full[place]);
    let parameters: Vec<f64> = without
        .model
        .parameters
        .iter()
        .map(|parameter| value_of(&parameter.name).unwrap_or(parameter.nominal))
        .collect();
    // The nodes of both models, by their positions in each.
    let shared: Vec<(usize, usize)> = (without.model.nodes.iter().enumerate())
        .filter_map(|(place, node)| {
            Some((with.model.nodes.iter().position(|node_with| node_with.name == node.name)?, place))
        })
        .collect();
    let find = |name: &str| refit.names.iter().position(|unknown| unknown == name).map(|place| refit.unknowns[place]);
    let inputs: Vec<String> = with.model.inputs.iter().map(|input| input.name.clone()).collect();
    let nodes: Vec<String> = with.model.nodes.iter().map(|node| node.name.clone()).collect();
    let count = nodes.len();
    let mut workspace = predictor.workspace();
    let mut with_workspace = predictor.workspace();
    let mut others = other.workspace();
    predictor.network().set_parameters(&mut with_workspace, &full);
    other.set_parameters(&mut others, &parameters);
    let mut heat_rows = Vec::new();
    for (index, measurement) in with.measurements.iter().enumerate() {
        let fixed = with_unknowns(measurement, &inputs, &nodes, &find);
        let prediction = predictor.predict(&mut workspace, &fixed, &full);
        for row in measurement.fitted_rows() {
            let temperatures = &prediction.temperatures[row * count..(row + 1) * count];
            if temperatures.iter().any(|value| !value.is_finite()) {
                continue;
            }
            let (values, time_s) = match &fixed.rows {
                Rows::Steady(phases) => (phases[row].inputs.clone(), None),
                Rows::Transient { inputs, .. } => {
                    let values = (0..inputs.base.len()).map(|input| inputs.in_row(row, input)).collect();
                    (values, Some(inputs.times_s[row]))
                }
            };
            let mut elsewhere = vec![0.0; without.model.nodes.len()];
            for &(from, to) in &shared {
                elsewhere[to] = temperatures[from];
            }
            let heat = heat_at(predictor.network(), &mut with_workspace, &values, time_s, temperatures);
            let before = heat_at(&other, &mut others, &values, time_s, &elsewhere);
            let mut watts = BTreeMap::new();
            for old in &before {
                let Some(&(place, _)) = shared.iter().find(|(_, to)| *to == old.node) else { continue };
                let Some(new) = heat.iter().find(|new| new.node == place) else { continue };
                let share = match (old.capacity_j_per_k, new.capacity_j_per_k) {
                    (Some(old), Some(new)) if time_s.is_some() && new > 0.0 => old / new,
                    _ => 1.0,
                };
                watts.insert(nodes[place].clone(), share * new.heat_w - old.heat_w);
            }
            heat_rows.push(Row { measurement: index, row, watts });
        }
    }
    Some(heat_rows)
}

fn heat_at(
    network: &Network,
    workspace: &mut Workspace,
    inputs: &[f64],
    time_s: Option<f64>,
    temperatures: &[f64],
) -> Vec<NodeHeat> {
    network.set_inputs(workspace, inputs);
    network.set_time(workspace, time_s.unwrap_or(0.0));
    network.set_temperatures(workspace, temperatures);
    network.node_heat(workspace)
}
