//! Same bytes for any number of threads, after kills, on any machine.

mod cache;
mod engine;
mod process;
mod toy;
