//! Sizes: the probabilistic one beside those of the conventional rules.

mod brief;

use crate::job::conventional::{Basis, Kind, Output, Size};
use crate::job::propagate::{self, Reached};
use crate::report::number::{self, NONE, Shown, percent, significant};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text};
use crate::report::plot::{Axis, Bar, bar_chart, palette};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;
use crate::study::rule::Margin;

use super::Entry;
use super::propagation::curve;

/// Pairs of environment and requirement that stand open, one below another.
const MOST_OPEN: usize = 3;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Sizing);

/// The section on sizes; not without a conventional analysis.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for (name, output) in report.outputs::<Kind>() {
        let all = pairs(output);
        for (position, &pair) in all.iter().enumerate() {
            let what = if pair.1 == ALL { "all requirements together" } else { pair.1 };
            let title = format!("{what} in environment {}", pair.0);
            let own = vec![Block::Figure(figure(report, name, output, pair)), sizes(report, output, pair)];
            // Of many the first is read, the others are looked up.
            if position > 0 && all.len() > MOST_OPEN {
                blocks.push(Block::Details(title, own));
                continue;
            }
            blocks.extend((all.len() > 1).then_some(Block::Heading(title)));
            blocks.extend(own);
        }
        blocks.extend(worst_case(output));
    }
    (!blocks.is_empty()).then(|| Section {
        id: "sizing",
        title: "Sizes: probabilistic and conventional".into(),
        blocks,
    })
}

/// Environment and requirement, in the order of the sizes; before the several requirements of an environment stands
/// [`ALL`] of them.
pub(super) fn pairs(output: &Output) -> Vec<(&str, &str)> {
    let mut out: Vec<(&str, &str)> = Vec::new();
    for size in &output.sizes {
        let pair = (size.environment.as_str(), size.requirement.as_str());
        if out.contains(&pair) {
            continue;
        }
        if let Some(first) = out.iter().position(|p| p.0 == pair.0)
            && out[first].1 != ALL
        {
            out.insert(first, (pair.0, ALL));
        }
        out.push(pair);
    }
    out
}

/// The sizes of a pair, for [`ALL`] requirements the governing one of each rule.
pub(super) fn sizes_of<'a>(output: &'a Output, (environment, requirement): (&str, &str)) -> Vec<&'a Size> {
    let mut out: Vec<&Size> = Vec::new();
    for size in output.sizes.iter().filter(|s| s.environment == environment) {
        let wanted = if requirement == ALL {
            output.governing(environment, &size.rule.name, size.basis)
        } else {
            (size.requirement == requirement).then_some(size)
        };
        out.extend(wanted.filter(|w| !out.contains(w)));
    }
    out
}

/// What is asked of the design variable: `smallest` or `largest`.
fn wanted(output: &Output) -> &'static str {
    if output.seeks_largest() { "largest" } else { "smallest" }
}

/// A size; whether none passes, or all of the range does.
fn size_text(output: &Output, size: &Size, text: &dyn Fn(f64) -> String) -> String {
    match size.size {
        None => "none in the range".to_owned(),
        Some(value) if value == output.design_range[0] => format!("{}, all of the range", text(value)),
        Some(value) => text(value),
    }
}

/// The probabilistic size for a pair, with the design variable in common.
pub(super) fn probabilistic<'a>(
    report: &'a PassReport<'_>,
    design: &str,
    (environment, requirement): (&str, &str),
) -> Option<&'a Reached> {
    report
        .outputs::<propagate::Kind>()
        .filter(|(_, output)| output.design_variable.as_deref() == Some(design))
        .flat_map(|(_, output)| &output.reached)
        .find(|r| r.environment == environment && r.requirement == requirement)
}

/// Name of a rule's size: what is stacked and what is added.
pub(super) fn label(size: &Size) -> String {
    let basis = size.basis.words();
    let margin = match size.rule.margin {
        Margin::TemperatureK(0.0) => "no margin".to_owned(),
        Margin::TemperatureK(k) => format!("+ {} K", number::as_given(k)),
        Margin::HeatLoad(share) => format!("+ {} heat load", percent(share, 0)),
    };
    format!("{basis}, {margin}")
}

