//! From the written model to the resolved one: SI units, indices for names, parsed expressions.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use crate::document::formula::Expected;
use crate::document::prior::{Prior, support};
use crate::document::{
    Amount, Diagnostic, Diagnostics, Formulas, Map, MapEntry, Place, Sense, Source, Span, Spanned, WrittenUnit, code,
    suggest,
};
use crate::expression::{Dependence, Dimension, ExprId, Names, Symbol, Table, Unit};
use crate::random::Distribution;
use crate::study::external::External;
use crate::study::folder::Folder;
use crate::thermal::element::{Contribution, Element, ElementForm, Lookup, Switch};
use crate::thermal::{Clock, Derivatives, Input, Limits, Model, Node, NodeKind, Parameter};

use super::form::{InputForm, LimitsForm, ModelForm, NodeForm, ParameterForm, TableForm};
use super::group::{self, Group};
use super::implied_groups;
use super::name;
use super::outside;
use super::quantity;
use super::surrogate::Surrogate;

/// The unit in which a parameter or input is written and shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// The unit; `None` where the entry states none: SI of unknown dimension.
    pub unit: Option<Unit>,
}

impl Scale {
    /// The unit's text; `SI` where none is stated.
    pub fn text(&self) -> &str {
        self.unit.as_ref().map_or("SI", |unit| &unit.text)
    }

    /// The dimension, where known.
    pub fn dimension(&self) -> Option<Dimension> {
        self.unit.as_ref().map(|unit| unit.dimension)
    }

    /// An amount of this entry in SI: bare numbers are in the entry's unit.
    pub fn si(&self, amount: &Amount, sense: Sense, diagnostics: &mut Diagnostics) -> Option<f64> {
        let written_dimension = amount.unit.as_ref().map(|written| written.unit.dimension);
        let dimension = self.dimension().or(written_dimension).unwrap_or(Dimension::NONE);
        amount.si(dimension, self.unit.as_ref(), sense, diagnostics)
    }
}

/// The own error of an input.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputError {
    /// Standard deviation, SI.
    pub sigma: Option<f64>,
    /// Prior of a constant error, SI.
    pub bias: Option<Prior>,
}

/// Where nodes, elements and their values stand in the model's file.
#[derive(Clone, Debug)]
pub struct Places {
    /// The file.
    pub file: Place,
    /// By kind (`node`, `conductor`, ...) and name: of the name (under an empty text) and of values.
    known: HashMap<(&'static str, String), Vec<(&'static str, Place)>>,
}

impl Default for Places {
    fn default() -> Self {
        Self { file: Place::in_text(&Source::new("", ""), Span::default()), known: HashMap::new() }
    }
}

impl Places {
    /// Notes where a value stands, or the name where `what` is empty.
    pub fn note(&mut self, kind: &'static str, name: &str, what: &'static str, place: &Place) {
        self.known.entry((kind, name.to_owned())).or_default().push((what, place.clone()));
    }

    /// Where a value stands; where that is not known, where its owner's name does.
    pub fn find(&self, kind: &'static str, name: &str, what: &str) -> Option<&Place> {
        let places = self.known.get(&(kind, name.to_owned()))?;
        let of = |wanted: &str| places.iter().find(|(noted_value, _)| *noted_value == wanted).map(|(_, place)| place);
        of(what).or_else(|| of(""))
    }
}

/// A resolved model with all that belongs to it.
#[derive(Clone, Debug, Default)]
pub struct ResolvedModel {
    /// The model proper.
    pub model: Model,
    /// What of it was reconstructed, and how.
    pub reconstructed: Option<String>,
    /// The names that expressions know.
    pub names: Names,
    /// Prior of each parameter, SI.
    pub priors: Vec<Prior>,
    /// Unit of each parameter.
    pub parameter_scales: Vec<Scale>,
    /// Unit of each input.
    pub input_scales: Vec<Scale>,
    /// Own error of each input.
    pub input_errors: Vec<InputError>,
    /// Of each input of the model's file whether every test sets it; those of adopted effects stand behind them.
    pub test_sets: Vec<bool>,
    /// Groups, in the order of the file, and then those that the model implies.
    pub groups: Vec<Group>,
    /// Dimension of each quantity.
    pub quantity_dimensions: Vec<Dimension>,
    /// What answers for the model in place of nodes and elements.
    pub external: Option<Arc<External>>,
    /// The surrogate in place of that.
    pub surrogate: Option<Arc<Surrogate>>,
    /// Where nodes and elements stand.
    pub places: Places,
    nodes: BTreeMap<String, usize>,
    /// Indices of the elements by name.
    pub elements: BTreeMap<String, Vec<usize>>,
}

