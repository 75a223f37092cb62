//! A network compiled for solving, and the workspace in which it is solved.
//!
//! `C_i(T_i) dT_i/dt = r_i(T)`, the balance `r_i` being the sum of the elements' heat into node `i` (W). Compilation
//! checks the model, chooses the unknowns and turns balances, slopes and quantities into instructions.

use std::sync::OnceLock;

use thiserror::Error;

use crate::expression::Symbol;
use crate::math::lanes::Lanes;

use super::connectivity::isolated_nodes;
use super::equations::{Equations, segment};
use super::external::External;
use super::linear::Linear;
use super::model::{Model, QuantityValue};

/// A model that cannot be compiled.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NetworkError {
    /// A boundary temperature that follows from other temperatures.
    #[error("boundary node `{node}`: its temperature may depend on parameters, inputs and time only")]
    BoundaryNotGiven {
        /// The node.
        node: String,
    },
    /// A constant capacity that is not positive.
    #[error("node `{node}`: heat capacity {capacity} J/K is not above 0")]
    Capacity {
        /// The node.
        node: String,
        /// The capacity, J/K.
        capacity: f64,
    },
    /// A capacity that depends on another node's temperature.
    #[error("node `{node}`: its heat capacity depends on the temperature of `{other}`, only its own is allowed")]
    CapacityDependsOnOther {
        /// The node.
        node: String,
        /// The other node.
        other: String,
    },
    /// An element that is not made as its kind must be.
    #[error("{kind} `{element}` {reason}")]
    Malformed {
        /// The kind.
        kind: &'static str,
        /// The element.
        element: String,
        /// What is wrong with it.
        reason: String,
    },
    /// An element that names a node that does not exist.
    #[error("element `{element}`: node {node} of {nodes} does not exist")]
    UnknownNode {
        /// The element.
        element: String,
        /// The node's index.
        node: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// An expression with a value that nobody supplies.
    #[error("an expression depends on values that are not known here: {symbols}")]
    UnboundValue {
        /// The symbols.
        symbols: String,
    },
    /// The matrix of slopes could not be laid out.
    #[error("the matrix of slopes cannot be laid out: {reason}")]
    Matrix {
        /// Why.
        reason: String,
    },
}

/// A compiled network.
#[derive(Clone, Debug)]
pub struct Network {
    pub(super) steady: Equations,
    /// The form with modes, where the model has thermostats.
    pub(super) switched: Option<Equations>,
    pub(super) linear: Linear<f64>,
    /// Matrix of transients, made for the first of them.
    transient_linear: OnceLock<Linear<f64>>,
    pub(super) nodes: Vec<String>,
    pub(super) nominal_parameters: Vec<f64>,
    pub(super) nominal_inputs: Vec<f64>,
    pub(super) quantities: Vec<QuantityValue>,
    pub(super) differentiate: Vec<Symbol>,
    /// What answers in place of equations.
    pub(super) external: Option<External>,
    isolated_nodes: Option<Vec<String>>,
}

/// Room for a solution: registers, vectors and factors, made once and used for many solves.
#[derive(Clone, Debug)]
pub struct Workspace {
    pub(super) state: State<f64>,
    /// Temperatures of all nodes, K.
    pub(super) temperatures: Vec<f64>,
    pub(super) linear: Linear<f64>,
    /// Which segments must run again.
    pub(super) stale_parameters: bool,
    pub(super) stale_inputs: bool,
    /// Whether the temperatures are a solution for the present parameters and inputs.
    pub(super) solved: bool,
    /// Whether `linear` holds the factors at the solution.
    pub(super) factored: bool,
    /// Rows of the unknowns whose temperatures were held in the last solve; empty: none.
    pub(super) held: Vec<bool>,
}

/// Registers and vectors of a solve, per lane.
#[derive(Clone, Debug)]
pub(super) struct State<V> {
    pub file: Vec<V>,
    pub step: Vec<V>,
}

impl<V: Lanes> State<V> {
    pub fn new(equations: &Equations) -> Self {
        Self { file: equations.program.registers(), step: vec![V::splat(0.0); equations.size()] }
    }
}

impl Network {
    /// Compiles a model. `differentiate` lists the parameters and inputs with respect to which derivatives will be
    /// asked; `Symbol::Node(i)` among them means the start temperature of node `i` in a transient.
    ///
    /// # Errors
    /// [`NetworkError`] names what is wrong with the model.
    pub fn compile(model: &Model, differentiate: &[Symbol]) -> Result<Self, NetworkError> {
        // Quantities of a model that is asked outside are differentiated by its outputs too.
        let outputs = model.external.as_ref().map_or(0, |external| u32::try_from(external.outputs).unwrap_or(u32::MAX));
        let of_quantities: Vec<Symbol> =
            differentiate.iter().copied().chain((0..outputs).map(Symbol::Output)).collect();
        let steady = Equations::compile(model, &of_quantities, false)?;
        let switched = model.elements.iter().any(|element| element.physics().is_switched());
        let switched = if switched { Some(Equations::compile(model, differentiate, true)?) } else { None };
        let linear = Linear::new(&steady)?;
        Ok(Self {
            external: model.external.clone(),
            isolated_nodes: isolated_nodes(model),
            linear,
            transient_linear: OnceLock::new(),
            steady,
            switched,
            nodes: model.nodes.iter().map(|node| node.name.clone()).collect(),
            nominal_parameters: model.parameters.iter().map(|p| p.nominal).collect(),
            nominal_inputs: model.inputs.iter().map(|i| i.nominal).collect(),
            quantities: model.quantities.iter().map(|q| q.value).collect(),
            differentiate: differentiate.to_vec(),
        })
    }

