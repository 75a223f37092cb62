//! A diagnosis in brief.

use crate::diagnosis::Output;
use crate::job::diagnose::Kind;
use crate::report::number::{self, NONE, significant};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

/// A diagnosis in brief.
pub(in crate::report::section) struct Diagnosis;

impl Brief for Diagnosis {
    type Kind = Kind;

    /// What must be mended first, then the verdict in words.
    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        output.before_the_verdict().into_iter().chain(output.words.iter().cloned()).collect()
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
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
}
