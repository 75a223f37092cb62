//! JSON to a tree that knows its places, with every error of a file and not the first only.
//!
//! Stricter than needed nowhere, kinder in messages: comments, trailing commas, single quotes, NaN and the like get
//! their own message, and reading goes on behind them. Depth, size and the number of values are limited, so that no file
//! overflows the stack or fills the memory.

use std::collections::HashMap;
use std::sync::Arc;

use super::code;
use super::diagnostic::{Diagnostic, Diagnostics};
pub use super::number::Number;
use super::number::number_fault;
use super::source::{JsonPath, Place, Source, Span};
use super::suggest;

/// Arrays and objects nested deeper are refused.
pub const DEPTH: usize = 128;

/// Files larger than this are refused, in bytes.
pub const SIZE: usize = 64 << 20;

/// Files with more values (numbers, strings, arrays, objects, ...) are refused.
pub const VALUES: usize = 1_000_000;

/// Reading stops after so many errors.
const ERRORS: usize = 200;

/// A JSON value with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// Where it stands.
    pub place: Place,
}

/// A JSON value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `null`.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// A number.
    Number(Number),
    /// A string, decoded.
    String(String),
    /// An array.
    Array(Vec<Node>),
    /// An object, in the order of the file, keys unique.
    Object(Vec<Entry>),
    /// Something that was no JSON; an error has been reported at its place, so readers say nothing more.
    Invalid,
}

impl Value {
    /// What it is, for messages: `a string`, `an object`, ...
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Null => "null",
            Self::Bool(_) => "a truth value",
            Self::Number(_) => "a number",
            Self::String(_) => "a string",
            Self::Array(_) => "an array",
            Self::Object(_) => "an object",
            Self::Invalid => "not JSON",
        }
    }
}

/// A field of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Where the key stands; its path is the value's.
    pub key_place: Place,
    /// The value.
    pub node: Node,
}

impl Node {
    /// The field of an object.
    pub fn get(&self, key: &str) -> Option<&Node> {
        match &self.value {
            Value::Object(entries) => entries.iter().find(|e| e.key == key).map(|e| &e.node),
            _ => None,
        }
    }

    /// The same value without places, for hashing. Invalid parts become null.
    pub fn to_json(&self) -> serde_json::Value {
        match &self.value {
            Value::Null | Value::Invalid => serde_json::Value::Null,
            Value::Bool(b) => (*b).into(),
            Value::Number(Number::Unsigned(u)) => (*u).into(),
            Value::Number(Number::Signed(i)) => (*i).into(),
            Value::Number(Number::Float(f)) => (*f).into(),
            Value::String(s) => s.as_str().into(),
            Value::Array(items) => items.iter().map(Node::to_json).collect(),
            Value::Object(entries) => {
                serde_json::Value::Object(entries.iter().map(|e| (e.key.clone(), e.node.to_json())).collect())
            }
        }
    }
}

/// Reads bytes as UTF-8; an error names the first byte that is none.
pub fn decode(name: &str, bytes: Vec<u8>, diagnostics: &mut Diagnostics) -> Arc<Source> {
    let error = match String::from_utf8(bytes) {
        Ok(text) => return Source::new(name, text),
        Err(error) => error,
    };
    let bytes = error.as_bytes();
    let source = Source::new(name, String::from_utf8_lossy(bytes));
    let start = error.utf8_error().valid_up_to();
    let end = source.text()[start..].chars().next().map_or(start, |c| start + c.len_utf8());
    let byte = bytes.get(start).copied().unwrap_or_default();
    let utf16 = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    diagnostics.push(
        Diagnostic::error(
            &code::NOT_UTF8,
            &Place::in_text(&source, Span::new(start, end)),
            format!("the file is not UTF-8: byte 0x{byte:02x} at offset {start}"),
        )
        .help(if utf16 {
            "the file looks like UTF-16: save it as UTF-8 (without byte order mark)"
        } else {
            "save the file as UTF-8"
        }),
    );
    source
}

