//! Measurements that do not lie in the repository: known by SHA-256, brought by `bmv data get`, checked by `verify`.

use std::ffi::OsStr;
use std::io::{Read, Write};
use std::net::IpAddr;
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Stdio};

use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::document::hash::hex;

use super::file::{Draft, Existing};
use super::folder::{Folder, FolderError};
use super::inherit::plain_name;
use super::origin::{Origin, is_internal};

/// Largest file that is fetched where the study does not state the size, bytes.
const LARGEST_FETCH: u64 = 1 << 30;
/// Redirects that are followed.
const MOST_REDIRECTS: usize = 5;
/// Longest text beside a redirect, bytes.
const LONGEST_REDIRECT: u64 = 1 << 16;
/// How the line begins in which `curl` tells where it is redirected to.
const REDIRECT: &str = "bmv-redirect ";
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
    /// The path is hidden.
    #[error("`{file}` is not brought: a pinned file lies under no hidden name, such as data/run.csv")]
    Hidden {
        /// The file.
        file: String,
    },
    /// The address is none of the public internet.
    #[error(
        "`{origin}` is not fetched: {address} is an address of this machine or its own network; --internal allows it, \
         --from DIR takes the file from a folder"
    )]
    Internal {
        /// The origin, or what it was redirected to.
        origin: String,
        /// Its address.
        address: IpAddr,
    },
    /// Only plain https is fetched.
    #[error("`{origin}` is not fetched: an origin is https://, a host's name or address, and a path")]
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

/// From where pinned files may be had.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sources {
    /// Folders that are searched for a file's hash.
    pub folders: Vec<PathBuf>,
    /// Whether files are fetched from addresses of this machine and its own networks too.
    pub internal: bool,
}

/// Brings a pinned file to its place: where it is there, nothing is done; else the folders are searched for its hash,
/// whatever the name; else it is fetched from its origin with the program `curl`. A file appears only whole and with the
/// right hash, and never below a hidden folder or under a hidden name.
///
/// # Errors
/// Other bytes at its place, nowhere to be had, or not what was pinned.
pub fn get(folder: &Folder, pinned: &Pinned, from: &Sources) -> Result<Obtained, PinnedError> {
    get_with(folder, pinned, from, OsStr::new("curl"), &Origin::resolve)
}

/// Gives the addresses of a host.
type Resolve = dyn Fn(&Origin) -> std::io::Result<Vec<IpAddr>>;

/// As [`get`], with addresses of hosts from a function.
///
/// # Errors
/// Those of [`get`].
pub fn get_with(
    folder: &Folder,
    pinned: &Pinned,
    from: &Sources,
    curl: &OsStr,
    resolve: &Resolve,
) -> Result<Obtained, PinnedError> {
    match verify(folder, pinned)? {
        State::Good => return Ok(Obtained::AlreadyThere),
        State::Other { sha256: actual_sha256 } => {
            let (file, sha256) = (pinned.file.clone(), pinned.sha256.clone());
            return Err(PinnedError::Other { file, found: actual_sha256, pinned: sha256 });
        }
        State::Absent => {}
    }
    let is_hidden =
        |part: Component<'_>| part.as_os_str().to_string_lossy().starts_with('.') && part != Component::CurDir;
    if Path::new(&pinned.file).components().any(is_hidden) {
        return Err(PinnedError::Hidden { file: pinned.file.clone() });
    }
    let unwritable = |error: std::io::Error| PinnedError::Unwritable {
        path: folder.shown_name(&pinned.file),
        reason: error.to_string(),
    };
    let draft = || Draft::new(folder.root(), Path::new(&plain_name(&pinned.file))).map_err(unwritable);
    if let Some(same_file) = from.folders.iter().find_map(|root| search(root, pinned)) {
        let mut file = std::fs::File::open(&same_file).map_err(unwritable)?;
        let arrived = arrive(&mut file, u64::MAX, draft()?).map_err(unwritable)?;
        // The file may have changed since it was hashed.
        if arrived.sha256 == pinned.sha256 {
            arrived.keep().map_err(unwritable)?;
            return Ok(Obtained::Copied(same_file));
        }
    }
    let Some(origin) = &pinned.origin else {
        return Err(PinnedError::NoOrigin { file: pinned.file.clone(), sha256: pinned.sha256.clone() });
    };
    let limit = pinned.bytes.unwrap_or(LARGEST_FETCH);
    let mut address = origin.clone();
    for _ in 0..=MOST_REDIRECTS {
        let pin = allowed(&address, from.internal, resolve)?;
        // What a redirect says beside the address may be longer than the file.
        let got = fetch(curl, &address, pin, limit.max(LONGEST_REDIRECT), draft()?, &unwritable)?;
        let arrived = match got {
            Got::Redirect(next) => {
                address = next;
                continue;
            }
            Got::File(arrived) => arrived,
        };
        if arrived.bytes > limit {
            return Err(PinnedError::TooLarge { origin: origin.clone(), limit });
        }
        if arrived.sha256 != pinned.sha256 {
            let (arrived_sha256, sha256) = (arrived.sha256.clone(), pinned.sha256.clone());
            return Err(PinnedError::WrongHash { origin: origin.clone(), found: arrived_sha256, pinned: sha256 });
        }
        arrived.keep().map_err(unwritable)?;
        return Ok(Obtained::Fetched(origin.clone()));
    }
    let reason = format!("it is redirected more than {MOST_REDIRECTS} times");
    Err(PinnedError::Fetch { origin: origin.clone(), reason })
}

