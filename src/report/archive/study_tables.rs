//! Tables over the passes of a study: requirements, key statements, parameters, changes, what flies.

use std::collections::BTreeSet;

use crate::document::counted;
use crate::math::sort::sort_by_key;
use crate::report::known::{self, Known};
use crate::report::number::{NONE, significant};
use crate::report::page::{Block, Cell, Column, Figure, Section, Table, Text};
use crate::report::plot::{Axis, Bar, bar_chart, palette};

use super::record::{HASH, ModelFile};
use super::study_page::{link, name};
use super::{ArchivedPass, ArchivedStudy};

/// Parameters whose intervals are drawn.
const MOST_FIGURES: usize = 12;
/// Hexadecimal digits of a file's hash that are shown.
const DIGITS: usize = 12;
/// Changed entries of a model's file that are named.
const MOST_ENTRIES: usize = 6;

/// A table of the rows of the last pass that has any, and those of earlier passes folded below it.
fn latest_first(
    rows: Vec<(&ArchivedPass, Vec<Cell>)>,
    study: &ArchivedStudy,
    table: impl Fn(Vec<Vec<Cell>>) -> Table,
) -> Vec<Block> {
    let has_rows = |pass: &&ArchivedPass| rows.iter().any(|(own, _)| std::ptr::eq(*own, *pass));
    let Some(last) = study.passes.iter().rev().find(has_rows) else { return Vec::new() };
    let (latest, earlier): (Vec<_>, Vec<_>) = rows.into_iter().partition(|(own, _)| std::ptr::eq(*own, last));
    let cells = |rows: Vec<(&ArchivedPass, Vec<Cell>)>| rows.into_iter().map(|(_, cells)| cells).collect::<Vec<_>>();
    let mut blocks = vec![Block::Table(table(cells(latest)))];
    if !earlier.is_empty() {
        let title = format!("Earlier passes ({})", counted(earlier.len(), "row"));
        blocks.push(Block::Details(title, vec![Block::Table(table(cells(earlier)))]));
    }
    blocks
}

/// Requirements over the passes that judge them.
pub(super) fn requirements(study: &ArchivedStudy) -> Option<Section> {
    let judged = study.passes.iter().flat_map(|pass| pass.record.requirements.iter().map(move |own| (pass, own)));
    let mut judged: Vec<_> = judged.filter(|(_, own)| own.probability.is_some()).collect();
    // A requirement's rows stand together, by pass.
    let mut names: Vec<(&str, &str)> = Vec::new();
    for (_, own) in &judged {
        let name = (own.requirement.as_str(), own.environment.as_str());
        if !names.contains(&name) {
            names.push(name);
        }
    }
    sort_by_key(&mut judged, |(_, own)| {
        names.iter().position(|name| *name == (own.requirement.as_str(), own.environment.as_str()))
    });
    let rows: Vec<(&ArchivedPass, Vec<Cell>)> = judged
        .into_iter()
        .map(|(pass, own)| {
            let cells = vec![
                Cell::code(&own.requirement),
                own.limit.clone().into(),
                Cell::code(&own.environment),
                Cell::from(link(pass)),
                own.predicted.clone().into(),
                own.probability_text.clone().into(),
                own.margin.clone().into(),
                own.state.clone().into(),
                Cell { text: Text::with_names(&own.verdict), status: Some(own.status) },
                Cell::code(&own.job),
            ];
            (pass, cells)
        })
        .collect();
    (!rows.is_empty()).then(|| Section {
        id: "requirements",
        title: "Requirements and margins over the passes".into(),
        blocks: latest_first(rows, study, |rows| Table {
            caption: "What each pass says of each requirement. Predicted: median, quantiles of 1 % and 99 %. Margin: between the limit \
                      and the quantile towards it at the required probability."
                .into(),
            columns: vec![
                Column::text("Requirement"),
                Column::text("Limit"),
                Column::text("Environment"),
                Column::text("Pass"),
                Column::text("Predicted"),
                Column::text("P(met)"),
                Column::text("Margin"),
                Column::text("Rests on the model"),
                Column::text("Verdict"),
                Column::text("Job"),
            ],
            rows,
        }),
    })
}

