//! Uncertainty propagation: distributions of the quantities, probability that the requirements are met.

pub(super) mod along;
pub mod brief;

use crate::document::counted;
use crate::job::propagate::{Case, Distributed, Joint, Kind, Met, Output, Probability};
use crate::math::sort::sort_by;
use crate::report::number::{self, Shown, fixed, percent, significant, with_error};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text, Tone};
use crate::report::plot::{Along, Axis, Chart, Layer, Limit, Mark, Stroke, palette};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

use super::problem::limits;
use super::validation::{Rests, claim_cell, objection};
use super::{Entry, prefix};

/// Figures of distributions that stand open; the others are folded away.
const OPEN_FIGURES: usize = 2;
/// Parameters listed of each quantity.
const MOST_MAIN_EFFECTS: usize = 4;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Propagation);

/// The section on propagation; not without such a job.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for (name, output) in report.outputs::<Kind>() {
        blocks.push(Block::Paragraph(Text::new("Job ").code(name).plain(format!(
            ": {} a case, drawn by {}.",
            counted(output.samples, "sample"),
            sampling(&output.sampling)
        ))));
        blocks.extend(failures(output));
        blocks.push(requirements(report, output));
        let claims = nominal_cases(output).flat_map(|case| &case.requirements);
        blocks.extend(objection(report, Rests::OnDelivered, claims).map(|text| Block::callout(Tone::Warning, text)));
        blocks.extend(probability_figures(output, name, false).into_iter().map(Block::Figure));
        blocks.extend(sweep_table(output));
        blocks.extend(along::block(output, name));
        blocks.push(distributions(output));
        blocks.extend(main_effects(output));
        let mut figures = Vec::new();
        for case in nominal_cases(output) {
            figures.extend(
                case.quantities.iter().flat_map(|q| [histogram(case, q, name, false), cumulative(case, q, name)]),
            );
        }
        for case in nominal_cases(output) {
            figures.extend(case.joint.iter().map(|j| joint(report, case, j, name)));
        }
        let mut figures: Vec<Block> = figures.into_iter().map(Block::Figure).collect();
        let folded = figures.split_off(figures.len().min(OPEN_FIGURES));
        blocks.extend(figures);
        if !folded.is_empty() {
            blocks.push(Block::Details(format!("Further distributions ({})", folded.len()), folded));
        }
    }
    (!blocks.is_empty()).then(|| Section { id: "propagation", title: "Propagation of uncertainty".into(), blocks })
}

fn sampling(name: &str) -> &str {
    match name {
        "sobol" => "scrambled Sobol points",
        "latin-hypercube" => "Latin hypercube",
        "monte-carlo" => "independent Monte Carlo",
        other => other,
    }
}

/// Cases at the nominal design value, one an environment; all of them where none is nominal.
pub fn nominal_cases(output: &Output) -> impl Iterator<Item = &Case> {
    let has_nominal = output.cases.iter().any(|c| c.design_value.is_none());
    output.cases.iter().filter(move |c| !has_nominal || c.design_value.is_none())
}

pub(super) fn failures(output: &Output) -> Vec<Block> {
    let failed: u64 = output.cases.iter().map(|c| c.failed).sum();
    if failed == 0 {
        return Vec::new();
    }
    let rows = output
        .cases
        .iter()
        .flat_map(|case| case.failures.iter().map(move |f| (case, f)))
        .take(20)
        .map(|(case, failure)| {
            let parameters: Vec<String> =
                failure.parameters.iter().map(|(name, value)| format!("{name} = {}", significant(*value, 5))).collect();
            vec![
                Cell::code(&case.environment),
                failure.index.to_string().into(),
                failure.reason.clone().into(),
                parameters.join(", ").into(),
            ]
        })
        .collect();
    vec![
        Block::callout(
            Tone::Warning,
            format!("No solution of {}: that counts as not meeting any requirement.", counted(failed, "sample")),
        ),
        Block::Table(Table {
            caption: "The first samples without a solution, parameters in SI.".into(),
            columns: vec![
                Column::text("Environment"),
                Column::number("Sample", ""),
                Column::text("Reason"),
                Column::text("Parameters"),
            ],
            rows,
        }),
    ]
}

