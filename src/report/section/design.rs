//! The experiment that teaches most: candidates, the best, limits, sensors.

mod brief;
mod spread;

use crate::job::design::{Candidate, Kind, Output, Pick};
use crate::math::functions::exp;
use crate::math::sort::sort_by;
use crate::report::number::{self, NONE, Shown, fixed, percent, significant, typeset, with_error};
use crate::report::page::{Block, Cell, Column, Figure, Section, Status, Table, Text, Tone};
use crate::report::plot::{Axis, Bar, Chart, HeatMap, Layer, Mark, Stroke, bar_chart, heat_map, palette};
use crate::report::view::PassReport;

use super::Entry;

/// Candidates of the table that stand open.
const OPEN_ROWS: usize = 10;
/// Candidates of a bar chart.
const MOST_BARS: usize = 15;
/// Most columns of a heat map that stay legible.
const MOST_COLUMNS: usize = 16;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Design);

/// The section on designs of experiments; not without one.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    let jobs = report.outputs::<Kind>().count();
    for (name, output) in report.outputs::<Kind>() {
        if jobs > 1 {
            blocks.push(Block::Heading(format!("Job {name}")));
        }
        blocks.extend(verdict(output));
        blocks.extend(figure(name, output).map(Block::Figure));
        blocks.extend(spread::blocks(name, output));
        blocks.extend(candidates(output));
        blocks.extend(picks(output));
        blocks.extend(sensors(output));
        blocks.extend(observability(output));
        blocks.extend(convergence(name, output));
        blocks.push(Block::paragraph(method(name, output)));
    }
    (!blocks.is_empty()).then(|| Section { id: "design", title: "Design of experiments".into(), blocks })
}

/// The conditions of a candidate in words, in the study's units.
pub fn conditions(output: &Output, candidate: usize) -> String {
    let Some(candidate) = output.candidates.get(candidate) else { return String::new() };
    let words = output.axes.iter().filter_map(|axis| {
        let value = candidate.conditions.get(&axis.input)?;
        let shown = Shown::written(&axis.unit);
        Some(format!("{} = {}", axis.input, number::with_unit(&given(&shown, *value), &shown.unit)))
    });
    words.collect::<Vec<_>>().join(", ")
}

/// A value that is set, in the study's unit.
fn given(shown: &Shown, si: f64) -> String {
    number::as_given(shown.value(si))
}

fn listed(names: &[String]) -> Text {
    let mut text = Text::default();
    for (place, name) in names.iter().enumerate() {
        if place > 0 {
            text = text.plain(if place + 1 == names.len() { " and " } else { ", " });
        }
        text = text.code(name);
    }
    text
}

fn verdict(output: &Output) -> Vec<Block> {
    let mut blocks = Vec::new();
    match &output.best {
        Some(best) => {
            let mut text = Text::new("The candidate that tells most about ");
            text.0.extend(listed(&output.learn).0);
            let value = with_error(best.information_nats, best.se);
            let text = text.plain(" is ").strong(conditions(output, best.candidate)).plain(match best.bias_bound {
                Some(bias) => format!(": {value} nats expected, bias at most {}.", significant(bias, 2)),
                None => format!(": about {value} nats expected, by an approximation of unknown bias."),
            });
            let text = if output.learn.len() == 1 {
                // exp(-U) is exact for a normal posterior of a normal prior.
                text.plain(format!(
                    " A normal posterior would then have about {} of the prior's standard deviation.",
                    percent(exp(-best.information_nats), 0)
                ))
            } else {
                text
            };
            blocks.push(Block::Callout(Tone::Verdict, text));
        }
        None if !output.is_trusted => {
            blocks.push(Block::callout(
                Tone::Warning,
                "No candidate is named: no estimate of the information can be trusted.",
            ));
        }
        None => blocks.push(Block::callout(Tone::Warning, "No candidate is allowed and has an estimate.")),
    }
    if !output.findings.is_empty() {
        blocks.push(Block::List(output.findings.iter().map(|finding| Text::new(finding.clone())).collect()));
    }
    blocks
}

/// Decimals that the errors leave sense in.
fn digits(output: &Output) -> usize {
    let errors = output.candidates.iter().filter_map(|candidate| candidate.se);
    if errors.fold(0.0, f64::max) < 0.005 { 3 } else { 2 }
}