/// Key statements of each pass: sizes by rule and by probability among them.
pub(super) fn statements(study: &ArchivedStudy) -> Option<Section> {
    let rows: Vec<(&ArchivedPass, Vec<Cell>)> = study
        .passes
        .iter()
        .flat_map(|pass| {
            pass.record.statements.iter().map(move |own| {
                let value = Cell { text: own.value.as_str().into(), status: own.status };
                (pass, vec![Cell::from(link(pass)), own.label.clone().into(), value])
            })
        })
        .collect();
    (!rows.is_empty()).then(|| Section {
        id: "statements",
        title: "Key numbers by pass".into(),
        blocks: latest_first(rows, study, |rows| Table {
            caption: "What stands in large letters on the first screen of each pass: sizes by rule and by probability, effects, states."
                .into(),
            columns: vec![Column::text("Pass"), Column::text("What"), Column::text("Value")],
            rows,
        }),
    })
}

/// A parameter in the order in which it first appears, with the passes that have it.
fn by_parameter(study: &ArchivedStudy) -> Vec<(&str, Vec<(&ArchivedPass, Known)>)> {
    let mut all: Vec<(&str, Vec<(&ArchivedPass, &Known)>)> = Vec::new();
    for pass in &study.passes {
        for own in &pass.record.parameters {
            match all.iter_mut().find(|(name, _)| *name == own.name) {
                Some((_, list)) => list.push((pass, own)),
                None => all.push((own.name.as_str(), vec![(pass, own)])),
            }
        }
    }
    let in_one_unit = all.into_iter().map(|(name, list)| {
        let (passes, knowns): (Vec<&ArchivedPass>, Vec<&Known>) = list.into_iter().unzip();
        (name, passes.into_iter().zip(known::stated(&knowns)).collect())
    });
    in_one_unit.collect()
}

/// Parameters over the passes, from prior to posterior: a row where something changed or was inferred.
pub(super) fn parameters(study: &ArchivedStudy) -> Option<Section> {
    let (mut rows, mut figures, mut unchanged) = (Vec::new(), Vec::new(), 0_u64);
    for (parameter, list) in by_parameter(study) {
        let is_other = |own: &Known| {
            list.first().is_some_and(|(_, first)| own.prior != first.prior || own.nominal != first.nominal)
        };
        if !list.iter().any(|(_, own)| own.posterior.is_some() || is_other(own)) {
            unchanged += 1;
            continue;
        }
        let mut before: Option<&Known> = None;
        for (pass, own) in &list {
            let is_same = before.is_some_and(|before| before.prior == own.prior && before.nominal == own.nominal);
            before = Some(own);
            if is_same && own.posterior.is_none() {
                continue;
            }
            rows.push(vec![
                Cell::code(parameter),
                own.unit.clone().into(),
                Cell::from(link(pass)),
                own.nominal_text().into(),
                own.prior.clone().into(),
                own.posterior_text().into(),
            ]);
        }
        figures.extend(intervals(parameter, &list));
    }
    if rows.is_empty() {
        return None;
    }
    let left_out = match unchanged {
        0 => String::new(),
        count => format!(
            " {} no pass changed or inferred; the report of a pass has them.",
            counted(count, "further parameter")
        ),
    };
    let count = counted(rows.len(), "row");
    let table = Block::Table(Table {
        caption: format!(
            "Parameters over the passes: a row where a pass has another nominal value or prior than the one before it, or infers the \
             parameter. Posterior: mean, standard deviation, 95 % interval; the calibration.{left_out}"
        )
        .into(),
        columns: vec![
            Column::text("Parameter"),
            Column::text("Unit"),
            Column::text("Pass"),
            Column::number("Nominal", ""),
            Column::text("Prior"),
            Column::text("Posterior"),
        ],
        rows,
    });
    // What was delivered, tuned last and flies stands open in a table of its own.
    let mut blocks = vec![Block::Details(format!("Parameters, pass by pass ({count})"), vec![table])];
    figures.truncate(MOST_FIGURES);
    if !figures.is_empty() {
        blocks.push(Block::Details(format!("Intervals, prior and posterior ({})", figures.len()), figures));
    }
    Some(Section { id: "parameters", title: "Parameters over the passes".into(), blocks })
}

