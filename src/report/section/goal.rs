//! Goal setting: how well the leading parameters must be known, what design is then within reach, and what to do next.

mod brief;

use crate::job::goal::{Kind, Knowledge, Next, Output};
use crate::math::sort::sort_by;
use crate::report::number::{self, NONE, Shown, percent, significant};
use crate::report::page::{Block, Cell, Column, Figure, Section, Statement, Status, Table, Text};
use crate::report::plot::{Along, Axis, Chart, Layer, Limit, Mark, Stroke, palette};
use crate::report::view::PassReport;

use super::Entry;
use super::propagation::probability_text;
use super::sensitivity::estimate_text;

/// Parameters in the table of main effects.
const MOST_LEADING: usize = 8;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Goal);

/// The section on goal setting; not without such a job.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for (name, output) in report.outputs::<Kind>() {
        blocks.push(Block::Paragraph(introduction(name, output)));
        blocks.push(Block::Statements(statements(output)));
        blocks.push(Block::List(reasons(output).into_iter().map(Text::from).collect()));
        blocks.push(requirements(output));
        blocks.extend(figure(name, output).map(Block::Figure));
        for (place, knowledge) in output.knowledge.iter().enumerate() {
            let table = levels(output, knowledge);
            if place == 0 {
                blocks.push(table);
            } else {
                blocks.push(Block::Details(
                    format!("Better knowledge of {}", knowledge.parameters.join(", ")),
                    vec![table],
                ));
            }
        }
        blocks.push(leading(output));
    }
    (!blocks.is_empty()).then(|| Section { id: "goal", title: "What must be known better".into(), blocks })
}

/// The advice in words.
pub fn next_words(next: Next) -> &'static str {
    match next {
        Next::ParameterInference => "an experiment that infers the leading parameters",
        Next::Validation => "a validation experiment",
        Next::Done => "nothing: done",
        Next::Redesign => "another design",
    }
}

/// Why, a sentence each, with the design values that knowledge reaches.
pub fn reasons(output: &Output) -> Vec<String> {
    let mut reasons = output.advice.reasons.clone();
    if let Some(target) = &output.target {
        let standing: Vec<String> = target
            .parameters
            .iter()
            .zip(&target.units)
            .zip(&target.sds)
            .map(|((name, unit), &sd)| format!("{name}: {}", Shown::parameter_of(unit, sd).difference().text(sd)))
            .collect();
        reasons.push(format!("standard deviations that may be left: {}", standing.join(", ")));
    }
    if let Some(name) = &output.design_variable {
        let shown = Shown::written(&output.design_unit);
        let value = |value: Option<f64>| value.map_or("no value of the range".to_owned(), |value| shown.text(value));
        reasons.push(format!("with prior knowledge {name} = {} reaches it", value(output.prior_design_value)));
        if let Some((knowledge, level)) = usual(output) {
            reasons.push(format!(
                "with {} known to {} of the prior standard deviation at the prior's mean, {name} = {} does",
                knowledge.parameters.join(" and "),
                percent(level.ratio, 0),
                value(level.design_value)
            ));
        }
        if let Some((truths, mean)) = output.truths.as_ref().and_then(|t| Some((t, t.mean_design_value?))) {
            reasons.push(format!(
                "averaged over truths, knowing {} to {} of the prior standard deviation leads to {name} = {}",
                truths.parameters.join(" and "),
                percent(truths.ratio, 0),
                shown.text(mean)
            ));
        }
    }
    if let Some(sd) = output.tolerable_discrepancy {
        let shown = Shown::quantity(&output.driving.unit, output.driving.is_temperature).difference();
        reasons.push(format!(
            "the model's discrepancy in {} may have a standard deviation of {} before the probability falls below what is required",
            output.driving.quantity,
            shown.text(sd)
        ));
    }
    reasons
}

/// The usual knowledge of the leading parameter, where a design value was sought for it.
fn usual(output: &Output) -> Option<(&Knowledge, &crate::job::goal::Level)> {
    let knowledge = output.knowledge.first()?;
    let level = knowledge.levels.iter().find(|level| level.is_design_sought && level.ratio <= 0.25)?;
    Some((knowledge, level))
}

fn introduction(name: &str, output: &Output) -> Text {
    Text::new("Job ").code(name).plain(format!(
        ": {} samples a probability, all requirements together in all environments. Better knowledge of a parameter is its prior \
         times the likelihood of one measurement with a normal error, first at the prior's mean, where it changes the spread \
         alone, then averaged over truths drawn from the prior.",
        output.samples
    ))
}

fn statements(output: &Output) -> Vec<Statement> {
    let is_met = output.probability.value >= output.required;
    let mut statements = vec![
        Statement {
            label: "Next".into(),
            value: next_words(output.advice.next).into(),
            text: Text::default(),
            status: None,
        },
        Statement {
            label: "Probability with prior knowledge".into(),
            value: number::probability(output.probability.value),
            text: format!("{} is required", number::probability(output.required)).into(),
            status: Some(Status::kept(is_met)),
        },
    ];
    if let Some(target) = &output.target {
        let all = format!("{} of the prior variance", percent(target.variance_ratio, 1));
        statements.push(match (target.parameters.as_slice(), target.units.as_slice(), target.sds.as_slice()) {
            ([name], [unit], [sd]) => Statement {
                label: format!("Uncertainty of {name} that may be left"),
                value: Shown::parameter_of(unit, *sd).difference().text(*sd),
                text: format!("its standard deviation; {all}").into(),
                status: None,
            },
            (names, ..) => Statement {
                label: "Variance that may be left".into(),
                value: percent(target.variance_ratio, 1),
                text: Text::new("of the prior variance of ").code(names.join(", ")),
                status: None,
            },
        });
    }
    statements
}

