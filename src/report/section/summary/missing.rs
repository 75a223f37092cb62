//! What diagnoses say on the first screen: what is missing, how sure that is, what it does to the error, and what else it
//! could be.

use std::collections::BTreeSet;

use crate::diagnosis::Verdict;
use crate::diagnosis::output::{EffectResult, Heat, HeldOutTest, Output, StoryStep};
use crate::diagnosis::verdict::discriminating_experiment::is_worth_a_test;
use crate::diagnosis::verdict::numbers::kelvins_before_and_after;
use crate::document::{counted, p_stated};
use crate::report::number::{fixed, significant, with_unit};
use crate::report::page::{Statement, Status, Text};
use crate::report::section::diagnosis::{chance, near_miss, one_of, proposed_first, size};
use crate::thermal::Model;

/// Rivals that a statement names.
const MOST_RIVALS: usize = 3;
/// What a Bayes factor tells and a probability does not.
const AGAINST: &str =
    ": the evidence against the model without it, where the probability is shared with the other candidates.";
/// Steps that stand on the first screen.
const MOST_STEPS: usize = 3;

/// The statements of a diagnosis.
pub(super) fn of_diagnosis(output: &Output, model: &Model) -> Vec<Statement> {
    let selected: Vec<&EffectResult> =
        output.selected.iter().filter_map(|id| output.effects.iter().find(|effect| effect.id == *id)).collect();
    let mut out = vec![what(output, &selected)];
    out.push(how_sure(output, &selected));
    let steps = steps(output);
    if steps.is_empty() {
        out.extend(error(output, &selected));
    } else {
        out.extend(steps);
    }
    out.extend(what_else(output, &selected, model));
    out
}

/// A further diagnosis of the same pass, in one statement.
pub(super) fn of_further(name: &str, output: &Output) -> Statement {
    let text = match output.selected.as_slice() {
        [] => Text::new("It selects no effect."),
        ids => listed(Text::new("It selects "), ids, ids.len()).plain("."),
    };
    Statement { label: format!("Diagnosis {name}"), value: output.verdict.word().to_owned(), text, status: None }
}

/// Names, with commas.
fn listed(mut text: Text, names: &[String], most: usize) -> Text {
    for (position, name) in names.iter().take(most).enumerate() {
        text = text.plain(if position == 0 { "" } else { ", " }).code(name);
    }
    let more = names.len().saturating_sub(most);
    if more > 0 { text.plain(format!(" and {more} more")) } else { text }
}

fn what(output: &Output, selected: &[&EffectResult]) -> Statement {
    let label = "What is missing".to_owned();
    let statement = |value: &str, text: Text, status| Statement { label, value: value.to_owned(), text, status };
    match (output.verdict, selected) {
        (Verdict::Adequate, _) => {
            let [effects, pairs, _] = output.looked_at;
            let text = format!(
                "{} and {} of them were tried on the tuned model; none is needed.",
                counted(effects, "effect"),
                counted(pairs, "pair")
            );
            match near_miss(output) {
                Some(near) => {
                    let text = Text::new("By the level of the tests no effect is needed, but ").joined(Some(near));
                    statement("nothing that is sure", text, Some(Status::Caution))
                }
                None => statement("nothing that shows", text.into(), Some(Status::Ok)),
            }
        }
        (Verdict::Unexplained, _) | (_, []) => {
            let mut text = Text::new("No effect of the catalogue explains the misfit. ");
            let clearest = output.heat.iter().filter(|heat| heat.sd > 0.0).max_by(|a, b| {
                let clear = |heat: &Heat| heat.watts.abs() / heat.sd;
                clear(a).total_cmp(&clear(b))
            });
            if let Some(heat) = clearest {
                let shown = with_unit(&significant(heat.watts, 2), "W");
                text = text.plain("Largest heat without an explanation: ").code(&heat.node).plain(format!(", {shown}"));
                if let Some(phase) = &heat.phase {
                    text = text.plain(" in ").code(phase);
                }
                text = text.plain(".");
            }
            if let Some(with) = output.goes_with.first() {
                text = text.plain(" Heat of ").code(&with.node).plain(" goes with ").code(&with.input).plain(".");
            }
            statement("something unknown", text, Some(Status::Fail))
        }
        (_, selected) => {
            let (settled, open): (Vec<&EffectResult>, Vec<&EffectResult>) =
                selected.iter().partition(|own| output.is_settled(own));
            // What is sure is the headline, where something is.
            let (named, perhaps) = if settled.is_empty() { (open, settled) } else { (settled, open) };
            let before = proposed_first(output, &named);
            // A name that a rival beats is no headline.
            let headline: Vec<String> = named.iter().map(|effect| one_of(output, effect)).collect();
            let mut text = match before {
                Some(before) => sizes(Text::new("Proposed: "), output, &named).plain("; ").joined(Some(before)),
                None => sizes(Text::default(), output, &named),
            };
            if !perhaps.is_empty() {
                text = sizes(text.plain(". Perhaps missing too: "), output, &perhaps);
            }
            statement(&headline.join(" + "), text.plain("."), Some(Status::Caution))
        }
    }
}

