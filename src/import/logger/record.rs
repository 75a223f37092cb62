//! Logs merged into one record: a reading for each channel at each instant at which any of them was read.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::dialect::{Dialect, Reading, dialect, is_without_names, name_and_unit, other_separator, reading, unit_of};
use super::instant::{Instant, instant};
use crate::document::{Diagnostics, Source, code, counted};
use crate::expression::Unit;
use crate::study::table::{Problems, Table};

/// Headers of columns that hold the time, in small letters.
const TIMES: &[&str] = &[
    "time",
    "timestamp",
    "time stamp",
    "datetime",
    "date time",
    "date/time",
    "date-time",
    "zeit",
    "zeitstempel",
    "datum/zeit",
    "epoch",
    "utc",
    "t",
    "elapsed",
    "elapsed time",
    "unix",
];
/// Headers of a date that stands beside its time of day.
const DATES: &[&str] = &["date", "datum", "day"];
/// Headers of that time of day.
const CLOCKS: &[&str] = &["time", "zeit", "uhrzeit", "clock"];
/// Readings that are all the same, above which a temperature counts as stuck.
const STUCK: usize = 20;

/// A channel of the record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its name in the files, whatever a map calls it.
    pub label: String,
    /// Its unit as the study format writes it.
    pub unit: Option<String>,
    /// What it measures, where the user says so.
    pub measures: Option<String>,
    /// A reading an instant, in the unit.
    pub readings: Vec<Option<f64>>,
    /// Why it is no part of the clean record.
    pub left_out: Option<String>,
}

impl Channel {
    /// Whether it reads a temperature.
    pub fn is_temperature(&self) -> bool {
        matches!(self.unit.as_deref(), Some("degC" | "K" | "degF"))
    }

    /// Whether a temperature has the same value throughout, as a channel has to which nothing is connected.
    pub fn is_stuck(&self) -> bool {
        let mut known = self.readings.iter().flatten();
        let first = known.next();
        self.is_temperature()
            && self.readings.iter().flatten().count() > STUCK
            && self.readings.iter().flatten().all(|value| Some(value) == first)
    }
}

/// All files together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Instants, s from the first.
    pub times_s: Vec<f64>,
    /// The first, s since 1970-01-01, where the files have dates.
    pub start_s: Option<f64>,
    /// Channels in the order of the files.
    pub channels: Vec<Channel>,
    /// What was assumed or left out, a line each.
    pub notes: Vec<String>,
    rows: BTreeMap<i64, BTreeMap<usize, f64>>,
    is_dated: Option<bool>,
}

/// Which columns say when a row was read.
enum Times {
    One(usize),
    DateAndClock(usize, usize),
}

/// A file as it is being read.
struct Log<'t> {
    table: Table<'t>,
    dialect: Dialect,
    headers: Vec<(String, Option<String>, Range<usize>)>,
    rows: Vec<Vec<Range<usize>>>,
}

impl Record {
    /// Adds a file.
    pub(super) fn add(&mut self, source: &Arc<Source>, time: Option<&str>, diagnostics: &mut Diagnostics) {
        let mut problems = Problems::default();
        let text = source.text();
        let found = dialect(text);
        let Some(dialect) = found.filter(|dialect| !is_without_names(text, dialect)) else {
            let line = found.map_or(0, |dialect| dialect.header);
            let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
            let end = start + text[start..].lines().next().map_or(0, str::len);
            let message = match found {
                None => "no separator makes columns of these lines",
                Some(_) => "no line of names stands above these readings: it has other separators, or is not there",
            };
            let known =
                "a header with the channels' names, then a row an instant, cells separated by `;`, a tab, `|` or `,`";
            let help = match other_separator(text) {
                Some(other) if found.is_none_or(|found| char::from(found.separator) != other) => {
                    format!("{known}; `{other}` seems to separate these: put `;` in its place")
                }
                _ => known.to_owned(),
            };
            problems.add(&code::TABLE_SHAPE, start..end, message, Some(&help));
            problems.report(source, diagnostics);
            return;
        };
        // Lines before the header become blanks, so that every place stays where it is.
        let start: usize = text.split_inclusive('\n').take(dialect.header).map(str::len).sum();
        let before: String = text[..start]
            .bytes()
            .map(|byte| if matches!(byte, b'\n' | b'\r') { char::from(byte) } else { ' ' })
            .collect();
        let blanked = before + &text[start..];
        if let Some(log) = log(&blanked, dialect, &mut problems) {
            self.merge(&log, time, &mut problems);
        }
        problems.report(source, diagnostics);
    }

