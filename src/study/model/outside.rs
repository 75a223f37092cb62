//! A model that a program or a server answers for, in place of nodes and elements.

use std::sync::Arc;

use crate::document::prior::Prior;
use crate::document::{Diagnostic, Diagnostics, code, name};
use crate::expression::{Dimension, ExprId, Symbol};
use crate::random::Distribution;
use crate::study::external::{self, Asked, External, Given, Output, Sources};
use crate::study::folder::Folder;
use crate::thermal::{self, Quantity, QuantityValue};

use super::form::ModelForm;
use super::resolve::ResolvedModel;
use super::surrogate;

/// Share of a prior's standard deviation, as its middle two thirds have it, that is the step of differences.
const STEP: f64 = 1e-3;

/// Resolves what answers for the model, and makes quantities of its outputs. `None` where something is wrong with it.
pub(super) fn resolve(
    form: &ModelForm,
    folder: Option<&Folder>,
    model: &mut ResolvedModel,
    diagnostics: &mut Diagnostics,
) -> Option<()> {
    let place = match (&form.command, &form.umbridge) {
        (None, None) => {
            let Some(surrogate) = &form.surrogate else { return Some(()) };
            let message = "a surrogate stands for a model that is asked outside, and this one is not";
            let diagnostic = Diagnostic::error(&code::EXTERNAL_MODEL, &surrogate.place, message);
            diagnostics.push(diagnostic.expected("beside it \"command\" or \"umbridge\""));
            return None;
        }
        (Some(_), Some(server)) => {
            let message = "a model has `command` or `umbridge`, not both";
            diagnostics.push(Diagnostic::error(&code::EXTERNAL_MODEL, &server.place, message).expected("one of them"));
            return None;
        }
        (Some(command), None) => &command.place,
        (None, Some(server)) => &server.place,
    };
    let refuse = |message: &str, expected: &str, diagnostics: &mut Diagnostics| {
        diagnostics.push(Diagnostic::error(&code::EXTERNAL_MODEL, place, message).expected(expected));
    };
    if !model.model.nodes.is_empty() || !model.model.elements.is_empty() {
        refuse(
            "a model that is asked outside has no nodes and elements of its own",
            "either `nodes`, or `command` or `umbridge`",
            diagnostics,
        );
        return None;
    }
    let Some(folder) = folder else {
        refuse("what lies outside cannot be had without the study's folder", "a model in a study", diagnostics);
        return None;
    };
    let asked = asked(model);
    let sources = Sources { folder, asked: &asked, parameters: model.model.parameters.len() };
    let external = match (&form.command, &form.umbridge) {
        (Some(command), _) => external::command(command, &sources, diagnostics)?,
        (_, Some(server)) => external::umbridge(server, &sources, diagnostics)?,
        (None, None) => return Some(()),
    };
    match (&form.command, &form.umbridge) {
        (Some(command), _) => name::check_labels(&command.value.outputs, diagnostics),
        (_, Some(server)) => name::check_labels(&server.value.outputs, diagnostics),
        (None, None) => {}
    }
    if external.outputs.is_empty() {
        refuse("the model gives no outputs", "at least one under `outputs`", diagnostics);
        return None;
    }
    let asked = thermal::External {
        outputs: external.outputs.len(),
        description: external.description(),
        identity: external.identity(),
        steps: external.steps.clone(),
        derivatives: external.derivatives,
        errors: 0..0,
        evaluator: None,
    };
    let values: Vec<ExprId> = match &form.surrogate {
        None => {
            model.model.external = Some(asked);
            let symbols = (0_u32..).zip(&external.outputs).map(|(number, _)| Symbol::Output(number));
            symbols.map(|symbol| model.model.graph.symbol(symbol)).collect()
        }
        Some(form) => {
            let outputs: Vec<(String, String)> =
                external.outputs.iter().map(|output| (output.name.clone(), output.si_unit())).collect();
            surrogate::resolve(form, (asked, external.answered_by()), &outputs, model, diagnostics)?
        }
    };
    for ((number, output), value) in (0_u32..).zip(&external.outputs).zip(values) {
        put_quantity(model, Symbol::Output(number), output, value);
    }
    model.external = Some(Arc::<External>::new(external));
    Some(())
}

/// The output as a quantity of its name, of this value.
fn put_quantity(model: &mut ResolvedModel, symbol: Symbol, output: &Output, value: ExprId) {
    model.names.dimensions.insert(symbol, output.unit.dimension);
    model.model.quantities.push(Quantity {
        name: output.name.clone(),
        unit: output.si_unit(),
        is_temperature: output.unit.has_offset() || output.unit.dimension == Dimension::TEMPERATURE,
        value: QuantityValue::Instant(value),
    });
    model.quantity_dimensions.push(output.unit.dimension);
}

/// Parameters, then inputs, each with the step of differences where the study states none: a thousandth of half the distance
/// between the prior's 16 % and 84 % quantiles, of an input a ten-thousandth of its range.
fn asked(model: &ResolvedModel) -> Vec<Asked> {
    let of_size = |value: f64| if value == 0.0 { 1.0 } else { value.abs() };
    let parameters = model.model.parameters.iter().zip(&model.priors).zip(&model.parameter_scales);
    let parameters = parameters.map(|((parameter, prior), scale)| {
        let distribution = match prior {
            Prior::Distribution(distribution) if !distribution.is_fixed() => Some(distribution),
            _ => None,
        };
        let half = distribution.map(|prior: &Distribution| 0.5 * (prior.quantile(0.84) - prior.quantile(0.16)));
        Asked {
            given: Given { name: parameter.name.clone(), unit: scale.unit.clone() },
            step: STEP * half.filter(|half| *half > 0.0 && half.is_finite()).unwrap_or(of_size(parameter.nominal)),
            is_uncertain: !matches!(prior, Prior::Distribution(Distribution::Fixed(_))),
        }
    });
    let inputs = model.model.inputs.iter().zip(&model.input_scales).map(|(input, scale)| Asked {
        given: Given { name: input.name.clone(), unit: scale.unit.clone() },
        step: 0.1 * STEP * input.range.map_or(of_size(input.nominal), |[lower, upper]| upper - lower),
        is_uncertain: false,
    });
    parameters.chain(inputs).collect()
}