    /// Names of nodes without a path to a boundary: such a network has no steady state (a transient has a solution).
    pub fn isolated_nodes(&self) -> Option<&[String]> {
        self.isolated_nodes.as_deref()
    }

    /// What answers in place of equations, where the model is not a network.
    pub fn external(&self) -> Option<&External> {
        self.external.as_ref()
    }

    /// Number of nodes, boundaries included.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Number of unknown temperatures.
    pub fn unknowns(&self) -> usize {
        self.steady.size()
    }

    /// Number of quantities.
    pub fn quantities(&self) -> usize {
        self.quantities.len()
    }

    /// The symbols of the derivatives, in the order given to [`Network::compile`].
    pub fn differentiated(&self) -> &[Symbol] {
        &self.differentiate
    }

    /// Nominal parameters, SI.
    pub fn nominal_parameters(&self) -> &[f64] {
        &self.nominal_parameters
    }

    /// Nominal inputs, SI.
    pub fn nominal_inputs(&self) -> &[f64] {
        &self.nominal_inputs
    }

    /// Room for the matrices of transients.
    pub(super) fn transient_linear(&self) -> Linear<f64> {
        let made = || match &self.switched {
            Some(equations) => Linear::new(equations).unwrap_or_else(|_| self.linear.clone()).in_turn(equations),
            None => self.linear.in_turn(&self.steady),
        };
        self.transient_linear.get_or_init(made).clone()
    }

    /// A workspace at the nominal parameters and inputs.
    pub fn workspace(&self) -> Workspace {
        let mut workspace = Workspace {
            state: State::new(&self.steady),
            temperatures: vec![0.0; self.nodes.len()],
            linear: self.linear.clone(),
            stale_parameters: true,
            stale_inputs: true,
            solved: false,
            factored: false,
            held: Vec::new(),
        };
        self.set_parameters(&mut workspace, &self.nominal_parameters);
        self.set_inputs(&mut workspace, &self.nominal_inputs);
        workspace
    }

    /// Sets all parameters, SI, in the model's order; missing ones keep their value.
    pub fn set_parameters(&self, workspace: &mut Workspace, values: &[f64]) {
        let count = values.len().min(self.steady.parameters);
        workspace.state.file[..count].copy_from_slice(&values[..count]);
        workspace.stale_parameters = true;
        workspace.solved = false;
    }

    /// Sets all inputs, SI, in the model's order; missing ones keep their value.
    pub fn set_inputs(&self, workspace: &mut Workspace, values: &[f64]) {
        let count = values.len().min(self.steady.inputs);
        let from = self.steady.parameters;
        workspace.state.file[from..from + count].copy_from_slice(&values[..count]);
        workspace.stale_inputs = true;
        workspace.solved = false;
    }

    /// Sets the instant at which expressions of time are evaluated, s (0 in a new workspace).
    pub fn set_time(&self, workspace: &mut Workspace, time_s: f64) {
        workspace.state.file[self.steady.time()] = time_s;
        workspace.stale_inputs = true;
        workspace.solved = false;
    }

    /// Runs what follows from parameters and inputs alone, where they changed, and fills in the boundaries.
    pub(super) fn refresh(&self, workspace: &mut Workspace) {
        let program = &self.steady.program;
        let file = &mut workspace.state.file;
        if workspace.stale_parameters {
            program.run(segment::PARAMETERS, file);
        }
        if workspace.stale_parameters || workspace.stale_inputs {
            for part in [segment::INPUTS, segment::INSTANT, segment::BOUNDARY] {
                program.run(part, file);
            }
            for &(node, register) in &self.steady.boundaries {
                workspace.temperatures[node] = file[register.index()];
            }
            workspace.stale_parameters = false;
            workspace.stale_inputs = false;
        }
    }

    /// Value of a quantity in the present state, SI; of a maximum, minimum or mean over time the value now.
    pub fn quantity(&self, workspace: &Workspace, index: usize) -> f64 {
        workspace.state.file[self.steady.quantity[index].index()]
    }
}

impl Workspace {
    /// Temperatures of all nodes in the model's order, boundaries included, K.
    pub fn temperatures(&self) -> &[f64] {
        &self.temperatures
    }
}