fn figure(job: &str, output: &Output) -> Option<Figure> {
    let learn = output.learn.join(", ");
    match output.axes.as_slice() {
        [rows, columns] if output.is_grid && columns.values.len() <= MOST_COLUMNS => {
            let (down, across) = (Shown::written(&rows.unit), Shown::written(&columns.unit));
            let width = columns.values.len();
            let map = HeatMap {
                columns: columns.values.iter().map(|value| given(&across, *value)).collect(),
                rows: (rows.values.iter().enumerate())
                    .map(|(row, value)| {
                        let row_candidates = &output.candidates[row * width..(row + 1) * width];
                        let values = row_candidates.iter().map(|c| c.information_nats.filter(|_| c.allowed)).collect();
                        (number::with_unit(&given(&down, *value), &down.unit), false, values)
                    })
                    .collect(),
                full_scale: 0.0,
                limit: None,
                legend: format!(
                    "expected information [nats]: {} down, {} across",
                    rows.input,
                    across.title(&columns.input)
                ),
                mark_label: String::new(),
                decimals: digits(output),
                is_unsigned: true,
                is_small: false,
            };
            let caption = format!(
                "Expected information about {learn} by {} and {}, in nats. Empty: not allowed.",
                rows.input, columns.input
            );
            Some(drawn(job, heat_map(&map), caption))
        }
        [axis] if output.is_grid => Some(curve(job, output, axis, &learn)),
        _ => Some(bars(job, output, &learn)),
    }
}

fn drawn(job: &str, drawing: crate::report::plot::Drawing, caption: String) -> Figure {
    Figure { id: format!("{job}-information"), drawing, alternative: caption.clone(), caption: caption.into() }
}

fn curve(job: &str, output: &Output, axis: &crate::job::design::Axis, learn: &str) -> Figure {
    let shown = Shown::written(&axis.unit);
    let mut points: Vec<(f64, f64, f64, bool)> = (output.candidates.iter())
        .filter_map(|candidate| {
            let x = shown.value(*candidate.conditions.get(&axis.input)?);
            let margin = 2.0 * candidate.se.unwrap_or(0.0) + candidate.bias_bound.unwrap_or(0.0);
            Some((x, candidate.information_nats?, margin, candidate.allowed))
        })
        .collect();
    sort_by(&mut points, |a, b| a.0.total_cmp(&b.0));
    let dots = |allowed: bool| points.iter().filter(|p| p.3 == allowed).map(|p| (p.0, p.1)).collect::<Vec<_>>();
    let mut chart = Chart {
        x: Axis::new(shown.title(&axis.input)),
        y: Axis::new("expected information [nats]"),
        ..Chart::default()
    };
    let colour = palette::BLUE;
    chart.layers.push(Layer::Band {
        points: points.iter().map(|p| (p.0, p.1 - p.2, p.1 + p.2)).collect(),
        colour,
        label: "two standard errors and the bias".into(),
    });
    let line = points.iter().map(|p| (p.0, p.1)).collect();
    chart.layers.push(Layer::Line { points: line, colour, stroke: Stroke::Solid, label: String::new() });
    chart.layers.push(Layer::Dots { points: dots(true), colour, mark: Mark::Disc, label: String::new() });
    if !dots(false).is_empty() {
        let (points, colour) = (dots(false), palette::VERMILION);
        chart.layers.push(Layer::Dots { points, colour, mark: Mark::Ring, label: "not allowed".into() });
    }
    drawn(job, chart.draw(), format!("Expected information about {learn} against {}, in nats.", axis.input))
}

/// Allowed candidates with the most information first, then the others.
fn ranked(output: &Output) -> Vec<usize> {
    let mut order: Vec<usize> = (0..output.candidates.len()).collect();
    let key = |&index: &usize| {
        let candidate = &output.candidates[index];
        (candidate.allowed, candidate.information_nats.unwrap_or(f64::NEG_INFINITY))
    };
    sort_by(&mut order, |a, b| {
        let ((a_allowed, a), (b_allowed, b)) = (key(a), key(b));
        b_allowed.cmp(&a_allowed).then(b.total_cmp(&a))
    });
    order
}

