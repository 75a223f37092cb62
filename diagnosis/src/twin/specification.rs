//! A network as plain data, from which both the resolved model and its file in the study format are made.

use serde_json::{Value, json};

use crate::expression::{ExprId, Graph, Names, ParseError, Scope, Symbol, parse};
use crate::random::Distribution;
use crate::thermal::element::cooler::{Cooler, Drive};
use crate::thermal::element::{Conductor, Element, ElementKind, Load, Radiation};
use crate::thermal::{Input, Limits, Model, Node, NodeKind, Parameter};

/// An input of a specification, in its own unit, which has no zero of its own and a factor of 1 (K, W, Pa, A, W/m2).
#[derive(Clone, Debug, PartialEq)]
pub struct InputSketch {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: &'static str,
    /// Nominal value.
    pub nominal: f64,
    /// Range.
    pub range: [f64; 2],
}

/// A parameter of a specification.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSketch {
    /// Name.
    pub name: String,
    /// Unit, SI.
    pub unit: &'static str,
    /// Nominal value.
    pub nominal: f64,
    /// Prior: uniform or lognormal.
    pub prior: Distribution,
}

/// What a node of a specification is.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeSketch {
    /// Temperature of a boundary, K: an expression.
    Boundary(String),
    /// Heat capacity, J/K: an expression.
    Capacity(String),
    /// No storage.
    Arithmetic,
}

/// A path of a specification.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSketch {
    /// Name.
    pub name: String,
    /// Nodes by position.
    pub between: [usize; 2],
    /// Conductance, W/K, or exchange area, m2: an expression.
    pub size: String,
}

/// A load of a specification.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadSketch {
    /// Name.
    pub name: String,
    /// Node by position.
    pub into: usize,
    /// Power, W: an expression.
    pub power: String,
}

/// A thermoelectric cooler of a specification, one stage.
#[derive(Clone, Debug, PartialEq)]
pub struct CoolerSketch {
    /// Name.
    pub name: String,
    /// Cold and hot node by position.
    pub nodes: [usize; 2],
    /// Current, A: an expression.
    pub current: String,
}

/// A network as plain data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetworkSpecification {
    /// Title.
    pub title: String,
    /// Inputs.
    pub inputs: Vec<InputSketch>,
    /// Parameters.
    pub parameters: Vec<ParameterSketch>,
    /// Nodes.
    pub nodes: Vec<(String, NodeSketch)>,
    /// Conductors.
    pub conductors: Vec<PathSketch>,
    /// Radiations.
    pub radiations: Vec<PathSketch>,
    /// Loads.
    pub loads: Vec<LoadSketch>,
    /// Coolers.
    pub coolers: Vec<CoolerSketch>,
}

/// Couples, Seebeck coefficient (V/K), resistance (ohm) and conductance (W/K) of a couple of a specification's coolers: those
/// of a small single-stage module of bismuth telluride.
const COOLER: [(&str, f64); 4] = [("couples", 17.0), ("seebeck", 4e-4), ("resistance", 0.02), ("conductance", 1.5e-3)];

impl NetworkSpecification {
    /// The resolved model without quantities, as reading the file of [`NetworkSpecification::text`] gives it.
    ///
    /// # Errors
    /// An expression that does not parse.
    pub fn model(&self) -> Result<Model, ParseError> {
        let mut model = Model { title: self.title.clone(), ..Model::default() };
        let mut names = Names::default();
        for (index, parameter) in (0u32..).zip(&self.parameters) {
            let symbol = model.graph.symbol(Symbol::Parameter(index));
            names.values.insert(parameter.name.clone(), symbol);
            model.parameters.push(Parameter {
                name: parameter.name.clone(),
                unit: parameter.unit.to_owned(),
                nominal: parameter.nominal,
                description: String::new(),
                source: String::new(),
            });
        }
        for (index, input) in (0u32..).zip(&self.inputs) {
            let symbol = model.graph.symbol(Symbol::Input(index));
            names.values.insert(input.name.clone(), symbol);
            model.inputs.push(Input {
                name: input.name.clone(),
                unit: input.unit.to_owned(),
                nominal: input.nominal,
                range: Some(input.range),
                settable: true,
                description: String::new(),
            });
        }
        let expression = |graph: &mut Graph, text: &str| parse(text, graph, &Scope::new(&names));
        for (name, node) in &self.nodes {
            let kind = match node {
                NodeSketch::Boundary(text) => NodeKind::Boundary { temperature: expression(&mut model.graph, text)? },
                NodeSketch::Capacity(text) => NodeKind::Diffusion { capacity: expression(&mut model.graph, text)? },
                NodeSketch::Arithmetic => NodeKind::Arithmetic,
            };
            model.nodes.push(Node { name: name.clone(), kind, area: None, alias: None, limits: Limits::default() });
        }
        for conductor in &self.conductors {
            let conductance = expression(&mut model.graph, &conductor.size)?;
            let kind = ElementKind::Conductor(Conductor { between: conductor.between, conductance });
            model.elements.push(Element { name: conductor.name.clone(), kind });
        }
        for radiation in &self.radiations {
            let exchange_area = expression(&mut model.graph, &radiation.size)?;
            let kind = ElementKind::Radiation(Radiation { between: radiation.between, exchange_area });
            model.elements.push(Element { name: radiation.name.clone(), kind });
        }
        for load in &self.loads {
            let power = expression(&mut model.graph, &load.power)?;
            model
                .elements
                .push(Element { name: load.name.clone(), kind: ElementKind::Load(Load { into: load.into, power }) });
        }
        for cooler in &self.coolers {
            let current = expression(&mut model.graph, &cooler.current)?;
            let [couples, seebeck, resistance, conductance]: [ExprId; 4] =
                COOLER.map(|(_, value)| model.graph.number(value));
            let lead_resistance = model.graph.number(0.0);
            let kind = ElementKind::Cooler(Cooler {
                nodes: cooler.nodes.to_vec(),
                couples: vec![couples],
                drive: Drive::Current(current),
                seebeck,
                resistance,
                conductance,
                lead_resistance,
            });
            model.elements.push(Element { name: cooler.name.clone(), kind });
        }
        Ok(model)
    }