    fn merge(&mut self, log: &Log<'_>, time: Option<&str>, problems: &mut Problems) {
        let Some(times) = times(log, time, problems) else { return };
        let is_time = |column: usize| match times {
            Times::One(one) => column == one,
            Times::DateAndClock(date, clock) => column == date || column == clock,
        };
        let mut columns: Vec<(usize, usize)> = Vec::new();
        for (column, (name, unit, range)) in log.headers.iter().enumerate().filter(|(at, _)| !is_time(*at)) {
            if name.is_empty() {
                continue;
            }
            let count =
                |wanted: fn(Reading) -> bool| log.rows.iter().filter(|row| wanted(log.reading(&row[column]))).count();
            let (numbers, texts) = (count(|own| matches!(own, Reading::Number(_))), count(|own| own == Reading::Text));
            if texts > numbers {
                let note = format!("column `{name}` holds text: left out");
                if !self.notes.contains(&note) {
                    self.notes.push(note);
                }
                continue;
            }
            match self.channel(name, unit.as_deref()) {
                Ok(channel) if columns.iter().any(|(_, other)| *other == channel) => {
                    problems.add(
                        &code::TABLE_SHAPE,
                        range.clone(),
                        format!("two columns are named `{name}`"),
                        Some("a name of its own for each channel"),
                    );
                }
                Ok(channel) => columns.push((column, channel)),
                Err(other) => {
                    let message = format!("`{name}` is in {other} in another file");
                    problems.add(&code::TABLE_SHAPE, range.clone(), message, Some("one unit for a channel"));
                }
            }
        }
        for row in &log.rows {
            let Some(key) = self.key(log, &times, row, problems) else { continue };
            for &(column, channel) in &columns {
                let value = match log.reading(&row[column]) {
                    Reading::Number(value) => value,
                    Reading::Missing => continue,
                    Reading::Text => {
                        let message = format!("`{}` is no reading", log.table.text(&row[column]));
                        let help = "a number; or nothing, `NaN` or `---` where nothing was read";
                        problems.add(&code::TABLE_CELL, row[column].clone(), message, Some(help));
                        continue;
                    }
                };
                let known = self.rows.entry(key).or_default().insert(channel, value);
                if known.is_some_and(|known| known != value) {
                    let name = &self.channels[channel].name;
                    let message = format!("`{name}` has another reading at this instant");
                    problems.add(
                        &code::TABLE_CELL,
                        row[column].clone(),
                        message,
                        Some("one reading of a channel at an instant"),
                    );
                }
            }
        }
    }

    /// The channel of a name, made where it is new; the unit that it has elsewhere, where that is another.
    fn channel(&mut self, name: &str, unit: Option<&str>) -> Result<usize, String> {
        if let Some(at) = self.channels.iter().position(|channel| channel.name == name) {
            return match (&self.channels[at].unit, unit) {
                (Some(own), Some(other)) if own != other => Err(own.clone()),
                _ => Ok(at),
            };
        }
        let unit = unit.map(str::to_owned);
        self.channels.push(Channel { name: name.to_owned(), label: name.to_owned(), unit, ..Channel::default() });
        Ok(self.channels.len() - 1)
    }

    /// The instant of a row in milliseconds.
    fn key(&mut self, log: &Log<'_>, times: &Times, row: &[Range<usize>], problems: &mut Problems) -> Option<i64> {
        let (cell, text, unit) = match *times {
            Times::One(column) => (column, log.table.text(&row[column]).into_owned(), log.headers[column].1.as_deref()),
            Times::DateAndClock(date, clock) => {
                let text = format!("{} {}", log.table.text(&row[date]), log.table.text(&row[clock]));
                (date, text, None)
            }
        };
        let range = row[cell].clone();
        let (is_dated, seconds) = match instant(&text, log.dialect.has_comma) {
            Some(Instant::Dated(seconds)) => (true, seconds),
            Some(Instant::Counted(count)) => {
                let unit = unit.and_then(|unit| Unit::parse(unit).ok());
                (false, unit.map_or(count, |unit| unit.difference_to_si(count)))
            }
            None => {
                let message = format!("`{text}` is no time");
                let help = "2024-05-17T12:30:00, 17.05.2024 12:30:00, seconds since 1970, or seconds from the start";
                problems.add(&code::TABLE_CELL, range, message, Some(help));
                return None;
            }
        };
        if *self.is_dated.get_or_insert(is_dated) != is_dated {
            let message = "this file has other times than those before it: a date here, a count from the start there";
            problems.add(
                &code::TABLE_CELL,
                range,
                message,
                Some("dates in all files, or counts from one start in all"),
            );
            return None;
        }
        Some((1000.0 * seconds).round() as i64)
    }

