//! Why a file is refused.

/// A file that a reader refuses, at its place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {message}", .line.map(|line| format!(":{line}")).unwrap_or_default())]
pub struct DeckError {
    /// Name of the file as it was given to the reader.
    pub file: String,
    /// Line, from 1; none in a binary file.
    pub line: Option<usize>,
    /// What is wrong, what was expected, what to do: a fragment in lower case without a final stop.
    pub message: String,
}

impl DeckError {
    /// An error at a line (from 1) of a file.
    pub fn at(file: &str, line: usize, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line: Some(line), message: message.into() }
    }

    /// An error of a whole file.
    pub fn of(file: &str, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line: None, message: message.into() }
    }
}
