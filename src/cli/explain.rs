//! `bmv explain`.

use super::Context;
use super::output::{escaped, folded, print, table};
use super::status::{Failure, Status};
use crate::document::other_tools::{OTHER_WORDS, other_word};
use crate::document::result_words::{RESULT_WORDS, result_word};
use crate::document::{code, suggest};

/// Arguments of `bmv explain`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Words of results are explained too (adequate, identified, ambiguous, unexplained, group, converged), and those of \
                        other thermal tools: GL, GR, QI, QS, MLI, D, A and B nodes."
)]
pub(super) struct Explain {
    /// Code of a diagnostic, as it stands in its message, a word of a result or of another thermal tool [default: list all]
    code: Option<String>,
}

impl Explain {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let Some(name) = self.code else {
            let rows: Vec<_> = code::all().map(|code| vec![code.name.to_owned(), code.title.to_owned()]).collect();
            let results = RESULT_WORDS.iter().map(|entry| {
                let first = entry.meaning.split_once(". ").map_or(entry.meaning, |(first, _)| first);
                vec![entry.word.to_owned(), first.to_owned()]
            });
            let results = table(&results.collect::<Vec<_>>(), context.fold);
            let words = OTHER_WORDS.iter().map(|entry| vec![entry.word.to_owned(), entry.meaning.to_owned()]);
            let words = table(&words.collect::<Vec<_>>(), context.fold);
            let codes = table(&rows, context.fold);
            print(&format!("{codes}\nWords of results:\n{results}\nWords of other tools:\n{words}"))?;
            return Ok(Status::Done);
        };
        let Some(code) = code::find(&name) else {
            if let Some(own) = result_word(&name) {
                let meaning = folded("", &format!("{}: {}", own.word, own.meaning), context.fold);
                print(&format!("{meaning}\n{}", folded("", own.then, context.fold)))?;
                return Ok(Status::Done);
            }
            if let Some(other) = other_word(&name) {
                print(&format!("{}: {}\n\nWrite {}\n", other.word, other.meaning, other.write))?;
                return Ok(Status::Done);
            }
            let words = RESULT_WORDS.iter().map(|entry| entry.word);
            let near = suggest::nearest(&name, code::all().map(|code| code.name).chain(words));
            let hint = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            return Err(Failure::input(format!("there is no diagnostic and no word `{}`{hint}", escaped(&name))));
        };
        let explanation = folded("", code.explanation, context.fold);
        print(&format!("{}: {}\n\n{explanation}\n{}\n", code.name, code.title, code.example))?;
        Ok(Status::Done)
    }
}
