mod graph;
mod infer;
mod parse;
mod program;
mod schedule;
mod unit;
