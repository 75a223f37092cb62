//! Calibration: whether it can be believed, what the parameters became, what the fit leaves.

mod brief;
mod figures;

use crate::document::{counted, p_value};
use crate::job::calibrate::{Evidence, Kind, Output, ParameterSummary, PhaseScore};
use crate::job::compare;
use crate::math::sort::sort_by;
use crate::report::number::{NONE, Shown, as_given, fixed, percent, significant, stated, typeset, with_error};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text, Tone};
use crate::report::view::PassReport;

use super::Entry;
use super::problem::prior_words;
use super::validation::IMPROBABLE;

/// Chains agree below it.
const MOST_RHAT: f64 = 1.01;
/// Fewer effective draws are too few.
const LEAST_EFFECTIVE: f64 = 400.0;

/// The section, and its kind's results in brief.
pub(super) const SECTION: Entry = Entry::of_kind(build, &brief::Calibration).apart();

/// The section on calibrations; not without one.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let checks = |name: &str, output: &Output| {
        let mut blocks = vec![coverage(output)];
        blocks.extend(scores(output));
        blocks.extend(figures::figures(name, output));
        blocks
    };
    of_each(report, |output| vec![parameters(output)], checks)
}

/// What tuning achieved in the comparisons, without the calibrations themselves.
pub fn achieved_alone(report: &PassReport<'_>) -> Option<Section> {
    let of = |comparison: &compare::Output| achieved(&comparison.tuned.as_ref()?.job, comparison);
    let blocks: Vec<Block> = report.outputs::<compare::Kind>().filter_map(|(_, comparison)| of(comparison)).collect();
    (!blocks.is_empty()).then(|| Section { id: "tuned", title: "After tuning".into(), blocks })
}

/// The posterior, whether it can be believed, the evidence; without the checks that a report goes into.
pub fn outlined(report: &PassReport<'_>) -> Option<Section> {
    of_each(report, |output| vec![posterior(output), trust(output)], |_, _| Vec::new())
}

/// The section with all calibrations: of each whether it can be believed, what it found, what tuning achieved, its checks and
/// how it was done.
fn of_each(
    report: &PassReport<'_>,
    found: impl Fn(&Output) -> Vec<Block>,
    checks: impl Fn(&str, &Output) -> Vec<Block>,
) -> Option<Section> {
    let mut blocks = Vec::new();
    let jobs = report.outputs::<Kind>().count();
    for (name, output) in report.outputs::<Kind>() {
        if jobs > 1 {
            blocks.push(Block::Heading(format!("Job {name}")));
        }
        blocks.extend(verdict(name, output));
        blocks.extend(found(output));
        blocks.extend(report.outputs::<compare::Kind>().filter_map(|(_, comparison)| achieved(name, comparison)));
        blocks.extend(checks(name, output));
        blocks.push(Block::paragraph(method(output)));
    }
    (!blocks.is_empty()).then(|| Section { id: "calibration", title: "Calibration".into(), blocks })
}

/// Mean, spread and quantiles of the draws.
fn posterior(output: &Output) -> Block {
    let row = |name: &String, summary: &ParameterSummary| {
        let (times, unit) = stated(&summary.unit, summary.mean.abs().max(summary.sd));
        let quantile = |value: f64| Cell::from(to(times * value, times * summary.sd));
        vec![
            Cell::code(name),
            quantile(summary.mean),
            significant(times * summary.sd, 2).into(),
            quantile(summary.q025),
            quantile(summary.q50),
            quantile(summary.q975),
            unit.into(),
        ]
    };
    Block::Table(Table {
        caption: "Posterior.".into(),
        columns: vec![
            Column::text("Unknown"),
            Column::number("Mean", ""),
            Column::number("Standard deviation", ""),
            Column::number("2.5 %", ""),
            Column::number("Median", ""),
            Column::number("97.5 %", ""),
            Column::text("Unit"),
        ],
        rows: rows(output, row),
    })
}

/// What each unknown's draws are worth.
fn trust(output: &Output) -> Block {
    let row = |name: &String, summary: &ParameterSummary| {
        let effective = |ess: Option<f64>| Cell {
            text: ess.map_or_else(|| NONE.to_owned(), |ess| fixed(ess, 0)).into(),
            status: ess.is_none_or(|ess| ess < LEAST_EFFECTIVE).then_some(Status::Fail),
        };
        vec![
            Cell::code(name),
            rhat(summary),
            effective(summary.ess_bulk),
            effective(summary.ess_tail),
            summary.mcse_mean.map_or_else(|| NONE.to_owned(), |error| significant(error, 2)).into(),
            at_bound(summary),
        ]
    };
    Block::Table(Table {
        caption:
            "How far the draws can be trusted: R-hat below 1.01 and 400 effective draws or more are asked for, in the \
                  bulk and in the tails. The error is that of the mean, in its unit."
                .into(),
        columns: vec![
            Column::text("Unknown"),
            Column::number("R-hat", ""),
            Column::number("Effective, bulk", ""),
            Column::number("Effective, tails", ""),
            Column::number("Error of the mean", ""),
            Column::number("At a bound", ""),
        ],
        rows: rows(output, row),
    })
}

