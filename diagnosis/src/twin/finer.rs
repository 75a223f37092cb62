//! A truth whose network is finer than the believed one: nodes with gradients, paths that end at other spots of a node than
//! its sensor sits at, exchange areas that are wrong. A believed model is then a little wrong everywhere.

use std::collections::HashMap;

use super::draw::Draw;
use super::inject::InjectError;
use super::world::World;
use crate::diagnosis::Problem;
use crate::expression::{Binary, ExprId, Symbol, Unary};
use crate::thermal::element::sign::EXCHANGE_AREA;
use crate::thermal::element::{Conductor, Element, ElementKind};
use crate::thermal::{Limits, Node, NodeKind, QuantityValue};

/// Least resistance between pieces of a node, K/W: 1 W makes a microkelvin.
const LEAST_RESISTANCE_K_PER_W: f64 = 1e-6;
/// Most pieces of a node.
const MOST_PIECES: usize = 5;
/// Largest error of an exchange area, in the logarithm.
const LARGEST_ERROR: f64 = 0.2;

/// Pieces of the nodes, and where things are on them.
#[derive(Clone, Debug)]
pub(super) struct Finer {
    /// By node of the believed model: resistances from its first piece to each other one, relative; none where it is one.
    pieces: Vec<Vec<f64>>,
    /// By node: where its sensors are, a share of its pieces.
    sensors: Vec<f64>,
    /// By element: where its ends are, shares of the pieces there.
    ends: Vec<[f64; 2]>,
    /// By element: error of an exchange area in the logarithm, relative.
    errors: Vec<f64>,
}

/// Elements beyond those of the model that a finer network knows: those of hidden effects.
const MORE_ELEMENTS: usize = 8;

impl Finer {
    /// Two to five pieces of every node that stores heat.
    pub fn draw(problem: &Problem, draw: &mut Draw) -> Self {
        let model = &problem.model;
        let pieces = (model.nodes.iter())
            .map(|node| match node.kind {
                NodeKind::Diffusion { .. } => (1..draw.whole(2, MOST_PIECES)).map(|_| draw.scale(0.3, 3.0)).collect(),
                NodeKind::Boundary { .. } | NodeKind::Arithmetic => Vec::new(),
            })
            .collect();
        let elements = model.elements.len() + MORE_ELEMENTS;
        Self {
            pieces,
            sensors: model.nodes.iter().map(|_| draw.share()).collect(),
            ends: (0..elements).map(|_| [draw.share(), draw.share()]).collect(),
            errors: (0..elements).map(|_| draw.normal()).collect(),
        }
    }
}

/// The place at this share of a list.
fn at(list: &[usize], share: f64) -> usize {
    list[((share * list.len() as f64) as usize).min(list.len() - 1)]
}

impl World {
    /// Makes a network finer, of which the resistances within its nodes are 0 K/W at first and the exchange areas right.
    ///
    /// # Errors
    /// [`InjectError::NoPlace`] where no node stores heat.
    pub(super) fn refine(&mut self, finer: &Finer) -> Result<(), InjectError> {
        if finer.pieces.iter().all(Vec::is_empty) {
            return Err(InjectError::NoPlace);
        }
        let coarseness = self.add_parameter("hidden.coarseness", 0.0);
        self.coarseness = Some(coarseness);
        let coarseness = Symbol::Parameter(u32::try_from(coarseness).unwrap_or(u32::MAX));
        let coarseness = self.hypothesis.model.graph.symbol(coarseness);
        let mut spots: Vec<Vec<usize>> = (0..self.hypothesis.model.nodes.len()).map(|node| vec![node]).collect();
        let mut paths = Vec::new();
        for (node, relative) in finer.pieces.iter().enumerate() {
            let NodeKind::Diffusion { capacity } = self.hypothesis.model.nodes[node].kind else { continue };
            let graph = &mut self.hypothesis.model.graph;
            let share = graph.number(1.0 / (1.0 + relative.len() as f64));
            let capacity = graph.multiply(share, capacity);
            self.hypothesis.model.nodes[node].kind = NodeKind::Diffusion { capacity };
            for relative in relative {
                let piece = self.add_piece(node, capacity);
                spots[node].push(piece);
                paths.push(self.path_within(node, piece, coarseness, *relative));
            }
        }
        self.move_sensors(finer, &spots);
        self.move_paths(finer, &spots, coarseness);
        self.hypothesis.model.elements.append(&mut paths);
        Ok(())
    }

    fn add_piece(&mut self, node: usize, capacity: ExprId) -> usize {
        let piece = self.hypothesis.model.nodes.len();
        self.hypothesis.model.nodes.push(Node {
            name: format!("hidden piece {piece}"),
            kind: NodeKind::Diffusion { capacity },
            area: None,
            alias: None,
            limits: Limits::default(),
        });
        for measurement in &mut self.hypothesis.measurements {
            measurement.begin_like(piece, node);
        }
        piece
    }

    fn path_within(&mut self, node: usize, piece: usize, coarseness: ExprId, relative: f64) -> Element {
        let graph = &mut self.hypothesis.model.graph;
        let [relative, least, one] = [relative, LEAST_RESISTANCE_K_PER_W, 1.0].map(|value| graph.number(value));
        let resistance = graph.multiply(relative, coarseness);
        let resistance = graph.binary(Binary::Maximum, resistance, least);
        let conductance = graph.divide(one, resistance);
        let kind = ElementKind::Conductor(Conductor { between: [node, piece], conductance });
        Element { name: format!("hidden path {piece}"), kind }
    }

    fn move_sensors(&mut self, finer: &Finer, spots: &[Vec<usize>]) {
        let model = &mut self.hypothesis.model;
        let mut symbol = |node: usize| model.graph.symbol(Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX)));
        let moved: HashMap<ExprId, ExprId> = (spots.iter().zip(&finer.sensors).enumerate())
            .map(|(node, (spots, share))| (symbol(node), symbol(at(spots, *share))))
            .collect();
        for quantity in &mut model.quantities {
            if let QuantityValue::Instant(value) = &mut quantity.value {
                *value = model.graph.substitute(&[*value], &moved)[0];
            }
        }
    }

    fn move_paths(&mut self, finer: &Finer, spots: &[Vec<usize>], coarseness: ExprId) {
        let model = &mut self.hypothesis.model;
        let [lower, upper] = [-LARGEST_ERROR, LARGEST_ERROR].map(|value| model.graph.number(value));
        for ((element, ends), error) in model.elements.iter_mut().zip(&finer.ends).zip(&finer.errors) {
            if !element.physics().is_passive() {
                continue;
            }
            let physics = element.kind.physics_mut();
            let is_radiative = physics.sign_constraints().iter().any(|sign| sign.what == EXCHANGE_AREA);
            if let Some(exchange_area) = physics.scaled().filter(|_| is_radiative) {
                // 1 K/W within the nodes goes with 10 % of error.
                let error = model.graph.number(0.1 * error);
                let error = model.graph.multiply(error, coarseness);
                let error = model.graph.binary(Binary::Maximum, error, lower);
                let error = model.graph.binary(Binary::Minimum, error, upper);
                let factor = model.graph.unary(Unary::Exp, error);
                *exchange_area = model.graph.multiply(factor, *exchange_area);
            }
            let Some(between) = physics.between_mut() else { continue };
            for (end, share) in between.iter_mut().zip(ends) {
                *end = spots.get(*end).map_or(*end, |spots| at(spots, *share));
            }
        }
    }
}
