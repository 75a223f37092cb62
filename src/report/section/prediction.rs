//! Predictions after calibration: the posterior carried to environments, beside the same with the priors.

mod brief;
pub mod tested;
pub(super) mod untested;

use crate::document::counted;
use crate::job::predict::{Kind, Output, Term, Validated};
use crate::job::propagate::{self, Met};
use crate::report::number::{self, NONE, Shown, significant, with_error};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text, Tone};
use crate::report::plot::{Along, Axis, Chart, Layer, Limit, Mark, Stroke, palette};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

use super::problem::limits;
use super::propagation::{
    along, cumulative, curve, environments, failures, histogram, joint, nominal_cases, probability_text, quantile,
    standing,
};
use super::validation::{Rests, claim_cell, objection};
use super::{Entry, prefix};

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Prediction);

/// The section on predictions; not without such a job.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for (name, output) in report.outputs::<Kind>() {
        blocks.push(Block::Paragraph(opening(name, output)));
        if !output.converged {
            let text = "The chains behind the posterior did not converge: nothing here is to be trusted.";
            blocks.push(Block::callout(Tone::Warning, text));
        }
        blocks.extend(failures(&output.posterior));
        blocks.extend(output.validated.iter().flat_map(|validated| added(report, validated)));
        blocks.extend(untested::table(report, name));
        if output.posterior.cases.iter().any(|case| !case.requirements.is_empty()) {
            blocks.push(requirements(report, output));
            let claims = nominal_cases(&output.posterior).flat_map(|case| &case.requirements);
            blocks.extend(objection(report, Rests::OnTuned, claims).map(|text| Block::callout(Tone::Warning, text)));
            blocks.extend(reached(output));
            blocks.extend(figures(output, name, false).into_iter().map(Block::Figure));
            blocks.extend(sweep(output));
        }
        blocks.extend(along::block(&output.posterior, name));
        blocks.push(distributions(output));
        let mut folded = Vec::new();
        for case in nominal_cases(&output.posterior) {
            for q in &case.quantities {
                folded.extend([histogram(case, q, name, false), cumulative(case, q, name)].map(Block::Figure));
            }
            folded
                .extend(case.joint.iter().map(|quantity_pair| Block::Figure(joint(report, case, quantity_pair, name))));
        }
        if !folded.is_empty() {
            blocks.push(Block::Details(format!("Distributions with the posterior ({})", folded.len()), folded));
        }
    }
    (!blocks.is_empty()).then(|| Section { id: "prediction", title: "Prediction after calibration".into(), blocks })
}

fn opening(name: &str, output: &Output) -> Text {
    let mut text = Text::new("Job ").code(name).plain(": ");
    for posterior_prior in &output.posterior.posterior_priors {
        text = text.plain(format!(
            "the posterior of {} ({}; {}, worth {} independent ones), ",
            posterior_prior.source.replace('`', ""),
            posterior_prior.parameters.join(", "),
            counted(posterior_prior.draws, "draw"),
            number::fixed(posterior_prior.effective, 0)
        ));
    }
    let added: Vec<String> = (output.posterior.discrepancy.iter())
        .map(|discrepancy| {
            format!("{} {} to {}", significant(discrepancy.sd, 3), discrepancy.unit, discrepancy.quantity)
        })
        .collect();
    if !added.is_empty() {
        let list = added.join(", ");
        text = text.plain(format!("with an error of the model added, normal with a standard deviation of {list}, "));
    }
    if let Some(validated) = &output.validated {
        let source = validated.source.replace('`', "");
        text = text.plain(format!("with the discrepancy of {source} added, "));
    }
    text.plain(format!(
        "carried to the environments in {} a case; other parameters keep their priors. Beside it the same with the priors that \
         the calibration began with. The intervals count what the number of draws leaves open.",
        counted(output.posterior.samples, "sample")
    ))
}

