//! What came out of the pass in a sentence or two, and the next step as a command.

use crate::diagnosis::Verdict;
use crate::diagnosis::output::{DiscriminatingStep, EffectResult, Output as Diagnosis};
use crate::diagnosis::verdict::discriminating_experiment::is_worth_a_test;
use crate::diagnosis::verdict::experiment_words::time;
use crate::document::canonical::quoted;
use crate::document::p_stated;
use crate::document::visible::shell_word;
use crate::expression::Unit;
use crate::job::{calibrate, compare, diagnose, goal, predict, propagate, test_plan};
use crate::math::sort::sort_by;
use crate::report::ladder;
use crate::report::number::{self, NONE, Shown, signed, significant, with_error, with_unit};
use crate::report::page::{Statement, Status, Text};
use crate::report::section::compliance::{Judged, counts, judged};
use crate::report::section::diagnosis::{chance, led_by_group, near_miss, proposed_first, size, unexplained};
use crate::report::section::propagation::{nominal_cases, standing};
use crate::report::section::summary::missing::probability_of_set;
use crate::report::section::summary::unconverged;
use crate::report::section::validation::{IMPROBABLE, misfit, tuned_in};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

/// Letters of the rivals' ids that a line of the next step has room for.
const MOST_LETTERS: usize = 70;
/// Requirements that the headline states.
const MOST_REQUIREMENTS: usize = 3;
/// Draws next to a bound, above which a parameter is said to press against it.
pub(super) const PRESSES: f64 = 0.05;

/// What came out; none where no result says it.
pub(super) fn headline(report: &PassReport<'_>) -> Option<Text> {
    let diagnosis = report.outputs::<diagnose::Kind>().next().map(|(_, output)| of_diagnosis(output));
    let is_first = diagnosis.is_none();
    let mut parts: Vec<Text> = unconverged::headline(report).into_iter().chain(diagnosis).collect();
    parts.extend(of_error(report, is_first));
    parts.extend(of_bounds(report));
    parts.extend(of_requirements(report));
    let mut whole = Text::default();
    for (position, part) in parts.into_iter().enumerate() {
        whole = if position == 0 { whole } else { whole.plain(" ") };
        whole.0.extend(part.0);
    }
    (!whole.0.is_empty()).then_some(whole)
}

/// The effect in the words of its title, its place, its size.
fn in_words(mut text: Text, effect: &EffectResult) -> Text {
    let (title, before) = match effect.title.strip_suffix(" between two nodes") {
        Some(title) => (title, " between "),
        None => (effect.title.as_str(), ", "),
    };
    text = text.strong(title);
    for (position, name) in effect.place.iter().enumerate() {
        text = text.plain(if position == 0 { before } else { " and " }).code(name);
    }
    if let Some((_, size)) = size(effect) {
        text = text.plain(format!(": {size}"));
    }
    if let Some([least, most]) = effect.watts {
        let size = if most >= -least { most } else { -least };
        text = text.plain(format!(", up to {}", with_unit(&significant(size, 2), "W")));
    }
    text
}

