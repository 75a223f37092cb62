//! The command line, as a user sees it.

mod campaigns;
mod documents;
mod frame;
mod hand_on;
mod history;
mod story;
mod studies;
mod verbs;
