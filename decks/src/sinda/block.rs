//! Blocks of a deck, with the files that it inserts.

use super::card::{Card, Comment, Header, Line, header, is_end, line};
use super::{SindaFile, base};
use crate::DeckError;

/// Files that insert one another are followed so deep.
const DEEPEST: usize = 16;

/// What a block holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// HEADER OPTIONS DATA: title and files.
    Options,
    /// HEADER CONTROL DATA: constants of the solution.
    Control,
    /// HEADER REGISTER DATA: names with expressions.
    Registers,
    /// HEADER NODE DATA.
    Nodes,
    /// HEADER CONDUCTOR DATA.
    Conductors,
    /// HEADER SOURCE DATA: heats.
    Sources,
    /// HEADER ARRAY DATA.
    Arrays,
    /// HEADER CARRAY DATA: lists of names.
    NameArrays,
    /// HEADER VARIABLES 0 and 1: statements at each instant and within the solution, of which heat at nodes is read.
    Heats,
    /// HEADER VARIABLES 2: statements behind each step.
    Logic,
    /// HEADER SUBROUTINE.
    Subroutines,
    /// Solver, output and operation: no part of the network.
    Unused,
    /// A part of the network that is not read.
    Refused,
}

impl Kind {
    fn of(words: &[String]) -> Option<Self> {
        let word = |at: usize| words.get(at).map_or("", String::as_str);
        Some(match word(0) {
            "OPTIONS" | "THERMAL" => Self::Options,
            "CONTROL" | "CONSTANTS" => Self::Control,
            "REGISTER" => Self::Registers,
            "NODE" => Self::Nodes,
            "CONDUCTOR" => Self::Conductors,
            "SOURCE" => Self::Sources,
            "ARRAY" => Self::Arrays,
            "CARRAY" => Self::NameArrays,
            "VARIABLES" if word(1) == "2" => Self::Logic,
            "VARIABLES" => Self::Heats,
            "SUBROUTINE" | "SUBROUTINES" => Self::Subroutines,
            "OPERATION" | "OPERATIONS" | "SOLVER" | "OUTPUT" | "PROCEDURE" | "RELIABILITY" | "EXECUTION" | "MODULE"
            | "END" => Self::Unused,
            "FLOW" | "FLOGIC" | "FPROP" | "MIXTURE" | "USER" => Self::Refused,
            _ => return None,
        })
    }

    /// Words of the header before the submodel's name.
    fn words_before_submodel(self) -> usize {
        match self {
            Self::Subroutines => 1,
            _ => 2,
        }
    }
}

/// Whether the words behind HEADER name a block.
pub(super) fn is_known(words: &[String]) -> bool {
    Kind::of(words).is_some()
}

/// A block.
#[derive(Debug)]
pub(super) struct Block<'a> {
    /// What it holds.
    pub(super) kind: Kind,
    /// The submodel, in capitals; empty where none is named.
    pub(super) submodel: String,
    /// Whether its header is a numbered one, as in SINDA/G: submodels have no names there, and END ends a block.
    pub(super) is_numbered: bool,
    /// The file's name.
    pub(super) file: &'a str,
    /// The line of its header.
    pub(super) line: usize,
    /// Its lines.
    pub(super) cards: Vec<Card<'a>>,
    /// Its comment lines.
    pub(super) comments: Vec<Comment<'a>>,
}

/// Cuts the files into blocks.
pub(super) fn blocks<'a>(files: &[SindaFile<'a>], errors: &mut Vec<DeckError>) -> Vec<Block<'a>> {
    let inserts = |file: &SindaFile<'a>, other: &str| {
        file.base() != other && file.text.lines().filter_map(insert).any(|name| is_same(&name, other))
    };
    let is_inserted = |file: &SindaFile<'_>| files.iter().any(|other| inserts(other, &file.base()));
    let mut reading =
        Reading { files, blocks: Vec::new(), leading: Vec::new(), errors, opened: Vec::new(), read: Vec::new() };
    for file in files.iter().filter(|file| !is_inserted(file)) {
        reading.open(*file);
    }
    if let Some(file) = files.iter().find(|file| !reading.read.contains(&file.base())) {
        reading.errors.push(DeckError::of(file.name, "files insert one another in a circle: expected one that begins"));
    }
    reading.blocks
}

