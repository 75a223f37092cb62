//! The figures that tell a job's result, one a row: what `bmv diff` holds beside one another.

use crate::diagnosis::Output as Diagnosed;
use crate::job::{calibrate, compare, conventional, design, goal, propagate, sensitivity};

use super::headline::kept;
use super::number::{self, NONE, Shown, percent, significant};
use super::section::design as design_section;
use super::section::goal::next_words;
use super::section::propagation::nominal_cases;
use super::view::{JobEntry, JobResult};

/// Names and texts of the figures, in an order of their own for each kind.
pub fn essentials(job: &JobEntry) -> Vec<(String, String)> {
    match &job.result {
        JobResult::Propagate(output) => of_propagation(output),
        JobResult::Predict(output) => of_propagation(&output.posterior),
        JobResult::Compare(output) => of_comparison(output),
        JobResult::Calibrate(output) => of_calibration(output),
        JobResult::Sensitivity(output) => of_sensitivity(output),
        JobResult::Diagnose(output) => of_diagnosis(output),
        JobResult::Conventional(output) => of_sizes(output),
        JobResult::Goal(output) => of_goal(output),
        JobResult::Design(output) => of_design(output),
    }
}

fn of_diagnosis(output: &Diagnosed) -> Vec<(String, String)> {
    let selected = if output.selected.is_empty() { NONE.to_owned() } else { output.selected.join(", ") };
    let mut rows = vec![
        ("verdict".to_owned(), output.verdict.word().to_owned()),
        ("selected effects".to_owned(), selected),
        ("P(nothing is missing)".to_owned(), number::probability(output.probability_nothing)),
        ("P(something unknown is missing)".to_owned(), number::probability(output.probability_unexplained)),
        ("family-wise p of the misfit".to_owned(), significant(output.misfit.family_wise_p, 2)),
        (
            "family-wise p of what is left".to_owned(),
            output.remaining_p.map_or_else(|| NONE.to_owned(), |p| significant(p, 2)),
        ),
    ];
    for effect in output.effects.iter().filter(|effect| !effect.changes_nothing) {
        rows.push((format!("P({} is missing)", effect.id), number::probability(effect.probability)));
        for (name, amount) in &effect.amplitudes {
            let text = format!("{} {}", number::with_error(amount.value, amount.sd), amount.unit);
            rows.push((format!("{}: {name}", effect.id), text));
        }
    }
    rows
}

fn of_sizes(output: &conventional::Output) -> Vec<(String, String)> {
    let design = Shown::written(&output.design_unit);
    let name = &output.design_variable;
    let mut rows = vec![(format!("{name}, nominal"), design.text(output.design_nominal))];
    rows.extend(output.sizes.iter().map(|size| {
        let (rule, requirement, environment) = (&size.rule.name, &size.requirement, &size.environment);
        let figure = format!("{name} by rule {rule}, {}: {requirement} in {environment}", size.basis.words());
        (figure, size.size.map_or_else(|| NONE.to_owned(), |size| design.text(size)))
    }));
    rows
}

fn of_goal(output: &goal::Output) -> Vec<(String, String)> {
    let design = Shown::written(&output.design_unit);
    let mut rows = vec![
        ("next step".to_owned(), next_words(output.advice.next).to_owned()),
        ("why".to_owned(), output.advice.reasons.join("; ")),
        ("P(all requirements)".to_owned(), number::probability(output.probability.value)),
    ];
    for met in &output.requirements {
        rows.push((
            format!("P({}) in {}", met.requirement, met.environment),
            number::probability(met.probability.value),
        ));
    }
    if let Some(name) = &output.design_variable {
        let value = output.prior_design_value.map_or_else(|| NONE.to_owned(), |value| design.text(value));
        rows.push((format!("{name} that the priors reach"), value));
    }
    if let Some(target) = &output.target {
        for ((name, unit), sd) in target.parameters.iter().zip(&target.units).zip(&target.sds) {
            let text = Shown::written(unit).difference().text(*sd);
            rows.push((format!("{name}: standard deviation that may be left"), text));
        }
    }
    rows
}