/// A row for each unknown, in their order.
fn rows(output: &Output, row: impl Fn(&String, &ParameterSummary) -> Vec<Cell>) -> Vec<Vec<Cell>> {
    shown(output).map(|(name, summary)| row(name, &summary)).collect()
}

/// The unknowns in their order, as people read them: temperatures at which a transient starts in degrees Celsius, as all
/// temperatures of a report.
fn shown(output: &Output) -> impl Iterator<Item = (&String, ParameterSummary)> {
    let zero = Shown::celsius().value(0.0);
    output.order.iter().enumerate().filter_map(move |(place, name)| {
        let mut summary = output.parameters.get(name)?.clone();
        if place as u64 >= output.model_parameters && summary.unit == "K" && name.contains(".start.") {
            let own = &mut summary;
            for value in [&mut own.mean, &mut own.q025, &mut own.q50, &mut own.q975, &mut own.map] {
                *value += zero;
            }
            summary.unit = "degC".to_owned();
        }
        Some((name, summary))
    })
}

fn rhat(own: &ParameterSummary) -> Cell {
    let text = own.rhat.map_or_else(|| NONE.to_owned(), |value| fixed(value, 3));
    Cell { text: text.into(), status: own.rhat.is_none_or(|value| value >= MOST_RHAT).then_some(Status::Fail) }
}

fn at_bound(own: &ParameterSummary) -> Cell {
    Cell { text: percent(own.at_bound, 0).into(), status: (own.at_bound > 0.05).then_some(Status::Caution) }
}

/// The logarithm of the evidence with its error, or that it is not to be trusted.
fn evidence(own: &Evidence) -> Option<String> {
    let value = own.value?;
    Some(match (own.sd, own.pareto_k, own.remedy()) {
        (_, Some(k), Some(remedy)) => {
            let k = fixed(k, 2);
            format!(
                "{}, not to be trusted (Pareto k {k}, wanted: 0.7 or less; {remedy} gives it otherwise)",
                fixed(value, 1)
            )
        }
        (Some(sd), ..) => with_error(value, sd),
        (None, ..) => fixed(value, 2),
    })
}

fn verdict(name: &str, output: &Output) -> Vec<Block> {
    let mut blocks = Vec::new();
    if output.converged {
        let text = format!(
            "The sampler converged: {} of {} agree, and every parameter has 400 effective draws or more.",
            counted(output.chains[0], "chain"),
            counted(output.chains[1], "draw")
        );
        blocks.push(Block::callout(Tone::Verdict, text));
    } else {
        let text = "The sampler did not converge. The numbers of this section are not to be relied upon.";
        blocks.push(Block::callout(Tone::Warning, text));
        let remedy =
            output.remedy().map(|remedy| Text::with_names(&format!("What mends it: {}.", remedy.in_words(name))));
        blocks.extend(remedy.map(|text| Block::callout(Tone::Next, text)));
        blocks.push(Block::List(output.objections.iter().map(|o| Text::new(o.clone())).collect()));
    }
    if let Some(p) = output.p_value.filter(|p| *p < IMPROBABLE) {
        let text = format!(
            "The tuned model does not explain the data: noise alone would leave so large a misfit with probability {}. \
             The posterior is too narrow for a model that lacks something.",
            p_value(p)
        );
        blocks.push(Block::callout(Tone::Warning, text));
    }
    let words: Vec<Text> = output.findings.iter().chain(&output.warnings).map(|word| Text::with_names(word)).collect();
    if !words.is_empty() {
        blocks.push(Block::paragraph("What to know about the parameters:"));
        blocks.push(Block::List(words));
    }
    blocks
}

/// A number to the digits that its spread leaves sense in.
fn to(value: f64, spread: f64) -> String {
    let digits = if spread > 0.0 && spread.is_finite() && value.is_finite() && value != 0.0 {
        let ratio = crate::math::functions::ln(value.abs() / spread) / core::f64::consts::LN_10;
        (ratio.max(0.0) + 2.5) as usize
    } else {
        4
    };
    significant(value, digits.clamp(2, 9))
}

