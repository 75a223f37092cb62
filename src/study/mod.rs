//! Model and pass as written, inheritance, resolution to SI and names, measurements, pinned data.
//!
//! [`load`] is the way in: it reads a pass with its parents, its model and its data, and gives a [`Pass`] in which
//! nothing is left to look up, or all that is wrong with the files.

pub mod blocked;
pub mod changed;
pub mod discover;
pub mod document;
pub mod external;
pub mod figure;
pub mod file;
pub mod folder;
pub mod history;
pub mod inherit;
pub mod job;
pub mod ledger;
pub mod model;
pub mod origin;
pub mod pass;
pub mod pinned;
pub mod posterior_prior;
pub mod problem;
pub mod profile;
pub mod project;
pub mod reader;
pub mod requirement;
pub mod resolve;
pub mod resolved;
pub mod rule;
pub mod schema;
pub mod table;
pub mod variable;
pub mod window;

pub use changed::{ChangedEntry, changed};
pub use discover::{Found, discover};
pub use document::StudyDocument;
pub use folder::Folder;
pub use job::{JobSpec, NamedJob};
pub use ledger::Content;
pub use problem::problem;
pub use project::Project;
pub use reader::{Reader, load};
pub use resolve::{command, effects};
pub use resolved::{AdoptedEffect, Closing, Evidence, ParameterChange, Pass};
pub use schema::schema;
