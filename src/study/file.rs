//! Files as the program reads and writes them: regular ones only, never written through a link, whole or not at all.
//!
//! A path has two parts. The base is what the user named, or the study's own folder: links in it are the user's. Below it
//! nothing may be a link, so that what a study or an archive from elsewhere brings along cannot lead a write out of it.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Component, Path, PathBuf};

use tempfile::NamedTempFile;

/// How names of files that are being written begin.
const DRAFT: &str = ".bmv-draft-";

/// What is to become of a file that is there already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// It stays, and writing fails with [`ErrorKind::AlreadyExists`].
    Keep,
    /// It is replaced.
    Replace,
}

/// A file that is being written beside its place. Dropped, it is gone.
#[derive(Debug)]
pub struct Draft {
    file: NamedTempFile,
    place: PathBuf,
}

impl Draft {
    /// Begins the file `relative` below the folder `base`; folders are made where they are missing.
    ///
    /// # Errors
    /// A link or something else in the way; what the system says.
    pub fn new(base: &Path, relative: &Path) -> io::Result<Self> {
        Self::with_prefix(base, relative, DRAFT)
    }

    /// As [`Draft::new`], with a beginning for its temporary name.
    ///
    /// # Errors
    /// As [`Draft::new`].
    pub fn with_prefix(base: &Path, relative: &Path, prefix: &str) -> io::Result<Self> {
        let name = relative.file_name().ok_or_else(|| refused(relative, "names no file"))?;
        let folder = make_folder(base, relative.parent().unwrap_or(Path::new("")))?;
        let place = folder.join(name);
        let mut builder = tempfile::Builder::new();
        builder.prefix(prefix);
        // As any new file has it: the system takes off what the user's mask says.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
        Ok(Self { file: builder.tempfile_in(folder)?, place })
    }

    /// Where it lies now.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The open file.
    pub fn file(&self) -> &File {
        self.file.as_file()
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// A link, something that is no regular file, or a file that must stay at its place; what the system says.
    pub fn keep(self, existing: Existing) -> io::Result<()> {
        match self.place.symlink_metadata() {
            Ok(_) if existing == Existing::Keep => return Err(ErrorKind::AlreadyExists.into()),
            Ok(there) if there.is_symlink() => return Err(is_link(&self.place)),
            Ok(there) if !there.is_file() => return Err(refused(&self.place, "is no regular file")),
            Ok(there) if there.permissions().readonly() => return Err(ErrorKind::PermissionDenied.into()),
            Ok(there) => self.file.as_file().set_permissions(there.permissions())?,
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
        let kept = match existing {
            Existing::Keep => self.file.persist_noclobber(&self.place),
            Existing::Replace => self.file.persist(&self.place),
        };
        kept.map(|_| ()).map_err(|error| error.error)
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Writes the file `relative` below the folder `base`, whole or not at all.
///
/// # Errors
/// As [`Draft::new`] and [`Draft::keep`].
pub fn write(base: &Path, relative: &Path, bytes: &[u8], existing: Existing) -> io::Result<()> {
    let mut draft = Draft::new(base, relative)?;
    draft.write_all(bytes)?;
    draft.flush()?;
    draft.keep(existing)
}

/// Makes the folder `relative` below `base` and gives its path.
///
/// # Errors
/// A link or a file in the way; a path that leaves `base`; what the system says.
pub fn make_folder(base: &Path, relative: &Path) -> io::Result<PathBuf> {
    if !base.as_os_str().is_empty() {
        fs::create_dir_all(base)?;
    }
    let mut folder = base.to_owned();
    for part in relative.components() {
        match part {
            Component::CurDir => continue,
            Component::Normal(name) => folder.push(name),
            _ => return Err(refused(relative, "leaves the folder")),
        }
        if real_folder(&folder)? {
            continue;
        }
        match fs::create_dir(&folder) {
            // Another process was faster; what it made is looked at too.
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                real_folder(&folder)?;
            }
            made => made?,
        }
    }
    Ok(folder)
}

/// Whether a new study may be written into a folder: there is nothing, or a folder with nothing in it.
///
/// # Errors
/// What the system says.
pub fn is_free(folder: &Path) -> io::Result<bool> {
    match fs::read_dir(folder) {
        Ok(mut entries) => Ok(entries.next().is_none()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(true),
        Err(error) => Err(error),
    }
}

/// Whether there is a folder; what is none, or is reached through a link, is an error.
fn real_folder(path: &Path) -> io::Result<bool> {
    match path.symlink_metadata() {
        Ok(there) if there.is_symlink() => Err(is_link(path)),
        Ok(there) if !there.is_dir() => Err(refused(path, "is no folder")),
        Ok(_) => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Removes the file `relative` below `base`. What is not there, lies behind a link, or is no regular file stays as it is.
///
/// # Errors
/// What the system says.
pub fn remove(base: &Path, relative: &Path) -> io::Result<()> {
    let mut path = base.to_owned();
    for part in relative.components() {
        let Component::Normal(name) = part else { return Ok(()) };
        if path != base && !real_folder(&path).is_ok_and(|there| there) {
            return Ok(());
        }
        path.push(name);
    }
    match path.symlink_metadata() {
        Ok(there) if there.is_file() => fs::remove_file(&path),
        _ => Ok(()),
    }
}

/// Opens a regular file and gives its length, bytes; a link is not followed, and nothing that could wait is opened.
///
/// # Errors
/// [`ErrorKind::InvalidData`] for what is no regular file; what the system says.
pub fn open(path: &Path) -> io::Result<(File, u64)> {
    let regular = |there: &fs::Metadata| {
        there.is_file().then_some(there.len()).ok_or_else(|| invalid(path, "is no regular file"))
    };
    regular(&path.symlink_metadata()?)?;
    let file = File::open(path)?;
    let length = regular(&file.metadata()?)?;
    Ok((file, length))
}

/// Reads a regular file of at most `limit` bytes.
///
/// # Errors
/// [`ErrorKind::InvalidData`] for what is no regular file or is larger; what the system says.
pub fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let too_large = || invalid(path, &format!("has more than {limit} bytes"));
    let (file, length) = open(path)?;
    if length > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    // It may grow while it is read.
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(too_large()) } else { Ok(bytes) }
}

fn is_link(path: &Path) -> io::Error {
    refused(path, "is a link, and nothing is written through links: remove it, or name a folder that holds none")
}

fn refused(path: &Path, why: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, format!("`{}` {why}", path.display()))
}

fn invalid(path: &Path, why: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, format!("`{}` {why}", path.display()))
}
