//! Quantities: what is asked of a model.

use crate::document::formula::Expected;
use crate::document::{
    Diagnostic, Diagnostics, Map, NameOr, Place, Sense, Spanned, WrittenUnit, code, written_choice, written_struct,
};
use crate::expression::{Dependence, Dimension, ExprId};
use crate::thermal::element::{Contribution, Lookup};
use crate::thermal::{Quantity, QuantityValue};

use super::name;
use super::resolve::ResolvedModel;

/// A quantity, or a name: of a node for its temperature, or of a quantity of the model.
pub type QuantityOrName = NameOr<QuantityForm>;

written_choice! {
    /// Something that is asked of a model.
    pub enum QuantityForm: "a quantity" {
        /// Temperature of a node.
        "temperature" => Temperature(Spanned<String>),
        /// Weighted mean temperature of nodes, by their weights.
        "mean" => Mean(Spanned<Map<Spanned<f64>>>),
        /// First minus second.
        "difference" => Difference([Box<QuantityOrName>; 2]),
        /// Heat through an element, W, from its first to its second end, into its node, or out of a cooler's cold side.
        "heat" => Heat(Spanned<String>),
        /// Current of a cooler, A.
        "current" => Current(Spanned<String>),
        /// Temperature of the cold side of a cooler that response surfaces stand for.
        "cold_side" => ColdSide(Spanned<String>),
        /// Duty of a heater, 0 to 1.
        "duty" => Duty(Spanned<String>),
        /// A quantity over the whole of a transient.
        "over_time" => OverTime(OverTimeForm),
        /// An expression of parameters, inputs, `t` and other quantities.
        "expression" => Expression(Box<ExpressionForm>),
    }
}

written_choice! {
    /// A quantity over the whole of a transient.
    pub enum OverTimeForm: "a quantity over time" {
        /// Its largest value.
        "maximum" => Maximum(Box<QuantityOrName>),
        /// Its smallest value.
        "minimum" => Minimum(Box<QuantityOrName>),
        /// Its time average.
        "mean" => Mean(Box<QuantityOrName>),
    }
}

written_struct! {
    /// An expression with its unit.
    pub struct ExpressionForm: "an object {\"of\": ..., \"unit\": ...}" {
        /// The expression.
        required of: Spanned<String>,
        /// Names in it that stand for other quantities.
        default(Map::default()) with: Map<QuantityOrName>,
        /// Its SI unit; `degC` says that its value in K is shown in degC.
        required unit: WrittenUnit,
    }
}

/// Quantities within quantities nested deeper are refused.
const DEEPEST: usize = 16;

/// A quantity without a name.
struct Unnamed {
    value: QuantityValue,
    dimension: Dimension,
    /// On the absolute scale of temperature.
    absolute: bool,
    unit: String,
}

impl Unnamed {
    fn instant(id: ExprId, dimension: Dimension, absolute: bool) -> Self {
        Self { value: QuantityValue::Instant(id), dimension, absolute, unit: dimension.to_string() }
    }
}

/// Resolves a quantity under a name. New expressions go into the model's graph. `place` is where it is asked for.
pub fn resolve(
    name: &str,
    form: &QuantityOrName,
    model: &mut ResolvedModel,
    diagnostics: &mut Diagnostics,
) -> Option<Quantity> {
    let Unnamed { value, absolute, unit, .. } = either(form, model, 0, diagnostics)?;
    Some(Quantity { name: name.to_owned(), unit, is_temperature: absolute, value })
}

/// Where a quantity stands.
fn place_of(form: &QuantityOrName) -> Option<&Place> {
    match form {
        NameOr::Name(name) => Some(&name.place),
        NameOr::Other(form) => match form {
            QuantityForm::Temperature(name)
            | QuantityForm::Heat(name)
            | QuantityForm::Current(name)
            | QuantityForm::ColdSide(name)
            | QuantityForm::Duty(name) => Some(&name.place),
            QuantityForm::Mean(map) => Some(&map.place),
            QuantityForm::Difference(pair) => place_of(&pair[0]),
            QuantityForm::OverTime(OverTimeForm::Maximum(q) | OverTimeForm::Minimum(q) | OverTimeForm::Mean(q)) => {
                place_of(q)
            }
            QuantityForm::Expression(form) => Some(&form.of.place),
        },
    }
}