impl Lookup for ResolvedModel {
    fn find_node(&self, name: &str, place: &Place, diagnostics: &mut Diagnostics) -> Option<usize> {
        let node_index = self.node(name);
        if node_index.is_none() {
            name::unknown("node", name, place, self.nodes.keys().map(String::as_str), diagnostics);
        }
        node_index
    }

    fn formulas(&mut self) -> Formulas<'_> {
        Formulas { graph: &mut self.model.graph, names: &self.names }
    }

    fn note(&mut self, kind: &'static str, name: &str, what: &'static str, place: &Place) {
        self.places.note(kind, name, what, place);
    }
}

impl ResolvedModel {
    /// Where slopes of a model that is asked outside come from, or of the surrogate in its place; `None` of a network.
    pub fn derivatives(&self) -> Option<Derivatives> {
        self.model.external.as_ref().map(|external| external.derivatives)
    }

    /// Index of a node.
    pub fn node(&self, name: &str) -> Option<usize> {
        self.nodes.get(name).copied()
    }

    /// Index of a parameter.
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.model.parameters.iter().position(|p| p.name == name)
    }

    /// Index of an input.
    pub fn input(&self, name: &str) -> Option<usize> {
        self.model.inputs.iter().position(|i| i.name == name)
    }

    /// Index of a quantity.
    pub fn quantity(&self, name: &str) -> Option<usize> {
        self.model.quantities.iter().position(|q| q.name == name)
    }

    /// Resolves the elements of a kind into the model.
    pub(super) fn resolve_elements<T: ElementForm>(&mut self, forms: &Map<T>, diagnostics: &mut Diagnostics) {
        name::check_labels(forms, diagnostics);
        for entry in forms {
            let name = Spanned { value: entry.name.clone(), place: entry.name_place.clone() };
            if let Some(kind) = entry.value.resolve(&name, self, diagnostics) {
                self.model.elements.push(Element { name: name.value, kind });
            }
        }
    }

    /// Index of an element of a kind, by the kind's word, or of any; an unknown one, or two of one name, are reported at
    /// `place`.
    pub fn find_element(
        &self,
        name: &str,
        kind: Option<&str>,
        place: &Place,
        diagnostics: &mut Diagnostics,
    ) -> Option<usize> {
        let is_of_kind = |element: &Element| kind.is_none_or(|kind| element.physics().kind() == kind);
        let fits = |index: usize| is_of_kind(&self.model.elements[index]);
        let indices: Vec<usize> = match self.elements.get(name) {
            Some(indices) => indices.iter().copied().filter(|&i| fits(i)).collect(),
            None => Vec::new(),
        };
        match indices.as_slice() {
            [one] => Some(*one),
            [] => {
                let element_names =
                    self.model.elements.iter().filter(|element| is_of_kind(element)).map(|e| e.name.as_str());
                name::unknown(kind.unwrap_or("element"), name, place, element_names, diagnostics);
                None
            }
            several => {
                let kinds: Vec<&str> = several.iter().map(|&i| self.model.elements[i].physics().kind()).collect();
                let message = format!("`{name}` is the name of a {}", kinds.join(" and a "));
                diagnostics
                    .push(Diagnostic::error(&code::DUPLICATE_NAME, place, message).expected("the name of one element"));
                None
            }
        }
    }

    /// What the element of a name gives beside heat, such as its `current`; an unknown name, or elements that give no such
    /// thing, are reported at `place`.
    pub fn find_output(
        &mut self,
        name: &str,
        what: &str,
        output: fn(&Contribution) -> Option<ExprId>,
        place: &Place,
        diagnostics: &mut Diagnostics,
    ) -> Option<ExprId> {
        // Elements of several kinds may have the name: what they are asked for leaves no trace in the graph.
        let mut graph = self.model.graph.clone();
        let mut gives = |element: &Element| output(&element.contribution(&mut graph, &mut Vec::new(), false)).is_some();
        let of_name = self.elements.get(name).map_or(&[][..], Vec::as_slice);
        if let Some(&element) = of_name.iter().find(|&&index| gives(&self.model.elements[index])) {
            return output(&self.contribution(element));
        }
        let giving = self.model.elements.iter().filter(|element| gives(element));
        let names: Vec<&str> = giving.map(|element| element.name.as_str()).collect();
        let message =
            if of_name.is_empty() { format!("unknown element `{name}`") } else { format!("`{name}` has no {what}") };
        let expected = match names.as_slice() {
            [] => format!("there is no element with a {what}"),
            names => format!("one of {}", suggest::listed(names.iter().copied(), 12)),
        };
        let near = diagnostics.nearest(name, names.iter().copied());
        diagnostics.push(Diagnostic::error(&code::UNKNOWN_NAME, place, message).expected(expected).suggest(near));
        None
    }

    /// What an element does to the network, in the steady form.
    pub fn contribution(&mut self, element: usize) -> Contribution {
        let mut switches: Vec<Switch> = Vec::new();
        self.model.elements[element].contribution(&mut self.model.graph, &mut switches, false)
    }

    /// Adds a parameter (an adopted effect's) behind those of the model and returns its index.
    pub fn add_parameter(&mut self, parameter: Parameter, scale: Scale, prior: Prior) -> usize {
        let index = self.model.parameters.len();
        self.name(&parameter.name, Symbol::Parameter(u32::try_from(index).unwrap_or(u32::MAX)), &scale);
        self.model.parameters.push(parameter);
        self.parameter_scales.push(scale);
        self.priors.push(prior);
        index
    }

    /// Adds an input (where an adopted effect is there) behind those of the model and returns its index.
    pub fn add_input(&mut self, input: Input, scale: Scale) -> usize {
        let index = self.model.inputs.len();
        self.model.inputs.push(input);
        self.input_scales.push(scale);
        self.input_errors.push(InputError::default());
        index
    }

    /// The input of a clock, added where the model has none.
    pub fn clock_input(&mut self, clock: Clock) -> usize {
        let input = self.model.clock_input(clock);
        if input == self.input_scales.len() {
            self.input_scales.push(Scale { unit: None });
            self.input_errors.push(InputError::default());
        }
        input
    }

    /// Takes note of what an effect has added to the model: its parameters with their units and priors, its nodes,
    /// elements and quantities.
    pub fn note_additions(&mut self, parameters: impl IntoIterator<Item = (Unit, Distribution)>) {
        for (unit, prior) in parameters {
            self.parameter_scales.push(Scale { unit: Some(unit) });
            self.priors.push(Prior::Distribution(prior));
        }
        self.nodes = self.model.nodes.iter().enumerate().map(|(i, node)| (node.name.clone(), i)).collect();
        self.elements.clear();
        for (index, element) in self.model.elements.iter().enumerate() {
            self.elements.entry(element.name.clone()).or_default().push(index);
        }
        for quantity in &self.model.quantities[self.quantity_dimensions.len()..] {
            let unit = Unit::parse(&quantity.unit);
            self.quantity_dimensions.push(unit.map_or(Dimension::NONE, |unit| unit.dimension));
        }
    }

    fn name(&mut self, name: &str, symbol: Symbol, scale: &Scale) {
        let id = self.model.graph.symbol(symbol);
        self.names.values.insert(name.to_owned(), id);
        if let Some(dimension) = scale.dimension() {
            self.names.dimensions.insert(symbol, dimension);
        }
    }
}

