//! Comparisons: settings with their defaults, names looked up; which calibration a comparison shows.

use super::form::CompareForm;
use super::{Kind, Spec};
use crate::document::{Place, code};
use crate::job::kind::{FormOf, JobKind};
use crate::study::job::{CALIBRATION, Entry, Forms, JobSpec, NamedJob};
use crate::study::profile;
use crate::study::resolve::chosen::data;
use crate::study::resolve::scope::Scope;
use crate::study::resolve::settings::{NOMINAL, Offered};

/// Resolves the settings of a comparison.
pub(super) fn resolve(
    scope: &mut Scope,
    entry: &Entry,
    form: &CompareForm,
    forms: &Forms,
    offered: &Offered,
) -> Option<JobSpec> {
    let before = scope.diagnostics.errors();
    let (data, missing) = data(scope, entry, form.data.as_ref(), "compare with", offered);
    let name = form.criteria.as_ref().map_or(profile::DEFAULT, |name| name.value.as_str());
    let criteria = offered.profiles.iter().find(|profile| profile.name == name).cloned();
    if let (None, Some(written)) = (&criteria, &form.criteria) {
        let profile_names: Vec<&str> = offered.profiles.iter().map(|profile| profile.name.as_str()).collect();
        scope.unknown(&code::JOB_REFERENCE, "criteria profile", name, &written.place, &profile_names);
    }
    let mut calibration = None;
    if let Some(from) = form.from.as_ref().filter(|from| from.value != NOMINAL) {
        match forms.kind(&from.value) {
            Some(CALIBRATION) => calibration = Some(&from.value),
            Some(other) => {
                let message = format!("`{}` is a `{other}` job", from.value);
                scope.error(&code::JOB_REFERENCE, &from.place, message, "`nominal`, or a `calibrate` job");
            }
            None => {
                let mut listed_states = vec![NOMINAL];
                listed_states.extend(forms.of_kind(CALIBRATION));
                scope.unknown(
                    &code::JOB_REFERENCE,
                    "state of the parameters",
                    &from.value,
                    &from.place,
                    &listed_states,
                );
            }
        }
    }
    if scope.diagnostics.errors() > before {
        return None;
    }
    if !missing.is_empty() {
        return Some(JobSpec::Waiting { kind: Kind::NAME, measurements: missing, command: offered.command.clone() });
    }
    let calibration = calibration.cloned();
    Some(JobSpec::of(Spec { data, criteria: criteria?, from: NOMINAL.to_owned(), calibration }))
}

/// The comparison at nominal parameters that a pass with measurements gets though no job asks for one; `place` is that of
/// the measurements.
pub(super) fn implied(jobs: &[NamedJob], offered: &Offered, place: Option<&Place>) -> Option<NamedJob> {
    const NAME: &str = "comparison";
    let data: Vec<usize> = offered.measurements.iter().filter_map(|(_, position)| *position).collect();
    let asked = jobs.iter().any(|job| job.spec.kind() == Kind::NAME || job.name == NAME);
    if asked || data.is_empty() {
        return None;
    }
    let criteria = offered.profiles.iter().find(|profile| profile.name == profile::DEFAULT)?.clone();
    let spec = JobSpec::of(Spec { data, criteria, from: NOMINAL.to_owned(), calibration: None });
    Some(NamedJob { name: NAME.to_owned(), place: place?.clone(), spec })
}

/// Lets comparisons that say nothing of `from` show the first calibration whose data they all have.
pub(super) fn show_calibrations(jobs: &mut [NamedJob], forms: &Forms) {
    let calibrations: Vec<(String, Vec<usize>)> = (jobs.iter())
        .filter(|job| job.spec.kind() == CALIBRATION)
        .filter_map(|job| Some((job.name.clone(), job.spec.inference()?.data.to_vec())))
        .collect();
    for job in jobs {
        let Some(spec) = job.spec.get::<Spec>() else { continue };
        let says = forms.get::<FormOf<Kind>>(&job.name).is_some_and(|form| form.0.from.is_some());
        if !says {
            let covering = calibrations.iter().find(|(_, data)| data.iter().all(|index| spec.data.contains(index)));
            job.spec = JobSpec::of(Spec { calibration: covering.map(|(name, _)| name.clone()), ..spec.clone() });
        }
    }
}
