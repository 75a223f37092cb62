//! What names mean while a pass is resolved.

use crate::document::prior::support;
use crate::document::quantity::report_dimension;
use crate::document::{Amount, Diagnostic, Diagnostics, Place, Sense, Spanned, WrittenUnit, code, suggest};
use crate::expression::{Dimension, Symbol, Unit};
use crate::measurement::Uncertain;
use crate::random::Distribution;
use crate::study::folder::Folder;
use crate::study::model::{Prior, ResolvedModel, Scale};
use crate::study::pass::uncertain::UncertainForm;
use crate::study::variable::Variable;
use crate::thermal::{Quantity, QuantityValue};

/// Share of a temperature's prior that may lie below absolute zero: tails of normal priors reach there.
const COLDEST: f64 = 0.001;

/// The model that is being completed, the folder, and where findings go.
pub struct Scope<'a> {
    /// The study's folder.
    pub folder: &'a Folder,
    /// The model; quantities are added where a node's name is asked for.
    pub resolved: ResolvedModel,
    /// Nodes that effects have added, each with the node whose start temperature it takes where none is stated.
    pub hosts: Vec<(usize, usize)>,
    /// Starts of nodes that effects have added: the measurement as written, the node, the temperature.
    pub starts: Vec<(String, usize, Uncertain)>,
    /// Nodes to which effects have given the only heat capacity that they have.
    pub given_storage: Vec<usize>,
    /// Priors from draws of the effect's parameters that is being adopted, by their names in the effect.
    pub drawn: Vec<(String, Prior)>,
    /// What is doubtful about the data: warnings that are heard where there are no errors.
    pub doubts: Vec<Diagnostic>,
    /// Errors and warnings.
    pub diagnostics: &'a mut Diagnostics,
}

