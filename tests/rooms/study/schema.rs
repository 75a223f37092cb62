//! Tests of `src/study/schema.rs`.

use bmv::study::inherit::NAMED;
use bmv::study::job::Kinds;
use bmv::study::schema::*;
use serde_json::json;

#[test]
fn every_kind_has_a_schema_with_its_fields() {
    for kind in KINDS {
        let schema = schema(kind, &Kinds::default()).expect("a schema");
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema", "{kind}");
        assert!(schema["$defs"].as_object().is_some_and(|definitions| !definitions.is_empty()), "{kind}");
    }
    assert!(schema("house", &Kinds::default()).is_err());
    let pass = schema("pass", &Kinds::default()).expect("a schema");
    let properties = &pass["$defs"]["PassForm"]["properties"];
    for section in NAMED {
        let entry = &properties[section]["anyOf"][0]["additionalProperties"]["anyOf"][1];
        assert_eq!(entry, &json!({"type": "null"}), "{section}");
    }
}
