//! Wrong input: the message, at its place.

mod pass_data;
mod pass_entries;
mod pass_load;
mod pass_study;
