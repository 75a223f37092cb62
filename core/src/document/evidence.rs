//! How far a source was itself read.

use super::written_words;

written_words! {
    /// How far a source was itself read.
    pub enum EvidenceForm: "evidence" {
        /// A definition, nothing to read.
        "definition" => Definition,
        /// The passage was read.
        "opened" => Opened,
        /// An excerpt of the source was read.
        "excerpt" => Excerpt,
        /// Known from other works only.
        "not opened" => NotOpened,
    }
}

/// A source in words, with a remark where it was not itself read.
pub fn source_text(source: &str, evidence: Option<EvidenceForm>) -> String {
    match evidence {
        Some(EvidenceForm::Excerpt) => format!("{source} (only an excerpt could be opened)"),
        Some(EvidenceForm::NotOpened) => format!("{source} (the source itself could not be opened)"),
        Some(EvidenceForm::Definition | EvidenceForm::Opened) | None => source.to_owned(),
    }
}
