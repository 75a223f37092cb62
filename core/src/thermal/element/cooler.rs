//! Thermoelectric cooler of one or more stages in series, driven by voltage or current.
//!
//! A stage of `n` couples between its cold side `Tc` and hot side `Th` carries the current `i` (Ioffe 1957;
//! per couple Seebeck coefficient `a` in V/K, resistance `R` in ohm, conductance `K` in W/K):
//!
//! `Qc = n (a i Tc - i^2 R / 2 - K (Th - Tc))` out of the cold side,
//! `Qh = n (a i Th + i^2 R / 2 - K (Th - Tc))` into the hot side,
//! `V = sum n a (Th - Tc) + i (sum n R + R_lead)`.
//!
//! So `Qh - Qc = i V` of the stage: the electrical power is heat in the network; the leads' part is dissipated
//! outside. At zero voltage the circuit is open (`i = 0`).

use serde_json::{Value, json};

use crate::document::formula::Expected;
use crate::document::{Diagnostic, Diagnostics, OneOrMany, Scalar, Spanned, code, counted, written_struct};
use crate::expression::{Binary, Dimension, ExprId, Graph, Unary};

use super::conductor::temperature;
use super::form::{ElementForm, Lookup, refuse};
use super::{Contribution, Description, Drawing, ElementKind, Path, Physics, SignConstraint, Switch, arrows, sign};

/// What the electronics holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Voltage over the whole cooler and its leads, V; 0 is an open circuit.
    Voltage(ExprId),
    /// Current, A.
    Current(ExprId),
}

/// A thermoelectric cooler.
#[derive(Clone, Debug, PartialEq)]
pub struct Cooler {
    /// Nodes from the cold side to the hot side, one more than there are stages.
    pub nodes: Vec<usize>,
    /// Couples of each stage, from cold to hot.
    pub couples: Vec<ExprId>,
    /// Voltage or current.
    pub drive: Drive,
    /// Seebeck coefficient of a couple, V/K.
    pub seebeck: ExprId,
    /// Resistance of a couple, ohm.
    pub resistance: ExprId,
    /// Conductance of a couple, W/K.
    pub conductance: ExprId,
    /// Resistance of the leads in series, ohm, dissipated outside the network.
    pub lead_resistance: ExprId,
}

impl Cooler {
    /// The current, A.
    fn current(&self, graph: &mut Graph) -> ExprId {
        match self.drive {
            Drive::Current(current) => current,
            Drive::Voltage(voltage) => {
                let mut back = graph.number(0.0);
                let mut total = self.lead_resistance;
                for (stage, &couples) in self.couples.iter().enumerate() {
                    let cold = temperature(graph, self.nodes[stage]);
                    let hot = temperature(graph, self.nodes[stage + 1]);
                    let difference = graph.subtract(hot, cold);
                    let seebeck = graph.multiply(couples, self.seebeck);
                    let seebeck_voltage = graph.multiply(seebeck, difference);
                    back = graph.add(back, seebeck_voltage);
                    let resistance = graph.multiply(couples, self.resistance);
                    total = graph.add(total, resistance);
                }
                let driving = graph.subtract(voltage, back);
                let closed = graph.divide(driving, total);
                // Open circuit at zero voltage: the drive electronics is off, no Seebeck current flows.
                let size = graph.unary(Unary::Abs, voltage);
                let zero = graph.number(0.0);
                let off = graph.binary(Binary::AtLeast, zero, size);
                let one = graph.number(1.0);
                let on = graph.subtract(one, off);
                graph.multiply(on, closed)
            }
        }
    }
}

