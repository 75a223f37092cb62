//! The first screen: how good or wrong, where, when, in which direction; whether the requirements are met, and what
//! that costs; what is missing, how surely, what it does to the error and what else it could be; with the picture that
//! shows it.

mod missing;

use crate::document::counted;
use crate::job::compare::{Deviation, Output, SensorSummary};
use crate::job::{calibrate, compare, conventional, diagnose, predict, propagate};
use crate::report::number::{self, Shown, fixed, signed};
use crate::report::page::{Block, Figure, Section, Statement, Status, Text, Tone};
use crate::report::view::PassReport;
use crate::study::requirement::ALL;

use super::{Entry, comparison, diagnosis, prediction, propagation, sizing};

/// Statements on the first screen.
const MOST_STATEMENTS: usize = 6;
/// The same where a diagnosis or the passes before have their say.
const MOST_WITH_DIAGNOSIS: usize = 9;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The summary; always there.
pub(super) fn build(report: &PassReport<'_>) -> Option<Section> {
    let mut blocks = Vec::new();
    let mut statements = Vec::new();
    let mut verdicts = Vec::new();
    // What a calibrated model is for goes before how well it fits.
    for (_, output) in report.outputs::<predict::Kind>() {
        let (about_requirements, _) = of_propagation(report, &output.posterior, "Probability after calibration");
        statements.extend(about_requirements);
        statements.extend(of_prediction(output));
    }
    let mut details = Vec::new();
    for (_, output) in report.outputs::<compare::Kind>() {
        let (foremost, more) = of_comparison(report, output);
        statements.extend(foremost);
        details.extend(more);
        verdicts.push(verdict_of_comparison(output));
    }
    statements.extend(missing::of_history(report));
    for (position, (name, output)) in report.outputs::<diagnose::Kind>().enumerate() {
        if position == 0 {
            statements.extend(missing::of_diagnosis(output));
        } else {
            statements.push(missing::of_further(name, output));
        }
    }
    // Where there is no room for all, details of the misfit go last.
    statements.extend(details);
    // What a requirement or a size says goes before what a distribution says, where there is no room for all.
    let mut distributions = Vec::new();
    for (_, output) in report.outputs::<propagate::Kind>() {
        let (about_requirements, about_quantities) = of_propagation(report, output, "Probability");
        statements.extend(about_requirements);
        distributions.extend(about_quantities);
    }
    for (_, output) in report.outputs::<conventional::Kind>() {
        statements.extend(of_sizes(report, output));
    }
    statements.extend(distributions);
    let has_more = report.outputs::<diagnose::Kind>().next().is_some() || report.history.is_some();
    statements.truncate(if has_more { MOST_WITH_DIAGNOSIS } else { MOST_STATEMENTS });
    if !statements.is_empty() {
        blocks.push(Block::Statements(statements));
    }
    // What is missing is the verdict; how the delivered model failed is then a note.
    let judged = report
        .outputs::<diagnose::Kind>()
        .map(|(_, output)| Block::callout(Tone::Verdict, diagnosis::verdict(output)))
        .next();
    let tone = if judged.is_some() { Tone::Note } else { Tone::Verdict };
    blocks.extend(judged);
    blocks.extend(verdicts.into_iter().flatten().map(|text| Block::callout(tone, text)));
    if let Some(note) = &report.reconstructed {
        blocks.push(Block::callout(Tone::Reconstructed, note.clone()));
    }
    for (name, _) in report.outputs::<calibrate::Kind>().filter(|(_, output)| !output.converged) {
        let text = Text::new("The calibration ")
            .code(name)
            .plain(" did not converge: tuned numbers are not to be relied upon.");
        blocks.push(Block::callout(Tone::Warning, text));
    }
    blocks.extend(report.warnings.iter().map(|w| Block::callout(Tone::Warning, w.clone())));
    if report.results.is_empty() {
        blocks.push(Block::callout(
            Tone::Note,
            "No job of this pass has a result yet; the sections below are its definition.",
        ));
    }
    blocks.extend(main_picture(report).map(Block::Figure));
    Some(Section { id: "summary", title: "Summary".into(), blocks })
}

