//! Tests of one source file each, at its path below `src`, `core/src` or `diagnosis/src`.

mod batch;
mod cli;
mod diagnosis;
mod document;
mod effect;
mod expression;
mod import;
mod inference;
mod job;
mod math;
mod measurement;
mod random;
mod report;
mod runner;
mod statistics;
mod study;
mod thermal;
mod twin;
mod watch;