/// Reads and parses a file's bytes: [`decode`], then [`parse`]. `None` where the bytes are no UTF-8.
pub fn parse_bytes(name: &str, bytes: &[u8], diagnostics: &mut Diagnostics) -> Option<Node> {
    let before = diagnostics.errors();
    let source = decode(name, bytes.to_vec(), diagnostics);
    if diagnostics.errors() > before {
        return None;
    }
    parse(&source, diagnostics)
}

/// Parses a text. Errors go to `diagnostics`; what could be read behind them is returned, with
/// [`Value::Invalid`] in the gaps. `None` where the structure itself is broken off.
pub fn parse(source: &Arc<Source>, diagnostics: &mut Diagnostics) -> Option<Node> {
    let before = diagnostics.errors();
    let path = JsonPath::root();
    let mut parser = Parser { source, text: source.text(), at: 0, depth: 0, values: 0, path, before, diagnostics };
    parser.document().ok()
}

/// Length in bytes of the first character or escape of a string's inside, and of what it decodes to.
pub(super) fn string_step(raw: &str) -> (usize, usize) {
    let mut chars = raw.chars();
    match chars.next() {
        Some('\\') => match chars.next() {
            Some('u') => {
                let (used, c) = unicode_escape(raw);
                (used, c.map_or(3, char::len_utf8))
            }
            Some(c) => (1 + c.len_utf8(), 1),
            None => (1, 1),
        },
        Some(c) => (c.len_utf8(), c.len_utf8()),
        None => (1, 1),
    }
}

/// Decodes `\uXXXX`, or two of them for a character above U+FFFF: bytes used, and the character if it is one.
fn unicode_escape(raw: &str) -> (usize, Option<char>) {
    let unit = |from: usize| {
        let digits = raw.get(from..from + 6)?.strip_prefix("\\u")?;
        if digits.bytes().all(|b| b.is_ascii_hexdigit()) { u32::from_str_radix(digits, 16).ok() } else { None }
    };
    match unit(0) {
        None => (2, None),
        Some(high @ 0xd800..=0xdbff) => match unit(6) {
            Some(low @ 0xdc00..=0xdfff) => (12, char::from_u32(0x10000 + ((high - 0xd800) << 10) + (low - 0xdc00))),
            _ => (6, None),
        },
        Some(other) => (6, char::from_u32(other)),
    }
}

/// The text cannot be read any further.
struct Broken;

struct Parser<'a> {
    source: &'a Arc<Source>,
    text: &'a str,
    at: usize,
    depth: usize,
    values: usize,
    path: JsonPath,
    before: usize,
    diagnostics: &'a mut Diagnostics,
}

impl<'a> Parser<'a> {
    fn place(&self, start: usize, end: usize) -> Place {
        Place { source: Arc::clone(self.source), span: Span::new(start, end), path: self.path.clone() }
    }

    fn error(&mut self, code: &'static code::Code, start: usize, end: usize, message: impl Into<String>, help: &str) {
        let place = self.place(start, end.max(start));
        let mut diagnostic = Diagnostic::error(code, &place, message);
        if !help.is_empty() {
            diagnostic = diagnostic.help(help);
        }
        self.diagnostics.push(diagnostic);
    }

    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    /// Skips white space, and comments with an error each.
    fn skip(&mut self) {
        loop {
            let rest = &self.text[self.at..];
            let blank = rest.len() - rest.trim_start_matches([' ', '\t', '\n', '\r']).len();
            self.at += blank;
            let rest = &self.text[self.at..];
            let length = if rest.starts_with("//") || rest.starts_with('#') {
                rest.find('\n').unwrap_or(rest.len())
            } else if rest.starts_with("/*") {
                rest.find("*/").map_or(rest.len(), |i| i + 2)
            } else {
                return;
            };
            let shown = rest[..length].lines().next().map_or(1, |l| l.trim_end().len());
            self.error(
                &code::COMMENT,
                self.at,
                self.at + shown,
                "JSON has no comments",
                "put the remark into a \"description\" or \"because\" field",
            );
            self.at += length;
        }
    }