/// The picture of the first screen; the section that it belongs to leaves it out.
pub(super) fn main_picture(report: &PassReport<'_>) -> Option<Figure> {
    if let Some((job, output)) = report.outputs::<compare::Kind>().find(|(_, o)| !o.rows.is_empty()) {
        let shows = comparison::Shows::of(output);
        let worst = worst_sensor(output);
        let measurement = worst.map_or(output.rows[0].measurement.as_str(), |s| s.measurement.as_str());
        if report.is_steady(measurement, &output.rows) {
            return Some(comparison::phase_map(job, output, measurement, shows));
        }
        let sensor = worst.map_or(output.rows[0].sensor.as_str(), |s| s.sensor.as_str());
        return Some(comparison::time_history(report, job, output, measurement, sensor, shows));
    }
    if let Some((job, output, pair)) =
        report.outputs::<conventional::Kind>().find_map(|(job, o)| Some((job, o, *sizing::pairs(o).first()?)))
    {
        return Some(sizing::figure(report, job, output, pair));
    }
    if let Some(figure) = report
        .outputs::<predict::Kind>()
        .find_map(|(job, prediction)| prediction::figures(prediction, job).into_iter().next())
    {
        return Some(figure);
    }
    let (job, output) = report.outputs::<propagate::Kind>().next()?;
    propagation::probability_figures(output, job).into_iter().next().or_else(|| {
        let case = propagation::nominal_cases(output).next()?;
        Some(propagation::histogram(case, case.quantities.first()?, job))
    })
}

/// Deviations of a sensor that count: those of the tuned state where there is one; for fitting and held out.
fn deviations(sensor: &SensorSummary) -> [&Deviation; 2] {
    sensor.tuned.as_ref().map_or([&sensor.train, &sensor.held_out], |tuned| [&tuned.train, &tuned.held_out])
}

/// How a sensor stands against its noise, in the state that counts.
fn standing(sensor: &SensorSummary, deviation: &Deviation) -> Option<Status> {
    match &sensor.tuned {
        Some(tuned) => tuned.noise_rmse.map(|[_, high]| Status::kept(deviation.rmse <= high)),
        None => comparison::against_noise(sensor, deviation),
    }
}

/// Sensor with the largest RMSE, in either kind of readings, among those of the first sensor's unit.
fn worst_sensor(output: &Output) -> Option<&SensorSummary> {
    let unit = &output.sensors.first()?.unit;
    let size = |s: &SensorSummary| {
        deviations(s).into_iter().filter(|d| d.count > 0 && d.rmse.is_finite()).map(|d| d.rmse).fold(0.0, f64::max)
    };
    output.sensors.iter().filter(|s| &s.unit == unit).max_by(|a, b| size(a).total_cmp(&size(b)))
}

/// The mean and what it says about the model, for a deviation of measured minus predicted.
fn direction(mean: f64, is_temperature: bool) -> &'static str {
    match (mean > 0.0, is_temperature) {
        (true, true) => "the model is too cold",
        (false, true) => "the model is too warm",
        (true, false) => "the model is too low",
        (false, false) => "the model is too high",
    }
}

fn verdict_of_comparison(output: &Output) -> Option<Text> {
    let first = output.fails.first()?;
    let more = output.fails.len() - 1;
    let text = Text::new(if output.tuned.is_some() { "As delivered, " } else { "" }).plain(first.clone());
    Some(match more {
        0 => text,
        1 => text.plain(" One more finding stands in the comparison."),
        more => text.plain(format!(" {more} more findings stand in the comparison.")),
    })
}

/// How wrong and where, in the tuned state where there is one; and what goes behind it.
fn of_comparison(report: &PassReport<'_>, output: &Output) -> (Vec<Statement>, Vec<Statement>) {
    let (mut out, mut details) = (Vec::new(), Vec::new());
    let units: Vec<&str> = output.sensors.iter().map(|s| s.unit.as_str()).collect();
    if let Some(unit) = units.first().filter(|u| units.iter().all(|v| v == *u)) {
        out.push(how_wrong(output, &Shown::si(unit)));
    }
    let of_delivered = if output.tuned.is_some() { ", as delivered" } else { "" };
    if let Some(worst) = worst_sensor(output) {
        let [train, held_out] = deviations(worst);
        let deviation = if held_out.count > 0 && held_out.rmse > train.rmse { held_out } else { train };
        let is_temperature = report.sensor_shown(&worst.measurement, &worst.sensor, &worst.unit).is_celsius();
        let shown = Shown::si(&worst.unit);
        let side = if deviation.mean > 0.0 { "above" } else { "below" };
        // A mean that is small against the scatter has no direction.
        let text = if deviation.mean.abs() > 0.3 * deviation.rmse {
            Text::new(format!(
                "The worst sensor reads {} {side} the prediction on average: ",
                shown.text(deviation.mean.abs())
            ))
            .strong(direction(deviation.mean, is_temperature))
            .plain(" there")
        } else {
            Text::new("The worst sensor deviates in both directions")
        };
        let state = if worst.tuned.is_some() { "tuned, " } else { "" };
        let text = text.plain(format!(
            " ({state}RMSE {}, largest {}).",
            shown.text(deviation.rmse),
            shown.text(deviation.max)
        ));
        let status = standing(worst, deviation);
        out.push(Statement { label: "Where".into(), value: worst.sensor.clone(), text, status });
    }
    if let Some(phase) =
        output.phases.iter().filter(|p| p.worst.is_finite()).max_by(|a, b| a.worst.abs().total_cmp(&b.worst.abs()))
    {
        let text = Text::new("The largest deviation: ").code(&phase.worst_sensor).plain(format!(
            ", {}{}.",
            number::with_unit(&signed(phase.worst, 2), "K"),
            if phase.held_out { ", held out" } else { "" }
        ));
        let label = format!("When{of_delivered}");
        details.push(Statement { label, value: phase.phase.clone(), text, status: None });
    }
    if let Some(chi2) = output.chi2_per_reading.filter(|c| c.is_finite()) {
        let status = if chi2 > 1.5 { Status::Fail } else { Status::Ok };
        let text = "Mean square of deviation over noise; the noise alone gives about 1.".into();
        details.push(Statement {
            label: format!("Against the noise{of_delivered}"),
            value: fixed(chi2, if chi2 < 100.0 { 1 } else { 0 }),
            text,
            status: Some(status),
        });
    }
    if !output.verdicts.is_empty() {
        let kept = output.verdicts.iter().filter(|v| v.kept).count();
        details.push(Statement {
            label: format!("Criteria{of_delivered}"),
            value: format!("{kept} of {} kept", output.verdicts.len()),
            text: Text::new(output.criteria.title.clone()),
            status: Some(Status::kept(kept == output.verdicts.len())),
        });
    }
    (out, details)
}

