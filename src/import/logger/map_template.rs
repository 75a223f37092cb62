//! A map of the channels to begin with: every channel that is named like nothing of the model, in the form that `--channels`
//! reads, with what it may stand for as far as names and units tell.

use super::proposal::{Known, bare, meant, quoted};
use super::record::{Channel, Record};
use crate::document::suggest::listed;
use crate::expression::Unit;

/// Fewest letters of a word that tells a name.
const LETTERS: usize = 3;
/// Names that a line lists.
const MOST_NAMES: usize = 12;

/// The map, and what of the model has no channel in it, in words.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MapTemplate {
    /// A CSV file's text.
    pub csv: String,
    /// Names of the model that no channel stands for; empty where all have one.
    pub without_channel: String,
    /// Whether there are channels that need no line: they are named like what they are.
    pub is_of_some: bool,
}

/// What a channel may stand for.
enum Guess<'k> {
    Input(&'k str),
    Measures(&'k str),
}

impl<'k> Guess<'k> {
    fn name(&self) -> &'k str {
        match self {
            Self::Input(name) | Self::Measures(name) => name,
        }
    }
}

/// Words of a name in small letters, numbers apart.
fn words(name: &str) -> Vec<String> {
    let split = name.split(|c: char| !c.is_alphabetic());
    split.filter(|word| word.chars().count() >= LETTERS).map(str::to_lowercase).collect()
}

/// Whether two units are of one dimension.
fn is_alike(one: Option<&str>, other: &str) -> bool {
    let dimension = |text: &str| Unit::parse(text).ok().map(|unit| unit.dimension);
    one.and_then(dimension).is_some_and(|own| dimension(other) == Some(own))
}

/// What a channel may stand for that is named like nothing: what shares a word with it.
fn guess<'k>(channel: &Channel, known: &'k Known) -> Option<Guess<'k>> {
    let own = words(&channel.name);
    let shares = |name: &str| {
        let theirs = words(name);
        own.iter().filter(|word| theirs.contains(word)).map(String::len).max().or_else(|| {
            let (short, whole) = (bare(name), bare(&channel.name));
            (short.len() >= LETTERS && whole.contains(&short)).then_some(short.len())
        })
    };
    let of_boundaries = known.boundaries.iter().map(|(node, input)| (node.as_str(), Guess::Input(input)));
    let is_fit = |input: &str| known.unit_of(input).is_some_and(|unit| is_alike(channel.unit.as_deref(), unit));
    let inputs = known.inputs.iter().map(|input| (input.as_str(), Guess::Input(input)));
    let inputs = inputs.chain(of_boundaries).filter(|(_, own)| is_fit(own.name()));
    let is_driven = |node: &str| known.boundaries.iter().any(|(boundary, _)| boundary == node);
    let nodes = known.measured.iter().filter(|name| channel.is_temperature() && !is_driven(name));
    let nodes = nodes.map(|node| (node.as_str(), Guess::Measures(node)));
    let mut best: Option<(usize, Guess<'k>)> = None;
    for (name, own) in nodes.chain(inputs) {
        if let Some(letters) = shares(name).filter(|letters| best.as_ref().is_none_or(|(most, _)| letters > most)) {
            best = Some((letters, own));
        }
    }
    best.map(|(_, own)| own)
}

/// A map of the channels of a record that need one.
pub fn map_template(record: &Record, known: &Known) -> MapTemplate {
    let mut csv = String::from("channel,name,unit,measures\n");
    let clear = |channel: &Channel| {
        let own = known.input_of(channel).or_else(|| meant(&known.measured, channel));
        own.filter(|_| channel.left_out.is_none())
    };
    let mut used: Vec<&str> = record.channels.iter().filter_map(clear).map(String::as_str).collect();
    let is_of_some = !used.is_empty();
    for channel in record.channels.iter().filter(|channel| clear(channel).is_none()) {
        let name = quoted(&channel.name);
        let unit = channel.unit.as_deref().unwrap_or_default();
        if channel.left_out.is_some() {
            csv.push_str(&format!("{name},,,\n"));
            continue;
        }
        // Two channels of one input would be an error; two sensors of a node are none.
        let own = guess(channel, known).filter(|own| !(matches!(own, Guess::Input(_)) && used.contains(&own.name())));
        used.extend(own.as_ref().map(Guess::name));
        csv.push_str(&match own {
            Some(Guess::Input(input)) => format!("{name},{},{unit},\n", quoted(input)),
            Some(Guess::Measures(measures)) => format!("{name},{name},{unit},{}\n", quoted(measures)),
            None => format!("{name},{name},{unit},\n"),
        });
    }
    let is_driven = |node: &str| known.boundaries.iter().any(|(boundary, _)| boundary == node);
    let inputs: Vec<String> = (known.inputs.iter())
        .filter(|name| !used.contains(&name.as_str()))
        .map(|name| known.unit_of(name).map_or_else(|| name.clone(), |unit| format!("{name} [{unit}]")))
        .collect();
    let nodes = known.measured.iter().filter(|name| !used.contains(&name.as_str()) && !is_driven(name));
    let nodes: Vec<&str> = nodes.map(String::as_str).collect();
    let parts = [("inputs", inputs.iter().map(String::as_str).collect()), ("nodes and quantities", nodes)];
    let parts = parts.into_iter().filter(|(_, names)| !names.is_empty());
    let parts: Vec<String> = parts.map(|(what, names)| format!("{what} {}", listed(names, MOST_NAMES))).collect();
    MapTemplate { csv, without_channel: parts.join("; "), is_of_some }
}