/// The size of each effect, and the most heat that it gives or takes; of laws of one thing what is open first.
fn sizes(mut text: Text, output: &Output, effects: &[&EffectResult]) -> Text {
    for (position, effect) in effects.iter().enumerate() {
        let size = size(effect).map_or_else(String::new, |(name, size)| format!(", {name} {size}"));
        let open =
            output.kind_of(effect).map_or_else(String::new, |kind| format!("{} is open; one of them: ", kind.open));
        text = text.plain(if position == 0 { "" } else { "; " }).plain(open).code(&effect.id).plain(size);
        if let (Some([least, most]), Some(first)) = (effect.watts, effect.carries.first()) {
            let (size, way) = if most >= -least { (most, "into") } else { (-least, "out of") };
            let size = with_unit(&significant(size, 2), "W");
            text = text.plain(format!(", up to {size} {way} ")).code(&first.node);
        }
    }
    text
}

fn how_sure(output: &Output, selected: &[&EffectResult]) -> Statement {
    let p = |p: f64| format!("A misfit as clear as this would have {} if nothing were missing.", p_stated(p));
    let best = output.models.iter().find(|model| {
        model.effects.len() == output.selected.len() && model.effects.iter().all(|id| output.selected.contains(id))
    });
    let (value, text) = match (output.verdict, best) {
        (Verdict::Adequate, _) => {
            let nothing = chance(output.probability_nothing);
            let text = format!("Over all tests together. That nothing is missing has a probability of {nothing}.");
            (p_stated(output.misfit.family_wise_p), text)
        }
        // What comes nearest may be probable among what was fitted, and no explanation.
        (Verdict::Unexplained, _) if output.probability_unexplained <= 0.5 => (
            p_stated(output.misfit.family_wise_p),
            "That is the probability of a misfit as clear as this if nothing were missing; nothing that was fitted explains enough of it."
                .to_owned(),
        ),
        (Verdict::Unexplained, _) | (_, None) => {
            (chance(output.probability_unexplained), p(output.misfit.family_wise_p))
        }
        (_, Some(model)) => {
            let each: Vec<String> = selected.iter().map(|effect| fixed(effect.log_bayes_factor, 1)).collect();
            let factor = if each.is_empty() {
                String::new()
            } else {
                format!(" Log Bayes factors: {}{AGAINST}", each.join(", "))
            };
            let wrong = p(output.misfit.family_wise_p);
            if output.verdict == Verdict::Ambiguous {
                let least = selected.iter().map(|effect| effect.probability).fold(model.probability, f64::min);
                let set_probability = chance(least);
                let settled: Vec<f64> = selected.iter().filter_map(|own| settled_probability(output, own)).collect();
                let of_all = chance(held(output));
                match settled.into_iter().reduce(f64::min) {
                    Some(sure) => (
                        chance(sure),
                        format!(
                            "Probability of what is called missing, the least sure of it; that every selected effect or a rival of it is \
                             missing {of_all}, just this set {set_probability}.{factor} {wrong}"
                        ),
                    ),
                    None => (
                        of_all,
                        format!("Probability that it is one of the rivals; of this set {set_probability}.{factor} {wrong}"),
                    ),
                }
            } else {
                let probability = probability_of_set(model.probability, selected);
                let of = if selected.len() == 1 { "Probability that it is missing" } else { "Probability of this set" };
                (chance(probability), format!("{of}.{factor} {wrong}"))
            }
        }
    };
    let label = format!("How sure: {}", output.verdict.word());
    Statement { label, value, text: text.into(), status: None }
}

