//! A pass with what it inherits from its parents.
//!
//! Sections with named entries are inherited by name: a named entry replaces the parent's whole entry, `null` removes
//! it. `title`, `description`, `model` and `seed` are inherited where they are not given. Jobs are not inherited.
//! The trees are merged before they are read, so that every entry keeps its place in the file that wrote it.

use std::collections::HashMap;
use std::sync::Arc;

use crate::document::code;
use crate::document::diagnostic::{Diagnostic, Diagnostics};
use crate::document::json::{Entry, Node, Value};
use crate::document::source::{Place, Source, Span};

use super::folder::{Folder, FolderError};
use super::reader::Reader;

/// Sections whose entries are inherited by name.
pub const NAMED: &[&str] =
    &["parameters", "adopt", "requirements", "environments", "measurements", "quantities", "criteria", "design"];
/// Fields that are inherited as they are.
const PLAIN: &[&str] = &["title", "description", "model", "seed"];

/// Most parents of a pass, one behind the other.
pub const MOST_PARENTS: usize = 100;

/// A pass file as written.
#[derive(Clone, Debug)]
pub struct PassFile {
    /// Its name within the study's folder.
    pub name: String,
    /// The tree.
    pub tree: Arc<Node>,
}

/// A pass, its parents behind it, nearest first.
#[derive(Clone, Debug)]
pub struct Lineage {
    /// The files, the pass itself first.
    pub files: Vec<PassFile>,
    /// The pass with everything inherited; `parent` is the pass's own.
    pub merged: Node,
}

