//! The temperatures about which the hardware worked: reference temperatures of what changes with temperature.
//!
//! Data sheets state properties at 20 degC, and models of hardware near it hold these. What works far from it has a property of its own
//! there, to which no straight line leads from room temperature: the conductance of a strap at 150 K is known at 150 K, and a law by which
//! it changes leaves it as it is there.

use std::sync::Arc;

use crate::diagnosis::Problem;
use crate::diagnosis::channel::median;
use crate::effect::{Candidate, PlaceKind, REFERENCE_K, Site};
use crate::expression::unit::CELSIUS_ZERO_K;
use crate::expression::{ExprId, Symbol, Term};
use crate::measurement::Measurement;
use crate::thermal::{Model, NodeKind, Quantity};

/// Places that work so near [`REFERENCE_K`] have it as their reference: a line through 20 degC holds there.
const NEAR_K: f64 = 60.0;
/// Other reference temperatures are multiples of it in degrees Celsius: a property does not change much within it.
const ROUNDED_TO_K: f64 = 10.0;

/// Temperature about which each node of a model worked in the rows that are fitted, K: the median of its readings, of a boundary
/// without a sensor of what is stated or logged; else the mean of the neighbours' for which it is known. `None` where nothing is.
pub fn working_temperatures_k(model: &Model, measurements: &[Measurement]) -> Vec<Option<f64>> {
    let mut readings: Vec<Vec<f64>> = vec![Vec::new(); model.nodes.len()];
    for measurement in measurements {
        for (position, sensor) in measurement.sensors.iter().enumerate() {
            let node = model.quantities.get(sensor.quantity).and_then(|quantity| node_of(model, quantity));
            if let Some(own) = node.and_then(|node| readings.get_mut(node)) {
                own.extend(measurement.fitted_rows().filter_map(|row| measurement.reading(row, position)));
            }
        }
    }
    let mut known: Vec<Option<f64>> = readings.into_iter().map(median).collect();
    for (node, known) in model.nodes.iter().zip(&mut known) {
        if let (NodeKind::Boundary { temperature }, None) = (&node.kind, &known) {
            *known = boundary_k(model, measurements, *temperature);
        }
    }
    spread(model, &mut known);
    known
}

/// The same of a model to which nodes were added: they work about the temperatures of their neighbours.
pub(crate) fn extended(model: &Model, known: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut all = known.to_vec();
    all.resize(model.nodes.len(), None);
    spread(model, &mut all);
    all
}

/// The node whose temperature a sensor reads, a fault of the sensor aside.
fn node_of(model: &Model, quantity: &Quantity) -> Option<usize> {
    let symbols = model.graph.symbols(quantity.value.expression());
    let mut nodes = symbols.iter().filter_map(|symbol| match symbol {
        Symbol::Node(node) => Some(*node as usize),
        _ => None,
    });
    let only = nodes.next().filter(|_| quantity.is_temperature)?;
    nodes.all(|other| other == only).then_some(only)
}

/// Temperature of a boundary that is a number or an input.
fn boundary_k(model: &Model, measurements: &[Measurement], temperature: ExprId) -> Option<f64> {
    let Term::Symbol(Symbol::Input(input)) = model.graph.term(temperature) else {
        return model.graph.constant(temperature);
    };
    let of = |measurement: &Measurement| -> Vec<f64> {
        let levels = measurement.fitted_rows().filter_map(|row| measurement.level(model, row, input as usize));
        levels.collect()
    };
    median(measurements.iter().flat_map(of).collect())
}

/// Gives nodes without a temperature the mean of their neighbours', those next to a known one first. What is seen through radiation
/// alone, as deep space, says nothing of a part.
fn spread(model: &Model, known: &mut [Option<f64>]) {
    loop {
        let mut sums = vec![(0.0, 0usize); known.len()];
        for element in &model.elements {
            let Some(ends) = element.kind.physics().between() else { continue };
            let is_radiation = PlaceKind::Radiation.is_element(element);
            for [from, to] in [ends, [ends[1], ends[0]]] {
                let is_boundary = matches!(model.nodes[from].kind, NodeKind::Boundary { .. });
                if let (Some(temperature), None) = (known[from], known[to])
                    && !(is_radiation && is_boundary)
                {
                    sums[to] = (sums[to].0 + temperature, sums[to].1 + 1);
                }
            }
        }
        let mut is_complete = true;
        for (known, (sum, count)) in known.iter_mut().zip(sums).filter(|(_, (_, count))| *count > 0) {
            *known = Some(sum / count as f64);
            is_complete = false;
        }
        if is_complete {
            return;
        }
    }
}

impl Problem {
    /// Takes the temperatures about which the hardware worked from the readings that it has now.
    pub(crate) fn work_where_read(&mut self) {
        if !self.working_temperatures_k.is_empty() {
            self.working_temperatures_k = Arc::new(working_temperatures_k(&self.model, &self.measurements));
        }
    }

    /// Reference temperature of an effect at a place, K: [`REFERENCE_K`] where the place worked within 60 K of it, and where nothing
    /// tells; else the temperature about which it worked, to 10 degC. Of a path it is the mean of its ends', of radiation the hotter
    /// end's, from which most of the heat comes; of several places their mean.
    pub fn reference_k(&self, candidate: &Candidate) -> f64 {
        let at = |node: &usize| self.working_temperatures_k.get(*node).copied().flatten();
        let is_boundary = |node: &usize| matches!(self.model.nodes[*node].kind, NodeKind::Boundary { .. });
        let of_element = |element: &usize| {
            let element = self.model.elements.get(*element)?;
            let physics = element.kind.physics();
            let nodes = physics.between().map_or_else(|| physics.heated().into_iter().collect(), Vec::from);
            let all: Vec<f64> = nodes.iter().filter_map(at).collect();
            // A boundary alone, as deep space, says nothing of what sees it.
            let known = if all.len() == nodes.len() {
                all
            } else {
                nodes.iter().filter(|node| !is_boundary(node)).filter_map(at).collect()
            };
            if PlaceKind::Radiation.is_element(element) { known.into_iter().reduce(f64::max) } else { mean(known) }
        };
        let places: Vec<f64> = match &candidate.site {
            Site::Elements(elements) => elements.iter().filter_map(of_element).collect(),
            Site::Nodes(nodes) => nodes.iter().filter_map(|(node, _)| at(node)).collect(),
            Site::Pair(_) | Site::Sensors(_) | Site::Parameter(_) => Vec::new(),
        };
        let rounded = |mean: f64| CELSIUS_ZERO_K + ROUNDED_TO_K * ((mean - CELSIUS_ZERO_K) / ROUNDED_TO_K).round();
        let far = mean(places).filter(|mean| (mean - REFERENCE_K).abs() > NEAR_K);
        far.map_or(REFERENCE_K, rounded)
    }

    /// The same where the effect refers to a temperature that is not [`REFERENCE_K`], so that a pass has to state it.
    pub fn stated_reference_k(&self, candidate: &Candidate) -> Option<f64> {
        let effect = self.catalogue.get(&candidate.effect)?;
        Some(self.reference_k(candidate)).filter(|&own| own != REFERENCE_K && effect.has_reference())
    }
}

fn mean(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
