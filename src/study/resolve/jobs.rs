//! Jobs: settings with their defaults, names looked up.

use crate::document::prior::support;
use crate::document::{Amount, Diagnostic, Map, MapEntry, NameOr, Node, Place, Sense, Spanned, Value, code, counted};
use crate::effect::Catalogue;
use crate::expression::Dimension;
use crate::inference::measurement::Measurement;
use crate::job::compare::{self, Criteria};
use crate::job::conventional::{self, Rule};
use crate::job::propagate::{self, Sampling, Sweep, Variable};
use crate::job::requirement::{Environment, Requirement};
use crate::random::Distribution;
use crate::study::model::Scale;
use crate::study::pass::job::{
    CompareForm, ConventionalForm, JobForm, PropagateForm, RangeForm, SamplingForm, SweepForm,
};
use crate::study::profile;
use crate::study::resolved::{HandedOnPrior, JobSpec, NamedJob};

use super::chosen::data;
use super::handed_on::Upstreams;
use super::scope::Scope;

/// Samples where a job says nothing.
const SAMPLES: u64 = 4096;
/// Most samples of a job.
const MOST_SAMPLES: u64 = 1 << 30;
/// Largest share of failed samples where a job says nothing.
const FAILURE_LIMIT: f64 = 0.01;
/// Most values of a sweep.
const MOST_STEPS: usize = 10_000;
/// Name of the environment and of the parameters' state where nothing else is said.
const NOMINAL: &str = "nominal";

/// What jobs of a pass can name.
pub struct Offered<'a> {
    /// File of the pass within the study.
    pub file: &'a str,
    /// The priors, SI.
    pub priors: &'a [Distribution],
    /// Draws that stand in for some of them.
    pub handed_on: &'a [HandedOnPrior],
    /// Requirements.
    pub requirements: &'a [Requirement],
    /// Environments.
    pub environments: &'a [Environment],
    /// Measurements by name, with their position in the list; `None` where pinned data are missing.
    pub measurements: &'a [(String, Option<usize>)],
    /// The measurements that are there.
    pub data: &'a [Measurement],
    /// Inputs whose range is that of the data.
    pub ranges_from_data: &'a [String],
    /// Margin rules.
    pub rules: &'a [Rule],
    /// Criteria profiles.
    pub profiles: &'a [Criteria],
    /// Ranges of design variables.
    pub design: &'a Map<RangeForm>,
    /// Number of quantities that have names of their own.
    pub named_quantities: usize,
    /// Physical effects.
    pub catalogue: &'a Catalogue,
    /// The command that brings missing data.
    pub command: String,
}

/// Resolves the jobs in the order of the file.
pub(super) fn jobs(
    scope: &mut Scope,
    forms: &Map<JobForm>,
    offered: &Offered,
    upstreams: &mut Upstreams,
) -> Vec<NamedJob> {
    let mut specs: Vec<Option<JobSpec>> = Vec::new();
    for entry in forms {
        specs.push(match &entry.value {
            JobForm::Propagate(form) => propagate(scope, form, offered).map(JobSpec::Propagate),
            JobForm::Conventional(form) => conventional(scope, entry, form, offered).map(JobSpec::Conventional),
            JobForm::Compare(form) => compare(scope, entry, form, forms, offered),
            JobForm::Diagnose(form) => super::diagnose::diagnose(scope, entry, form, offered),
            JobForm::Calibrate(form) => super::calibrate::calibrate(scope, entry, form, offered),
            // After the calibrations of the pass, wherever these stand.
            JobForm::Predict(_) => None,
            JobForm::Sensitivity(form) => {
                super::sensitivity::sensitivity(scope, form, offered).map(JobSpec::Sensitivity)
            }
            JobForm::Goal(form) => super::goal::goal(scope, entry, form, offered).map(JobSpec::Goal),
            JobForm::Design(form) => super::design::design(scope, entry, form, offered).map(JobSpec::Design),
            JobForm::Discrepancy(settings) => not_yet(scope, entry.value.kind(), settings, offered),
        });
    }
    let named = |specs: &[Option<JobSpec>]| -> Vec<NamedJob> {
        let all = forms.iter().zip(specs);
        all.filter_map(|(entry, spec)| {
            Some(NamedJob { name: entry.name.clone(), place: entry.name_place.clone(), spec: spec.clone()? })
        })
        .collect()
    };
    let known = named(&specs);
    for (entry, spec) in forms.iter().zip(&mut specs) {
        if let JobForm::Predict(form) = &entry.value {
            *spec = super::predict::predict(scope, entry, form, offered, upstreams, (&known, forms));
        }
    }
    named(&specs)
}

