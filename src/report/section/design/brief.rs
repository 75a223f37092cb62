//! A design of experiments in brief.

use crate::job::design::{Kind, Output};
use crate::report::headline::MOST_FINDINGS;
use crate::report::number::{self, NONE};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

use super::conditions;

/// A design of experiments in brief.
pub(in crate::report::section) struct Design;

impl Brief for Design {
    type Kind = Kind;

    /// The best candidate, and what must be said of it.
    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(best) = &output.best {
            let conditions = conditions(output, best.candidate);
            let value = number::with_error(best.information_nats, best.se);
            lines.push(format!("{conditions} tells most about {}: {value} nats expected", output.learn.join(", ")));
        }
        if !output.is_trusted {
            lines.push("no candidate is named: no estimate of the information can be trusted".to_owned());
        }
        lines.extend(output.findings.iter().take(MOST_FINDINGS).cloned());
        lines
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let mut rows = vec![("estimator".to_owned(), output.estimator.clone())];
        let best = output.best.as_ref();
        let best_conditions = best.map_or_else(|| NONE.to_owned(), |best| conditions(output, best.candidate));
        rows.push(("best candidate".to_owned(), best_conditions));
        let nats = best.map_or_else(|| NONE.to_owned(), |best| number::with_error(best.information_nats, best.se));
        rows.push(("information expected of it, nats".to_owned(), nats));
        for (position, pick) in output.picks.iter().enumerate() {
            rows.push((format!("phase {} to pick", position + 1), conditions(output, pick.position)));
        }
        rows.push(("findings".to_owned(), output.findings.join(" ")));
        rows
    }
}
