//! A deck as a study: its files in memory, and how they are written into a folder.

use std::io;
use std::path::Path;

use bmv_decks::{Deck, Note};
use thiserror::Error;

use crate::batch::next_pass::text::Item;
use crate::document::visible::escaped;
use crate::study::file::{self, Existing};

use super::check::fault;
use super::model::{ModelFile, model};
use super::record::{self, Measured, measured};
use super::summary::Summary;
use super::{DECK_RESULT, PASS};

/// The model's file.
const MODEL: &str = "model.json";
/// The files of tables of conductors and radiations.
const TABLES: [&str; 2] = ["data/conductors.csv", "data/radiations.csv"];
/// The user's list of parts, so that the import can be made again.
const PARTS: &str = "data/parts.csv";

/// A deck that becomes no study.
#[derive(Debug, Error)]
pub enum ImportError {
    /// What a reader gave does not hold together.
    #[error("the deck `{title}` cannot be imported: {fault}")]
    Deck {
        /// Its title.
        title: String,
        /// What is wrong.
        fault: String,
    },
    /// The folder has something in it.
    #[error("`{folder}` is not empty, and an import replaces nothing; name another folder with --into")]
    NotEmpty {
        /// The folder.
        folder: String,
    },
    /// What the system says.
    #[error("cannot write `{path}`: {error}")]
    Unwritable {
        /// The file or folder.
        path: String,
        /// Why.
        error: io::Error,
    },
}

/// A study that was made of a deck.
#[derive(Debug)]
pub struct ImportedStudy {
    /// Its files by their path within it, in the order in which they are written: what names others comes last.
    pub files: Vec<(&'static str, String)>,
    /// What was read and what became of it.
    pub summary: Summary,
    /// What the closure of the record needs.
    pub(super) result: Option<DeckResult>,
}

/// The record's temperatures by the nodes' names in the study.
#[derive(Debug)]
pub(super) struct DeckResult {
    /// Names in the study, with the reader's notes and the temperatures of the rows of `data/record.csv`, K.
    pub nodes: Vec<ResultNode>,
    /// Instants of the same rows, s.
    pub times_s: Vec<f64>,
    /// Whether inputs keep a row's value until the next one.
    pub held: bool,
    /// The step of the printed temperatures, K.
    pub step_k: f64,
}

/// A node of a record.
#[derive(Debug)]
pub(super) struct ResultNode {
    pub name: String,
    /// What the reader noted of its heat.
    pub note: Option<String>,
    pub temperatures_k: Vec<f64>,
}

/// The study of a deck. `files` are the names of what it was read from.
///
/// # Errors
/// A deck that names what it does not have, or holds numbers that are not finite.
pub fn import(deck: &Deck, files: &[String]) -> Result<ImportedStudy, ImportError> {
    if let Some(fault) = fault(deck) {
        return Err(ImportError::Deck { title: escaped(&deck.title).into_owned(), fault });
    }
    let ModelFile { item, written, couplings, mut notes, parameters } = model(deck, files, TABLES);
    let measured = deck.record.as_ref().and_then(|record| measured(deck, record, &written));
    if deck.record.is_some() && measured.is_none() {
        notes.push("the record has no temperature of a node that is no boundary, and is left out".to_owned());
    }
    let mut study_files = Vec::new();
    for (path, table) in TABLES.into_iter().zip(couplings.tables) {
        study_files.extend(table.map(|table| (path, table)));
    }
    let mut result = None;
    if let (Some(record), Some(measured)) = (&deck.record, &measured) {
        notes.extend(measured.notes.iter().cloned());
        study_files.push((record::FILE, measured.csv.clone()));
        let of_rows = |values: &Vec<f64>| measured.rows.iter().filter_map(|&row| values.get(row).copied()).collect();
        let nodes = (deck.nodes.iter().zip(&record.temperatures_k).enumerate())
            .filter(|(index, _)| written.is_there[*index])
            .map(|(index, (node, values))| ResultNode {
                name: written.node(index).to_owned(),
                note: deck.notes.iter().find(|note| note.nodes.contains(&node.name)).map(in_words),
                temperatures_k: of_rows(values),
            })
            .collect();
        let (times_s, step_k) = (of_rows(&record.times_s), measured.step_k);
        result = Some(DeckResult { nodes, times_s, held: record.held, step_k });
    }
    study_files.push((MODEL, item.document()));
    study_files.push((PASS, pass(deck, measured.as_ref())));
    let counts = super::summary::counts(deck, &written.is_there, &couplings.became, parameters, measured.as_ref());
    let of_reader = deck.notes.iter().map(in_words);
    let summary = Summary {
        title: deck.title.clone(),
        tool: deck.tool.clone(),
        sources: files.to_vec(),
        counts,
        notes: of_reader.chain(notes).collect(),
        files: study_files.iter().map(|(path, _)| (*path).to_owned()).collect(),
    };
    Ok(ImportedStudy { files: study_files, summary, result })
}

/// A note of the reader, at its place.
fn in_words(note: &Note) -> String {
    match &note.place {
        Some(place) => format!("{place}: {}", note.message),
        None => note.message.clone(),
    }
}

/// The first pass: the model against what the other tool computed, where that is there.
fn pass(deck: &Deck, measured: Option<&Measured>) -> String {
    let mut entries = vec![
        ("format", Item::text(crate::study::pass::FORMAT)),
        ("title", Item::text(&format!("{}, as imported", escaped(&deck.title)))),
        ("parent", Item::Raw("null".to_owned())),
        ("model", Item::text(MODEL)),
        ("seed", Item::number(1.0)),
    ];
    let mut jobs = Vec::new();
    if let Some(measured) = measured {
        entries.push(("measurements", Item::one(DECK_RESULT, measured.item.clone())));
        let data = Item::one("data", Item::List(vec![Item::text(DECK_RESULT)]));
        jobs.push(("delivered".to_owned(), Item::one("compare", data)));
    }
    entries.push(("jobs", Item::Object(jobs)));
    Item::Object(entries.into_iter().map(|(key, item)| (key.to_owned(), item)).collect()).document()
}

/// Whether a study may be written into a folder.
///
/// # Errors
/// The folder holds something, or cannot be looked into.
pub fn check_folder(folder: &Path) -> Result<(), ImportError> {
    let shown = || escaped(&folder.display().to_string()).into_owned();
    match file::is_free(folder) {
        Ok(true) => Ok(()),
        Ok(false) => Err(ImportError::NotEmpty { folder: shown() }),
        Err(error) => Err(ImportError::Unwritable { path: shown(), error }),
    }
}

impl ImportedStudy {
    /// Keeps the list of parts by which the deck was divided.
    pub fn keep_parts(&mut self, text: String) {
        self.files.insert(0, (PARTS, text));
        self.summary.files.insert(0, PARTS.to_owned());
    }

    /// Writes the study into a folder that is made, or is empty.
    ///
    /// # Errors
    /// As [`check_folder`]; a file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), ImportError> {
        check_folder(folder)?;
        for (path, text) in &self.files {
            file::write(folder, Path::new(path), text.as_bytes(), Existing::Keep).map_err(|error| {
                ImportError::Unwritable { path: escaped(&folder.join(path).display().to_string()).into_owned(), error }
            })?;
        }
        Ok(())
    }
}