/// The comparison at nominal parameters that a pass with measurements gets though no job asks for one; `place` is that of
/// the measurements.
pub fn implied_comparison(jobs: &[NamedJob], offered: &Offered, place: Option<&Place>) -> Option<NamedJob> {
    const NAME: &str = "comparison";
    let data: Vec<usize> = offered.measurements.iter().filter_map(|(_, position)| *position).collect();
    let asked = jobs.iter().any(|job| job.spec.kind() == "compare" || job.name == NAME);
    if asked || data.is_empty() {
        return None;
    }
    let criteria = offered.profiles.iter().find(|profile| profile.name == profile::DEFAULT)?.clone();
    let spec = JobSpec::Compare(compare::Spec { data, criteria, from: NOMINAL.to_owned(), calibration: None });
    Some(NamedJob { name: NAME.to_owned(), place: place?.clone(), spec })
}

/// A job that this version does not run: its settings are an object, the measurements that it names exist.
fn not_yet(scope: &mut Scope, kind: &'static str, settings: &Node, offered: &Offered) -> Option<JobSpec> {
    if !matches!(settings.value, Value::Object(_)) {
        return crate::document::written::wrong_type(settings, "an object of settings", scope.diagnostics);
    }
    if let Some(Node { value: Value::Array(items), .. }) = settings.get("data") {
        for item in items {
            if let Value::String(name) = &item.value {
                measurement(scope, name, &item.place, offered);
            }
        }
    }
    let reason = format!("this version does not run `{kind}` jobs");
    Some(JobSpec::NotYet { kind, settings: settings.to_json(), reason })
}

pub(super) fn measurement(scope: &mut Scope, name: &str, place: &Place, offered: &Offered) -> Option<Option<usize>> {
    let found = offered.measurements.iter().find(|(known, _)| known == name).map(|(_, position)| *position);
    if found.is_none() {
        let known: Vec<&str> = offered.measurements.iter().map(|(known, _)| known.as_str()).collect();
        scope.unknown(&code::JOB_REFERENCE, "measurement", name, place, &known);
    }
    found
}

pub(super) fn environments(
    scope: &mut Scope,
    names: Option<&Vec<Spanned<String>>>,
    offered: &Offered,
) -> Vec<Environment> {
    let nominal = || Environment { name: NOMINAL.to_owned(), inputs: scope.nominal_inputs() };
    let Some(names) = names.filter(|names| !names.is_empty()) else {
        return if offered.environments.is_empty() { vec![nominal()] } else { offered.environments.to_vec() };
    };
    let mut list = Vec::new();
    for name in names {
        match offered.environments.iter().find(|environment| environment.name == name.value) {
            Some(environment) => list.push(environment.clone()),
            None if name.value == NOMINAL => {
                list.push(Environment { name: NOMINAL.to_owned(), inputs: scope.nominal_inputs() });
            }
            None => {
                let mut known: Vec<&str> = offered.environments.iter().map(|known| known.name.as_str()).collect();
                known.push(NOMINAL);
                scope.unknown(&code::JOB_REFERENCE, "environment", &name.value, &name.place, &known);
            }
        }
    }
    list
}

pub(super) fn requirements(
    scope: &mut Scope,
    names: Option<&Vec<Spanned<String>>>,
    offered: &Offered,
) -> Vec<Requirement> {
    let Some(names) = names else { return offered.requirements.to_vec() };
    let mut list = Vec::new();
    for name in names {
        match offered.requirements.iter().find(|requirement| requirement.name == name.value) {
            Some(requirement) => list.push(requirement.clone()),
            None => {
                let known: Vec<&str> = offered.requirements.iter().map(|known| known.name.as_str()).collect();
                scope.unknown(&code::JOB_REFERENCE, "requirement", &name.value, &name.place, &known);
            }
        }
    }
    list
}

