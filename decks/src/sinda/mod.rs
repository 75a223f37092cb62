//! Decks of SINDA/FLUINT and SINDA/G as text: `.inp`, `.cc`, `.k`, `.hra`, `.hrl` as Thermal Desktop writes them, `.sin` with
//! numbered headers (`BCD 3NODE DATA`), and the printed result `.out`.
//!
//! The layout was read off public decks of Thermal Desktop 6.2 (`bpar907/APSS-2-Thermal-TXRX`, `oresat/oresat-thermal`) and
//! SINDA/G (`afcarl/RR062`), and follows the SINDA/FLUINT user's manual (C&R Technologies). Data blocks are read. Code is refused
//! at its line, but for heat given to a node in VARIABLES 0 and 1, heaters of Thermal Desktop, and what it always writes and
//! that has no physics in it.

mod arrays;
mod assembly;
mod block;
mod card;
mod conductors;
mod control;
mod heaters;
mod heating;
mod law;
mod loads;
mod nodes;
mod result;
mod seen;
mod subroutines;
mod thermostat;
mod units;

use crate::{Deck, DeckError};

pub use result::read_result;

/// Most errors that are reported of one deck.
const MOST_ERRORS: usize = 50;

/// A text file of a deck.
#[derive(Debug, Clone, Copy)]
pub struct SindaFile<'a> {
    /// Its name, with or without folders.
    pub name: &'a str,
    /// Its text.
    pub text: &'a str,
}

impl SindaFile<'_> {
    /// Its name without folders, in small letters: INSERT is blind to both.
    fn base(&self) -> String {
        base(self.name)
    }

    /// Whether it has a block of a deck.
    fn is_deck(&self) -> bool {
        self.text.lines().any(|line| card::header(line).is_some_and(|header| block::is_known(&header.words)))
    }

    /// Whether it is what SINDA/FLUINT printed.
    fn is_result(&self) -> bool {
        result::is_printed(self.text)
    }
}

fn base(name: &str) -> String {
    name.rsplit(['/', '\\']).next().unwrap_or(name).to_ascii_lowercase()
}

/// Whether the files are a deck, with or without its printed result.
pub fn recognises(files: &[SindaFile<'_>]) -> bool {
    files.iter().any(SindaFile::is_deck)
}

/// Reads a deck: its blocks in the order of the files that insert others, then those of files that nothing inserts.
///
/// Named contacts become parameters in W/K, the sum of their conductors, each a share of it. Named heat loads become inputs in
/// W likewise. Each set of radiation conductors and of heating rates gets a scale with the nominal value 1. Groups are
/// submodels and contacts. Temperatures of a printed steady state become the record, else those of a printed transient.
///
/// # Errors
/// Each line that is not understood, fifty at most.
pub fn read(files: &[SindaFile<'_>]) -> Result<Deck, Vec<DeckError>> {
    let (results, decks): (Vec<_>, Vec<_>) =
        files.iter().copied().partition(|file| file.is_result() && !file.is_deck());
    let mut errors = Vec::new();
    let blocks = block::blocks(&decks, &mut errors);
    let mut deck = assembly::assemble(&blocks, &mut errors);
    if let [result] = results.as_slice() {
        match result::record(result, &deck.deck.nodes, deck.units, deck.has_means) {
            Ok((record, notes)) => {
                deck.deck.notes.extend(notes);
                deck.add_record(record);
            }
            Err(error) => errors.push(error),
        }
    } else if let [_, second, ..] = results.as_slice() {
        errors.push(DeckError::of(second.name, "a second printed result: give the one that belongs to the deck"));
    }
    if errors.is_empty() {
        return Ok(deck.deck);
    }
    errors.truncate(MOST_ERRORS);
    Err(errors)
}
