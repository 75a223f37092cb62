//! A comparison in brief.

use crate::document::counted;
use crate::job::compare::{Kind, Output, Verdict};
use crate::report::headline::MOST_FINDINGS;
use crate::report::number::Shown;
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

/// A comparison in brief.
pub(in crate::report::section) struct Comparison;

impl Brief for Comparison {
    type Kind = Kind;

    /// RMSE and criteria, then where it fails.
    fn headline(job: &JobEntry, output: &Output) -> Vec<String> {
        let untuned = job.untuned();
        // Once at length.
        let state = if job.has_adopted { "untuned" } else { untuned };
        let units: Vec<&str> = output.sensors.iter().map(|sensor| sensor.unit.as_str()).collect();
        let mut parts = Vec::new();
        if let Some(unit) = units.first().filter(|unit| units.iter().all(|other| other == *unit)) {
            let shown = Shown::si(unit);
            let tuned = output.tuned.as_ref();
            let sets = [
                ("", &output.train, tuned.map(|tuned| &tuned.train)),
                (" on held-out readings", &output.held_out, tuned.map(|tuned| &tuned.held_out)),
            ];
            for (readings, delivered, tuned) in sets.into_iter().filter(|(_, delivered, _)| delivered.count > 0) {
                let delivered = shown.text(delivered.rmse);
                parts.push(match tuned {
                    Some(tuned) => format!("RMSE{readings} {delivered} {untuned}, {} tuned", shown.text(tuned.rmse)),
                    None => format!("RMSE{readings} {delivered} {untuned}"),
                });
            }
        }
        if !output.verdicts.is_empty() {
            let [kept, tuned] = [&output.verdicts, &output.tuned_verdicts()].map(|verdicts| kept(verdicts));
            let tuned = if output.tuned.is_some() { format!(", {tuned} tuned") } else { String::new() };
            parts.push(format!("{kept} criteria kept {state}{tuned} ({})", output.criteria.title));
        }
        if !output.failed.is_empty() {
            parts.push(format!("{} without a prediction", counted(output.failed.len(), "phase")));
        }
        let mut lines = vec![parts.join("; ")];
        lines.extend(output.fails.iter().take(MOST_FINDINGS).map(|finding| format!("{state}, {finding}")));
        if output.fails.len() > MOST_FINDINGS {
            let more = counted(output.fails.len() - MOST_FINDINGS, "more finding");
            lines.push(format!("and {more}"));
        } else if output.fails.is_empty() {
            let judged = "the model fails at no place".to_owned();
            lines.push(format!("{state}, {}", super::largest_error(output).unwrap_or(judged)));
        }
        lines
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let mut rows = Vec::new();
        for sensor in &output.sensors {
            let shown = Shown::si(&sensor.unit);
            let tuned = sensor.tuned.as_ref();
            let states = [
                ("untuned", Some((&sensor.train, &sensor.held_out))),
                ("tuned", tuned.map(|tuned| (&tuned.train, &tuned.held_out))),
            ];
            for (state, deviations) in states {
                let Some((train, held_out)) = deviations else { continue };
                for (readings, errors) in [("for fitting", train), ("held out", held_out)] {
                    if errors.count > 0 {
                        let name =
                            format!("{}, {}: RMSE {state}, readings {readings}", sensor.measurement, sensor.sensor);
                        rows.push((name, shown.text(errors.rmse)));
                    }
                }
            }
        }
        if !output.verdicts.is_empty() {
            rows.push(("criteria kept untuned".to_owned(), kept(&output.verdicts)));
            if output.tuned.is_some() {
                rows.push(("criteria kept tuned".to_owned(), kept(&output.tuned_verdicts())));
            }
        }
        rows
    }
}

/// How many of some criteria are kept.
fn kept(verdicts: &[Verdict]) -> String {
    format!("{} of {}", verdicts.iter().filter(|verdict| verdict.kept).count(), verdicts.len())
}
