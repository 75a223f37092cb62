//! A record as a measurement of a study: a clean CSV file, and the sensors and inputs that a pass would have.

use serde_json::{Map, Value, json};

use super::absolute_error::{self, Tolerance};
use super::between_rows::{BetweenRows, between_rows};
use super::dead;
use super::record::{Channel, Record};
use crate::document::calendar::date_and_time;
use crate::document::suggest::{self, listed};
use crate::document::{counted, time};
use crate::report::number::significant;
use crate::statistics::noise::noise;
use crate::statistics::quantile::{quantile_sorted, sorted};

/// Standard deviations of a sensor's noise by which it changes between two rows where these are far apart.
const COARSE: f64 = 20.0;
/// Times the usual distance of two rows from which one is a gap.
const LONG_GAP: f64 = 20.0;
/// Names that a message lists.
const MOST_NAMES: usize = 12;

/// What a study's model has that a channel may stand for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Known {
    /// Names of nodes and quantities, which sensors measure.
    pub measured: Vec<String>,
    /// Names of inputs.
    pub inputs: Vec<String>,
    /// Their units, in the same order; none where they are not known.
    pub units: Vec<String>,
    /// Boundary nodes whose temperature is an input: name of the node, of the input.
    pub boundaries: Vec<(String, String)>,
}

impl Known {
    /// The unit of an input.
    pub(super) fn unit_of(&self, input: &str) -> Option<&str> {
        let at = self.inputs.iter().position(|name| name == input)?;
        self.units.get(at).map(String::as_str)
    }

    /// The input that a channel feeds: one named like it, else the temperature of a boundary node that is named like it, unless
    /// the user says what the channel measures.
    pub(super) fn input_of(&self, channel: &Channel) -> Option<&String> {
        meant(&self.inputs, channel).or_else(|| {
            let own = self.boundaries.iter().filter(|_| channel.measures.is_none());
            let of_node = |node: &String| *node == channel.name || bare(node) == bare(&channel.name);
            own.filter(|(node, _)| of_node(node)).map(|(_, input)| input).next()
        })
    }
}

/// What the user says of channels: how inputs go between rows, and what is no fault.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Said {
    /// Names of the inputs, or of their channels, that are held from row to row.
    pub held: Vec<String>,
    /// Names of those that are linear between rows.
    pub linear: Vec<String>,
    /// Names of channels whose readings all stay, though they look dead.
    pub kept: Vec<String>,
}

impl Said {
    /// The rule of an input: as the user says, else as its readings suggest.
    fn rule(&self, input: &str, channel: &Channel) -> BetweenRows {
        let says = |names: &[String]| names.iter().any(|name| name == input || *name == channel.name);
        let by = |is_held, option| BetweenRows { is_held, because: format!("as {option} says") };
        if says(&self.held) {
            by(true, "--hold")
        } else if says(&self.linear) {
            by(false, "--linear")
        } else {
            between_rows(&channel.readings, channel.unit.as_deref().unwrap_or_default())
        }
    }

    /// A name that no input of the record has, or that is said to be both.
    fn wrong(&self, inputs: &[(&str, &str)]) -> Option<String> {
        let is_known = |name: &&String| inputs.iter().any(|(input, channel)| name == input || name == channel);
        if let Some(name) = self.held.iter().find(|name| self.linear.contains(name)) {
            return Some(format!("`{name}` cannot be both held and linear: name it after --hold or after --linear"));
        }
        let name = self.held.iter().chain(&self.linear).find(|name| !is_known(name))?;
        let known = listed(inputs.iter().map(|(input, _)| *input), MOST_NAMES);
        Some(format!("--hold and --linear: `{name}` is no input with a channel; they are {known}"))
    }
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
    /// Whether a channel means nothing that the model has.
    pub has_unknown: bool,
}

/// Letters and digits of a name in small letters: `TC_Box 1` and `tc box-1` are one.
pub(super) fn bare(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The name among some that a channel means.
pub(super) fn meant<'k>(names: &'k [String], channel: &Channel) -> Option<&'k String> {
    let asked = channel.measures.as_ref().unwrap_or(&channel.name);
    names.iter().find(|name| *name == asked).or_else(|| names.iter().find(|name| bare(name) == bare(asked)))
}

