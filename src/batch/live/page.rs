//! What is served under a path.

use crate::batch::next_pass::Offer;

/// What a file is to a browser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// HTML, to which the state and the offers are added.
    Page,
    /// Anything else, as it is.
    Other(&'static str),
}

/// A file of the reports, in memory.
#[derive(Clone, Debug)]
pub(super) struct Served {
    pub kind: Kind,
    pub content: Vec<u8>,
    /// What can be adopted from here: of which pass.
    pub offers: Vec<(String, Offer)>,
}

impl Served {
    /// A file by its name and content.
    pub fn new(name: &str, content: &[u8]) -> Self {
        let kind = match name.rsplit_once('.').map(|(_, ending)| ending) {
            Some("html") => Kind::Page,
            Some("json") => Kind::Other("application/json"),
            Some("csv") => Kind::Other("text/csv; charset=utf-8"),
            Some("svg") => Kind::Other("image/svg+xml"),
            Some("npy") => Kind::Other("application/octet-stream"),
            _ => Kind::Other("text/plain; charset=utf-8"),
        };
        Self { kind, content: content.to_owned(), offers: Vec::new() }
    }
}
