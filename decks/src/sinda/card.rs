//! Lines of a deck.

/// A line that is no comment, without the comment behind `$`.
#[derive(Debug, Clone)]
pub(super) struct Card<'a> {
    /// The file's name.
    pub(super) file: &'a str,
    /// The line, from 1.
    pub(super) line: usize,
    /// What stands in it.
    pub(super) text: &'a str,
    /// The last comment line above it, without its `C`, until a blank line or another block.
    pub(super) comment: Option<Comment<'a>>,
}

/// A comment line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Comment<'a> {
    /// Its line, from 1.
    pub(super) line: usize,
    /// Its text.
    pub(super) text: &'a str,
}

/// What a line is.
pub(super) enum Line<'a> {
    /// Nothing.
    Blank,
    /// A comment, without its `C`.
    Comment(&'a str),
    /// Data or a statement, without the mark of Fortran (`F`, or `M` where it is translated).
    Card(&'a str),
}

/// Reads a line.
pub(super) fn line(text: &str) -> Line<'_> {
    let mut characters = text.chars();
    let first = characters.next();
    let is_word = characters.next().is_some_and(char::is_alphanumeric);
    let rest = match first {
        Some('C' | 'c') if !is_word => return Line::Comment(text.get(1..).unwrap_or_default().trim()),
        Some('F' | 'f' | 'M' | 'm') if !is_word => text.get(1..).unwrap_or_default(),
        _ => text,
    };
    let code = rest.split_once('$').map_or(rest, |(code, _)| code).trim();
    if code.is_empty() { Line::Blank } else { Line::Card(code) }
}

/// The words behind HEADER, in capitals, if the line begins a block.
pub(super) fn header(text: &str) -> Option<Vec<String>> {
    let Line::Card(code) = line(text) else { return None };
    let mut words = code.split([' ', '\t', ',']).filter(|word| !word.is_empty()).map(str::to_ascii_uppercase);
    (words.next()? == "HEADER").then(|| words.collect())
}