fn of_diagnosis(output: &Diagnosis) -> Text {
    let selected: Vec<&EffectResult> =
        output.selected.iter().filter_map(|id| output.effects.iter().find(|effect| effect.id == *id)).collect();
    let text = Text::default().strong(output.verdict.word()).plain(": ");
    match (output.verdict, selected.as_slice()) {
        (Verdict::Adequate, _) => {
            let p = p_stated(output.misfit.family_wise_p);
            match near_miss(output) {
                Some(near) => {
                    // Said once, where the tests are near their level.
                    let tests = if near.in_plain_words().contains(&p) { String::new() } else { format!(" ({p})") };
                    let text = text.plain(format!("no effect is needed by the level of the tests{tests}, but "));
                    text.joined(Some(near))
                }
                None => text.plain(format!("nothing is missing that these data could show ({p} over all tests).")),
            }
        }
        (Verdict::Unexplained, _) | (_, []) => text.plain(unexplained(output)),
        (verdict, _) => {
            let (settled, open): (Vec<&EffectResult>, Vec<&EffectResult>) =
                selected.iter().partition(|own| output.is_settled(own));
            let is_partly = verdict == Verdict::Ambiguous && !settled.is_empty() && !open.is_empty();
            let each = |mut text: Text, effects: &[&EffectResult]| {
                for (position, effect) in effects.iter().enumerate() {
                    let text_before = if position == 0 { text } else { text.plain("; and ") };
                    text = in_words(led_by_group(text_before, output, effect), effect);
                }
                text
            };
            let is_kind_alone =
                verdict == Verdict::Ambiguous && open.is_empty() && output.settled().len() < settled.len();
            let begin = if is_partly || is_kind_alone { text.plain("missing is ") } else { text };
            let mut text = match is_partly {
                true => each(each(begin, &settled).plain("; open is "), &open),
                false => each(begin, &selected),
            };
            let before = proposed_first(output, &selected);
            let model = output.models.iter().find(|model| {
                model.effects.len() == selected.len() && model.effects.iter().all(|id| output.selected.contains(id))
            });
            text = match (verdict, model) {
                (Verdict::Ambiguous, _) if is_partly && before.is_none() => text.plain("."),
                (Verdict::Ambiguous, _) if output.is_without_rival() => {
                    let what = if selected.len() == 1 { "it is" } else { "they are" };
                    text.plain(format!("; these data do not settle that {what} there."))
                }
                (Verdict::Ambiguous, _) if before.is_some() => text.plain("; ").joined(before).plain("."),
                (Verdict::Ambiguous, _) => text.plain("; rivals explain the data as well."),
                (_, Some(model)) => {
                    text.plain(format!("; probability {}.", chance(probability_of_set(model.probability, &selected))))
                }
                (_, None) => text.plain("."),
            };
            let errors = model.map(|model| (output.misfit.rmse_k, model.rmse_k));
            let fall = errors.and_then(|(before, after)| {
                let held_out = before.held_out.zip(after.held_out).map(|pair| (pair, "held-out"));
                held_out.or_else(|| before.train.zip(after.train).map(|pair| (pair, "fitted")))
            });
            let shown = Shown::si("K");
            let them = if selected.len() == 1 { "it" } else { "them" };
            match fall {
                Some(((before, after), what)) if after < before => text.plain(format!(
                    " With {them} the {what} error falls from {} tuned to {}.",
                    shown.text(before),
                    shown.text(after)
                )),
                Some(((before, after), what)) => text.plain(format!(
                    " The {what} error does not fall with {them}: {} tuned, {} with {them}.",
                    shown.text(before),
                    shown.text(after)
                )),
                None => text,
            }
        }
    }
}

/// The error of the delivered and the tuned model; where it fails is said of a model that was not tuned and not diagnosed.
fn of_error(report: &PassReport<'_>, is_first: bool) -> Option<Text> {
    let (_, output) = report.outputs::<compare::Kind>().find(|(_, output)| !output.rows.is_empty())?;
    let states = ladder::standings(output);
    let shown = Shown::si(ladder::unit(output));
    let [delivered, ..] = states.as_slice() else { return None };
    let what = if delivered.held_out.is_some() { "Held-out error" } else { "Error" };
    let error = shown.text(delivered.error()?);
    // With an adopted effect at nominal size the model is no longer the delivered one, and no state that anybody uses.
    let untuned = if report.adopted.is_empty() { "as delivered" } else { "untuned with the adopted effects" };
    if let Some(tuned) = states.get(1).filter(|_| !report.adopted.is_empty()) {
        let text = Text::new(format!("{what} {} tuned with the adopted effects", shown.text(tuned.error()?)));
        return Some(match tuned_before(report, delivered.held_out.is_some()) {
            Some((pass, before)) => {
                text.plain(format!(", {} tuned without them (", shown.text(before))).code(pass).plain(").")
            }
            None => text.plain(format!(", {error} before tuning.")),
        });
    }
    if let Some(tuned) = states.get(1) {
        return Some(format!("{what} {error} {untuned}, {} after tuning.", shown.text(tuned.error()?)).into());
    }
    if let Some(pass) = tuned_in(report) {
        let error = shown.text(pass.standings.get(1)?.error()?);
        return Some(
            Text::new(format!("{what} {error} tuned in ")).code(&pass.pass).plain(", on which the prediction rests."),
        );
    }
    let text = Text::new(format!("{what} {error} {untuned}."));
    let Some(worst) = delivered.worst.as_ref().filter(|_| is_first) else { return Some(text) };
    let (mean, largest) = (with_unit(&signed(worst.mean, 2), &shown.unit), shown.text(worst.largest));
    Some(text.plain(" Worst: ").code(&worst.name).plain(format!(", {mean} on average, {largest} at most.")))
}

