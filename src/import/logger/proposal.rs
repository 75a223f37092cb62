//! A record as a measurement of a study: a clean CSV file, and the sensors and inputs that a pass would have.

use serde_json::{Map, Value, json};

use super::record::{Channel, Record};
use crate::document::counted;
use crate::report::number::significant;

/// What a study's model has that a channel may stand for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Known {
    /// Names of nodes and quantities, which sensors measure.
    pub measured: Vec<String>,
    /// Names of inputs.
    pub inputs: Vec<String>,
}

/// The proposal.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// The clean file: `time [s]`, then a column a channel, `NAME [unit]`.
    pub csv: String,
    /// The measurement as a pass writes it.
    pub measurement: Value,
    /// Names of the sensors.
    pub sensors: Vec<String>,
    /// Names of the inputs that have a column.
    pub inputs: Vec<String>,
    /// What else is to be known, a line each.
    pub notes: Vec<String>,
}

/// Letters and digits of a name in small letters: `TC_Box 1` and `tc box-1` are one.
fn bare(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The name among some that a channel means.
fn meant<'k>(names: &'k [String], channel: &Channel) -> Option<&'k String> {
    let asked = channel.measures.as_ref().unwrap_or(&channel.name);
    names.iter().find(|name| *name == asked).or_else(|| names.iter().find(|name| bare(name) == bare(asked)))
}

/// A record as the measurement of a model; `file` is the path of the clean file within the study.
pub fn propose(record: &Record, known: &Known, file: &str) -> Proposal {
    let mut notes = record.notes.clone();
    let mut sensors = Map::new();
    let mut hold: Vec<String> = Vec::new();
    let (mut columns, mut inputs, mut unknown): (Vec<(String, &Channel)>, Vec<String>, Vec<&str>) = Default::default();
    for channel in &record.channels {
        if let Some(reason) = &channel.left_out {
            notes.push(format!("channel `{}` {reason}: left out", channel.name));
        } else if let Some(input) = meant(&known.inputs, channel) {
            inputs.push(input.clone());
            if moves_in_steps(&channel.readings) {
                hold.push(input.clone());
            }
            columns.push((input.clone(), channel));
        } else if channel.is_stuck() {
            let value = channel.readings.iter().flatten().next().copied().unwrap_or(f64::NAN);
            notes.push(format!(
                "channel `{}` reads {value} throughout, as if nothing were connected: left out",
                channel.name
            ));
        } else if let Some(measures) = meant(&known.measured, channel) {
            sensors.insert(channel.name.clone(), sensor(measures, channel));
            columns.push((channel.name.clone(), channel));
        } else {
            unknown.push(&channel.name);
            columns.push((channel.name.clone(), channel));
        }
    }
    if !unknown.is_empty() {
        let names: Vec<String> = unknown.iter().map(|name| format!("`{name}`")).collect();
        notes.push(format!(
            "{} no node, quantity or input of the model: {}; their columns are kept, and --channels says what they are",
            if names.len() == 1 { "a channel is named like" } else { "channels are named like" },
            names.join(", ")
        ));
    }
    let longest = record.times_s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let mut steps: Vec<f64> = record.times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    if steps.get(steps.len() / 2).is_some_and(|usual| longest > 20.0 * usual) {
        let gap = significant(longest, 3);
        notes.push(format!("the longest gap between two rows is {gap} s; \"max_gap\" begins a transient anew there"));
    }
    let names = sensors.keys().cloned().collect();
    let mut transient = json!({"file": file, "sensors": sensors, "initial": {"measured": {}}});
    if !hold.is_empty() {
        notes.push(format!("held from row to row, because they move in steps: {}", hold.join(", ")));
        transient["hold"] = json!(hold);
    }
    let measurement = json!({"transient": transient});
    Proposal { csv: csv(record, &columns), measurement, sensors: names, inputs, notes }
}

fn sensor(measures: &str, channel: &Channel) -> Value {
    let mut out = json!({"measures": measures});
    if let (Some(sigma), true) = (scatter(&channel.readings), channel.is_temperature()) {
        out["sigma"] = json!({"value": sigma, "unit": "K"});
    }
    out
}

/// Whether a series stands still in most rows and jumps in some, as what a test sets does.
fn moves_in_steps(readings: &[Option<f64>]) -> bool {
    let known: Vec<f64> = readings.iter().flatten().copied().collect();
    let still = known.windows(2).filter(|two| two[0] == two[1]).count();
    let rows = known.len().saturating_sub(1);
    still < rows && 5 * still > 4 * rows
}

/// Standard deviation of what is not smooth in a series, to two digits: of its second differences, whose variance is six
/// times that of independent noise, by their median (P. J. Rousseeuw, C. Croux, J. Am. Stat. Assoc. 88, 1273, 1993, for the
/// factor 1.4826). Where most of them are 0, that of the display's steps.
pub fn scatter(readings: &[Option<f64>]) -> Option<f64> {
    let known: Vec<f64> = readings.iter().flatten().copied().collect();
    let mut second: Vec<f64> = known.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).abs()).collect();
    if second.len() < 8 {
        return None;
    }
    second.sort_by(f64::total_cmp);
    let noise = 1.4826 * second[second.len() / 2] / 6.0_f64.sqrt();
    let steps = known.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 0.0);
    let smallest = steps.fold(f64::INFINITY, f64::min);
    let sigma = if noise > 0.0 { noise } else { smallest / 12.0_f64.sqrt() };
    format!("{sigma:.1e}").parse().ok().filter(|sigma: &f64| sigma.is_finite() && *sigma > 0.0)
}

/// A cell with quotes where it needs them.
fn quoted(text: &str) -> String {
    let needs = text.contains([',', '"', '\n', '\r']);
    if needs { format!("\"{}\"", text.replace('"', "\"\"").replace(['\n', '\r'], " ")) } else { text.to_owned() }
}

fn csv(record: &Record, columns: &[(String, &Channel)]) -> String {
    let mut out = String::from("time [s]");
    for (name, channel) in columns {
        let unit = channel.unit.as_deref().unwrap_or("1");
        out.push(',');
        out.push_str(&quoted(&format!("{name} [{unit}]")));
    }
    out.push('\n');
    for (row, time) in record.times_s.iter().enumerate() {
        out.push_str(&time.to_string());
        for (_, channel) in columns {
            out.push(',');
            if let Some(value) = channel.readings.get(row).copied().flatten() {
                out.push_str(&value.to_string());
            }
        }
        out.push('\n');
    }
    out
}

impl Proposal {
    /// What was found, in a few lines.
    pub fn in_words(&self, record: &Record) -> String {
        let last = record.times_s.last().copied().unwrap_or(0.0);
        let mut text = format!(
            "{} over {} h: {}, {}\n",
            counted(record.times_s.len(), "instant"),
            significant(last / 3600.0, 3),
            counted(self.sensors.len(), "sensor"),
            counted(self.inputs.len(), "input")
        );
        for note in &self.notes {
            text.push_str(&format!("note: {note}\n"));
        }
        text
    }
}
