//! The form of a stored object: the payload, then a line that says what it is, how long, and its hash.
//!
//! `bmv-object/1 KIND OWNER LENGTH HASH`, where the hash covers kind, name, owner and length too, so that a file which was
//! cut, altered or given another name does not pass.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::runner::key::Key;
use crate::study::file;

const FORMAT: &str = "bmv-object/1";
/// More than the longest trailer: two hashes of 64 digits, the format, a kind, a length of at most 20 digits.
pub(super) const LONGEST_TRAILER: u64 = 256;

/// What an object holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Result of a job, canonical JSON.
    Result,
    /// Output of a block.
    Block,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Self::Result => "result",
            Self::Block => "block",
        }
    }

    fn from_word(word: &str) -> Option<Self> {
        [Self::Result, Self::Block].into_iter().find(|kind| kind.word() == word)
    }
}

/// The last line of an object, read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Trailer {
    pub kind: Kind,
    /// Key of the job to which the object belongs.
    pub owner: Key,
    length: u64,
    hash: String,
}

/// The end of an object's file: what is written after the payload.
pub(super) fn trailer(kind: Kind, name: &Key, owner: &Key, payload: &[u8]) -> String {
    let hash = hash(kind, name, owner, payload);
    format!("\n{FORMAT} {} {owner} {} {hash}\n", kind.word(), payload.len())
}

/// Cuts the trailer off a file's bytes. `None` if the object called `name` is damaged.
pub(super) fn open(name: &Key, mut bytes: Vec<u8>) -> Option<(Trailer, Vec<u8>)> {
    let tail_start = bytes.len().saturating_sub(LONGEST_TRAILER as usize);
    let (line_start, trailer) = parse(bytes.get(tail_start..)?)?;
    bytes.truncate(tail_start + line_start);
    let sound = trailer.length == bytes.len() as u64
        && trailer.hash == hash(trailer.kind, name, &trailer.owner, &bytes).as_str();
    sound.then_some((trailer, bytes))
}

/// Reads only the trailer of a file; it is not checked against the payload. `None` if there is none.
pub(super) fn peek(path: &Path) -> Option<Trailer> {
    let (mut file, length) = file::open(path).ok()?;
    file.seek(SeekFrom::Start(length.saturating_sub(LONGEST_TRAILER))).ok()?;
    let mut tail = Vec::new();
    file.take(LONGEST_TRAILER).read_to_end(&mut tail).ok()?;
    parse(&tail).map(|(_, trailer)| trailer)
}

/// Finds the trailer at the end of these bytes: where its line break stands, and what it says.
fn parse(tail: &[u8]) -> Option<(usize, Trailer)> {
    let body = tail.strip_suffix(b"\n")?;
    let start = body.iter().rposition(|&byte| byte == b'\n')?;
    let line = std::str::from_utf8(body.get(start + 1..)?).ok()?;
    let [format, kind, owner, length, hash] = line.split(' ').collect::<Vec<_>>().try_into().ok()?;
    if format != FORMAT {
        return None;
    }
    let trailer = Trailer {
        kind: Kind::from_word(kind)?,
        owner: Key::try_from(owner.to_owned()).ok()?,
        length: length.parse().ok()?,
        hash: hash.to_owned(),
    };
    Some((start, trailer))
}

fn hash(kind: Kind, name: &Key, owner: &Key, payload: &[u8]) -> Key {
    let mut hash = Sha256::new();
    hash.update(format!("{FORMAT} {} {name} {owner} {}\n", kind.word(), payload.len()));
    hash.update(payload);
    Key::from_digest(&hash.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored(payload: &[u8]) -> Vec<u8> {
        let mut bytes = payload.to_vec();
        bytes.extend(trailer(Kind::Block, &Key::of(b"name"), &Key::of(b"owner"), payload).bytes());
        bytes
    }

    #[test]
    fn payloads_of_any_bytes_come_back() {
        for payload in [&b""[..], b"{}", b"\n\n", b"bmv-object/1 block\n", &[0, 255, 10], &[10; 1000]] {
            let (trailer, read) = open(&Key::of(b"name"), stored(payload)).expect("sound");
            assert_eq!(read, payload);
            assert_eq!((trailer.kind, trailer.owner), (Kind::Block, Key::of(b"owner")));
        }
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_seen() {
        let bytes = stored(b"some payload");
        for length in 0..bytes.len() {
            assert!(open(&Key::of(b"name"), bytes[..length].to_vec()).is_none(), "cut to {length}");
        }
        for place in 0..bytes.len() {
            let mut altered = bytes.clone();
            altered[place] ^= 1;
            assert!(open(&Key::of(b"name"), altered).is_none(), "bit flipped at {place}");
        }
    }

    #[test]
    fn an_object_under_another_name_is_damaged() {
        assert!(open(&Key::of(b"other"), stored(b"x")).is_none());
    }
}