    fn document(&mut self) -> Result<Node, Broken> {
        if self.text.len() > SIZE {
            let message = format!("the file has {} bytes; at most {SIZE} are read", self.text.len());
            self.error(&code::TOO_LARGE, 0, 0, message, "measured data belong into CSV files");
            return Err(Broken);
        }
        if self.text.starts_with('\u{feff}') {
            self.at = '\u{feff}'.len_utf8();
            self.error(
                &code::BYTE_ORDER_MARK,
                0,
                self.at,
                "the file begins with a byte order mark",
                "save it as UTF-8 without BOM",
            );
        }
        self.skip();
        if self.at == self.text.len() {
            self.error(
                &code::SYNTAX,
                self.at,
                self.at,
                "the file is empty",
                "a file of bmv is one JSON object: {\"format\": ...}",
            );
            return Err(Broken);
        }
        let node = self.value()?;
        self.skip();
        if self.at < self.text.len() {
            let end = self.word_end();
            self.error(
                &code::SYNTAX,
                self.at,
                end,
                "text after the end of the document",
                "a file holds one JSON value; remove what follows",
            );
        }
        Ok(node)
    }

    /// End of the run of characters that would belong to a word or number here; at least one character.
    fn word_end(&self) -> usize {
        let rest = &self.text[self.at..];
        let run =
            rest.find(|c: char| !(c.is_alphanumeric() || matches!(c, '+' | '-' | '.' | '_'))).unwrap_or(rest.len());
        self.at + if run == 0 { rest.chars().next().map_or(0, char::len_utf8) } else { run }
    }

    fn value(&mut self) -> Result<Node, Broken> {
        let start = self.at;
        if self.diagnostics.errors() - self.before > ERRORS {
            // A file that is no JSON at all would only repeat itself.
            return Err(Broken);
        }
        self.values += 1;
        if self.values > VALUES {
            let message = format!("the file has more than {VALUES} values");
            self.error(&code::TOO_LARGE, start, start + 1, message, "measured data belong into CSV files");
            return Err(Broken);
        }
        let value = match self.peek() {
            Some('{') => self.nested(Self::object)?,
            Some('[') => self.nested(Self::array)?,
            Some('"') => self.string()?.map_or(Value::Invalid, Value::String),
            Some('\'') => {
                self.single_quoted();
                Value::Invalid
            }
            Some(c) if c.is_alphanumeric() || matches!(c, '+' | '-' | '.' | '_') => self.word(),
            Some(',' | '}' | ']') => {
                self.error(&code::SYNTAX, start, start + 1, "a value is missing here", "");
                Value::Invalid
            }
            Some(c) => {
                self.error(&code::SYNTAX, start, start + c.len_utf8(), format!("unexpected character {c:?}"), "");
                self.at = self.word_end();
                Value::Invalid
            }
            None => return self.broken_off("a value"),
        };
        Ok(Node { value, place: self.place(start, self.at) })
    }

    fn broken_off<T>(&mut self, expected: &str) -> Result<T, Broken> {
        let end = self.text.trim_end().len();
        self.error(
            &code::BROKEN_OFF,
            end,
            end,
            format!("the file ends where {expected} is expected"),
            "a bracket, brace or quote is not closed",
        );
        Err(Broken)
    }

    fn nested(&mut self, read: fn(&mut Self) -> Result<Value, Broken>) -> Result<Value, Broken> {
        if self.depth == DEPTH {
            self.error(
                &code::TOO_DEEP,
                self.at,
                self.at + 1,
                format!("nested deeper than {DEPTH} levels"),
                "no file of bmv needs more than about ten levels",
            );
            return Err(Broken);
        }
        self.depth += 1;
        let value = read(self);
        self.depth -= 1;
        value
    }

