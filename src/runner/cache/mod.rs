//! The cache: finished results and blocks by their keys, verified on every read.
//!
//! An object is published whole or not at all: written under a temporary name in its own folder, then linked to its final
//! name. A link refuses to replace, so the first of several writers wins and the others compare; bytes that differ for
//! one key are a bug that is reported, with both kept. Damaged objects, and what lies at an object's place without being
//! a regular file, are moved to `quarantine/` and computed again. Several processes may use one cache at the same time;
//! nothing is locked. The cache's folder may be a link; in it none is followed.

pub mod object;
pub mod tidy;

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

pub use object::Kind;
pub(super) use tidy::host;
pub use tidy::{Pruned, Statistics, Verified};

use super::error::RunnerError;
use super::key::Key;
use crate::study::file::{self, Draft, Existing};

/// Largest object, bytes: larger ones are not stored, and what is larger is none.
pub const LARGEST: u64 = 1 << 30;

/// What a look into the cache finds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lookup {
    /// The payload, verified.
    Found(Vec<u8>),
    /// Nothing is stored under this name, or it cannot be read.
    Absent,
    /// Something is stored, but torn or altered. It was moved out of the way, if the cache can be written.
    Damaged,
}

/// A cache in a folder. Opening touches nothing; folders are made when the first object is stored.
#[derive(Debug)]
pub struct Cache {
    root: PathBuf,
    /// Folders of objects in which this process has written: they exist, and leftovers in them were removed.
    prepared: Vec<AtomicBool>,
    /// Part of the temporary names of this process.
    writer: String,
    counter: AtomicU64,
    /// Whether blocks, too, are flushed to the disk before they get their name.
    is_shared: bool,
}