pub(super) fn propagate(scope: &mut Scope, form: &PropagateForm, offered: &Offered) -> Option<propagate::Spec> {
    let before = scope.diagnostics.errors();
    let environments = environments(scope, form.environments.as_ref(), offered);
    let requirements = requirements(scope, form.requirements.as_ref(), offered);
    let mut quantities = quantities(scope, form.quantities.as_ref(), &requirements, offered);
    let mut joint = Vec::new();
    for pair in &form.joint {
        let (x, y) = (scope.quantity(&pair[0]), scope.quantity(&pair[1]));
        if let (Some(x), Some(y)) = (x, y) {
            push_new(&mut quantities, x);
            push_new(&mut quantities, y);
            let position = |index: usize| quantities.iter().position(|other| *other == index).unwrap_or(0);
            joint.push([position(x), position(y)]);
        }
    }
    let sampling = match form.sampling {
        None | Some(SamplingForm::Sobol) => Sampling::Sobol,
        Some(SamplingForm::LatinHypercube) => Sampling::LatinHypercube,
        Some(SamplingForm::MonteCarlo) => Sampling::MonteCarlo,
    };
    let samples = samples(scope, form.samples.as_ref(), sampling);
    let failure_limit = failure_limit(scope, form.failure_limit.as_ref());
    let sweep = form.sweep.as_ref().and_then(|form| sweep(scope, form));
    let spec =
        propagate::Spec { quantities, samples, sampling, environments, sweep, joint, requirements, failure_limit };
    (scope.diagnostics.errors() == before).then_some(spec)
}

/// The quantities asked for, those of the requirements among them; all named ones where there are neither, else all nodes.
pub(super) fn quantities(
    scope: &mut Scope,
    names: Option<&Vec<Spanned<String>>>,
    requirements: &[Requirement],
    offered: &Offered,
) -> Vec<usize> {
    let mut quantities: Vec<usize> = Vec::new();
    match names {
        Some(names) => {
            for name in names {
                if let Some(index) = scope.quantity(name) {
                    push_new(&mut quantities, index);
                }
            }
        }
        None if requirements.is_empty() && offered.named_quantities > 0 => {
            quantities.extend(0..offered.named_quantities)
        }
        None if requirements.is_empty() => {
            for node in 0..scope.resolved.model.nodes.len() {
                let index = scope.node_quantity(node);
                push_new(&mut quantities, index);
            }
        }
        None => {}
    }
    for requirement in requirements {
        push_new(&mut quantities, requirement.quantity);
    }
    quantities
}

pub(super) fn push_new(list: &mut Vec<usize>, index: usize) {
    if !list.contains(&index) {
        list.push(index);
    }
}

/// The largest share of failed solves that is tolerated.
pub(super) fn failure_limit(scope: &mut Scope, written: Option<&Spanned<f64>>) -> f64 {
    let Some(limit) = written else { return FAILURE_LIMIT };
    if !(0.0..=1.0).contains(&limit.value) {
        let message = format!("a failure limit of {}", limit.value);
        scope.error(&code::JOB_SETTING, &limit.place, message, "a share from 0 to 1");
    }
    limit.value
}

/// The number of samples; Sobol points are rounded up to a power of two, with a warning.
pub(super) fn samples(scope: &mut Scope, written: Option<&Spanned<u64>>, sampling: Sampling) -> u64 {
    let Some(Spanned { value, place }) = written else { return SAMPLES };
    if !(2..=MOST_SAMPLES).contains(value) {
        let expected = format!("an integer from 2 to {MOST_SAMPLES}");
        scope.error(&code::JOB_SETTING, place, counted(*value, "sample"), &expected);
        return SAMPLES;
    }
    let rounded = value.next_power_of_two();
    if sampling == Sampling::Sobol && rounded != *value {
        let message = format!("{value} Sobol points are rounded up to {rounded}");
        scope
            .diagnostics
            .push(Diagnostic::warning(&code::ROUNDED_SAMPLES, place, message).help("write a power of two"));
        return rounded;
    }
    *value
}

/// A design variable's values in SI; bare numbers are in its own unit.
fn value(scope: &mut Scope, amount: &Amount, scale: &Scale) -> Option<f64> {
    scale.si(amount, Sense::Absolute, scope.diagnostics)
}

/// Equally spaced values, both ends exact; at least two.
pub(super) fn spaced(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = (count - 1) as f64;
    (0..count)
        .map(|index| {
            let share = index as f64 / last;
            from * (1.0 - share) + to * share
        })
        .collect()
}

