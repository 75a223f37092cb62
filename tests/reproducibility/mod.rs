//! Same bytes for any number of threads, after kills, on any machine.

mod cache;
mod engine;
mod jobs;
mod process;
mod program;
mod samples;
mod stored;
mod toy;
