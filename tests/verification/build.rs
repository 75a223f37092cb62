//! Models built in code, for the verification cases.

use bmv::expression::{Binary, ExprId, Graph, Symbol, Unary};
use bmv::thermal::element::{Conductor, Element, ElementKind, Flow, Heater, HeaterControl, Load, Radiation};
use bmv::thermal::{Input, Limits, Model, Node, NodeKind, Parameter, Quantity, QuantityValue};

/// A model under construction, with short hands for expressions.
#[derive(Default)]
pub struct Build {
    pub model: Model,
}

impl Build {
    pub fn graph(&mut self) -> &mut Graph {
        &mut self.model.graph
    }
    pub fn n(&mut self, value: f64) -> ExprId {
        self.model.graph.number(value)
    }
    pub fn time(&mut self) -> ExprId {
        self.model.graph.symbol(Symbol::Time)
    }
    pub fn t(&mut self, node: usize) -> ExprId {
        self.model.graph.symbol(Symbol::Node(node as u32))
    }
    pub fn add(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.model.graph.add(a, b)
    }
    pub fn sub(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.model.graph.subtract(a, b)
    }
    pub fn mul(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.model.graph.multiply(a, b)
    }
    pub fn scale(&mut self, factor: f64, a: ExprId) -> ExprId {
        let factor = self.n(factor);
        self.mul(factor, a)
    }
    pub fn cos(&mut self, a: ExprId) -> ExprId {
        self.model.graph.unary(Unary::Cos, a)
    }
    pub fn sin(&mut self, a: ExprId) -> ExprId {
        self.model.graph.unary(Unary::Sin, a)
    }
    pub fn max0(&mut self, a: ExprId) -> ExprId {
        let zero = self.n(0.0);
        self.model.graph.binary(Binary::Maximum, zero, a)
    }
    pub fn parameter(&mut self, name: &str, nominal: f64) -> ExprId {
        let index = self.model.parameters.len() as u32;
        self.model.parameters.push(Parameter {
            name: name.into(),
            unit: String::new(),
            nominal,
            description: String::new(),
            source: String::new(),
        });
        self.model.graph.symbol(Symbol::Parameter(index))
    }
    pub fn input(&mut self, name: &str, nominal: f64) -> ExprId {
        let index = self.model.inputs.len() as u32;
        self.model.inputs.push(Input {
            name: name.into(),
            unit: String::new(),
            nominal,
            range: None,
            settable: true,
            description: String::new(),
        });
        self.model.graph.symbol(Symbol::Input(index))
    }
    fn node(&mut self, name: &str, kind: NodeKind) -> usize {
        self.model.nodes.push(Node { name: name.into(), kind, area: None, alias: None, limits: Limits::default() });
        self.model.nodes.len() - 1
    }
    pub fn diffusion(&mut self, name: &str, capacity: f64) -> usize {
        let capacity = self.n(capacity);
        self.node(name, NodeKind::Diffusion { capacity })
    }
    pub fn diffusion_of(&mut self, name: &str, capacity: ExprId) -> usize {
        self.node(name, NodeKind::Diffusion { capacity })
    }
    pub fn arithmetic(&mut self, name: &str) -> usize {
        self.node(name, NodeKind::Arithmetic)
    }
    pub fn boundary(&mut self, name: &str, temperature: ExprId) -> usize {
        self.node(name, NodeKind::Boundary { temperature })
    }
    pub fn element(&mut self, name: &str, kind: ElementKind) {
        self.model.elements.push(Element { name: name.into(), kind });
    }
    pub fn conductor(&mut self, name: &str, between: [usize; 2], conductance: ExprId) {
        self.element(name, ElementKind::Conductor(Conductor { between, conductance }));
    }
    pub fn radiation(&mut self, name: &str, between: [usize; 2], exchange_area: ExprId) {
        self.element(name, ElementKind::Radiation(Radiation { between, exchange_area }));
    }
    pub fn load(&mut self, name: &str, into: usize, power: ExprId) {
        self.element(name, ElementKind::Load(Load { into, power }));
    }
    #[allow(dead_code)]
    pub fn flow(&mut self, name: &str, between: [usize; 2], heat: ExprId) {
        self.element(name, ElementKind::Flow(Flow { between, heat, one_way: false }));
    }
    pub fn thermostat(&mut self, name: &str, into: usize, power: ExprId, on: ExprId, off: ExprId) {
        let control = HeaterControl::Thermostat { on, off };
        self.element(name, ElementKind::Heater(Heater { into, senses: into, power, control }));
    }
    /// Quantity of an element's heat, current or whatever `pick` takes from its contribution.
    pub fn quantity(&mut self, name: &str, id: ExprId) {
        self.model.quantities.push(Quantity {
            name: name.into(),
            unit: String::new(),
            is_temperature: false,
            value: QuantityValue::Instant(id),
        });
    }
    pub fn temperature(&mut self, name: &str, node: usize) {
        let id = self.t(node);
        self.quantity(name, id);
    }
}

/// The radiator of the first case study: one node, one side radiating to a sink.
/// Parameters: Q, eps, alpha, q_sun, theta, q_alb, q_IR; the quantity is its temperature.
pub fn radiator() -> Model {
    let mut b = Build::default();
    let q = b.parameter("Q", 100.0);
    let eps = b.parameter("eps", 0.85);
    let alpha = b.parameter("alpha", 0.2);
    let q_sun = b.parameter("q_sun", 1367.0);
    let theta = b.parameter("theta", 80.0 * std::f64::consts::PI / 180.0);
    let q_alb = b.parameter("q_alb", 15.0);
    let q_ir = b.parameter("q_IR", 20.0);
    let sink = b.n(3.0);
    let radiator = b.diffusion("radiator", 1350.0);
    let sink = b.boundary("sink", sink);
    let area = 0.3;
    let emitting = b.scale(area, eps);
    b.radiation("to sink", [radiator, sink], emitting);
    b.load("dissipation", radiator, q);
    let cosine = b.cos(theta);
    let direct = b.mul(q_sun, cosine);
    let solar = b.add(direct, q_alb);
    let solar = b.mul(alpha, solar);
    let infrared = b.mul(eps, q_ir);
    let absorbed = b.add(solar, infrared);
    let absorbed = b.scale(area, absorbed);
    b.load("absorbed", radiator, absorbed);
    b.temperature("T", radiator);
    b.model
}

/// The solar X-ray monitor of the second case study, from its study in `tests/verification/sxm`. Parameters: Gh, Gsub,
/// Gb, Gth, Glead, Gpre, Gap, Gharn, e*, seebeck, resistance, conductance, then five more. Inputs: T_orex, V, q_sun, T_sky.
/// Quantities: the nine temperatures, the current, heat out of the cold side.
pub fn sxm() -> Model {
    let pass = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/verification/sxm/pass-1.json");
    match bmv::job::load(&pass) {
        Ok(pass) => pass.model,
        Err(_) => panic!("{} does not load", pass.display()),
    }
}