/// What a discrepancy job adds to the nominal cases, and where that is an extrapolation.
fn added(report: &PassReport<'_>, validated: &Validated) -> Vec<Block> {
    let input = |name: &str| report.model.inputs.iter().find(|own| own.name == name);
    let text = |name: &str, value: f64| {
        let shown = input(name).map_or_else(|| Shown::si(""), |own| Shown::written(&own.unit));
        shown.text(value)
    };
    let outside = |term: &Term| {
        let list = term.outside.iter().map(|own| {
            let [lower, upper] = own.tested;
            let tested = if lower == upper {
                format!("tested at {} alone", text(&own.input, lower))
            } else {
                format!("tested from {} to {}", text(&own.input, lower), text(&own.input, upper))
            };
            format!("{} = {}, {tested}", own.input, text(&own.input, own.value))
        });
        list.collect::<Vec<_>>().join("; ")
    };
    let mut blocks = Vec::new();
    let flagged = validated.terms.iter().filter(|term| !term.outside.is_empty()).count();
    if flagged > 0 {
        let text = format!(
            "Extrapolation: in {flagged} of {} the discrepancy is taken outside what was tested. What it is there, no reading \
             says; the probabilities take it to be what the test found.",
            counted(validated.terms.len(), "case")
        );
        blocks.push(Block::callout(Tone::Warning, text));
    }
    let nominal = validated.terms.iter().filter(|term| term.design_value.is_none());
    let rows = nominal.map(|term| {
        let status = if term.outside.is_empty() { Status::Ok } else { Status::Caution };
        let flag = if term.outside.is_empty() { "within what was tested".to_owned() } else { outside(term) };
        vec![
            Cell::code(&term.environment),
            Cell::code(&term.sensor),
            term.quantities.join(", ").into(),
            term.law.clone().into(),
            super::discrepancy::amount(term.mean, &term.unit).into(),
            format!("{} {}", significant(term.sd, 3), term.unit).into(),
            number::fixed(term.distance, 2).into(),
            Cell::marked(flag, status),
        ]
    });
    blocks.push(Block::Table(Table {
        caption: "What is added to each sample for the nominal design: mean and standard deviation of the discrepancy, and the \
                  distance to the nearest phase behind it in lengths of its Gaussian process."
            .into(),
        columns: vec![
            Column::text("Environment"),
            Column::text("Sensor"),
            Column::text("Quantities"),
            Column::text("Law"),
            Column::number("Mean", ""),
            Column::number("Standard deviation", ""),
            Column::number("Distance", "lengths"),
            Column::text("Extrapolation"),
        ],
        rows: rows.collect(),
    }));
    blocks
}

/// The same outcome with the posterior, where a discrepancy is added to that.
fn without<'o>(output: &'o Output, environment: &str, design: Option<f64>, requirement: &str) -> Option<&'o Met> {
    let cases = &output.validated.as_ref()?.without.cases;
    let case = cases.iter().find(|case| case.environment == environment && case.design_value == design)?;
    case.requirements.iter().find(|met| met.requirement == requirement)
}

/// What the last column of probabilities is with.
fn last(output: &Output) -> &'static str {
    if output.validated.is_some() { "With the discrepancy too" } else { "With the posterior" }
}

/// The same outcome with the priors.
fn before<'o>(output: &'o Output, environment: &str, design: Option<f64>, requirement: &str) -> Option<&'o Met> {
    let case = output.prior.cases.iter().find(|case| case.environment == environment && case.design_value == design)?;
    case.requirements.iter().find(|met| met.requirement == requirement)
}

fn requirements(report: &PassReport<'_>, output: &Output) -> Block {
    let mut rows = Vec::new();
    for case in nominal_cases(&output.posterior) {
        for met in &case.requirements {
            let shown = report.quantity_shown(&met.quantity, &met.unit);
            let prior = before(output, &case.environment, case.design_value, &met.requirement);
            let mut row = vec![
                Cell::code(&case.environment),
                Cell::code(&met.requirement),
                limits(&shown, met.above, met.below).into(),
                prior.map_or_else(|| NONE.to_owned(), |met| probability_text(&met.probability)).into(),
            ];
            if output.validated.is_some() {
                let alone = without(output, &case.environment, case.design_value, &met.requirement);
                row.push(alone.map_or_else(|| NONE.to_owned(), |met| probability_text(&met.probability)).into());
            }
            row.push(probability_text(&met.probability).into());
            row.push(number::probability(met.required).into());
            row.push(claim_cell(report, Rests::OnTuned, met));
            rows.push(row);
        }
    }
    let mut columns = vec![
        Column::text("Environment"),
        Column::text("Requirement"),
        Column::text("Limit"),
        Column::number("With the priors", ""),
    ];
    if output.validated.is_some() {
        columns.push(Column::number("With the posterior", ""));
    }
    columns.extend([Column::number(last(output), ""), Column::number("Required", ""), Column::text("Outcome")]);
    Block::Table(Table {
        caption: "Probability that the requirements are met by the nominal design, with 95 % intervals.".into(),
        columns,
        rows,
    })
}

