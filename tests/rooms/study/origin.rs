//! Tests of `src/study/origin.rs`.

use std::net::IpAddr;

use bmv::study::origin::*;

fn parsed(url: &str) -> Option<(String, u16)> {
    Origin::parse(url).map(|origin| (origin.host, origin.port))
}

#[test]
fn only_plain_https_addresses_are_taken() {
    let some = |host: &str, port| Some((host.to_owned(), port));
    assert_eq!(parsed("https://example.org/x.csv"), some("example.org", 443));
    assert_eq!(parsed("https://example.org:8443?x"), some("example.org", 8443));
    assert_eq!(parsed("https://192.0.2.1/x"), some("192.0.2.1", 443));
    assert_eq!(parsed("https://[2001:db8::1]:1/x"), some("2001:db8::1", 1));
    for url in [
        "http://example.org/x",
        "file:///etc/passwd",
        "-o/tmp/x",
        "https://a b",
        "https:///x",
        "https://user@127.0.0.1/x",
        "https://example.org\\@127.0.0.1/x",
        "https://0x7f.0.0.1/x",
        "https://2130706433/x",
        "https://127.1/x",
        "https://example.org:x/",
        "https://ex%61mple.org/",
        "https://[::1/x",
    ] {
        assert_eq!(parsed(url), None, "{url}");
    }
}

#[test]
fn addresses_that_are_not_public_are_known() {
    for text in [
        "127.0.0.1",
        "10.1.2.3",
        "172.16.0.1",
        "172.31.255.255",
        "192.168.1.1",
        "169.254.169.254",
        "100.64.0.1",
        "0.0.0.0",
        "224.0.0.1",
        "255.255.255.255",
        "::",
        "::1",
        "fe80::1",
        "fc00::1",
        "fd12::1",
        "ff02::1",
        "::ffff:127.0.0.1",
        "::ffff:10.0.0.1",
        "64:ff9b::a00:1",
        "2002:7f00:1::",
        "2001:db8::1",
        "2001::1",
    ] {
        assert!(is_internal(text.parse().expect("an address")), "{text}");
    }
    for text in ["8.8.8.8", "172.32.0.1", "100.128.0.1", "2606:4700::1111", "2001:4860:4860::8888", "2002:808:808::"] {
        assert!(!is_internal(text.parse().expect("an address")), "{text}");
    }
}

#[test]
fn a_name_is_pinned_to_what_was_looked_at() {
    let addresses: Vec<IpAddr> = ["8.8.8.8", "2606:4700::1111"].map(|text| text.parse().expect("one")).to_vec();
    let origin = Origin::parse("https://example.org/x").expect("plain");
    assert_eq!(origin.pin(&addresses).expect("a name"), "example.org:443:8.8.8.8,[2606:4700::1111]");
    assert_eq!(Origin::parse("https://8.8.8.8/x").expect("plain").pin(&addresses), None);
}