fn of_design(output: &design::Output) -> Vec<(String, String)> {
    let mut rows = vec![("estimator".to_owned(), output.estimator.clone())];
    let best = output.best.as_ref();
    let told = best.map_or_else(|| NONE.to_owned(), |best| design_section::conditions(output, best.candidate));
    rows.push(("best candidate".to_owned(), told));
    let nats = best.map_or_else(|| NONE.to_owned(), |best| number::with_error(best.information_nats, best.se));
    rows.push(("information expected of it, nats".to_owned(), nats));
    for (position, pick) in output.picks.iter().enumerate() {
        rows.push((format!("phase {} to pick", position + 1), design_section::conditions(output, pick.position)));
    }
    rows.push(("findings".to_owned(), output.findings.join(" ")));
    rows
}

fn of_propagation(output: &propagate::Output) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    let has_one = nominal_cases(output).count() == 1;
    for case in nominal_cases(output) {
        let place = if has_one { String::new() } else { format!(" in {}", case.environment) };
        for met in &case.requirements {
            rows.push((format!("P({}){place}", met.requirement), number::probability(met.probability.value)));
        }
        for quantity in &case.quantities {
            let shown = Shown::quantity(&quantity.unit, quantity.is_temperature);
            rows.push((format!("{}, mean{place}", quantity.name), shown.text(quantity.mean)));
            rows.push((format!("{}, standard deviation{place}", quantity.name), shown.difference().text(quantity.sd)));
        }
        rows.push((format!("samples without a solution{place}"), case.failed.to_string()));
    }
    rows
}

fn of_comparison(output: &compare::Output) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    for sensor in &output.sensors {
        let shown = Shown::si(&sensor.unit);
        let tuned = sensor.tuned.as_ref();
        let states = [
            ("as delivered", Some((&sensor.train, &sensor.held_out))),
            ("tuned", tuned.map(|tuned| (&tuned.train, &tuned.held_out))),
        ];
        for (state, deviations) in states {
            let Some((train, held_out)) = deviations else { continue };
            for (readings, own) in [("for fitting", train), ("held out", held_out)] {
                if own.count > 0 {
                    let name = format!("{}, {}: RMSE {state}, readings {readings}", sensor.measurement, sensor.sensor);
                    rows.push((name, shown.text(own.rmse)));
                }
            }
        }
    }
    if !output.verdicts.is_empty() {
        rows.push(("criteria kept as delivered".to_owned(), kept(&output.verdicts)));
        if output.tuned.is_some() {
            rows.push(("criteria kept tuned".to_owned(), kept(&output.tuned_verdicts())));
        }
    }
    rows
}

fn of_calibration(output: &calibrate::Output) -> Vec<(String, String)> {
    let known = output.order.iter().filter_map(|name| Some((name, output.parameters.get(name)?)));
    let mut rows: Vec<(String, String)> = known
        .map(|(name, own)| {
            let unit = if own.unit == "1" { String::new() } else { format!(" {}", own.unit) };
            (name.clone(), format!("{}{unit}", number::with_error(own.mean, own.sd)))
        })
        .collect();
    let evidence = output.log_evidence.value.map_or_else(|| NONE.to_owned(), |value| significant(value, 5));
    rows.push(("log evidence".to_owned(), evidence));
    rows.push(("converged".to_owned(), if output.converged { "yes" } else { "no" }.to_owned()));
    rows
}

fn of_sensitivity(output: &sensitivity::Output) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    for case in &output.cases {
        let place = if output.cases.len() == 1 { String::new() } else { format!(" in {}", case.environment) };
        for quantity in &case.quantities {
            let Some(sobol) = &quantity.sobol else { continue };
            for (parameter, total) in output.parameters.iter().zip(&sobol.total) {
                let name = format!("{}: total effect of {}{place}", quantity.name, parameter.name);
                rows.push((name, percent(total.estimate.value, 0)));
            }
        }
    }
    rows
}
