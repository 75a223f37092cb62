//! Tests of `core/src/document/hash.rs`.

use bmv::document::hash::*;

#[test]
fn agrees_with_the_standard() {
    // FIPS 180-2, appendix B.1 and the empty message.
    assert_eq!(sha256_hex(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert_eq!(sha256_hex(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}
