//! A source text, and places in it.

use std::sync::Arc;

/// A file's text with the name under which it is shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    name: String,
    text: String,
}

/// A range of bytes of a source, `start..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, PartialOrd, Ord)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One after the last byte.
    pub end: usize,
}

impl Span {
    /// The range `start..end`.
    pub const fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }
}

/// Line and column of a character, both from 1; columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Source {
    /// A source text. `name` is what messages show, such as a path relative to where the user stands.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        Arc::new(Self { name: name.into(), text: text.into() })
    }

    /// The name shown in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Line and column of a byte; a byte past the end counts as the end, one inside a character as that character.
    pub fn position(&self, byte: usize) -> Position {
        let byte = floor_boundary(&self.text, byte);
        let before = &self.text[..byte];
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        Position { line: before.matches('\n').count() + 1, column: before[start..].chars().count() + 1 }
    }
}

/// The largest boundary of a character at or before `byte`.
pub(super) fn floor_boundary(text: &str, byte: usize) -> usize {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

/// A JSON path, shown as `$.nodes.board.capacity`. It is a last step and a link to the path before it, which all members
/// of an object or array share: a long key is kept once, however many values stand under it. Reading limits the depth.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct JsonPath(Option<Arc<Step>>);

#[derive(PartialEq, Eq)]
enum Step {
    Root,
    Key(JsonPath, Box<str>),
    Index(JsonPath, usize),
}

impl JsonPath {
    /// The path of a whole document.
    pub fn root() -> Self {
        Self(Some(Arc::new(Step::Root)))
    }

    /// The path of a field.
    pub fn key(&self, key: &str) -> Self {
        Self(Some(Arc::new(Step::Key(self.clone(), key.into()))))
    }

    /// The path of a member of an array.
    pub fn index(&self, index: usize) -> Self {
        Self(Some(Arc::new(Step::Index(self.clone(), index))))
    }

    /// The path of the object or array that holds what is at this one.
    pub fn parent(&self) -> Option<&Self> {
        match self.0.as_deref() {
            Some(Step::Key(parent, _) | Step::Index(parent, _)) => Some(parent),
            Some(Step::Root) | None => None,
        }
    }

    /// Whether both are the same links, and not only the same path.
    pub fn is_same(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(one), Some(two)) => Arc::ptr_eq(one, two),
            (None, None) => true,
            _ => false,
        }
    }

    /// Whether it is that of a place outside JSON.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }
}

impl std::fmt::Display for JsonPath {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let paths = std::iter::successors(Some(self), |path| path.parent());
        let steps: Vec<&Step> = paths.filter_map(|path| path.0.as_deref()).collect();
        steps.into_iter().rev().try_for_each(|step| match step {
            Step::Root => f.write_str("$"),
            Step::Key(_, key) if is_plain(key) => write!(f, ".{key}"),
            Step::Key(_, key) => write!(f, "[{}]", super::canonical::quoted(key)),
            Step::Index(_, index) => write!(f, "[{index}]"),
        })
    }
}

/// Whether a key stands in a path behind a point, without quotes.
fn is_plain(key: &str) -> bool {
    key.chars().next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Where something stands: file, bytes, and JSON path.
#[derive(Clone, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub source: Arc<Source>,
    /// The bytes.
    pub span: Span,
    /// The JSON path; empty outside JSON.
    pub path: JsonPath,
}

impl std::fmt::Debug for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}..{} {}", self.source.name, self.span.start, self.span.end, self.path)
    }
}

impl Place {
    /// A place in a file that is not JSON, such as a cell of a table.
    pub fn in_text(source: &Arc<Source>, span: Span) -> Self {
        Self { source: Arc::clone(source), span, path: JsonPath::default() }
    }

    /// Line and column of the first character.
    pub fn position(&self) -> Position {
        self.source.position(self.span.start)
    }

    /// The text at the place, as written.
    pub fn text(&self) -> &str {
        self.source.text.get(self.span.start..self.span.end).unwrap_or("")
    }

    /// The part of a JSON string whose *decoded* text has the bytes `start..end`: an error inside an expression
    /// points into the string, escapes or not. Any other place is returned as it is.
    pub fn inside_string(&self, start: usize, end: usize) -> Self {
        let Some(inner) = self.text().strip_prefix('"') else { return self.clone() };
        let (mut raw, mut decoded) = (0, 0);
        let mut first = None;
        let mut last = None;
        let bytes = inner.as_bytes();
        while raw < bytes.len() && bytes[raw] != b'"' {
            if first.is_none() && decoded >= start {
                first = Some(raw);
            }
            if last.is_none() && decoded >= end {
                last = Some(raw);
            }
            let (used, made) = super::json::string_step(&inner[raw..]);
            raw += used;
            decoded += made;
        }
        let base = self.span.start + 1;
        let (first, last) = (first.unwrap_or(raw), last.unwrap_or(raw));
        let mut place = self.clone();
        place.span = Span::new(base + first, base + last.max(first));
        place
    }
}
