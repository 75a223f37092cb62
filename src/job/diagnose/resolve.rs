//! Diagnoses: settings with their defaults, names looked up.

use super::form::DiagnoseForm;
use super::run::Spec;
use crate::diagnosis::{PRIOR_OF, Settings};
use crate::document::{Place, code};
use crate::study::job::{Entry, JobSpec};
use crate::study::resolve::adopt::own_file;
use crate::study::resolve::chosen::{data, parameters_or_all};
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::{Offered, number};

/// Most effects at once that can be asked for.
const MOST: u64 = 6;
/// Least probability that a kind of effect is missing, or is not.
const LEAST_PROBABILITY: f64 = 1e-9;

/// Resolves the settings of a diagnosis.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &DiagnoseForm, offered: &Offered) -> Option<JobSpec> {
    let before = scope.diagnostics.errors();
    let (data, missing) = data(scope, entry, form.data.as_ref(), "diagnose", offered);
    let parameters = parameters_or_all(scope, form.parameters.as_ref(), offered.priors);
    let defaults = Settings::default();
    let most = number(scope, form.most.as_ref(), defaults.most, 1, MOST, "effects at once");
    let false_alarm = form.false_alarm.as_ref().map_or(defaults.false_alarm, |written| {
        if !(written.value >= 1e-9 && written.value <= 0.5) {
            let message = format!("a probability of a false alarm of {}", written.value);
            scope.error(&code::JOB_SETTING, &written.place, message, "a number from 1e-9 to 0.5");
        }
        written.value
    });
    let named = form.effects.iter().flatten().chain(&form.without).map(|name| (name.value.as_str(), &name.place));
    check(
        scope,
        named.chain(form.missing_probability.iter().map(|missing| (missing.name.as_str(), &missing.name_place))),
        offered,
    );
    for missing in &form.missing_probability {
        if !(missing.value >= LEAST_PROBABILITY && missing.value <= 1.0 - LEAST_PROBABILITY) {
            let message = format!("a probability of {} that `{}` is missing", missing.value, missing.name);
            let help = "a number from 1e-9 to 0.999999999; what cannot be missing stands under `without`";
            scope.error(&code::JOB_SETTING, &missing.place, message, help);
        }
    }
    if form.effects.as_ref().is_some_and(Vec::is_empty) {
        let expected = "names of effects; without `effects` the whole catalogue is considered";
        scope.error(&code::JOB_SETTING, &entry.place, format!("`{}` considers no effect", entry.name), expected);
    }
    let without = |name: &str| form.without.iter().any(|other| other.value == name);
    let chosen = |name: &&str| match &form.effects {
        Some(names) => names.iter().any(|wanted| wanted.value == **name),
        None => true,
    };
    let kinds = offered.catalogue.names().chain([PRIOR_OF]);
    let effects = kinds.filter(chosen).filter(|name| !without(name)).map(str::to_owned).collect();
    if scope.diagnostics.errors() > before {
        return None;
    }
    let missing_probability =
        form.missing_probability.iter().map(|missing| (missing.name.clone(), missing.value)).collect();
    if !missing.is_empty() {
        let command = offered.command.clone();
        return Some(JobSpec::Waiting { kind: "diagnose", measurements: missing, command });
    }
    Some(JobSpec::of(Spec { data, parameters, effects, settings: Settings { most, false_alarm, missing_probability } }))
}

fn check<'a>(scope: &mut Scope, names: impl Iterator<Item = (&'a str, &'a Place)>, offered: &Offered) {
    for (name, place) in names {
        // What is wrong with a file of the study's own was said at its place.
        let is_own = || scope.folder.has_file(&own_file(name));
        if offered.catalogue.get(name).is_none() && name != PRIOR_OF && !is_own() {
            let effect_names: Vec<&str> = offered.catalogue.names().chain([PRIOR_OF]).collect();
            scope.unknown(&code::UNKNOWN_EFFECT, "effect", name, place, &effect_names);
        }
    }
}
