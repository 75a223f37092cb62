//! What is said of a verdict in the light of the numbers beside it.

use std::f64::consts::TAU;

use crate::diagnosis::output::{Amount, EffectResult, GroupKind, Output, Precedence};
use crate::document::time::unit_of_time;
use crate::document::{counted, p_stated};
use crate::expression::unit::CELSIUS_ZERO_K;
use crate::math::functions::atan2;
use crate::report::number::fixed;
use crate::report::page::Text;

use super::{amount, chance};

/// Probability of the tests below which a misfit is no clear agreement either.
const NEAR: f64 = 0.05;
/// Error of the number of a phase that is stated.
const LEAST_PHASES: f64 = 0.5;
/// Probability of an effect from which on it is worth a word that it may be there.
const MAY_BE: f64 = 0.2;

/// Why a verdict that nothing is needed is no proof, where the tests are near their level or an effect may well be there.
pub(in crate::report::section) fn near_miss(output: &Output) -> Option<Text> {
    let p = output.misfit.family_wise_p;
    let best = (output.effects.iter()).max_by(|a, b| a.probability.total_cmp(&b.probability));
    let best = best.filter(|effect| effect.probability >= MAY_BE);
    let is_near = p < NEAR;
    if !is_near && best.is_none() {
        return None;
    }
    let mut text = Text::default();
    if is_near {
        text = text.plain(format!("noise alone leaves such a misfit with {} only", p_stated(p)));
    }
    if let Some(effect) = best {
        text = text.plain(if is_near { ", and " } else { "" }).code(&effect.id);
        text = text.plain(format!(" is missing with a probability of {}", chance(effect.probability)));
    }
    Some(text.plain(": a longer or stronger test would tell."))
}

/// An effect by what all laws of its group are, by its group where a rival is more probable, else by its title.
pub(in crate::report::section) fn one_of(output: &Output, own: &EffectResult) -> String {
    if let Some(kind) = output.kind_of(own) {
        let mut letters = kind.what.chars().filter(|letter| *letter != '`');
        return letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect());
    }
    if output.more_probable(own).is_empty() {
        return own.title.clone();
    }
    let members = output.effects.iter().filter(|other| other.group == own.group).count();
    format!("One of {}", counted(members, "effect"))
}

/// The beginning of what is said of an effect: what its group is before its name, where all of it are laws of one thing or a rival is
/// more probable.
pub(in crate::report::section) fn led_by_group(text: Text, output: &Output, own: &EffectResult) -> Text {
    if let Some(GroupKind { what, open, probability, .. }) = output.kind_of(own) {
        let text = text.joined(Some(Text::with_names(what)));
        let [all, one] = [*probability, own.probability].map(chance);
        return text.plain(format!(" ({all}), {open} the data do not tell; proposed, with a probability of {one}: "));
    }
    if output.more_probable(own).is_empty() {
        return text;
    }
    let group = one_of(output, own).replacen('O', "o", 1);
    let chance = chance(own.probability);
    text.strong(group).plain(format!(" that these data cannot tell apart; proposed, with a probability of {chance}: "))
}

/// That rivals of effects are more probable, and why the effects are proposed first all the same; `None` where none is.
pub(in crate::report::section) fn proposed_first(output: &Output, selected: &[&EffectResult]) -> Option<Text> {
    let led: Vec<(&EffectResult, Vec<&EffectResult>)> =
        selected.iter().map(|own| (*own, output.more_probable(own))).filter(|(_, rivals)| !rivals.is_empty()).collect();
    let mut text = Text::default();
    for (position, (own, rivals)) in led.iter().enumerate() {
        text = text.plain(if position == 0 { "more probable" } else { "; more probable" });
        // Of several it must be said which.
        text = if selected.len() > 1 { text.plain(" than ").code(&own.id).plain(": ") } else { text.plain(": ") };
        for (position, rival) in rivals.iter().enumerate() {
            text = text.plain(if position == 0 { "" } else { ", " }).code(&rival.id);
            text = text.plain(format!(" {}", chance(rival.probability)));
        }
        if let Some(reason) = own.precedence.map(Precedence::reason) {
            text = text.plain(format!(" (the proposed one goes first: {reason})"));
        }
    }
    (!led.is_empty()).then(|| text.plain("; to be proposed first makes an effect no surer"))
}

/// Whether an effect is a harmonic, whose parts tell little one by one.
pub(super) fn is_harmonic(effect: &EffectResult) -> bool {
    ["cosine", "sine"].iter().all(|part| effect.amplitudes.contains_key(*part))
}

