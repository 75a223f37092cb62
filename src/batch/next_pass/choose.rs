//! Which effects of a diagnosis are adopted: those that it supports, or any with a word that says so.

use std::sync::Arc;

use crate::diagnosis::output::{DiscriminatingExperiment, EffectResult, OneThing};
use crate::diagnosis::verdict::experiment_words::repeated;
use crate::diagnosis::{Output, Verdict};
use crate::document::visible::shell_word;
use crate::document::{Diagnostic, Diagnostics, Place, Source, Span, code, percent, suggest};
use crate::expression::Unit;
use crate::thermal::Model;

use super::acting::Acting;
use super::entry::probability_text;
use super::mend::Mended;

/// Ids that a message lists.
const MOST_LISTED: usize = 8;

/// What was asked for, as places that messages can point at.
#[derive(Clone, Debug)]
pub struct Asked {
    source: Arc<Source>,
    /// The command's own words, then each effect.
    command: Span,
    effects: Vec<(String, Span)>,
    /// Where the effects act.
    pub(super) acting: Acting,
    /// Calibrations of the pass whose settings are mended.
    pub(super) mended: Vec<Mended>,
}

impl Asked {
    /// The effects asked for, by id or by what stands for it; `command` is what stands before them.
    pub fn new(command: &str, effects: &[String]) -> Self {
        let mut text = command.to_owned();
        let mut places = Vec::new();
        for effect in effects {
            text.push(' ');
            places.push((effect.clone(), Span::new(text.len(), text.len() + effect.len())));
            text.push_str(effect);
        }
        let source = Source::new("command line", text);
        Self {
            source,
            command: Span::new(0, command.len()),
            effects: places,
            acting: Acting::default(),
            mended: Vec::new(),
        }
    }

    /// The same, with where the effects act.
    #[must_use]
    pub fn acting(mut self, acting: Acting) -> Self {
        self.acting = acting;
        self
    }

    /// The same, with the calibrations to mend.
    #[must_use]
    pub fn mending(mut self, mended: Vec<Mended>) -> Self {
        self.mended = mended;
        self
    }

    /// The place of the command itself.
    pub fn command(&self) -> Place {
        Place::in_text(&self.source, self.command)
    }

    fn effects(&self) -> impl Iterator<Item = (&str, Place)> {
        self.effects.iter().map(|(text, span)| (text.as_str(), Place::in_text(&self.source, *span)))
    }
}

/// What is adopted, and what must be said of it.
#[derive(Debug)]
pub struct Chosen<'f> {
    /// The effects.
    pub effects: Vec<&'f EffectResult>,
    /// That the data do not settle them.
    pub warnings: Diagnostics,
}

/// The effects to adopt: those asked for, or, where none are, those that the diagnosis selected and settled.
///
/// # Errors
/// What is not known, not unique, not supported, or not settled and not asked for by name; what is not supported or settled is
/// let through where `forced`.
pub fn choose<'f>(
    diagnosis: &'f Output,
    asked: &Asked,
    job: &str,
    forced: bool,
    model: &Model,
) -> Result<Chosen<'f>, Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let mut chosen: Vec<(&EffectResult, Place)> = Vec::new();
    if asked.effects.is_empty() {
        let selected: Vec<&EffectResult> = diagnosis.selected.iter().filter_map(|id| diagnosis.effect(id)).collect();
        if selected.is_empty() {
            diagnostics.push(nothing_selected(diagnosis, asked, job, model));
        } else if !forced && !diagnosis.verdict.names_one_set() {
            diagnostics.push(not_settled(diagnosis, &selected, asked, job, model));
        }
        chosen.extend(selected.into_iter().map(|finding| (finding, asked.command())));
    }
    for (text, place) in asked.effects() {
        let Some(finding) = find(diagnosis, text, &place, job, &mut diagnostics) else { continue };
        if !forced && !diagnosis.supports(finding) {
            diagnostics.push(refused(diagnosis, finding, &place, job));
        } else if !chosen.iter().any(|(other, _)| other.id == finding.id) {
            chosen.push((finding, place));
        }
    }
    if !forced {
        for (position, (finding, place)) in chosen.iter().enumerate() {
            let before = chosen[..position].iter().map(|(other, _)| *other);
            if let Some(rival) = diagnosis.confused_with(finding).find(|rival| before.clone().any(|b| b.id == rival.id))
            {
                diagnostics.push(rivals(diagnosis, finding, rival, place, model));
            }
        }
    }
    if diagnostics.has_errors() {
        Err(diagnostics)
    } else {
        let effects: Vec<&EffectResult> = chosen.into_iter().map(|(finding, _)| finding).collect();
        let mut warnings = Diagnostics::new();
        let settled = diagnosis.settled();
        let is_open = |effect: &&EffectResult| !settled.iter().any(|one| one.id == effect.id);
        if diagnosis.verdict == Verdict::Ambiguous && effects.iter().any(is_open) {
            let warning = Diagnostic::warning(&code::ADOPT_AMBIGUOUS, &asked.command(), odds(diagnosis, &effects));
            warnings.push(match parting(diagnosis, model) {
                Some(words) => warning.help(words),
                None => warning,
            });
        }
        Ok(Chosen { effects, warnings })
    }
}