    /// Priors of the parameters, SI.
    pub fn priors(&self) -> Vec<Distribution> {
        self.parameters.iter().map(|parameter| parameter.prior).collect()
    }

    /// The model's file in the study format: entries in their order, which is that of the resolved model.
    pub fn text(&self) -> String {
        let node = |position: usize| &self.nodes[position].0;
        let paths = |list: &[PathSketch], what: &str| {
            object(list.iter().map(|path| {
                let between = path.between.map(node);
                (&path.name, json!({"between": between, what: scalar(&path.size)}))
            }))
        };
        let inputs = object(self.inputs.iter().map(|input| {
            (&input.name, json!({"unit": input.unit, "nominal": input.nominal, "range": input.range, "settable": true}))
        }));
        let parameters = object(self.parameters.iter().map(|parameter| {
            (
                &parameter.name,
                json!({"unit": parameter.unit, "nominal": parameter.nominal, "prior": prior(&parameter.prior)}),
            )
        }));
        let nodes = object(self.nodes.iter().map(|(name, sketch)| {
            let body = match sketch {
                NodeSketch::Boundary(text) => json!({"boundary": scalar(text)}),
                NodeSketch::Capacity(text) => json!({"capacity": scalar(text)}),
                NodeSketch::Arithmetic => json!({}),
            };
            (name, body)
        }));
        let loads = object(
            self.loads.iter().map(|load| (&load.name, json!({"into": node(load.into), "power": scalar(&load.power)}))),
        );
        let coolers = object(self.coolers.iter().map(|cooler| {
            let [cold, hot] = cooler.nodes.map(node);
            let mut body = json!({"cold": cold, "hot": hot, "current": scalar(&cooler.current)});
            for (name, value) in COOLER {
                body[name] = json!(value);
            }
            (&cooler.name, body)
        }));
        let conductors = paths(&self.conductors, "conductance");
        let radiations = paths(&self.radiations, "exchange_area");
        let title = json!(self.title);
        format!(
            "{{\n\"format\": \"bmv-network/1\",\n\"title\": {title},\n\"inputs\": {inputs},\n\"parameters\": {parameters},\n\
             \"nodes\": {nodes},\n\"conductors\": {conductors},\n\"radiations\": {radiations},\n\"loads\": {loads},\n\
             \"coolers\": {coolers}\n}}\n"
        )
    }
}

/// An object with its entries in order, one a line.
pub(super) fn object<'a>(entries: impl Iterator<Item = (&'a String, Value)>) -> String {
    let lines: Vec<String> = entries.map(|(name, body)| format!("  {}: {body}", json!(name))).collect();
    if lines.is_empty() { "{}".to_owned() } else { format!("{{\n{}\n}}", lines.join(",\n")) }
}

/// An expression as the study format has it: a bare number where it is one.
fn scalar(text: &str) -> Value {
    text.parse::<f64>().map_or_else(|_| json!(text), |value| json!(value))
}

/// A prior as the study format has it, SI.
pub fn prior(distribution: &Distribution) -> Value {
    match *distribution {
        Distribution::Fixed(value) => json!({"fixed": value}),
        Distribution::Uniform { lower, upper } => json!({"uniform": [lower, upper]}),
        Distribution::LogUniform { lower, upper } => json!({"loguniform": [lower, upper]}),
        Distribution::LogNormal { median, factor } => json!({"lognormal": {"median": median, "factor": factor}}),
        Distribution::HalfNormal { scale } => json!({"halfnormal": scale}),
        Distribution::Triangular { lower, mode, upper } => json!({"triangular": [lower, mode, upper]}),
        Distribution::Normal { mean, sd, lower, upper } => {
            let mut body = json!({"mean": mean, "sd": sd});
            for (name, value) in [("lower", lower), ("upper", upper)] {
                if let Some(value) = value {
                    body[name] = json!(value);
                }
            }
            json!({"normal": body})
        }
    }
}
