//! Thermoelectric coolers as written.

use super::{ElementForm, refuse};
use crate::document::formula::Expected;
use crate::document::{Diagnostic, Diagnostics, OneOrMany, Scalar, Spanned, code, counted, written_struct};
use crate::expression::{Dimension, ExprId};
use crate::study::model::resolve::ResolvedModel;
use crate::thermal::element::{Cooler, Drive, ElementKind, law};

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
        model: &mut ResolvedModel,
        diagnostics: &mut Diagnostics,
    ) -> Option<ElementKind> {
        model.places.note("cooler", &name.value, law::COUPLES, &self.couples.place);
        let scalars = [(law::COUPLE_RESISTANCE, &self.resistance), (law::COUPLE_CONDUCTANCE, &self.conductance)];
        let leads = self.lead_resistance.as_ref().map(|resistance| (law::LEADS, resistance));
        for (what, scalar) in scalars.into_iter().chain(leads) {
            model.places.note("cooler", &name.value, what, scalar.place());
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
            if let Some(value) = id.and_then(|id| model.model.graph.constant(id)).filter(|v| *v <= 0.0) {
                refuse(scalar.place(), format!("{what} of {value}"), "above 0", diagnostics);
            }
        }
        for (scalar, id) in written.iter().zip(&couples) {
            if let Some(value) = id.and_then(|id| model.model.graph.constant(id)).filter(|v| *v <= 0.0) {
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
