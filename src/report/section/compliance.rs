//! The compliance matrix: every requirement with its statement, what is predicted of it, the state of the model that this
//! rests on, and what may be claimed. A prediction after calibration goes before a propagation of the priors.

use serde::{Deserialize, Serialize};

use crate::job::propagate::{Case, Distributed, Met};
use crate::job::{predict, propagate};
use crate::math::sort::sort_by_key;
use crate::math::special::normal_quantile;
use crate::report::number::{self, NONE, Shown, with_unit};
use crate::report::page::{Block, Cell, Column, Section, Status, Table, Text};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

use super::Entry;
use super::problem::limits;
use super::propagation::{nominal_cases, probability_text, quantile};
use super::validation::{Rests, claim, state};

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// Share of the distribution that lies below the upper end of the stated interval, and above its lower one.
const SHARE: f64 = 0.99;
/// Hexadecimal digits of a job's key that are shown; whole ones are under Provenance.
const DIGITS: usize = 16;
/// What is said of a requirement that no job judges.
const NOT_JUDGED: &str =
    "no claim: no job of this pass judges it; a `predict` job would, or `propagate` where nothing was calibrated";

/// A requirement in an environment, and what holds of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The requirement.
    pub requirement: String,
    /// What it says.
    pub statement: String,
    /// The quantity.
    pub quantity: String,
    /// Its limit.
    pub limit: String,
    /// The environment; empty where nothing judges it.
    pub environment: String,
    /// Median of the quantity, with its quantiles of 1 % and 99 %.
    pub predicted: String,
    /// Required probability.
    pub required: f64,
    /// Probability that it is met; `None` where nothing judges it.
    pub probability: Option<f64>,
    /// The same with its interval.
    pub probability_text: String,
    /// The same with the priors that the calibration began with.
    pub before: String,
    /// What remains between the limit and the quantile towards it that has the required probability.
    pub margin: String,
    /// State of the model on which it rests.
    pub state: String,
    /// What may be claimed.
    pub verdict: String,
    /// How it stands: `ok`, `caution` or `fail`.
    pub status: Status,
    /// The job; empty where none judges it.
    pub job: String,
    /// Its key.
    pub key: String,
}

/// The section on compliance; not without requirements.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let rows = judged(report);
    if rows.is_empty() {
        return None;
    }
    let blocks = vec![
        Block::Paragraph(Text::new(format!("Requirements: {}", counts(&rows))).plain(
            " Met: the whole 95 % interval of the probability lies at or above what is required, and the model keeps the \
             criteria of its test where it was tested. Without that a high probability is no claim.",
        )),
        Block::Table(table(&rows)),
    ];
    Some(Section { id: "compliance", title: "Requirement compliance".into(), blocks })
}

/// How many requirements are met, not met, and without a claim.
pub fn counts<'j>(rows: impl IntoIterator<Item = &'j Judged>) -> String {
    let mut numbers = [(0_usize, "met"), (0, "not met"), (0, "without a claim")];
    for row in rows {
        let place = match row.status {
            Status::Ok => &mut numbers[0],
            Status::Fail => &mut numbers[1],
            Status::Caution => &mut numbers[2],
        };
        place.0 += 1;
    }
    let said = numbers.iter().filter(|(count, _)| *count > 0).map(|(count, word)| format!("{count} {word}"));
    format!("{}.", said.collect::<Vec<_>>().join(", "))
}

fn table(rows: &[Judged]) -> Table {
    let short = |key: &str| key.chars().take(DIGITS).collect::<String>();
    let cells = |row: &Judged| {
        let required = format!("{}, with P \u{2265} {}", row.limit, number::probability(row.required));
        let probability = match row.before.as_str() {
            NONE => row.probability_text.clone(),
            before => format!("{}; before {before}", row.probability_text),
        };
        vec![
            Cell::from(Text::default().code(&row.requirement).plain(format!(": {}", row.statement))),
            required.into(),
            if row.environment.is_empty() { NONE.into() } else { Cell::code(&row.environment) },
            row.predicted.clone().into(),
            probability.into(),
            row.margin.clone().into(),
            row.state.clone().into(),
            Cell { text: Text::with_names(&row.verdict), status: Some(row.status) },
            match row.job.as_str() {
                "" => NONE.into(),
                job => Cell::from(Text::default().code(job).plain(" ").code(short(&row.key))),
            },
        ]
    };
    Table {
        caption: format!(
            "Every requirement of the pass at the nominal design. Predicted: median, quantiles of 1 % and 99 %. Before: with the \
             priors that the calibration began with. Margin: between the limit and the quantile towards it at the required probability. Source: the \
             job and the first {DIGITS} digits of its key."
        )
        .into(),
        columns: vec![
            Column::text("Requirement"),
            Column::text("Limit"),
            Column::text("Environment"),
            Column::text("Predicted"),
            Column::text("P(met)"),
            Column::text("Margin"),
            Column::text("Rests on the model"),
            Column::text("Verdict"),
            Column::text("Source"),
        ],
        rows: rows.iter().map(cells).collect(),
    }
}

