//! What was asked: requirements, parameters with priors and sources, inputs, environments, changes.

use crate::random::Distribution;
use crate::report::number::{NONE, Shown, as_given, probability};
use crate::report::page::{Block, Cell, Column, Section, Table, Text};
use crate::report::view::PassReport;
use crate::thermal::Parameter;

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The section on the problem; always there.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for paragraph in report.description.split("\n\n").map(str::trim).filter(|p| !p.is_empty()) {
        blocks.push(Block::paragraph(paragraph));
    }
    blocks.extend(requirements(report));
    blocks.extend(parameters(report));
    blocks.extend(inputs(report));
    blocks.extend(environments(report));
    blocks.extend(changes(report));
    Some(Section { id: "problem", title: "Problem".into(), blocks })
}

fn requirements(report: &PassReport<'_>) -> Vec<Block> {
    if report.requirements.is_empty() {
        return Vec::new();
    }
    let rows = report
        .requirements
        .iter()
        .map(|requirement| {
            let shown = report.requirement_shown(requirement);
            let quantity = report.model.quantities.get(requirement.quantity).map_or(NONE, |q| q.name.as_str());
            vec![
                Cell::code(&requirement.name),
                Cell::code(quantity),
                limits(&shown, requirement.above, requirement.below).into(),
                probability(requirement.probability).into(),
            ]
        })
        .collect();
    vec![
        Block::Heading("Requirements".into()),
        Block::Table(Table {
            caption: "What the system must satisfy, and with what probability.".into(),
            columns: vec![
                Column::text("Requirement"),
                Column::text("Quantity"),
                Column::text("Limit"),
                Column::number("Required probability", ""),
            ],
            rows,
        }),
    ]
}

/// Limits in words.
pub(super) fn limits(shown: &Shown, above: Option<f64>, below: Option<f64>) -> String {
    match (above, below) {
        (Some(low), Some(high)) => format!("{} to {}", shown.number(low), shown.text(high)),
        (Some(low), None) => format!("at least {}", shown.text(low)),
        (None, Some(high)) => format!("at most {}", shown.text(high)),
        (None, None) => NONE.to_owned(),
    }
}

/// A prior in words, in a unit that stands beside.
pub fn prior_words(prior: &Distribution, shown: &Shown) -> String {
    let number = |si: f64| as_given(shown.value(si));
    let spread = |si: f64| as_given(shown.difference().value(si));
    match *prior {
        Distribution::Fixed(value) => format!("fixed at {}", number(value)),
        Distribution::Uniform { lower, upper } => format!("uniform, {} to {}", number(lower), number(upper)),
        Distribution::Normal { mean, sd, lower, upper } => {
            let cut = match (lower, upper) {
                (Some(a), Some(b)) => format!(", cut to {} to {}", number(a), number(b)),
                (Some(a), None) => format!(", above {}", number(a)),
                (None, Some(b)) => format!(", below {}", number(b)),
                (None, None) => String::new(),
            };
            format!("normal, {} \u{00B1} {}{cut}", number(mean), spread(sd))
        }
        Distribution::LogNormal { median, factor } => {
            format!("lognormal, median {}, factor {}", number(median), as_given(factor))
        }
        Distribution::LogUniform { lower, upper } => format!("loguniform, {} to {}", number(lower), number(upper)),
        Distribution::HalfNormal { scale } => format!("half-normal, scale {}", spread(scale)),
        Distribution::Triangular { lower, mode, upper } => {
            format!("triangular, {}, {}, {}", number(lower), number(mode), number(upper))
        }
    }
}

/// How a parameter is shown by its nominal value, or by its prior's spread where that is larger.
pub fn parameter_shown(parameter: &Parameter, prior: Option<&Distribution>) -> Shown {
    let spread = prior.map_or(0.0, Distribution::sd);
    let size = parameter.nominal.abs().max(if spread.is_finite() { spread } else { 0.0 });
    Shown::parameter_of(&parameter.unit, size)
}

