//! Arrays of a result that are too long for JSON. Their numbers lie beside it as NPY (format 1.0 of NumPy's enhancement
//! proposal 1); in the JSON stand shape and hash, so that the hash of the JSON is one of the numbers too.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::document::hash::sha256_hex_of;

/// How an NPY file begins: its mark, and the version of the format.
const MARK: &[u8] = b"\x93NUMPY\x01\x00";
/// Bytes to whose multiple the header is filled, so that the numbers behind it are aligned.
const ALIGNMENT: usize = 64;
/// Bytes that are hashed at a time.
const PIECE: usize = 1 << 13;

/// Numbers in rows, columns and so on, the last index running fastest. A number that is not there is NaN.
#[derive(Clone, Debug)]
pub struct Array {
    shape: Vec<usize>,
    numbers: Numbers,
}

/// Where the numbers are.
#[derive(Clone, Debug)]
enum Numbers {
    Here(Arc<Vec<f64>>),
    /// Beside the JSON of which the array was read, in the block of this hash.
    Beside(String),
}

/// An array as it stands in JSON.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Array")]
struct Reference {
    /// Sizes; the last index runs fastest.
    shape: Vec<usize>,
    /// SHA-256 of the NPY file with the numbers, 64 lower-case hexadecimal digits.
    sha256: String,
}

impl Array {
    /// Numbers of a shape; a number that is lacking is NaN.
    pub fn new(shape: Vec<usize>, mut numbers: Vec<f64>) -> Self {
        numbers.resize(shape.iter().product(), f64::NAN);
        Self { shape, numbers: Numbers::Here(Arc::new(numbers)) }
    }

    /// The numbers; none of an array that was read without them.
    pub fn numbers(&self) -> &[f64] {
        match &self.numbers {
            Numbers::Here(numbers) => numbers,
            Numbers::Beside(_) => &[],
        }
    }

    /// SHA-256 of the NPY file.
    pub fn sha256(&self) -> String {
        match &self.numbers {
            Numbers::Here(numbers) => {
                sha256_hex_of(std::iter::once(header(&self.shape)).chain(numbers.chunks(PIECE).map(little_endian)))
            }
            Numbers::Beside(sha256) => sha256.clone(),
        }
    }

    /// The NPY file.
    pub fn npy(&self) -> Vec<u8> {
        npy(&self.shape, self.numbers())
    }

    /// Appends the NPY file.
    pub fn write_npy(&self, bytes: &mut Vec<u8>) {
        append(&self.shape, self.numbers(), bytes);
    }

    /// Reads an NPY file as it is written here from the start of these bytes; gives what follows it too.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn split_npy(bytes: &[u8]) -> Result<(Self, &[u8]), &'static str> {
        let body = bytes.strip_prefix(MARK).ok_or("an array does not begin as an NPY file of version 1.0")?;
        let (length, body) = body.split_first_chunk::<2>().ok_or(CUT)?;
        let (text, body) = body.split_at_checked(usize::from(u16::from_le_bytes(*length))).ok_or(CUT)?;
        let shape = shape_of(text).ok_or("the header of an array is not one that is written here")?;
        let size = shape.iter().try_fold(8_usize, |size, &part| size.checked_mul(part)).ok_or(CUT)?;
        let (body, rest) = body.split_at_checked(size).ok_or(CUT)?;
        let numbers = body.as_chunks::<8>().0.iter().map(|word| f64::from_le_bytes(*word)).collect();
        Ok((Self::new(shape, numbers), rest))
    }
}

/// What is said of an array whose numbers end too early.
const CUT: &str = "an array is cut off";

/// Equal numbers to the bit, NaN too.
impl PartialEq for Array {
    fn eq(&self, other: &Self) -> bool {
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        self.shape == other.shape
            && match (&self.numbers, &other.numbers) {
                (Numbers::Here(own), Numbers::Here(others)) => own.iter().zip(others.iter()).all(same),
                _ => self.sha256() == other.sha256(),
            }
    }
}

impl Serialize for Array {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Reference { shape: self.shape.clone(), sha256: self.sha256() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Array {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Reference { shape, sha256 } = Reference::deserialize(deserializer)?;
        Ok(Self { shape, numbers: Numbers::Beside(sha256) })
    }
}

impl JsonSchema for Array {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        Reference::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Reference::json_schema(generator)
    }
}

/// Arrays by their hash.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrays(BTreeMap<String, Array>);

impl FromIterator<Array> for Arrays {
    fn from_iter<T: IntoIterator<Item = Array>>(arrays: T) -> Self {
        Self(arrays.into_iter().map(|array| (array.sha256(), array)).collect())
    }
}

impl Arrays {
    /// Puts its numbers into an array that was read without them.
    ///
    /// # Errors
    /// The hash of numbers that are not here, or have another shape.
    pub fn fill(&self, array: &mut Array) -> Result<(), String> {
        let Numbers::Beside(sha256) = &array.numbers else { return Ok(()) };
        match self.0.get(sha256).filter(|own| own.shape == array.shape) {
            Some(own) => array.clone_from(own),
            None => return Err(sha256.clone()),
        }
        Ok(())
    }

    /// Appends all of them as NPY files, in the order of their hashes.
    pub fn write_npy(&self, bytes: &mut Vec<u8>) {
        self.0.values().for_each(|array| array.write_npy(bytes));
    }

    /// Reads NPY files that stand one after the other.
    ///
    /// # Errors
    /// What is wrong with one of them.
    pub fn from_npy(mut bytes: &[u8]) -> Result<Self, &'static str> {
        let mut arrays = Vec::new();
        while !bytes.is_empty() {
            let (array, rest) = Array::split_npy(bytes)?;
            arrays.push(array);
            bytes = rest;
        }
        Ok(arrays.into_iter().collect())
    }
}

/// An array of doubles as an NPY file.
pub fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::new();
    append(shape, values, &mut bytes);
    bytes
}

fn append(shape: &[usize], values: &[f64], bytes: &mut Vec<u8>) {
    let header = header(shape);
    bytes.reserve_exact(header.len() + 8 * values.len());
    bytes.extend(header);
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}

fn little_endian(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// What stands before the numbers: mark, version, length of the description, description.
fn header(shape: &[usize]) -> Vec<u8> {
    let sizes: Vec<String> = shape.iter().map(usize::to_string).collect();
    // A tuple of one has a comma behind it.
    let sizes = if sizes.len() == 1 { format!("{},", sizes[0]) } else { sizes.join(", ") };
    let mut text = format!("{BEFORE_SHAPE}{sizes}{AFTER_SHAPE}");
    let before = MARK.len() + 2;
    let filled = (before + text.len() + 1).next_multiple_of(ALIGNMENT);
    text.push_str(&" ".repeat(filled - before - text.len() - 1));
    text.push('\n');
    let mut bytes = MARK.to_vec();
    // A description has a few sizes of at most 20 digits.
    bytes.extend(u16::try_from(text.len()).unwrap_or(u16::MAX).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

const BEFORE_SHAPE: &str = "{'descr': '<f8', 'fortran_order': False, 'shape': (";
const AFTER_SHAPE: &str = "), }";

/// The shape that a description states.
fn shape_of(text: &[u8]) -> Option<Vec<usize>> {
    let text = std::str::from_utf8(text).ok()?.trim_end();
    let sizes = text.strip_prefix(BEFORE_SHAPE)?.strip_suffix(AFTER_SHAPE)?;
    sizes.split(',').map(str::trim).filter(|size| !size.is_empty()).map(|size| size.parse().ok()).collect()
}
