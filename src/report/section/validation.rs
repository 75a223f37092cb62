//! Whether what is claimed of requirements rests on a model that keeps the criteria of its own test.

use crate::document::p_value;
use crate::job::propagate::Met;
use crate::job::{calibrate, compare, predict};
use crate::report::ladder::{self, Standing};
use crate::report::number::Shown;
use crate::report::page::{Cell, Status, Text};
use crate::report::view::PassReport;

use super::propagation;

/// Which state of the model a claim rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rests {
    /// As delivered, with the priors of its parameters.
    OnDelivered,
    /// On a calibration.
    OnTuned,
}

/// The state of the model on which claims rest, and the comparison in which it breaks criteria; `None` where it keeps
/// them all, or where nothing was measured.
fn broken<'r>(report: &'r PassReport<'_>, rests: Rests) -> Option<(&'r compare::Output, Standing)> {
    report.outputs::<compare::Kind>().find_map(|(_, output)| {
        let mut states = ladder::standings(output);
        let tuned = if states.len() > 1 && rests == Rests::OnTuned { states.pop() } else { None };
        let state = tuned.or_else(|| states.into_iter().next())?;
        state.fails().then_some((output, state))
    })
}

/// The state of the model on which claims rest, and what its test says of it: validated is a state that keeps all criteria
/// on readings held out from its fit.
pub(super) fn state(report: &PassReport<'_>, rests: Rests) -> String {
    let which = match rests {
        Rests::OnDelivered => report.untuned(),
        Rests::OnTuned => "tuned",
    };
    let judged = report.outputs::<compare::Kind>().filter_map(|(_, output)| {
        let mut states = ladder::standings(output);
        let tuned = if states.len() > 1 && rests == Rests::OnTuned { states.pop() } else { None };
        tuned.or_else(|| states.into_iter().next()).filter(|state| state.kept.is_some())
    });
    let judged: Vec<Standing> = judged.collect();
    if judged.is_empty() {
        format!("{which}; no test of it in this pass")
    } else if judged.iter().any(Standing::fails) {
        format!("{which}; it fails its test")
    } else if judged.iter().any(|state| state.held_out.is_some()) {
        format!("{which} and validated on readings held out")
    } else {
        format!("{which}; it keeps the criteria on the readings that it was held against")
    }
}

/// Whether chains behind a tuned state or a prediction of the pass did not converge.
pub(super) fn is_unconverged(report: &PassReport<'_>) -> bool {
    report.outputs::<calibrate::Kind>().any(|(_, output)| !output.converged)
        || report.outputs::<predict::Kind>().any(|(_, output)| !output.converged)
}

/// Probability below which noise alone is no explanation of what a tuned model leaves.
pub(super) const IMPROBABLE: f64 = 0.005;

/// Probability that noise alone leaves so large a misfit, where a calibration of the pass leaves one that is improbable and a
/// prediction adds no discrepancy for it.
fn misfit(report: &PassReport<'_>) -> Option<f64> {
    let is_bare =
        |(_, output): (&str, &predict::Output)| output.validated.is_none() && output.posterior.discrepancy.is_empty();
    if !report.outputs::<predict::Kind>().any(is_bare) {
        return None;
    }
    let tails = report.outputs::<calibrate::Kind>().filter_map(|(_, output)| output.p_value);
    tails.filter(|p| *p < IMPROBABLE).reduce(f64::min)
}

/// How a requirement stands, in words and in colour: none is met by a model that fails its test or does not explain its data, or
/// by draws of chains that did not converge.
pub(super) fn claim(report: &PassReport<'_>, rests: Rests, met: &Met) -> (&'static str, Status) {
    match propagation::standing(met) {
        Status::Ok if rests == Rests::OnTuned && is_unconverged(report) => {
            ("no claim: the posterior is not to be trusted", Status::Caution)
        }
        Status::Ok if broken(report, rests).is_some() => ("no claim: the model fails its test", Status::Caution),
        Status::Ok if rests == Rests::OnTuned && misfit(report).is_some() => {
            ("no claim: the tuned model does not explain its data", Status::Caution)
        }
        standing => (propagation::outcome(met), standing),
    }
}

/// The same as a cell.
pub(super) fn claim_cell(report: &PassReport<'_>, rests: Rests, met: &Met) -> Cell {
    let (words, status) = claim(report, rests, met);
    Cell::marked(words, status)
}

/// Why no requirement may be called met, where one would be.
pub(super) fn objection<'m>(
    report: &PassReport<'_>,
    rests: Rests,
    mut claims: impl Iterator<Item = &'m Met>,
) -> Option<Text> {
    let met = claims.find(|met| propagation::standing(met) == Status::Ok)?;
    let heading = Text::default().strong("No requirement is called met here.");
    let Some((output, state)) = broken(report, rests) else {
        let p = misfit(report).filter(|_| rests == Rests::OnTuned)?;
        return Some(heading.plain(format!(
            " The tuned model does not explain the data to which it was fitted: noise alone would leave so large a misfit with \
             probability {}. Its posterior is too narrow for a model that lacks something.",
            p_value(p)
        )));
    };
    let [kept, of] = state.kept?;
    let which = if rests == Rests::OnTuned && output.tuned.is_some() { "tuned" } else { report.untuned() };
    let mut text = heading.plain(format!(
        " The probability is that of the model, and the model {which} keeps {kept} of {of} criteria of its test ({}).",
        output.criteria.title
    ));
    let unit = ladder::unit(output);
    if let Some(worst) = state.worst.filter(|_| unit == "K") {
        // Measured above predicted: the model is too cold, which hides what breaks an upper limit.
        let unsafe_limit = match (met.below, met.above) {
            (Some(_), None) if worst.mean > 0.0 => Some("at most"),
            (None, Some(_)) if worst.mean < 0.0 => Some("at least"),
            _ => None,
        };
        let side = if worst.mean > 0.0 { "above" } else { "below" };
        text = text.plain(" ").code(worst.name).plain(format!(
            " reads {} {side} the prediction on average, {} at the worst",
            Shown::si(unit).text(worst.mean.abs()),
            Shown::si(unit).text(worst.largest)
        ));
        text = text.plain(match unsafe_limit {
            Some(limit) => format!(": the unsafe side of a limit of the kind \u{201C}{limit}\u{201D}."),
            None => ".".to_owned(),
        });
    }
    Some(text)
}