    /// Behind an item: a comma goes on (`true`), the closing bracket ends (`false`).
    fn next_item(&mut self, close: char) -> Result<bool, Broken> {
        self.skip();
        match self.peek() {
            Some(',') => {
                let comma = self.at;
                self.at += 1;
                self.skip();
                if self.peek() == Some(close) {
                    self.error(
                        &code::TRAILING_COMMA,
                        comma,
                        comma + 1,
                        format!("a comma before the closing `{close}`"),
                        "remove the comma",
                    );
                    self.at += 1;
                    return Ok(false);
                }
                Ok(true)
            }
            Some(c) if c == close => {
                self.at += 1;
                Ok(false)
            }
            Some(c @ ('}' | ']')) => {
                self.error(
                    &code::SYNTAX,
                    self.at,
                    self.at + 1,
                    format!("`{c}` closes what was opened by `{}`", if close == '}' { '{' } else { '[' }),
                    &format!("write `{close}`, or close the inner bracket first"),
                );
                Err(Broken)
            }
            Some(_) => {
                let end = self.word_end();
                self.error(
                    &code::SYNTAX,
                    self.at,
                    end,
                    format!("expected `,` or `{close}`"),
                    "separate entries with a comma",
                );
                if matches!(self.peek(), Some(':' | '=' | ';')) {
                    self.at += 1;
                    self.skip();
                }
                Ok(true)
            }
            None => self.broken_off(&format!("`,` or `{close}`")),
        }
    }

    fn array(&mut self) -> Result<Value, Broken> {
        self.at += 1;
        let mut items = Vec::new();
        self.skip();
        if self.peek() == Some(']') {
            self.at += 1;
            return Ok(Value::Array(items));
        }
        let array_path = self.path.clone();
        loop {
            self.path = array_path.index(items.len());
            let item = self.value();
            self.path.clone_from(&array_path);
            items.push(item?);
            if !self.next_item(']')? {
                return Ok(Value::Array(items));
            }
        }
    }

    fn object(&mut self) -> Result<Value, Broken> {
        self.at += 1;
        let mut entries: Vec<Entry> = Vec::new();
        let mut seen: HashMap<String, usize> = HashMap::new();
        self.skip();
        if self.peek() == Some('}') {
            self.at += 1;
            return Ok(Value::Object(entries));
        }
        let object_path = self.path.clone();
        loop {
            let start = self.at;
            let key = self.key()?;
            let end = self.at;
            self.path = object_path.key(key.as_deref().unwrap_or("?"));
            let key_place = self.place(start, end);
            let node = self.field();
            self.path.clone_from(&object_path);
            let node = node?;
            if let Some(key) = key {
                if let Some(&first) = seen.get(&key) {
                    let first: &Entry = &entries[first];
                    let line = first.key_place.position().line;
                    let diagnostic = Diagnostic::error(
                        &code::DUPLICATE_KEY,
                        &key_place,
                        format!("the key {key:?} stands twice in this object"),
                    )
                    .related(&first.key_place, "first here")
                    .help(format!("rename or remove one of them (the other is on line {line})"));
                    self.diagnostics.push(diagnostic);
                } else {
                    seen.insert(key.clone(), entries.len());
                    entries.push(Entry { key, key_place, node });
                }
            }
            if !self.next_item('}')? {
                return Ok(Value::Object(entries));
            }
        }
    }

    /// A key; `None` where it is no string and an error has been reported.
    fn key(&mut self) -> Result<Option<String>, Broken> {
        match self.peek() {
            Some('"') => self.string(),
            Some('\'') => {
                self.single_quoted();
                Ok(None)
            }
            Some(c) if c.is_alphanumeric() || matches!(c, '_' | '-' | '+' | '.') => {
                let end = self.word_end();
                let word = &self.text[self.at..end];
                self.error(&code::SYNTAX, self.at, end, "a key must be a string", &format!("write \"{word}\""));
                let word = word.to_owned();
                self.at = end;
                Ok(Some(word))
            }
            Some(c) => {
                self.error(
                    &code::SYNTAX,
                    self.at,
                    self.at + c.len_utf8(),
                    format!("expected a key, found {c:?}"),
                    "a field is \"name\": value",
                );
                Err(Broken)
            }
            None => self.broken_off("a key"),
        }
    }

