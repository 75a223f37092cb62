//! Objects declared once: the declaration gives the type, the reader with all errors, and the JSON Schema.
//!
//! `written_struct!` declares an object with required, optional and defaulted fields; `written_choice!` an object
//! with exactly one key, the kind; `written_words!` one of some words. Doc comments become the schema's
//! descriptions.

use super::code;
use super::diagnostic::{Diagnostic, Diagnostics};
use super::json::{Entry, Node, Value};
use super::other_tools;
use super::source::{Place, Span};
use super::suggest;
use super::written::{Written, wrong_type};

/// What the description of a job's settings begins with.
const SETTINGS: &str = "settings of ";

/// The fields of an object that is being read. Used by `written_struct!`.
pub struct Fields<'a> {
    place: &'a Place,
    entries: &'a [Entry],
}

impl<'a> Fields<'a> {
    /// The object's fields; unknown ones are reported.
    pub fn open(node: &'a Node, field_names: &[&str], what: &str, diagnostics: &mut Diagnostics) -> Option<Self> {
        let Value::Object(entries) = &node.value else { return wrong_type(node, what, diagnostics) };
        for entry in entries {
            if !field_names.contains(&entry.key.as_str()) {
                // A word for the same thing says more than one that is spelt alike.
                let same = other_tools::same_field(&entry.key, field_names);
                let near = same.or_else(|| diagnostics.nearest(&entry.key, field_names.iter().copied()));
                let who = || other_tools::who_has(&entry.key).filter(|_| what.starts_with(SETTINGS));
                let text = if let Value::String(text) = &entry.node.value { Some(text.as_str()) } else { None };
                let help = match (other_tools::advice(&entry.key, text), near) {
                    (Some(advice), _) => advice,
                    (None, Some(near)) => format!("did you mean `{near}`?"),
                    (None, None) if field_names.is_empty() => "the object has no fields: write {}".to_owned(),
                    (None, None) => {
                        let fields = format!("the fields are {}", suggest::listed(field_names.iter().copied(), 20));
                        who().map_or_else(|| fields.clone(), |who| format!("{who}; here {fields}"))
                    }
                };
                diagnostics.push(
                    Diagnostic::error(&code::UNKNOWN_FIELD, &entry.key_place, format!("unknown field `{}`", entry.key))
                        .help(help),
                );
            }
        }
        Some(Self { place: &node.place, entries })
    }

    fn find(&self, key: &str) -> Option<&'a Node> {
        self.entries.iter().find(|e| e.key == key).map(|e| &e.node)
    }

    /// A field that must be there.
    pub fn required<T: Written>(&self, key: &str, diagnostics: &mut Diagnostics) -> Option<T> {
        match self.find(key) {
            Some(node) => T::read(node, diagnostics),
            None => {
                // The opening brace stands for the object.
                let place =
                    Place { span: Span::new(self.place.span.start, self.place.span.start + 1), ..self.place.clone() };
                diagnostics.push(
                    Diagnostic::error(&code::MISSING_FIELD, &place, format!("missing field `{key}`"))
                        .expected(format!("`{key}`: {}", T::expected())),
                );
                None
            }
        }
    }

    /// A field that may be missing or null.
    pub fn optional<T: Written>(&self, key: &str, diagnostics: &mut Diagnostics) -> Option<Option<T>> {
        match self.find(key) {
            None | Some(Node { value: Value::Null, .. }) => Some(None),
            Some(node) => T::read(node, diagnostics).map(Some),
        }
    }
}

