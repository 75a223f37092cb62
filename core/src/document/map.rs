//! Names with values, in the order of the file.

use serde_json::json;

use super::diagnostic::Diagnostics;
use super::json::{Node, Value};
use super::schema::Schemas;
use super::source::Place;
use super::written::{Written, wrong_type};

/// Names with values, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Map<T>(Vec<MapEntry<T>>);

/// A name with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct MapEntry<T> {
    /// The name.
    pub name: String,
    /// Where the name stands.
    pub name_place: Place,
    /// The value.
    pub value: T,
    /// Where the value stands.
    pub place: Place,
}

impl<T> Default for Map<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Map<T> {
    /// The entries in the order of the file.
    pub fn iter(&self) -> std::slice::Iter<'_, MapEntry<T>> {
        self.0.iter()
    }
    /// The entry of a name.
    pub fn get(&self, name: &str) -> Option<&MapEntry<T>> {
        self.0.iter().find(|e| e.name == name)
    }
    /// The names in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|e| e.name.as_str())
    }
    /// Number of entries.
    pub fn len(&self) -> usize {
        self.0.len()
    }
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<'a, T> IntoIterator for &'a Map<T> {
    type Item = &'a MapEntry<T>;
    type IntoIter = std::slice::Iter<'a, MapEntry<T>>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Written> Written for Map<T> {
    fn read(node: &Node, diagnostics: &mut Diagnostics) -> Option<Self> {
        let Value::Object(entries) = &node.value else {
            return wrong_type(node, &Self::expected(), diagnostics);
        };
        let read: Vec<Option<MapEntry<T>>> = entries
            .iter()
            .map(|entry| {
                Some(MapEntry {
                    value: T::read(&entry.node, diagnostics)?,
                    name: entry.key.clone(),
                    name_place: entry.key_place.clone(),
                    place: entry.node.place.clone(),
                })
            })
            .collect();
        read.into_iter().collect::<Option<Vec<_>>>().map(Self)
    }
    fn schema(schemas: &mut Schemas) -> serde_json::Value {
        json!({"type": "object", "additionalProperties": T::schema(schemas)})
    }
    fn expected() -> String {
        format!("an object of names, each {}", T::expected())
    }
}
