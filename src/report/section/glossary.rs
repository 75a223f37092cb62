//! Terms of the report, as they are used here.

use crate::report::page::{Block, Section, Text};
use crate::report::view::PassReport;

use super::Entry;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// Terms of every report with results.
const ALWAYS: &[(&str, &str)] = &[
    ("pass", "a step of the validation: a model with its priors, what it is held against, and the jobs that run on it"),
    ("as delivered", "the model at the nominal values of its parameters, before it is fitted to this test"),
    ("tuned", "the model at the most probable values of its parameters, given the readings for fitting"),
    ("held out", "readings that a fit does not see, by which it is judged"),
    ("RMSE", "root mean square of measured minus predicted"),
    ("prior, posterior", "what is known of a parameter before and after the readings, as a distribution"),
    ("95 % interval", "from the quantile of 2.5 % to that of 97.5 %"),
    ("criteria", "what measured minus predicted must keep for the model to pass its test"),
    ("effect", "physics that a model may lack, with an equation, a place and a size"),
    ("key", "SHA-256 of everything that decides a job's result"),
    ("manifest", "manifest.json: every input, job and file of the report with its hash"),
];

/// Terms of results of one kind.
const OF_KINDS: &[(&str, &str, &str)] = &[
    (
        "calibrate",
        "split R-hat",
        "how far chains of a sampler agree with one another, after Vehtari et al. (2021); near 1 they do",
    ),
    ("calibrate", "effective sample size", "how many independent draws a sampler's draws are worth"),
    (
        "calibrate",
        "log evidence",
        "natural logarithm of the probability density of the readings under the model and its priors",
    ),
    (
        "calibrate",
        "reduced chi-square",
        "sum of squares of the whitened residuals over readings less unknowns; near 1 the noise explains them",
    ),
    ("diagnose", "Bayes factor", "how many times more probable the readings are under one model than under another"),
    (
        "sensitivity",
        "main effect, total effect",
        "shares of a variance that go where a parameter is known, alone or with all that it acts together with",
    ),
    (
        "conventional",
        "margin by rule",
        "kelvins or a share of the heat added to a worst case, as a standard prescribes",
    ),
    ("discrepancy", "discrepancy", "what a calibrated model leaves unexplained, as a law with an uncertainty"),
    ("design", "expected information", "by how much a test is expected to narrow the parameters, in nats"),
];

/// The section; not without results.
fn build(report: &PassReport<'_>) -> Option<Section> {
    if report.results.is_empty() {
        return None;
    }
    let has = |kind: &str| report.results.iter().any(|job| job.output.kind() == kind);
    let of_kinds = OF_KINDS.iter().filter(|(kind, ..)| has(kind)).map(|(_, term, meaning)| (*term, *meaning));
    let entries = ALWAYS.iter().copied().chain(of_kinds);
    let entries = entries.map(|(term, meaning)| (Text::new(term), Text::new(format!("{meaning}."))));
    Some(Section { id: "glossary", title: "Glossary".into(), blocks: vec![Block::Definitions(entries.collect())] })
}
