//! The command line, as a user sees it.

mod archive;
mod campaigns;
mod check;
mod cluster;
mod decks;
mod documents;
mod escapes;
mod export;
mod external;
mod frame;
mod hand_on;
mod history;
mod import;
mod index;
mod laws;
mod many_readings;
mod not_finite;
mod reference_temperature;
mod serve_model;
mod story;
mod studies;
mod test_plan_verb;
mod tutorial;
mod unsettled;
mod verbs;
mod watch;