/// The error of all sensors; the tuned one beside the delivered one where there is one.
fn how_wrong(output: &Output, shown: &Shown) -> Statement {
    let statuses: Vec<Status> = output
        .sensors
        .iter()
        .filter_map(|sensor| {
            let [train, held_out] = deviations(sensor);
            standing(sensor, if held_out.count > 0 { held_out } else { train })
        })
        .collect();
    let status =
        if statuses.contains(&Status::Fail) { Some(Status::Fail) } else { statuses.first().map(|_| Status::Ok) };
    let label = "How wrong".to_owned();
    let (delivered, of) = if output.held_out.count > 0 {
        (&output.held_out, counted(output.held_out.count, "held-out reading"))
    } else {
        (&output.train, format!("{}; none is held out", counted(output.train.count, "reading")))
    };
    let Some(tuned) = &output.tuned else {
        let rest = match (output.held_out.count, output.train.count) {
            (0, _) | (_, 0) => String::new(),
            _ => format!("; {} over the {} that a fit may use", shown.text(output.train.rmse), output.train.count),
        };
        let text = format!("RMSE over {of}{rest}.");
        return Statement { label, value: shown.text(delivered.rmse), text: text.into(), status };
    };
    let best = if output.held_out.count > 0 { &tuned.held_out } else { &tuned.train };
    let mut text = Text::new("RMSE tuned, ").strong(format!("{} as delivered", shown.text(delivered.rmse)));
    text = text.plain(format!(", over {of}"));
    if output.held_out.count > 0 {
        text = text.plain(format!(
            "; over the {} of the fit {}, {} as delivered",
            output.train.count,
            shown.text(tuned.train.rmse),
            shown.text(output.train.rmse)
        ));
    }
    Statement { label, value: shown.text(best.rmse), text: text.plain("."), status }
}

/// Whether the model breaks the criteria of a test to which nothing of it was tuned.
fn fails_its_test(report: &PassReport<'_>) -> bool {
    let breaks = |output: &Output| output.tuned.is_none() && output.verdicts.iter().any(|verdict| !verdict.kept);
    report.outputs::<compare::Kind>().any(|(_, output)| breaks(output))
}

/// By environment: the requirement that is farthest from what is required, under this label, and its quantity's
/// distribution.
fn of_propagation(
    report: &PassReport<'_>,
    output: &propagate::Output,
    probability: &str,
) -> (Vec<Statement>, Vec<Statement>) {
    let (mut out, mut quantities) = (Vec::new(), Vec::new());
    let fails = fails_its_test(report);
    for case in propagation::nominal_cases(output) {
        let Some(met) = case.requirements.iter().min_by(|a, b| {
            (a.probability.value - a.required)
                .total_cmp(&(b.probability.value - b.required))
                .then((a.requirement == ALL).cmp(&(b.requirement == ALL)))
        }) else {
            continue;
        };
        let status = propagation::standing(met);
        let shown = report.quantity_shown(&met.quantity, &met.unit);
        let what = if met.quantity.is_empty() {
            "all requirements together".to_owned()
        } else {
            format!("{} {}", met.quantity, super::problem::limits(&shown, met.above, met.below))
        };
        let (words, status) = match status {
            Status::Ok if fails => ("met by the model, which fails its test: this is no proof", Status::Caution),
            Status::Ok => ("met", status),
            Status::Caution => ("undecided with these samples", status),
            Status::Fail => ("not met", status),
        };
        out.push(Statement {
            label: format!("{probability}, nominal design, {}", case.environment),
            value: propagation::probability_stated(&met.probability),
            text: Text::new(format!("{what}; required {}: ", number::probability(met.required)))
                .strong(words)
                .plain("."),
            status: Some(status),
        });
        if let Some(q) = case.quantities.iter().find(|q| q.name == met.quantity).or(case.quantities.first()) {
            let shown = Shown::quantity(&q.unit, q.is_temperature);
            quantities.push(Statement {
                label: format!("{}, {}", q.name, case.environment),
                value: format!("{} \u{00B1} {}", shown.number(q.mean), shown.difference().text(q.sd)),
                text: Text::new(format!("mean and standard deviation; nominal {}.", shown.text(q.nominal))),
                status: None,
            });
        }
    }
    (out, quantities)
}