/// Reads a pass of a folder and its parents and merges them. `None` where the pass itself cannot be read; errors go
/// to `diagnostics`.
pub fn lineage(
    reader: &Reader,
    folder: &Folder,
    name: &str,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Lineage>, FolderError> {
    let parsed = reader.tree(folder, name)?;
    diagnostics.extend(&parsed.diagnostics);
    let Some(tree) = parsed.tree else { return Ok(None) };
    let mut files = vec![PassFile { name: plain_name(name), tree }];
    while let Some(next) = parent(reader, folder, &files, diagnostics) {
        files.push(next);
    }
    let mut merged: Option<Node> = None;
    for file in files.iter().rev() {
        merged = Some(match merged {
            None => first(&file.tree, diagnostics),
            Some(inherited) => merge(&inherited, &file.tree, diagnostics),
        });
    }
    Ok(merged.map(|merged| Lineage { files, merged }))
}

/// The next parent of the last file; `None` where there is none or it cannot be used.
fn parent(reader: &Reader, folder: &Folder, files: &[PassFile], diagnostics: &mut Diagnostics) -> Option<PassFile> {
    let node = files.last()?.tree.get("parent")?;
    // Anything but a string is reported when the merged pass, or this parent as a pass, is read.
    let Value::String(name) = &node.value else { return None };
    if let Some(position) = files.iter().position(|file| file.name == plain_name(name)) {
        let way: Vec<&str> = files[position..].iter().map(|file| file.name.as_str()).collect();
        let way = format!("{} -> {}", way.join(" -> "), files[position].name);
        diagnostics.push(
            Diagnostic::error(&code::PARENT_CYCLE, &node.place, format!("the parents run in a circle: {way}"))
                .expected("reached before")
                .help("the first pass has \"parent\": null"),
        );
        return None;
    }
    if files.len() > MOST_PARENTS {
        let message = format!("`{}` has more than {MOST_PARENTS} parents, one behind the other", files[0].name);
        diagnostics.push(
            Diagnostic::error(&code::TOO_LONG_CHAIN, &node.place, message)
                .help("write what a later pass inherits into a pass with \"parent\": null"),
        );
        return None;
    }
    match reader.tree(folder, name) {
        Ok(parsed) => {
            diagnostics.extend(&parsed.diagnostics);
            Some(PassFile { name: plain_name(name), tree: parsed.tree? })
        }
        Err(error) => {
            diagnostics.push(folder_diagnostic(&error, node));
            None
        }
    }
}

/// What is wrong with a path, at the place where it is written.
pub(super) fn folder_diagnostic(error: &FolderError, node: &Node) -> Diagnostic {
    folder_diagnostic_at(error, &node.place)
}

/// What is wrong with a path, at its place.
pub fn folder_diagnostic_at(error: &FolderError, place: &Place) -> Diagnostic {
    match error {
        FolderError::NotPlain { .. } | FolderError::LeadsOut { .. } => {
            Diagnostic::error(&code::PATH_REFUSED, place, error.to_string())
        }
        FolderError::Missing { .. } | FolderError::Unreadable { .. } => {
            Diagnostic::error(&code::FILE_MISSING, place, error.to_string())
        }
        FolderError::TooLarge { .. } => Diagnostic::error(&code::TOO_LARGE, place, error.to_string()),
    }
}

/// What is wrong with a file that no other names, at its beginning.
pub(super) fn unnamed_file_diagnostic(folder: &Folder, file: &str, error: &FolderError) -> Diagnostic {
    let nowhere = Place::in_text(&Source::new(folder.shown_name(file), ""), Span::default());
    folder_diagnostic_at(error, &nowhere)
}

/// A file's name within the study in its plainest form.
pub fn plain_name(name: &str) -> String {
    let parts: Vec<&str> = name.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    parts.join("/")
}

/// The oldest pass: it has nothing to remove.
fn first(tree: &Node, diagnostics: &mut Diagnostics) -> Node {
    let mut tree = tree.clone();
    if let Value::Object(entries) = &mut tree.value {
        for entry in entries.iter_mut().filter(|entry| NAMED.contains(&entry.key.as_str())) {
            entry.node = overlay(None, &entry.key, &entry.node, diagnostics);
        }
    }
    tree
}

fn merge(inherited: &Node, own: &Node, diagnostics: &mut Diagnostics) -> Node {
    let (Value::Object(old), Value::Object(new)) = (&inherited.value, &own.value) else { return own.clone() };
    let mut entries: Vec<Entry> = Vec::new();
    for entry in new {
        let key = entry.key.as_str();
        let mut entry = entry.clone();
        if NAMED.contains(&key) {
            let before = old.iter().find(|other| other.key == entry.key).map(|other| &other.node);
            entry.node = overlay(before, &entry.key, &entry.node, diagnostics);
        }
        entries.push(entry);
    }
    for entry in old {
        let key = entry.key.as_str();
        if (NAMED.contains(&key) || PLAIN.contains(&key)) && !new.iter().any(|other| other.key == entry.key) {
            entries.push(entry.clone());
        }
    }
    Node { value: Value::Object(entries), place: own.place.clone() }
}

/// A section with the parent's entries under it.
fn overlay(before: Option<&Node>, section: &str, own: &Node, diagnostics: &mut Diagnostics) -> Node {
    let Value::Object(new) = &own.value else { return own.clone() };
    let mut entries: Vec<Entry> = match before.map(|node| &node.value) {
        Some(Value::Object(entries)) => entries.clone(),
        Some(_) | None => Vec::new(),
    };
    // Keys of a section are unique, so that places stay as they are until the end.
    let positions: HashMap<String, usize> =
        entries.iter().enumerate().map(|(position, entry)| (entry.key.clone(), position)).collect();
    let mut removed = Vec::new();
    for entry in new {
        match (positions.get(&entry.key).copied(), &entry.node.value) {
            (Some(position), Value::Null) => removed.push(position),
            (Some(position), _) => entries[position] = entry.clone(),
            (None, Value::Null) => {
                let near = diagnostics.nearest(&entry.key, entries.iter().map(|other| other.key.as_str()));
                diagnostics.push(
                    Diagnostic::error(
                        &code::NOTHING_TO_REMOVE,
                        &entry.key_place,
                        format!("no parent has `{}` under `{section}`", entry.key),
                    )
                    .expected("`null` removes what a parent has")
                    .suggest(near),
                );
            }
            (None, _) => entries.push(entry.clone()),
        }
    }
    removed.sort_unstable();
    let mut position = 0;
    entries.retain(|_| {
        position += 1;
        removed.binary_search(&(position - 1)).is_err()
    });
    Node { value: Value::Object(entries), place: own.place.clone() }
}
