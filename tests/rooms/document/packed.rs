//! Tests of `core/src/document/packed.rs`.

use bmv::document::packed;
use serde::{Deserialize, Serialize};

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct List {
    #[serde(with = "packed")]
    numbers: Vec<f64>,
}

fn cbor(list: &impl Serialize) -> Vec<u8> {
    let mut bytes = Vec::new();
    ciborium::into_writer(list, &mut bytes).unwrap();
    bytes
}

#[test]
fn numbers_come_back_to_the_bit_at_eight_bytes_each() {
    // More than one buffer of the reader.
    let numbers: Vec<f64> =
        (0..10_000).map(|k| f64::from(k) / 3.0).chain([f64::NAN, f64::NEG_INFINITY, -0.0]).collect();
    let bytes = cbor(&List { numbers: numbers.clone() });
    assert!((8 * numbers.len()..8 * numbers.len() + 20).contains(&bytes.len()), "{}", bytes.len());
    let back: List = ciborium::from_reader(bytes.as_slice()).unwrap();
    let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<u64>>();
    assert_eq!(bits(&back.numbers), bits(&numbers));
    let none: List = ciborium::from_reader(cbor(&List { numbers: Vec::new() }).as_slice()).unwrap();
    assert!(none.numbers.is_empty());
}

#[test]
fn people_read_a_list() {
    let list = List { numbers: vec![1.5, -2.0] };
    let text = serde_json::to_string(&list).unwrap();
    assert_eq!(text, r#"{"numbers":[1.5,-2.0]}"#);
    assert_eq!(serde_json::from_str::<List>(&text).unwrap(), list);
}

#[test]
fn a_number_that_is_cut_off_is_an_error() {
    #[derive(Serialize)]
    struct Bytes {
        #[serde(serialize_with = "as_bytes")]
        numbers: Vec<u8>,
    }
    fn as_bytes<S: serde::Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(bytes)
    }
    let read = ciborium::from_reader::<List, _>(cbor(&Bytes { numbers: vec![0; 12] }).as_slice());
    let why = read.unwrap_err().to_string();
    assert!(why.contains("eight bytes for each number"), "{why}");
}
