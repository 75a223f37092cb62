//! Tests of `src/job/kind.rs`.

use bmv::job::array::Arrays;
use bmv::job::kind::*;
use bmv::job::{KINDS, design, goal};
use serde_json::Value;

#[test]
fn every_kind_stands_once_and_is_found_by_its_name() {
    for (position, kind) in KINDS.iter().enumerate() {
        assert!(KINDS[..position].iter().all(|other| other.name() != kind.name()), "{} stands twice", kind.name());
        assert_eq!(find(kind.name()).map(|listed_kind| listed_kind.name()), Some(kind.name()));
    }
    assert!(find("sizing").is_none());
}

#[test]
fn a_result_is_read_as_its_kind_alone() {
    let written = design::Output { estimator: "own".to_owned(), ..design::Output::default() };
    let value = serde_json::to_value(&written).expect("JSON");
    let read = find("design").expect("a kind").output(&value, &Arrays::default()).expect("a result");
    assert_eq!(read.as_any().downcast_ref::<design::Output>(), Some(&written));
    assert!(read.as_any().downcast_ref::<goal::Output>().is_none());
    assert_eq!((read.kind(), read.to_json().expect("JSON")), ("design", value));
    assert!(find("goal").expect("a kind").output(&Value::Null, &Arrays::default()).is_err());
}
