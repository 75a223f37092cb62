//! What two passes say differently, in the words of their files: every entry of the passes with what they inherit, and of
//! their models, at its place.

use crate::document::Diagnostics;
use crate::document::json::{self, Entry, Node, Value};
use crate::document::source::{Place, Source, Span};

use super::folder::{Folder, FolderError};
use super::inherit::{folder_diagnostic_at, lineage};
use super::job::Kinds;
use super::model::tabulated;
use super::reader::Reader;
use super::resolved::Pass;

/// Longest text of a value, in characters.
const LONGEST: usize = 90;
/// Fields of a pass that decide no result.
const FOR_PEOPLE: &[&str] = &["format", "title", "description", "parent"];

/// An entry that two passes write differently.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ChangedEntry {
    /// The file and line that has it; of an entry that is gone, the one that had it.
    pub at: String,
    /// The entry, as in `parameters.G_foot.prior`.
    pub entry: String,
    /// What the first pass has there; nothing if it is new.
    pub before: Option<String>,
    /// What the second pass has there; nothing if it is gone.
    pub after: Option<String>,
}

/// What the files of two passes say differently, models first.
///
/// # Errors
/// A file that cannot be read any more.
pub fn changed(before: &Pass, after: &Pass) -> Result<Vec<ChangedEntry>, Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let trees = [before, after].map(|pass| trees(pass, &mut diagnostics));
    let [Some([old_model, old_pass]), Some([new_model, new_pass])] = trees else { return Err(diagnostics) };
    let mut changed_entries = Vec::new();
    walk("", Some(&old_model), Some(&new_model), &mut changed_entries);
    let old = without_words(old_pass);
    let new = without_words(new_pass);
    walk("", Some(&old), Some(&new), &mut changed_entries);
    for measurement in &after.measurements {
        let other = before.measurements.iter().find(|other| other.name == measurement.name);
        let is_listed =
            changed_entries.iter().any(|one| one.entry.starts_with(&format!("measurements.{}", measurement.name)));
        // Not by all that they resolve to: what a pass adopts moves places in the model's lists, and no reading.
        if !is_listed && other.is_some_and(|other| other.sha256 != measurement.sha256) {
            changed_entries.push(ChangedEntry {
                at: after.folder.join(&after.file).display().to_string(),
                entry: format!("measurements.{}", measurement.name),
                before: Some("the readings of its file".to_owned()),
                after: Some("other readings".to_owned()),
            });
        }
    }
    Ok(changed_entries)
}

/// A pass's model and the pass with what it inherits.
fn trees(pass: &Pass, diagnostics: &mut Diagnostics) -> Option<[Node; 2]> {
    let read = |diagnostics: &mut Diagnostics| -> Result<Option<[Node; 2]>, FolderError> {
        let folder = Folder::open(&pass.folder)?;
        let bytes = folder.read(&pass.model_file)?;
        let model = json::parse_bytes(&folder.shown_name(&pass.model_file), &bytes, diagnostics)
            .map(|tree| tabulated::expanded(tree, &folder, diagnostics));
        let pass = lineage(&Reader::new(Kinds::default()), &folder, &pass.file, diagnostics)?;
        Ok(model.zip(pass).map(|(model, pass)| [model, pass.merged]))
    };
    read(diagnostics).unwrap_or_else(|error| {
        let shown = pass.folder.join(&pass.file).display().to_string();
        let whole = Span::new(0, shown.len());
        diagnostics.push(folder_diagnostic_at(&error, &Place::in_text(&Source::new("command line", shown), whole)));
        None
    })
}

/// A pass without what is for people alone.
pub fn without_words(mut pass: Node) -> Node {
    if let Value::Object(entries) = &mut pass.value {
        entries.retain(|entry| !FOR_PEOPLE.contains(&entry.key.as_str()));
    }
    pass
}

