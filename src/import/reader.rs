//! Which reader takes which files. A new reader is a line in [`READERS`].

use bmv_decks::esatan::{self, Form};
use bmv_decks::sinda::{self, SindaFile};
use bmv_decks::{Deck, DeckError, xija};
use thiserror::Error;

/// A file that is to be imported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeckFile {
    /// Its name, as the user gave it.
    pub name: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

impl DeckFile {
    /// Its text. What is no UTF-8 is read as Latin-1: decks are older than UTF-8, and what is beyond ASCII stands in
    /// their comments.
    pub fn text(&self) -> String {
        match std::str::from_utf8(&self.bytes) {
            Ok(text) => text.to_owned(),
            Err(_) => self.bytes.iter().map(|&byte| char::from(byte)).collect(),
        }
    }
}

/// A reader of one tool's files.
#[derive(Clone, Copy, Debug)]
pub struct Reader {
    /// The tool and what its files are, for people: `SINDA/FLUINT (.inp)`.
    pub tool: &'static str,
    /// Whether these are such files.
    pub recognises: fn(&[DeckFile]) -> bool,
    /// The deck that they are together.
    pub read: fn(&[DeckFile]) -> Result<Deck, Vec<DeckError>>,
}

/// All readers; the first that recognises the files reads them.
pub const READERS: &[Reader] = &[
    Reader {
        tool: "ESATAN-TMS results with the model in them (.TMD)",
        recognises: |files| is_esatan(files, Form::Tmd),
        read: |files| one(files, |file| esatan::read_tmd(&file.name, &file.bytes).map_err(|error| vec![error])),
    },
    Reader {
        tool: "ESATAN's dumps as CSV (nodes, conductors, temperatures)",
        recognises: |files| is_esatan(files, Form::Csv),
        read: |files| {
            let texts: Vec<(String, String)> = files.iter().map(|file| (file.name.clone(), file.text())).collect();
            esatan::read_csv(&texts)
        },
    },
    Reader {
        tool: "ESATAN's text of a model (.d)",
        recognises: |files| is_esatan(files, Form::Text),
        read: |files| one(files, |file| esatan::read_text(&file.name, &file.text())),
    },
    Reader {
        tool: "SINDA/FLUINT's and SINDA/G's text (.inp, .cc, .k, .hra, .hrl, .sin, with a printed .out)",
        recognises: |files| sinda_files(files, sinda::recognises),
        read: |files| sinda_files(files, sinda::read),
    },
    Reader {
        tool: "xija's model specifications (.json)",
        recognises: |files| files.iter().any(|file| xija::recognises(&file.text())),
        read: |files| one(files, |file| xija::read(&file.name, &file.text())),
    },
];

/// Whether all files are of a form of ESATAN.
fn is_esatan(files: &[DeckFile], form: Form) -> bool {
    !files.is_empty() && files.iter().all(|file| esatan::recognises(&file.bytes) == Some(form))
}

/// What is made of the files' names and texts.
fn sinda_files<T>(files: &[DeckFile], call: impl Fn(&[SindaFile<'_>]) -> T) -> T {
    let texts: Vec<String> = files.iter().map(DeckFile::text).collect();
    let files = files.iter().zip(&texts).map(|(file, text)| SindaFile { name: &file.name, text });
    call(&files.collect::<Vec<_>>())
}

/// Reads the only file of a model that is one file.
fn one(files: &[DeckFile], read: impl Fn(&DeckFile) -> Result<Deck, Vec<DeckError>>) -> Result<Deck, Vec<DeckError>> {
    match files {
        [file] => read(file),
        [_, second, ..] => {
            Err(vec![DeckError::of(&second.name, "a second file: this model is one file; import each into its study")])
        }
        [] => Err(vec![DeckError::of("", "no file")]),
    }
}

/// Files that are not read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ReadError {
    /// No reader recognises them.
    #[error("no reader recognises {files}: {readers}")]
    Unknown {
        /// The files, in words.
        files: String,
        /// What is read, in words.
        readers: String,
    },
    /// A reader refuses them.
    #[error("{}", .errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Refused {
        /// Why, each at its place.
        errors: Vec<DeckError>,
    },
}

/// The deck that some files are, by the first of some readers that recognises them.
///
/// # Errors
/// No reader recognises the files, or the one that does refuses them.
pub fn read(readers: &[Reader], files: &[DeckFile]) -> Result<Deck, ReadError> {
    let Some(reader) = readers.iter().find(|reader| (reader.recognises)(files)) else {
        let names: Vec<String> = files.iter().map(|file| format!("`{}`", file.name)).collect();
        let tools: Vec<&str> = readers.iter().map(|reader| reader.tool).collect();
        let readers = match tools.as_slice() {
            [] => "this build has no readers".to_owned(),
            _ => format!("there are readers of {}", tools.join(", ")),
        };
        return Err(ReadError::Unknown { files: names.join(", "), readers });
    };
    (reader.read)(files).map_err(|errors| ReadError::Refused { errors })
}