/// Whether an address may be fetched; for a name, what pins it to the addresses that were looked at.
fn allowed(address: &str, internal: bool, resolve: &Resolve) -> Result<Option<String>, PinnedError> {
    let origin = Origin::parse(address).ok_or_else(|| PinnedError::NotHttps { origin: address.to_owned() })?;
    if internal {
        return Ok(None);
    }
    let addresses = resolve(&origin).map_err(|error| PinnedError::Fetch {
        origin: address.to_owned(),
        reason: format!("`{}` has no address: {error}", origin.host),
    })?;
    match addresses.iter().find(|address| is_internal(**address)) {
        Some(internal_address) => Err(PinnedError::Internal { origin: address.to_owned(), address: *internal_address }),
        None => Ok(origin.pin(&addresses)),
    }
}

/// What came from an address.
enum Got {
    File(Arrived),
    /// It is elsewhere.
    Redirect(String),
}

/// Fetches from one address; redirects are not followed.
fn fetch(
    curl: &OsStr,
    origin: &str,
    pin: Option<String>,
    limit: u64,
    draft: Draft,
    unwritable: &dyn Fn(std::io::Error) -> PinnedError,
) -> Result<Got, PinnedError> {
    let failed = |reason: String| PinnedError::Fetch { origin: origin.to_owned(), reason };
    let mut child = Command::new(curl)
        .args(["--fail", "--silent", "--show-error", "--no-location", "--globoff", "--proto", "=https"])
        .args(["--connect-timeout", "30", "--max-time", "1800"])
        .args(["--write-out", &format!("%{{stderr}}\n{REDIRECT}%{{redirect_url}}\n")])
        .args(pin.iter().flat_map(|pin| ["--resolve", pin]))
        .args(["--", origin])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| failed(format!("the program `curl` cannot be run: {error}")))?;
    let arrived = match child.stdout.take() {
        Some(mut stdout) => arrive(&mut stdout, limit, draft),
        None => Err(std::io::Error::other("no output")),
    };
    let too_large = arrived.as_ref().is_ok_and(|arrived| arrived.bytes > limit);
    if too_large || arrived.is_err() {
        // It may have ended by itself, which is as good.
        let _ = child.kill();
    }
    let output = child.wait_with_output().map_err(|error| failed(error.to_string()))?;
    if too_large {
        return Err(PinnedError::TooLarge { origin: origin.to_owned(), limit });
    }
    let arrived = arrived.map_err(unwritable)?;
    let said = String::from_utf8_lossy(&output.stderr);
    let lines = || said.lines().map(str::trim).filter(|line| !line.is_empty());
    if !output.status.success() {
        let reason = lines().rfind(|line| !line.starts_with(REDIRECT.trim()));
        return Err(failed(reason.unwrap_or("curl failed").to_owned()));
    }
    let redirect = lines().rev().find_map(|line| line.strip_prefix(REDIRECT));
    Ok(redirect.map_or(Got::File(arrived), |next| Got::Redirect(next.to_owned())))
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

/// Bytes that have arrived beside their place.
struct Arrived {
    draft: Draft,
    sha256: String,
    bytes: u64,
}

impl Arrived {
    fn keep(self) -> std::io::Result<()> {
        self.draft.file().sync_all()?;
        self.draft.keep(Existing::Keep)
    }
}

/// Copies at most `limit + 1` bytes, so that too many are noticed.
fn arrive(source: &mut dyn Read, limit: u64, mut draft: Draft) -> std::io::Result<Arrived> {
    let mut source = source.take(limit.saturating_add(1));
    let mut hasher = Sha256::new();
    let mut bytes = 0;
    let mut block = vec![0; BLOCK];
    loop {
        match source.read(&mut block)? {
            0 => return Ok(Arrived { draft, sha256: hex(&hasher.finalize()), bytes }),
            read => {
                hasher.update(&block[..read]);
                draft.write_all(&block[..read])?;
                bytes += read as u64;
            }
        }
    }
}