/// The effect that a text stands for: its id, an id with the ends of its pair exchanged, or the only supported (else
/// the only) one whose effect, beginning or last places it is.
fn find<'f>(
    diagnosis: &'f Output,
    text: &str,
    place: &Place,
    job: &str,
    diagnostics: &mut Diagnostics,
) -> Option<&'f EffectResult> {
    let exchanged = |finding: &&EffectResult| {
        matches!(finding.where_kind.as_str(), "nodes" | "sensors") && parts(&finding.id) == parts(text)
    };
    if let Some(finding) = diagnosis.effect(text).or_else(|| diagnosis.effects.iter().find(exchanged)) {
        return Some(finding);
    }
    let is_ending = |id: &str| id.strip_suffix(text).is_some_and(|rest| rest.ends_with(':'));
    let is_meant = |finding: &EffectResult| {
        !text.is_empty() && (finding.effect == text || finding.id.starts_with(text) || is_ending(&finding.id))
    };
    let matching: Vec<&EffectResult> = diagnosis.effects.iter().filter(|finding| is_meant(finding)).collect();
    let is_selected = |finding: &&&EffectResult| diagnosis.selected.contains(&finding.id);
    let is_supported = |finding: &&&EffectResult| diagnosis.supports(finding);
    let narrowed: [Vec<&EffectResult>; 3] = [
        matching.iter().filter(is_selected).copied().collect(),
        matching.iter().filter(is_supported).copied().collect(),
        matching,
    ];
    if let Some(only) = narrowed.iter().find_map(|list| if let [only] = list.as_slice() { Some(*only) } else { None }) {
        return Some(only);
    }
    let [_, _, matching] = narrowed;
    if !matching.is_empty() {
        let message = format!("`{text}` stands for {} effects of diagnosis `{job}`", matching.len());
        let listed = suggest::listed(matching.iter().map(|finding| finding.id.as_str()), MOST_LISTED);
        diagnostics.push(Diagnostic::error(&code::ADOPT_UNKNOWN, place, message).expected("one of them").help(listed));
        return None;
    }
    if let Some(unseen) = diagnosis.unseen.iter().find(|unseen| unseen.id == text || parts(&unseen.id) == parts(text)) {
        let why = if unseen.why.is_empty() { String::new() } else { format!(": {}", unseen.why) };
        diagnostics.push(
            Diagnostic::error(&code::ADOPT_REFUSED, place, format!("these data cannot see `{text}`{why}"))
                .expected("an effect that the data can see")
                .help("no diagnosis of these data supports it or speaks against it; to assume it all the same, write it under `adopt` in the pass file"),
        );
        return None;
    }
    let finding_ids = || diagnosis.effects.iter().map(|finding| finding.id.as_str());
    let help = match nearest(text, finding_ids()).as_slice() {
        [] => format!("best first, it has {}", suggest::listed(finding_ids(), MOST_LISTED)),
        near => format!("the nearest: {}", suggest::listed(near.iter().copied(), MOST_LISTED)),
    };
    diagnostics.push(
        Diagnostic::error(&code::ADOPT_UNKNOWN, place, format!("diagnosis `{job}` has no effect `{text}`"))
            .expected("an id as in `effects` of `bmv diagnose --json`, its beginning or its last places")
            .help(help),
    );
    None
}

/// Parts of an id; a pair's ends may stand in either order.
fn parts(id: &str) -> Vec<&str> {
    let mut parts: Vec<&str> = id.split(':').collect();
    if let [_, places @ ..] = parts.as_mut_slice() {
        places.sort_unstable();
    }
    parts
}

