//! Of the record: what holds of the requirements, what is known of the parameters, what the model leaves unexplained.

use crate::job::{calibrate, discrepancy, predict};
use crate::report::number::{self, NONE, Shown, as_given, significant};
use crate::report::page::{Block, Cell, Column, Status, Table, Text};
use crate::report::section::problem::{limits, prior_words};
use crate::report::section::propagation::{nominal_cases, probability_text, quantile, standing};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

/// Share of the distribution that lies on the safe side of what the remaining margin is taken from.
const SHARE: f64 = 0.99;

/// Requirements with their probabilities before and after, and the margin that remains.
pub(super) fn requirements(report: &PassReport<'_>) -> Vec<Block> {
    let mut rows = Vec::new();
    for (name, output) in report.outputs::<predict::Kind>() {
        for case in nominal_cases(&output.posterior) {
            let before = output
                .prior
                .cases
                .iter()
                .find(|own| own.environment == case.environment && own.design_value == case.design_value);
            for met in case.requirements.iter().filter(|met| met.requirement != ALL) {
                let shown = report.quantity_shown(&met.quantity, &met.unit);
                let prior =
                    before.and_then(|own| own.requirements.iter().find(|own| own.requirement == met.requirement));
                let quantity = case.quantities.iter().find(|own| own.name == met.quantity);
                let left = quantity.and_then(|own| {
                    let hot = met.below.map(|limit| limit - quantile(own, SHARE));
                    let cold = met.above.map(|limit| quantile(own, 1.0 - SHARE) - limit);
                    hot.into_iter().chain(cold).reduce(f64::min)
                });
                let status = standing(met);
                let word = match status {
                    Status::Ok => "met",
                    Status::Caution => "undecided",
                    Status::Fail => "NOT met",
                };
                rows.push(vec![
                    Cell::code(&met.requirement),
                    limits(&shown, met.above, met.below).into(),
                    Cell::code(&case.environment),
                    number::probability(met.required).into(),
                    prior.map_or_else(|| NONE.to_owned(), |own| probability_text(&own.probability)).into(),
                    probability_text(&met.probability).into(),
                    Cell::marked(word, status),
                    left.map_or_else(
                        || NONE.to_owned(),
                        |left| {
                            let sign = if left > 0.0 { "+" } else { "" };
                            format!("{sign}{}", shown.difference().text(left))
                        },
                    )
                    .into(),
                    Cell::code(name),
                ]);
            }
        }
    }
    if rows.is_empty() {
        return Vec::new();
    }
    vec![
        Block::Heading("Requirements and remaining margin".into()),
        Block::Table(Table {
            caption: "What was asked of the nominal design and what holds: probabilities with the priors and with all that was \
                      learnt, and the margin that remains between the limit and the 99 % quantile towards it."
                .into(),
            columns: vec![
                Column::text("Requirement"),
                Column::text("Limit"),
                Column::text("Environment"),
                Column::number("Required", ""),
                Column::number("Before", ""),
                Column::number("After", ""),
                Column::text("Outcome"),
                Column::number("Remaining margin", ""),
                Column::text("Job"),
            ],
            rows,
        }),
    ]
}

/// The parameters: prior, source, posterior.
pub(super) fn parameters(report: &PassReport<'_>) -> Vec<Block> {
    let calibrations: Vec<(&str, &calibrate::Output)> = report.outputs::<calibrate::Kind>().collect();
    let rows = report.model.parameters.iter().map(|parameter| {
        let shown = Shown::written(&parameter.unit);
        let prior = report.priors.iter().find(|prior| prior.0 == parameter.name);
        let draws = report.posterior_priors.iter().find(|(name, _)| *name == parameter.name);
        let prior = match draws {
            Some((_, source)) => format!("draws of {}", source.replace('`', "")),
            None => prior.map_or_else(|| "fixed".to_owned(), |prior| prior_words(&prior.1, &shown)),
        };
        let found =
            calibrations.iter().find_map(|(name, output)| Some((name, output.parameters.get(&parameter.name)?)));
        // A calibration states its numbers in the parameter's unit.
        let posterior = found.map(|(name, own)| {
            let digits = |value: f64| significant(value, 4);
            format!(
                "{} \u{B1} {} ({} to {}; {name})",
                digits(own.mean),
                significant(own.sd, 2),
                digits(own.q025),
                digits(own.q975)
            )
        });
        vec![
            Cell::code(&parameter.name),
            shown.unit.clone().into(),
            as_given(shown.value(parameter.nominal)).into(),
            prior.into(),
            posterior.unwrap_or_else(|| NONE.to_owned()).into(),
            parameter.source.clone().into(),
        ]
    });
    vec![
        Block::Heading("Parameters".into()),
        Block::Table(Table {
            caption: "Parameters of the simulation model: prior, posterior (mean, standard deviation, 95 % interval; the calibration) \
                      where one was inferred, source."
                .into(),
            columns: vec![
                Column::text("Parameter"),
                Column::text("Unit"),
                Column::number("Nominal", ""),
                Column::text("Prior"),
                Column::text("Posterior"),
                Column::text("Source"),
            ],
            rows: rows.collect(),
        }),
    ]
}

/// What the calibrated model leaves unexplained, sensor by sensor.
pub(super) fn discrepancies(report: &PassReport<'_>) -> Vec<Block> {
    let mut rows = Vec::new();
    let mut findings = Vec::new();
    for (_, output) in report.outputs::<discrepancy::Kind>() {
        for own in &output.sensors {
            let behind: Vec<f64> = own.residuals.iter().map(|residual| residual.residual).collect();
            let largest = behind.iter().fold(0.0, |most: f64, own| most.max(own.abs()));
            rows.push(vec![
                Cell::code(&own.sensor),
                own.law.words().into(),
                own.because.clone().into(),
                number::with_unit(&significant(largest, 3), &own.unit).into(),
            ]);
        }
        findings.extend(output.findings.iter().map(|finding| Text::with_names(finding)));
    }
    if rows.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![
        Block::Heading("Discrepancies".into()),
        Block::Table(Table {
            caption: "What the calibrated model leaves unexplained: the law of each sensor, and its largest residual."
                .into(),
            columns: vec![
                Column::text("Sensor"),
                Column::text("Law"),
                Column::text("Because"),
                Column::number("Largest residual", ""),
            ],
            rows,
        }),
    ];
    if !findings.is_empty() {
        blocks.push(Block::List(findings));
    }
    blocks
}