/// Every requirement with what holds of it; a row an environment and job.
pub fn judged(report: &PassReport<'_>) -> Vec<Judged> {
    let mut rows: Vec<Judged> = Vec::new();
    let key = |name: &str| report.results.iter().find(|job| job.name == name).map_or("", |job| job.key.as_str());
    for (name, output) in report.outputs::<predict::Kind>() {
        for case in nominal_cases(&output.posterior) {
            let same = |own: &&Case| own.environment == case.environment && own.design_value == case.design_value;
            let before = output.prior.cases.iter().find(same);
            for met in single(case) {
                let prior =
                    before.and_then(|own| own.requirements.iter().find(|own| own.requirement == met.requirement));
                let mut row = row(report, case, met, Rests::OnTuned, output.converged);
                row.before = prior.map_or_else(|| NONE.to_owned(), |own| probability_text(&own.probability));
                rows.push(Judged { job: name.to_owned(), key: key(name).to_owned(), ..row });
            }
        }
    }
    let mut of_priors = Vec::new();
    for (name, output) in report.outputs::<propagate::Kind>() {
        for case in nominal_cases(output) {
            for met in single(case) {
                let is_predicted =
                    rows.iter().any(|row| row.requirement == met.requirement && row.environment == case.environment);
                if !is_predicted {
                    let row = row(report, case, met, Rests::OnDelivered, output.converged.unwrap_or(true));
                    of_priors.push(Judged { job: name.to_owned(), key: key(name).to_owned(), ..row });
                }
            }
        }
    }
    rows.extend(of_priors);
    for requirement in &report.requirements {
        if rows.iter().any(|row| row.requirement == requirement.name) {
            continue;
        }
        let shown = report.requirement_shown(requirement);
        let quantity = report.model.quantities.get(requirement.quantity).map_or("", |own| own.name.as_str());
        rows.push(Judged {
            limit: limits(&shown, requirement.above, requirement.below),
            statement: statement(report, &requirement.name, quantity),
            requirement: requirement.name.clone(),
            quantity: quantity.to_owned(),
            environment: String::new(),
            predicted: NONE.to_owned(),
            required: requirement.probability,
            probability: None,
            probability_text: NONE.to_owned(),
            before: NONE.to_owned(),
            margin: NONE.to_owned(),
            state: NONE.to_owned(),
            verdict: NOT_JUDGED.to_owned(),
            status: Status::Caution,
            job: String::new(),
            key: String::new(),
        });
    }
    // In the order in which the pass states them.
    let place = |row: &Judged| report.requirements.iter().position(|own| own.name == row.requirement);
    sort_by_key(&mut rows, |row| place(row).unwrap_or(usize::MAX));
    rows
}

/// Requirements of a case by themselves.
fn single(case: &Case) -> impl Iterator<Item = &Met> {
    case.requirements.iter().filter(|met| met.requirement != ALL)
}

fn row(report: &PassReport<'_>, case: &Case, met: &Met, rests: Rests, converged: bool) -> Judged {
    let shown = report.quantity_shown(&met.quantity, &met.unit);
    let quantity = case.quantities.iter().find(|own| own.name == met.quantity);
    let left = quantity.and_then(|own| {
        let hot = met.below.map(|limit| limit - between(own, met.required));
        let cold = met.above.map(|limit| between(own, 1.0 - met.required) - limit);
        hot.into_iter().chain(cold).reduce(f64::min)
    });
    let predicted = quantity.map(|own| {
        let [low, middle, high] = [1.0 - SHARE, 0.5, SHARE].map(|share| shown.number(quantile(own, share)));
        with_unit(&format!("{middle} ({low} to {high})"), &shown.unit)
    });
    let (words, status) = claim(report, rests, met);
    let mut state = state(report, rests);
    if !converged {
        state.push_str("; the sampler did not converge");
    }
    Judged {
        requirement: met.requirement.clone(),
        statement: statement(report, &met.requirement, &met.quantity),
        quantity: met.quantity.clone(),
        limit: limits(&shown, met.above, met.below),
        environment: case.environment.clone(),
        predicted: predicted.unwrap_or_else(|| NONE.to_owned()),
        required: met.required,
        probability: Some(met.probability.value),
        probability_text: probability_text(&met.probability),
        before: NONE.to_owned(),
        margin: left.map_or_else(|| NONE.to_owned(), |left| margin(&shown, left)),
        state,
        verdict: words.to_owned(),
        status,
        job: String::new(),
        key: String::new(),
    }
}

/// A quantile between those that a result has, along the standard normal deviate; the outermost one beyond them.
fn between(own: &Distributed, probability: f64) -> f64 {
    let after = own.quantiles.partition_point(|known| known.probability < probability);
    let (Some(above), before) = (own.quantiles.get(after), after.checked_sub(1).map(|before| &own.quantiles[before]))
    else {
        return own.quantiles.last().map_or(f64::NAN, |last| last.value);
    };
    let Some(below) = before else { return above.value };
    let [low, at, high] = [below.probability, probability, above.probability].map(normal_quantile);
    below.value + (above.value - below.value) * (at - low) / (high - low)
}

/// What remains, with its sign.
fn margin(shown: &Shown, left: f64) -> String {
    format!("{}{}", if left > 0.0 { "+" } else { "" }, shown.difference().text(left))
}

/// What a requirement says; where the pass leaves that out, of what it speaks.
fn statement(report: &PassReport<'_>, requirement: &str, quantity: &str) -> String {
    let written = report.statements.iter().find(|own| own.requirement == requirement);
    let Some(own) = written.filter(|own| !own.text.is_empty()) else {
        return format!("The limit of {quantity} is kept");
    };
    if own.source.is_empty() { own.text.clone() } else { format!("{} ({})", own.text, own.source) }
}