/// How a requirement stands: kept if the whole interval is above what is required, failed if it is below.
pub fn standing(met: &Met) -> Status {
    if met.probability.lower >= met.required {
        Status::Ok
    } else if met.probability.upper < met.required {
        Status::Fail
    } else {
        Status::Caution
    }
}

/// How a requirement stands, in words.
pub(super) fn outcome(met: &Met) -> &'static str {
    match standing(met) {
        Status::Ok => "met",
        Status::Caution => "undecided with these samples",
        Status::Fail => "not met",
    }
}

/// `0.919 (0.913 to 0.925)`; where all samples agree, `≥ 0.996`.
pub(super) fn probability_text(p: &Probability) -> String {
    if p.value == 0.0 || p.value == 1.0 {
        return probability_stated(p);
    }
    format!("{} ({} to {})", number::probability(p.value), number::probability(p.lower), number::probability(p.upper))
}

/// A probability by itself: where all samples agree, what they show it to be at least or at most.
pub fn probability_stated(p: &Probability) -> String {
    if p.value == 1.0 {
        format!("\u{2265} {}", number::probability(p.lower))
    } else if p.value == 0.0 {
        format!("\u{2264} {}", number::probability(p.upper))
    } else {
        number::probability(p.value)
    }
}

fn requirements(report: &PassReport<'_>, output: &Output) -> Block {
    let mut rows = Vec::new();
    for case in nominal_cases(output) {
        for met in &case.requirements {
            let shown = report.quantity_shown(&met.quantity, &met.unit);
            rows.push(vec![
                Cell::code(&case.environment),
                Cell::code(&met.requirement),
                limits(&shown, met.above, met.below).into(),
                probability_text(&met.probability).into(),
                number::probability(met.required).into(),
                claim_cell(report, Rests::OnDelivered, met),
            ]);
        }
    }
    Block::Table(Table {
        caption:
            "Probability that the requirements are met by the nominal design, with its 95 % interval from sampling."
                .into(),
        columns: vec![
            Column::text("Environment"),
            Column::text("Requirement"),
            Column::text("Limit"),
            Column::number("Probability", ""),
            Column::number("Required", ""),
            Column::text("Outcome"),
        ],
        rows,
    })
}

/// Environments in the order of the cases.
pub(super) fn environments(output: &Output) -> Vec<&str> {
    let mut out: Vec<&str> = Vec::new();
    for case in &output.cases {
        if !out.contains(&case.environment.as_str()) {
            out.push(&case.environment);
        }
    }
    out
}

/// Design value and probability of a requirement over the sweep, in increasing order.
pub(super) fn curve(output: &Output, environment: &str, requirement: &str) -> Vec<(f64, Probability)> {
    let mut points: Vec<(f64, Probability)> = output
        .cases
        .iter()
        .filter(|c| c.environment == environment)
        .filter_map(|c| {
            Some((c.design_value?, c.requirements.iter().find(|m| m.requirement == requirement)?.probability))
        })
        .collect();
    sort_by(&mut points, |a, b| a.0.total_cmp(&b.0));
    points
}