fn parameters(report: &PassReport<'_>) -> Vec<Block> {
    if report.model.parameters.is_empty() {
        return Vec::new();
    }
    let rows = report
        .model
        .parameters
        .iter()
        .map(|parameter| {
            let prior = report.priors.iter().find(|p| p.0 == parameter.name);
            let shown = parameter_shown(parameter, prior.map(|prior| &prior.1));
            let draws = report.posterior_priors.iter().find(|(name, _)| *name == parameter.name);
            let prior = match draws {
                Some((_, source)) => format!("draws of {}", source.replace('`', "")),
                None => prior.map_or_else(|| "fixed".to_owned(), |p| prior_words(&p.1, &shown)),
            };
            vec![
                Cell::code(&parameter.name),
                as_given(shown.value(parameter.nominal)).into(),
                shown.unit.clone().into(),
                prior.into(),
                parameter.description.clone().into(),
                parameter.source.clone().into(),
            ]
        })
        .collect();
    vec![
        Block::Heading("Parameters".into()),
        Block::Table(Table {
            caption: "Parameters with nominal values and priors.".into(),
            columns: vec![
                Column::text("Parameter"),
                Column::number("Nominal", ""),
                Column::text("Unit"),
                Column::text("Prior"),
                Column::text("Description"),
                Column::text("Source"),
            ],
            rows,
        }),
    ]
}

fn inputs(report: &PassReport<'_>) -> Vec<Block> {
    if report.model.inputs.is_empty() {
        return Vec::new();
    }
    let rows = report
        .model
        .inputs
        .iter()
        .map(|input| {
            let shown = Shown::written(&input.unit);
            let number = |si: f64| as_given(shown.value(si));
            vec![
                Cell::code(&input.name),
                number(input.nominal).into(),
                shown.unit.clone().into(),
                input.range.map_or_else(|| NONE.to_owned(), |[a, b]| format!("{} to {}", number(a), number(b))).into(),
                (if input.settable { "yes" } else { "no" }).into(),
                input.description.clone().into(),
            ]
        })
        .collect();
    vec![
        Block::Heading("Inputs".into()),
        Block::Table(Table {
            caption: "Inputs: what is imposed on the system.".into(),
            columns: vec![
                Column::text("Input"),
                Column::number("Nominal", ""),
                Column::text("Unit"),
                Column::text("Range"),
                Column::text("A test can set it"),
                Column::text("Description"),
            ],
            rows,
        }),
    ]
}

fn environments(report: &PassReport<'_>) -> Vec<Block> {
    // One environment at nominal inputs says nothing beyond the table of inputs.
    let is_nominal = |e: &crate::study::requirement::Environment| {
        e.inputs.iter().zip(&report.model.inputs).all(|(value, input)| *value == input.nominal)
    };
    if report.model.inputs.is_empty() || report.environments.iter().all(is_nominal) {
        return Vec::new();
    }
    let mut columns = vec![Column::text("Environment")];
    columns.extend(report.model.inputs.iter().map(|i| Column::number(&i.name, Shown::written(&i.unit).unit)));
    let rows = report
        .environments
        .iter()
        .map(|environment| {
            let mut row = vec![Cell::code(&environment.name)];
            row.extend(report.model.inputs.iter().enumerate().map(|(position, input)| {
                let value = environment.inputs.get(position).copied().unwrap_or(f64::NAN);
                Cell::from(as_given(Shown::written(&input.unit).value(value)))
            }));
            row
        })
        .collect();
    vec![
        Block::Heading("Environments".into()),
        Block::Table(Table { caption: "Values of the inputs in each environment.".into(), columns, rows }),
    ]
}

fn changes(report: &PassReport<'_>) -> Vec<Block> {
    if report.changes.is_empty() {
        return Vec::new();
    }
    let rows = report
        .changes
        .iter()
        .map(|change| {
            vec![
                Cell::code(&change.what),
                change.before.clone().into(),
                change.after.clone().into(),
                if change.because.trim().is_empty() {
                    Cell::marked("no reason given", crate::report::page::Status::Caution)
                } else {
                    Cell::from(Text::with_names(&change.because))
                },
            ]
        })
        .collect();
    vec![
        Block::Heading("Changes in this pass".into()),
        Block::Table(Table {
            caption: Text::new("Every change against the parent pass, with its reason."),
            columns: vec![Column::text("What"), Column::text("Before"), Column::text("After"), Column::text("Because")],
            rows,
        }),
    ]
}