/// Probability that a requirement is met at a size, between the points of the sweep.
fn probability_at(
    report: &PassReport<'_>,
    design: &str,
    (environment, requirement): (&str, &str),
    size: f64,
) -> Option<f64> {
    report
        .outputs::<propagate::Kind>()
        .filter(|(_, output)| output.design_variable.as_deref() == Some(design))
        .find_map(|(_, output)| {
            let points = curve(output, environment, requirement);
            points.windows(2).find(|w| size >= w[0].0 && size <= w[1].0).map(|w| {
                let width = w[1].0 - w[0].0;
                let share = if width > 0.0 { (size - w[0].0) / width } else { 0.0 };
                w[0].1.value + share * (w[1].1.value - w[0].1.value)
            })
        })
}

/// Bars of all sizes for a pair.
fn figure(report: &PassReport<'_>, job: &str, output: &Output, pair: (&str, &str)) -> Figure {
    let shown = Shown::written(&output.design_unit);
    let mut bars = Vec::new();
    if let Some(reached) = probabilistic(report, &output.design_variable, pair) {
        bars.push(Bar {
            label: format!("probabilistic, P = {}", number::probability(reached.probability)),
            from: 0.0,
            value: reached.design_value.map_or(f64::NAN, |v| shown.value(v)),
            interval: reached.interval.map(|i| i.map(|v| shown.value(v))),
            text: reached.design_value.map_or_else(|| "not reached in the sweep".to_owned(), |v| shown.text(v)),
            colour: palette::BLUE,
        });
    }
    for size in sizes_of(output, pair) {
        bars.push(Bar {
            label: label(size),
            from: 0.0,
            value: size.size.map_or(f64::NAN, |v| shown.value(v)),
            interval: None,
            text: size_text(output, size, &|v| shown.text(v)),
            colour: if size.basis == Basis::Nominal { (150, 162, 174) } else { palette::AMBER },
        });
    }
    let nominal = number::with_unit(&number::as_given(shown.value(output.design_nominal)), &shown.unit);
    let marker = format!("nominal design {nominal}");
    let axis = Axis::new(shown.title(&output.design_variable));
    let listed: Vec<String> = bars.iter().map(|b| format!("{}: {}", b.label, b.text)).collect();
    Figure {
        id: format!("{job}-sizes-{}-{}", pair.0, pair.1),
        drawing: bar_chart(&axis, &bars, Some((shown.value(output.design_nominal), &marker))),
        caption: figure_caption(output, pair)
            .plain(": probabilistic in blue with its 95 % sampling interval, by rule from nominal values in grey, from stacked worst cases in amber."),
        alternative: format!("Bar chart of sizes. {}.", listed.join("; ")),
    }
}

fn figure_caption(output: &Output, (environment, requirement): (&str, &str)) -> Text {
    let what = |text: Text| {
        if requirement == ALL { text.plain("all requirements") } else { text.plain("requirement ").code(requirement) }
    };
    let text = if output.seeks_largest() {
        what(Text::new("Largest ").code(&output.design_variable).plain(" at which "))
            .plain(" can be met in environment ")
    } else {
        what(Text::new("Size (").code(&output.design_variable).plain(") that ")).plain(" asks for in environment ")
    };
    text.code(environment)
}

/// What a rule says of the design variable: a limit where the largest value is sought, else a size.
fn asked(output: &Output) -> String {
    format!("{} of {}", if output.seeks_largest() { "Limit" } else { "Size" }, output.design_variable)
}

/// The probability that a rule's value buys; a rule that buys less than is required is called unsafe.
fn bought(met: Option<f64>, required: Option<f64>, is_swept: bool) -> Cell {
    let Some(met) = met else {
        return if is_swept { "outside the sweep" } else { NONE }.into();
    };
    let text = number::probability(met);
    match required {
        Some(required) if met < required => Cell::marked(format!("{text}, unsafe"), Status::Fail),
        _ => text.into(),
    }
}

