//! A thermal model as another tool wrote it, in SI units: kelvin, watt, joule, metre, second.

/// A thermal model read from a deck.
///
/// Names are unique within their list. Names of inputs, parameters and tables are identifiers (a letter or `_`, then
/// letters, digits and `_`), since expressions contain them; other names are the deck's own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Deck {
    /// The deck's title, or its file's name.
    pub title: String,
    /// The tool that wrote it, with its version where the deck tells it: `SINDA/FLUINT 6.2`.
    pub tool: String,
    /// The deck's own Stefan-Boltzmann constant in W/(m2 K4), if it states one. Exchange areas are the deck's, so that
    /// the heat that it computes is `stefan_boltzmann * exchange_area * (Ta^4 - Tb^4)`.
    pub stefan_boltzmann: Option<f64>,
    /// What varies in time or from case to case.
    pub inputs: Vec<Input>,
    /// Numbers with a name: symbols, contacts, materials.
    pub parameters: Vec<Parameter>,
    /// Piecewise linear functions of one variable, constant beyond their ends.
    pub tables: Vec<Table>,
    /// Nodes in the deck's order.
    pub nodes: Vec<Node>,
    /// Conductors and radiative exchanges. A pair of nodes may occur several times: the heats add.
    pub couplings: Vec<Coupling>,
    /// Heat into nodes.
    pub loads: Vec<Load>,
    /// Heaters that a thermostat switches.
    pub heaters: Vec<Heater>,
    /// Nodes or couplings that belong together: submodels, materials.
    pub groups: Vec<Group>,
    /// Inputs and temperatures over time that stand in the deck or in a result beside it.
    pub record: Option<Record>,
    /// What was assumed, converted or left out.
    pub notes: Vec<Note>,
}

/// A value of a deck.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number in SI units.
    Number(f64),
    /// A parameter times a number.
    Scaled {
        /// The parameter's name.
        parameter: String,
        /// What it is multiplied by.
        factor: f64,
    },
    /// An expression of inputs, parameters and tables with `+ - * / ^ ( )`, `exp log sqrt sin cos tanh min max abs step
    /// smoothstep clamp interp(table, x)`, `pi`, `t` (time in s); of `T` in a load or a capacity (its node's
    /// temperature in K), of `Ta` and `Tb` in a coupling (those of [`Coupling::between`]).
    Expression(String),
}

/// A quantity that varies in time or from case to case.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// Identifier.
    pub name: String,
    /// Unit as the study format writes it: `W`, `K`, `deg`, `1`.
    pub unit: String,
    /// Value where nothing else is said: the mean over the record where there is one.
    pub nominal: f64,
    /// What it is, for people.
    pub description: String,
}

/// A number with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Identifier.
    pub name: String,
    /// Unit: `W/K`, `1`, `W`, `J/K`.
    pub unit: String,
    /// The deck's value.
    pub nominal: f64,
    /// What it is, with the deck's own name of it.
    pub description: String,
}

/// A piecewise linear function.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Identifier.
    pub name: String,
    /// Abscissae, rising.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
}

/// A node.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The deck's name, unique: `SUB.12`, `12`, `1dpamzt`.
    pub name: String,
    /// What the deck calls it for people.
    pub label: Option<String>,
    /// Its kind.
    pub kind: NodeKind,
    /// Temperature at the start in K.
    pub initial_temperature_k: Option<f64>,
}

/// How a node's temperature comes about.
#[derive(Debug, Clone, PartialEq)]
pub enum NodeKind {
    /// It stores heat.
    Diffusion {
        /// Heat capacity in J/K.
        capacity: Value,
    },
    /// Its balance closes at every instant.
    Arithmetic,
    /// It is given.
    Boundary {
        /// Temperature in K.
        temperature: Value,
    },
}

/// The law of a coupling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CouplingKind {
    /// Heat = conductance (Ta - Tb); the value is in W/K.
    Linear,
    /// Heat = sigma exchange_area (Ta^4 - Tb^4); the value is in m2.
    Radiative,
    /// Heat into the second node alone = conductance (Ta - Tb), taken from nowhere: a flow's upstream coupling. W/K.
    OneWay,
}

/// A heat exchange between two nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// The deck's name, unique among couplings: `SUB.12`, `GL(3,7)`.
    pub name: String,
    /// Its law.
    pub kind: CouplingKind,
    /// Indices into [`Deck::nodes`].
    pub between: [usize; 2],
    /// Conductance in W/K or exchange area in m2.
    pub value: Value,
}

/// Heat into a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// The deck's name, unique among loads.
    pub name: String,
    /// Index into [`Deck::nodes`].
    pub into: usize,
    /// Power in W.
    pub power: Value,
}

/// A heater that a thermostat switches. In a steady state its power falls linearly from all of it at `on_below_k` to none at
/// `off_above_k`, the average of its cycling.
#[derive(Debug, Clone, PartialEq)]
pub struct Heater {
    /// The deck's name, unique among heaters.
    pub name: String,
    /// Index into [`Deck::nodes`] of the node that is heated.
    pub into: usize,
    /// Index into [`Deck::nodes`] of the node whose temperature switches it.
    pub senses: usize,
    /// Power in W when it is on.
    pub power: Value,
    /// It switches on below this temperature, in K.
    pub on_below_k: f64,
    /// It switches off above this temperature, in K.
    pub off_above_k: f64,
}

/// What belongs together.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The deck's name of it.
    pub name: String,
    /// Indices into [`Deck::nodes`]; empty in a group of couplings.
    pub nodes: Vec<usize>,
    /// Indices into [`Deck::couplings`], of one kind; empty in a group of nodes.
    pub couplings: Vec<usize>,
}

/// Inputs and temperatures at instants.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    /// Instants in s, rising; a single one in a steady result.
    pub times_s: Vec<f64>,
    /// Whether the rows are a steady result each, not instants of one transient.
    pub is_steady: bool,
    /// `inputs[i][row]`, in the order of [`Deck::inputs`] and their units. Linear between rows, unless `held`.
    pub inputs: Vec<Vec<f64>>,
    /// Whether inputs keep a row's value until the next one.
    pub held: bool,
    /// `temperatures_k[n][row]`, in the order of [`Deck::nodes`]; an empty list for a node without a result.
    pub temperatures_k: Vec<Vec<f64>>,
}

/// What a reader says of a deck beside what it read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// File and line, where it has one: `case0.cc:120`.
    pub place: Option<String>,
    /// A sentence.
    pub message: String,
    /// Names of the nodes whose heat it concerns, in the deck's words.
    pub nodes: Vec<String>,
}

impl Note {
    /// On the deck as a whole.
    pub fn new(message: impl Into<String>) -> Self {
        Self { place: None, message: message.into(), nodes: Vec::new() }
    }

    /// At a file, or at a line of one.
    pub fn at(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self { place: Some(place.into()), ..Self::new(message) }
    }

    /// The same as one that concerns the heat of a node.
    pub fn of_node(mut self, name: &str) -> Self {
        self.nodes.push(name.to_owned());
        self
    }
}