fn bars(job: &str, output: &Output, learn: &str) -> Figure {
    let bars: Vec<Bar> = (ranked(output).into_iter().take(MOST_BARS))
        .filter_map(|index| {
            let candidate = &output.candidates[index];
            let (value, error) = (candidate.information_nats?, 2.0 * candidate.se.unwrap_or(0.0));
            Some(Bar {
                label: conditions(output, index),
                from: 0.0,
                value,
                interval: Some([value - error, value + error]),
                text: fixed(value, digits(output)),
                colour: if candidate.allowed { palette::BLUE } else { palette::VERMILION },
            })
        })
        .collect();
    let caption =
        format!("Expected information about {learn}, in nats, with two standard errors: the most telling candidates.");
    drawn(job, bar_chart(&Axis::new("expected information [nats]"), &bars, None), caption)
}

fn candidates(output: &Output) -> Vec<Block> {
    let shows = |of: fn(&Candidate) -> Option<f64>| output.candidates.iter().any(|candidate| of(candidate).is_some());
    let (has_red, has_yellow) = (shows(|c| c.violation.red), shows(|c| c.violation.yellow));
    let mut columns: Vec<Column> =
        (output.axes.iter()).map(|axis| Column::number(&axis.input, Shown::written(&axis.unit).unit)).collect();
    columns.extend([
        Column::number("Information", "nats"),
        Column::number("Bias at most", "nats"),
        Column::number("Behind the best", "nats"),
        Column::number("Linear estimate", "nats"),
    ]);
    if has_red {
        columns.push(Column::number("P(outside red)", ""));
    }
    if has_yellow {
        columns.push(Column::number("P(outside yellow)", ""));
    }
    columns.push(Column::text("Outcome"));
    let best = output.best.as_ref();
    let row = |index: usize| -> Vec<Cell> {
        let candidate = &output.candidates[index];
        let mut row: Vec<Cell> = (output.axes.iter())
            .map(|axis| match candidate.conditions.get(&axis.input) {
                Some(value) => given(&Shown::written(&axis.unit), *value).into(),
                None => NONE.into(),
            })
            .collect();
        let optional = |value: Option<String>| Cell::from(value.unwrap_or_else(|| NONE.to_owned()));
        row.push(optional(candidate.information_nats.map(|value| match candidate.se {
            Some(error) if error > 0.0 => with_error(value, error),
            _ => significant(value, 4),
        })));
        row.push(optional(candidate.bias_bound.map(|value| significant(value, 2))));
        row.push(optional(
            candidate.behind_best.map(
                |[value, error]| {
                    if error > 0.0 { with_error(value, error) } else { significant(value, 3) }
                },
            ),
        ));
        row.push(optional(candidate.linear_nats.map(|value| significant(value, 3))));
        for (share, has) in [(candidate.violation.red, has_red), (candidate.violation.yellow, has_yellow)] {
            if has {
                row.push(optional(share.map(number::probability)));
            }
        }
        let is_best = best.is_some_and(|best| best.candidate == index);
        let is_rival = best.is_some_and(|best| best.rivals.contains(&index));
        row.push(match &candidate.because {
            // The probability stands in a column of its own.
            Some(because) => match candidate.violation.not_tolerated {
                Some(limits) => Cell::marked(format!("outside the {} limits", limits.colour()), Status::Fail),
                None => Cell::marked(because.clone(), Status::Fail),
            },
            None if candidate.sees_nothing => Cell::marked("sees nothing", Status::Caution),
            None if is_best => Cell::marked("best", Status::Ok),
            None if is_rival => "not told from the best".into(),
            None if candidate.is_found => "between the grid's values".into(),
            None => Cell::default(),
        });
        row
    };
    let mut rows: Vec<Vec<Cell>> = ranked(output).into_iter().map(row).collect();
    let folded = rows.split_off(rows.len().min(OPEN_ROWS));
    let caption = "Candidates by expected information, with its standard error. Differences from the best are on common \
                   random numbers and known better than the values.";
    let mut blocks = vec![Block::Table(Table { caption: caption.into(), columns: columns.clone(), rows })];
    if !folded.is_empty() {
        let title = format!("Further candidates ({})", folded.len());
        let table = Table { caption: "Further candidates.".into(), columns, rows: folded };
        blocks.push(Block::Details(title, vec![Block::Table(table)]));
    }
    blocks
}