/// How probable a selected effect is that is settled, or what all laws of its group are; `None` of others.
fn settled_probability(output: &Output, own: &EffectResult) -> Option<f64> {
    let kind = output.settled_kind_of(own).map(|kind| kind.probability);
    kind.or_else(|| output.is_settled(own).then_some(own.probability))
}

/// Probability of a set: of a single effect its own, whatever else may be missing; else that of the set among those that were fitted, at most
/// that of its least probable effect.
pub(super) fn probability_of_set(among_sets: f64, effects: &[&EffectResult]) -> f64 {
    match effects {
        [one] => one.probability,
        _ => effects.iter().map(|effect| effect.probability).fold(among_sets, f64::min),
    }
}

/// Probability of the sets that have an effect of every group.
fn held(output: &Output) -> f64 {
    let groups: BTreeSet<u64> = output.effects.iter().filter_map(|effect| effect.group).collect();
    let has = |ids: &[String], group: u64| {
        output.effects.iter().any(|effect| effect.group == Some(group) && ids.contains(&effect.id))
    };
    let hits = output.models.iter().filter(|model| groups.iter().all(|group| has(&model.effects, *group)));
    hits.map(|model| model.probability).sum()
}

/// An error before and after something, and whether it fell.
fn change(before: Option<f64>, after: Option<f64>) -> Option<(String, bool)> {
    let (before, after) = (before?, after?);
    Some((with_unit(&kelvins_before_and_after([before, after]).join(" \u{2192} "), "K"), after < before))
}

/// What each effect does to the error, where they are added one by one; what remains stands with the last one.
fn steps(output: &Output) -> Vec<Statement> {
    let added: Vec<(&String, &StoryStep)> =
        output.steps.iter().filter_map(|step| step.effect.as_ref().map(|id| (id, step))).collect();
    // Else the most effects that a set may have are there.
    let end = output.steps.last().filter(|step| step.effect.is_none());
    let ended =
        end.map(|end| if end.open { " Where more is missing is open." } else { " No further effect is added." });
    let shown = added.iter().take(MOST_STEPS).enumerate().filter_map(|(position, (id, step))| {
        let [before, after] = step.rmse_k.train;
        let train = change(before, after)?;
        let held_out = change(step.rmse_k.held_out[0], step.rmse_k.held_out[1]);
        let beside = if step.beside_later { ", beside the later steps" } else { "" };
        let text = Text::default().code(id.as_str()).plain(format!(", probability {}. ", chance(step.probability)));
        let (value, fell, text) = match held_out {
            Some((value, fell)) => (
                value,
                fell,
                text.plain(format!("RMSE on held-out readings{beside}; on those of the fit {}.", train.0)),
            ),
            None => {
                (train.0, train.1, text.plain(format!("RMSE on the readings of the fit{beside}; none is held out.")))
            }
        };
        let is_last = position + 1 == added.len().min(MOST_STEPS);
        let text = match added.len() - added.len().min(MOST_STEPS) {
            _ if !is_last => text,
            0 => text.plain(ended.unwrap_or_default()),
            more => text.plain(format!(" {} follow; the diagnosis lists them.", counted(more, "smaller step"))),
        };
        let status = Some(if fell { Status::Ok } else { Status::Caution });
        Some(Statement { label: format!("Error, step {}", position + 1), value, text, status })
    });
    shown.collect()
}

