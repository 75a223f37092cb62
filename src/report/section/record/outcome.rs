//! Of the record: what holds of the requirements, what is known of the parameters, what the model leaves unexplained.

use crate::job::discrepancy;
use crate::report::known;
use crate::report::number::{self, significant};
use crate::report::page::{Block, Cell, Column, Table, Text};
use crate::report::section::compliance::{counts, judged};
use crate::report::view::PassReport;

/// Requirements in a sentence; the compliance matrix has them one by one.
pub(super) fn requirements(report: &PassReport<'_>) -> Vec<Block> {
    let rows = judged(report);
    if rows.is_empty() {
        return Vec::new();
    }
    vec![
        Block::Heading("Requirements and remaining margin".into()),
        Block::paragraph(format!(
            "{} Each with its margin stands in the section Requirement compliance.",
            counts(&rows)
        )),
    ]
}

/// The parameters: prior, source, posterior.
pub(super) fn parameters(report: &PassReport<'_>) -> Vec<Block> {
    let rows = known::parameters(report).into_iter().flat_map(|own| known::stated(&[&own])).map(|own| {
        vec![
            Cell::code(&own.name),
            own.unit.clone().into(),
            own.nominal_text().into(),
            own.prior.clone().into(),
            own.posterior_text().into(),
            own.source.into(),
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
