//! `bmv import`.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::Context;
use super::import_csv::Csv;
use super::output::{escaped, print, print_json, shown, table, tell};
use super::status::{Failure, Status};
use crate::document::visible::shell_word;
use crate::import::reader::{self, READERS};
use crate::import::{Closure, DeckFile, PASS, Summary, closure, import, parts, study};
use crate::study::file;

/// Larger files are refused, in bytes.
const LARGEST: u64 = 256 << 20;
/// Diagnostics printed of a study that is not accepted.
const MOST_DIAGNOSTICS: usize = 20;

/// Arguments of `bmv import`.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "All files together are one model: a deck with its results. The study is a model, a pass and, where \
                        the files tell what the other tool computed, that as a measurement. Which nodes balance with it \
                        is printed: what does not balance was left out."
)]
pub(super) struct Import {
    #[command(subcommand)]
    what: Option<What>,
    /// Files of the other tool
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Folder of the new study; it is made
    #[arg(long, required = true, value_name = "STUDY")]
    into: Option<PathBuf>,
    /// CSV file of the model's parts, `part,first,last`: names and ranges of node numbers
    ///
    /// Conductors within a part and between two parts get a factor as a parameter, the part's heats and boundary
    /// temperatures become inputs, and a diagnosis tries each part as a place. Without it a deck that names no
    /// parameters is divided by its submodels and labels.
    #[arg(long, value_name = "FILE")]
    parts: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// What is imported, where it is no model.
#[derive(Debug, clap::Subcommand)]
enum What {
    /// Bring measurements as a logger wrote them into a study
    Csv(Csv),
}

/// What `--json` prints.
#[derive(Serialize)]
struct Imported<'a> {
    study: String,
    #[serde(flatten)]
    summary: &'a Summary,
    closure: Option<&'a Closure>,
}

impl Import {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        if let Some(What::Csv(verb)) = self.what {
            return verb.execute(context);
        }
        let into = self.into.ok_or_else(|| Failure::input("--into STUDY is needed".to_owned()))?;
        let wrong = |error: study::ImportError| Failure::input(error.to_string());
        study::check_folder(&into).map_err(wrong)?;
        let files = self.files.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
        let mut deck = reader::read(READERS, &files).map_err(|error| Failure::input(error.to_string()))?;
        let parts = self.parts.as_deref().map(read).transpose()?;
        match &parts {
            Some(file) => {
                let ranges = parts::ranges(&file.name, &file.text());
                ranges
                    .and_then(|ranges| parts::divide_by_ranges(&mut deck, &file.name, &ranges))
                    .map_err(|error| Failure::input(error.to_string()))?;
            }
            None if deck.parameters.is_empty() => parts::divide_by_groups(&mut deck),
            None => {}
        }
        let names: Vec<String> = files.into_iter().map(|file| file.name).collect();
        let mut imported = import(&deck, &names).map_err(wrong)?;
        if let Some(file) = &parts {
            imported.keep_parts(file.text());
        }
        imported.write(&into).map_err(wrong)?;
        let pass = into.join(PASS);
        // Loaded as any study is: what the deck says must be what the format understands.
        let loaded = crate::study::load(&crate::job::kinds(), &pass).map_err(|diagnostics| {
            let report = diagnostics.render(context.coloured, MOST_DIAGNOSTICS);
            let folder = shown(&into);
            Failure::rendered(format!("{report}\n`{folder}` was written, but is no study yet: mend these places there"))
        })?;
        let closure = closure::closure(&imported, &loaded)
            .map_err(|error| Failure::input(format!("the network cannot be solved: {error}")))?;
        let summary = &imported.summary;
        if self.json {
            let study = into.display().to_string();
            print_json(&Imported { study, summary, closure: closure.as_ref() })?;
            return Ok(Status::Done);
        }
        if !loaded.warnings.is_empty() {
            tell(&loaded.warnings.render(context.coloured, MOST_DIAGNOSTICS));
        }
        let mut text = summary.in_words();
        if let Some(closure) = &closure {
            text.push_str(&closure.in_words());
            if closure.closing() < closure.nodes.len() {
                text.push_str(&table(&closure.table(), context.fold));
            }
        }
        text.push_str(&format!("Made {}: {}; now try\n", shown(&into), summary.files.join(", ")));
        let next = if loaded.jobs.is_empty() { ("plan", into) } else { ("compare", pass) };
        text.push_str(&format!("bmv {} {}\n", next.0, escaped(&shell_word(&next.1.display().to_string()))));
        print(&text)?;
        Ok(Status::Done)
    }
}

/// A file of the user's.
pub(super) fn read(path: &Path) -> Result<DeckFile, Failure> {
    let name = path.display().to_string();
    // A link that the user names is the user's own.
    let bytes = path.canonicalize().and_then(|real| file::read(&real, LARGEST));
    match bytes {
        Ok(bytes) => Ok(DeckFile { name, bytes }),
        Err(error) => Err(Failure::input(format!("cannot read `{}`: {error}", escaped(&name)))),
    }
}