fn reached(output: &Output) -> Option<Block> {
    let design = output.posterior.design_variable.as_ref()?;
    let shown = Shown::written(&output.posterior.design_unit);
    let text = |reached: Option<&propagate::Reached>| match reached
        .and_then(|reached| Some((reached.design_value?, reached.interval)))
    {
        Some((value, Some([a, b]))) => format!("{} ({} to {})", shown.number(value), shown.number(a), shown.number(b)),
        Some((value, None)) => shown.number(value),
        None => NONE.to_owned(),
    };
    let rows = output.posterior.reached.iter().map(|posterior_reached| {
        let prior =
            output.prior.reached.iter().find(|p| {
                p.environment == posterior_reached.environment && p.requirement == posterior_reached.requirement
            });
        let change = prior.and_then(|prior| Some(posterior_reached.design_value? - prior.design_value?));
        let mut row = vec![
            Cell::code(&posterior_reached.environment),
            Cell::code(&posterior_reached.requirement),
            number::probability(posterior_reached.probability).into(),
            text(prior).into(),
        ];
        if let Some(validated) = &output.validated {
            let alone = validated.without.reached.iter().find(|own| {
                own.environment == posterior_reached.environment && own.requirement == posterior_reached.requirement
            });
            row.push(text(alone).into());
        }
        row.push(text(Some(posterior_reached)).into());
        row.push(
            change.map_or_else(|| NONE.to_owned(), |change| number::signed(shown.difference().value(change), 1)).into(),
        );
        row
    });
    Some(Block::Table(Table {
        caption: format!(
            "Value of {design} ({}) from which on the required probability is reached, with the interval that those of the \
             probabilities give.",
            shown.unit
        )
        .into(),
        columns: {
            let mut columns = vec![
                Column::text("Environment"),
                Column::text("Requirement"),
                Column::number("Required", ""),
                Column::number("With the priors", ""),
            ];
            if output.validated.is_some() {
                columns.push(Column::number("With the posterior", ""));
            }
            columns.push(Column::number(last(output), ""));
            columns.push(Column::number("Change", shown.difference().unit.clone()));
            columns
        },
        rows: rows.collect(),
    }))
}

/// Probability against the design variable, with the posterior and with the priors, an environment a figure.
pub(super) fn figures(output: &Output, job: &str, is_small: bool) -> Vec<Figure> {
    let Some(design) = &output.posterior.design_variable else { return Vec::new() };
    let shown = Shown::written(&output.posterior.design_unit);
    let mut figures = Vec::new();
    for environment in environments(&output.posterior) {
        let swept = |case: &&propagate::Case| case.environment == environment && case.design_value.is_some();
        let Some(case) = output.posterior.cases.iter().find(swept) else { continue };
        let mut chart = Chart {
            x: Axis::new(shown.title(design)),
            y: Axis::of_probability(if is_small { "P(met)" } else { "probability that the requirement is met" }),
            is_small,
            ..Chart::default()
        };
        let requirements = case.requirements.iter().filter(|met| met.requirement != ALL);
        for (position, met) in requirements.enumerate() {
            let colour = palette::series(position);
            let of = |from: &propagate::Output| curve(from, environment, &met.requirement);
            let line = |points: &[(f64, propagate::Probability)]| -> Vec<(f64, f64)> {
                points.iter().map(|(x, p)| (shown.value(*x), p.value)).collect()
            };
            let (prior, posterior) = (of(&output.prior), of(&output.posterior));
            chart.layers.push(Layer::Band {
                points: posterior.iter().map(|(x, p)| (shown.value(*x), p.lower, p.upper)).collect(),
                colour,
                label: String::new(),
            });
            let label = |what: &str| format!("{}, {what}", met.requirement);
            chart.layers.push(Layer::Line {
                points: line(&prior),
                colour,
                stroke: Stroke::Dashed,
                label: label("priors"),
            });
            let points = line(&posterior);
            let label = label(if output.validated.is_some() { "posterior and discrepancy" } else { "posterior" });
            chart.layers.push(Layer::Line { points: points.clone(), colour, stroke: Stroke::Solid, label });
            chart.layers.push(Layer::Dots { points, colour, mark: Mark::Disc, label: String::new() });
            if !chart.limits.iter().any(|limit| limit.value == met.required) {
                let label = format!("required {}", number::probability(met.required));
                chart.limits.push(Limit { along: Along::Y, value: met.required, label, colour: palette::VERMILION });
            }
        }
        let caption = format!(
            "Probability of meeting the requirements against {design}, environment {environment}: with the posterior{} (solid, \
             with its 95 % interval) and with the priors that the calibration began with (dashed).",
            if output.validated.is_some() { " and the discrepancy" } else { "" }
        );
        figures.push(Figure {
            id: format!("{}{job}-prediction-{environment}", prefix(is_small)),
            drawing: chart.draw(),
            alternative: caption.clone(),
            caption: caption.into(),
        });
    }
    figures
}

