//! `bmv`: reproducible Bayesian-based model validation of spacecraft thermal models.
//!
//! The rooms of the house, each of which may use only those before it:
//! `watch`, `math`, `random` and `expression`, `statistics`, `document`, `thermal`, `effect`, `measurement`, `inference` (the crate
//! `bmv-core`), `diagnosis`, `twin` (the crate `bmv-diagnosis`), `study`, `job`, `runner`, `report`, `batch`, `import`, `cli` (DESIGN.md says what each knows and may not know).

pub use bmv_core::{document, effect, expression, inference, math, measurement, random, statistics, thermal, watch};
pub use bmv_diagnosis::{diagnosis, twin};

pub mod batch;
pub mod cli;
pub mod import;
pub mod job;
pub mod report;
pub mod runner;
pub mod study;