/// The nearest of some ids, nearest first.
fn nearest<'a>(text: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut left: Vec<&str> = known.collect();
    let mut nearest_ids = Vec::new();
    while nearest_ids.len() < 3
        && let Some(near) = suggest::nearest(text, left.iter().copied())
    {
        left.retain(|other| *other != near);
        nearest_ids.push(near);
    }
    nearest_ids
}

fn selected(diagnosis: &Output) -> String {
    match diagnosis.selected.as_slice() {
        [] => "nothing".to_owned(),
        ids => suggest::listed(ids.iter().map(String::as_str), MOST_LISTED),
    }
}

/// Supported effects that are not selected.
fn further(diagnosis: &Output) -> Vec<&str> {
    let all = diagnosis.effects.iter().filter(|finding| diagnosis.supports(finding));
    all.map(|finding| finding.id.as_str())
        .filter(|id| !diagnosis.selected.iter().any(|selected_id| selected_id == id))
        .collect()
}

fn refused(diagnosis: &Output, finding: &EffectResult, place: &Place, job: &str) -> Diagnostic {
    let verdict = diagnosis.verdict.word();
    let further = further(diagnosis);
    let accepted = match (diagnosis.selected.is_empty(), further.is_empty()) {
        (true, true) => "nothing would be accepted".to_owned(),
        (false, true) => format!("accepted: {}", selected(diagnosis)),
        (true, false) => format!("accepted: one of {}", suggest::listed(further, MOST_LISTED)),
        (false, false) => {
            let alike = suggest::listed(further, MOST_LISTED);
            format!("accepted: {}, or what these data cannot tell from it: {alike}", selected(diagnosis))
        }
    };
    let stands = format!(" (probability {:.3})", finding.probability);
    Diagnostic::error(
        &code::ADOPT_REFUSED,
        place,
        format!("diagnosis `{job}` does not support `{}`{stands}", finding.id),
    )
    .expected(format!("the verdict is `{verdict}`, selected is {}", selected(diagnosis)))
    .help(format!("{accepted}; --force adopts it all the same, and the new pass says so"))
}

fn rivals(
    diagnosis: &Output,
    finding: &EffectResult,
    rival: &EffectResult,
    place: &Place,
    model: &Model,
) -> Diagnostic {
    let message =
        format!("`{}` and `{}` explain the same misfit: these data cannot tell them apart", rival.id, finding.id);
    let mut help = "adopt one of them, or both with --force".to_owned();
    if let Some(words) = parting(diagnosis, model) {
        help.push_str(&format!("; {words}"));
    }
    Diagnostic::error(&code::ADOPT_REFUSED, place, message).expected("one of the two").help(help)
}

fn nothing_selected(diagnosis: &Output, asked: &Asked, job: &str, model: &Model) -> Diagnostic {
    let expected = match diagnosis.verdict {
        Verdict::Adequate => "these data need no further effect",
        Verdict::Unexplained if diagnosis.only_small_errors => {
            "no effect explains the errors, and the tests find nothing definite"
        }
        Verdict::Unexplained => "something is missing, and nothing of the catalogue explains it",
        Verdict::Ambiguous => "several effects explain the data alike",
        Verdict::Identified => "the diagnosis would adopt nothing",
    };
    let verdict = diagnosis.verdict.word();
    let message = format!("diagnosis `{job}` selected nothing to adopt; its verdict is `{verdict}`");
    let diagnostic = Diagnostic::error(&code::ADOPT_REFUSED, &asked.command(), message).expected(expected);
    let further = further(diagnosis);
    if further.is_empty() {
        return diagnostic.help("name an effect with --force to adopt it against the diagnosis");
    }
    let mut help = format!("name one of {}", suggest::listed(further, MOST_LISTED));
    if let Some(words) = parting(diagnosis, model) {
        help.push_str(&format!("; {words}"));
    }
    diagnostic.help(help)
}

