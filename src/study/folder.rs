//! The folder of a study: nothing that a study names lies outside it, and nothing is read that is no plain file or too
//! large for the memory.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use thiserror::Error;

use crate::document::json;

use super::inherit::plain_name;
use super::ledger::{Content, Ledger};

/// Tables larger than this are refused, in bytes.
pub const TABLE_SIZE: usize = 256 << 20;

/// Why a path is refused or cannot be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum FolderError {
    /// The path is not plain.
    #[error("the path `{path}` leaves the study's folder: write it relative to that folder, without `..`")]
    NotPlain {
        /// As written.
        path: String,
    },
    /// A link leads out of the folder.
    #[error("the path `{path}` leads out of the study's folder through a link")]
    LeadsOut {
        /// As written.
        path: String,
    },
    /// There is no such file.
    #[error("the file `{path}` does not exist in the study's folder")]
    Missing {
        /// As written.
        path: String,
    },
    /// The file is larger than may be read.
    #[error("the file `{path}` has {bytes} bytes; at most {limit} are read")]
    TooLarge {
        /// As written.
        path: String,
        /// Its bytes, as many as were seen.
        bytes: u64,
        /// The limit.
        limit: usize,
    },
    /// The file system refuses.
    #[error("`{path}` cannot be read: {reason}")]
    Unreadable {
        /// As written.
        path: String,
        /// What the system says.
        reason: String,
    },
}

/// The folder of a study.
#[derive(Clone, Debug)]
pub struct Folder {
    root: PathBuf,
    shown: PathBuf,
    /// What was read.
    ledger: Ledger,
}

impl Folder {
    /// The folder at a path.
    ///
    /// # Errors
    /// There is no such folder.
    pub fn open(path: &Path) -> Result<Self, FolderError> {
        let shown = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        let text = shown.display().to_string();
        match shown.canonicalize() {
            Ok(root) if root.is_dir() => Ok(Self { root, shown: path.to_owned(), ledger: Ledger::default() }),
            Ok(_) => Err(FolderError::Unreadable { path: text, reason: "it is no folder".to_owned() }),
            Err(error) => Err(FolderError::Unreadable { path: text, reason: error.to_string() }),
        }
    }

    /// The path as the user gave it.
    pub fn shown(&self) -> &Path {
        &self.shown
    }

    /// The folder with files that were read before: read again, they must be the same.
    pub fn after(self, files: BTreeMap<String, Content>) -> Self {
        Self { ledger: Ledger::with(files), ..self }
    }

    /// The folder itself, links resolved.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The files that were read through this folder, by their plain path within it, as they were then.
    pub fn files(&self) -> BTreeMap<String, Content> {
        self.ledger.files()
    }

    /// The name under which messages show one of its files.
    pub fn shown_name(&self, relative: &str) -> String {
        self.shown.join(relative).display().to_string()
    }

    /// Where a file of the folder lies or would lie: the path is plain (no `..`, not absolute) and what exists of it
    /// stays inside the folder, links followed.
    ///
    /// # Errors
    /// A path that is not plain or leads out.
    pub fn place(&self, relative: &str) -> Result<PathBuf, FolderError> {
        let path = Path::new(relative);
        let plain = !relative.is_empty()
            && !relative.contains(['\\', '\0'])
            && path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
            && path.components().any(|part| matches!(part, Component::Normal(_)));
        if !plain {
            return Err(FolderError::NotPlain { path: relative.to_owned() });
        }
        let place = self.root.join(path);
        let mut existing = place.as_path();
        loop {
            if existing.symlink_metadata().is_ok() {
                return match existing.canonicalize() {
                    Ok(real) if real.starts_with(&self.root) => Ok(place),
                    // A link to nothing is refused too: what is written through it would land elsewhere.
                    Ok(_) | Err(_) => Err(FolderError::LeadsOut { path: relative.to_owned() }),
                };
            }
            match existing.parent() {
                Some(parent) => existing = parent,
                None => return Err(FolderError::Missing { path: relative.to_owned() }),
            }
        }
    }

    /// Notes what a file was when it was read elsewhere.
    ///
    /// # Errors
    /// It was another when it was read here before.
    pub(super) fn note(&self, relative: &str, content: Content) -> Result<(), FolderError> {
        if self.ledger.note(&plain_name(relative), content) {
            return Ok(());
        }
        let reason = "it changed while the study was read; run the command again".to_owned();
        Err(FolderError::Unreadable { path: relative.to_owned(), reason })
    }

    /// The bytes of a JSON file of the folder. They are noted: a file that is read twice is the same both times.
    ///
    /// # Errors
    /// A path that is refused, a file that is missing, unreadable, no plain file or too large, or that changed since it
    /// was read before.
    pub fn read(&self, relative: &str) -> Result<Vec<u8>, FolderError> {
        self.read_at_most(relative, json::SIZE)
    }

    /// The bytes of a CSV file of the folder.
    ///
    /// # Errors
    /// As [`Folder::read`].
    pub fn read_table(&self, relative: &str) -> Result<Vec<u8>, FolderError> {
        self.read_at_most(relative, TABLE_SIZE)
    }

    /// Whether there is a plain file at a path that is not refused.
    pub fn has_file(&self, relative: &str) -> bool {
        self.place(relative).is_ok_and(|place| place.is_file())
    }

    /// The bytes of a plain file. Kind and size are looked at first: to open a pipe waits for its writer, and the size of
    /// a file says nothing about the room on its disk.
    fn read_at_most(&self, relative: &str, limit: usize) -> Result<Vec<u8>, FolderError> {
        let place = self.place(relative)?;
        let path = || relative.to_owned();
        let too_large = |bytes: u64| FolderError::TooLarge { path: path(), bytes, limit };
        let unreadable = |reason: String| FolderError::Unreadable { path: path(), reason };
        let data = place.metadata().map_err(|_| FolderError::Missing { path: path() })?;
        if !data.is_file() {
            return Err(unreadable("it is no file".to_owned()));
        }
        if data.len() > limit as u64 {
            return Err(too_large(data.len()));
        }
        let mut bytes = Vec::new();
        let read = std::fs::File::open(&place).and_then(|file| file.take(limit as u64 + 1).read_to_end(&mut bytes));
        read.map_err(|error| unreadable(error.to_string()))?;
        // It may have grown since.
        if bytes.len() > limit {
            return Err(too_large(bytes.len() as u64));
        }
        self.note(relative, Content::of(&bytes))?;
        Ok(bytes)
    }

    /// Names of the JSON files of a folder below, without `.json`, sorted; none where it does not exist.
    pub fn json_names(&self, below: &str) -> Vec<String> {
        let Ok(place) = self.place(below) else { return Vec::new() };
        let Ok(entries) = std::fs::read_dir(place) else { return Vec::new() };
        let mut names: Vec<String> = entries
            .flatten()
            .filter_map(|entry| entry.file_name().to_str()?.strip_suffix(".json").map(str::to_owned))
            .filter(|name| !name.is_empty() && !name.starts_with('.'))
            .collect();
        names.sort();
        names
    }
}
