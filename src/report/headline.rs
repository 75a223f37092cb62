//! What came out of a job, in a line or two.

use crate::document::counted;
use crate::job::compare::Verdict;
use crate::job::{calibrate, compare, conventional, design, goal, predict, propagate, sensitivity};

use super::number::{self, Shown};
use super::required::outcome;
use super::section::goal as goal_section;
use super::section::propagation;
use super::section::sensitivity as sensitivity_section;
use super::view::{JobEntry, JobResult};

/// Parameters of a sensitivity analysis that are told.
const MOST_LEADING: usize = 3;
/// Findings of a comparison and reasons of an advice that are told.
const MOST_FINDINGS: usize = 2;

/// The outcome of a job, a line each.
pub fn headlines(job: &JobEntry) -> Vec<String> {
    match &job.result {
        JobResult::Propagate(output) => of_propagation(output),
        JobResult::Predict(output) => of_prediction(output),
        JobResult::Conventional(output) => of_sizes(output),
        JobResult::Compare(output) => of_comparison(output),
        JobResult::Calibrate(output) => of_calibration(output),
        JobResult::Diagnose(output) => {
            output.before_the_verdict().into_iter().chain(output.words.iter().cloned()).collect()
        }
        JobResult::Sensitivity(output) => of_sensitivity(output),
        JobResult::Goal(output) => of_goal(output),
        JobResult::Design(output) => of_design(output),
    }
}

/// Whether to believe it, what stands against it, and the evidence.
fn of_calibration(output: &calibrate::Output) -> Vec<String> {
    let mut lines = Vec::new();
    if output.converged {
        let evidence = output.log_evidence.value.zip(output.log_evidence.sd);
        let evidence = evidence.map_or("is not known".to_owned(), |(value, sd)| number::with_error(value, sd));
        lines.push(format!("{} converged; logarithm of the evidence {evidence}", output.sampler));
    } else {
        lines.push(format!("{} did NOT converge", output.sampler));
        lines.extend(output.objections.iter().take(MOST_FINDINGS).cloned());
    }
    lines.extend(output.findings.iter().take(MOST_FINDINGS).cloned());
    lines
}

/// The leading parameters of each quantity.
fn of_sensitivity(output: &sensitivity::Output) -> Vec<String> {
    let mut lines = Vec::new();
    for case in &output.cases {
        let place = if output.cases.len() == 1 { String::new() } else { format!(" in {}", case.environment) };
        for quantity in &case.quantities {
            let Some(sobol) = &quantity.sobol else {
                lines.extend(quantity.is_constant.then(|| format!("{} does not vary{place}", quantity.name)));
                continue;
            };
            let leading: Vec<String> = sensitivity_section::by_total(sobol)
                .into_iter()
                .take(MOST_LEADING)
                .map(|at| {
                    let total = number::percent(sobol.total[at].estimate.value, 0);
                    format!("{} {total}", output.parameters[at].name)
                })
                .collect();
            lines.push(format!("{}: total effects {}{place}", quantity.name, leading.join(", ")));
        }
        if case.failed > 0 {
            let (failed, solves, rows) = (case.failed, case.solves, case.rows_left_out);
            let are = if rows == 1 { "is" } else { "are" };
            let rows = counted(rows, "row");
            lines.push(format!("{failed} of {} failed, {rows} {are} left out{place}", counted(solves, "solve")));
        }
    }
    lines.extend(output.precision.filter(|precision| !precision.is_reached).map(|precision| {
        let (widest, asked) = (number::significant(precision.widest, 2), number::significant(precision.asked, 2));
        format!("the precision asked for is NOT reached: the widest interval is {widest}, asked for {asked}")
    }));
    lines
}

/// What to do next, and why.
fn of_goal(output: &goal::Output) -> Vec<String> {
    let mut lines = vec![format!("next: {}", goal_section::next_words(output.advice.next))];
    lines.extend(output.advice.reasons.iter().take(MOST_FINDINGS).cloned());
    lines
}

/// The best candidate, and what must be said of it.
fn of_design(output: &design::Output) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(best) = &output.best {
        let conditions = super::section::design::conditions(output, best.candidate);
        let value = number::with_error(best.information_nats, best.se);
        lines.push(format!("{conditions} tells most about {}: {value} nats expected", output.learn.join(", ")));
    }
    if !output.is_trusted {
        lines.push("no candidate is named: no estimate of the information can be trusted".to_owned());
    }
    lines.extend(output.findings.iter().take(MOST_FINDINGS).cloned());
    lines
}

