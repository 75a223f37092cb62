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
    /// A run of a model outside, which follows from its inputs alone, whichever job asked first.
    Run,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Self::Result => "result",
            Self::Block => "block",
            Self::Run => "run",
        }
    }

    fn from_word(word: &str) -> Option<Self> {
        [Self::Result, Self::Block, Self::Run].into_iter().find(|kind| kind.word() == word)
    }
}

/// The last line of an object, read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trailer {
    /// What the object is.
    pub kind: Kind,
    /// Key of the job to which the object belongs.
    pub owner: Key,
    length: u64,
    hash: String,
}

/// The end of an object's file: what is written after the payload.
pub fn trailer(kind: Kind, name: &Key, owner: &Key, payload: &[u8]) -> String {
    let hash = hash(kind, name, owner, payload);
    format!("\n{FORMAT} {} {owner} {} {hash}\n", kind.word(), payload.len())
}

/// Cuts the trailer off a file's bytes. `None` if the object called `name` is damaged.
pub fn open(name: &Key, mut bytes: Vec<u8>) -> Option<(Trailer, Vec<u8>)> {
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
