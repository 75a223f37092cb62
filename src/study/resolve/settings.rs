//! What settings of several job kinds have in common: environments, requirements, quantities, numbers of samples.

use crate::document::{Diagnostic, Map, Place, Spanned, code, counted};
use crate::effect::Catalogue;
use crate::measurement::Measurement;
use crate::random::Distribution;
use crate::study::pass::variable::RangeForm;
use crate::study::profile::Criteria;
use crate::study::requirement::{Environment, Requirement};
use crate::study::resolved::PosteriorReference;
use crate::study::rule::Rule;

use super::scope::Scope;

/// Samples where a job says nothing.
const SAMPLES: u64 = 4096;
/// Most samples of a job.
const MOST_SAMPLES: u64 = 1 << 30;
/// Largest share of failed samples where a job says nothing.
const FAILURE_LIMIT: f64 = 0.01;
/// Name of the environment and of the parameters' state where nothing else is said.
pub const NOMINAL: &str = "nominal";

/// What jobs of a pass can name.
pub struct Offered<'a> {
    /// File of the pass within the study.
    pub file: &'a str,
    /// The priors, SI.
    pub priors: &'a [Distribution],
    /// Draws that stand in for some of them.
    pub posterior_priors: &'a [PosteriorReference],
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
    /// Where the model asks for a surrogate, where it does.
    pub surrogate: Option<&'a Place>,
    /// Number of quantities that have names of their own.
    pub named_quantities: usize,
    /// Physical effects.
    pub catalogue: &'a Catalogue,
    /// The command that brings missing data.
    pub command: String,
}

/// Position of a measurement, `None` within where its data are missing; reported where there is none of the name.
pub fn measurement(scope: &mut Scope, name: &str, place: &Place, offered: &Offered) -> Option<Option<usize>> {
    let position = offered
        .measurements
        .iter()
        .find(|(measurement_name, _)| measurement_name == name)
        .map(|(_, position)| *position);
    if position.is_none() {
        let measurement_names: Vec<&str> =
            offered.measurements.iter().map(|(measurement_name, _)| measurement_name.as_str()).collect();
        scope.unknown(&code::JOB_REFERENCE, "measurement", name, place, &measurement_names);
    }
    position
}

/// The environments of these names; all of the pass where none are named, else the nominal one.
pub fn environments(scope: &mut Scope, names: Option<&Vec<Spanned<String>>>, offered: &Offered) -> Vec<Environment> {
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
                let mut environment_names: Vec<&str> =
                    offered.environments.iter().map(|environment| environment.name.as_str()).collect();
                environment_names.push(NOMINAL);
                scope.unknown(&code::JOB_REFERENCE, "environment", &name.value, &name.place, &environment_names);
            }
        }
    }
    list
}

/// The requirements of these names; all of the pass where none are named.
pub fn requirements(scope: &mut Scope, names: Option<&Vec<Spanned<String>>>, offered: &Offered) -> Vec<Requirement> {
    let Some(names) = names else { return offered.requirements.to_vec() };
    let mut list = Vec::new();
    for name in names {
        match offered.requirements.iter().find(|requirement| requirement.name == name.value) {
            Some(requirement) => list.push(requirement.clone()),
            None => {
                let requirement_names: Vec<&str> =
                    offered.requirements.iter().map(|requirement| requirement.name.as_str()).collect();
                scope.unknown(&code::JOB_REFERENCE, "requirement", &name.value, &name.place, &requirement_names);
            }
        }
    }
    list
}

/// The quantities asked for, those of the requirements among them; all named ones where there are neither, else all nodes.
pub fn quantities(
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

/// Adds an index that is not there yet.
pub fn push_new(list: &mut Vec<usize>, index: usize) {
    if !list.contains(&index) {
        list.push(index);
    }
}

/// The largest share of failed solves that is tolerated.
pub fn failure_limit(scope: &mut Scope, written: Option<&Spanned<f64>>) -> f64 {
    let Some(limit) = written else { return FAILURE_LIMIT };
    if !(0.0..=1.0).contains(&limit.value) {
        let message = format!("a failure limit of {}", limit.value);
        scope.error(&code::JOB_SETTING, &limit.place, message, "a share from 0 to 1");
    }
    limit.value
}

/// The number of samples; Sobol points are rounded up to a power of two, with a warning.
pub fn samples(scope: &mut Scope, written: Option<&Spanned<u64>>, is_sobol: bool) -> u64 {
    let Some(Spanned { value, place }) = written else { return SAMPLES };
    if !(2..=MOST_SAMPLES).contains(value) {
        let expected = format!("an integer from 2 to {MOST_SAMPLES}");
        scope.error(&code::JOB_SETTING, place, counted(*value, "sample"), &expected);
        return SAMPLES;
    }
    let rounded = value.next_power_of_two();
    if is_sobol && rounded != *value {
        let message = format!("{value} Sobol points are rounded up to {rounded}");
        scope
            .diagnostics
            .push(Diagnostic::warning(&code::ROUNDED_SAMPLES, place, message).help("write a power of two"));
        return rounded;
    }
    *value
}

/// A whole number within limits, a default where nothing is written.
pub fn number(
    scope: &mut Scope,
    written: Option<&Spanned<u64>>,
    default: u64,
    least: u64,
    most: u64,
    what: &str,
) -> u64 {
    let Some(Spanned { value, place }) = written else { return default };
    if !(least..=most).contains(value) {
        let expected = format!("an integer from {least} to {most}");
        scope.error(&code::JOB_SETTING, place, format!("{value} {what}"), &expected);
    }
    *value
}
