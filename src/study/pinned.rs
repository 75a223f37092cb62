//! Measurements that do not lie in the repository: known by SHA-256, brought by `bmv data get`, checked by `verify`.

use std::ffi::OsStr;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::document::hash::hex;

use super::folder::{Folder, FolderError};

/// Largest file that is fetched where the study does not state the size, bytes.
const LARGEST_FETCH: u64 = 1 << 30;
/// Bytes read at a time.
const BLOCK: usize = 1 << 16;

/// A measurement's file that is known by its hash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pinned {
    /// The measurement.
    pub measurement: String,
    /// Path within the study.
    pub file: String,
    /// SHA-256, lower-case hex.
    pub sha256: String,
    /// Size, bytes.
    pub bytes: Option<u64>,
    /// Where it can be had (https).
    pub origin: Option<String>,
    /// Its licence.
    pub licence: Option<String>,
}

/// What lies at a pinned file's place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// The pinned bytes.
    Good,
    /// Nothing.
    Absent,
    /// Other bytes, with their hash.
    Other {
        /// SHA-256 of what is there.
        sha256: String,
    },
}

/// How a file was had.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Obtained {
    /// It was there.
    AlreadyThere,
    /// Copied from a local file.
    Copied(PathBuf),
    /// Fetched from its origin.
    Fetched(String),
}

/// Why a pinned file cannot be had.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum PinnedError {
    /// The path is refused.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// Other bytes lie at its place; they are left alone.
    #[error("`{file}` is there with SHA-256 {found}, pinned is {pinned}: move it away first")]
    Other {
        /// The file.
        file: String,
        /// Hash of what is there.
        found: String,
        /// Pinned hash.
        pinned: String,
    },
    /// Neither found nor fetchable.
    #[error("no file with SHA-256 {sha256} was found for `{file}`, and the study states no origin to fetch it from")]
    NoOrigin {
        /// The file.
        file: String,
        /// Pinned hash.
        sha256: String,
    },
    /// Only https is fetched.
    #[error("`{origin}` is not fetched: an origin begins with https://")]
    NotHttps {
        /// As written.
        origin: String,
    },
    /// The program that fetches cannot be run or failed.
    #[error("`{origin}` could not be fetched: {reason}")]
    Fetch {
        /// The address.
        origin: String,
        /// What went wrong.
        reason: String,
    },
    /// More bytes than pinned or allowed.
    #[error("`{origin}` gives more than {limit} bytes")]
    TooLarge {
        /// The address.
        origin: String,
        /// The limit.
        limit: u64,
    },
    /// The bytes fetched are not the pinned ones.
    #[error("`{origin}` gives bytes with SHA-256 {found}, pinned is {pinned}: nothing was kept")]
    WrongHash {
        /// The address.
        origin: String,
        /// Hash of what came.
        found: String,
        /// Pinned hash.
        pinned: String,
    },
    /// The file system refuses.
    #[error("`{path}` cannot be written: {reason}")]
    Unwritable {
        /// The file.
        path: String,
        /// What the system says.
        reason: String,
    },
}

/// What lies at a pinned file's place.
///
/// # Errors
/// A path that leaves the study, a file that cannot be read.
pub fn verify(folder: &Folder, pinned: &Pinned) -> Result<State, PinnedError> {
    let place = folder.place(&pinned.file)?;
    if !place.is_file() {
        return Ok(State::Absent);
    }
    match hash_of(&place) {
        Ok(sha256) if sha256 == pinned.sha256 => Ok(State::Good),
        Ok(sha256) => Ok(State::Other { sha256 }),
        Err(error) => Err(FolderError::Unreadable { path: pinned.file.clone(), reason: error.to_string() }.into()),
    }
}

/// Brings a pinned file to its place: where it is there, nothing is done; else the folders `from` are searched for
/// its hash, whatever the name; else it is fetched from its origin with the program `curl`. A file appears only
/// whole and with the right hash.
///
/// # Errors
/// Other bytes at its place, nowhere to be had, or not what was pinned.
pub fn get(folder: &Folder, pinned: &Pinned, from: &[PathBuf]) -> Result<Obtained, PinnedError> {
    get_with(folder, pinned, from, OsStr::new("curl"))
}