/// Probability against the design variable, an environment a figure.
pub(super) fn probability_figures(output: &Output, job: &str, is_small: bool) -> Vec<Figure> {
    let Some(design) = &output.design_variable else { return Vec::new() };
    let shown = Shown::written(&output.design_unit);
    let mut figures = Vec::new();
    for environment in environments(output) {
        let Some(case) = output.cases.iter().find(|c| c.environment == environment && c.design_value.is_some()) else {
            continue;
        };
        let mut chart = Chart {
            x: Axis::new(shown.title(design)),
            y: Axis::of_probability(if is_small { "P(met)" } else { "probability that the requirement is met" }),
            is_small,
            ..Chart::default()
        };
        let mut words = Vec::new();
        // With one requirement `all` repeats it.
        let is_single = case.requirements.len() <= 2;
        for (position, met) in case.requirements.iter().filter(|m| !(is_single && m.requirement == ALL)).enumerate() {
            let colour = palette::series(position);
            let points = curve(output, environment, &met.requirement);
            let x = |p: &(f64, Probability)| shown.value(p.0);
            chart.layers.push(Layer::Band {
                points: points.iter().map(|p| (x(p), p.1.lower, p.1.upper)).collect(),
                colour,
                label: String::new(),
            });
            let line: Vec<_> = points.iter().map(|p| (x(p), p.1.value)).collect();
            let label = if is_single { String::new() } else { met.requirement.clone() };
            chart.layers.push(Layer::Line { points: line.clone(), colour, stroke: Stroke::Solid, label });
            chart.layers.push(Layer::Dots { points: line, colour, mark: Mark::Disc, label: String::new() });
            if !chart.limits.iter().any(|l| l.value == met.required) {
                let label = format!("required {}", number::probability(met.required));
                chart.limits.push(Limit { along: Along::Y, value: met.required, label, colour: palette::VERMILION });
            }
            let reached =
                output.reached.iter().find(|r| r.environment == environment && r.requirement == met.requirement);
            if let Some(value) = reached.and_then(|r| r.design_value) {
                let label = shown.text(value);
                words.push(format!("{} reaches it at {label}", met.requirement));
                // A requirement that governs alone stands where all together do: one label for both.
                let value = shown.value(value);
                let span = points.last().map_or(0.0, &x) - points.first().map_or(0.0, x);
                let is_shown = |l: &Limit| l.along == Along::X && (l.value - value).abs() < 0.02 * span;
                if !chart.limits.iter().any(is_shown) {
                    chart.limits.push(Limit { along: Along::X, value, label, colour });
                }
            }
        }
        let reached = if words.is_empty() { String::new() } else { format!(" {}.", words.join("; ")) };
        let caption = format!(
            "Probability of meeting the requirement against {design}, environment {environment}; the band is the 95 % interval from sampling.{reached}"
        );
        figures.push(Figure {
            id: format!("{}{job}-probability-{environment}", prefix(is_small)),
            drawing: chart.draw(),
            alternative: caption.clone(),
            caption: caption.into(),
        });
    }
    figures
}

fn sweep_table(output: &Output) -> Option<Block> {
    let design = output.design_variable.as_ref()?;
    let shown = Shown::written(&output.design_unit);
    let first = output.cases.iter().find(|c| c.design_value.is_some())?;
    let mut columns = vec![Column::text("Environment"), Column::number(design, shown.unit.clone())];
    columns.extend(first.requirements.iter().map(|m| Column::number(format!("P({})", m.requirement), "")));
    let rows = output
        .cases
        .iter()
        .filter_map(|case| {
            let value = case.design_value?;
            let mut row = vec![Cell::code(&case.environment), significant(shown.value(value), 4).into()];
            row.extend(case.requirements.iter().map(|m| Cell::marked(probability_text(&m.probability), standing(m))));
            Some(row)
        })
        .collect();
    let caption = "Probability over the sweep of the design variable, with 95 % intervals.".into();
    Some(Block::Details("Table of the sweep".into(), vec![Block::Table(Table { caption, columns, rows })]))
}

pub(super) fn quantile(distributed: &Distributed, probability: f64) -> f64 {
    distributed.quantiles.iter().find(|q| (q.probability - probability).abs() < 1e-9).map_or(f64::NAN, |q| q.value)
}