/// The one entry of a choice. Used by `written_choice!`.
pub fn one_kind<'a>(node: &'a Node, kinds: &[&str], what: &str, diagnostics: &mut Diagnostics) -> Option<&'a Entry> {
    let expected = || format!("an object with one key of {}", suggest::listed(kinds.iter().copied(), 20));
    if let Value::String(kind) = &node.value
        && kinds.contains(&kind.as_str())
    {
        let message = format!("{what} is an object, and this is a string");
        let diagnostic = Diagnostic::error(&code::ONE_KIND, &node.place, message).expected(expected());
        diagnostics.push(diagnostic.help(format!("the kind is a key: {{\"{kind}\": ...}}")));
        return None;
    }
    let Value::Object(entries) = &node.value else { return wrong_type(node, &expected(), diagnostics) };
    match entries.as_slice() {
        [one] if kinds.contains(&one.key.as_str()) => Some(one),
        [one] => {
            let near = diagnostics.nearest(&one.key, kinds.iter().copied());
            let diagnostic =
                Diagnostic::error(&code::UNKNOWN_KIND, &one.key_place, format!("unknown kind `{}` of {what}", one.key))
                    .expected(format!("one of {}", suggest::listed(kinds.iter().copied(), 20)))
                    .suggest(near);
            diagnostics.push(diagnostic);
            None
        }
        several => {
            let message = match several.len() {
                0 => format!("{what} needs exactly one kind, and this object is empty"),
                n => format!("{what} needs exactly one kind, and this object has {n} keys"),
            };
            let mut diagnostic = Diagnostic::error(&code::ONE_KIND, &node.place, message).expected(expected());
            let named = several.iter().find(|e| matches!(e.key.as_str(), "kind" | "type"));
            if let Some(Value::String(kind)) = named.map(|e| &e.node.value) {
                diagnostic = diagnostic.help(format!("the kind is the key: {{\"{kind}\": ...}}"));
            }
            let (own, others): (Vec<&Entry>, Vec<&Entry>) =
                several.iter().partition(|entry| kinds.contains(&entry.key.as_str()));
            if let ([kind], [_, ..]) = (own.as_slice(), others.as_slice()) {
                let names = suggest::listed(others.iter().map(|entry| entry.key.as_str()), 20);
                diagnostic = diagnostic.help(match kind.node.value {
                    Value::Object(_) => {
                        format!("move {names} into `{}`, or leave out what does not belong there", kind.key)
                    }
                    _ => format!("leave out {names}"),
                });
            }
            diagnostics.push(diagnostic);
            None
        }
    }
}

/// One of some words. Used by `written_words!`.
pub fn word<'a>(node: &'a Node, words: &[&str], what: &str, diagnostics: &mut Diagnostics) -> Option<&'a str> {
    let expected = format!("one of {}", suggest::listed(words.iter().copied(), 20));
    let Value::String(text) = &node.value else { return wrong_type(node, &expected, diagnostics) };
    if words.contains(&text.as_str()) {
        return Some(text);
    }
    let near = diagnostics.nearest(text, words.iter().copied());
    let what = what.strip_prefix("a ").or_else(|| what.strip_prefix("an ")).unwrap_or(what);
    diagnostics.push(
        Diagnostic::error(&code::UNKNOWN_KIND, &node.place, format!("unknown {what} `{text}`"))
            .expected(expected)
            .suggest(near),
    );
    None
}