fn get_with(folder: &Folder, pinned: &Pinned, from: &[PathBuf], curl: &OsStr) -> Result<Obtained, PinnedError> {
    match verify(folder, pinned)? {
        State::Good => return Ok(Obtained::AlreadyThere),
        State::Other { sha256: found } => {
            let (file, sha256) = (pinned.file.clone(), pinned.sha256.clone());
            return Err(PinnedError::Other { file, found, pinned: sha256 });
        }
        State::Absent => {}
    }
    let place = folder.place(&pinned.file)?;
    let unwritable = |error: std::io::Error| PinnedError::Unwritable {
        path: folder.shown_name(&pinned.file),
        reason: error.to_string(),
    };
    if let Some(found) = from.iter().find_map(|root| search(root, pinned)) {
        let mut file = std::fs::File::open(&found).map_err(unwritable)?;
        let arrived = arrive(&mut file, u64::MAX, &place).map_err(unwritable)?;
        // The file may have changed since it was hashed.
        if arrived.sha256 == pinned.sha256 {
            arrived.keep(&place).map_err(unwritable)?;
            return Ok(Obtained::Copied(found));
        }
    }
    let Some(origin) = &pinned.origin else {
        return Err(PinnedError::NoOrigin { file: pinned.file.clone(), sha256: pinned.sha256.clone() });
    };
    if !origin.starts_with("https://") || origin.contains(char::is_whitespace) {
        return Err(PinnedError::NotHttps { origin: origin.clone() });
    }
    let limit = pinned.bytes.unwrap_or(LARGEST_FETCH);
    let failed = |reason: String| PinnedError::Fetch { origin: origin.clone(), reason };
    let mut child = Command::new(curl)
        .args(["--fail", "--silent", "--show-error", "--location", "--globoff"])
        .args(["--proto", "=https", "--proto-redir", "=https", "--max-redirs", "5"])
        .args(["--connect-timeout", "30", "--max-time", "1800", "--"])
        .arg(origin)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| failed(format!("the program `curl` cannot be run: {error}")))?;
    let arrived = match child.stdout.take() {
        Some(mut stdout) => arrive(&mut stdout, limit, &place),
        None => Err(std::io::Error::other("no output")),
    };
    let too_large = arrived.as_ref().is_ok_and(|arrived| arrived.bytes > limit);
    if too_large || arrived.is_err() {
        // It may have ended by itself, which is as good.
        let _ = child.kill();
    }
    let output = child.wait_with_output().map_err(|error| failed(error.to_string()))?;
    if too_large {
        return Err(PinnedError::TooLarge { origin: origin.clone(), limit });
    }
    let arrived = arrived.map_err(unwritable)?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(failed(said.trim().lines().last().unwrap_or("curl failed").to_owned()));
    }
    if arrived.sha256 != pinned.sha256 {
        let (found, sha256) = (arrived.sha256.clone(), pinned.sha256.clone());
        return Err(PinnedError::WrongHash { origin: origin.clone(), found, pinned: sha256 });
    }
    arrived.keep(&place).map_err(unwritable)?;
    Ok(Obtained::Fetched(origin.clone()))
}

/// The folders to search: the one named, else the one in `BMV_DATA`.
pub fn search_folders(from: Option<&Path>, bmv_data: Option<&OsStr>) -> Vec<PathBuf> {
    match (from, bmv_data) {
        (Some(from), _) => vec![from.to_owned()],
        (None, Some(folder)) if !folder.is_empty() => vec![PathBuf::from(folder)],
        (None, _) => Vec::new(),
    }
}

/// A file below `root` (or `root` itself) with the pinned bytes; the first in the order of names.
fn search(root: &Path, pinned: &Pinned) -> Option<PathBuf> {
    walkdir::WalkDir::new(root)
        .sort_by_file_name()
        .into_iter()
        .flatten()
        .filter(|entry| entry.file_type().is_file())
        .filter(|entry| {
            let length = entry.metadata().map(|data| data.len()).ok();
            pinned.bytes.is_none_or(|bytes| length == Some(bytes))
        })
        .find(|entry| hash_of(entry.path()).is_ok_and(|sha256| sha256 == pinned.sha256))
        .map(walkdir::DirEntry::into_path)
}

fn hash_of(path: &Path) -> std::io::Result<String> {
    let mut file = std::fs::File::open(path)?;
    let mut hasher = Sha256::new();
    let mut block = vec![0; BLOCK];
    loop {
        match file.read(&mut block)? {
            0 => return Ok(hex(&hasher.finalize())),
            read => hasher.update(&block[..read]),
        }
    }
}

/// Bytes that have arrived in a temporary file beside their place.
struct Arrived {
    file: tempfile::NamedTempFile,
    sha256: String,
    bytes: u64,
}

impl Arrived {
    fn keep(self, place: &Path) -> std::io::Result<()> {
        self.file.as_file().sync_all()?;
        match self.file.persist_noclobber(place) {
            Ok(_) => Ok(()),
            Err(error) => Err(error.error),
        }
    }
}

