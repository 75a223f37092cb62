//! Margins from history: differences class by class, margins with their bounds, what rules would have held.

mod brief;

use crate::job::margins_from_history::{Group, Kind, Output};
use crate::report::number::{NONE, fixed, percent, signed, with_unit};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text, Tone};
use crate::report::plot::{Along, Axis, Chart, Layer, Limit, palette};
use crate::report::view::PassReport;

use super::Entry;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::MarginsFromHistory);

/// The section on margins from history; not without such a job.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    for (name, output) in report.outputs::<Kind>() {
        blocks.push(Block::Paragraph(opening(name, output)));
        blocks.extend(output.findings.iter().map(|finding| {
            let mut characters = finding.replace('`', "").chars().collect::<Vec<_>>();
            if let Some(first) = characters.first_mut() {
                *first = first.to_ascii_uppercase();
            }
            Block::callout(Tone::Warning, format!("{}.", characters.into_iter().collect::<String>()))
        }));
        blocks.push(margins(output));
        blocks.extend(rules(output));
        let mut figures = output.groups.iter().map(|group| Block::Figure(histogram(name, output, group)));
        blocks.extend(figures.next());
        let rest: Vec<Block> = figures.collect();
        if !rest.is_empty() {
            blocks.push(Block::Details(format!("Differences by class ({})", rest.len()), rest));
        }
    }
    (!blocks.is_empty()).then(|| Section { id: "margins-from-history", title: "Margins from history".into(), blocks })
}

/// A difference in K.
pub(super) fn kelvin(value: f64) -> String {
    with_unit(&fixed(value, 1), "K")
}

/// What a group is called.
pub(super) fn named(group: &Group) -> &str {
    group.class.as_deref().unwrap_or("all")
}

fn opening(name: &str, output: &Output) -> Text {
    let (share, confidence) = (percent(output.capture, 0), percent(output.confidence, 0));
    Text::new("Job ")
        .code(name)
        .plain(": differences of measured and predicted temperatures of earlier programs, from ")
        .code(&output.file)
        .plain(format!(
            ". The margin is the least that holds {share} of a normal distribution with their mean and standard deviation, hot and cold \
             together. As few differences tell that with an error of its own, bounds at a confidence of {confidence} stand beside it: \
             the mean's magnitude and Howe's factor (1969) times the standard deviation; the same as if each program had given one \
             difference; and for any distribution an order statistic (Wilks 1941), for which {} differences are needed.",
            output.fewest_distribution_free
        ))
}

fn margins(output: &Output) -> Block {
    let number = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), |value| fixed(value, 1));
    let rows = output.groups.iter().map(|group| {
        let [coldest, hottest] = group.range_k.map(|end| signed(end, 1));
        vec![
            Cell::from(named(group)),
            group.comparisons.to_string().into(),
            group.programs.map_or_else(|| NONE.to_owned(), |programs| programs.to_string()).into(),
            match group.sd_k {
                Some(sd) => format!("{} \u{B1} {}", signed(group.mean_k, 1), fixed(2.0 * sd, 1)),
                None => signed(group.mean_k, 1),
            }
            .into(),
            format!("{coldest} to {hottest}").into(),
            Cell::from(Text::default().strong(number(group.margin_k))),
            group.within_margin.map_or_else(|| NONE.to_owned(), |share| percent(share, 0)).into(),
            number(group.bound_k).into(),
            number(group.bound_by_program_k).into(),
            number(group.distribution_free_k).into(),
        ]
    });
    Block::Table(Table {
        caption: "Measured minus predicted and the margin that it asks for, in K: mean and two standard deviations, the range, the \
                  margin with the share of the differences within it, and its bounds."
            .into(),
        columns: vec![
            Column::text("Class"),
            Column::number("Differences", ""),
            Column::number("Programs", ""),
            Column::number("Mean \u{B1} 2 sd", "K"),
            Column::number("Range", "K"),
            Column::number("Margin", "K"),
            Column::number("Within it", ""),
            Column::number("Bound", "K"),
            Column::number("Bound by program", "K"),
            Column::number("Any distribution", "K"),
        ],
        rows: rows.collect(),
    })
}

fn rules(output: &Output) -> Option<Block> {
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for group in &output.groups {
        for held in &group.rules {
            let share = held.inside as f64 / group.comparisons.max(1) as f64;
            let [lower, upper] = held.interval;
            let status = if lower >= output.capture {
                Status::Ok
            } else if upper < output.capture {
                Status::Fail
            } else {
                Status::Caution
            };
            rows.push(vec![
                Cell::from(named(group)),
                Cell::code(&held.rule),
                fixed(held.margin_k, 1).into(),
                Cell::marked(percent(share, 1), status),
                format!("{} to {}", percent(lower, 1), percent(upper, 1)).into(),
            ]);
        }
    }
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!(
                "What margins by rule would have held, with the interval of the share at a confidence of {} (Clopper & Pearson 1934), as if \
                 all differences were independent. \
                 Marked: above {} for sure, perhaps, not.",
                percent(output.confidence, 0),
                percent(output.capture, 0)
            )
            .into(),
            columns: vec![
                Column::text("Class"),
                Column::text("Rule"),
                Column::number("Margin", "K"),
                Column::number("Held", ""),
                Column::number("Interval", ""),
            ],
            rows,
        })
    })
}

fn histogram(job: &str, output: &Output, group: &Group) -> Figure {
    let mut limits = vec![Limit { along: Along::X, value: 0.0, label: String::new(), colour: palette::MUTED }];
    if let Some(margin) = group.margin_k {
        for (sign, label) in [(-1.0, String::new()), (1.0, kelvin(margin))] {
            limits.push(Limit { along: Along::X, value: sign * margin, label, colour: palette::VERMILION });
        }
    }
    let heights = group.counts.iter().map(|count| *count as f64).collect();
    let layer = Layer::Bars { edges: group.edges_k.clone(), heights, colour: palette::BLUE, label: String::new() };
    let chart = Chart {
        x: Axis::new("measured \u{2212} predicted [K]"),
        y: Axis::new("differences"),
        layers: vec![layer],
        limits,
        height: 700,
        ..Chart::default()
    };
    let caption = format!(
        "Differences of class {} ({}), with the margin either way that holds {} of them.",
        named(group),
        group.comparisons,
        percent(output.capture, 0)
    );
    Figure {
        id: format!("{job}-{}-differences", named(group)),
        drawing: chart.draw(),
        alternative: format!("Histogram. {caption}"),
        caption: caption.into(),
    }
}