impl Physics for Cooler {
    fn kind(&self) -> &'static str {
        "cooler"
    }

    fn contribution(&self, graph: &mut Graph, _switches: &mut Vec<Switch>, _switched: bool) -> Contribution {
        let current = self.current(graph);
        let half = graph.number(0.5);
        let square = graph.multiply(current, current);
        let ohmic = graph.multiply(square, self.resistance);
        let joule = graph.multiply(half, ohmic);
        let mut out = Contribution { current: Some(current), ..Contribution::default() };
        for (stage, &couples) in self.couples.iter().enumerate() {
            let (cold, hot) = (self.nodes[stage], self.nodes[stage + 1]);
            let (tc, th) = (temperature(graph, cold), temperature(graph, hot));
            let difference = graph.subtract(th, tc);
            let conducted = graph.multiply(self.conductance, difference);
            let pumping = graph.multiply(self.seebeck, current);
            let (at_cold, at_hot) = (graph.multiply(pumping, tc), graph.multiply(pumping, th));
            let lessened = graph.subtract(at_cold, joule);
            let per_couple_cold = graph.subtract(lessened, conducted);
            let raised = graph.add(at_hot, joule);
            let per_couple_hot = graph.subtract(raised, conducted);
            let from_cold = graph.multiply(couples, per_couple_cold);
            let into_hot = graph.multiply(couples, per_couple_hot);
            let loss = graph.negate(from_cold);
            out.heat.extend([(cold, loss), (hot, into_hot)]);
            out.through = out.through.or(Some(from_cold));

            let size = graph.add(tc, th);
            let exchanged = graph.multiply(self.conductance, size);
            let mut terms = graph.unary(Unary::Abs, at_cold);
            for part in [at_hot, joule, exchanged] {
                let part = graph.unary(Unary::Abs, part);
                terms = graph.add(terms, part);
            }
            let terms = graph.multiply(couples, terms);
            out.balance_scale.extend([(cold, terms), (hot, terms)]);
        }
        out
    }

    fn identity(&self, number: &mut dyn FnMut(ExprId) -> Value) -> Value {
        json!({
            "nodes": self.nodes,
            "couples": self.couples.iter().map(|&couples| number(couples)).collect::<Vec<_>>(),
            "drive": match self.drive {
                Drive::Voltage(voltage) => json!({"voltage": number(voltage)}),
                Drive::Current(current) => json!({"current": number(current)}),
            },
            "seebeck": number(self.seebeck),
            "resistance": number(self.resistance),
            "conductance": number(self.conductance),
            "lead_resistance": number(self.lead_resistance),
        })
    }

    fn description(&self, name: &dyn Fn(usize) -> String) -> Description {
        let (value, unit) = match self.drive {
            Drive::Voltage(voltage) => (voltage, "V"),
            Drive::Current(current) => (current, "A"),
        };
        let mut others = vec![self.seebeck, self.resistance, self.conductance, self.lead_resistance];
        others.extend(&self.couples);
        Description { what: "cooler", ends: arrows(&self.nodes, name), value, unit, others }
    }

    fn drawing(&self) -> Drawing {
        Drawing::Path(Path::Cooler)
    }

    fn joined(&self) -> &[usize] {
        &self.nodes
    }

    fn fault(&self) -> Option<String> {
        let (nodes, stages) = (self.nodes.len(), self.couples.len());
        (stages == 0 || nodes != stages + 1)
            .then(|| format!("has {nodes} nodes for {stages} stages; a cooler needs one node more than it has stages"))
    }

    fn sign_constraints(&self) -> Vec<SignConstraint> {
        let mut constraints = vec![
            SignConstraint::above_zero(sign::COUPLE_RESISTANCE, "ohm", self.resistance),
            SignConstraint::above_zero(sign::COUPLE_CONDUCTANCE, "W/K", self.conductance),
            SignConstraint::at_least_zero(sign::LEADS, "ohm", self.lead_resistance),
        ];
        constraints.extend(self.couples.iter().map(|&couples| SignConstraint::above_zero(sign::COUPLES, "", couples)));
        constraints
    }
}

const CONDUCTANCE: Expected = Expected::value(Dimension::CONDUCTANCE, "a conductance");
const VOLTAGE: Expected = Expected::value(Dimension::VOLTAGE, "a voltage");
const CURRENT: Expected = Expected::value(Dimension::CURRENT, "a current");
const SEEBECK: Expected = Expected::value(Dimension::SEEBECK, "a Seebeck coefficient");
const RESISTANCE: Expected = Expected::value(Dimension::RESISTANCE, "a resistance");
const COUPLES: Expected = Expected::value(Dimension::NONE, "a number of couples").given();

written_struct! {
    /// A thermoelectric cooler of one or more stages; values are of one couple.
    pub struct CoolerForm: "a cooler" {
        /// The node that is cooled.
        required cold: Spanned<String>,
        /// Nodes between the stages, from cold to hot.
        default(Vec::new()) interstage: Vec<Spanned<String>>,
        /// The node that takes the heat.
        required hot: Spanned<String>,
        /// Voltage over cooler and leads, V; either this or `current`.
        optional voltage: Scalar,
        /// Current, A.
        optional current: Scalar,
        /// Seebeck coefficient of a couple, V/K; may depend on `Tm` of cold and hot side.
        required seebeck: Scalar,
        /// Resistance of a couple, ohm.
        required resistance: Scalar,
        /// Conductance of a couple, W/K.
        required conductance: Scalar,
        /// Number of couples of each stage, from cold to hot.
        required couples: Spanned<OneOrMany<Scalar>>,
        /// Resistance of the leads, ohm, dissipated outside.
        optional lead_resistance: Scalar,
        /// Description, for the report.
        optional description: String,
        /// Where the values come from.
        optional source: String,
    }
}