fn either(
    form: &QuantityOrName,
    model: &mut ResolvedModel,
    depth: usize,
    diagnostics: &mut Diagnostics,
) -> Option<Unnamed> {
    if depth > DEEPEST {
        if let Some(place) = place_of(form) {
            let message = format!("quantities nested deeper than {DEEPEST} levels");
            diagnostics.push(Diagnostic::error(&code::EXPRESSION_DEPTH, place, message));
        }
        return None;
    }
    match form {
        NameOr::Name(name) => named(name, model, diagnostics),
        NameOr::Other(form) => unnamed(form, model, depth, diagnostics),
    }
}

/// A node's temperature, or a quantity of the model.
fn named(name: &Spanned<String>, model: &mut ResolvedModel, diagnostics: &mut Diagnostics) -> Option<Unnamed> {
    if let Some(node) = model.node(&name.value) {
        let id = model.formulas().node(node);
        return Some(Unnamed::instant(id, Dimension::TEMPERATURE, true));
    }
    if let Some(index) = model.quantity(&name.value) {
        let quantity = &model.model.quantities[index];
        return Some(Unnamed {
            value: quantity.value,
            dimension: model.quantity_dimensions[index],
            absolute: quantity.is_temperature,
            unit: quantity.unit.clone(),
        });
    }
    let node_names = model.model.nodes.iter().map(|n| n.name.as_str());
    let listed_names = node_names.chain(model.model.quantities.iter().map(|q| q.name.as_str()));
    name::unknown("node or quantity", &name.value, &name.place, listed_names, diagnostics);
    None
}

/// A quantity at an instant: over a whole transient is refused inside others.
fn instant(
    form: &QuantityOrName,
    model: &mut ResolvedModel,
    depth: usize,
    diagnostics: &mut Diagnostics,
) -> Option<(ExprId, Unnamed)> {
    let inner = either(form, model, depth + 1, diagnostics)?;
    if let QuantityValue::Instant(id) = inner.value {
        return Some((id, inner));
    }
    if let Some(place) = place_of(form) {
        diagnostics.push(
            Diagnostic::error(
                &code::NESTED_OVER_TIME,
                place,
                "a quantity over time cannot stand inside another quantity",
            )
            .expected("a quantity at an instant"),
        );
    }
    None
}

fn unnamed(
    form: &QuantityForm,
    model: &mut ResolvedModel,
    depth: usize,
    diagnostics: &mut Diagnostics,
) -> Option<Unnamed> {
    match form {
        QuantityForm::Temperature(name) => {
            let node = model.find_node(&name.value, &name.place, diagnostics)?;
            let id = model.formulas().node(node);
            Some(Unnamed::instant(id, Dimension::TEMPERATURE, true))
        }
        QuantityForm::Mean(weights) => mean(weights, model, diagnostics),
        QuantityForm::Difference(pair) => {
            let first = instant(&pair[0], model, depth, diagnostics);
            let second = instant(&pair[1], model, depth, diagnostics);
            let ((a, first), (b, second)) = (first?, second?);
            if first.dimension != second.dimension
                && let Some(place) = place_of(&pair[1])
            {
                let message = format!("a difference of {} and {}", first.dimension, second.dimension);
                diagnostics.push(Diagnostic::error(&code::WRONG_DIMENSION, place, message).expected("two of one unit"));
                return None;
            }
            let id = model.model.graph.subtract(a, b);
            Some(Unnamed::instant(id, first.dimension, first.absolute && !second.absolute))
        }
        QuantityForm::Heat(name) => {
            let element = model.find_element(&name.value, None, &name.place, diagnostics)?;
            let id = model.contribution(element).through?;
            Some(Unnamed::instant(id, Dimension::POWER, false))
        }
        QuantityForm::Current(name) => {
            let id = model.find_output(&name.value, "current", |element| element.current, &name.place, diagnostics)?;
            Some(Unnamed::instant(id, Dimension::CURRENT, false))
        }
        QuantityForm::ColdSide(name) => {
            let output = |element: &Contribution| element.cold_side;
            let id = model.find_output(&name.value, "cold side of surfaces", output, &name.place, diagnostics)?;
            Some(Unnamed::instant(id, Dimension::TEMPERATURE, true))
        }
        QuantityForm::Duty(name) => {
            let id = model.find_output(&name.value, "duty", |element| element.duty, &name.place, diagnostics)?;
            Some(Unnamed::instant(id, Dimension::NONE, false))
        }
        QuantityForm::OverTime(form) => {
            let (inner, make): (_, fn(ExprId) -> QuantityValue) = match form {
                OverTimeForm::Maximum(inner) => (inner, QuantityValue::Maximum),
                OverTimeForm::Minimum(inner) => (inner, QuantityValue::Minimum),
                OverTimeForm::Mean(inner) => (inner, QuantityValue::TimeMean),
            };
            let (id, inner) = instant(inner, model, depth, diagnostics)?;
            Some(Unnamed { value: make(id), ..inner })
        }
        QuantityForm::Expression(form) => expression(form, model, depth, diagnostics),
    }
}