/// Resolves a model, whose program and tables lie in the folder. `None` where there is an error; warnings may stand beside a model.
pub fn resolve(form: &ModelForm, folder: Option<&Folder>, diagnostics: &mut Diagnostics) -> Option<ResolvedModel> {
    let before = diagnostics.errors();
    let mut model = ResolvedModel::default();
    model.model.title.clone_from(&form.title);
    model.places.file.clone_from(&form.format.place);
    if let Some(tables) = &form.tabulated {
        // With a folder their rows have become entries, and this member is gone.
        let message = "tables of couplings cannot be read without the study's folder";
        diagnostics.push(Diagnostic::error(&code::FILE_MISSING, &tables.place, message).expected("a model in a study"));
    }
    for entry in &form.parameters {
        model.resolve_parameter(entry, diagnostics);
    }
    for entry in &form.inputs {
        if let Some(parameter) = form.parameters.get(&entry.name) {
            diagnostics.push(
                Diagnostic::error(
                    &code::DUPLICATE_NAME,
                    &entry.name_place,
                    format!("`{}` is the name of an input and of a parameter", entry.name),
                )
                .related(&parameter.name_place, "the parameter")
                .help("rename one of them: expressions could not tell them apart"),
            );
        }
        model.resolve_input(entry, diagnostics);
    }
    name::check_labels(&form.tables, diagnostics);
    for entry in &form.tables {
        model.resolve_table(entry, diagnostics);
    }
    name::check_labels(&form.nodes, diagnostics);
    model.nodes = form.nodes.names().enumerate().map(|(i, name)| (name.to_owned(), i)).collect();
    for (index, entry) in form.nodes.iter().enumerate() {
        model.resolve_node(index, entry, diagnostics);
    }
    form.resolve_elements(&mut model, diagnostics);
    for (index, element) in model.model.elements.iter().enumerate() {
        model.elements.entry(element.name.clone()).or_default().push(index);
    }
    if diagnostics.errors() > before {
        // Groups and quantities speak of nodes and elements: some are missing now, through no fault of theirs.
        return None;
    }
    model.reconstructed.clone_from(&form.reconstructed);
    outside::resolve(form, folder, &mut model, diagnostics)?;
    model.groups = group::resolve(&form.groups, &model, diagnostics);
    model.groups.extend(implied_groups::implied(&model, &model.groups));
    quantity::resolve_all(&form.quantities, &mut model, diagnostics);
    if model.model.nodes.is_empty() && model.model.quantities.is_empty() {
        diagnostics.push(
            Diagnostic::error(&code::EMPTY_MODEL, &form.format.place, "the model has neither nodes nor quantities")
                .expected("beside it \"nodes\", or \"quantities\" of an algebraic model"),
        );
    }
    (diagnostics.errors() == before).then_some(model)
}

