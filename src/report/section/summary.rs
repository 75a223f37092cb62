//! The first screen: what came out in a sentence, the next step as a command, the states of the model, what requirements
//! and sizes that leaves, what is missing and where, and the picture that shows it.

mod adopted;
pub(super) mod claims;
pub mod ladder;
mod missing;
mod outcome;
mod unconverged;

use crate::document::counted;
use crate::job::{calibrate, compare, conventional, diagnose, predict, propagate};
use crate::report::page::{Block, Figure, Section, Statement, Text, Tone};
use crate::report::view::PassReport;

use super::validation::{is_unconverged, tuned_in};
use super::{Entry, comparison, network, prediction, propagation, surrogate};

/// Statements on the first screen.
const MOST_STATEMENTS: usize = 6;

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The summary; always there.
pub(super) fn build(report: &PassReport<'_>) -> Option<Section> {
    let (headline, statements) = in_brief(report);
    let tone = if is_unconverged(report) { Tone::Warning } else { Tone::Verdict };
    let mut blocks: Vec<Block> = headline.map(|text| Block::callout(tone, text)).into_iter().collect();
    blocks.extend(outcome::next_step(report).map(|text| Block::callout(Tone::Next, text)));
    blocks.extend(adopted::in_predictions(report));
    blocks.extend(data_warnings(report));
    blocks.extend(prediction::untested::warning(report));
    let (table, notes) = ladder::table(report).unzip();
    blocks.extend(table.map(Block::Table));
    let pictures: Vec<Figure> = network::picture(report, true).into_iter().chain(main_picture(report)).collect();
    if !pictures.is_empty() {
        blocks.push(Block::Beside(pictures));
    }
    // Below the pictures: their captions belong on the first screen before this.
    blocks.extend(notes.map(Block::Small));
    if !statements.is_empty() {
        blocks.push(Block::Statements(statements));
    }
    blocks.extend(claims::objection_to_all(report).map(|text| Block::callout(Tone::Warning, text)));
    if let Some(note) = &report.reconstructed {
        blocks.push(Block::callout(Tone::Reconstructed, note.clone()));
    }
    blocks.extend(surrogate::notes(report));
    blocks.extend(report.warnings.iter().map(|w| Block::callout(Tone::Warning, w.clone())));
    if report.results.is_empty() {
        blocks.push(Block::callout(
            Tone::Note,
            "No job of this pass has a result yet; the sections below are its definition.",
        ));
    }
    Some(Section { id: "summary", title: "Summary".into(), blocks })
}

/// What must be known of the data before anything is believed, in short; the sections have all of it.
fn data_warnings(report: &PassReport<'_>) -> Option<Block> {
    let mut lines: Vec<String> = Vec::new();
    let doubts = report.outputs::<diagnose::Kind>().flat_map(|(_, output)| output.before_the_verdict());
    let compared = report.outputs::<compare::Kind>().flat_map(|(_, output)| output.warnings.iter().cloned());
    // Of what a diagnosis warns of, that which is about a sensor.
    let sensors = || report.measurements.iter().flat_map(|own| &own.sensors);
    let diagnosed = report.outputs::<diagnose::Kind>().flat_map(|(_, output)| output.warnings.iter().cloned());
    let diagnosed = diagnosed.filter(|line| sensors().any(|sensor| line.contains(sensor.name.as_str())));
    for line in doubts.chain(compared).chain(diagnosed) {
        // A doubt with its remedy holds the bare one.
        if !lines.iter().any(|own| own.contains(&line)) {
            lines.push(line);
        }
    }
    let (first, more) = lines.split_first()?;
    let ended = first.trim_end_matches('.');
    let more = match more.len() {
        0 => ".".to_owned(),
        count => format!("; {} below.", counted(count, "more warning")),
    };
    Some(Block::callout(Tone::Warning, Text::with_names(&format!("Data: {ended}{more}"))))
}