fn distributions(output: &Output) -> Block {
    let mut rows = Vec::new();
    for case in nominal_cases(output) {
        for q in &case.quantities {
            let shown = Shown::quantity(&q.unit, q.is_temperature);
            let mut row = vec![
                Cell::code(&case.environment),
                Cell::code(&q.name),
                shown.unit.clone().into(),
                shown.number(q.nominal).into(),
                with_error(shown.value(q.mean), q.mean_standard_error).into(),
                with_error(q.sd, q.sd_standard_error).into(),
            ];
            row.extend([0.01, 0.05, 0.5, 0.95, 0.99].map(|p| Cell::from(shown.number(quantile(q, p)))));
            rows.push(row);
        }
    }
    let mut columns = vec![Column::text("Environment"), Column::text("Quantity"), Column::text("Unit")];
    columns.extend(
        ["Nominal", "Mean", "Standard deviation", "1 %", "5 %", "Median", "95 %", "99 %"]
            .map(|t| Column::number(t, "")),
    );
    Block::Table(Table {
        caption: "Distributions of the quantities for the nominal design; \u{00B1} is the standard error from sampling, standard \
                  deviations of temperatures are in K."
            .into(),
        columns,
        rows,
    })
}

/// The leading parameters of each quantity by the same samples.
fn main_effects(output: &Output) -> Option<Block> {
    let mut rows = Vec::new();
    for case in nominal_cases(output) {
        for quantity in &case.quantities {
            let mut effects: Vec<_> = case.main_effects.iter().filter(|e| e.quantity == quantity.name).collect();
            sort_by(&mut effects, |a, b| b.estimate.value.total_cmp(&a.estimate.value));
            rows.extend(effects.iter().take(MOST_MAIN_EFFECTS).map(|effect| {
                vec![
                    Cell::code(&case.environment),
                    Cell::code(&effect.quantity),
                    Cell::code(&effect.parameter),
                    super::sensitivity::estimate_text(&effect.estimate).into(),
                ]
            }));
        }
    }
    if rows.is_empty() {
        return None;
    }
    let table = Table {
        caption: "Shares of the variance that would go if a parameter were known, by classes of the parameter among the same samples, \
                  with 95 % intervals; the leading parameters of each quantity."
            .into(),
        columns: vec![
            Column::text("Environment"),
            Column::text("Quantity"),
            Column::text("Parameter"),
            Column::number("Main effect", ""),
        ],
        rows,
    };
    Some(Block::Details("Main effects from the same samples".into(), vec![Block::Table(table)]))
}

/// Markers of the limits that apply to a quantity and of its nominal value.
fn markers(case: &Case, q: &Distributed, shown: &Shown) -> Vec<Limit> {
    let mut out = vec![Limit {
        along: Along::X,
        value: shown.value(q.nominal),
        label: format!("nominal {}", shown.text(q.nominal)),
        colour: palette::INK,
    }];
    for met in case.requirements.iter().filter(|m| m.quantity == q.name) {
        for limit in [met.above, met.below].into_iter().flatten() {
            let label = format!("limit {}", shown.text(limit));
            out.push(Limit { along: Along::X, value: shown.value(limit), label, colour: palette::VERMILION });
        }
    }
    out
}

pub(super) fn histogram(case: &Case, q: &Distributed, job: &str, is_small: bool) -> Figure {
    let shown = Shown::quantity(&q.unit, q.is_temperature);
    let total: u64 = q.histogram_counts.iter().sum();
    let chart = Chart {
        x: Axis::new(shown.title(&q.name)),
        y: Axis::new("share of samples [%]").up_to(100.0),
        layers: vec![Layer::Bars {
            edges: q.histogram_edges.iter().map(|&e| shown.value(e)).collect(),
            heights: q.histogram_counts.iter().map(|&c| 100.0 * c as f64 / total.max(1) as f64).collect(),
            colour: palette::BLUE,
            label: String::new(),
        }],
        limits: markers(case, q, &shown),
        height: if is_small { 0 } else { 760 },
        is_small,
        ..Chart::default()
    };
    let caption = format!(
        "Distribution of {} in environment {}: mean {}, standard deviation {}, 1 % to 99 %: {} to {}.",
        q.name,
        case.environment,
        shown.text(q.mean),
        shown.difference().text(q.sd),
        shown.number(quantile(q, 0.01)),
        shown.text(quantile(q, 0.99)),
    );
    Figure {
        id: format!("{}{job}-{}-{}-histogram", prefix(is_small), case.environment, q.name),
        drawing: chart.draw(),
        alternative: format!("Histogram. {caption}"),
        caption: caption.into(),
    }
}