impl ElementForm for CoolerForm {
    fn resolve(
        &self,
        name: &Spanned<String>,
        model: &mut dyn Lookup,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        model.note("cooler", &name.value, sign::COUPLES, &self.couples.place);
        let scalars = [(sign::COUPLE_RESISTANCE, &self.resistance), (sign::COUPLE_CONDUCTANCE, &self.conductance)];
        let leads = self.lead_resistance.as_ref().map(|resistance| (sign::LEADS, resistance));
        for (what, scalar) in scalars.into_iter().chain(leads) {
            model.note("cooler", &name.value, what, scalar.place());
        }
        let mut nodes: Vec<usize> = Vec::new();
        let written = std::iter::once(&self.cold).chain(&self.interstage).chain(std::iter::once(&self.hot));
        let mut valid = true;
        for written in written {
            let Some(node) = model.find_node(&written.value, &written.place, diagnostics) else {
                valid = false;
                continue;
            };
            if nodes.contains(&node) {
                let message = format!("the node `{}` stands twice in this cooler", written.value);
                diagnostics.push(
                    Diagnostic::error(&code::SELF_LOOP, &written.place, message)
                        .expected("different nodes from cold to hot"),
                );
                valid = false;
            }
            nodes.push(node);
        }
        let stages = 1 + self.interstage.len();
        let written = &self.couples.value.0;
        if written.len() != stages {
            let message = format!("{} of couples for {}", counted(written.len(), "number"), counted(stages, "stage"));
            diagnostics.push(
                Diagnostic::error(&code::WRONG_LENGTH, &self.couples.place, message)
                    .expected(format!("{stages}, from cold to hot: one more than nodes in `interstage`")),
            );
            valid = false;
        }
        if !valid {
            return None;
        }
        let mut formulas = model.formulas();
        let locals = formulas.ends([nodes[0], nodes[nodes.len() - 1]]);
        // Of a cooler only the mean temperature has a plain meaning for its materials.
        let seebeck = formulas.scalar(&self.seebeck, SEEBECK, &locals, diagnostics);
        let resistance = formulas.scalar(&self.resistance, RESISTANCE, &locals, diagnostics);
        let conductance = formulas.scalar(&self.conductance, CONDUCTANCE, &locals, diagnostics);
        let couples: Vec<Option<ExprId>> =
            written.iter().map(|c| formulas.scalar(c, COUPLES, &[], diagnostics)).collect();
        let lead_resistance = match &self.lead_resistance {
            Some(scalar) => formulas.scalar(scalar, RESISTANCE, &[], diagnostics),
            None => Some(formulas.graph.number(0.0)),
        };
        let drive = match (&self.voltage, &self.current) {
            (Some(voltage), None) => formulas.scalar(voltage, VOLTAGE, &locals, diagnostics).map(Drive::Voltage),
            (None, Some(current)) => formulas.scalar(current, CURRENT, &locals, diagnostics).map(Drive::Current),
            (both, _) => {
                let message = match both {
                    Some(_) => "a cooler has either `voltage` or `current`, and this one has both",
                    None => "a cooler has either `voltage` or `current`, and this one has neither",
                };
                let place = name.place.clone();
                diagnostics.push(
                    Diagnostic::error(&code::ONE_KIND, &place, message).expected("exactly one of `voltage`, `current`"),
                );
                None
            }
        };
        for (scalar, id, what) in [
            (&self.resistance, resistance, "a couple's resistance"),
            (&self.conductance, conductance, "a couple's conductance"),
        ] {
            if let Some(value) = id.and_then(|id| model.formulas().graph.constant(id)).filter(|v| *v <= 0.0) {
                refuse(scalar.place(), format!("{what} of {value}"), "above 0", diagnostics);
            }
        }
        for (scalar, id) in written.iter().zip(&couples) {
            if let Some(value) = id.and_then(|id| model.formulas().graph.constant(id)).filter(|v| *v <= 0.0) {
                refuse(scalar.place(), format!("{value} couples"), "a number above 0", diagnostics);
            }
        }
        Some(ElementKind::Cooler(Cooler {
            nodes,
            couples: couples.into_iter().collect::<Option<_>>()?,
            drive: drive?,
            seebeck: seebeck?,
            resistance: resistance?,
            conductance: conductance?,
            lead_resistance: lead_resistance?,
        }))
    }
}