fn pick_rows(picks: &[Pick], name: impl Fn(usize) -> Cell) -> Vec<Vec<Cell>> {
    let mut before = 0.0;
    let rows = picks.iter().enumerate().map(|(place, pick)| {
        let gain = pick.information_nats - before;
        before = pick.information_nats;
        vec![
            (place + 1).to_string().into(),
            name(pick.position),
            with_error(pick.information_nats, pick.se).into(),
            fixed(gain, 3).into(),
            pick.bias_bound.map_or_else(|| NONE.to_owned(), |bias| significant(bias, 2)).into(),
        ]
    });
    rows.collect()
}

fn pick_columns(what: &str) -> Vec<Column> {
    vec![
        Column::number("Step", ""),
        Column::text(what),
        Column::number("Information of all", "nats"),
        Column::number("Gain", "nats"),
        Column::number("Bias at most", "nats"),
    ]
}

fn picks(output: &Output) -> Vec<Block> {
    if output.picks.len() < 2 {
        return Vec::new();
    }
    let table = Table {
        caption: "Phases chosen one after the other, each the one that adds most to those before it.".into(),
        columns: pick_columns("Phase"),
        rows: pick_rows(&output.picks, |position| conditions(output, position).into()),
    };
    let mut blocks = vec![Block::Table(table)];
    if !output.guarantee.is_empty() {
        blocks.push(Block::paragraph(output.guarantee.clone()));
    }
    blocks
}

fn sensors(output: &Output) -> Vec<Block> {
    let mut blocks = Vec::new();
    if !output.sensor_picks.is_empty() {
        let name = |position: usize| Cell::code(output.sensors.get(position).map_or("", |sensor| sensor.name.as_str()));
        blocks.push(Block::Table(Table {
            caption: "Sensors chosen one after the other at the best candidate.".into(),
            columns: pick_columns("Sensor"),
            rows: pick_rows(&output.sensor_picks, name),
        }));
    }
    if output.sensors.len() > 1 && output.correlations.len() == output.sensors.len() {
        let mut columns = vec![Column::text("Sensor")];
        columns.extend(output.sensors.iter().map(|sensor| Column::number(&sensor.name, "")));
        let rows = output.correlations.iter().zip(&output.sensors).map(|(row, sensor)| {
            let mut cells = vec![Cell::code(&sensor.name)];
            cells.extend(row.iter().enumerate().map(|(place, value)| match value {
                Some(value) => {
                    let is_other = output.sensors[place].name != sensor.name;
                    let text = fixed(*value, 3);
                    if is_other && value.abs() >= 0.98 { Cell::marked(text, Status::Caution) } else { text.into() }
                }
                None => NONE.into(),
            }));
            cells
        });
        blocks.push(Block::Table(Table {
            caption:
                "Correlation of the sensors' noise-free readings over the prior at the best candidate. Amber: both \
                      tell the same."
                    .into(),
            columns,
            rows: rows.collect(),
        }));
    }
    blocks
}

fn observability(output: &Output) -> Option<Block> {
    if output.observability.is_empty() {
        return None;
    }
    let mut columns = vec![Column::text("Parameter"), Column::text("Role")];
    columns.extend(output.sensors.iter().map(|sensor| Column::number(&sensor.name, typeset(&sensor.unit))));
    let rows = output.observability.iter().map(|observed| {
        let role = if observed.learn { "to learn" } else { "nuisance" };
        let mut row = vec![Cell::code(&observed.parameter), role.into()];
        row.extend(observed.changes.iter().zip(&output.sensors).map(|(change, sensor)| {
            let text = significant(*change, 3);
            if observed.learn && change.abs() < sensor.sigma {
                Cell::marked(text, Status::Caution)
            } else {
                text.into()
            }
        }));
        row
    });
    let noise: Vec<String> = (output.sensors.iter())
        .map(|sensor| {
            format!("{} {}", sensor.name, number::with_unit(&significant(sensor.sigma, 3), &typeset(&sensor.unit)))
        })
        .collect();
    Some(Block::Table(Table {
        caption: format!(
            "Observability at the best candidate: change of the reading for one prior standard deviation of the parameter. \
             Amber: below the noise of one reading ({}).",
            noise.join(", ")
        )
        .into(),
        columns,
        rows: rows.collect(),
    }))
}