impl Cache {
    /// The cache in the folder `root`, which need not exist.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self {
            root: root.into(),
            prepared: (0..256).map(|_| AtomicBool::new(false)).collect(),
            writer: tidy::writer_prefix(),
            counter: AtomicU64::new(0),
            is_shared: false,
        }
    }

    /// The same for a writer among several machines: blocks are flushed as results are, since others read them at once and
    /// this machine may be lost. `task` names the writer where machines have equal names: letters and digits.
    #[must_use]
    pub fn shared(self, task: &str) -> Self {
        Self { writer: format!("{}-{task}", self.writer), is_shared: true, ..self }
    }

    /// Whether something lies at an object's place. The place is opened: what a listing says may be old on a shared file
    /// system.
    pub fn is_there(&self, name: &Key) -> bool {
        File::open(self.path(name)).is_ok()
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Where the object of this name lies, if it is stored.
    pub fn path(&self, name: &Key) -> PathBuf {
        self.root.join(self.place(name))
    }

    /// An object's place below the root.
    fn place(&self, name: &Key) -> PathBuf {
        let (folder, file) = name.as_str().split_at(2);
        Path::new("objects").join(folder).join(file)
    }

    /// Reads and verifies an object. A cache that cannot be read is like an empty one.
    pub fn get(&self, kind: Kind, name: &Key) -> Lookup {
        let path = self.path(name);
        match stored(&path) {
            Ok(Some(bytes)) => match object::open(name, bytes) {
                Some((trailer, payload)) if trailer.kind == kind => return Lookup::Found(payload),
                _ => {}
            },
            Ok(None) => {}
            Err(_) => return Lookup::Absent,
        }
        // A cache on a read-only disk keeps its damaged objects; they are passed over at each read.
        let _ = self.set_aside("quarantine", &path, name);
        Lookup::Damaged
    }

    /// Stores an object that belongs to the job `owner`. Results are flushed to the disk before they get their name; of
    /// blocks the last few may be lost when the power fails, which the verification sees.
    ///
    /// # Errors
    /// [`RunnerError::File`] if the system refuses, [`RunnerError::Nondeterministic`] if other bytes are stored already.
    pub fn put(&self, kind: Kind, owner: &Key, name: &Key, payload: &[u8]) -> Result<(), RunnerError> {
        let path = self.path(name);
        let folder = path.parent().unwrap_or(&self.root);
        if payload.len() as u64 > LARGEST - object::LONGEST_TRAILER {
            let reason = format!("it has {} bytes, more than the {LARGEST} of the largest object", payload.len());
            return Err(RunnerError::file("write", &path)(std::io::Error::other(reason)));
        }
        self.prepare(folder, name)?;
        // More than once, because another process may move a damaged object away, or take a file of ours for one of a
        // killed writer, in between.
        for _ in 0..3 {
            let temporary = self.write_temporary(kind, owner, name, payload)?;
            let published = match fs::hard_link(temporary.path(), &path) {
                Ok(()) => true,
                Err(error) if error.kind() == ErrorKind::NotFound => false,
                Err(error) if error.kind() == ErrorKind::AlreadyExists || path.symlink_metadata().is_ok() => {
                    self.is_settled(&path, kind, name, payload, &temporary)?
                }
                // No links on this file system: a rename replaces what came in between, with equal content.
                Err(_) => {
                    temporary.keep(Existing::Replace).map_err(RunnerError::file("write", &path))?;
                    true
                }
            };
            if published {
                if self.is_flushed(kind) {
                    // The name itself must outlive a power cut; a file system that cannot do this still has the object.
                    let _ = File::open(folder).and_then(|folder| folder.sync_all());
                }
                return Ok(());
            }
        }
        Err(RunnerError::file("write", &path)(std::io::Error::other("another process keeps removing it")))
    }

    /// Compares with what is stored at `path`: true if equal, false if that was damaged and is out of the way now.
    fn is_settled(
        &self,
        path: &Path,
        kind: Kind,
        name: &Key,
        payload: &[u8],
        temporary: &Draft,
    ) -> Result<bool, RunnerError> {
        let stored = match stored(path) {
            Ok(bytes) => bytes.and_then(|bytes| object::open(name, bytes)),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
            Err(error) => return Err(RunnerError::file("read", path)(error)),
        };
        match stored {
            Some((trailer, stored)) if trailer.kind == kind && stored == payload => Ok(true),
            Some(_) => {
                let kept = self.set_aside("conflict", temporary.path(), name)?;
                Err(RunnerError::Nondeterministic { name: name.to_string(), stored: path.to_path_buf(), kept })
            }
            None => {
                self.set_aside("quarantine", path, name)?;
                Ok(false)
            }
        }
    }

    /// The object in a file beside its place, which goes when it is dropped.
    fn write_temporary(&self, kind: Kind, owner: &Key, name: &Key, payload: &[u8]) -> Result<Draft, RunnerError> {
        let place = self.place(name);
        let write = || {
            let prefix = format!("{}{}", tidy::TEMPORARY, self.unique());
            let mut draft = Draft::with_prefix(&self.root, &place, &prefix)?;
            draft.write_all(payload)?;
            draft.write_all(object::trailer(kind, name, owner, payload).as_bytes())?;
            if self.is_flushed(kind) {
                draft.file().sync_all()?;
            }
            Ok(draft)
        };
        write().map_err(RunnerError::file("write", self.root.join(&place)))
    }

    /// Makes the folder of an object and removes what killed writers left in it, once a process.
    fn prepare(&self, folder: &Path, name: &Key) -> Result<(), RunnerError> {
        let number = usize::from_str_radix(name.as_str().get(..2).unwrap_or("0"), 16).unwrap_or(0);
        if let Some(flag) = self.prepared.get(number)
            && !flag.load(Ordering::Acquire)
        {
            let place = self.place(name);
            let inside = place.parent().unwrap_or(&place);
            file::make_folder(&self.root, inside).map_err(RunnerError::file("make the folder", folder))?;
            tidy::remove_leftovers(folder);
            flag.store(true, Ordering::Release);
        }
        Ok(())
    }

    /// Moves a file to a side folder under a name of its own.
    fn set_aside(&self, side: &str, path: &Path, name: &Key) -> Result<PathBuf, RunnerError> {
        let folder = self.root.join(side);
        file::make_folder(&self.root, Path::new(side)).map_err(RunnerError::file("make the folder", &folder))?;
        let target = folder.join(format!("{name}.{}", self.unique()));
        match fs::rename(path, &target) {
            // Another process was faster.
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(target),
            other => other.map(|()| target.clone()).map_err(RunnerError::file("move", path)),
        }
    }

    fn is_flushed(&self, kind: Kind) -> bool {
        kind == Kind::Result || self.is_shared
    }

    fn unique(&self) -> String {
        let number = self.counter.fetch_add(1, Ordering::Relaxed);
        let nanoseconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_nanos());
        format!("{}-{number}-{nanoseconds:x}", self.writer)
    }
}

/// The bytes at an object's place; nothing where something lies there that can be no object.
fn stored(path: &Path) -> std::io::Result<Option<Vec<u8>>> {
    match file::read(path, LARGEST) {
        Err(error) if error.kind() == ErrorKind::InvalidData => Ok(None),
        read => read.map(Some),
    }
}