/// Places at which two trees differ, from top to bottom.
pub fn walk(path: &str, before: Option<&Node>, after: Option<&Node>, found: &mut Vec<ChangedEntry>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    // Sections are stated entry by entry, also those that only one of them has.
    let is_section = !path.is_empty() && !path.contains(['.', '[']);
    match (before.map(|node| &node.value), after.map(|node| &node.value)) {
        (Some(old), Some(new)) if is_same(old, new) => {}
        (Some(Value::Object(old)), Some(Value::Object(new))) if !reads_as_one(old, new) => {
            for entry in old {
                walk(&below(&entry.key), Some(&entry.node), get(new, &entry.key), found);
            }
            for entry in new.iter().filter(|entry| get(old, &entry.key).is_none()) {
                walk(&below(&entry.key), None, Some(&entry.node), found);
            }
        }
        (Some(Value::Object(old)), None) if is_section => {
            old.iter().for_each(|entry| walk(&below(&entry.key), Some(&entry.node), None, found));
        }
        (None, Some(Value::Object(new))) if is_section => {
            new.iter().for_each(|entry| walk(&below(&entry.key), None, Some(&entry.node), found));
        }
        (Some(Value::Array(old)), Some(Value::Array(new)))
            if old.len() == new.len() && old.iter().chain(new).all(|item| matches!(item.value, Value::Object(_))) =>
        {
            for (position, (old, new)) in old.iter().zip(new).enumerate() {
                walk(&format!("{path}[{position}]"), Some(old), Some(new), found);
            }
        }
        _ => {
            let Some(place) = after.or(before).map(|node| &node.place) else { return };
            found.push(ChangedEntry {
                at: format!("{}:{}", place.source.name(), place.position().line),
                entry: if path.is_empty() { "everything".to_owned() } else { path.to_owned() },
                before: before.map(shown),
                after: after.map(shown),
            });
        }
    }
}

/// Whether two values are the same; numbers by their value, however written.
fn is_same(old: &Value, new: &Value) -> bool {
    match (old, new) {
        (Value::Null, Value::Null) => true,
        (Value::Bool(old), Value::Bool(new)) => old == new,
        (Value::Number(old), Value::Number(new)) => match (old.as_u64(), new.as_u64()) {
            // Large ones are not the same although they are as floats.
            (Some(old), Some(new)) => old == new,
            _ => old.as_f64() == new.as_f64(),
        },
        (Value::String(old), Value::String(new)) => old == new,
        (Value::Array(old), Value::Array(new)) => {
            old.len() == new.len() && old.iter().zip(new).all(|(old, new)| is_same(&old.value, &new.value))
        }
        (Value::Object(old), Value::Object(new)) => {
            let has =
                |entry: &Entry| get(new, &entry.key).is_some_and(|other| is_same(&entry.node.value, &other.value));
            old.len() == new.len() && old.iter().all(has)
        }
        _ => false,
    }
}

/// Whether a change from one object to the other is stated as one: of amounts with their unit, and of a choice.
fn reads_as_one(old: &[Entry], new: &[Entry]) -> bool {
    is_amount(old) || is_amount(new) || matches!((old, new), ([old], [new]) if old.key != new.key)
}

fn is_amount(entries: &[Entry]) -> bool {
    entries.len() == 2 && get(entries, "value").is_some() && get(entries, "unit").is_some()
}

fn get<'n>(entries: &'n [Entry], key: &str) -> Option<&'n Node> {
    entries.iter().find(|entry| entry.key == key).map(|entry| &entry.node)
}

/// A value as people read it.
fn shown(node: &Node) -> String {
    let text = match &node.value {
        Value::String(text) => text.clone(),
        Value::Number(_) => node.place.text().to_owned(),
        Value::Object(entries) => match (get(entries, "value"), get(entries, "unit"), entries.as_slice()) {
            (Some(value), Some(unit), [_, _]) => format!("{} {}", shown(value), shown(unit)),
            (_, _, [only]) => format!("{} {}", only.key, shown(&only.node)),
            _ => node.to_json().to_string(),
        },
        _ => node.to_json().to_string(),
    };
    if text.chars().count() <= LONGEST {
        return text;
    }
    text.chars().take(LONGEST - 3).chain("...".chars()).collect()
}
