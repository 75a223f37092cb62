//! Measurements as loggers write them: any separator, decimal comma or point, lines before the header, a row of units,
//! times in ISO 8601, as an epoch or as seconds, several files, channels that are dead or that nothing needs.
//!
//! `dialect`: how a file is written. `instant`: times. `channels`: what the user says of the channels. `record`: the
//! files as one record. `dead`: channels that died in its course. `absolute_error`: the tolerance of a thermometer's type. `between_rows`: how an input goes between two rows. `proposal`: that record as a measurement of a
//! study; `map_template`: what the user may say of the channels. Text in, text out: no file is touched.

pub mod absolute_error;
pub mod between_rows;
mod channels;
pub mod dead;
pub mod dialect;
pub mod instant;
mod map_template;
pub mod proposal;
mod record;

pub use map_template::{MapTemplate, map_template};
pub use proposal::{Known, Proposal, Said, propose};
pub use record::{Channel, Record};

use std::sync::Arc;

use crate::document::{Diagnostics, Source};

/// How the files are to be read, where they do not say it themselves.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// Header of the column of times.
    pub time: Option<String>,
    /// Names, units and places of channels: a CSV file's name and text.
    pub channels: Option<(String, String)>,
}

/// Several logs as one record.
///
/// # Errors
/// Every place of a file that is not understood, with file, line and column.
pub fn read(files: &[(String, String)], settings: &Settings) -> Result<Record, Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let mut record = Record::default();
    let map = settings
        .channels
        .as_ref()
        .map(|(name, text)| channels::read(&Source::new(name.clone(), text.clone()), &mut diagnostics));
    for (name, text) in files {
        let source: Arc<Source> = Source::new(name.clone(), text.clone());
        record.add(&source, settings.time.as_deref(), &mut diagnostics);
    }
    // Of a file that was not understood the channels are not known: the map would be wrong in every line.
    if let Some(map) = map.filter(|_| !diagnostics.has_errors()) {
        channels::apply(&map, &mut record, &mut diagnostics);
    }
    record.finish();
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok(record) }
}