fn convergence(job: &str, output: &Output) -> Option<Block> {
    if output.convergence.len() < 2 || output.estimator == "linear" {
        return None;
    }
    let rows = output.convergence.iter().map(|part| {
        let error = part.se.map_or_else(|| NONE.to_owned(), |error| significant(error, 2));
        vec![part.samples.to_string().into(), fixed(part.information_nats, 4).into(), error.into()]
    });
    let table = Table {
        caption: "The estimate of the best candidate from the first of its outer samples.".into(),
        columns: vec![
            Column::number("Outer samples", ""),
            Column::number("Information", "nats"),
            Column::number("Standard error", "nats"),
        ],
        rows: rows.collect(),
    };
    // Of one replicate there is no error, of two Student's factor makes it too wide to be drawn beside the others.
    let drawn =
        output.convergence.iter().filter_map(|part| Some((part.samples as f64, part.information_nats, part.se?)));
    let drawn: Vec<(f64, f64, f64)> = drawn.skip(1).collect();
    let chart = Chart {
        x: Axis::new("outer samples"),
        y: Axis::new("expected information [nats]"),
        layers: vec![
            Layer::Band {
                points: drawn.iter().map(|p| (p.0, p.1 - 2.0 * p.2, p.1 + 2.0 * p.2)).collect(),
                colour: palette::BLUE,
                label: "two standard errors".into(),
            },
            Layer::Line {
                points: drawn.iter().map(|p| (p.0, p.1)).collect(),
                colour: palette::BLUE,
                stroke: Stroke::Solid,
                label: String::new(),
            },
            Layer::Dots {
                points: drawn.iter().map(|p| (p.0, p.1)).collect(),
                colour: palette::BLUE,
                mark: Mark::Disc,
                label: String::new(),
            },
        ],
        height: 620,
        ..Chart::default()
    };
    let caption = "The estimate of the best candidate as its outer samples grow.";
    let figure = (drawn.len() > 1).then(|| Figure {
        id: format!("{job}-convergence"),
        drawing: chart.draw(),
        alternative: caption.to_owned(),
        caption: caption.into(),
    });
    let blocks = figure.map(Block::Figure).into_iter().chain([Block::Table(table)]).collect();
    Some(Block::Details("Convergence of the estimate".into(), blocks))
}

fn method(job: &str, output: &Output) -> Text {
    let [outer, inner, draws] = output.samples;
    let how = match output.estimator.as_str() {
        "nested" => format!(
            "nested Monte Carlo with {outer} outer and {inner} inner scrambled Sobol points in 16 replicates, whose scatter gives \
             the standard error{}",
            if output.nuisance.is_empty() {
                "; each outer sample is read with several noises".to_owned()
            } else {
                format!("; nuisance parameters integrated out by {draws} importance draws a sample")
            }
        ),
        "importance" => format!(
            "importance sampling of the inner integrals by {draws} draws round a Laplace approximation, {outer} outer points in \
             16 replicates"
        ),
        "laplace" => format!("the average divergence of Laplace approximations over {outer} outer points"),
        _ => "a linear model with normal priors at nominal parameters".to_owned(),
    };
    let mut text = Text::new("Job ").code(job).plain(format!(
        ": expected information gain (Lindley 1956) by {how}; {} solutions of the model. One nat narrows the normal posterior of a single parameter to \
         {} of the prior's standard deviation. ",
        output.solutions,
        percent(0.367_879_441_171_442_33, 0)
    ));
    if !output.because.is_empty() {
        text = text.plain("The estimator was left to the program: ").code(&output.estimator).plain(", because ");
        text.0.extend(Text::with_names(&format!("{}. ", output.because)).0);
    }
    let found_count = output.candidates.iter().filter(|candidate| candidate.is_found).count();
    if found_count > 0 {
        text = text.plain(format!(
            "{found_count} of the candidates were sought between the grid's values by Bayesian optimisation. "
        ));
    }
    text = if output.nuisance.is_empty() {
        text.plain("No other parameter is uncertain in it.")
    } else {
        let mut text = text.plain("Integrated out: ");
        text.0.extend(listed(&output.nuisance).0);
        text.plain(".")
    };
    text
}