/// Intervals of 95 % of a parameter's priors and posteriors; not without a posterior.
fn intervals(parameter: &str, list: &[(&ArchivedPass, Known)]) -> Option<Block> {
    list.iter().find(|(_, own)| own.posterior.is_some())?;
    let mut bars: Vec<Bar> = Vec::new();
    let mut last_prior = None;
    for (pass, own) in list {
        let name = name(pass);
        if let Some(prior) = own.prior_interval.filter(|_| last_prior != Some(&own.prior)) {
            bars.push(bar(format!("prior, {name}"), prior, String::new()));
            last_prior = Some(&own.prior);
        }
        if let Some(posterior) = &own.posterior {
            let text = format!("{} \u{B1} {}", significant(posterior.mean, 4), significant(posterior.sd, 2));
            bars.push(bar(format!("posterior, {name}"), posterior.interval, text));
        }
    }
    let unit = list.first().map_or("", |(_, own)| own.unit.as_str());
    let title = if unit.is_empty() { parameter.to_owned() } else { format!("{parameter} [{unit}]") };
    let said: Vec<String> = bars.iter().map(|bar| format!("{} {}", bar.label, bar.text)).collect();
    Some(Block::Figure(Figure {
        id: format!("parameter-{parameter}"),
        drawing: bar_chart(&Axis::new(title), &bars, None),
        caption: Text::new("Intervals of 95 % of ").code(parameter).plain(": priors and posteriors, pass by pass."),
        alternative: format!("Intervals of {parameter}: {}.", said.join("; ")),
    }))
}

fn bar(label: String, interval: [f64; 2], text: String) -> Bar {
    let [low, high] = interval;
    Bar { label, from: low, value: high, interval: Some(interval), text, colour: palette::SKY }
}

/// That the model's file of a pass is another one than that of the pass before it, and what differs.
fn of_model(pass: &ArchivedPass, earlier: &[&ArchivedPass]) -> Option<Vec<Cell>> {
    let own = pass.record.model.as_ref()?;
    let parent = pass.record.errors.as_ref().and_then(|errors| errors.parent.as_ref());
    let before = earlier.iter().rev().find(|other| parent == Some(&other.record.pass)).or(earlier.last())?;
    let before = before.record.model.as_ref().filter(|before| before.sha256 != own.sha256)?;
    let short = |file: &ModelFile| {
        let digits: String = file.sha256.chars().take(DIGITS).collect();
        Text::default().code(&file.path).plain(" ").code(digits)
    };
    let names: BTreeSet<&String> = before.entries.keys().chain(own.entries.keys()).collect();
    let words = names.into_iter().filter_map(|name| match (before.entries.get(name), own.entries.get(name)) {
        (Some(before), Some(after)) if before == after => None,
        (Some(before), Some(after)) if ![before, after].iter().any(|own| own.starts_with(HASH)) => {
            Some(format!("{name}: {before} \u{2192} {after}"))
        }
        (Some(_), Some(_)) => Some(format!("{name} changed")),
        (None, _) => Some(format!("{name} added")),
        (_, None) => Some(format!("{name} removed")),
    });
    let words: Vec<String> = words.collect();
    let more = words.len().saturating_sub(MOST_ENTRIES);
    let mut text = words.iter().take(MOST_ENTRIES).cloned().collect::<Vec<_>>().join("; ");
    if more > 0 {
        text.push_str(&format!("; {}", counted(more, "more entry")));
    }
    // Without entries on both sides only the hashes are known to differ.
    let is_known = !before.entries.is_empty() && !own.entries.is_empty();
    let text = match (is_known, words.is_empty()) {
        (true, false) => text,
        (true, true) => "the same entries, written otherwise".to_owned(),
        (false, _) => "what differs is not known".to_owned(),
    };
    Some(vec![
        Cell::from(link(pass)),
        "model file".into(),
        Cell::code(&own.path),
        Cell::from(short(before)),
        Cell::from(short(own)),
        text.into(),
    ])
}