fn mean(
    weights: &Spanned<Map<Spanned<f64>>>,
    model: &mut ResolvedModel,
    diagnostics: &mut Diagnostics,
) -> Option<Unnamed> {
    let mut members = Vec::new();
    let mut total = 0.0;
    for entry in &weights.value {
        let weight = entry.value.value;
        let node = model.find_node(&entry.name, &entry.name_place, diagnostics);
        if weight < 0.0 {
            let message = format!("the weight {weight} is below 0");
            diagnostics.push(Diagnostic::error(&code::OUT_OF_RANGE, &entry.place, message).expected("a weight from 0"));
            return None;
        }
        total += weight;
        members.push((node?, weight));
    }
    if !(total > 0.0 && total.is_finite()) {
        let message = format!("the weights of a mean sum to {total}");
        diagnostics.push(
            Diagnostic::error(&code::OUT_OF_RANGE, &weights.place, message).expected("weights with a sum above 0"),
        );
        return None;
    }
    let formulas = model.formulas();
    let mut terms = Vec::new();
    for (node, weight) in members {
        let temperature =
            formulas.graph.symbol(crate::expression::Symbol::Node(u32::try_from(node).unwrap_or(u32::MAX)));
        let share = formulas.graph.number(weight / total);
        terms.push(formulas.graph.multiply(share, temperature));
    }
    // In pairs: a chain of thousands of terms would be as deep as it is long.
    while terms.len() > 1 {
        terms = terms.chunks(2).map(|pair| formulas.graph.sum(pair)).collect();
    }
    Some(Unnamed::instant(*terms.first()?, Dimension::TEMPERATURE, true))
}

fn expression(
    form: &ExpressionForm,
    model: &mut ResolvedModel,
    depth: usize,
    diagnostics: &mut Diagnostics,
) -> Option<Unnamed> {
    let mut locals = Vec::new();
    let mut valid = true;
    for entry in &form.with {
        valid &= name::check_symbol(&entry.name, &entry.name_place, diagnostics);
        match instant(&entry.value, model, depth, diagnostics) {
            Some((id, _)) => locals.push((entry.name.as_str(), id)),
            None => valid = false,
        }
    }
    if !valid {
        return None;
    }
    let unit = &form.unit.unit;
    if unit.factor != 1.0 {
        let message = format!("an expression's value is SI; `{}` is not", unit.text);
        diagnostics.push(
            Diagnostic::error(&code::WRONG_DIMENSION, &form.unit.place, message)
                .expected(format!("the SI unit `{}`", unit.dimension)),
        );
        return None;
    }
    let expected = Expected {
        dimension: unit.dimension,
        sense: Sense::Absolute,
        allowed: Expected::GIVEN.union(Dependence::NODE),
        what: "the quantity",
    };
    let id = model.formulas().text(&form.of, expected, &locals, diagnostics)?;
    let text = if unit.has_offset() { "K".to_owned() } else { unit.text.clone() };
    Some(Unnamed {
        value: QuantityValue::Instant(id),
        dimension: unit.dimension,
        absolute: unit.has_offset(),
        unit: text,
    })
}

/// Resolves the model's own quantities, each of which may use those before it.
pub(super) fn resolve_all(form: &Map<QuantityOrName>, model: &mut ResolvedModel, diagnostics: &mut Diagnostics) {
    name::check_labels(form, diagnostics);
    for entry in form {
        let itself = matches!(&entry.value, NameOr::Name(name) if name.value == entry.name)
            || matches!(&entry.value, NameOr::Other(QuantityForm::Temperature(name)) if name.value == entry.name);
        if model.node(&entry.name).is_some() && !itself {
            diagnostics.push(
                Diagnostic::error(
                    &code::DUPLICATE_NAME,
                    &entry.name_place,
                    format!("the quantity `{}` has the name of a node", entry.name),
                )
                .help("a node's name alone means its temperature: rename the quantity"),
            );
            continue;
        }
        let Some(Unnamed { value, dimension, absolute, unit }) = either(&entry.value, model, 0, diagnostics) else {
            continue;
        };
        model.quantity_dimensions.push(dimension);
        model.model.quantities.push(Quantity { name: entry.name.clone(), unit, is_temperature: absolute, value });
    }
}
