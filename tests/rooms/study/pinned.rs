//! Tests of `src/study/pinned.rs`.

use std::ffi::OsStr;
use std::net::IpAddr;
use std::path::Path;

use bmv::study::folder::Folder;
use bmv::study::origin::Origin;
use bmv::study::pinned::*;

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
    let got = |bytes: Option<u64>, curl: &OsStr| get_with(&folder, &pinned(bytes, origin), &from(&[]), curl, &resolved);
    let wrong = got(None, &programs.program("wrong", "printf abd"));
    assert!(matches!(wrong, Err(PinnedError::WrongHash { .. })), "{wrong:?}");
    let large = got(Some(3), &programs.program("large", "printf abcd"));
    assert!(matches!(large, Err(PinnedError::TooLarge { limit: 3, .. })), "{large:?}");
    let larger = got(Some(3), &programs.program("larger", "head -c 100000 /dev/zero"));
    assert!(matches!(larger, Err(PinnedError::TooLarge { .. })), "{larger:?}");
    let failed = got(None, &programs.program("failed", "echo 'curl: (22) 404' >&2; echo 'bmv-redirect ' >&2; exit 22"));
    assert!(matches!(failed, Err(PinnedError::Fetch { ref reason, .. }) if reason == "curl: (22) 404"), "{failed:?}");
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
