//! The command line, as a user sees it.

mod documents;
mod frame;
mod studies;
