//! Tests of `src/runner/key.rs`.

use bmv::document::hash::sha256;
use bmv::runner::key::*;
use serde_json::{Value, json};

fn material() -> KeyMaterial {
    KeyMaterial {
        kind: "propagate".into(),
        algorithm_version: 1,
        engine_version: ENGINE_VERSION,
        seed: 7,
        name: "before".into(),
        identity: json!({"samples": 1000}),
        upstream: vec![Key::of(b"upstream")],
    }
}

#[test]
fn hashes_are_those_of_the_standard() {
    // FIPS 180-4's example "abc".
    let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    assert_eq!(Key::of(b"abc").as_str(), expected);
    assert_eq!(Key::of(b"abc").short(), &expected[..12]);
}

#[test]
fn every_named_field_changes_the_key() {
    let first = material().key().unwrap();
    assert_eq!(first, material().key().unwrap());
    let changes: [fn(&mut KeyMaterial); 8] = [
        |m| m.kind = "sensitivity".into(),
        |m| m.algorithm_version = 2,
        |m| m.engine_version += 1,
        |m| m.seed = 8,
        |m| m.name = "after".into(),
        |m| m.identity = json!({"samples": 1001}),
        |m| m.upstream = vec![Key::of(b"another")],
        |m| m.upstream.clear(),
    ];
    let mut keys = vec![first];
    for change in changes {
        let mut changed = material();
        change(&mut changed);
        keys.push(changed.key().unwrap());
    }
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), 9, "all keys differ");
}

#[test]
fn the_largest_seeds_do_not_collapse() {
    let [mut a, mut b] = [material(), material()];
    a.seed = u64::MAX;
    b.seed = u64::MAX - 1;
    assert_ne!(a.key().unwrap(), b.key().unwrap());
}

#[test]
fn the_order_of_the_identity_s_fields_does_not_matter() {
    let [mut a, mut b] = [material(), material()];
    a.identity = serde_json::from_str(r#"{"x": 1, "y": {"b": 2, "a": 3}}"#).unwrap();
    b.identity = serde_json::from_str(r#"{"y": {"a": 3, "b": 2}, "x": 1}"#).unwrap();
    assert_eq!(a.key().unwrap(), b.key().unwrap());
}

#[test]
fn blocks_differ_by_job_stage_index_and_input() {
    let job = Key::of(b"job");
    let keys = [
        block_key(&job, "sum", 0, [b"".as_slice(), b"input"].map(sha256)),
        block_key(&Key::of(b"other"), "sum", 0, [b"".as_slice(), b"input"].map(sha256)),
        block_key(&job, "mean", 0, [b"".as_slice(), b"input"].map(sha256)),
        block_key(&job, "sum", 1, [b"".as_slice(), b"input"].map(sha256)),
        block_key(&job, "sum", 0, [b"".as_slice(), b"inputs"].map(sha256)),
    ];
    for (i, a) in keys.iter().enumerate() {
        assert!(keys[i + 1..].iter().all(|b| a != b), "key {i} is unique");
    }
}

#[test]
fn explain_is_readable_json_of_what_was_hashed() {
    let text = material().explain().unwrap();
    let value: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["identity"]["samples"], 1000);
    assert_eq!(value["engine_version"], ENGINE_VERSION);
    assert!(text.contains("\n  \"name\": \"before\""), "{text}");
}

#[test]
fn only_hashes_are_keys() {
    assert!(Key::try_from("../../etc/passwd".to_owned()).is_err());
    assert!(Key::try_from("A".repeat(64)).is_err());
    assert!(Key::try_from("a".repeat(64)).is_ok());
}
