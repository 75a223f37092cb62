//! Tests of `src/report/script.rs`.

use bmv::report::script::*;

#[test]
fn base_64_is_that_of_the_standard() {
    // RFC 4648, section 10.
    for (bytes, digits) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
        assert_eq!(base64(bytes.as_bytes()), digits);
    }
}

#[test]
fn the_script_makes_no_markup_and_asks_for_nothing() {
    for forbidden in [
        "innerHTML",
        "outerHTML",
        "insertAdjacent",
        "document.write",
        "eval",
        "Function(",
        "fetch",
        "XMLHttp",
        "import",
        "</",
        "<!--",
    ] {
        assert!(!OF_PAGES.contains(forbidden), "{forbidden}");
    }
    assert_eq!(bmv::document::visible::escaped_lines(OF_PAGES), OF_PAGES, "its hash is that of the page's text");
}
