//! `bmv`: reproducible Bayesian-based model validation of spacecraft thermal models.
//!
//! The rooms of the house, each of which may use only those before it:
//! `watch`, `math`, `random` and `expression`, `statistics`, `document`, `thermal`, `effect`, `inference` and `surrogate`,
//! `diagnosis`, `job`, `study`, `runner`, `report`, `cli` (DESIGN.md says what each knows and may not know).

pub mod cli;
pub mod diagnosis;
pub mod document;
pub mod effect;
pub mod expression;
pub mod inference;
pub mod job;
pub mod math;
pub mod random;
pub mod report;
pub mod runner;
pub mod statistics;
pub mod study;
pub mod surrogate;
pub mod thermal;
pub mod watch;
