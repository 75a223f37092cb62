//! JSON with places: spans, quantities and units, checked maps, canonical form, hashes, diagnostics, dates and times.

pub mod calendar;
pub mod canonical;
pub mod code;
pub mod declare;
pub mod diagnostic;
pub mod evidence;
pub mod formula;
pub mod hash;
pub mod json;
pub mod map;
pub mod name;
pub mod number;
pub mod other_tools;
pub mod prior;
pub mod quantity;
pub mod result_words;
pub mod schema;
pub mod source;
pub mod suggest;
pub mod time;
pub mod visible;
pub mod words;
pub mod written;

pub use declare::Empty;
pub use declare::{written_choice, written_struct, written_words};
pub use diagnostic::{Diagnostic, Diagnostics, PlainDiagnostic, Severity};
pub use evidence::{EvidenceForm, source_text};
pub use formula::Formulas;
pub use json::{Node, Value};
pub use map::{Map, MapEntry};
pub use prior::{Prior, PriorForm};
pub use quantity::{Amount, Scalar, Sense, WrittenUnit};
pub use schema::Schemas;
pub use source::{JsonPath, Place, Position, Source, Span};
pub use words::{counted, grouped, p_stated, p_value, percent, upper};
pub use written::{NameOr, OneOrMany, Spanned, Written, read_file};
