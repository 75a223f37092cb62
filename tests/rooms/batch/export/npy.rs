//! Tests of `src/batch/export/npy.rs`.

use bmv::batch::export::npy::*;

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
