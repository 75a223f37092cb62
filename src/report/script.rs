//! The script of a page, and by which name its policy admits a script: the hash of its text.

use sha2::{Digest, Sha256};

/// The script of every page: tables sort and filter, figures tell their values. A page says all of it without.
pub const OF_PAGES: &str = include_str!("../../templates/report.js");

/// What a page may load and run: nothing but its own style and these scripts (Content Security Policy, level 3).
pub(super) fn policy(scripts: &[&str]) -> String {
    let sources = scripts.iter().map(|text| format!(" 'sha256-{}'", base64(&Sha256::digest(text.as_bytes()))));
    format!("default-src 'none'; style-src 'unsafe-inline'; script-src{}", sources.collect::<String>())
}

/// Bytes in base 64 (RFC 4648, section 4).
pub fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let of_three = |three: &[u8]| {
        let number =
            (0..3).fold(0_usize, |number, at| number << 8 | three.get(at).map_or(0, |byte| usize::from(*byte)));
        let digit = move |at: usize| match at <= three.len() {
            true => char::from(DIGITS[number >> (18 - 6 * at) & 63]),
            false => '=',
        };
        [digit(0), digit(1), digit(2), digit(3)]
    };
    bytes.chunks(3).flat_map(of_three).collect()
}