/// The scale of an entry: its unit, or the one beside its nominal value.
fn scale(unit: &Option<WrittenUnit>, nominal: &Amount) -> Scale {
    let written = unit.as_ref().or(nominal.unit.as_ref());
    Scale { unit: written.map(|written| written.unit.clone()) }
}

/// A pair in order, in SI.
fn ordered(
    pair: &Spanned<[Amount; 2]>,
    what: &str,
    convert: impl Fn(&Amount, &mut Diagnostics) -> Option<f64>,
    diagnostics: &mut Diagnostics,
) -> Option<[f64; 2]> {
    let [low, high] = &pair.value;
    let (lower, upper) = (convert(low, diagnostics), convert(high, diagnostics));
    let (lower, upper) = (lower?, upper?);
    if lower < upper {
        return Some([lower, upper]);
    }
    let message = format!("{what} [{}, {}] is not in order", low.value, high.value);
    diagnostics.push(
        Diagnostic::error(&code::OUT_OF_RANGE, &pair.place, message).expected("[lower, upper], lower below upper"),
    );
    None
}

impl ResolvedModel {
    fn resolve_parameter(&mut self, entry: &MapEntry<ParameterForm>, diagnostics: &mut Diagnostics) {
        name::check_symbol(&entry.name, &entry.name_place, diagnostics);
        let form = &entry.value;
        let scale = scale(&form.unit, &form.nominal);
        let nominal = scale.si(&form.nominal, Sense::Absolute, diagnostics).unwrap_or_default();
        let dimension = scale.dimension().unwrap_or(Dimension::NONE);
        let prior = match &form.prior {
            Some(prior) => prior.resolve(scale.unit.as_ref(), dimension, Sense::Absolute, diagnostics),
            None => None,
        };
        if let Some(Prior::Distribution(distribution)) = &prior {
            let [lower, upper] = support(distribution);
            if nominal < lower || nominal > upper {
                let shown = |value: f64| match &scale.unit {
                    Some(unit) => unit.from_si(value),
                    None => value,
                };
                let message = format!(
                    "the nominal value {} of `{}` lies outside its prior, {} to {} {}",
                    form.nominal.value,
                    entry.name,
                    shown(lower),
                    shown(upper),
                    scale.text()
                );
                diagnostics.push(
                    Diagnostic::warning(&code::NOMINAL_OUTSIDE, &form.nominal.place, message)
                        .expected("a value within the prior"),
                );
            }
        }
        let parameter = Parameter {
            name: entry.name.clone(),
            unit: scale.text().to_owned(),
            nominal,
            description: form.description.clone().unwrap_or_default(),
            source: form.source.clone().unwrap_or_default(),
        };
        self.add_parameter(parameter, scale, prior.unwrap_or(Prior::Distribution(Distribution::Fixed(nominal))));
    }

