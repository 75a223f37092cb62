//! Test plans: the design looked up, settings with their defaults.

use super::form::TestPlanForm;
use super::output::{PlannedSensor, Spec};
use crate::document::{Amount, Place, Spanned, code};
use crate::job::design;
use crate::job::kind::JobKind;
use crate::study::job::{Asked, Entry, JobSpec};
use crate::study::profile;
use crate::study::resolve::plausible;
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::number;
use crate::study::resolved::Upstream;

/// Samples behind bands and probabilities where a job says nothing.
const SAMPLES: u64 = 1024;
/// Most of them.
const MOST_SAMPLES: u64 = 1 << 20;
/// Transients where a job says nothing.
const TRANSIENTS: u64 = 32;
/// An hour, s.
const HOUR_S: f64 = 3600.0;

/// Resolves the settings of a test plan.
pub(super) fn resolve(scope: &mut Scope, entry: &Entry, form: &TestPlanForm, asked: &mut Asked) -> Option<JobSpec> {
    let before = scope.diagnostics.errors();
    let offered = asked.offered;
    let name = form.criteria.as_ref().map_or(profile::DEFAULT, |name| name.value.as_str());
    let criteria = offered.profiles.iter().find(|profile| profile.name == name).cloned();
    let place = form.criteria.as_ref().map_or(&entry.name_place, |name| &name.place);
    let rate_k_per_s = criteria.as_ref().and_then(|profile| profile.stabilisation_k_per_s);
    match (&criteria, rate_k_per_s) {
        (None, _) => {
            let names: Vec<&str> = offered.profiles.iter().map(|profile| profile.name.as_str()).collect();
            scope.unknown(&code::JOB_REFERENCE, "criteria profile", name, place, &names);
        }
        (Some(_), None) => {
            let message = format!("the criteria `{name}` do not say when a phase is steady");
            scope.error(&code::JOB_REFERENCE, place, message, "a profile with `stabilisation`, such as `smc-3k`");
        }
        (Some(_), Some(_)) => {}
    }
    let samples = number(scope, form.samples.as_ref(), SAMPLES, 64, MOST_SAMPLES, "samples");
    if let Some(written) = form.samples.as_ref().filter(|written| !written.value.is_power_of_two()) {
        let message = format!("{} samples", written.value);
        scope.error(&code::JOB_SETTING, &written.place, message, "a power of two");
    }
    let transients = number(scope, form.transients.as_ref(), TRANSIENTS, 8, 4096, "transients");
    let hold_s = duration(scope, form.hold.as_ref(), HOUR_S, true);
    let longest_s = duration(scope, form.longest.as_ref(), 72.0 * HOUR_S, false);
    let design = design_job(scope, entry, form.from.as_ref(), asked)?;
    let spec = asked.jobs.iter().find(|job| job.name == design).and_then(|job| job.spec.get::<design::Spec>());
    // One that has errors of its own has been reported.
    let spec = spec?;
    let inputs = spec.candidates.first()?.inputs.clone();
    let mut start = inputs.clone();
    for varied in &spec.varied {
        start[varied.input] = scope.resolved.model.inputs[varied.input].nominal;
    }
    for written in &form.start {
        let Some(input) = scope.known_input(&written.name, &written.name_place) else { continue };
        if let Some(value) = scope.input_value(input, &written.value) {
            start[input] = value;
        }
    }
    plausible::constants(scope, &form.start, &start);
    let sentences = |written: &Option<Vec<Spanned<String>>>| -> Vec<String> {
        written.iter().flatten().map(|sentence| sentence.value.clone()).collect()
    };
    let sensors = spec.sensors.iter().map(|sensor| PlannedSensor {
        name: sensor.name.clone(),
        quantity: sensor.quantity,
        sigma: sensor.sigma,
        bias_sd: sensor.bias.as_ref().map(|bias| bias.sd()),
    });
    let resolved = Spec {
        design: Upstream { file: offered.file.to_owned(), job: design },
        inputs,
        start,
        sensors: sensors.collect(),
        objectives: sentences(&form.objectives),
        success: sentences(&form.success),
        criteria: criteria?,
        rate_k_per_s: rate_k_per_s?,
        hold_s,
        longest_s,
        samples,
        transients,
    };
    (scope.diagnostics.errors() == before).then(|| JobSpec::of(resolved))
}

/// The design of this name, else the pass's only one; reported where there is none.
fn design_job(scope: &mut Scope, entry: &Entry, written: Option<&Spanned<String>>, asked: &Asked) -> Option<String> {
    let kind = design::Kind::NAME;
    let designs = asked.forms.of_kind(kind);
    match (written, designs.as_slice()) {
        (Some(name), designs) if designs.contains(&name.value.as_str()) => Some(name.value.clone()),
        (Some(name), designs) => {
            match asked.forms.kind(&name.value) {
                Some(other) => {
                    let message = format!("`{}` is a `{other}` job", name.value);
                    scope.error(&code::JOB_REFERENCE, &name.place, message, "a `design` job");
                }
                None => scope.unknown(&code::JOB_REFERENCE, "design", &name.value, &name.place, designs),
            }
            None
        }
        (None, [only]) => Some((*only).to_owned()),
        (None, several) => {
            let message =
                format!("`{}` does not say `from` which design, and the pass has {}", entry.name, several.len());
            let expected = match several {
                [] => "a job of kind `design`, which chooses the phases".to_owned(),
                several => format!("\"from\": one of {}", several.join(", ")),
            };
            scope.error(&code::JOB_REFERENCE, &entry.name_place, message, &expected);
            None
        }
    }
}

/// A duration in seconds.
fn duration(scope: &mut Scope, written: Option<&Amount>, otherwise: f64, zero_allowed: bool) -> f64 {
    let Some(written) = written else { return otherwise };
    let place: &Place = &written.place;
    match scope.seconds(written) {
        Some(seconds) if seconds.is_finite() && (seconds > 0.0 || (zero_allowed && seconds == 0.0)) => seconds,
        Some(seconds) => {
            let expected = if zero_allowed { "a duration, 0 or above" } else { "a duration above 0" };
            scope.error(&code::OUT_OF_RANGE, place, format!("a duration of {seconds} s"), expected);
            otherwise
        }
        // It has been reported.
        None => otherwise,
    }
}
