//! How blocks and results are stored.
//!
//! A block is CBOR (RFC 8949), then as many little-endian doubles as it has long lists of. CBOR has NaN and the
//! infinities, which JSON has not: what a stage found is what the next one reads, to the bit.
//!
//! A result is JSON, for everyone. There a number that is not finite has no text: `null` stands for it where the type says
//! that it need not be available (`Option`), anything else is an error that names the place. Long arrays lie beside it.

use ciborium::Value as Tree;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::JobError;
use super::array::Arrays;

/// Keys of what names an entry of a list, for errors.
const NAMES: [&str; 8] =
    ["name", "requirement", "environment", "quantity", "measurement", "phase", "sensor", "parameter"];

/// The stored form of a block: what heads it, and the numbers behind that.
///
/// # Errors
/// A value that cannot be written; in debug builds one that would not read back as it is.
pub fn with_numbers<T: Serialize + DeserializeOwned>(head: &T, numbers: &[f64]) -> Result<Vec<u8>, JobError> {
    let mut bytes = encoded(head)?;
    if cfg!(debug_assertions) {
        let again = decoded::<T>(&bytes).and_then(|(value, _)| encoded(&value).map_err(|error| error.to_string()));
        if again.as_ref() != Ok(&bytes) {
            let why = again.err().unwrap_or_else(|| "another value".to_owned());
            return Err(JobError::Failed(format!("a block would not read back as it was written: {why}")));
        }
    }
    bytes.reserve_exact(8 * numbers.len());
    bytes.extend(numbers.iter().flat_map(|value| value.to_le_bytes()));
    Ok(bytes)
}

/// Reads a block: what heads it, and the numbers behind that.
///
/// # Errors
/// [`JobError::Unreadable`] for bytes of another form.
pub fn split_numbers<T: DeserializeOwned>(bytes: &[u8], stage: &str) -> Result<(T, Vec<f64>), JobError> {
    let (value, rest) = decoded(bytes).map_err(|reason| unreadable(stage, reason))?;
    let (words, remainder) = rest.as_chunks::<8>();
    if !remainder.is_empty() {
        return Err(unreadable(stage, "a number is cut off"));
    }
    Ok((value, words.iter().map(|word| f64::from_le_bytes(*word)).collect()))
}

/// What crosses between stages and processes as bytes. Whatever serde can write is one; types with long lists of numbers
/// write these behind ([`with_numbers`]).
pub trait Block: Sized {
    /// The stored form.
    ///
    /// # Errors
    /// A value that cannot be written; in debug builds one that would not read back as it is.
    fn into_bytes(self) -> Result<Vec<u8>, JobError>;
    /// Reads the stored form.
    ///
    /// # Errors
    /// [`JobError::Unreadable`] for bytes of another form.
    fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError>;
}

impl<T: Serialize + DeserializeOwned> Block for T {
    fn into_bytes(self) -> Result<Vec<u8>, JobError> {
        with_numbers(&self, &[])
    }

    fn from_bytes(bytes: &[u8], stage: &str) -> Result<Self, JobError> {
        let (value, numbers) = split_numbers(bytes, stage)?;
        if numbers.is_empty() { Ok(value) } else { Err(unreadable(stage, "it is too long")) }
    }
}

/// A result as it is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct ResultDocument {
    /// JSON, with shape and hash of each array.
    pub json: serde_json::Value,
    /// The numbers of the arrays.
    pub arrays: Arrays,
}

/// A result as JSON. A number that is not finite becomes `null` where it is optional.
///
/// # Errors
/// A result that would not read back as what it is: a number that must be finite and is not, with its place.
pub fn result<T: Serialize + DeserializeOwned>(output: &T) -> Result<serde_json::Value, JobError> {
    let json = serde_json::to_value(output).map_err(|error| JobError::Failed(error.to_string()))?;
    match T::deserialize(&json) {
        Ok(_) => Ok(json),
        Err(error) => Err(JobError::Failed(match not_finite(output) {
            Some(place) => format!("the result has no finite number at {place}"),
            None => format!("the result would not read back: {error}"),
        })),
    }
}