/// The nearest earlier pass that is tuned on the same readings without the effects of this one, with its error in K.
fn tuned_before<'r>(report: &'r PassReport<'_>, held_out: bool) -> Option<(&'r str, f64)> {
    let history = report.history.as_ref()?;
    let own = history.passes.iter().find(|pass| pass.pass == report.pass_file)?;
    let before = history.before(own).filter(|before| before.has_readings_of(own) && before.adopted != own.adopted)?;
    let tuned = before.rmse_k.tuned;
    Some((before.pass.as_str(), if held_out { tuned.held_out? } else { tuned.train? }))
}

/// Whether the posterior lies above the middle of the prior: the bound that its draws press against is the upper one.
fn is_at_upper(summary: &calibrate::ParameterSummary) -> bool {
    let middle = summary.prior.quantile(0.5);
    let middle = Unit::parse(&summary.unit).map_or(middle, |unit| unit.from_si(middle));
    summary.q50 > middle
}

/// Parameters that press against a bound of their priors.
fn of_bounds(report: &PassReport<'_>) -> Option<Text> {
    // Of draws that are not to be trusted nothing is said.
    let pressing: Vec<(&String, &calibrate::ParameterSummary)> = (report.outputs::<calibrate::Kind>())
        .filter(|(_, output)| output.converged)
        .flat_map(|(_, output)| &output.parameters)
        .filter(|(_, summary)| summary.at_bound > PRESSES)
        .collect();
    let mut text = Text::default();
    for (position, (name, summary)) in pressing.iter().enumerate() {
        let verb = if position == 0 { " presses against the " } else { " against the " };
        text = text.plain(if position == 0 { "" } else { ", " }).code(*name).plain(verb);
        text = text.plain(if is_at_upper(summary) { "upper" } else { "lower" }).plain(" bound");
    }
    let of = if pressing.len() > 1 { " of their priors" } else { " of its prior" };
    (!pressing.is_empty())
        .then(|| text.plain(of).plain(": relax it with a physical reason, or look for missing physics."))
}

/// Each requirement with what is predicted of it, those farthest from what is required first; after calibration where that was
/// carried on.
fn of_requirements(report: &PassReport<'_>) -> Option<Text> {
    let mut rows: Vec<(Judged, f64)> = (judged(report).into_iter())
        .filter_map(|row| row.probability.map(|value| (value - row.required, row)))
        .map(|(left, row)| (row, left))
        .collect();
    let rank = |status: Status| match status {
        Status::Fail => 0,
        Status::Caution => 1,
        Status::Ok => 2,
    };
    sort_by(&mut rows, |a, b| rank(a.0.status).cmp(&rank(b.0.status)).then(a.1.total_cmp(&b.1)));
    let mut text = Text::default();
    for (position, (row, _)) in rows.iter().take(MOST_REQUIREMENTS).enumerate() {
        text = text.plain(if position == 0 { "Requirement: " } else { "; " });
        text = text.plain(format!("{} {}, {}: ", row.quantity, row.limit, row.environment));
        if row.predicted != NONE {
            let interval = if position == 0 { " (median; 98\u{A0}% interval)" } else { "" };
            text = text.plain(format!("predicted {}{interval}, margin {}, ", row.predicted, row.margin));
        }
        let stated = probability_stated_in(&row.probability_text);
        text = text.plain(format!("P\u{A0}{}, required {}, ", equals(stated), number::probability(row.required)));
        text = text.strong(row.verdict.clone());
    }
    let (first, _) = rows.first()?;
    let left_out = &rows[rows.len().min(MOST_REQUIREMENTS)..];
    if !left_out.is_empty() {
        let counts = counts(left_out.iter().map(|(row, _)| row));
        text = text.plain(format!("; {} more: {}", left_out.len(), counts.trim_end_matches('.')));
    }
    Some(text.plain(".").joined(reached(report, first)))
}

