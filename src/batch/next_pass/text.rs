//! JSON as people write it: sections and their entries on lines of their own, short objects on one line, two blanks a
//! level. Numbers that come from a file keep their digits.

use crate::document::canonical;
use crate::document::json::{Node, Value};

/// Longest line on which an object or array stands whole, in characters.
const WIDTH: usize = 120;

/// Objects and arrays of at least so many plain values have several on a line.
const FILLED: usize = 20;

/// Levels whose objects are always broken: the document and its sections.
const BROKEN: usize = 2;

/// A value to be written.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A number, string, truth value or null, as JSON has it.
    Raw(String),
    /// An array.
    List(Vec<Item>),
    /// An object, in this order.
    Object(Vec<(String, Item)>),
}

impl Item {
    /// A string.
    pub fn text(text: &str) -> Self {
        Self::Raw(canonical::quoted(text))
    }

    /// A number; null where it is none.
    pub fn number(value: f64) -> Self {
        Self::Raw(canonical::float(value).unwrap_or_else(|_| "null".to_owned()))
    }

    /// An object of one entry.
    pub fn one(key: &str, item: Self) -> Self {
        Self::Object(vec![(key.to_owned(), item)])
    }

    /// A value of a file, numbers as they stand there.
    pub fn of_node(node: &Node) -> Self {
        match &node.value {
            Value::String(text) => Self::text(text),
            Value::Array(items) => Self::List(items.iter().map(Self::of_node).collect()),
            Value::Object(entries) => {
                Self::Object(entries.iter().map(|entry| (entry.key.clone(), Self::of_node(&entry.node))).collect())
            }
            Value::Number(_) => Self::Raw(node.place.text().to_owned()),
            Value::Null | Value::Invalid => Self::Raw("null".to_owned()),
            Value::Bool(value) => Self::Raw(value.to_string()),
        }
    }

    /// The whole text, with a line's end.
    pub fn document(&self) -> String {
        let mut text = String::new();
        self.put(0, 0, &mut text);
        text.push('\n');
        text
    }

    /// On one line.
    fn line(&self) -> String {
        match self {
            Self::Raw(text) => text.clone(),
            Self::List(items) => format!("[{}]", items.iter().map(Self::line).collect::<Vec<_>>().join(", ")),
            Self::Object(entries) => {
                let each = |(key, item): &(String, Self)| format!("{}: {}", canonical::quoted(key), item.line());
                format!("{{{}}}", entries.iter().map(each).collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// Whether it holds nothing but plain values.
    fn is_plain(&self) -> bool {
        let is_raw = |item: &Self| matches!(item, Self::Raw(_));
        match self {
            Self::Raw(_) => true,
            Self::List(items) => items.iter().all(is_raw),
            Self::Object(entries) => entries.iter().all(|(_, item)| is_raw(item)),
        }
    }

    /// Appends its entries, as many on a line as fit.
    fn fill(&self, indent: &str, text: &mut String) {
        let entries: Vec<String> = match self {
            Self::Raw(_) => Vec::new(),
            Self::List(items) => items.iter().map(Self::line).collect(),
            Self::Object(entries) => {
                entries.iter().map(|(key, item)| format!("{}: {}", canonical::quoted(key), item.line())).collect()
            }
        };
        let mut column = WIDTH;
        for (position, entry) in entries.iter().enumerate() {
            let width = entry.chars().count() + 2;
            if position > 0 {
                text.push(',');
            }
            if column + width > WIDTH {
                text.push('\n');
                text.push_str(indent);
                column = indent.len();
            } else {
                text.push(' ');
            }
            text.push_str(entry);
            column += width;
        }
    }

    /// Appends it where `column` characters stand on the line already.
    fn put(&self, level: usize, column: usize, text: &mut String) {
        let line = self.line();
        let (open, close, count) = match self {
            Self::Raw(_) => ("", "", 0),
            Self::List(items) => ("[", "]", items.len()),
            Self::Object(entries) => ("{", "}", entries.len()),
        };
        let is_section = level < BROKEN && matches!(self, Self::Object(_));
        // A comma may follow.
        let fits = column + line.chars().count() < WIDTH;
        if count == 0 || (fits && !is_section) {
            text.push_str(&line);
            return;
        }
        if let (Self::Object(entries), false) = (self, is_section)
            && let [(key, item)] = entries.as_slice()
        {
            // A choice of a kind stays on the line of what it is the kind of.
            let key = format!("{{{}: ", canonical::quoted(key));
            text.push_str(&key);
            item.put(level, column + key.chars().count(), text);
            text.push('}');
            return;
        }
        let indent = "  ".repeat(level + 1);
        text.push_str(open);
        if count >= FILLED && !is_section && self.is_plain() {
            self.fill(&indent, text);
            text.push('\n');
            text.push_str(&"  ".repeat(level));
            text.push_str(close);
            return;
        }
        for position in 0..count {
            text.push_str(if position == 0 { "\n" } else { ",\n" });
            text.push_str(&indent);
            match self {
                Self::Object(entries) => {
                    let (key, item) = &entries[position];
                    let key = format!("{}: ", canonical::quoted(key));
                    text.push_str(&key);
                    item.put(level + 1, indent.len() + key.chars().count(), text);
                }
                Self::List(items) => items[position].put(level + 1, indent.len(), text),
                Self::Raw(_) => {}
            }
        }
        text.push('\n');
        text.push_str(&"  ".repeat(level));
        text.push_str(close);
    }
}
