//! The figures that tell a job's result, one a row: what `bmv diff` holds beside one another.

use crate::job::{calibrate, compare, propagate, sensitivity};

use super::headline::headlines;
use super::number::{self, NONE, Shown, percent, significant};
use super::section::propagation::nominal_cases;
use super::view::{JobEntry, JobResult};

/// Names and texts of the figures, in an order of their own for each kind; what has none is told by its headlines.
pub fn essentials(job: &JobEntry) -> Vec<(String, String)> {
    match &job.result {
        JobResult::Propagate(output) => of_propagation(output),
        JobResult::Predict(output) => of_propagation(&output.posterior),
        JobResult::Compare(output) => of_comparison(output),
        JobResult::Calibrate(output) => of_calibration(output),
        JobResult::Sensitivity(output) => of_sensitivity(output),
        JobResult::Diagnose(_) | JobResult::Conventional(_) | JobResult::Goal(_) | JobResult::Design(_) => {
            let lines = headlines(job).into_iter().enumerate();
            lines.map(|(position, line)| (format!("line {}", position + 1), line)).collect()
        }
    }
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
    let kept = output.verdicts.iter().filter(|verdict| verdict.kept).count();
    rows.push(("criteria kept".to_owned(), format!("{kept} of {}", output.verdicts.len())));
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
