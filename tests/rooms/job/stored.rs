//! Tests of `src/job/stored.rs`.

use bmv::job::stored::*;
use ciborium::Value as Tree;
use serde::{Deserialize, Serialize};
use serde_json::json;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Inner {
    name: String,
    value: f64,
    perhaps: Option<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    list: Vec<[f64; 2]>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Outer {
    first: Vec<Inner>,
    #[serde(flatten)]
    second: Inner,
    pair: (u64, f64),
}

fn outer(values: [f64; 5]) -> Outer {
    let [a, b, c, d, e] = values;
    let inner = |value, perhaps| Inner { name: "NaN".into(), value, perhaps, list: vec![[a, e], [0.1, -0.0]] };
    Outer { first: vec![inner(a, None), inner(b, Some(c))], second: inner(d, Some(e)), pair: (u64::MAX, c) }
}

/// Bits of all numbers, since NaN is not equal to itself.
fn bits(tree: &impl Serialize) -> String {
    format!("{:?}", Tree::serialized(tree).expect("a tree"))
}

proptest::proptest! {
    #[test]
    fn any_numbers_survive_in_a_block(values: [u64; 5], numbers: Vec<u64>) {
        let head = outer(values.map(f64::from_bits));
        let numbers: Vec<f64> = numbers.into_iter().map(f64::from_bits).collect();
        let bytes = with_numbers(&head, &numbers).expect("bytes");
        let (back, rest) = split_numbers::<Outer>(&bytes, "s").expect("a block");
        assert_eq!(bits(&back), bits(&head));
        assert_eq!(bits(&rest), bits(&numbers));
    }
}

#[test]
fn what_json_loses_survives_in_a_block() {
    let special = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, f64::MIN_POSITIVE];
    let bytes = with_numbers(&outer(special), &special).expect("bytes");
    let (back, numbers) = split_numbers::<Outer>(&bytes, "s").expect("a block");
    assert!(back.first[0].value.is_nan() && back.first[0].perhaps.is_none());
    assert_eq!((back.first[1].value, back.first[1].perhaps), (f64::INFINITY, Some(f64::NEG_INFINITY)));
    assert!(back.second.value.is_sign_negative() && back.first[0].name == "NaN");
    assert!(numbers[0].is_nan() && numbers[1..] == special[1..]);
}

#[test]
fn damage_is_seen() {
    let head = outer([1.0; 5]);
    let bytes = with_numbers(&head, &[1.5, 2.5]).expect("bytes");
    for cut in 0..bytes.len() {
        let short = split_numbers::<Outer>(&bytes[..cut], "s");
        assert!(short.is_err() || short.is_ok_and(|(_, numbers)| numbers.len() < 2), "cut at {cut}");
    }
    assert!(Outer::from_bytes(&bytes, "s").is_err_and(|error| error.to_string().contains("too long")));
    let error = Outer::from_bytes(b"{\"first\": 1}", "conclude").expect_err("not CBOR");
    assert!(error.to_string().contains("stage `conclude`"), "{error}");
}

/// Builds without debug assertions do not read back what they write.
#[test]
#[cfg(debug_assertions)]
fn a_value_that_would_not_read_back_is_refused() {
    #[derive(Serialize, Deserialize)]
    struct Lossy {
        #[serde(skip_serializing_if = "Vec::is_empty")]
        list: Vec<f64>,
    }
    let refused = Lossy { list: vec![] }.into_bytes();
    assert!(refused.is_err_and(|error| error.to_string().contains("`list`")));
}

#[test]
fn a_result_names_the_place_of_what_is_not_finite() {
    let mut output = outer([1.0; 5]);
    output.first[1].perhaps = Some(f64::NAN);
    let Ok(value) = result(&output) else { panic!("an optional number may be missing") };
    assert_eq!(value["first"][1]["perhaps"], json!(null));
    output.first[1].name = "gap".into();
    output.first[1].value = f64::NEG_INFINITY;
    let error = result(&output).expect_err("not a number").to_string();
    assert_eq!(error, "the result has no finite number at first[1] (gap).value: -inf");
}