/// A record as the measurement of a model; `file` is the path of the clean file within the study.
///
/// # Errors
/// What the user says of an input that the record does not have.
pub fn propose(record: &Record, known: &Known, said: &Said, file: &str) -> Result<Proposal, String> {
    let (record, of_dead) = dead::without(record, &said.kept);
    let record = &record;
    let mut notes = record.notes.clone();
    let mut assumed: Vec<(String, Tolerance)> = Vec::new();
    let mut sensors = Map::new();
    let mut hold: Vec<String> = Vec::new();
    let (mut columns, mut inputs, mut unknown): (Vec<(String, &Channel)>, Vec<String>, Vec<&Channel>) =
        Default::default();
    let (mut measuring, mut of_inputs, mut rules) = (Vec::new(), Vec::new(), Vec::new());
    // A channel named like the input itself goes before one named like its node.
    let named = |input: &str| {
        record
            .channels
            .iter()
            .any(|own| own.left_out.is_none() && meant(&known.inputs, own).is_some_and(|own| own == input))
    };
    let is_fed_by = |input: &&String, channel: &Channel| meant(&known.inputs, channel).is_some() || !named(input);
    for channel in &record.channels {
        if let Some(reason) = &channel.left_out {
            notes.push(format!("channel `{}` {reason}: left out", channel.name));
        } else if let Some(input) = known.input_of(channel).filter(|input| is_fed_by(input, channel)) {
            if meant(&known.inputs, channel).is_none() {
                notes.push(format!(
                    "channel `{}` is named like a boundary node, whose temperature is input {input}: it feeds that input",
                    channel.name
                ));
            }
            inputs.push(input.clone());
            let rule = said.rule(input, channel);
            let how = if rule.is_held { "held from row to row" } else { "linear between rows" };
            rules.push(format!("input {input} is {how}: {}", rule.because));
            if rule.is_held {
                hold.push(input.clone());
            }
            of_inputs.push((input.as_str(), channel.name.as_str()));
            columns.push((input.clone(), channel));
        } else if channel.is_stuck() && !said.kept.contains(&channel.name) {
            let value = channel.readings.iter().flatten().next().copied().unwrap_or(f64::NAN);
            notes.push(format!(
                "channel `{}` reads {value} throughout, as if nothing were connected: left out",
                channel.name
            ));
        } else if let Some(measures) = meant(&known.measured, channel) {
            let tolerance = absolute_error::tolerance(channel);
            sensors.insert(channel.name.clone(), sensor(measures, channel, tolerance));
            assumed.extend(tolerance.map(|tolerance| (channel.name.clone(), tolerance)));
            measuring.push(channel);
            columns.push((channel.name.clone(), channel));
        } else {
            unknown.push(channel);
            columns.push((channel.name.clone(), channel));
        }
    }
    if !unknown.is_empty() {
        let names: Vec<String> = unknown.iter().map(|channel| unknown_name(channel, known)).collect();
        notes.push(format!(
            "{} no node, quantity or input of the model: {}; their columns are kept, and --channels says what they are",
            if names.len() == 1 { "a channel is named like" } else { "channels are named like" },
            names.join(", ")
        ));
        if unknown.iter().any(|channel| channel.is_temperature()) {
            notes.push(
                "the temperature of something that the model leaves out, as a flange or another room, can be an input of \
                 model.json that nothing uses: a diagnosis then tries a conductive path to it"
                    .to_owned(),
            );
        }
    }
    let longest = record.times_s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    if longest > LONG_GAP * usual_step(record) {
        let gap = significant(longest, 3);
        // A number of JSON, whatever its size.
        let limit = (LONG_GAP * usual_step(record)).ceil();
        notes.push(format!(
            "the longest gap between two rows is {gap} s, over which inputs would go on as they were; with \"max_gap\": {{\"value\": {limit}, \
             \"unit\": \"s\"}} beside \"file\" each part begins anew at its first readings"
        ));
    }
    let names = sensors.keys().cloned().collect();
    let mut transient = json!({"file": file, "sensors": sensors, "initial": {"measured": {}}});
    if let Some(start) = record.start_s.and_then(date_and_time) {
        transient["time_zero"] = json!(start.replace(' ', "T"));
    }
    if let Some(wrong) = said.wrong(&of_inputs) {
        return Err(wrong);
    }
    notes.extend(of_dead);
    notes.extend(absolute_error::note(&assumed));
    notes.extend(rules);
    notes.extend(coarse(record, &measuring, !hold.is_empty()));
    if !hold.is_empty() {
        transient["hold"] = json!(hold);
    }
    let measurement = json!({"transient": transient});
    let has_unknown = !unknown.is_empty();
    Ok(Proposal { csv: csv(record, &columns), measurement, sensors: names, inputs, notes, has_unknown })
}

