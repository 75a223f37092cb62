//! What of a pass's diagnoses can be adopted by one command, as a page offers it.

use serde::Deserialize;

use crate::batch::{Executed, LoadedPass};
use crate::diagnosis::output::EffectResult;
use crate::diagnosis::{Output, PRIOR_OF};
use crate::document::visible::shell_word;
use crate::study::resolve::of_sensors;

use super::acting::{Acting, acts_in};
use super::entry::probability_text;

/// Effects offered of one diagnosis.
const MOST_OFFERED: usize = 6;

/// Effects that a command adopts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Offer {
    /// The diagnosis.
    pub job: String,
    /// Ids that the command names; none where it adopts what the diagnosis selected.
    pub effects: Vec<String>,
    /// The effects in words.
    pub title: String,
    /// How probable they are.
    pub probability: String,
    /// The command.
    pub command: String,
    /// Where the effects act unless they belong to the test alone, in a sentence; empty where they act on no model.
    pub acts: String,
}

/// The diagnosis of this name among the results of a pass.
pub fn diagnosis(pass: &LoadedPass, executed: &Executed, job: &str) -> Option<Output> {
    let is_it = |position: usize| {
        let node = &executed.plan.nodes()[position];
        node.name == job && node.task.kind() == "diagnose"
    };
    let (_, finished) = executed.results(pass).find(|(position, _)| is_it(*position))?;
    Output::deserialize(&*finished.stored.value).ok()
}

/// What the diagnoses of a pass let adopt: the selected set where the verdict settles it, else what of it is settled, and each
/// other supported effect by its name.
pub fn offers(pass: &LoadedPass, executed: &Executed) -> Vec<Offer> {
    let jobs = pass.pass.jobs.iter().filter(|job| job.spec.kind() == "diagnose");
    let mut offers = Vec::new();
    for (place, job) in jobs.enumerate() {
        let Some(output) = diagnosis(pass, executed, &job.name) else { continue };
        // The first diagnosis of a pass needs no name.
        let of_job = if place == 0 { String::new() } else { format!(" --job {}", shell_word(&job.name)) };
        let base = format!("bmv adopt {}{of_job}", shell_word(&pass.shown));
        let offer = |effects: &[&EffectResult], are_named: bool| {
            let on_model = effects.iter().any(|effect| acts_on_model(pass, effect));
            let acts =
                on_model.then(|| acts_in(&pass.pass, &Acting::Everywhere, effects.len() == 1).0.replace('`', ""));
            let ids: Vec<String> = effects.iter().filter(|_| are_named).map(|effect| effect.id.clone()).collect();
            let words: String = ids.iter().map(|id| format!(" {}", shell_word(id))).collect();
            Offer {
                job: job.name.clone(),
                title: effects.iter().map(|effect| in_words(&output, effect)).collect::<Vec<_>>().join("; "),
                probability: output.odds(effects).map(probability_text).unwrap_or_default(),
                command: format!("{base}{words}"),
                effects: ids,
                acts: acts.unwrap_or_default(),
            }
        };
        let selected: Vec<&EffectResult> = output.selected.iter().filter_map(|id| output.effect(id)).collect();
        if output.verdict.names_one_set() && !selected.is_empty() {
            offers.push(offer(&selected, false));
        } else {
            let settled = output.settled();
            let is_settled = |effect: &EffectResult| settled.iter().any(|one| one.id == effect.id);
            if !settled.is_empty() {
                offers.push(offer(&settled, true));
            }
            let open = output.effects.iter().filter(|effect| output.supports(effect) && !is_settled(effect));
            offers.extend(open.take(MOST_OFFERED).map(|effect| offer(&[effect], true)));
        }
    }
    offers
}

/// Whether an effect changes the model, not a sensor or a prior alone.
fn acts_on_model(pass: &LoadedPass, effect: &EffectResult) -> bool {
    effect.effect != PRIOR_OF && pass.pass.catalogue.get(&effect.effect).is_none_or(|own| !of_sensors(own))
}

/// An effect with its place; where it is one law of what is settled, that comes first.
fn in_words(output: &Output, effect: &EffectResult) -> String {
    let own = match effect.place.as_slice() {
        [] => effect.title.clone(),
        places => format!("{}: {}", effect.title, places.join(", ")),
    };
    let kind = output.settled_kind_of(effect).filter(|_| output.confused_with(effect).next().is_some());
    kind.map_or_else(|| own.clone(), |kind| format!("{}, as {own}", kind.what.replace('`', "")))
}