fn error(output: &Output, selected: &[&EffectResult]) -> Option<Statement> {
    if selected.is_empty() {
        return None;
    }
    let before = output.misfit.rmse_k;
    let after = output
        .models
        .iter()
        .find(|model| {
            model.effects.len() == output.selected.len() && model.effects.iter().all(|id| output.selected.contains(id))
        })?
        .rmse_k;
    let train = change(before.train, after.train)?;
    let held_out = change(before.held_out, after.held_out);
    let with = if selected.len() == 1 { "With it" } else { "With them" };
    let (value, fell, text) = match held_out {
        Some((value, fell)) => {
            (value, fell, format!("{with}, RMSE tuned on held-out readings; on those of the fit {}.", train.0))
        }
        None => (train.0, train.1, format!("{with}, RMSE tuned on the readings of the fit; none is held out.")),
    };
    // A calibration infers its noise beside the model as it is, a diagnosis beside what it lacks.
    let is_settled = output.noise.values().any(|noise| noise.estimated);
    let text = if is_settled { format!("{text} Both with the noise as it was estimated here.") } else { text };
    let speaks_against = output.held_out_test.as_ref().is_some_and(|test: &HeldOutTest| test.veto);
    let text = if speaks_against { format!("{text} The held-out readings speak against it.") } else { text };
    let status = Some(if fell && !speaks_against { Status::Ok } else { Status::Caution });
    Some(Statement { label: "What that does to the error".into(), value, text: text.into(), status })
}

fn what_else(output: &Output, selected: &[&EffectResult], model: &Model) -> Option<Statement> {
    let first = *selected.first()?;
    let groups: Vec<u64> = selected.iter().filter_map(|effect| effect.group).collect();
    let rivals: Vec<&EffectResult> = output
        .effects
        .iter()
        .filter(|other| {
            other.group.is_some_and(|group| groups.contains(&group)) && !output.selected.contains(&other.id)
        })
        .collect();
    let label = "What else it could be".to_owned();
    if rivals.is_empty() {
        let next = output.effects.iter().find(|other| !output.selected.contains(&other.id));
        let text = match next.filter(|other| other.probability >= 1e-3) {
            Some(other) => {
                Text::new("The next best, ").code(&other.id).plain(format!(", {}.", chance(other.probability)))
            }
            None if first.confused_with.is_empty() => Text::new("No other effect comes above 0.1\u{A0}%."),
            None => Text::new("No other effect comes above 0.1\u{A0}%. Most easily mistaken for it: ")
                .plain(first.confused_with.join(", "))
                .plain("."),
        };
        let value = if output.verdict == Verdict::Ambiguous { "other sets" } else { "no rival" };
        return Some(Statement { label, value: value.into(), text, status: None });
    }
    let names: Vec<String> = rivals.iter().map(|rival| rival.id.clone()).collect();
    let mut text = listed(Text::new("These data cannot tell it from "), &names, MOST_RIVALS).plain(".");
    if let Some(experiment) = &output.discriminating_experiment {
        let probability = chance(experiment.probability);
        text = text.plain(match is_worth_a_test(experiment.probability) {
            true => format!(" The phase proposed below would, with probability {probability}."),
            false => format!(
                " The best steady phase within the stated ranges would with probability {probability}, guessing with 50\u{A0}%."
            ),
        });
    } else if let Some(one) = &output.one_thing {
        text = text.plain(" ").plain(one.in_words());
    }
    if let Some(own) = &output.only_in_transients {
        text = text.plain(" ").plain(own.in_brief(model).replace(" degC", "\u{A0}\u{B0}C"));
    }
    let value = counted(rivals.len(), "rival");
    Some(Statement { label, value, text, status: Some(Status::Caution) })
}