/// What design value would reach a requirement that is not met: all requirements together where the sweep tells that.
fn reached(report: &PassReport<'_>, row: &Judged) -> Option<Text> {
    let predicted = report.outputs::<predict::Kind>().map(|(name, output)| (name, &output.posterior));
    let propagated = report.outputs::<propagate::Kind>();
    let (_, output) = predicted.chain(propagated).find(|(name, _)| *name == row.job)?;
    let name = output.design_variable.as_ref().filter(|_| row.status != Status::Ok)?;
    let of = |requirement: &str| {
        let is = |reached: &&propagate::Reached| {
            reached.environment == row.environment && reached.requirement == requirement
        };
        output.reached.iter().find(is)
    };
    let reached = of(ALL).or_else(|| of(&row.requirement))?;
    let what = if reached.requirement == ALL { "meets all requirements" } else { "reaches it" };
    Some(match reached.design_value {
        Some(value) => format!(" {name} = {} {what}.", Shown::written(&output.design_unit).text(value)).into(),
        None => format!(" No {name} of the sweep {what}.").into(),
    })
}

/// A probability without its interval, which the table of compliance has.
fn probability_stated_in(text: &str) -> &str {
    text.split_once(" (").map_or(text, |(stated, _)| stated)
}

/// A probability behind its letter; one that is a bound has its own sign.
fn equals(stated: &str) -> String {
    let text = if stated.starts_with(['\u{2264}', '\u{2265}']) { stated.to_owned() } else { format!("= {stated}") };
    text.replace(' ', "\u{A0}")
}

/// Whether a comparison or the calibration behind it leaves something to be explained.
fn leaves_something(report: &PassReport<'_>) -> bool {
    let presses = |(_, output): (&str, &calibrate::Output)| {
        output.parameters.values().any(|summary| summary.at_bound > PRESSES)
            || output.p_value.is_some_and(|p| p < IMPROBABLE)
    };
    let lacks = |(_, output): (&str, &compare::Output)| match ladder::standings(output).as_slice() {
        [_, tuned, ..] => tuned.fails(),
        [delivered] => delivered.fails() || !output.fails.is_empty(),
        [] => false,
    };
    // What was tuned in another pass is judged there.
    (tuned_in(report).is_none() && report.outputs::<compare::Kind>().any(lacks))
        || report.outputs::<calibrate::Kind>().any(presses)
}