fn sweep(scope: &mut Scope, form: &Spanned<Map<SweepForm>>) -> Option<Sweep> {
    let entry = match form.value.iter().collect::<Vec<_>>().as_slice() {
        [one] => *one,
        several => {
            let message = format!("a sweep of {} variables", several.len());
            scope.error(&code::SWEEP, &form.place, message, "exactly one parameter or input");
            return None;
        }
    };
    let (variable, scale) = scope.variable(&entry.name, &entry.name_place)?;
    let values: Vec<f64> = match &entry.value {
        SweepForm::List(list) => {
            let values: Vec<Option<f64>> = list.iter().map(|amount| value(scope, amount, &scale)).collect();
            values.into_iter().collect::<Option<_>>()?
        }
        SweepForm::Steps(steps) => {
            let (from, to) = (value(scope, &steps.from, &scale)?, value(scope, &steps.to, &scale)?);
            let count = steps.steps.value;
            if !(2..=MOST_STEPS).contains(&count) {
                let message = format!("a sweep of {}", counted(count, "step"));
                scope.error(&code::SWEEP, &steps.steps.place, message, &format!("from 2 to {MOST_STEPS} values"));
                return None;
            }
            spaced(from, to, count)
        }
    };
    let rises = values.windows(2).all(|pair| pair[0] < pair[1]);
    let falls = values.windows(2).all(|pair| pair[0] > pair[1]);
    if values.is_empty() || values.len() > MOST_STEPS || !(rises || falls) {
        scope.error(
            &code::SWEEP,
            &entry.place,
            "the values of a sweep are not in order",
            "at least one value, each above the one before, or each below it",
        );
        return None;
    }
    Some(Sweep { name: entry.name.clone(), unit: scale.text().to_owned(), variable, values })
}

fn conventional(
    scope: &mut Scope,
    entry: &MapEntry<JobForm>,
    form: &ConventionalForm,
    offered: &Offered,
) -> Option<conventional::Spec> {
    let before = scope.diagnostics.errors();
    let rules = match &form.rules {
        None => offered.rules.to_vec(),
        Some(names) => {
            let mut rules = Vec::new();
            for name in names {
                match offered.rules.iter().find(|rule| rule.name == name.value) {
                    Some(rule) => rules.push(rule.clone()),
                    None => {
                        let known: Vec<&str> = offered.rules.iter().map(|rule| rule.name.as_str()).collect();
                        scope.unknown(&code::JOB_REFERENCE, "margin rule", &name.value, &name.place, &known);
                    }
                }
            }
            rules
        }
    };
    let environments = environments(scope, form.environments.as_ref(), offered);
    let requirements = requirements(scope, form.requirements.as_ref(), offered);
    if requirements.is_empty() && !scope.diagnostics.has_errors() {
        let message = format!("`{}` has no requirement to size for", entry.name);
        scope.error(&code::JOB_REFERENCE, &entry.name_place, message, "at least one entry under `requirements`");
    }
    let design = design_variable(scope, entry, form.design_variable.as_ref(), offered);
    let heat_loads = heat_loads(scope, form.heat_loads.as_ref(), design.as_ref().map(|design| design.variable));
    let design = design?;
    let spec = conventional::Spec { rules, environments, requirements, design, heat_loads };
    (scope.diagnostics.errors() == before).then_some(spec)
}

/// What is sized, with the ends of its range.
pub(super) fn design_variable(
    scope: &mut Scope,
    entry: &MapEntry<JobForm>,
    written: Option<&NameOr<Spanned<Map<RangeForm>>>>,
    offered: &Offered,
) -> Option<Sweep> {
    match written {
        Some(NameOr::Other(map)) => match map.value.iter().collect::<Vec<_>>().as_slice() {
            [one] => design_range(scope, one),
            several => {
                let message = format!("{} design variables", several.len());
                scope.error(&code::SWEEP, &map.place, message, "exactly one parameter or input");
                None
            }
        },
        Some(NameOr::Name(name)) => match offered.design.get(&name.value) {
            Some(range) => design_range(scope, range),
            None => known_range(scope, name, offered),
        },
        None => match offered.design.iter().collect::<Vec<_>>().as_slice() {
            [one] => design_range(scope, one),
            several => {
                let message = format!("`{}` names no design variable, and the pass has {}", entry.name, several.len());
                let expected = "\"design_variable\": {NAME: {\"from\": ..., \"to\": ...}}";
                scope.error(&code::SWEEP, &entry.name_place, message, expected);
                None
            }
        },
    }
}

