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

/// Reads a line. Of a deck with numbered headers (`BCD 3NODE DATA`) every line with a C in its first column is a comment,
/// and so is a remark, `REM`.
pub(super) fn line(text: &str, is_numbered: bool) -> Line<'_> {
    let mut characters = text.chars();
    let first = characters.next();
    let is_word =
        characters.next().is_some_and(char::is_alphanumeric) && !(is_numbered && matches!(first, Some('C' | 'c')));
    if is_numbered
        && let Some(remark) = text.trim_start().strip_prefix("REM")
        && !remark.starts_with(|c: char| !c.is_whitespace())
    {
        return Line::Comment(remark.trim());
    }
    let rest = match first {
        Some('C' | 'c') if !is_word => return Line::Comment(text.get(1..).unwrap_or_default().trim()),
        Some('F' | 'f' | 'M' | 'm') if !is_word => text.get(1..).unwrap_or_default(),
        _ => text,
    };
    let code = rest.split_once('$').map_or(rest, |(code, _)| code).trim();
    if code.is_empty() { Line::Blank } else { Line::Card(code) }
}

/// A line that begins a block.
pub(super) struct Header {
    /// Words behind HEADER, in capitals.
    pub(super) words: Vec<String>,
    /// Whether it is a numbered one, `BCD 3NODE DATA`, as in SINDA/G.
    pub(super) is_numbered: bool,
}

/// The header that a line is, if it begins a block.
pub(super) fn header(text: &str) -> Option<Header> {
    let Line::Card(code) = line(text, false) else { return None };
    let (first, rest) = code.split_once(char::is_whitespace)?;
    let (is_numbered, rest) = match first.to_ascii_uppercase().as_str() {
        "HEADER" => (false, rest),
        "BCD" => (true, rest.trim_start().strip_prefix('3')?),
        _ => return None,
    };
    let words = rest.split([' ', '\t', ',']).filter(|word| !word.is_empty()).map(str::to_ascii_uppercase);
    Some(Header { words: words.collect(), is_numbered })
}

/// Whether a line ends the deck: `END OF DATA`.
pub(super) fn is_end(code: &str) -> bool {
    let mut words = code.split_whitespace();
    ["END", "OF", "DATA"].into_iter().all(|word| words.next().is_some_and(|one| one.eq_ignore_ascii_case(word)))
}