/// Declares an object with fields, its reader and its schema.
///
/// ```text
/// written_struct! {
///     /// Describes the object in the schema.
///     pub struct NodeEntry: "a node" {
///         /// Describes the field.
///         required capacity: Scalar,
///         /// Missing or null is `None`.
///         optional area: Amount,
///         /// Missing takes the default.
///         default(true) settable: bool,
///         /// A key that is no field name of Rust.
///         optional place as "where": String,
///     }
/// }
/// ```
#[macro_export]
macro_rules! written_struct {
    (
        $(#[doc = $doc:literal])*
        $visibility:vis struct $name:ident : $what:literal {
            $(
                $(#[doc = $field_doc:literal])*
                $kind:ident $(($default:expr))? $field:ident $(as $key:literal)? : $type:ty
            ),* $(,)?
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq)]
        $visibility struct $name {
            $( $(#[doc = $field_doc])* pub $field: $crate::document::declare::written_struct!(@type $kind $type) ),*
        }

        impl $crate::document::written::Written for $name {
            #[allow(unused_variables, reason = "an object may have no fields")]
            fn read(
                node: &$crate::document::Node,
                diagnostics: &mut $crate::document::Diagnostics,
            ) -> Option<Self> {
                let field_names: &[&str] = &[$( $crate::document::declare::written_struct!(@key $field $($key)?) ),*];
                let fields = $crate::document::declare::Fields::open(node, field_names, $what, diagnostics)?;
                $(
                    let key = $crate::document::declare::written_struct!(@key $field $($key)?);
                    let $field = $crate::document::declare::written_struct!(
                        @read $kind $(($default))? fields key $type, diagnostics
                    );
                )*
                Some(Self { $( $field: $field? ),* })
            }

            #[allow(unused_variables, reason = "an object may have no fields")]
            fn schema(schemas: &mut $crate::document::schema::Schemas) -> serde_json::Value {
                schemas.define(stringify!($name), |schemas| {
                    $crate::document::schema::object(
                        concat!($($doc, "\n"),*),
                        vec![$(
                            $crate::document::schema::Field {
                                key: $crate::document::declare::written_struct!(@key $field $($key)?),
                                description: concat!($($field_doc, "\n"),*),
                                schema: <$type as $crate::document::written::Written>::schema(schemas),
                                required: $crate::document::declare::written_struct!(@required $kind),
                            }
                        ),*],
                    )
                })
            }

            fn expected() -> String {
                $what.to_owned()
            }
        }
    };
    (@type required $type:ty) => { $type };
    (@type optional $type:ty) => { Option<$type> };
    (@type default $type:ty) => { $type };
    (@key $field:ident) => { stringify!($field) };
    (@key $field:ident $key:literal) => { $key };
    (@required required) => { true };
    (@required optional) => { false };
    (@required default) => { false };
    (@read required $fields:ident $key:ident $type:ty, $diagnostics:ident) => {
        $fields.required::<$type>($key, $diagnostics)
    };
    (@read optional $fields:ident $key:ident $type:ty, $diagnostics:ident) => {
        $fields.optional::<$type>($key, $diagnostics)
    };
    (@read default ($default:expr) $fields:ident $key:ident $type:ty, $diagnostics:ident) => {
        $fields.optional::<$type>($key, $diagnostics).map(|value| value.unwrap_or_else(|| $default))
    };
}
pub use written_struct;

/// Declares a choice: an object with exactly one key, the kind, its reader and its schema.
///
/// ```text
/// written_choice! {
///     /// Describes the choice in the schema.
///     pub enum Prior: "a prior" {
///         /// Describes the kind.
///         "uniform" => Uniform([f64; 2]),
///     }
/// }
/// ```
#[macro_export]
macro_rules! written_choice {
    (
        $(#[doc = $doc:literal])*
        $visibility:vis enum $name:ident : $what:literal {
            $( $(#[doc = $kind_doc:literal])* $key:literal => $variant:ident($type:ty) ),* $(,)?
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq)]
        $visibility enum $name { $( $(#[doc = $kind_doc])* $variant($type) ),* }

        impl $name {
            /// The key of the kind.
            pub fn kind(&self) -> &'static str {
                match self { $( Self::$variant(_) => $key ),* }
            }
        }

        impl $crate::document::written::Written for $name {
            fn read(
                node: &$crate::document::Node,
                diagnostics: &mut $crate::document::Diagnostics,
            ) -> Option<Self> {
                let entry = $crate::document::declare::one_kind(node, &[$($key),*], $what, diagnostics)?;
                match entry.key.as_str() {
                    $( $key => <$type as $crate::document::written::Written>::read(&entry.node, diagnostics)
                        .map(Self::$variant), )*
                    _ => None,
                }
            }

            fn schema(schemas: &mut $crate::document::schema::Schemas) -> serde_json::Value {
                schemas.define(stringify!($name), |schemas| {
                    $crate::document::schema::choice(
                        concat!($($doc, "\n"),*),
                        vec![$( ($key, concat!($($kind_doc, "\n"),*), <$type as $crate::document::written::Written>::schema(schemas)) ),*],
                    )
                })
            }

            fn expected() -> String {
                let kinds: &[&str] = &[$($key),*];
                format!("{}: an object with one key of {}", $what, $crate::document::suggest::listed(kinds.iter().copied(), 20))
            }
        }
    };
}
pub use written_choice;

/// Declares one of some words, its reader and its schema.
#[macro_export]
macro_rules! written_words {
    (
        $(#[doc = $doc:literal])*
        $visibility:vis enum $name:ident : $what:literal {
            $( $(#[doc = $word_doc:literal])* $word:literal => $variant:ident ),* $(,)?
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $visibility enum $name { $( $(#[doc = $word_doc])* $variant ),* }

        impl $name {
            /// The word.
            pub fn word(self) -> &'static str {
                match self { $( Self::$variant => $word ),* }
            }
        }

        impl $crate::document::written::Written for $name {
            fn read(
                node: &$crate::document::Node,
                diagnostics: &mut $crate::document::Diagnostics,
            ) -> Option<Self> {
                match $crate::document::declare::word(node, &[$($word),*], $what, diagnostics)? {
                    $( $word => Some(Self::$variant), )*
                    _ => None,
                }
            }

            fn schema(schemas: &mut $crate::document::schema::Schemas) -> serde_json::Value {
                schemas.define(stringify!($name), |_| {
                    $crate::document::schema::words(
                        concat!($($doc, "\n"),*),
                        &[$( ($word, concat!($($word_doc, "\n"),*)) ),*],
                    )
                })
            }

            fn expected() -> String {
                let words: &[&str] = &[$($word),*];
                format!("{}: one of {}", $what, $crate::document::suggest::listed(words.iter().copied(), 20))
            }
        }
    };
}
pub use written_words;

written_struct! {
    /// An object without fields: `{}`.
    pub struct Empty: "an empty object, {}" {}
}