fn design_range(scope: &mut Scope, entry: &MapEntry<RangeForm>) -> Option<Sweep> {
    let (variable, scale) = scope.variable(&entry.name, &entry.name_place)?;
    let from = value(scope, &entry.value.from, &scale);
    let to = value(scope, &entry.value.to, &scale);
    let (from, to) = (from?, to?);
    if from == to || !from.is_finite() || !to.is_finite() {
        let message = format!("the range of `{}` is empty", entry.name);
        scope.error(&code::SWEEP, &entry.place, message, "two values; rules pass towards `to`");
        return None;
    }
    Some(Sweep { name: entry.name.clone(), unit: scale.text().to_owned(), variable, values: vec![from, to] })
}

/// The range of an input, or of a bounded prior.
fn known_range(scope: &mut Scope, name: &Spanned<String>, offered: &Offered) -> Option<Sweep> {
    let (variable, scale) = scope.variable(&name.value, &name.place)?;
    let range = match variable {
        Variable::Input(index) => scope.resolved.model.inputs[index].range,
        Variable::Parameter(index) => Some(support(&offered.priors[index])),
    };
    match range.filter(|[from, to]| from < to && from.is_finite() && to.is_finite()) {
        Some(range) => {
            Some(Sweep { name: name.value.clone(), unit: scale.text().to_owned(), variable, values: range.to_vec() })
        }
        None => {
            let message = format!("no range is known in which `{}` could be sought", name.value);
            let expected = format!("{{\"{}\": {{\"from\": ..., \"to\": ...}}}}", name.value);
            scope.error(&code::SWEEP, &name.place, message, &expected);
            None
        }
    }
}

/// The parameters and inputs that are heat loads: those named, else all in W but the design variable.
fn heat_loads(scope: &mut Scope, names: Option<&Vec<Spanned<String>>>, design: Option<Variable>) -> Vec<Variable> {
    if let Some(names) = names {
        return names.iter().filter_map(|name| Some(scope.variable(&name.value, &name.place)?.0)).collect();
    }
    let is_power = |scale: &Scale| scale.dimension() == Some(Dimension::POWER);
    let parameters = scope.resolved.parameter_scales.iter().enumerate().filter(|(_, scale)| is_power(scale));
    let inputs = scope.resolved.input_scales.iter().enumerate().filter(|(_, scale)| is_power(scale));
    let parameters = parameters.map(|(index, _)| Variable::Parameter(index));
    parameters.chain(inputs.map(|(index, _)| Variable::Input(index))).filter(|load| Some(*load) != design).collect()
}

fn compare(
    scope: &mut Scope,
    entry: &MapEntry<JobForm>,
    form: &CompareForm,
    forms: &Map<JobForm>,
    offered: &Offered,
) -> Option<JobSpec> {
    let before = scope.diagnostics.errors();
    let (data, missing) = data(scope, entry, form.data.as_ref(), "compare with", offered);
    let name = form.criteria.as_ref().map_or(profile::DEFAULT, |name| name.value.as_str());
    let criteria = offered.profiles.iter().find(|profile| profile.name == name).cloned();
    if let (None, Some(written)) = (&criteria, &form.criteria) {
        let known: Vec<&str> = offered.profiles.iter().map(|profile| profile.name.as_str()).collect();
        scope.unknown(&code::JOB_REFERENCE, "criteria profile", name, &written.place, &known);
    }
    let kind = "compare";
    let mut calibration = None;
    if let Some(from) = form.from.as_ref().filter(|from| from.value != NOMINAL) {
        match forms.get(&from.value).map(|job| &job.value) {
            Some(JobForm::Calibrate(_)) => calibration = Some(&from.value),
            Some(other) => {
                let message = format!("`{}` is a `{}` job", from.value, other.kind());
                scope.error(&code::JOB_REFERENCE, &from.place, message, "`nominal`, or a `calibrate` job");
            }
            None => {
                let calibrations = forms.iter().filter(|job| matches!(job.value, JobForm::Calibrate(_)));
                let mut known = vec![NOMINAL];
                known.extend(calibrations.map(|job| job.name.as_str()));
                scope.unknown(&code::JOB_REFERENCE, "state of the parameters", &from.value, &from.place, &known);
            }
        }
    }
    if scope.diagnostics.errors() > before {
        return None;
    }
    if !missing.is_empty() {
        return Some(JobSpec::Waiting { kind, measurements: missing, command: offered.command.clone() });
    }
    let calibration = calibration.cloned();
    Some(JobSpec::Compare(compare::Spec { data, criteria: criteria?, from: NOMINAL.to_owned(), calibration }))
}
