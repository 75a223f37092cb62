//! `bmv explain`.

use super::Context;
use super::output::{escaped, folded, print, table};
use super::status::{Failure, Status};
use crate::document::{code, suggest};

/// Arguments of `bmv explain`.
#[derive(Debug, clap::Args)]
pub(super) struct Explain {
    /// Code of a diagnostic, as it stands in its message [default: list all]
    code: Option<String>,
}

impl Explain {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let Some(name) = self.code else {
            let rows: Vec<_> = code::all().map(|code| vec![code.name.to_owned(), code.title.to_owned()]).collect();
            print(&table(&rows, context.fold))?;
            return Ok(Status::Done);
        };
        let Some(code) = code::find(&name) else {
            let near = suggest::nearest(&name, code::all().map(|code| code.name));
            let hint = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            return Err(Failure::input(format!("there is no diagnostic `{}`{hint}", escaped(&name))));
        };
        let explanation = folded("", code.explanation, context.fold);
        print(&format!("{}: {}\n\n{explanation}\n{}\n", code.name, code.title, code.example))?;
        Ok(Status::Done)
    }
}