    /// The colon and the value behind a key.
    fn field(&mut self) -> Result<Node, Broken> {
        self.skip();
        match self.peek() {
            Some(':') => self.at += 1,
            Some('=') => {
                self.error(
                    &code::SYNTAX,
                    self.at,
                    self.at + 1,
                    "expected `:` behind the key, found `=`",
                    "write \"name\": value",
                );
                self.at += 1;
            }
            Some(',' | '}') => {
                self.error(
                    &code::SYNTAX,
                    self.at,
                    self.at + 1,
                    "a value is missing behind the key",
                    "write \"name\": value",
                );
                return Ok(Node { value: Value::Invalid, place: self.place(self.at, self.at) });
            }
            Some(_) => {
                let end = self.word_end();
                self.error(&code::SYNTAX, self.at, end, "expected `:` behind the key", "write \"name\": value");
            }
            None => return self.broken_off("`:`"),
        }
        self.skip();
        let node = self.value()?;
        Ok(self.without_decimal_comma(node))
    }

    /// A field's value; a number behind which a comma and digits follow at once, `0,6`, was meant as one number: behind a
    /// field's value a key would follow, which is a string.
    fn without_decimal_comma(&mut self, node: Node) -> Node {
        let rest = &self.text[self.at..];
        let fraction = rest.strip_prefix(',').map_or("", |rest| {
            let end = rest.find(|c: char| !(c.is_ascii_digit() || matches!(c, 'e' | 'E' | '+' | '-')));
            &rest[..end.unwrap_or(rest.len())]
        });
        let begins = fraction.starts_with(|c: char| c.is_ascii_digit());
        if !begins || !matches!(node.value, Value::Number(Number::Unsigned(_) | Number::Signed(_))) {
            return node;
        }
        let (start, end) = (node.place.span.start, self.at + 1 + fraction.len());
        let meant = format!("{}.{fraction}", node.place.text());
        let message = format!("`{}` is no JSON number: it has a decimal comma", &self.text[start..end]);
        self.error(&code::INVALID_NUMBER, start, end, message, &format!("write {meant}"));
        self.at = end;
        Node { value: Value::Invalid, place: self.place(start, end) }
    }

    fn single_quoted(&mut self) {
        let start = self.at;
        let rest = &self.text[start + 1..];
        let line = rest.find('\n').unwrap_or(rest.len());
        let end = rest[..line].find('\'').map_or_else(|| self.word_end().max(start + 1), |i| start + i + 2);
        self.error(&code::SYNTAX, start, end, "a string stands in double quotes", "replace ' by \"");
        self.at = end;
    }

    /// A string; `None` where it holds an invalid escape or character, which has been reported.
    fn string(&mut self) -> Result<Option<String>, Broken> {
        let start = self.at;
        self.at += 1;
        let mut out = String::new();
        let mut valid = true;
        loop {
            let at = self.at;
            match self.peek() {
                None => {
                    self.error(
                        &code::BROKEN_OFF,
                        start,
                        self.text.len(),
                        "the string is not closed",
                        "close it with \"",
                    );
                    return Err(Broken);
                }
                Some('"') => {
                    self.at += 1;
                    return Ok(valid.then_some(out));
                }
                Some('\n') => {
                    self.error(
                        &code::CONTROL_CHARACTER,
                        start,
                        at,
                        "the string is not closed on its line",
                        "close it with \", or write \\n for a line break",
                    );
                    return Ok(None);
                }
                Some('\\') => {
                    let (used, decoded) = self.escape();
                    match decoded {
                        Some(c) => out.push(c),
                        None => {
                            let used = used.min(self.text.len() - at);
                            let shown = &self.text[at..at + used];
                            let message = if used == 6 {
                                format!("`{shown}` is half of a character")
                            } else {
                                format!("`{shown}` is no escape of JSON")
                            };
                            self.error(&code::INVALID_ESCAPE, at, at + used, message, "valid are \\\" \\\\ \\/ \\b \\f \\n \\r \\t and \\u with four hexadecimal digits; a backslash itself is \\\\");
                            valid = false;
                        }
                    }
                    self.at += used;
                }
                Some(c) if c < ' ' => {
                    self.error(
                        &code::CONTROL_CHARACTER,
                        at,
                        at + 1,
                        format!("the control character U+{:04X} stands unescaped in a string", u32::from(c)),
                        &format!("write \\u{:04x}, or remove it", u32::from(c)),
                    );
                    valid = false;
                    self.at += 1;
                }
                Some(c) => {
                    out.push(c);
                    self.at += c.len_utf8();
                }
            }
        }
    }