/// What came out and the key statements of the first screen.
pub(super) fn in_brief(report: &PassReport<'_>) -> (Option<Text>, Vec<Statement>) {
    let of_effects = adopted::sizes(report);
    let (mut before, mut after) = statements(report, of_effects.is_empty());
    // What was measured of the adopted effects has room in any case.
    let room = MOST_STATEMENTS - of_effects.len().min(MOST_STATEMENTS);
    before.truncate(room);
    after.truncate(room - before.len());
    before.extend(of_effects);
    before.extend(after);
    (outcome::headline(report), before)
}

/// The statements before and after those of the adopted effects' sizes, most important first; of a calibration that has none
/// of these what it tells most of.
fn statements(report: &PassReport<'_>, has_no_effect: bool) -> (Vec<Statement>, Vec<Statement>) {
    let mut statements = Vec::new();
    // What a calibrated model is for goes before how it came about.
    for (_, output) in report.outputs::<predict::Kind>() {
        let (about_requirements, _) = claims::of_predicted(report, output);
        statements.extend(about_requirements);
        statements.extend(claims::of_prediction(output));
    }
    for (position, (name, output)) in report.outputs::<diagnose::Kind>().enumerate() {
        if position == 0 {
            statements.extend(missing::of_diagnosis(output, report.model));
        } else {
            statements.push(missing::of_further(name, output));
        }
    }
    // Of what was found its size, before that of what was known to be there.
    if has_no_effect {
        let calibrations = report.outputs::<calibrate::Kind>();
        statements.extend(calibrations.filter_map(|(_, output)| outcome::of_calibration(output)));
    }
    let before = std::mem::take(&mut statements);
    // What a requirement or a size says goes before what a distribution says, where there is no room for all.
    let mut distributions = Vec::new();
    for (_, output) in report.outputs::<propagate::Kind>() {
        let (about_requirements, about_quantities) = claims::of_propagated(report, output);
        statements.extend(about_requirements);
        distributions.extend(about_quantities);
    }
    let is_one = report.outputs::<conventional::Kind>().count() == 1;
    for (name, output) in report.outputs::<conventional::Kind>() {
        statements.extend(claims::of_sizes(report, output, (!is_one).then_some(name)));
    }
    statements.extend(distributions);
    (before, statements)
}

/// The picture of the first screen; in full it stands in the section that it belongs to.
fn main_picture(report: &PassReport<'_>) -> Option<Figure> {
    // A state that the predictions do not rest on is no picture of them.
    let compared = || report.outputs::<compare::Kind>().find(|(_, output)| !output.rows.is_empty());
    if let Some((job, output)) = if tuned_in(report).is_some() { None } else { compared() } {
        let shows = comparison::Shows::of(output);
        let worst = comparison::worst_sensor(output);
        let first = output.rows.first()?;
        let measurement = worst.map_or(first.measurement, |s| s.measurement.as_str());
        if report.is_steady(measurement, &output.rows) {
            return Some(comparison::phase_map(report, job, output, measurement, shows, true));
        }
        let sensor = worst.map_or(first.sensor, |s| s.sensor.as_str());
        return Some(comparison::time_history(report, job, output, measurement, sensor, shows, true));
    }
    if let Some(figure) = report
        .outputs::<predict::Kind>()
        .find_map(|(job, prediction)| prediction::figures(prediction, job, true).into_iter().next())
    {
        return Some(figure);
    }
    let first = |job: &str, output: &propagate::Output| {
        let case = propagation::nominal_cases(output).next()?;
        Some(propagation::histogram(case, case.quantities.first()?, job, true))
    };
    if let Some((job, prediction)) = report.outputs::<predict::Kind>().next() {
        return first(job, &prediction.posterior);
    }
    let (job, output) = report.outputs::<propagate::Kind>().next()?;
    propagation::probability_figures(output, job, true).into_iter().next().or_else(|| first(job, output))
}
