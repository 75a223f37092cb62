//! The physics and the statistics of `bmv`, and the documents that they are declared in.
//!
//! The rooms, each of which may use only those before it: `watch`, `math`, `random` and `expression`, `statistics`, `document`,
//! `thermal`, `effect`, `measurement`, `inference`. Above them are the crate `bmv-diagnosis` and the crate `bmv` (jobs, studies, the
//! runner, reports, the command line), which shows these rooms as its own.

pub mod document;
pub mod effect;
pub mod expression;
pub mod inference;
pub mod math;
pub mod measurement;
pub mod random;
pub mod statistics;
pub mod thermal;
pub mod watch;
