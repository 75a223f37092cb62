//! Tests of `src/job/array.rs`.

use bmv::document::hash::sha256_hex;
use bmv::job::array::{Array, Arrays, npy};

#[test]
fn an_array_has_the_bytes_that_numpy_writes() {
    // `numpy.save` of `numpy.array([[1.0, 2.0]])`, NumPy 2.
    let bytes = npy(&[1, 2], &[1.0, 2.0]);
    assert_eq!(bytes.len(), 128 + 16);
    let header = b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }";
    assert!(bytes.starts_with(header) && bytes[127] == b'\n');
    let of_one = b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f8', 'fortran_order': False, 'shape': (3,), } ";
    assert!(npy(&[3], &[0.0; 3]).starts_with(of_one));
}

/// Arrays with a NaN, longer than what is hashed at a time, and with no number.
fn arrays() -> [Array; 3] {
    let long = (0..20_001).map(|i| f64::from(i) / 7.0).collect();
    [
        Array::new(vec![2, 2], vec![1.0, f64::NAN, -0.0, 4.0]),
        Array::new(vec![20_001], long),
        Array::new(vec![0, 3], vec![]),
    ]
}

#[test]
fn arrays_are_found_again_by_their_hashes() {
    let mut bytes = Vec::new();
    arrays().into_iter().collect::<Arrays>().write_npy(&mut bytes);
    let read = Arrays::from_npy(&bytes).unwrap();
    for array in arrays() {
        assert_eq!(array.sha256(), sha256_hex(&array.npy()));
        let json = serde_json::to_value(&array).unwrap();
        let mut again: Array = serde_json::from_value(json.clone()).unwrap();
        assert!(again.numbers().is_empty());
        assert_eq!(serde_json::to_value(&again).unwrap(), json);
        read.fill(&mut again).unwrap();
        let bits = |own: &Array| own.numbers().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(&array));
    }
    let mut foreign: Array = serde_json::from_value(serde_json::json!({"shape": [1], "sha256": "00"})).unwrap();
    assert_eq!(read.fill(&mut foreign), Err("00".to_owned()));
    let mut other_shape = serde_json::to_value(&arrays()[0]).unwrap();
    other_shape["shape"] = serde_json::json!([4]);
    assert!(read.fill(&mut serde_json::from_value(other_shape).unwrap()).is_err());
}

#[test]
fn no_bytes_but_those_of_arrays_are_read() {
    let mut whole = Vec::new();
    arrays()[0].write_npy(&mut whole);
    for cut in [1, 9, 40, whole.len() - 1] {
        assert!(Arrays::from_npy(&whole[..cut]).is_err(), "{cut} bytes");
    }
    for (old, new) in [("<f8", "<f4"), ("False", "True "), ("(2, 2)", "(9, 2)"), ("(2, 2)", "(-, 2)")] {
        let text: Vec<u8> = whole.clone();
        let at = text.windows(old.len()).position(|own| own == old.as_bytes()).unwrap();
        let altered = [&text[..at], new.as_bytes(), &text[at + old.len()..]].concat();
        assert!(Arrays::from_npy(&altered).is_err(), "{new}");
    }
    // More numbers than any memory has.
    let mut huge = npy(&[1], &[1.0]);
    let text = b"{'descr': '<f8', 'fortran_order': False, 'shape': (4611686018427387904, 4), }";
    huge[10..10 + text.len()].copy_from_slice(text);
    assert!(Arrays::from_npy(&huge).is_err());
}
