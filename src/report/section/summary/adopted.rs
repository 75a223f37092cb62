//! Adopted effects on the first screen: which of them act in predictions, how sure the choice was and how large they are.

use crate::expression::Unit;
use crate::job::calibrate::{self, ParameterSummary};
use crate::report::number::{self, fixed, significant, with_error, with_unit};
use crate::report::page::{Block, Statement, Status, Text, Tone};
use crate::report::section::diagnosis::{chance, since_s, since_start_s};
use crate::report::view::PassReport;
use crate::study::AdoptedEffect;
use crate::thermal::Parameter;

/// Effects that are named one by one.
const MOST_EFFECTS: usize = 3;
/// Probability below which an effect is a choice among others.
const SURE: f64 = 0.95;
/// Standard deviations between an adopted and a calibrated size from which that is remarked on.
const APART: f64 = 3.0;

/// The size of an effect: that of its first parameter, and what that is called in the effect.
struct Size {
    text: String,
    parameter: String,
    value: f64,
    sd: Option<f64>,
}

/// The parameter of an effect that tells its size: its first, of a node its coupling.
fn parameter<'r>(report: &'r PassReport<'_>, effect: &AdoptedEffect) -> Option<&'r Parameter> {
    let own = || effect.parameters.clone().filter_map(|index| report.model.parameters.get(index));
    let is_coupling = |parameter: &&Parameter| parameter.name.ends_with(".conductance");
    own().find(|parameter| effect.effect.contains("hidden-node") && is_coupling(parameter)).or_else(|| own().next())
}

/// The size with which an effect was adopted: its nominal value, with the error that the diagnosis stated.
fn adopted_size(report: &PassReport<'_>, effect: &AdoptedEffect) -> Option<Size> {
    let parameter = parameter(report, effect)?;
    let own = parameter.name.strip_prefix(effect.name.as_str())?.trim_start_matches('.');
    let value = Unit::parse(&parameter.unit).ok()?.from_si(parameter.nominal);
    let sd = effect.evidence.iter().flat_map(|evidence| &evidence.sd).find(|(name, _)| name == own);
    let sd = sd.map(|(_, sd)| *sd);
    Some(Size { text: stated(own, &parameter.unit, value, sd), parameter: own.replace('_', " "), value, sd })
}

/// A size in words: a relative change as a share.
fn stated(parameter: &str, unit: &str, value: f64, sd: Option<f64>) -> String {
    let (scale, unit) = match (parameter, unit) {
        ("change", "1") => (100.0, "%".to_owned()),
        _ => number::stated(unit, sd.unwrap_or(0.0).max(value.abs())),
    };
    let text = sd.map_or_else(|| significant(scale * value, 4), |sd| with_error(scale * value, scale * sd));
    with_unit(&text, &unit)
}

/// The calibrated size of an effect, and from when on it is there: a time in the record, or that into every run.
fn calibrated_size(report: &PassReport<'_>, effect: &AdoptedEffect, summary: &ParameterSummary) -> String {
    let prefix = format!("{}.", effect.name);
    let own = parameter(report, effect).and_then(|parameter| parameter.name.strip_prefix(&prefix)).unwrap_or_default();
    let size = stated(own, &summary.unit, summary.mean, Some(summary.sd));
    let of_calibrations = |name: &str| {
        let mut outputs = report.outputs::<calibrate::Kind>();
        outputs.find_map(|(_, output)| output.parameters.get(&format!("{prefix}{name}")).filter(|own| own.unit == "s"))
    };
    let date = of_calibrations("date").map(|own| since_s(own.mean));
    let since = date.or_else(|| of_calibrations("elapsed").map(|own| since_start_s(own.mean))).unwrap_or_default();
    format!("{size}{since}")
}

/// Its posterior, where a calibration of the pass has it.
fn calibrated<'r>(report: &'r PassReport<'_>, effect: &AdoptedEffect) -> Option<(&'r str, &'r ParameterSummary)> {
    let name = &parameter(report, effect)?.name;
    report
        .outputs::<calibrate::Kind>()
        .find_map(|(job, output)| Some((job, output.parameters.get(name).filter(|_| output.converged)?)))
}