    fn resolve_input(&mut self, entry: &MapEntry<InputForm>, diagnostics: &mut Diagnostics) {
        name::check_symbol(&entry.name, &entry.name_place, diagnostics);
        let form = &entry.value;
        let scale = scale(&form.unit, &form.nominal);
        let nominal = scale.si(&form.nominal, Sense::Absolute, diagnostics).unwrap_or_default();
        let convert = |amount: &Amount, diagnostics: &mut Diagnostics| scale.si(amount, Sense::Absolute, diagnostics);
        let range = form.range.as_ref().and_then(|pair| ordered(pair, "the range", convert, diagnostics));
        if let (Some([lower, upper]), Some(pair)) = (range, &form.range)
            && (nominal < lower || nominal > upper)
        {
            let [low, high] = &pair.value;
            let message = format!(
                "the nominal value {} of `{}` lies outside its range, {} to {}",
                form.nominal.value, entry.name, low.value, high.value
            );
            diagnostics.push(
                Diagnostic::warning(&code::NOMINAL_OUTSIDE, &form.nominal.place, message)
                    .expected("a value within the range"),
            );
        }
        let sigma = form.sigma.as_ref().and_then(|amount| {
            let sigma = scale.si(amount, Sense::Difference, diagnostics)?;
            if sigma > 0.0 {
                return Some(sigma);
            }
            let message = format!("a standard deviation of {} is not above 0", amount.value);
            diagnostics
                .push(Diagnostic::error(&code::OUT_OF_RANGE, &amount.place, message).expected("a number above 0"));
            None
        });
        let dimension = scale.dimension().unwrap_or(Dimension::NONE);
        let bias = form
            .bias
            .as_ref()
            .and_then(|bias| bias.prior.resolve(scale.unit.as_ref(), dimension, Sense::Difference, diagnostics));
        let index = self.model.inputs.len();
        self.name(&entry.name, Symbol::Input(u32::try_from(index).unwrap_or(u32::MAX)), &scale);
        self.model.inputs.push(Input {
            name: entry.name.clone(),
            unit: scale.text().to_owned(),
            nominal,
            range,
            settable: form.settable,
            description: form.description.clone().unwrap_or_default(),
        });
        self.input_scales.push(scale);
        self.input_errors.push(InputError { sigma, bias });
        self.test_sets.push(form.test_sets);
    }

    fn resolve_table(&mut self, entry: &MapEntry<TableForm>, diagnostics: &mut Diagnostics) {
        let (x, y) = (&entry.value.x, &entry.value.y);
        if x.value.len() != y.value.len() {
            let message = format!("the table has {} x and {} y", x.value.len(), y.value.len());
            diagnostics.push(
                Diagnostic::error(&code::INVALID_TABLE, &y.place, message)
                    .expected(format!("{} numbers", x.value.len())),
            );
        } else if x.value.is_empty() {
            diagnostics.push(
                Diagnostic::error(&code::INVALID_TABLE, &x.place, "the table is empty").expected("at least one point"),
            );
        } else if let Some(i) = (1..x.value.len()).find(|&i| x.value[i] <= x.value[i - 1]) {
            let message = format!("x does not increase: {} follows {}", x.value[i], x.value[i - 1]);
            diagnostics.push(
                Diagnostic::error(&code::INVALID_TABLE, &x.place, message).expected("strictly increasing numbers"),
            );
        }
        // Kept even when wrong, so that expressions that use it have no error of their own.
        let table = self.model.graph.table(Table { x: x.value.clone(), y: y.value.clone() });
        self.names.tables.insert(entry.name.clone(), table);
    }