    /// Lays the readings out by instant, and says which channels are of no use.
    pub(super) fn finish(&mut self) {
        let Some(first) = self.rows.keys().next().copied() else { return };
        self.start_s = self.is_dated.filter(|is_dated| *is_dated).map(|_| first as f64 / 1000.0);
        self.times_s = self.rows.keys().map(|key| (key - first) as f64 / 1000.0).collect();
        for (at, channel) in self.channels.iter_mut().enumerate() {
            let coldest = match channel.unit.as_deref() {
                Some("degC") => -273.15,
                Some("K") => 0.0,
                Some("degF") => -459.67,
                _ => f64::NEG_INFINITY,
            };
            let known: Vec<Option<f64>> = self.rows.values().map(|row| row.get(&at).copied()).collect();
            channel.readings = known.iter().map(|own| own.filter(|value| *value > coldest)).collect();
            let impossible = known.iter().flatten().count() - channel.readings.iter().flatten().count();
            if impossible > 0 {
                let what = counted(impossible, "reading");
                self.notes.push(format!("{what} of `{}` at or below absolute zero: taken as missing", channel.name));
            }
            let reason = if channel.readings.iter().flatten().next().is_none() {
                Some("has no reading")
            } else if channel.unit.is_none() {
                Some("has no unit; a map of the channels can give one")
            } else {
                None
            };
            if let Some(reason) = reason.filter(|_| channel.left_out.is_none()) {
                channel.left_out = Some(reason.to_owned());
            }
        }
    }
}

impl Log<'_> {
    fn reading(&self, cell: &Range<usize>) -> Reading {
        reading(&self.table.text(cell), self.dialect.has_comma)
    }
}

/// Header, units and rows of a text.
fn log<'t>(text: &'t str, dialect: Dialect, problems: &mut Problems) -> Option<Log<'t>> {
    let table = Table::new(text, dialect.separator, problems)?;
    let mut rows: Vec<Vec<Range<usize>>> = Vec::new();
    table.rows(table.headers().len(), problems, |cells, _| rows.push(cells.to_vec()));
    let mut headers: Vec<(String, Option<String>, Range<usize>)> = (table.headers().iter())
        .map(|header| {
            let (name, unit) = name_and_unit(&header.text);
            (name, unit, header.range.clone())
        })
        .collect();
    // A row below the header without a number is one of units.
    let says_units = rows.first().is_some_and(|row| {
        let texts: Vec<_> = row.iter().map(|cell| table.text(cell)).collect();
        texts.iter().any(|text| unit_of(text).is_some())
            && texts.iter().all(|text| {
                !matches!(reading(text, dialect.has_comma), Reading::Number(_))
                    && instant(text, dialect.has_comma).is_none()
            })
    });
    if says_units {
        for ((_, unit, _), cell) in headers.iter_mut().zip(rows.remove(0)) {
            *unit = unit_of(&table.text(&cell)).or(unit.take());
        }
    }
    Some(Log { table, dialect, headers, rows })
}

/// The columns of the time: the one that the user names, one with the name of a time, else the first if it holds times.
fn times(log: &Log<'_>, asked: Option<&str>, problems: &mut Problems) -> Option<Times> {
    let find = |names: &[&str], but: Option<usize>| {
        log.headers
            .iter()
            .enumerate()
            .position(|(at, (name, ..))| Some(at) != but && names.contains(&name.to_lowercase().as_str()))
    };
    let first = log.headers.first()?;
    if let Some(asked) = asked {
        let found = log.headers.iter().position(|(name, ..)| name == asked).map(Times::One);
        if found.is_none() {
            let headers: Vec<&str> = log.headers.iter().map(|(name, ..)| name.as_str()).collect();
            let help = format!("one of {}", headers.join(", "));
            problems.add(&code::TABLE_SHAPE, first.2.clone(), format!("no column is named `{asked}`"), Some(&help));
        }
        return found;
    }
    if let Some(date) = find(DATES, None) {
        return Some(find(CLOCKS, Some(date)).map_or(Times::One(date), |clock| Times::DateAndClock(date, clock)));
    }
    if let Some(time) = find(TIMES, None) {
        return Some(Times::One(time));
    }
    let row = log.rows.first()?;
    if matches!(instant(&log.table.text(&row[0]), log.dialect.has_comma), Some(Instant::Dated(_))) {
        return Some(Times::One(0));
    }
    let help = "--time HEADER names the column that holds it";
    problems.add(&code::TABLE_SHAPE, first.2.clone(), "no column is named like a time", Some(help));
    None
}
