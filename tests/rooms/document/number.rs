//! Tests of `core/src/document/number.rs`.

use bmv::document::number::*;

#[test]
fn the_grammar_of_rfc_8259() {
    for valid in ["0", "-0", "10", "0.5", "-1.25e-3", "1E+9", "123456789012345678901234567890"] {
        assert_eq!(number_fault(valid), None, "{valid}");
        assert!(serde_json::from_str::<f64>(valid).is_ok(), "{valid}");
    }
    for invalid in ["01", "-01", ".5", "1.", "+1", "1e", "1e+", "0x10", "1_000", "1.5.2", "-", "2K"] {
        assert!(number_fault(invalid).is_some(), "{invalid}");
        assert!(serde_json::from_str::<f64>(invalid).is_err(), "{invalid}");
    }
}

#[test]
fn integral_floats_are_integers_where_they_are_exact() {
    assert_eq!(Number::Float(2.0).as_u64(), Some(2));
    assert_eq!(Number::Float(2.5).as_u64(), None);
    assert_eq!(Number::Float(1e300).as_u64(), None);
    assert_eq!(Number::Signed(-1).as_u64(), None);
    assert_eq!(Number::Unsigned(u64::MAX).as_u64(), Some(u64::MAX));
}