/// How sure the choice was, as the diagnosis that proposed the effect stated it, and of which pass that was.
fn how_sure(effect: &AdoptedEffect) -> Option<String> {
    let evidence = effect.evidence.as_ref()?;
    let probability = evidence.probability?;
    let stated = chance(probability);
    let what = if probability < SURE { "a choice at" } else { "probability" };
    Some(format!("{what} {stated} in {}", evidence.pass))
}

fn names<'n>(mut text: Text, names: impl Iterator<Item = &'n str>) -> Text {
    for (position, name) in names.enumerate() {
        text = text.plain(if position == 0 { "" } else { ", " }).code(name);
    }
    text
}

/// Which adopted effects act in the predictions of the pass; nothing where it has no environment to predict in, or adopts
/// nothing that acts there.
pub(super) fn in_predictions(report: &PassReport<'_>) -> Option<Block> {
    let of_model: Vec<&AdoptedEffect> = report.adopted.iter().filter(|effect| !effect.is_of_readings).collect();
    let environments = || report.environments.iter().map(|environment| environment.name.as_str());
    if of_model.is_empty() || environments().next().is_none() {
        return None;
    }
    let acting: Vec<&AdoptedEffect> =
        of_model.iter().copied().filter(|effect| environments().any(|name| effect.acts_in(name))).collect();
    if acting.is_empty() {
        let text =
            names(Text::new("Of the test alone, in no prediction: "), of_model.iter().map(|own| own.name.as_str()));
        return Some(Block::callout(Tone::Note, text.plain(".")));
    }
    let mut text = Text::new(if acting.len() == 1 {
        "An adopted effect acts in predictions too ("
    } else {
        "Adopted effects act in predictions too ("
    });
    text = names(text, environments().filter(|name| acting.iter().any(|own| own.acts_in(name)))).plain("): ");
    for (position, effect) in acting.iter().take(MOST_EFFECTS).enumerate() {
        text = text.plain(if position == 0 { "" } else { "; " }).code(&effect.name);
        // What the diagnosis of an earlier pass fitted is past where this pass has calibrated it.
        let calibrated = calibrated(report, effect).map(|(_, summary)| calibrated_size(report, effect, summary));
        let calibrated = calibrated.map(|size| format!("{size} as calibrated"));
        let size = calibrated.or_else(|| adopted_size(report, effect).map(|size| size.text));
        let about: Vec<String> = how_sure(effect).into_iter().chain(size).collect();
        if !about.is_empty() {
            text = text.plain(format!(", {}", about.join(", ")));
        }
    }
    let more = acting.len().saturating_sub(MOST_EFFECTS);
    text = text.plain(if more > 0 { format!("; {more} more. ") } else { ". ".to_owned() });
    text = text.plain("What belongs to the test alone is kept out of them by ").code("applies_to").plain(".");
    let is_open = acting.iter().any(|own| own.evidence.as_ref().and_then(|e| e.probability).is_some_and(|p| p < SURE));
    Some(Block::callout(if is_open { Tone::Warning } else { Tone::Note }, text))
}

/// What the calibrations of a pass measured of its adopted effects.
pub(super) fn sizes(report: &PassReport<'_>) -> Vec<Statement> {
    let one = |effect: &AdoptedEffect| {
        let (_, summary) = calibrated(report, effect)?;
        let adopted = adopted_size(report, effect)?;
        let sure = how_sure(effect).map_or_else(String::new, |sure| format!(", {sure}"));
        let variance = adopted.sd.map_or(0.0, |sd| sd * sd) + summary.sd * summary.sd;
        let apart = (summary.mean - adopted.value).abs() / variance.sqrt();
        let apart = match adopted.sd {
            Some(_) if apart.is_finite() && apart >= APART => format!(
                " They lie {} standard deviations apart: what the model has or lacks beside the effect is not the same in both.",
                fixed(apart, 1)
            ),
            _ => String::new(),
        };
        Some(Statement {
            label: format!("Measured: {}", effect.name),
            value: calibrated_size(report, effect, summary),
            text: format!("{} as calibrated; adopted with {}{sure}.{apart}", adopted.parameter, adopted.text).into(),
            status: (summary.at_bound > super::outcome::PRESSES).then_some(Status::Caution),
        })
    };
    report.adopted.iter().filter_map(one).take(MOST_EFFECTS).collect()
}
