//! A diagnosis in brief.

use super::verdict;
use crate::diagnosis::Output;
use crate::job::diagnose::Kind;
use crate::report::number::{self, NONE, significant};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

/// A diagnosis in brief.
pub(in crate::report::section) struct Diagnosis;

impl Brief for Diagnosis {
    type Kind = Kind;

    /// What must be mended first, then the verdict with what is missing and what that does to the error; all the rest is said by
    /// the verb for this kind.
    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let is_of = |word: &str, id: &String| word.contains(&format!("({id})"));
        let is_selected =
            |word: &&String| output.selected.iter().any(|id| is_of(word, id)) && !word.contains("(group ");
        let is_error = |word: &&String| word.starts_with("With it the RMSE") || word.starts_with("With them the RMSE");
        let (tuned, rest) = output.words.split_first().map_or((None, &[][..]), |(first, rest)| (Some(first), rest));
        let essential = rest.iter().filter(|word| is_selected(word) || is_error(word));
        let verdict = format!("verdict {}", verdict(output).in_plain_words());
        let tuned = tuned.filter(|_| output.selected.is_empty());
        output
            .before_the_verdict()
            .into_iter()
            .chain([verdict])
            .chain(tuned.into_iter().chain(essential).cloned())
            .collect()
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
