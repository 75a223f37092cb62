//! Models of other tools as studies: a deck becomes `model.json`, tables of couplings, a record of results and a pass
//! that holds the model against them.
//!
//! `reader`: which reader takes which files. `parts`: parts of a deck, and the
//! parameters and inputs that they give. `name`: names of a deck as the study format allows them. `model`, `record`: the
//! parts of the study. `study`: all of it, in memory. `closure`: whether the record's temperatures balance in the
//! network, which is the proof of an import.

mod check;
pub mod closure;
mod coupling;
pub mod logger;
mod model;
pub mod name;
pub mod parts;
pub mod reader;
mod record;
pub mod resolution;
pub mod study;
pub mod summary;

pub use closure::{Closure, NodeClosure};
pub use reader::{DeckFile, ReadError};
pub use study::{ImportError, ImportedStudy, import};
pub use summary::Summary;

/// The file of the pass that an import writes.
pub const PASS: &str = "pass-1.json";
/// The measurement that holds what the other tool computed.
pub const DECK_RESULT: &str = "deck result";