/// The next step, as a command; none where the pass has no result yet.
pub(super) fn next_step(report: &PassReport<'_>) -> Option<Text> {
    if report.results.is_empty() {
        return None;
    }
    if let Some(mended) = unconverged::next_step(report) {
        return Some(mended);
    }
    let path = format!("{}/{}", report.study, report.pass_file);
    let command = |verb: &str| format!("bmv {verb} {path}");
    if let Some((name, output)) = report.outputs::<diagnose::Kind>().next() {
        let several = report.outputs::<diagnose::Kind>().count() > 1;
        let adopt = if several { format!("{} --job {name}", command("adopt")) } else { command("adopt") };
        match output.verdict {
            Verdict::Identified => {
                return Some(Text::default().code(adopt).plain(" writes the next pass with it; then run it."));
            }
            Verdict::Ambiguous if !output.settled().is_empty() => {
                // It costs no test.
                let ids =
                    output.settled().iter().map(|effect| format!(" {}", shell_word(&effect.id))).collect::<String>();
                let text = Text::default().code(format!("{adopt}{ids}"));
                return Some(text.plain(" adopts what is settled; the rest stays open."));
            }
            Verdict::Ambiguous if parted(output).is_some() => {
                let text = apart(Text::new("Measure a phase that tells "), parted(output).unwrap_or_default());
                return Some(text.plain(": ").code(command("diagnose")).plain(" names its conditions."));
            }
            Verdict::Ambiguous if stepped(output).is_some() => {
                let (rivals, step) = stepped(output)?;
                let text = Text::new("Measure ")
                    .plain(step.in_words(report.model).replace(" degC", "\u{A0}\u{B0}C"))
                    .plain(" for ");
                let no_longer = if step.ends_early { ", no longer" } else { "" };
                let text = text.plain(format!("{}{no_longer}: it tells ", time(step.duration_s)));
                return Some(apart(text, rivals).plain(format!(" with probability {}.", chance(step.probability))));
            }
            Verdict::Ambiguous if !output.selected.is_empty() && is_settled_but_for_laws(output) => {
                let ids = output.selected.iter().map(|id| format!(" {}", shell_word(id))).collect::<String>();
                let text =
                    Text::new("What is missing is settled, but not by which law: adopt the one that you know, as in ");
                return Some(text.code(format!("{adopt}{ids}")).plain("."));
            }
            Verdict::Ambiguous | Verdict::Unexplained => {
                let text = Text::default().code(command("diagnose"));
                return Some(text.plain(" lists what else it could be, the missing heat and what was tried."));
            }
            Verdict::Adequate => {}
        }
    } else if leaves_something(report) {
        let text = Text::default().code(command("diagnose"));
        return Some(text.plain(" says which physical effects would explain the misfit."));
    }
    if let Some((_, Some(pass))) = misfit(report) {
        let text = Text::default().code(format!("bmv diagnose {}/{pass}", report.study));
        return Some(text.plain(" says which physical effects would explain what the calibration there leaves."));
    }
    if let Some(text) = prediction_to_add(report) {
        return Some(text);
    }
    if let Some((name, _)) = report.outputs::<goal::Kind>().next() {
        let text = Text::default().code(format!("{} {name}", command("show")));
        return Some(text.plain(" says how well each parameter must be known, and what to do for it."));
    }
    if let Some((name, _)) = report.outputs::<test_plan::Kind>().next() {
        let text =
            Text::new("Test as planned (").code(format!("{} {name}", command("show"))).plain("), then bring the log: ");
        return Some(text.code(format!("bmv import csv LOG... --into {}", report.study)).plain("."));
    }
    Some(last_step(report))
}

/// Whether everything that was selected is settled, or one law of what is.
fn is_settled_but_for_laws(output: &Diagnosis) -> bool {
    output.selected.iter().all(|id| output.effect(id).is_some_and(|effect| output.is_settled(effect)))
}

/// The rivals by their ids where there is room for them, else how many.
fn apart(mut text: Text, rivals: &[String]) -> Text {
    if rivals.iter().map(String::len).sum::<usize>() > MOST_LETTERS {
        return text.plain(format!("the {} rivals apart", rivals.len()));
    }
    for (position, rival) in rivals.iter().enumerate() {
        text = text.plain(if position == 0 { "" } else { " from " }).code(rival);
    }
    text
}

/// The rivals that a proposed phase would part; none without a phase that is worth a test and that the hardware surely bears.
fn parted(output: &Diagnosis) -> Option<&[String]> {
    let experiment = output.discriminating_experiment.as_ref()?;
    let is_borne = experiment.limits_ok && experiment.near_tested;
    (experiment.between.len() > 1 && !experiment.conditions.is_empty() && is_borne)
        .then_some(experiment.between.as_slice())
        .filter(|_| is_worth_a_test(experiment.probability))
}

/// The rivals that a proposed step would part, likewise.
fn stepped(output: &Diagnosis) -> Option<(&[String], &DiscriminatingStep)> {
    let own = output.only_in_transients.as_ref()?;
    let step = own.step.as_ref().filter(|step| step.limits_ok && step.near_tested)?;
    is_worth_a_test(step.probability).then_some((own.between.as_slice(), step))
}

