//! Care of a cache: counting, verifying all of it, removing what is not needed, leftovers of killed writers.

use std::collections::BTreeSet;
use std::fs::{self, DirEntry};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use super::{Cache, Kind, Lookup, object};
use crate::math::sort::sort_by_key;
use crate::runner::error::RunnerError;
use crate::runner::key::Key;
use crate::study::file;

/// How names of files that are being written begin.
pub const TEMPORARY: &str = ".tmp-";
/// A leftover from another machine, and the content of the trash, goes after this time.
pub const KEPT_FOR: Duration = Duration::from_secs(24 * 3600);

/// What a cache holds.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Statistics {
    /// Results of jobs.
    pub results: u64,
    /// Their size on disk, bytes.
    pub result_bytes: u64,
    /// Outputs of blocks.
    pub blocks: u64,
    /// Their size on disk, bytes.
    pub block_bytes: u64,
    /// Files that are being written, or that a killed writer left.
    pub leftovers: u64,
    /// Damaged objects.
    pub quarantined: u64,
    /// Second versions of objects whose computation is not reproducible.
    pub conflicts: u64,
    /// Objects that were pruned and are not deleted yet.
    pub trashed: u64,
}

/// What a verification of every object found.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Verified {
    /// Objects that are as they were written.
    pub sound: u64,
    /// Names of the objects that are not; they were moved to `quarantine/`.
    pub damaged: Vec<String>,
}

/// What a pruning did.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Pruned {
    /// Objects that stay.
    pub kept: u64,
    /// Objects that went to the trash.
    pub moved: u64,
    /// Their size, bytes.
    pub moved_bytes: u64,
    /// Files deleted for good: trash older than a day, leftovers of killed writers.
    pub deleted: u64,
}

/// A file in the store of objects.
struct Stored {
    path: PathBuf,
    /// The object's name; nothing for a leftover or a file that is not ours.
    name: Option<Key>,
    bytes: u64,
}

impl Cache {
    /// Counts what is stored. Reads the last line of every object.
    ///
    /// # Errors
    /// [`RunnerError::File`] if a folder cannot be listed.
    pub fn statistics(&self) -> Result<Statistics, RunnerError> {
        let mut statistics = Statistics::default();
        for stored in self.stored()? {
            match stored.name.and_then(|_| object::peek(&stored.path)).map(|trailer| trailer.kind) {
                Some(Kind::Result) => {
                    statistics.results += 1;
                    statistics.result_bytes += stored.bytes;
                }
                Some(Kind::Block | Kind::Run) => {
                    statistics.blocks += 1;
                    statistics.block_bytes += stored.bytes;
                }
                None => statistics.leftovers += 1,
            }
        }
        statistics.quarantined = entries(&self.root().join("quarantine"))?.len() as u64;
        statistics.conflicts = entries(&self.root().join("conflict"))?.len() as u64;
        for day in folders(&self.root().join("trash"))? {
            statistics.trashed += entries(&day.path())?.len() as u64;
        }
        Ok(statistics)
    }

    /// Reads every object and moves the damaged ones to `quarantine/`.
    ///
    /// # Errors
    /// [`RunnerError::File`] if a folder cannot be listed.
    pub fn verify(&self) -> Result<Verified, RunnerError> {
        let mut verified = Verified::default();
        for stored in self.stored()? {
            let Some(name) = stored.name else { continue };
            let kind = object::peek(&stored.path).map_or(Kind::Result, |trailer| trailer.kind);
            match self.get(kind, &name) {
                Lookup::Found(_) => verified.sound += 1,
                Lookup::Absent => {}
                Lookup::Damaged => verified.damaged.push(name.to_string()),
            }
        }
        Ok(verified)
    }