/// The name of an inserted file.
fn insert(text: &str) -> Option<String> {
    let Line::Card(code) = line(text, false) else { return None };
    let (word, name) = code.split_once(char::is_whitespace)?;
    word.eq_ignore_ascii_case("INSERT").then(|| base(name.trim().trim_matches(['\'', '"'])))
}

/// Whether a file is the one that is inserted: a binary twin `.k_in` stands for the text `.k`.
fn is_same(inserted: &str, file: &str) -> bool {
    inserted == file || inserted.strip_suffix("_in").is_some_and(|text| text == file)
}

struct Reading<'a, 'r> {
    files: &'r [SindaFile<'a>],
    blocks: Vec<Block<'a>>,
    /// Comments before the first block.
    leading: Vec<Comment<'a>>,
    errors: &'r mut Vec<DeckError>,
    /// Files that insert the one that is read.
    opened: Vec<String>,
    /// Files that were read.
    read: Vec<String>,
}

impl<'a> Reading<'a, '_> {
    fn open(&mut self, file: SindaFile<'a>) {
        let name = file.base();
        self.opened.push(name.clone());
        self.read.push(name);
        let mut comment = None;
        let mut is_numbered = false;
        for (number, text) in (1..).zip(file.text.lines()) {
            if let Some(header) = header(text) {
                comment = None;
                is_numbered = header.is_numbered;
                self.begin(file, number, &header);
                continue;
            }
            if let Some(name) = insert(text) {
                comment = None;
                self.insert(file, number, &name);
                continue;
            }
            match line(text, is_numbered) {
                Line::Blank => {}
                Line::Comment(text) => {
                    let one = Comment { line: number, text };
                    comment = Some(one);
                    match self.blocks.last_mut() {
                        Some(block) => block.comments.push(one),
                        None => self.leading.push(one),
                    }
                }
                Line::Card(code) if is_end(code) => break,
                Line::Card(code) if code.eq_ignore_ascii_case("PSTOP") || code.eq_ignore_ascii_case("PSTART") => {}
                Line::Card(text) => {
                    if is_numbered && text.eq_ignore_ascii_case("END") && !self.is_of_arrays() {
                        continue;
                    }
                    let card = Card { file: file.name, line: number, text, comment };
                    match self.blocks.last_mut() {
                        Some(block) => block.cards.push(card),
                        None => {
                            self.errors.push(DeckError::at(
                                file.name,
                                number,
                                "expected a line `HEADER ...` before it",
                            ));
                            break;
                        }
                    }
                }
            }
        }
        self.opened.pop();
    }

    /// Whether the block that is read is one of arrays, whose own END is theirs too.
    fn is_of_arrays(&self) -> bool {
        self.blocks.last().is_some_and(|block| block.kind == Kind::Arrays)
    }

    fn begin(&mut self, file: SindaFile<'a>, number: usize, header: &Header) {
        let words = header.words.as_slice();
        let Some(kind) = Kind::of(words) else {
            let message = format!("`HEADER {}` is not known: expected NODE DATA, CONDUCTOR DATA, ...", words.join(" "));
            return self.errors.push(DeckError::at(file.name, number, message));
        };
        let submodel = words.get(kind.words_before_submodel()).cloned().unwrap_or_default();
        let submodel = if header.is_numbered { String::new() } else { submodel };
        self.blocks.push(Block {
            kind,
            submodel,
            is_numbered: header.is_numbered,
            file: file.name,
            line: number,
            cards: Vec::new(),
            comments: std::mem::take(&mut self.leading),
        });
    }

    fn insert(&mut self, file: SindaFile<'a>, number: usize, name: &str) {
        let mut fail = |message: String| self.errors.push(DeckError::at(file.name, number, message));
        let Some(inserted) = self.files.iter().find(|other| is_same(name, &other.base())) else {
            let twin = name.strip_suffix("_in").map(|text| format!(", or its text `{text}`")).unwrap_or_default();
            return fail(format!("`{name}` is inserted here and is not among the files: give it too{twin}"));
        };
        let base = inserted.base();
        if self.opened.contains(&base) {
            return fail(format!("`{name}` inserts itself"));
        }
        if self.opened.len() >= DEEPEST {
            return fail(format!("files insert one another more than {DEEPEST} deep"));
        }
        if self.read.contains(&base) {
            return fail(format!("`{name}` is inserted a second time"));
        }
        self.open(*inserted);
    }
}
