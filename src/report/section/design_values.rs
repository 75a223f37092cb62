//! Design values to which the approaches of a pass lead: by probability, and by the conventional rules.

use serde::{Deserialize, Serialize};

use crate::job::conventional::{self, Basis};
use crate::job::{predict, propagate};
use crate::report::number;
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

use super::sizing::{label, pairs, sizes_of};

/// How a design value is come by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// The required probability is reached.
    Probability,
    /// A margin on nominal values.
    RuleOnNominal,
    /// A margin on stacked worst cases.
    RuleOnWorstCase,
}

/// A design value, all requirements of an environment together where it has several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignValue {
    /// The design variable.
    pub variable: String,
    /// Its unit as the study writes it.
    pub unit: String,
    /// Its nominal value, SI.
    pub nominal: Option<f64>,
    /// The environment.
    pub environment: String,
    /// How it is come by.
    pub way: Way,
    /// The same in words, with the margin or the probability.
    pub approach: String,
    /// What was known, in words.
    pub known: String,
    /// The value, SI; `None` where none passes.
    pub value: Option<f64>,
    /// Its 95 % interval from sampling, SI.
    pub interval: Option<[f64; 2]>,
    /// The job.
    pub job: String,
}

/// The design values of a pass. Sizes by rule from what an earlier pass knew are that pass's.
pub fn of(report: &PassReport<'_>) -> Vec<DesignValue> {
    let mut values = Vec::new();
    for (job, output) in report.outputs::<propagate::Kind>() {
        by_probability(report, job, output, "priors", &mut values);
    }
    for (job, output) in report.outputs::<predict::Kind>() {
        let has_more = output.validated.is_some() || !output.posterior.discrepancy.is_empty();
        let known = if has_more { "posterior and discrepancy" } else { "posterior" };
        by_probability(report, job, &output.posterior, known, &mut values);
    }
    for (job, output) in report.outputs::<conventional::Kind>() {
        let known = match (&output.correlation, &output.priors_of) {
            (Some(correlation), _) => format!("correlated, {}", correlation.method),
            (None, None) => "before the test".to_owned(),
            (None, Some(_)) => continue,
        };
        // The first pair of an environment stands for all its requirements.
        let mut seen: Vec<&str> = Vec::new();
        for pair in pairs(output) {
            if seen.contains(&pair.0) {
                continue;
            }
            seen.push(pair.0);
            values.extend(sizes_of(output, pair).into_iter().map(|size| DesignValue {
                variable: output.design_variable.clone(),
                unit: output.design_unit.clone(),
                nominal: Some(output.design_nominal),
                environment: pair.0.to_owned(),
                way: if size.basis == Basis::Nominal { Way::RuleOnNominal } else { Way::RuleOnWorstCase },
                approach: label(size),
                known: known.clone(),
                value: size.size,
                interval: None,
                job: job.to_owned(),
            }));
        }
    }
    values
}

fn by_probability(
    report: &PassReport<'_>,
    job: &str,
    output: &propagate::Output,
    known: &str,
    values: &mut Vec<DesignValue>,
) {
    let Some(variable) = &output.design_variable else { return };
    for reached in &output.reached {
        let of_environment = output.reached.iter().filter(|own| own.environment == reached.environment);
        let governs = reached.requirement == ALL || of_environment.count() == 1;
        if governs {
            values.push(DesignValue {
                variable: variable.clone(),
                unit: output.design_unit.clone(),
                nominal: report.nominal_design(variable),
                environment: reached.environment.clone(),
                way: Way::Probability,
                approach: format!("probabilistic, P = {}", number::probability(reached.probability)),
                known: known.to_owned(),
                value: reached.design_value,
                interval: reached.interval,
                job: job.to_owned(),
            });
        }
    }
}