fn sweep(output: &Output) -> Option<Block> {
    let design = output.posterior.design_variable.as_ref()?;
    let shown = Shown::written(&output.posterior.design_unit);
    let first = output.posterior.cases.iter().find(|case| case.design_value.is_some())?;
    let mut columns = vec![Column::text("Environment"), Column::number(design, shown.unit.clone())];
    for met in &first.requirements {
        columns
            .extend(["priors", "posterior"].map(|what| Column::number(format!("P({}), {what}", met.requirement), "")));
    }
    let rows = output.posterior.cases.iter().filter_map(|case| {
        let value = case.design_value?;
        let mut row = vec![Cell::code(&case.environment), significant(shown.value(value), 4).into()];
        for met in &case.requirements {
            let prior = before(output, &case.environment, case.design_value, &met.requirement);
            row.push(prior.map_or_else(|| NONE.to_owned(), |met| number::probability(met.probability.value)).into());
            row.push(Cell::marked(probability_text(&met.probability), standing(met)));
        }
        Some(row)
    });
    let caption = "Probability over the sweep of the design variable; of the posterior with 95 % intervals.".into();
    let table = Block::Table(Table { caption, columns, rows: rows.collect() });
    Some(Block::Details("Table of the sweep, priors and posterior".into(), vec![table]))
}

fn distributions(output: &Output) -> Block {
    let mut rows = Vec::new();
    for case in nominal_cases(&output.posterior) {
        let same = |prior_case: &&propagate::Case| {
            prior_case.environment == case.environment && prior_case.design_value == case.design_value
        };
        let prior = output.prior.cases.iter().find(same);
        for q in &case.quantities {
            let shown = Shown::quantity(&q.unit, q.is_temperature);
            let before =
                prior.and_then(|prior| prior.quantities.iter().find(|prior_quantity| prior_quantity.name == q.name));
            let prior = before.map_or_else(
                || [NONE.to_owned(), NONE.to_owned()],
                |prior_quantity| {
                    [
                        with_error(shown.value(prior_quantity.mean), prior_quantity.mean_standard_error),
                        with_error(prior_quantity.sd, prior_quantity.sd_standard_error),
                    ]
                },
            );
            let mut row = vec![Cell::code(&case.environment), Cell::code(&q.name), shown.unit.clone().into()];
            row.extend(prior.map(Cell::from));
            row.push(with_error(shown.value(q.mean), q.mean_standard_error).into());
            row.push(with_error(q.sd, q.sd_standard_error).into());
            row.extend([0.01, 0.5, 0.99].map(|p| Cell::from(shown.number(quantile(q, p)))));
            rows.push(row);
        }
    }
    let mut columns = vec![Column::text("Environment"), Column::text("Quantity"), Column::text("Unit")];
    columns.extend(
        ["Mean, priors", "Standard deviation, priors", "Mean", "Standard deviation", "1 %", "Median", "99 %"]
            .map(|title| Column::number(title, "")),
    );
    Block::Table(Table {
        caption: "Distributions of the quantities for the nominal design, with the priors and with the posterior; \
                  \u{00B1} is the standard error, standard deviations of temperatures are in K."
            .into(),
        columns,
        rows,
    })
}