/// Copies at most `limit + 1` bytes, so that too many are noticed.
fn arrive(source: &mut dyn Read, limit: u64, place: &Path) -> std::io::Result<Arrived> {
    let folder = place.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".bmv-data-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let mut file = builder.tempfile_in(folder)?;
    let mut source = source.take(limit.saturating_add(1));
    let mut hasher = Sha256::new();
    let mut bytes = 0;
    let mut block = vec![0; BLOCK];
    loop {
        match source.read(&mut block)? {
            0 => return Ok(Arrived { file, sha256: hex(&hasher.finalize()), bytes }),
            read => {
                hasher.update(&block[..read]);
                file.write_all(&block[..read])?;
                bytes += read as u64;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // SHA-256 of "abc" (FIPS 180-2, appendix B.1).
    const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

    fn pinned(bytes: Option<u64>, origin: Option<&str>) -> Pinned {
        Pinned {
            measurement: "test".to_owned(),
            file: "data/x.csv".to_owned(),
            sha256: ABC.to_owned(),
            bytes,
            origin: origin.map(str::to_owned),
            licence: None,
        }
    }

    fn study() -> (tempfile::TempDir, Folder) {
        let root = tempfile::tempdir().expect("a folder");
        let folder = Folder::open(root.path()).expect("opened");
        (root, folder)
    }

    #[test]
    fn a_file_is_found_by_its_hash_whatever_its_name() {
        let (root, folder) = study();
        let store = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(store.path().join("deep")).expect("made");
        std::fs::write(store.path().join("x.csv"), "abd").expect("written");
        std::fs::write(store.path().join("deep/other name"), "abc").expect("written");
        let wanted = pinned(Some(3), None);
        assert_eq!(verify(&folder, &wanted).expect("looked"), State::Absent);
        let from = [store.path().to_owned()];
        let obtained = get(&folder, &wanted, &from).expect("found");
        assert_eq!(obtained, Obtained::Copied(store.path().join("deep/other name")));
        assert_eq!(std::fs::read(root.path().join("data/x.csv")).expect("there"), b"abc");
        assert_eq!(verify(&folder, &wanted).expect("looked"), State::Good);
        assert_eq!(get(&folder, &wanted, &from).expect("there"), Obtained::AlreadyThere);
        assert_eq!(std::fs::read_dir(root.path().join("data")).expect("listed").count(), 1);
    }

    #[test]
    fn other_bytes_are_reported_and_left_alone() {
        let (root, folder) = study();
        std::fs::create_dir(root.path().join("data")).expect("made");
        std::fs::write(root.path().join("data/x.csv"), "").expect("written");
        let wanted = pinned(None, None);
        assert!(matches!(verify(&folder, &wanted), Ok(State::Other { .. })));
        assert!(matches!(get(&folder, &wanted, &[]), Err(PinnedError::Other { .. })));
        assert_eq!(std::fs::read(root.path().join("data/x.csv")).expect("there"), b"");
    }

    #[test]
    fn without_a_usable_origin_nothing_is_fetched() {
        let (_root, folder) = study();
        assert!(matches!(get(&folder, &pinned(None, None), &[]), Err(PinnedError::NoOrigin { .. })));
        for origin in ["http://example.org/x", "file:///etc/passwd", "-o/tmp/x", "https://a b"] {
            let got = get(&folder, &pinned(None, Some(origin)), &[]);
            assert!(matches!(got, Err(PinnedError::NotHttps { .. })), "{origin}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_is_fetched_is_kept_only_with_its_hash_and_size() {
        use std::os::unix::fs::PermissionsExt;
        let programs = tempfile::tempdir().expect("a folder");
        let program = |name: &str, body: &str| {
            let path = programs.path().join(name);
            std::fs::write(&path, format!("#!/bin/sh\n{body}\n")).expect("written");
            std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).expect("set");
            path.into_os_string()
        };
        let origin = Some("https://example.org/x.csv");
        let (root, folder) = study();
        let file = root.path().join("data/x.csv");
        let wrong = get_with(&folder, &pinned(None, origin), &[], &program("wrong", "printf abd"));
        assert!(matches!(wrong, Err(PinnedError::WrongHash { .. })), "{wrong:?}");
        let large = get_with(&folder, &pinned(Some(3), origin), &[], &program("large", "printf abcd"));
        assert!(matches!(large, Err(PinnedError::TooLarge { limit: 3, .. })), "{large:?}");
        let body = "echo 'curl: (22) 404' >&2; exit 22";
        let failed = get_with(&folder, &pinned(None, origin), &[], &program("failed", body));
        assert!(
            matches!(failed, Err(PinnedError::Fetch { ref reason, .. }) if reason == "curl: (22) 404"),
            "{failed:?}"
        );
        let absent = get_with(&folder, &pinned(None, origin), &[], OsStr::new("/nonexistent/curl"));
        assert!(matches!(absent, Err(PinnedError::Fetch { .. })), "{absent:?}");
        assert!(!file.exists());
        let good = get_with(&folder, &pinned(Some(3), origin), &[], &program("good", "printf abc"));
        assert_eq!(good, Ok(Obtained::Fetched("https://example.org/x.csv".to_owned())));
        assert_eq!(std::fs::read(file).expect("there"), b"abc");
    }
}