    /// Moves to the trash what does not belong to the jobs `keep`, and blocks of jobs whose result is there; deletes for
    /// good what lies in the trash for more than a day, and leftovers of killed writers.
    ///
    /// # Errors
    /// [`RunnerError::File`] if the system refuses.
    pub fn prune(&self, keep: &BTreeSet<Key>) -> Result<Pruned, RunnerError> {
        let mut pruned = Pruned { deleted: self.empty_trash()?, ..Pruned::default() };
        for folder in folders(&self.root().join("objects"))? {
            pruned.deleted += remove_leftovers(&folder.path());
        }
        let place = Path::new("trash").join(seconds_since_1970().to_string());
        let bin = self.root().join(&place);
        let make_bin = || file::make_folder(self.root(), &place).map_err(RunnerError::file("make the folder", &bin));
        for stored in self.stored()? {
            let Some(name) = &stored.name else { continue };
            let needed = object::peek(&stored.path).is_some_and(|trailer| {
                let is_superseded = trailer.kind == Kind::Block && self.path(&trailer.owner).exists();
                keep.contains(&trailer.owner) && !is_superseded
            });
            if needed {
                pruned.kept += 1;
                continue;
            }
            make_bin()?;
            match fs::rename(&stored.path, bin.join(name.as_str())) {
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                other => {
                    other.map_err(RunnerError::file("move", &stored.path))?;
                    pruned.moved += 1;
                    pruned.moved_bytes += stored.bytes;
                }
            }
        }
        for damaged in entries(&self.root().join("quarantine"))? {
            make_bin()?;
            let _ = fs::rename(damaged.path(), bin.join(damaged.file_name()));
        }
        Ok(pruned)
    }

    /// Deletes what was moved to the trash more than a day ago; a trash folder's name is the time of its pruning.
    fn empty_trash(&self) -> Result<u64, RunnerError> {
        let mut deleted = 0;
        for bin in folders(&self.root().join("trash"))? {
            let Some(moved_at_s) = bin.file_name().to_str().and_then(|name| name.parse::<u64>().ok()) else { continue };
            if seconds_since_1970().saturating_sub(moved_at_s) > KEPT_FOR.as_secs() {
                deleted += entries(&bin.path())?.len() as u64;
                fs::remove_dir_all(bin.path()).map_err(RunnerError::file("delete", bin.path()))?;
            }
        }
        Ok(deleted)
    }

    /// All files below `objects/`, in the order of their names.
    fn stored(&self) -> Result<Vec<Stored>, RunnerError> {
        let mut all = Vec::new();
        for folder in folders(&self.root().join("objects"))? {
            for entry in entries(&folder.path())? {
                let name = format!("{}{}", folder.file_name().to_string_lossy(), entry.file_name().to_string_lossy());
                // A file that went away since is not counted.
                let Ok(metadata) = entry.metadata() else { continue };
                all.push(Stored { path: entry.path(), name: Key::try_from(name).ok(), bytes: metadata.len() });
            }
        }
        Ok(all)
    }
}

/// Host and process, for temporary names, so that others can tell whether the writer is alive.
pub fn writer_prefix() -> String {
    format!("{}-{}", host(), std::process::id())
}

/// Removes files that killed writers left in a folder: those of a process of this host that is gone, and those of other
/// hosts after a day. Gives how many.
pub fn remove_leftovers(folder: &Path) -> u64 {
    let own_host = host();
    let mut removed = 0;
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(writer) = name.to_str().and_then(|name| name.strip_prefix(TEMPORARY)) else { continue };
        let mut parts = writer.split('-');
        let (host, process) = (parts.next(), parts.next());
        let is_dead = host == Some(own_host.as_str())
            && process.is_some_and(|id| id.parse::<u32>().is_ok() && !Path::new("/proc").join(id).exists());
        let is_old = entry
            .metadata()
            .and_then(|metadata| metadata.modified())
            .is_ok_and(|time| time.elapsed().is_ok_and(|age| age > KEPT_FOR));
        if (is_dead || is_old) && fs::remove_file(entry.path()).is_ok() {
            removed += 1;
        }
    }
    removed
}

/// Name of this machine in letters, digits and dots, or `unknown`.
pub fn host() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let name: String = name.trim().chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '.' }).collect();
    if name.is_empty() { "unknown".to_owned() } else { name }
}

/// Whole seconds since 1970 by the clock of this machine.
pub fn seconds_since_1970() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs())
}

/// Folders in a folder by name; links are none.
fn folders(folder: &Path) -> Result<Vec<DirEntry>, RunnerError> {
    let mut subfolders = entries(folder)?;
    subfolders.retain(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    Ok(subfolders)
}

/// Entries of a folder by name; of a folder that does not exist or is a link, none.
fn entries(folder: &Path) -> Result<Vec<DirEntry>, RunnerError> {
    if folder.symlink_metadata().is_ok_and(|there| there.is_symlink()) {
        return Ok(Vec::new());
    }
    let listing = match fs::read_dir(folder) {
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => return Ok(Vec::new()),
        other => other.map_err(RunnerError::file("list", folder))?,
    };
    let mut entries: Vec<_> = listing.collect::<Result<_, _>>().map_err(RunnerError::file("list", folder))?;
    sort_by_key(&mut entries, DirEntry::file_name);
    Ok(entries)
}