fn sizes(report: &PassReport<'_>, output: &Output, pair: (&str, &str)) -> Block {
    let design = Shown::written(&output.design_unit);
    let shown = Shown::quantity(&output.unit, output.is_temperature);
    let reached = probabilistic(report, &output.design_variable, pair);
    let is_swept = report
        .outputs::<propagate::Kind>()
        .any(|(_, swept)| swept.design_variable.as_ref() == Some(&output.design_variable));
    let mut rows = Vec::new();
    if let Some(reached) = reached {
        rows.push(vec![
            Cell::from(
                Text::default().strong(format!("probabilistic, P = {}", number::probability(reached.probability))),
            ),
            reached
                .design_value
                .map_or_else(|| "not reached in the sweep".to_owned(), |v| significant(design.value(v), 4))
                .into(),
            NONE.into(),
            reached.design_value.map_or_else(|| NONE.to_owned(), |_| number::probability(reached.probability)).into(),
            NONE.into(),
            NONE.into(),
            "propagated priors".into(),
        ]);
    }
    for size in sizes_of(output, pair) {
        let against = match (size.size, reached.and_then(|r| r.design_value)) {
            // A share of an absolute temperature says nothing; its difference does.
            (Some(size_value), Some(probabilistic)) if design.is_celsius() => {
                number::signed(size_value - probabilistic, 1)
            }
            (Some(size_value), Some(probabilistic)) if probabilistic != 0.0 => {
                number::signed(100.0 * (size_value / probabilistic - 1.0), 1)
            }
            _ => NONE.to_owned(),
        };
        let met = size.size.and_then(|v| probability_at(report, &output.design_variable, pair, v));
        let margin = format!("{}{}", if size.margin > 0.0 { "+" } else { "" }, shown.difference().number(size.margin));
        let name = if pair.1 == ALL { format!("{} ({})", label(size), size.requirement) } else { label(size) };
        rows.push(vec![
            name.into(),
            size_text(output, size, &|v| significant(design.value(v), 4)).into(),
            against.into(),
            bought(met, reached.map(|reached| reached.probability), is_swept),
            shown.number(size.prediction).into(),
            Cell::marked(margin, Status::kept(size.passes)),
            format!("{}; {}", size.rule.title, size.rule.source).into(),
        ]);
    }
    Block::Table(Table {
        caption: Text::new("Sizes by rule: the ")
            .plain(wanted(output))
            .plain(" value from which on the rule passes. The last numbers judge the nominal design of ")
            .plain(design.text(output.design_nominal))
            .plain(": its prediction under the rule's parameters, and the margin that is left after the rule's own."),
        columns: vec![
            Column::text("Rule"),
            Column::number(asked(output), design.unit.clone()),
            Column::number("Against probabilistic", if design.is_celsius() { "K" } else { "%" }),
            Column::number("P there", ""),
            Column::number("Prediction", shown.unit.clone()),
            Column::number("Margin left", shown.difference().unit),
            Column::text("Rule and source"),
        ],
        rows,
    })
}

fn worst_case(output: &Output) -> Option<Block> {
    if output.worst_case.is_empty() {
        return None;
    }
    let rows = output
        .worst_case
        .iter()
        .map(|end| {
            let parameter = Shown::parameter_of(&end.unit, end.nominal.abs().max(end.worst.abs()));
            let effect = Shown::quantity(&output.unit, output.is_temperature).difference();
            let sign = if end.effect > 0.0 { "+" } else { "" };
            vec![
                Cell::code(&end.requirement),
                Cell::code(&end.parameter),
                number::as_given(parameter.value(end.nominal)).into(),
                number::as_given(parameter.value(end.worst)).into(),
                parameter.unit.clone().into(),
                format!("{sign}{}", effect.number(end.effect)).into(),
            ]
        })
        .collect();
    let unit = Shown::quantity(&output.unit, output.is_temperature).difference().unit;
    Some(Block::Table(Table {
        caption: "The stack: each parameter at the end of its prior that is worst for the requirement, and what it does alone.".into(),
        columns: vec![
            Column::text("Requirement"),
            Column::text("Parameter"),
            Column::number("Nominal", ""),
            Column::number("Worst", ""),
            Column::text("Unit"),
            Column::number("Change of the quantity", unit),
        ],
        rows,
    }))
}
