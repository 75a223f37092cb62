//! Models built in code, for the verification cases.

use bmv::expression::{Binary, ExprId, Graph, Symbol, Unary};
use bmv::thermal::element::{
    Conductor, Element, ElementKind, Flow, Heater, HeaterControl, Load, Radiation,
    cooler::{Cooler, Drive},
};
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
        self.element(name, ElementKind::Flow(Flow { between, heat }));
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

/// The solar X-ray monitor of the second case study. Parameters: Gh, Gsub, Gb, Gth, Glead, Gpre, Gap, Gharn, e*,
/// seebeck, resistance, conductance. Inputs: T_orex, V, q_sun, T_sky. Quantities: the nine temperatures, the current,
/// heat out of the cold side.
pub fn sxm() -> Model {
    let mut b = Build::default();
    let gh = b.parameter("Gh", 0.15);
    let gsub = b.parameter("Gsub", 0.6);
    let gb = b.parameter("Gb", 0.4);
    let gth = b.parameter("Gth", 2.0);
    let glead = b.parameter("Glead", 2.5e-4);
    let gpre = b.parameter("Gpre", 0.08);
    let gap = b.parameter("Gap", 0.5);
    let gharn = b.parameter("Gharn", 0.004);
    let estar = b.parameter("estar", 0.03);
    let seebeck = b.parameter("a_c", 3.95e-4);
    let resistance = b.parameter("R_c", 0.185);
    let conductance = b.parameter("K_c", 3.8e-4);
    let orex = b.input("T_orex", 303.15);
    let voltage = b.input("V", 2.75);
    let q_sun = b.input("q_sun", 1698.96);
    let sky = b.input("T_sky", 3.0);
    let names = ["sdd", "tec_mid", "tec_hot", "sdd_hsg", "preamp", "sxm_hsg", "aperture", "bracket", "mli"];
    let capacities = [0.3, 0.5, 2.0, 12.0, 20.0, 150.0, 15.0, 120.0, 6.0];
    let [sdd, mid, hot, hsg, pre, sxm, ap, bracket, mli]: [usize; 9] =
        std::array::from_fn(|i| b.diffusion(names[i], capacities[i]));
    let deck = b.boundary("deck", orex);
    let sky = b.boundary("sky", sky);
    b.conductor("Gh", [hsg, sxm], gh);
    b.conductor("Gsub", [sxm, bracket], gsub);
    b.conductor("Gb", [bracket, deck], gb);
    b.conductor("Gth", [hot, hsg], gth);
    b.conductor("Glead", [sdd, hsg], glead);
    b.conductor("Gpre", [pre, sxm], gpre);
    let gpw = b.n(0.002);
    b.conductor("Gpw", [pre, hsg], gpw);
    b.conductor("Gap", [ap, sxm], gap);
    b.conductor("Gharn", [sxm, deck], gharn);
    let inner = b.n(0.6e-4);
    b.radiation("cavity", [sdd, hsg], inner);
    let blanket = b.scale(0.02, estar);
    b.radiation("blanket", [mli, sxm], blanket);
    let cover = b.n(0.6 * 0.02);
    b.radiation("cover", [mli, sky], cover);
    let plate = b.n(0.8 * 0.0012);
    b.radiation("plate", [ap, sky], plate);
    let q = b.n(0.0015);
    b.load("bias", sdd, q);
    let q = b.n(0.6);
    b.load("electronics", pre, q);
    let sun = b.scale(0.3 * 0.0012, q_sun);
    b.load("sun on plate", ap, sun);
    let sun = b.scale(0.45 * 0.0036, q_sun);
    b.load("sun on cover", mli, sun);
    let couples = vec![b.n(8.0), b.n(24.0)];
    let lead_resistance = b.n(0.35);
    let cooler = Cooler {
        nodes: vec![sdd, mid, hot],
        couples,
        drive: Drive::Voltage(voltage),
        seebeck,
        resistance,
        conductance,
        lead_resistance,
    };
    b.element("tec", ElementKind::Cooler(cooler.clone()));
    for (name, node) in names.iter().zip(0..9) {
        b.temperature(name, node);
    }
    let contribution = cooler.contribution(b.graph());
    b.quantity("current", contribution.current.unwrap());
    b.quantity("pumped", contribution.through.unwrap());
    b.model
}
