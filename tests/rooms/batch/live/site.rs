//! Tests of `src/batch/live/site.rs`.

use bmv::batch::live::site::*;

#[test]
fn addresses_and_forms_are_read_as_browsers_write_them() {
    assert_eq!(decoded("/a%20b/%C3%A9.html"), "/a b/\u{e9}.html");
    assert_eq!(decoded("/100%/%zz%4"), "/100%/%zz%4");
    let path = "/a b/p%2e/\u{e9}.html";
    assert_eq!(decoded(&address(path)), path);
    let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
    let read = form(b"pass=pass-1.json&effect=a%3Ab+c&effect=%26").expect("a form");
    assert_eq!(read, [pair("pass", "pass-1.json"), pair("effect", "a:b c"), pair("effect", "&")]);
    assert_eq!(form(b"\xff"), None);
    assert_eq!(form(b"no pair"), None);
    assert_eq!(token("a=b&token=x"), Some("x"));
}