/// An error of a stored block.
pub fn unreadable(stage: &str, reason: impl ToString) -> JobError {
    JobError::Unreadable { stage: stage.to_owned(), reason: reason.to_string() }
}

fn encoded<T: Serialize>(value: &T) -> Result<Vec<u8>, JobError> {
    let mut bytes = Vec::new();
    ciborium::into_writer(value, &mut bytes)
        .map_err(|error| JobError::Failed(format!("a block cannot be written: {error}")))?;
    Ok(bytes)
}

/// A value and the bytes behind it.
fn decoded<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), String> {
    let mut rest = bytes;
    let value = ciborium::from_reader(&mut rest).map_err(|error| match error {
        ciborium::de::Error::Io(_) => "it is cut off".to_owned(),
        other => other.to_string(),
    })?;
    Ok((value, rest))
}

/// The first number that is not finite and that its type needs: its place, with the names on the way, and its value.
fn not_finite<T: Serialize + DeserializeOwned>(output: &T) -> Option<String> {
    let tree = Tree::serialized(output).ok()?;
    let mut not_finite_places = Vec::new();
    search(&tree, &mut Vec::new(), &mut not_finite_places);
    // With every other one finite, only the one that is missing can be what does not read back.
    let mut finite = tree.clone();
    for (place, _) in &not_finite_places {
        replace(&mut finite, place, Tree::Float(0.0));
    }
    // Read from JSON, as results are: reading from the tree would compile a second reader of every kind's result.
    let needed = |place: &[usize]| {
        let mut alone = finite.clone();
        replace(&mut alone, place, Tree::Null);
        serde_json::to_value(&alone).is_ok_and(|json| T::deserialize(&json).is_err())
    };
    let (place, value) = not_finite_places.iter().find(|(place, _)| needed(place))?;
    Some(format!("{}: {value}", described(&tree, place)))
}

/// Places of all numbers that are not finite: positions among the children from the root on.
fn search(tree: &Tree, at: &mut Vec<usize>, found: &mut Vec<(Vec<usize>, f64)>) {
    if let Tree::Float(value) = tree
        && !value.is_finite()
    {
        found.push((at.clone(), *value));
    }
    for (position, child) in children(tree).into_iter().enumerate() {
        at.push(position);
        search(child, at, found);
        at.pop();
    }
}

fn children(tree: &Tree) -> Vec<&Tree> {
    match tree {
        Tree::Array(items) => items.iter().collect(),
        Tree::Map(entries) => entries.iter().map(|(_, value)| value).collect(),
        _ => Vec::new(),
    }
}

fn replace(tree: &mut Tree, place: &[usize], by: Tree) {
    match (place, tree) {
        ([], tree) => *tree = by,
        ([first, rest @ ..], Tree::Array(items)) => replace(&mut items[*first], rest, by),
        ([first, rest @ ..], Tree::Map(entries)) => replace(&mut entries[*first].1, rest, by),
        _ => {}
    }
}

/// A place in words: `cases[0] (hot).quantities[1] (T).nominal`.
fn described(tree: &Tree, place: &[usize]) -> String {
    let (mut text, mut at) = (String::new(), tree);
    for &position in place {
        match at {
            Tree::Map(entries) => {
                let (key, value) = &entries[position];
                let dot = if text.is_empty() { "" } else { "." };
                text.push_str(&format!("{dot}{}", key.as_text().unwrap_or("?")));
                at = value;
            }
            Tree::Array(items) => {
                text.push_str(&format!("[{position}]"));
                at = &items[position];
            }
            _ => {}
        }
        if let Tree::Map(entries) = at {
            let named = |name: &&str| entries.iter().find(|(key, _)| key.as_text() == Some(*name))?.1.as_text();
            if let Some(name) = NAMES.iter().find_map(named) {
                text.push_str(&format!(" ({name})"));
            }
        }
    }
    text
}
