//! Tests of `core/src/document/canonical.rs`.

use bmv::document::canonical::*;
use serde_json::{Value, json};

#[test]
fn one_meaning_has_one_text() {
    let text = |v: Value| canonical(&v).expect("finite");
    assert_eq!(text(json!({"b": 1.0, "a": [true, null, -0.0, "x"]})), r#"{"a":[true,null,0,"x"],"b":1}"#);
    assert_eq!(text(json!(1)), text(json!(1.0)));
    // Bytes, not characters of UTF-16: U+FF61 before U+1D306.
    assert_eq!(text(json!({"\u{1d306}": 1, "\u{ff61}": 2})), "{\"\u{ff61}\":2,\"\u{1d306}\":1}");
    assert_eq!(text(json!("\u{1}\n\"\\é")), "\"\\u0001\\n\\\"\\\\é\"");
}

#[test]
fn integers_are_exact_and_floats_shortest() {
    for exact in ["18446744073709551615", "9007199254740993", "-9223372036854775808"] {
        let value: Value = serde_json::from_str(exact).expect("valid");
        assert_eq!(canonical(&value).as_deref(), Ok(exact));
    }
    for (value, expected) in [
        (0.1 + 0.2, "0.30000000000000004"),
        (1e-7, "1e-7"),
        (1e300, "1e300"),
        (5e-324, "5e-324"),
        (1e20, "100000000000000000000"),
        (-2.5, "-2.5"),
    ] {
        assert_eq!(float(value).as_deref(), Ok(expected));
    }
    assert!(float(f64::NAN).is_err() && float(f64::INFINITY).is_err());
}