/// By environment: the design value that all requirements allow, before and after.
fn of_prediction(output: &predict::Output) -> Vec<Statement> {
    let mut out: Vec<Statement> = Vec::new();
    let Some(design) = &output.posterior.design_variable else { return out };
    let shown = Shown::written(&output.posterior.design_unit);
    for case in propagation::nominal_cases(&output.posterior) {
        let is_whole = |reached: &&propagate::Reached| {
            reached.environment == case.environment && (reached.requirement == ALL || case.requirements.len() == 1)
        };
        let find =
            |from: &propagate::Output| from.reached.iter().find(is_whole).and_then(|reached| reached.design_value);
        let Some(value) = find(&output.posterior) else { continue };
        let text = find(&output.prior).map_or_else(
            || "no value of the sweep reached it with the priors.".to_owned(),
            |before| format!("reaches what is required; with the priors {}.", shown.text(before)),
        );
        out.push(Statement {
            label: format!("{design} after calibration, {}", case.environment),
            value: shown.text(value),
            text: Text::new(text),
            status: None,
        });
    }
    out
}

fn of_sizes(report: &PassReport<'_>, output: &conventional::Output) -> Vec<Statement> {
    let mut out = Vec::new();
    let design = Shown::written(&output.design_unit);
    let mut environments: Vec<&str> = Vec::new();
    let what = if output.seeks_largest() { format!("largest {}", output.design_variable) } else { "size".to_owned() };
    // The first pair of an environment is that of all its requirements.
    for pair in sizing::pairs(output) {
        if environments.contains(&pair.0) {
            continue;
        }
        environments.push(pair.0);
        let reached = sizing::probabilistic(report, &output.design_variable, pair);
        let probabilistic = reached.and_then(|r| r.design_value.map(|v| (v, r)));
        if let Some((value, reached)) = probabilistic {
            let interval = reached
                .interval
                .map_or(String::new(), |[a, b]| format!(" ({} to {})", design.number(a), design.text(b)));
            out.push(Statement {
                label: format!("Probabilistic {what}, {}", pair.0),
                value: design.text(value),
                text: Text::code(Text::default(), &output.design_variable)
                    .plain(format!(" for P = {}{interval}.", number::probability(reached.probability))),
                status: None,
            });
        }
        let sizes: Vec<&conventional::Size> =
            sizing::sizes_of(output, pair).into_iter().filter(|s| s.size.is_some()).collect();
        let stacked = sizes.iter().filter(|s| s.basis == conventional::Basis::StackedWorstCase);
        let middle = sorted_middle(stacked.copied().collect());
        if let Some((size, value)) = middle.and_then(|s| Some((s, s.size?))) {
            let against = probabilistic.map_or(String::new(), |(design_value, _)| {
                let difference = design.difference();
                let relative = match (design.is_celsius(), design_value < value) {
                    (false, _) => propagation::relative(design_value, value),
                    (true, true) => format!("{} colder", difference.text(value - design_value)),
                    (true, false) => format!("{} warmer", difference.text(design_value - value)),
                };
                format!(" The probabilistic {what} is {relative}.")
            });
            let all = || sizes.iter().filter_map(|s| s.size);
            let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
            let range = format!(" All rules: {} to {}.", design.number(least), design.text(most));
            out.push(Statement {
                label: format!("Conventional {what}, {}", pair.0),
                value: design.text(value),
                text: Text::new(format!("{} ({}).{against}{range}", sizing::label(size), size.rule.title)),
                status: None,
            });
        }
    }
    out
}

/// The middle one by size, the larger of two.
fn sorted_middle(mut sizes: Vec<&conventional::Size>) -> Option<&conventional::Size> {
    sizes.sort_by(|a, b| a.size.unwrap_or(f64::NAN).total_cmp(&b.size.unwrap_or(f64::NAN)));
    sizes.get(sizes.len() / 2).copied()
}
