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

fn get_with(
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

    fn from(folders: &[&Path]) -> Sources {
        Sources { folders: folders.iter().map(|&folder| folder.to_owned()).collect(), internal: false }
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
        let from = from(&[store.path()]);
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
        assert!(matches!(get(&folder, &wanted, &from(&[])), Err(PinnedError::Other { .. })));
        assert_eq!(std::fs::read(root.path().join("data/x.csv")).expect("there"), b"");
    }

    #[test]
    fn without_a_usable_origin_nothing_is_fetched() {
        let (_root, folder) = study();
        assert!(matches!(get(&folder, &pinned(None, None), &from(&[])), Err(PinnedError::NoOrigin { .. })));
        for origin in ["http://example.org/x", "file:///etc/passwd", "-o/tmp/x", "https://a b"] {
            let got = get(&folder, &pinned(None, Some(origin)), &from(&[]));
            assert!(matches!(got, Err(PinnedError::NotHttps { .. })), "{origin}");
        }
    }

    #[test]
    fn nothing_is_brought_under_a_hidden_name() {
        let (root, folder) = study();
        let store = tempfile::tempdir().expect("a folder");
        std::fs::write(store.path().join("x"), "abc").expect("written");
        for file in [".git/hooks/post-checkout", "data/.x.csv", ".x", "./.x"] {
            let wanted = Pinned { file: file.to_owned(), ..pinned(None, None) };
            let got = get(&folder, &wanted, &from(&[store.path()]));
            assert!(matches!(got, Err(PinnedError::Hidden { .. })), "{file}: {got:?}");
        }
        assert_eq!(std::fs::read_dir(root.path()).expect("listed").count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn nothing_is_brought_through_a_link() {
        let (root, folder) = study();
        let store = tempfile::tempdir().expect("a folder");
        std::fs::write(store.path().join("x"), "abc").expect("written");
        std::fs::create_dir(root.path().join("other")).expect("made");
        std::os::unix::fs::symlink("other", root.path().join("data")).expect("linked");
        let got = get(&folder, &pinned(None, None), &from(&[store.path()]));
        assert!(matches!(got, Err(PinnedError::Unwritable { .. })), "{got:?}");
        assert_eq!(std::fs::read_dir(root.path().join("other")).expect("listed").count(), 0);
    }

    /// Programs in place of `curl`.
    #[cfg(unix)]
    struct Programs(tempfile::TempDir);

    #[cfg(unix)]
    impl Programs {
        fn program(&self, name: &str, body: &str) -> std::ffi::OsString {
            let path = self.0.path().join(name);
            std::fs::write(&path, format!("#!/bin/sh\n{body}\n")).expect("written");
            std::fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o755)).expect("set");
            path.into_os_string()
        }
    }

    /// A resolver that knows `example.org` and `inside.example.org`.
    #[cfg(unix)]
    fn resolved(origin: &Origin) -> std::io::Result<Vec<IpAddr>> {
        let text = match origin.host.as_str() {
            "example.org" => "8.8.8.8",
            "inside.example.org" => "10.0.0.7",
            host => host,
        };
        Ok(vec![text.parse().map_err(std::io::Error::other)?])
    }

    #[cfg(unix)]
    #[test]
    fn what_is_fetched_is_kept_only_with_its_hash_and_size() {
        let programs = Programs(tempfile::tempdir().expect("a folder"));
        let origin = Some("https://example.org/x.csv");
        let (root, folder) = study();
        let file = root.path().join("data/x.csv");
        let got =
            |bytes: Option<u64>, curl: &OsStr| get_with(&folder, &pinned(bytes, origin), &from(&[]), curl, &resolved);
        let wrong = got(None, &programs.program("wrong", "printf abd"));
        assert!(matches!(wrong, Err(PinnedError::WrongHash { .. })), "{wrong:?}");
        let large = got(Some(3), &programs.program("large", "printf abcd"));
        assert!(matches!(large, Err(PinnedError::TooLarge { limit: 3, .. })), "{large:?}");
        let larger = got(Some(3), &programs.program("larger", "head -c 100000 /dev/zero"));
        assert!(matches!(larger, Err(PinnedError::TooLarge { .. })), "{larger:?}");
        let failed =
            got(None, &programs.program("failed", "echo 'curl: (22) 404' >&2; echo 'bmv-redirect ' >&2; exit 22"));
        assert!(
            matches!(failed, Err(PinnedError::Fetch { ref reason, .. }) if reason == "curl: (22) 404"),
            "{failed:?}"
        );
        let absent = got(None, OsStr::new("/nonexistent/curl"));
        assert!(matches!(absent, Err(PinnedError::Fetch { .. })), "{absent:?}");
        assert!(!file.exists());
        let good = got(Some(3), &programs.program("good", "printf abc"));
        assert_eq!(good, Ok(Obtained::Fetched("https://example.org/x.csv".to_owned())));
        assert_eq!(std::fs::read(file).expect("there"), b"abc");
    }

    #[cfg(unix)]
    #[test]
    fn internal_addresses_are_fetched_only_where_that_is_asked() {
        let programs = Programs(tempfile::tempdir().expect("a folder"));
        let (root, folder) = study();
        let curl = programs.program("good", "printf abc");
        // From the public address once to another, and only from there on the file.
        let moved = |to: &str| format!("case \"$*\" in *first*) echo 'bmv-redirect {to}' >&2;; *) printf abc;; esac");
        let inside = programs.program("inside", &moved("https://169.254.169.254/latest"));
        let to_file = programs.program("file", &moved("file:///etc/passwd"));
        let round = programs.program("round", &moved("https://example.org/first"));
        let outside = programs.program("outside", &moved("https://example.org/second"));
        let cases = [
            ("https://127.0.0.1/x", &curl, true),
            ("https://[::1]/x", &curl, true),
            ("https://inside.example.org/x", &curl, true),
            ("https://example.org/first", &inside, true),
            ("https://example.org/first", &to_file, false),
            ("https://example.org/first", &round, false),
        ];
        for (origin, curl, is_internal) in cases {
            let got = get_with(&folder, &pinned(None, Some(origin)), &from(&[]), curl, &resolved);
            assert_eq!(matches!(got, Err(PinnedError::Internal { .. })), is_internal, "{origin}: {got:?}");
            assert!(got.is_err(), "{origin}");
        }
        let got = get_with(&folder, &pinned(None, Some("https://example.org/first")), &from(&[]), &outside, &resolved);
        assert!(matches!(got, Ok(Obtained::Fetched(_))), "{got:?}");
        std::fs::remove_file(root.path().join("data/x.csv")).expect("there");
        let internal = Sources { internal: true, ..from(&[]) };
        let got = get_with(&folder, &pinned(None, Some("https://127.0.0.1/x")), &internal, &curl, &resolved);
        assert!(matches!(got, Ok(Obtained::Fetched(_))), "{got:?}");
    }
}
