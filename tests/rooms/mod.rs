//! Tests of one source file each, at its path below `src`.

mod batch;
mod cli;
mod import;
mod job;
mod report;
mod runner;
mod study;