/// The job that judges the requirements of a pass which has a posterior and judges none: the line to add, and the command.
fn prediction_to_add(report: &PassReport<'_>) -> Option<Text> {
    let rows = judged(report);
    let judges_none = !rows.is_empty() && rows.iter().all(|row| row.probability.is_none());
    let (calibration, _) = report.outputs::<calibrate::Kind>().next().filter(|_| judges_none)?;
    let names = report.environments.iter().map(|environment| quoted(&environment.name));
    let environments = names.collect::<Vec<_>>().join(", ");
    let is_free = |name: &&str| report.results.iter().all(|job| job.name != *name);
    let name = ["flight", "prediction"].into_iter().find(is_free)?;
    let within = if environments.is_empty() { String::new() } else { format!(r#", "environments": [{environments}]"#) };
    let job = format!(r#""{name}": {{"predict": {{"from": {}{within}}}}}"#, quoted(calibration));
    let text = Text::new("No job judges the requirements with what was learnt: in ").code(&report.pass_file);
    let text = text.plain(" write ").code(job).plain(" under ").code("jobs").plain("; then ");
    Some(text.code(format!("bmv run {}/{}", report.study, report.pass_file)).plain("."))
}

/// What is left where no job says what to do: the design that meets the requirement, a test, or the archive.
fn last_step(report: &PassReport<'_>) -> Text {
    let predicted = report.outputs::<predict::Kind>().map(|(_, output)| &output.posterior);
    let output = predicted.chain(report.outputs::<propagate::Kind>().map(|(_, output)| output)).next();
    let is_missed = |output: &propagate::Output, reached: &propagate::Reached| {
        let mut met = nominal_cases(output)
            .filter(|case| case.environment == reached.environment)
            .flat_map(|case| case.requirements.iter().filter(|met| met.requirement == reached.requirement));
        met.any(|met| standing(met) != Status::Ok)
    };
    let size = output.and_then(|output| {
        let name = output.design_variable.as_ref()?;
        let missed = output.reached.iter().filter(|reached| is_missed(output, reached));
        let sizes: Vec<f64> = missed.map(|reached| reached.design_value).collect::<Option<_>>()?;
        let [first, ..] = sizes.as_slice() else { return None };
        // The sizes of several requirements: only where they agree is there one to set.
        let is_one = sizes.iter().all(|size| size == first);
        is_one.then(|| (name, Shown::written(&output.design_unit).text(*first)))
    });
    let study = &report.study;
    match size {
        Some((name, size)) => Text::new("In the next pass set ")
            .code(name)
            .plain(format!(" to {size}; then "))
            .code(format!("bmv run {study}"))
            .plain("."),
        None if report.measurements.is_empty() && output.is_some() => {
            let text = Text::new("Nothing was measured yet; a test's log is brought by ");
            text.code(format!("bmv import csv LOG... --into {study}")).plain(".")
        }
        None => {
            let pass = report.pass_file.trim_end_matches(".json");
            Text::default()
                .code(format!("bmv verify reports/{study}/{pass}"))
                .plain(" recomputes every hash before the report is signed.")
        }
    }
}

/// What a calibration measured: the parameter of which it taught the most.
pub(super) fn of_calibration(output: &calibrate::Output) -> Option<Statement> {
    if !output.converged {
        return None;
    }
    // Mean and standard deviation before, in the parameter's unit.
    let before = |summary: &calibrate::ParameterSummary| match &summary.posterior_prior {
        Some(prior) => (prior.mean, prior.sd),
        None => {
            let shown = Shown::written(&summary.unit);
            (shown.value(summary.prior.mean()), shown.difference().value(summary.prior.sd()))
        }
    };
    let gain = |summary: &calibrate::ParameterSummary| {
        let (_, prior) = before(summary);
        (summary.sd > 0.0 && prior.is_finite()).then(|| prior / summary.sd)
    };
    let known = output.order.iter().take(output.model_parameters as usize);
    let (name, summary, _) = known
        .filter_map(|name| output.parameters.get(name).map(|summary| (name, summary)))
        .filter_map(|(name, summary)| Some((name, summary, gain(summary)?)))
        .max_by(|a, b| a.2.total_cmp(&b.2))?;
    let (prior_mean, prior_sd) = before(summary);
    let (times, unit) = number::stated(&summary.unit, summary.size());
    let presses = summary.at_bound > PRESSES;
    let text = format!(
        "the parameter that the calibration tells most of; before {}.",
        with_error(times * prior_mean, times * prior_sd)
    );
    Some(Statement {
        label: format!("Measured: {name}"),
        value: with_unit(&with_error(times * summary.mean, times * summary.sd), &unit),
        text: text.into(),
        status: presses.then_some(Status::Caution),
    })
}
