//! Tests of `src/runner/cache/object.rs`.

use bmv::runner::cache::object::*;
use bmv::runner::key::Key;

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
