//! Long lists of numbers as one string of bytes, little-endian doubles: for `#[serde(with = "packed")]`, in formats that have such
//! strings. Written one by one, each number has a head of its own, which takes far longer than the number.

use std::fmt;

use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::{Serialize, Serializer};

/// Writes numbers.
///
/// # Errors
/// Those of the format.
pub fn serialize<S: Serializer>(numbers: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    if serializer.is_human_readable() {
        return numbers.serialize(serializer);
    }
    let bytes: Vec<u8> = numbers.iter().flat_map(|value| value.to_le_bytes()).collect();
    serializer.serialize_bytes(&bytes)
}

/// Reads numbers.
///
/// # Errors
/// Those of the format; bytes of another length than that of whole numbers.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    if deserializer.is_human_readable() {
        deserializer.deserialize_seq(Numbers)
    } else {
        deserializer.deserialize_byte_buf(Numbers)
    }
}

struct Numbers;

impl<'de> Visitor<'de> for Numbers {
    type Value = Vec<f64>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list of numbers")
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
        let (words, rest) = bytes.as_chunks::<8>();
        match rest {
            [] => Ok(words.iter().map(|word| f64::from_le_bytes(*word)).collect()),
            _ => Err(E::invalid_length(bytes.len(), &"eight bytes for each number")),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut numbers = Vec::with_capacity(list.size_hint().unwrap_or(0).min(1 << 16));
        while let Some(value) = list.next_element()? {
            numbers.push(value);
        }
        Ok(numbers)
    }
}
