//! The command line, as a user sees it.

mod campaigns;
mod frame;
