//! Refuses to fit readings that already stand behind a prior.

use std::collections::BTreeSet;

use crate::document::{Diagnostic, code, suggest};
use crate::inference::likelihood::rows::used_rows;
use crate::measurement::{Measurement, Rows};
use crate::study::job::{Entry, Forms, Inference, NamedJob};
use crate::study::resolved::PosteriorReference;

use super::scope::Scope;

/// Rows named in a message.
const NAMED: usize = 12;

/// Reports every calibration and diagnosis of the pass that fits readings which stand behind its priors.
pub(super) fn check(
    scope: &mut Scope,
    jobs: &[NamedJob],
    forms: &Forms,
    measurements: &[Measurement],
    posterior_priors: &[PosteriorReference],
) {
    if posterior_priors.is_empty() {
        return;
    }
    for entry in forms.entries() {
        let named = jobs.iter().find(|job| job.name == entry.name);
        let Some(Inference { verb, data, parameters }) = named.and_then(|job| job.spec.inference()) else { continue };
        // A measurement with an error of its own is not among them.
        let data: Vec<&Measurement> = data.iter().filter_map(|&index| measurements.get(index)).collect();
        let used = |reference: &&PosteriorReference| reference.draws.parameters.iter().any(|p| parameters.contains(p));
        job(scope, entry, verb, &data, posterior_priors.iter().filter(used));
    }
}

fn job<'h>(
    scope: &mut Scope,
    entry: &Entry,
    verb: &str,
    data: &[&Measurement],
    posterior_priors: impl Iterator<Item = &'h PosteriorReference>,
) {
    for posterior_prior in posterior_priors {
        for behind in &posterior_prior.behind {
            let reading_hashes: BTreeSet<&str> =
                behind.rows.iter().flat_map(|row| &row.readings).map(|(_, hash)| hash.as_str()).collect();
            for measurement in data {
                let twice: Vec<String> = used_rows(measurement)
                    .into_iter()
                    .filter(|row| row.readings.iter().any(|(_, hash)| reading_hashes.contains(hash.as_str())))
                    .map(|row| row.label)
                    .collect();
                if twice.is_empty() {
                    continue;
                }
                let steady = matches!(measurement.rows, Rows::Steady(_));
                let (job, file) = (&behind.calibration.job, &behind.calibration.file);
                let parameters = suggest::listed(posterior_prior.draws.names.iter().map(String::as_str), NAMED);
                let message = format!(
                    "`{}` {verb} on readings that stand behind its prior: `{job}` of `{file}` was fitted to {} of `{}`",
                    entry.name,
                    rows(&twice, steady),
                    measurement.name
                );
                let held_out = if steady { "\"phases\": [...]" } else { "\"intervals\": [...]" };
                let help = format!(
                    "hold those rows out here (\"held_out\": {{{held_out}}}), or give {parameters} the prior that \
                     `{job}` of `{file}` began with and calibrate on all data at once"
                );
                scope.diagnostics.push(
                    Diagnostic::error(&code::DATA_USED_TWICE, &entry.name_place, message)
                        .expected("other rows than those behind the prior")
                        .related(&posterior_prior.place, format!("the posterior of {}", posterior_prior.draws.source))
                        .help(help),
                );
            }
        }
    }
}

/// Rows in words.
fn rows(labels: &[String], steady: bool) -> String {
    let what = match (steady, labels.len()) {
        (true, 1) => "phase",
        (true, _) => "phases",
        (false, 1) => "the row at",
        (false, _) => "the rows at",
    };
    let list = if labels.len() <= NAMED {
        labels.join(", ")
    } else {
        let (first, last) = (labels[..NAMED - 2].join(", "), &labels[labels.len() - 1]);
        format!("{first} ... {last} ({} rows)", labels.len())
    };
    format!("{what} {list}")
}