/// A channel that means nothing known, with what its map may have meant.
fn unknown_name(channel: &Channel, known: &Known) -> String {
    let Some(measures) = &channel.measures else { return format!("`{}`", channel.name) };
    let names = known.inputs.iter().chain(&known.measured).map(String::as_str);
    let near = suggest::nearest(measures, names).map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
    format!("`{}` (mapped to `{measures}`{near})", channel.name)
}

fn sensor(measures: &str, channel: &Channel, tolerance: Option<Tolerance>) -> Value {
    let mut out = json!({"measures": measures});
    if let (Some(sigma), true) = (scatter(&channel.readings), channel.is_temperature()) {
        out["sigma"] = json!({"value": sigma, "unit": "K"});
    }
    if let Some(tolerance) = tolerance {
        out["bias"] = tolerance.bias();
        out["description"] = json!(tolerance.in_words());
    }
    out
}

/// The noise of a series to two digits; where it is 0, as of a display, that of the display's steps.
pub fn scatter(readings: &[Option<f64>]) -> Option<f64> {
    let known: Vec<f64> = readings.iter().flatten().copied().collect();
    let noise = noise(&known)?;
    let steps = known.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 0.0);
    let smallest = steps.fold(f64::INFINITY, f64::min);
    let sigma = if noise > 0.0 { noise } else { smallest / 12.0_f64.sqrt() };
    format!("{sigma:.1e}").parse().ok().filter(|sigma: &f64| sigma.is_finite() && *sigma > 0.0)
}

/// What to be aware of where rows are so far apart that temperatures change much between two: a held input may have
/// stepped at any instant between them.
fn coarse(record: &Record, sensors: &[&Channel], has_steps: bool) -> Option<String> {
    let apart = usual_step(record);
    // Over a gap temperatures may change by anything.
    let is_near = |row: usize| record.times_s[row + 1] - record.times_s[row] < 2.0 * apart;
    let fastest = sensors.iter().filter_map(|channel| {
        let of_rows = channel.readings.windows(2).enumerate().filter(|(row, _)| is_near(*row));
        let changes = of_rows.filter_map(|(_, two)| Some((two[1]? - two[0]?).abs()));
        let change = changes.fold(0.0, f64::max);
        Some((*channel, change, scatter(&channel.readings)?)).filter(|(_, change, sigma)| *change > COARSE * sigma)
    });
    let (channel, change, _) = fastest.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| has_steps)?;
    let (apart, change) = (significant(apart, 3), significant(change, 2));
    Some(format!(
        "rows are {apart} s apart, and `{}` changes by up to {change} K between two: an input that is held has stepped up to \
         {apart} s before the row that shows it, which looks like a lag of the sensors; log faster round a step, or \
         ignore the rows after it",
        channel.name
    ))
}

/// The median distance between two rows, s.
fn usual_step(record: &Record) -> f64 {
    quantile_sorted(&sorted(&record.times_s.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>()), 0.5)
}

/// A cell with quotes where it needs them.
pub(super) fn quoted(text: &str) -> String {
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
            "{} over {}: {}, {}\n",
            counted(record.times_s.len(), "instant"),
            time::instant(last, last),
            counted(self.sensors.len(), "sensor"),
            counted(self.inputs.len(), "input")
        );
        for note in &self.notes {
            text.push_str(&format!("note: {note}\n"));
        }
        text
    }
}