pub(super) fn cumulative(case: &Case, q: &Distributed, job: &str) -> Figure {
    let shown = Shown::quantity(&q.unit, q.is_temperature);
    let count = q.cdf.len().max(1) as f64;
    let points = q.cdf.iter().enumerate().map(|(i, &v)| (shown.value(v), (i as f64 + 0.5) / count)).collect();
    let chart = Chart {
        x: Axis::new(shown.title(&q.name)),
        y: Axis::over("share of samples below", 0.0, 1.0),
        layers: vec![Layer::Line { points, colour: palette::BLUE, stroke: Stroke::Solid, label: String::new() }],
        limits: markers(case, q, &shown),
        height: 760,
        ..Chart::default()
    };
    let caption = format!("Distribution function of {} in environment {}.", q.name, case.environment);
    Figure {
        id: format!("{job}-{}-{}-cdf", case.environment, q.name),
        drawing: chart.draw(),
        alternative: caption.clone(),
        caption: caption.into(),
    }
}

pub(super) fn joint(report: &PassReport<'_>, case: &Case, j: &Joint, job: &str) -> Figure {
    let (x, y) = (report.quantity_shown(&j.x, &j.units[0]), report.quantity_shown(&j.y, &j.units[1]));
    let line = |value: fn(&crate::job::propagate::Conditional) -> f64| -> Vec<(f64, f64)> {
        j.conditional.iter().map(|c| (x.value(c.x), y.value(value(c)))).collect()
    };
    let chart = Chart {
        x: Axis::new(x.title(&j.x)),
        y: Axis::new(y.title(&j.y)),
        layers: vec![
            Layer::Cells {
                x_edges: j.x_edges.iter().map(|&e| x.value(e)).collect(),
                y_edges: j.y_edges.iter().map(|&e| y.value(e)).collect(),
                values: j.counts.iter().map(|row| row.iter().map(|&c| c as f64).collect()).collect(),
                colour: palette::SKY,
                label: "density of samples".into(),
            },
            Layer::Line {
                points: line(|c| c.q05),
                colour: palette::INK,
                stroke: Stroke::Dashed,
                label: "5 % and 95 %".into(),
            },
            Layer::Line { points: line(|c| c.q95), colour: palette::INK, stroke: Stroke::Dashed, label: String::new() },
            Layer::Line {
                points: line(|c| c.mean),
                colour: palette::VERMILION,
                stroke: Stroke::Solid,
                label: format!("mean of {}", j.y),
            },
        ],
        ..Chart::default()
    };
    let strength =
        j.correlation.map_or("undefined".to_owned(), |r| if r.abs() > 0.005 { fixed(r, 2) } else { "0.00".to_owned() });
    let caption = format!(
        "Joint distribution of {} and {} in environment {} (linear correlation {strength}), with {} where {} is known.",
        j.x, j.y, case.environment, j.y, j.x
    );
    Figure {
        id: format!("{job}-{}-joint-{}-{}", case.environment, j.x, j.y),
        drawing: chart.draw(),
        alternative: caption.clone(),
        caption: caption.into(),
    }
}

/// `12 % smaller` or `8 % larger`.
pub(super) fn relative(value: f64, reference: f64) -> String {
    let change = value / reference - 1.0;
    let word = if change < 0.0 { "smaller" } else { "larger" };
    format!("{} {word}", percent(change.abs(), 0))
}