/// The size of an effect and what it is called: its first parameter; of a harmonic its amplitude and where it is largest.
pub(in crate::report::section) fn size(effect: &EffectResult) -> Option<(String, String)> {
    if let (Some(cosine), Some(sine)) = (effect.amplitudes.get("cosine"), effect.amplitudes.get("sine")) {
        let size = (cosine.value * cosine.value + sine.value * sine.value).sqrt();
        let part = |own: &Amount| own.value * own.sd;
        let sd = (part(cosine) * part(cosine) + part(sine) * part(sine)).sqrt() / size.max(f64::MIN_POSITIVE);
        let whole = Amount { value: size, sd, at_bound: cosine.at_bound || sine.at_bound, ..cosine.clone() };
        let share = atan2(sine.value, cosine.value) / TAU;
        let share = if share < 0.0 { share + 1.0 } else { share };
        // Of an angle that a file has in degrees, else of the time of day.
        let largest = if effect.effect.contains("periodic") {
            format!("at {}\u{B0}", fixed(360.0 * share, 0))
        } else {
            format!("{}\u{A0}h after the record's start and every 24\u{A0}h", fixed(24.0 * share, 1))
        };
        return Some(("amplitude".to_owned(), format!("{}, largest {largest}", amount(&whole))));
    }
    if let (Some(power), Some(peak), Some(duration)) =
        (effect.amplitudes.get("power"), effect.amplitudes.get("peak"), effect.amplitudes.get("duration"))
    {
        let when = format!(
            "for {}\u{A0}h about {}\u{A0}h after the record's start and every 24\u{A0}h",
            fixed(duration.value, 1),
            fixed(peak.value, 1)
        );
        return Some(("power".to_owned(), format!("{}, {when}", amount(power))));
    }
    let onset = effect.amplitudes.iter().find(|(name, _)| is_onset(name));
    let (name, value) = effect.amplitudes.iter().find(|(name, value)| !is_onset(name) && value.level.is_none())?;
    // A relative change is read as a share.
    let size = match (name.as_str(), value.unit.as_str()) {
        ("change", "1") => {
            let [value, sd] = [value.value, value.sd].map(|own| fixed(100.0 * own, 1));
            format!("{value} \u{B1} {sd}\u{A0}%")
        }
        _ => amount(value),
    };
    let at = effect.since.as_ref().map_or_else(String::new, |at| format!(" ({})", at.replace(' ', "\u{A0}")));
    let when = onset.map_or_else(String::new, |(name, amount)| format!("{}{at}", since(name, amount)));
    let level: String = effect.amplitudes.iter().filter_map(|(name, value)| level(name, value)).collect();
    let about = effect.reference_k.map_or_else(String::new, |reference_k| {
        format!(" (reference temperature {}\u{A0}\u{B0}C)", fixed(reference_k - CELSIUS_ZERO_K, 0))
    });
    Some((name.clone(), format!("{size}{about}{level}{when}")))
}

/// The same at a time in a record.
pub(in crate::report::section) fn since_s(seconds: f64) -> String {
    format!(", from {} on", time(seconds))
}

/// The same so long after every start.
pub(in crate::report::section) fn since_start_s(seconds: f64) -> String {
    format!(", from {} after each start on", time(seconds))
}

/// Whether a parameter says when an effect sets in.
pub(super) fn is_onset(name: &str) -> bool {
    ["date", "elapsed"].contains(&name)
}

/// At which value of an input or a node an effect acts, after a comma; `None` of a parameter that does not say it.
pub(super) fn level(name: &str, value: &Amount) -> Option<String> {
    let level = value.level.as_ref()?;
    let shown = match level.is_temperature {
        true => Amount { value: value.value - CELSIUS_ZERO_K, unit: "degC".to_owned(), ..value.clone() },
        false => value.clone(),
    };
    Some(format!(", {name} at {} = {}", level.of, amount(&shown)))
}

/// From when on an effect is there, with its error, after a comma.
pub(super) fn onset(name: &str, when: &Amount) -> String {
    match (name, when.unit.as_str()) {
        ("elapsed", _) => format!(", from {} after each start on", amount(&as_time(when))),
        (_, "1") if when.sd >= LEAST_PHASES => {
            format!(", from phase {} \u{B1} {} on", fixed(when.value.ceil(), 0), fixed(when.sd.ceil(), 0))
        }
        (_, "1") => since(name, when),
        _ => format!(", from {} on", amount(&as_time(when))),
    }
}

/// A time with its error in the unit that suits it.
fn as_time(when: &Amount) -> Amount {
    if when.unit != "s" {
        return when.clone();
    }
    let (length, unit) = unit_of_time(when.value);
    Amount { value: when.value / length, sd: when.sd / length, unit: unit.to_owned(), ..when.clone() }
}

/// A time in the unit that suits it.
fn time(seconds: f64) -> String {
    let (length, unit) = unit_of_time(seconds);
    format!(
        "{}\u{A0}{unit}",
        fixed(
            seconds / length,
            match unit {
                "s" => 0,
                "min" => 1,
                _ => 2,
            }
        )
    )
}

/// From when on an effect is there: the number of a phase, the time in a record, or that after every start.
fn since(name: &str, when: &Amount) -> String {
    match (name, when.unit.as_str()) {
        ("elapsed", "s") => since_start_s(when.value),
        ("elapsed", _) => format!(", from {} after each start on", amount(when)),
        (_, "s") => since_s(when.value),
        (_, "1") => format!(", from phase {} on", fixed(when.value.ceil(), 0)),
        _ => format!(", from {} on", amount(when)),
    }
}

/// What a verdict means by which something is missing that no effect explains.
pub(in crate::report) fn unexplained(output: &Output) -> &'static str {
    if output.only_small_errors {
        "the model errs by more than the instruments' noise, but the tests find nothing definite: small errors everywhere may be all there is."
    } else {
        "something is missing, and nothing in the catalogue explains it."
    }
}
