//! A test plan in brief.

use crate::document::counted;
use crate::job::test_plan::{Kind, Output};
use crate::report::number::{NONE, probability};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

use super::time;

/// A test plan in brief.
pub(in crate::report::section) struct TestPlan;

/// The largest probability outside red limits, with its phase and node.
fn worst(output: &Output) -> Option<(f64, &str, &str)> {
    let of = output.phases.iter().flat_map(|phase| {
        phase.limits.iter().filter_map(|own| Some((own.outside_red?.value, phase.name.as_str(), own.node.as_str())))
    });
    of.fold(None, |worst, next| if worst.is_none_or(|(most, ..)| next.0 > most) { Some(next) } else { worst })
}

impl Brief for TestPlan {
    type Kind = Kind;

    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let duration = output.duration_s[0].map_or_else(|| "of unknown duration".to_owned(), time);
        let red = worst(output).map_or_else(
            || "no node has red limits".to_owned(),
            |(value, phase, node)| {
                format!("red limits are left with probability {} at most ({node}, {phase})", probability(value))
            },
        );
        vec![format!("{}, {duration}; {red}", counted(output.phases.len(), "phase"))]
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let text = |time_s: Option<f64>| time_s.map_or_else(|| NONE.to_owned(), time);
        let red = worst(output).map_or_else(|| NONE.to_owned(), |(value, ..)| probability(value));
        vec![
            ("duration, nominal".to_owned(), text(output.duration_s[0])),
            ("duration, 95 % of the samples".to_owned(), text(output.duration_s[3])),
            ("outside red limits, at most".to_owned(), red),
        ]
    }
}