impl Scope<'_> {
    /// Adds an error.
    pub fn error(&mut self, code: &'static code::Code, place: &Place, message: impl Into<String>, expected: &str) {
        let diagnostic = Diagnostic::error(code, place, message);
        self.diagnostics.push(if expected.is_empty() { diagnostic } else { diagnostic.expected(expected) });
    }

    /// Reports a name that nothing has, with the nearest one or a list.
    pub fn unknown(&mut self, code: &'static code::Code, what: &str, name: &str, place: &Place, known: &[&str]) {
        unknown(self.diagnostics, code, (what, name), place, known.iter().copied());
    }

    /// Position of a quantity in the model's list: a named one, or a node's temperature, which is added.
    pub fn quantity(&mut self, name: &Spanned<String>) -> Option<usize> {
        if let Some(index) = self.resolved.quantity(&name.value) {
            return Some(index);
        }
        if let Some(node) = self.resolved.node(&name.value) {
            return Some(self.node_quantity(node));
        }
        let model = &self.resolved.model;
        let listed_names = (model.quantities.iter().map(|quantity| quantity.name.as_str()))
            .chain(model.nodes.iter().map(|node| node.name.as_str()));
        let asked = ("quantity or node", name.value.as_str());
        unknown(self.diagnostics, &code::UNKNOWN_NAME, asked, &name.place, listed_names);
        None
    }

    /// The temperature of a node as a quantity, which is added where it is not there.
    pub fn node_quantity(&mut self, node: usize) -> usize {
        let name = self.resolved.model.nodes[node].name.clone();
        if let Some(index) = self.resolved.quantity(&name) {
            return index;
        }
        // A model has far fewer nodes than this type counts.
        let symbol = Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX));
        let value = QuantityValue::Instant(self.resolved.model.graph.symbol(symbol));
        self.resolved.model.quantities.push(Quantity { name, unit: "K".to_owned(), is_temperature: true, value });
        self.resolved.quantity_dimensions.push(Dimension::TEMPERATURE);
        self.resolved.model.quantities.len() - 1
    }

    /// Dimension of a quantity, and whether its values stand on a scale with a zero of its own.
    pub fn quantity_form(&self, quantity: usize) -> (Dimension, Sense) {
        let absolute = self.resolved.model.quantities[quantity].is_temperature;
        let sense = if absolute { Sense::Absolute } else { Sense::Difference };
        (self.resolved.quantity_dimensions[quantity], sense)
    }

    /// Position of an input.
    pub fn input(&self, name: &str) -> Option<usize> {
        self.resolved.input(name)
    }

    /// Position of an input, reported where there is none.
    pub fn known_input(&mut self, name: &str, place: &Place) -> Option<usize> {
        let input_index = self.input(name);
        if input_index.is_none() {
            let input_names = self.resolved.model.inputs.iter().map(|input| input.name.as_str());
            unknown(self.diagnostics, &code::UNKNOWN_NAME, ("input", name), place, input_names);
        }
        input_index
    }

    /// The inputs' nominal values.
    pub fn nominal_inputs(&self) -> Vec<f64> {
        self.resolved.model.inputs.iter().map(|input| input.nominal).collect()
    }

    /// An input's value in SI; a bare number is SI, with a warning where the input is written in another unit.
    pub fn input_value(&mut self, input: usize, amount: &Amount) -> Option<f64> {
        let scale = self.resolved.input_scales[input].clone();
        let Some(unit) = &scale.unit else { return scale.si(amount, Sense::Absolute, self.diagnostics) };
        if amount.unit.is_none() && (unit.factor != 1.0 || unit.has_offset()) {
            let name = &self.resolved.model.inputs[input].name;
            let (value, si) = (amount.value, unit.dimension);
            let message =
                format!("the bare number {value} is taken in {si}; the model states `{name}` in {}", unit.text);
            let help = format!("write {{\"value\": {value}, \"unit\": \"{}\"}}, or state {si}", unit.text);
            self.diagnostics.push(Diagnostic::warning(&code::BARE_NUMBER, &amount.place, message).help(help));
        }
        amount.si(unit.dimension, None, Sense::Absolute, self.diagnostics)
    }

    /// A parameter or input by name, with its unit.
    pub fn variable(&mut self, name: &str, place: &Place) -> Option<(Variable, Scale)> {
        if let Some(index) = self.resolved.parameter(name) {
            return Some((Variable::Parameter(index), self.resolved.parameter_scales[index].clone()));
        }
        if let Some(index) = self.input(name) {
            return Some((Variable::Input(index), self.resolved.input_scales[index].clone()));
        }
        let model = &self.resolved.model;
        let listed_names = (model.parameters.iter().map(|parameter| parameter.name.as_str()))
            .chain(model.inputs.iter().map(|input| input.name.as_str()));
        unknown(self.diagnostics, &code::UNKNOWN_NAME, ("parameter or input", name), place, listed_names);
        None
    }

    /// A duration or instant in seconds; a bare number is seconds.
    pub fn seconds(&mut self, amount: &Amount) -> Option<f64> {
        amount.si(Dimension::TIME, None, Sense::Difference, self.diagnostics)
    }

    /// Whether the prior of what must lie above 0 does; reported where it does not.
    fn is_above_zero(&mut self, prior: &Distribution, place: &Place, dimension: Dimension, sense: Sense) -> bool {
        if dimension == Dimension::TEMPERATURE && sense == Sense::Absolute {
            let low = prior.quantile(COLDEST);
            if low > 0.0 {
                return true;
            }
            let message = format!("a share of the prior lies below absolute zero: {COLDEST} of it below {low:.4} K");
            let diagnostic = Diagnostic::error(&code::OUT_OF_RANGE, place, message)
                .expected("a prior above 0 K; bare numbers are in K")
                .help("temperatures in degC need their unit: {\"prior\": {\"normal\": {\"mean\": 20, \"sd\": 5}}, \"unit\": \"degC\"}");
            self.diagnostics.push(diagnostic);
            return false;
        }
        let [lower, _] = support(prior);
        let is_above = prior.quantile(0.5) > 0.0 && !(lower.is_finite() && lower < 0.0);
        if !is_above {
            let help = "such as {\"lognormal\": {\"median\": 0.2, \"factor\": 1.5}}";
            let diagnostic = Diagnostic::error(&code::OUT_OF_RANGE, place, "the prior is not above 0")
                .expected("a prior of values above 0")
                .help(help);
            self.diagnostics.push(diagnostic);
        }
        is_above
    }

    /// A known or inferred number in SI. `above_zero` refuses what is not, known or by its prior.
    pub fn uncertain(
        &mut self,
        form: &UncertainForm,
        dimension: Dimension,
        sense: Sense,
        above_zero: bool,
    ) -> Option<Uncertain> {
        match form {
            UncertainForm::Known(amount) => {
                let value = amount.si(dimension, None, sense, self.diagnostics)?;
                if above_zero && value <= 0.0 {
                    let message = format!("{} is not above 0", amount.value);
                    self.error(&code::OUT_OF_RANGE, &amount.place, message, "a value above 0");
                    return None;
                }
                Some(Uncertain::Known(value))
            }
            UncertainForm::Inferred(form) => {
                let written_unit = match &form.unit {
                    Some(WrittenUnit { unit, place }) if unit.dimension != dimension => {
                        report_dimension(unit, place, dimension, self.diagnostics);
                        return None;
                    }
                    Some(written) => written.unit.clone(),
                    None => Unit::si(dimension),
                };
                match form.prior.resolve(Some(&written_unit), dimension, sense, self.diagnostics)? {
                    Prior::Distribution(prior)
                        if above_zero && !self.is_above_zero(&prior, form.prior.place(), dimension, sense) =>
                    {
                        None
                    }
                    Prior::Distribution(prior) => match &form.nominal {
                        None => Some(Uncertain::Inferred(prior)),
                        Some(amount) => {
                            let nominal = amount.si(dimension, Some(&written_unit), sense, self.diagnostics)?;
                            if !prior.log_density(nominal).is_finite() {
                                let message = format!("the prior excludes {}", amount.value);
                                self.error(
                                    &code::OUT_OF_RANGE,
                                    &amount.place,
                                    message,
                                    "a value that the prior allows",
                                );
                                return None;
                            }
                            Some(Uncertain::InferredFrom { prior, nominal })
                        }
                    },
                    Prior::Posterior { place, .. } | Prior::Draws { place, .. } => {
                        let message = "draws cannot be the prior of what is inferred of the data";
                        self.error(&code::PRIOR_NOT_READ, &place, message, "a distribution");
                        None
                    }
                }
            }
        }
    }

    /// Whether a reason is there; reported where it is blank.
    pub fn reason(&mut self, reason: &Spanned<String>) -> bool {
        if reason.value.trim().is_empty() {
            self.error(&code::BECAUSE_MISSING, &reason.place, "the reason is blank", "a reason in words");
            return false;
        }
        true
    }
}

/// Reports a name that nothing has, after what was asked for, with the nearest one or a list.
pub fn unknown<'n>(
    diagnostics: &mut Diagnostics,
    code: &'static code::Code,
    (what, name): (&str, &str),
    place: &Place,
    known: impl Iterator<Item = &'n str> + Clone,
) {
    let near = diagnostics.nearest(name, known.clone());
    let listed = suggest::listed(known.clone(), 12);
    let expected =
        if known.into_iter().next().is_none() { format!("there is no {what}") } else { format!("one of {listed}") };
    diagnostics
        .push(Diagnostic::error(code, place, format!("unknown {what} `{name}`")).expected(expected).suggest(near));
}

/// The unit of a text that has been checked before; no unit where it is none.
pub fn unit_of(text: &str) -> Unit {
    Unit::parse(text).unwrap_or_else(|_| Unit::si(Dimension::NONE))
}