    /// Bytes of the escape at the cursor, and its character.
    fn escape(&self) -> (usize, Option<char>) {
        let raw = &self.text[self.at..];
        let Some(c) = raw[1..].chars().next() else { return (1, None) };
        let decoded = match c {
            '"' | '\\' | '/' => Some(c),
            'b' => Some('\u{8}'),
            'f' => Some('\u{c}'),
            'n' => Some('\n'),
            'r' => Some('\r'),
            't' => Some('\t'),
            'u' => return unicode_escape(raw),
            _ => None,
        };
        (1 + c.len_utf8(), decoded)
    }

    /// A literal word or a number.
    fn word(&mut self) -> Value {
        let start = self.at;
        let end = self.word_end();
        let word = &self.text[start..end];
        self.at = end;
        match word {
            "null" => return Value::Null,
            "true" => return Value::Bool(true),
            "false" => return Value::Bool(false),
            _ => {}
        }
        let bare = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
        if ["nan", "inf", "infinity"].contains(&bare.as_str()) {
            self.error(
                &code::NOT_A_NUMBER,
                start,
                end,
                format!("JSON has no `{word}`"),
                "write a finite number, or leave the field out",
            );
            return Value::Invalid;
        }
        if bare.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return self.number(start, word);
        }
        let help = match suggest::nearest(word, ["true", "false", "null"]) {
            Some(near) => format!("write {near}, or \"{word}\" for a string"),
            None => format!("a string stands in double quotes: \"{word}\""),
        };
        self.error(&code::SYNTAX, start, end, format!("`{word}` is no JSON value"), &help);
        Value::Invalid
    }

    fn number(&mut self, start: usize, word: &str) -> Value {
        let end = start + word.len();
        if let Some(fault) = number_fault(word) {
            self.error(
                &code::INVALID_NUMBER,
                start,
                end,
                format!("`{word}` is no JSON number: {fault}"),
                "numbers look like 12, -0.5 or 1.2e-3",
            );
            return Value::Invalid;
        }
        if !word.contains(['.', 'e', 'E']) {
            if let Ok(u) = word.parse::<u64>() {
                return Value::Number(Number::Unsigned(u));
            }
            if let Ok(i) = word.parse::<i64>() {
                // `-0` is the integer 0.
                return Value::Number(if i == 0 { Number::Unsigned(0) } else { Number::Signed(i) });
            }
        }
        let value: f64 = word.parse().unwrap_or(f64::NAN);
        let mantissa = word.split(['e', 'E']).next().unwrap_or(word);
        if !value.is_finite() {
            self.error(
                &code::NUMBER_RANGE,
                start,
                end,
                format!("the number `{word}` is too large"),
                "the largest is about 1.8e308",
            );
            return Value::Invalid;
        }
        if value == 0.0 && mantissa.contains(|c: char| ('1'..='9').contains(&c)) {
            self.error(
                &code::NUMBER_RANGE,
                start,
                end,
                format!("the number `{word}` is too small to be told from 0"),
                "the smallest is about 4.9e-324; write 0 if zero is meant",
            );
            return Value::Invalid;
        }
        Value::Number(Number::Float(value))
    }
}