fn parameters(output: &Output) -> Block {
    let row = |name: &String, summary: &ParameterSummary| {
        let ess = match (summary.ess_bulk, summary.ess_tail) {
            (Some(bulk), Some(tail)) => fixed(bulk.min(tail), 0),
            _ => NONE.to_owned(),
        };
        let is_few = |ess: Option<f64>| ess.is_none_or(|ess| ess < LEAST_EFFECTIVE);
        let few = is_few(summary.ess_bulk) || is_few(summary.ess_tail);
        let size = summary.size();
        let (times, unit) = stated(&summary.unit, size);
        let to = |value: f64, sd: f64| to(times * value, times * sd);
        let prior = match &summary.posterior_prior {
            Some(prior) => format!(
                "{} \u{00B1} {}, draws of {}",
                to(prior.mean, prior.sd),
                significant(times * prior.sd, 2),
                prior.source.replace('`', "")
            ),
            None => prior_words(&summary.prior, &Shown::parameter(&summary.unit, size)),
        };
        vec![
            Cell::code(name),
            prior.into(),
            to(summary.mean, summary.sd).into(),
            significant(times * summary.sd, 2).into(),
            format!("{} to {}", to(summary.q025, summary.sd), to(summary.q975, summary.sd)).into(),
            to(summary.map, summary.sd).into(),
            unit.into(),
            at_bound(summary),
            rhat(summary),
            Cell { text: ess.into(), status: few.then_some(Status::Fail) },
        ]
    };
    Block::Table(Table {
        caption: "Parameters, and what was inferred of the data: prior and posterior. The tuned state is the most \
                  probable point. Amber: more than 5 % of the draws lie next to a bound."
            .into(),
        columns: vec![
            Column::text("Unknown"),
            Column::text("Prior"),
            Column::number("Mean", ""),
            Column::number("Standard deviation", ""),
            Column::number("95 % interval", ""),
            Column::number("Most probable", ""),
            Column::text("Unit"),
            Column::number("At a bound", ""),
            Column::number("R-hat", ""),
            Column::number("Least effective draws", ""),
        ],
        rows: rows(output, row),
    })
}

/// Delivered, tuned, and what the noise allows, by sensor; for comparisons with this calibration.
fn achieved(job: &str, comparison: &compare::Output) -> Option<Block> {
    comparison.tuned.as_ref().filter(|tuned| tuned.job == job)?;
    let (mut rows, mut sizes) = (Vec::new(), Vec::new());
    for sensor in &comparison.sensors {
        let Some(tuned) = &sensor.tuned else { continue };
        let digits = if sensor.unit == "K" { 2 } else { 4 };
        let noise = tuned
            .noise_rmse
            .map_or_else(|| NONE.to_owned(), |[a, b]| format!("{} to {}", fixed(a, digits), fixed(b, digits)));
        for (name, before, after) in
            [("for fits", &sensor.train, &tuned.train), ("held out", &sensor.held_out, &tuned.held_out)]
        {
            if before.count > 0 {
                let status = tuned.noise_rmse.map(|[_, high]| Status::kept(after.rmse <= high));
                sizes.push(after.rmse);
                rows.push(vec![
                    Cell::code(&sensor.measurement),
                    Cell::code(&sensor.sensor),
                    name.into(),
                    fixed(before.rmse, digits).into(),
                    Cell { text: fixed(after.rmse, digits).into(), status },
                    noise.clone().into(),
                    typeset(&sensor.unit).into(),
                ]);
            }
        }
    }
    let table = Table {
        caption:
            "What tuning achieved: RMSE before tuning, at the nominal parameters, and after it, and the 95 % range that the noise of the tuned \
                  state alone would give over all readings (its correlation in time allowed for). Where the noise is \
                  inferred, it has taken up whatever the model lacks."
                .into(),
        columns: vec![
            Column::text("Measurement"),
            Column::text("Sensor"),
            Column::text("Readings"),
            Column::number("Before", ""),
            Column::number("Tuned", ""),
            Column::number("Noise alone", ""),
            Column::text("Unit"),
        ],
        rows,
    };
    Some(Block::Table(table.cut(&sizes)))
}

fn coverage(output: &Output) -> Block {
    let share = |inside: u64, count: u64| {
        if count == 0 { NONE.to_owned() } else { percent(inside as f64 / count as f64, 0) }
    };
    let rows = output
        .predictive
        .iter()
        .map(|check| {
            let (train, held_out) = (check.train, check.held_out);
            let all = train.count + held_out.count;
            let bins: Vec<String> = check.pit.iter().map(u64::to_string).collect();
            vec![
                Cell::code(&check.measurement),
                Cell::code(&check.sensor),
                train.count.to_string().into(),
                share(train.inside, train.count).into(),
                held_out.count.to_string().into(),
                share(held_out.inside, held_out.count).into(),
                share(train.inside_prior + held_out.inside_prior, all).into(),
                bins.join(" ").into(),
            ]
        })
        .collect();
    Block::Table(Table {
        caption: "Predictive checks: share of readings inside the 95 % band of model and noise, after and before the \
                  calibration, and how the readings for the fit fall on the tenths of their predicted distribution (even \
                  is good)."
            .into(),
        columns: vec![
            Column::text("Measurement"),
            Column::text("Sensor"),
            Column::number("For fits", ""),
            Column::number("Inside", ""),
            Column::number("Held out", ""),
            Column::number("Inside", ""),
            Column::number("Inside, prior", ""),
            Column::text("Tenths"),
        ],
        rows,
    })
}