fn requirements(output: &Output) -> Block {
    let rows = output
        .requirements
        .iter()
        .map(|met| {
            vec![
                Cell::code(&met.environment),
                Cell::code(&met.requirement),
                Cell::code(&met.quantity),
                probability_text(&met.probability).into(),
            ]
        })
        .collect();
    Block::Table(Table {
        caption: format!(
            "Each requirement with prior knowledge; {} in environment {} drives.",
            output.driving.requirement, output.driving.environment
        )
        .into(),
        columns: vec![
            Column::text("Environment"),
            Column::text("Requirement"),
            Column::text("Quantity"),
            Column::number("Probability", ""),
        ],
        rows,
    })
}

/// Probability against the standard deviation that is left, a line a set of parameters.
fn figure(job: &str, output: &Output) -> Option<Figure> {
    if output.knowledge.is_empty() {
        return None;
    }
    let mut chart = Chart {
        x: Axis::new("standard deviation that is left, by the prior's"),
        y: Axis::new("probability that all requirements are met").up_to(1.0),
        limits: vec![Limit {
            along: Along::Y,
            value: output.required,
            label: format!("required {}", number::probability(output.required)),
            colour: palette::VERMILION,
        }],
        ..Chart::default()
    };
    for (position, knowledge) in output.knowledge.iter().enumerate() {
        let colour = palette::series(if position == 0 { 0 } else { position + 1 });
        let mut points: Vec<(f64, f64)> =
            knowledge.levels.iter().map(|level| (level.ratio, level.probability.value)).collect();
        points.push((1.0, output.probability.value));
        sort_by(&mut points, |a, b| a.0.total_cmp(&b.0));
        let label = knowledge.parameters.join(", ");
        chart.layers.push(Layer::Line { points: points.clone(), colour, stroke: Stroke::Solid, label });
        chart.layers.push(Layer::Dots { points, colour, mark: Mark::Disc, label: String::new() });
    }
    let caption =
        "Probability that the given design meets all requirements against the standard deviation that is left of the \
                   leading parameters, the readings at the priors' means."
            .to_owned();
    Some(Figure {
        id: format!("{job}-knowledge"),
        drawing: chart.draw(),
        alternative: caption.clone(),
        caption: caption.into(),
    })
}

fn levels(output: &Output, knowledge: &Knowledge) -> Block {
    let design = output.design_variable.as_ref().map(|name| (name, Shown::written(&output.design_unit)));
    let mut columns = vec![
        Column::number("Deviation left", "%"),
        Column::number("Variance left", "%"),
        Column::number("Probability", ""),
    ];
    columns.extend(
        design.as_ref().map(|(name, shown)| Column::number(format!("{name} within reach"), shown.unit.clone())),
    );
    let rows = knowledge
        .levels
        .iter()
        .map(|level| {
            let status = Status::kept(level.probability.value >= output.required);
            let mut row = vec![
                significant(100.0 * level.ratio, 3).into(),
                significant(100.0 * level.ratio * level.ratio, 3).into(),
                Cell::marked(probability_text(&level.probability), status),
            ];
            row.extend(design.as_ref().map(|(_, shown)| {
                let text = match (level.design_value, level.is_design_sought) {
                    (Some(value), _) => significant(shown.value(value), 4),
                    (None, true) => "outside the range".to_owned(),
                    (None, false) => NONE.to_owned(),
                };
                Cell::from(text)
            }));
            row
        })
        .collect();
    Block::Table(Table {
        caption: Text::new("Better knowledge of ").code(knowledge.parameters.join(", ")).plain(
            ", from little to perfect: the probability by the given design, and the design that is then within reach.",
        ),
        columns,
        rows,
    })
}

fn leading(output: &Output) -> Block {
    let rows = output
        .leading
        .iter()
        .take(MOST_LEADING)
        .map(|leading| {
            let shown = Shown::parameter_of(&leading.unit, leading.mean.abs().max(leading.sd));
            vec![
                Cell::code(&leading.parameter),
                leading.main.as_ref().map_or(NONE.to_owned(), estimate_text).into(),
                shown.text(leading.mean).into(),
                shown.difference().text(leading.sd).into(),
            ]
        })
        .collect();
    Block::Table(Table {
        caption: format!(
            "Main effects on {}, from the samples of the prior by classes of each parameter.",
            output.driving.quantity
        )
        .into(),
        columns: vec![
            Column::text("Parameter"),
            Column::number("Main effect", ""),
            Column::number("Prior mean", ""),
            Column::number("Prior standard deviation", ""),
        ],
        rows,
    })
}
