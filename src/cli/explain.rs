//! `bmv explain`.

use super::Context;
use super::output::{escaped, folded, print, table};
use super::status::{Failure, Status};
use crate::document::other_tools::{OTHER_WORDS, other_word};
use crate::document::{code, suggest};

/// Arguments of `bmv explain`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Words of other thermal tools are explained too: GL, GR, QI, QS, MLI, D, A and B nodes.")]
pub(super) struct Explain {
    /// Code of a diagnostic, as it stands in its message, or a word of another thermal tool [default: list all]
    code: Option<String>,
}

impl Explain {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let Some(name) = self.code else {
            let rows: Vec<_> = code::all().map(|code| vec![code.name.to_owned(), code.title.to_owned()]).collect();
            let words = OTHER_WORDS.iter().map(|entry| vec![entry.word.to_owned(), entry.meaning.to_owned()]);
            let words = table(&words.collect::<Vec<_>>(), context.fold);
            print(&format!("{}\nWords of other tools:\n{words}", table(&rows, context.fold)))?;
            return Ok(Status::Done);
        };
        let Some(code) = code::find(&name) else {
            if let Some(other) = other_word(&name) {
                print(&format!("{}: {}\n\nWrite {}\n", other.word, other.meaning, other.write))?;
                return Ok(Status::Done);
            }
            let near = suggest::nearest(&name, code::all().map(|code| code.name));
            let hint = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            return Err(Failure::input(format!("there is no diagnostic `{}`{hint}", escaped(&name))));
        };
        let explanation = folded("", code.explanation, context.fold);
        print(&format!("{}: {}\n\n{explanation}\n{}\n", code.name, code.title, code.example))?;
        Ok(Status::Done)
    }
}