    fn resolve_node(&mut self, index: usize, entry: &MapEntry<NodeForm>, diagnostics: &mut Diagnostics) {
        const BOUNDARY: Expected = Expected::value(Dimension::TEMPERATURE, "a boundary temperature").given();
        const CAPACITY: Expected = Expected {
            // Its own temperature, and nothing else of the network; time would make energy from nothing.
            allowed: Dependence::PARAMETER.union(Dependence::INPUT).union(Dependence::NODE),
            ..Expected::value(Dimension::HEAT_CAPACITY, "a heat capacity")
        };
        let form = &entry.value;
        self.places.note("node", &entry.name, "", &entry.name_place);
        for (what, scalar) in [("temperature", &form.boundary), ("heat capacity", &form.capacity)] {
            if let Some(scalar) = scalar {
                self.places.note("node", &entry.name, what, scalar.place());
            }
        }
        let refuse = |place: &Place, message: String, expected: &str, diagnostics: &mut Diagnostics| {
            diagnostics.push(Diagnostic::error(&code::OUT_OF_RANGE, place, message).expected(expected));
        };
        let kind = match (&form.boundary, &form.capacity) {
            (Some(_), Some(capacity)) => {
                let message = format!("the node `{}` has a boundary temperature and a heat capacity", entry.name);
                diagnostics.push(
                    Diagnostic::error(&code::ONE_KIND, capacity.place(), message)
                        .expected("either `boundary` or `capacity`, or neither")
                        .help("a boundary's temperature is given, so its capacity plays no part: remove `capacity`"),
                );
                NodeKind::Arithmetic
            }
            (Some(boundary), None) => match self.formulas().scalar(boundary, BOUNDARY, &[], diagnostics) {
                Some(temperature) => {
                    if let Some(value) = self.model.graph.constant(temperature).filter(|v| *v <= 0.0) {
                        let expected = "a temperature above 0 K, or {\"value\": ..., \"unit\": \"degC\"}";
                        refuse(boundary.place(), format!("a boundary temperature of {value} K"), expected, diagnostics);
                    }
                    NodeKind::Boundary { temperature }
                }
                None => NodeKind::Arithmetic,
            },
            (None, Some(capacity)) => {
                let mut formulas = self.formulas();
                let locals = [("T", formulas.node(index))];
                match formulas.scalar(capacity, CAPACITY, &locals, diagnostics) {
                    Some(id) => {
                        if let Some(value) = self.model.graph.constant(id).filter(|v| *v <= 0.0) {
                            let expected = "a heat capacity above 0 J/K; leave it out for a node that stores no heat";
                            refuse(capacity.place(), format!("a heat capacity of {value} J/K"), expected, diagnostics);
                        }
                        NodeKind::Diffusion { capacity: id }
                    }
                    None => NodeKind::Arithmetic,
                }
            }
            (None, None) => NodeKind::Arithmetic,
        };
        let area = form.area.as_ref().and_then(|amount| {
            let area = amount.si(Dimension::AREA, None, Sense::Absolute, diagnostics)?;
            if area <= 0.0 {
                refuse(&amount.place, format!("an area of {area} m2"), "an area above 0", diagnostics);
            }
            Some(area)
        });
        let limits = form.limits.as_ref().map(|limits| resolve_limits(limits, diagnostics)).unwrap_or_default();
        self.model.nodes.push(Node { name: entry.name.clone(), kind, area, alias: form.alias.clone(), limits });
    }
}

fn resolve_limits(form: &LimitsForm, diagnostics: &mut Diagnostics) -> Limits {
    let mut pair = |pair: &Option<Spanned<[Amount; 2]>>| {
        let convert = |amount: &Amount, diagnostics: &mut Diagnostics| {
            amount.si(Dimension::TEMPERATURE, None, Sense::Absolute, diagnostics)
        };
        pair.as_ref().and_then(|pair| ordered(pair, "the pair of limits", convert, diagnostics))
    };
    Limits { yellow: pair(&form.yellow), red: pair(&form.red) }
}