/// That a set was selected which these data do not settle, and how it is adopted all the same.
fn not_settled(diagnosis: &Output, selected: &[&EffectResult], asked: &Asked, job: &str, model: &Model) -> Diagnostic {
    let message = format!("diagnosis `{job}` is ambiguous: {}", odds(diagnosis, selected));
    let ids: Vec<_> = selected.iter().map(|finding| shell_word(&finding.id)).collect();
    let command = asked.command();
    let settled: Vec<_> = diagnosis.settled().iter().map(|finding| shell_word(&finding.id)).collect();
    let mut help = match settled.is_empty() {
        true => String::new(),
        false => format!("what is settled can be adopted alone: {} {}; ", command.text(), settled.join(" ")),
    };
    help.push_str(&format!("to adopt it all the same, name it: {} {}", command.text(), ids.join(" ")));
    if let Some(words) = parting(diagnosis, model) {
        help.push_str(&format!("; {words}"));
    }
    Diagnostic::error(&code::ADOPT_REFUSED, &command, message).expected("the name of what you adopt").help(help)
}

/// How probable some effects are, and what else it could be.
fn odds(diagnosis: &Output, chosen: &[&EffectResult]) -> String {
    let ids: Vec<&str> = chosen.iter().map(|finding| finding.id.as_str()).collect();
    let joint_probability = diagnosis.odds(chosen).map(probability_text);
    let rivals = diagnosis.rivals(chosen);
    let more = rivals.len().saturating_sub(MOST_LISTED);
    let mut named: Vec<String> = (rivals.into_iter().take(MOST_LISTED))
        .map(|(id, odds)| format!("`{id}` ({})", probability_text(odds)))
        .collect();
    if more > 0 {
        named.push(format!("{more} more"));
    }
    let rivals = if named.is_empty() { String::new() } else { format!("; its rivals: {}", named.join(", ")) };
    let probability_clause = joint_probability.map_or_else(String::new, |odds| format!(" (probability {odds})"));
    let effects = suggest::listed(ids, MOST_LISTED);
    let settled = settled_kinds(diagnosis, chosen).map_or_else(String::new, |kinds| format!("{kinds}; "));
    format!("{settled}these data leave open whether it is {effects}{probability_clause}{rivals}")
}

/// What is missing for sure where each of some effects is settled, or one law of something that is. `None` where one is open, and
/// where all are settled down to their laws.
fn settled_kinds(diagnosis: &Output, chosen: &[&EffectResult]) -> Option<String> {
    if !chosen.iter().all(|effect| diagnosis.is_settled(effect)) {
        return None;
    }
    let mut kinds: Vec<String> = Vec::new();
    for kind in chosen.iter().filter_map(|effect| diagnosis.settled_kind_of(effect)) {
        let words = format!(
            "what is missing is {}, {} is open (probability {})",
            kind.what,
            kind.open,
            probability_text(kind.probability)
        );
        if !kinds.contains(&words) {
            kinds.push(words);
        }
    }
    (!kinds.is_empty()).then(|| kinds.join("; "))
}

/// What would part the rivals, or that no phase does: as the diagnosis decided it.
fn parting(diagnosis: &Output, model: &Model) -> Option<String> {
    let phase = diagnosis.discriminating_experiment.as_ref().and_then(|apart| experiment(apart, model));
    let none = diagnosis.one_thing.as_ref().map(OneThing::clause);
    let step = diagnosis.only_in_transients.as_ref().map(|own| own.clause(model));
    let words: Vec<String> = phase.into_iter().chain(none).chain(step).collect();
    (!words.is_empty()).then(|| words.join("; "))
}

/// The separating experiment in words.
fn experiment(experiment: &DiscriminatingExperiment, model: &Model) -> Option<String> {
    if experiment.conditions.is_empty() {
        return None;
    }
    let value = |value: f64| crate::document::canonical::float(rounded(value)).unwrap_or_default();
    let conditions = experiment.conditions.iter().map(|(name, condition)| {
        // In the unit in which the study writes the input.
        let written = model.inputs.iter().find(|input| input.name == *name).map(|input| input.unit.as_str());
        let (number, unit) = match written.and_then(|unit| Some((Unit::parse(unit).ok()?, unit))) {
            Some((parsed, unit)) => (parsed.from_si(condition.value), unit),
            None => (condition.value, condition.unit.as_str()),
        };
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        format!("{name} = {}{unit}", value(number))
    });
    let again = repeated(experiment.repeat_probability);
    Some(format!(
        "a phase at {} would tell them apart with probability {}{}",
        conditions.collect::<Vec<_>>().join(", "),
        percent(experiment.probability),
        again.map_or_else(String::new, |p| format!(" (repeating a phase: {})", percent(p)))
    ))
}

fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}
