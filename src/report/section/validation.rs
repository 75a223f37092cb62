//! Whether what is claimed of requirements rests on a model that keeps the criteria of its own test.

use crate::document::{p_stated, p_value};
use crate::job::propagate::Met;
use crate::job::{calibrate, compare, predict};
use crate::report::history::PassErrors;
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

/// A state of the model on which claims rest, against the criteria of its test.
struct Judged<'r> {
    state: Standing,
    /// The criteria in words, with the name that the state has; of a comparison of this pass.
    here: Option<(&'r compare::Output, &'static str)>,
    /// The other pass in which it was tuned and tested.
    pass: Option<&'r str>,
}

/// The pass before this one whose calibration a prediction carries.
fn carried<'r>(report: &'r PassReport<'_>, output: &predict::Output) -> Option<&'r PassErrors> {
    let sources = || output.posterior.posterior_priors.iter().map(|own| own.source.as_str());
    let passes = || report.history.iter().flat_map(|history| &history.passes);
    let of = |source: &str| passes().find(|pass| source.ends_with(&format!(" of `{}`", pass.pass)));
    // Draws of a calibration of this pass are named without a pass.
    if sources().any(|source| !source.contains("` of `")) {
        return None;
    }
    sources().find_map(of).filter(|pass| pass.pass != report.pass_file)
}

/// The passes whose calibrations the predictions of this one carry; none where one carries a calibration of its own.
fn behind<'r>(report: &'r PassReport<'_>) -> Vec<&'r PassErrors> {
    report
        .outputs::<predict::Kind>()
        .map(|(_, output)| carried(report, output))
        .collect::<Option<_>>()
        .unwrap_or_default()
}

/// The pass in which the model of the predictions was tuned, where this pass does not tune it itself: untuned states of this
/// pass are then none that anybody uses.
pub(super) fn tuned_in<'r>(report: &'r PassReport<'_>) -> Option<&'r PassErrors> {
    let is_tuned_here = report.outputs::<compare::Kind>().any(|(_, output)| output.tuned.is_some());
    behind(report).into_iter().next().filter(|_| !is_tuned_here)
}

/// The states on which claims rest, as far as they were tested.
fn judged<'r>(report: &'r PassReport<'_>, rests: Rests) -> Vec<Judged<'r>> {
    let behind = if rests == Rests::OnTuned { behind(report) } else { Vec::new() };
    if !behind.is_empty() {
        let of = |pass: &'r PassErrors| {
            let state = pass.standings.get(1)?.clone();
            Some(Judged { state, here: None, pass: Some(pass.pass.as_str()) })
        };
        return behind.into_iter().filter_map(of).filter(|own| own.state.kept.is_some()).collect();
    }
    let of = |(_, output): (&'r str, &'r compare::Output)| {
        let mut states = ladder::standings(output);
        let tuned = if states.len() > 1 && rests == Rests::OnTuned { states.pop() } else { None };
        let which = if tuned.is_some() { "tuned" } else { report.untuned() };
        let state = tuned.or_else(|| states.into_iter().next())?;
        Some(Judged { state, here: Some((output, which)), pass: None })
    };
    report.outputs::<compare::Kind>().filter_map(of).filter(|own| own.state.kept.is_some()).collect()
}

/// The first of these states that breaks a criterion; `None` where all are kept, or where nothing was measured.
fn broken<'r>(report: &'r PassReport<'_>, rests: Rests) -> Option<Judged<'r>> {
    judged(report, rests).into_iter().find(|own| own.state.fails())
}

/// The state of the model on which claims rest, and what its test says of it: validated is a state that keeps all criteria
/// on readings held out from its fit.
pub(super) fn state(report: &PassReport<'_>, rests: Rests) -> String {
    let behind = behind(report);
    let which = match (rests, behind.first()) {
        (Rests::OnDelivered, _) => report.untuned().to_owned(),
        (Rests::OnTuned, Some(pass)) => format!("tuned in {}", pass.pass),
        (Rests::OnTuned, None) => "tuned".to_owned(),
    };
    let states = judged(report, rests);
    let misfit = misfit(report).filter(|_| rests == Rests::OnTuned);
    let misfit = misfit.map_or_else(String::new, |own| format!("; it does not explain its data ({})", p_stated(own.0)));
    if states.is_empty() {
        let place = if behind.is_empty() { "in this pass" } else { "there" };
        format!("{which}; no test of it {place}{misfit}")
    } else if states.iter().any(|own| own.state.fails()) {
        format!("{which}; it fails its test{misfit}")
    } else if states.iter().any(|own| own.state.held_out.is_some()) {
        let validated = if misfit.is_empty() { " and validated on readings held out" } else { "" };
        format!("{which}{validated}{misfit}")
    } else {
        format!("{which}; it keeps the criteria on the readings that it was held against{misfit}")
    }
}

/// Whether chains behind a tuned state or a prediction of the pass did not converge.
pub(super) fn is_unconverged(report: &PassReport<'_>) -> bool {
    report.outputs::<calibrate::Kind>().any(|(_, output)| !output.converged)
        || report.outputs::<predict::Kind>().any(|(_, output)| !output.converged)
}

/// Probability below which noise alone is no explanation of what a tuned model leaves.
pub(super) const IMPROBABLE: f64 = 0.005;

/// Probability that noise alone leaves so large a misfit, where the calibration behind a prediction leaves one that is improbable
/// and the prediction adds no discrepancy for it; with the pass of that calibration, where it is another one.
pub(super) fn misfit<'r>(report: &'r PassReport<'_>) -> Option<(f64, Option<&'r str>)> {
    let own = || report.outputs::<calibrate::Kind>().filter_map(|(_, output)| output.p_value).reduce(f64::min);
    let of = |(_, output): (&str, &predict::Output)| {
        let is_bare = output.validated.is_none() && output.posterior.discrepancy.is_empty();
        let carried = carried(report, output);
        let p = carried.map_or_else(own, |pass| pass.p_value).filter(|p| is_bare && *p < IMPROBABLE)?;
        Some((p, carried.map(|pass| pass.pass.as_str())))
    };
    report.outputs::<predict::Kind>().filter_map(of).reduce(|a, b| if b.0 < a.0 { b } else { a })
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
    let Some(judged) = broken(report, rests) else {
        let (p, pass) = misfit(report).filter(|_| rests == Rests::OnTuned)?;
        let text = match pass {
            Some(pass) => heading.plain(" The model tuned in ").code(pass).plain(" does not explain"),
            None => heading.plain(" The tuned model does not explain"),
        };
        return Some(text.plain(format!(
            " the data to which it was fitted: noise alone would leave so large a misfit with probability {}. Its posterior is too \
             narrow for a model that lacks something.",
            p_value(p)
        )));
    };
    let [kept, of] = judged.state.kept?;
    let mut text = heading.plain(" The probability is that of the model, and the model ");
    text = match (judged.here, judged.pass) {
        (Some((output, which)), _) => {
            text.plain(format!("{which} keeps {kept} of {of} criteria of its test ({}).", output.criteria.title))
        }
        (None, pass) => text
            .plain("tuned in ")
            .code(pass.unwrap_or_default())
            .plain(format!(" keeps {kept} of {of} criteria of its test there.")),
    };
    let (unit, state) = (judged.here.map_or("K", |(output, _)| ladder::unit(output)), judged.state);
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