/// Probability of each requirement at the nominal design, and where the design reaches what is required.
fn of_propagation(output: &propagate::Output) -> Vec<String> {
    let mut lines = Vec::new();
    let design = Shown::written(&output.design_unit);
    let has_one_environment = propagation::nominal_cases(output).all(|c| c.environment == output.cases[0].environment);
    for case in propagation::nominal_cases(output) {
        let place = if has_one_environment { String::new() } else { format!(" in {}", case.environment) };
        for met in &case.requirements {
            let outcome = outcome(met);
            let reached = output
                .reached
                .iter()
                .find(|r| r.environment == case.environment && r.requirement == met.requirement)
                .zip(output.design_variable.as_ref())
                .map_or(String::new(), |(reached, name)| match reached.design_value {
                    Some(value) => format!("; {name} = {} reaches it", design.text(value)),
                    None => format!("; no {name} of the sweep reaches it"),
                });
            lines.push(format!(
                "P({}) = {}{place}, required {}: {outcome}{reached}",
                met.requirement,
                number::probability(met.probability.value),
                number::probability(met.required),
            ));
        }
        if case.requirements.is_empty() {
            lines.extend(case.quantities.iter().map(|q| {
                let shown = Shown::quantity(&q.unit, q.is_temperature);
                let spread = shown.difference().text(q.sd);
                format!("{} = {}, standard deviation {spread}{place}", q.name, shown.text(q.mean))
            }));
        }
        if case.failed > 0 {
            let samples = counted(output.samples, "sample");
            lines.push(format!("no solution in {} of {samples}{place}", case.failed));
        }
    }
    lines
}

/// With the posterior, and where the design reached what is required with the priors.
fn of_prediction(output: &predict::Output) -> Vec<String> {
    let mut lines = of_propagation(&output.posterior);
    let design = Shown::written(&output.posterior.design_unit);
    if let Some(name) = &output.posterior.design_variable {
        for own in &output.prior.reached {
            let value = own.design_value.map_or_else(|| format!("no {name} of the sweep"), |value| design.text(value));
            lines.push(format!("with the priors, {} in {}: {value} reaches it", own.requirement, own.environment));
        }
    }
    if !output.converged {
        lines.push("the chains behind the posterior did NOT converge".to_owned());
    }
    lines
}

/// The range of the sizes by rule.
fn of_sizes(output: &conventional::Output) -> Vec<String> {
    let design = Shown::written(&output.design_unit);
    let sizes: Vec<f64> = output.sizes.iter().filter_map(|size| size.size).collect();
    let (least, most) = (sizes.iter().copied().reduce(f64::min), sizes.iter().copied().reduce(f64::max));
    let nominal = design.text(output.design_nominal);
    let passing = output.sizes.iter().filter(|size| size.passes).count();
    let range = match least.zip(most) {
        Some((least, most)) => {
            format!("{} from {} to {} by rule", output.design_variable, design.number(least), design.text(most))
        }
        None => format!("no {} of the range satisfies any rule", output.design_variable),
    };
    vec![format!("{range}; the nominal {nominal} passes {passing} of {}", counted(output.sizes.len(), "rule"))]
}

/// RMSE and criteria, then where it fails.
fn of_comparison(output: &compare::Output) -> Vec<String> {
    let units: Vec<&str> = output.sensors.iter().map(|sensor| sensor.unit.as_str()).collect();
    let mut parts = Vec::new();
    if let Some(unit) = units.first().filter(|unit| units.iter().all(|other| other == *unit)) {
        let shown = Shown::si(unit);
        let tuned = output.tuned.as_ref();
        let rows = [
            ("", &output.train, tuned.map(|tuned| &tuned.train)),
            (" on held-out rows", &output.held_out, tuned.map(|tuned| &tuned.held_out)),
        ];
        for (rows, delivered, tuned) in rows.into_iter().filter(|(_, delivered, _)| delivered.count > 0) {
            let delivered = shown.text(delivered.rmse);
            parts.push(match tuned {
                Some(tuned) => format!("RMSE{rows} {delivered} as delivered, {} tuned", shown.text(tuned.rmse)),
                None => format!("RMSE{rows} {delivered} as delivered"),
            });
        }
    }
    if !output.verdicts.is_empty() {
        let [kept, tuned] = [&output.verdicts, &output.tuned_verdicts()].map(|verdicts| kept(verdicts));
        let tuned = if output.tuned.is_some() { format!(", {tuned} tuned") } else { String::new() };
        parts.push(format!("{kept} criteria kept as delivered{tuned} ({})", output.criteria.title));
    }
    if !output.failed.is_empty() {
        parts.push(format!("{} without a prediction", counted(output.failed.len(), "phase")));
    }
    let mut lines = vec![parts.join("; ")];
    lines.extend(output.fails.iter().take(MOST_FINDINGS).map(|found| format!("as delivered, {found}")));
    if output.fails.len() > MOST_FINDINGS {
        let more = counted(output.fails.len() - MOST_FINDINGS, "more finding");
        lines.push(format!("and {more}"));
    } else if output.fails.is_empty() {
        lines.push("as delivered, the model fails at no place".to_owned());
    }
    lines
}

/// How many of some criteria are kept.
pub fn kept(verdicts: &[Verdict]) -> String {
    format!("{} of {}", verdicts.iter().filter(|verdict| verdict.kept).count(), verdicts.len())
}