/// Worst phases shown; the others are folded away with them.
const WORST_PHASES: usize = 5;

/// What the rest of the data said of each steady phase.
fn scores(output: &Output) -> Vec<Block> {
    let mut words = String::new();
    if let Some(left_out) = &output.leave_one_phase_out {
        let count = output.phases.iter().filter(|phase| !phase.held_out).count();
        words.push_str(&format!(
            "Log predictive density of {}, each left out in turn: {} \u{00B1} {}",
            counted(count, "fitted phase"),
            fixed(left_out.expected_log_density, 1),
            fixed(left_out.standard_error, 1)
        ));
        if left_out.unreliable > 0 {
            words.push_str(&format!(" ({} of them not reliable)", left_out.unreliable));
        }
        words.push_str(&format!("; effective number of parameters {}. ", fixed(left_out.effective_parameters, 1)));
    }
    if let Some(held_out) = &output.held_out {
        let error = held_out.standard_error.map_or(String::new(), |error| format!(" \u{00B1} {}", fixed(error, 1)));
        words.push_str(&format!(
            "Of {} held out ({}): {}{error}. ",
            counted(held_out.phases, "phase"),
            counted(held_out.readings, "reading"),
            fixed(held_out.log_density, 1)
        ));
    }
    if words.is_empty() {
        return Vec::new();
    }
    words.push_str("Larger is better; only models of the same readings are to be compared.");
    let mut worst: Vec<_> = output.phases.iter().filter(|phase| phase.readings > 0).collect();
    let of_a_reading = |phase: &PhaseScore| phase.log_density / phase.readings as f64;
    sort_by(&mut worst, |a, b| of_a_reading(a).total_cmp(&of_a_reading(b)));
    let row = |phase: &&PhaseScore| {
        let kind = if phase.held_out { "held out" } else { "for fits" };
        let kind = if phase.reliable { kind.to_owned() } else { format!("{kind}, not reliable") };
        vec![
            Cell::code(&phase.measurement),
            Cell::code(&phase.phase),
            kind.into(),
            phase.readings.to_string().into(),
            fixed(phase.log_density, 2).into(),
            fixed(of_a_reading(phase), 2).into(),
        ]
    };
    let table = |caption: &str, rows: &[&PhaseScore]| {
        Block::Table(Table {
            caption: caption.into(),
            columns: vec![
                Column::text("Measurement"),
                Column::text("Phase"),
                Column::text("Readings"),
                Column::number("Number", ""),
                Column::number("Log density", ""),
                Column::number("Of a reading", ""),
            ],
            rows: rows.iter().map(row).collect(),
        })
    };
    let few = worst.len().min(WORST_PHASES);
    let mut blocks = vec![
        Block::paragraph(words),
        table("The phases that were predicted worst, by log density of a reading.", &worst[..few]),
    ];
    if worst.len() > few {
        let rest = table("The other phases, from worse to better.", &worst[few..]);
        blocks.push(Block::Details("Scores of the other phases".into(), vec![rest]));
    }
    blocks
}

fn method(output: &Output) -> String {
    let best = &output.most_probable;
    let mut text = format!(
        "Sampler {}, {} of {} of the fit ended at the most probable point. ",
        output.sampler,
        best.starts[1],
        counted(best.starts[0], "start")
    );
    if let Some(words) = evidence(&output.log_evidence) {
        text.push_str(&format!("Log evidence by {}: {words}. ", output.log_evidence.method));
    }
    if let Some(p) = output.p_value {
        text.push_str(&format!("Posterior predictive p-value {}. ", p_value(p)));
    }
    if let Some(left_out) = &output.leave_one_out {
        text.push_str(&format!(
            "Log predictive density of the readings, each left out in turn, {} \u{00B1} {}",
            fixed(left_out.expected_log_density, 1),
            fixed(left_out.standard_error, 1)
        ));
        if left_out.unreliable > 0 {
            text.push_str(&format!(" ({} unreliable)", counted(left_out.unreliable, "reading")));
        }
        text.push_str(". ");
    }
    text.push_str(&format!(
        "{} likelihoods, {} gradients, {} of them failed.",
        as_given(output.spent.likelihoods as f64),
        as_given(output.spent.gradients as f64),
        output.spent.rejected
    ));
    text
}