/// Every change with its reason, where it first stands.
pub(super) fn changes(study: &ArchivedStudy) -> Option<Section> {
    let mut seen = Vec::new();
    let mut rows = Vec::new();
    let mut earlier: Vec<&ArchivedPass> = Vec::new();
    for pass in &study.passes {
        rows.extend(of_model(pass, &earlier));
        earlier.push(pass);
        let parameters = pass.record.changes.iter().map(|own| ("parameter", own));
        let effects = pass.record.adopted.iter().map(|own| ("effect", own));
        for (kind, own) in parameters.chain(effects) {
            if seen.contains(&own) {
                continue;
            }
            seen.push(own);
            let before = if own.before.is_empty() { NONE } else { own.before.as_str() };
            rows.push(vec![
                Cell::from(link(pass)),
                kind.into(),
                Cell::code(&own.what),
                before.into(),
                own.after.clone().into(),
                Text::with_names(&own.because).into(),
            ]);
        }
    }
    (!rows.is_empty()).then(|| Section {
        id: "changes",
        title: "Change log".into(),
        blocks: vec![Block::Table(Table {
            caption: "Every change of the model over all passes, where it first stands: another model's file, nominal values and priors against the model's \
                      file, and adopted effects."
                .into(),
            columns: vec![
                Column::text("Pass"),
                Column::text("Kind"),
                Column::text("What"),
                Column::text("Model's file"),
                Column::text("From this pass on"),
                Column::text("Justification"),
            ],
            rows,
        })],
    })
}

/// Parameters as delivered, as tuned last, and as the last prediction takes them.
pub(super) fn flight(study: &ArchivedStudy) -> Option<Section> {
    let last = study.passes.iter().rev().find(|pass| !pass.record.flight.is_empty());
    let mut rows = Vec::new();
    for (parameter, list) in by_parameter(study) {
        let Some((first_pass, first)) = list.first() else { continue };
        let tuned = list.iter().rev().find(|(_, own)| own.posterior.is_some());
        let in_flight = last.and_then(|pass| {
            let (_, own) = list.iter().find(|(other, _)| std::ptr::eq(*other, pass))?;
            let draws =
                pass.record.flight.iter().rev().find(|flight| flight.parameters.iter().any(|name| name == parameter));
            Some(
                draws.map_or_else(|| format!("prior: {}", own.prior), |draws| format!("posterior of {}", draws.source)),
            )
        });
        let is_moved = list.iter().any(|(_, own)| own.nominal != first.nominal || own.prior != first.prior);
        if tuned.is_none() && !is_moved {
            continue;
        }
        rows.push(vec![
            Cell::code(parameter),
            first.unit.clone().into(),
            format!("{} ({})", first.nominal_text(), name(first_pass)).into(),
            tuned
                .map_or_else(|| NONE.to_owned(), |(pass, own)| format!("{}, {}", own.posterior_text(), name(pass)))
                .into(),
            in_flight.unwrap_or_else(|| NONE.to_owned()).into(),
        ]);
    }
    let caption = match last {
        Some(pass) => format!(
            "Parameters that were changed or inferred: nominal value as first delivered; last posterior; what the prediction of {} \
             takes. All others are as delivered.",
            name(pass)
        ),
        None => "Parameters that were changed or inferred: nominal value as first delivered; last posterior. No pass predicts with a \
                 calibration."
            .to_owned(),
    };
    (!rows.is_empty()).then(|| Section {
        id: "flight",
        title: "Parameters: delivered, tuned, flight".into(),
        blocks: vec![Block::Table(Table {
            caption: caption.into(),
            columns: vec![
                Column::text("Parameter"),
                Column::text("Unit"),
                Column::text("Delivered"),
                Column::text("Tuned"),
                Column::text("Flight"),
            ],
            rows,
        })],
    })
}
