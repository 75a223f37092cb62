//! Arrays as NPY files (format 1.0 of NumPy's enhancement proposal 1) beside an index of names, labels, units and texts.

use serde_json::{Map, Value, json};

use crate::batch::BatchError;
use crate::job::array::npy;
use crate::job::dataset::{Attribute, Dataset, Dimension, Group, Labels, Values, Variable};

/// The files, by name.
///
/// # Errors
/// An index that cannot be written.
pub(super) fn files(dataset: &Dataset) -> Result<Vec<(String, Vec<u8>)>, BatchError> {
    let mut files = Vec::new();
    let mut groups = Map::new();
    for group in &dataset.groups {
        let mut variables = Map::new();
        for (position, variable) in group.variables.iter().enumerate() {
            let mut entry = described(group, variable);
            match &variable.values {
                // Names of variables may hold what names of files may not.
                Values::Numbers(values) => {
                    let file = format!("{}.{position}.npy", group.name);
                    files.push((file.clone(), npy(&shape(group, variable), values)));
                    entry.insert("file".to_owned(), json!(file));
                }
                Values::Texts(values) => {
                    entry.insert("values".to_owned(), json!(values));
                }
            }
            variables.insert(variable.name.clone(), Value::Object(entry));
        }
        groups.insert(
            group.name.to_owned(),
            json!({"attributes": attributes(&group.attributes), "variables": variables}),
        );
    }
    let index = json!({"attributes": attributes(&dataset.attributes), "groups": groups});
    let text = serde_json::to_string_pretty(&index).map_err(|error| BatchError::job(error.to_string()))?;
    files.push(("index.json".to_owned(), format!("{text}\n").into_bytes()));
    Ok(files)
}

fn dimensions<'g>(group: &'g Group, variable: &'g Variable) -> impl Iterator<Item = &'g Dimension> {
    group.rows.iter().chain(&variable.across)
}

fn shape(group: &Group, variable: &Variable) -> Vec<usize> {
    dimensions(group, variable).map(|dimension| dimension.labels.len()).collect()
}

fn described(group: &Group, variable: &Variable) -> Map<String, Value> {
    let labels = |dimension: &Dimension| match &dimension.labels {
        Labels::Places(places) => json!({"name": dimension.name, "labels": places}),
        Labels::Names(names) => json!({"name": dimension.name, "labels": names}),
    };
    let mut entry = Map::new();
    entry.insert("about".to_owned(), json!(variable.about));
    entry.insert("unit".to_owned(), json!(variable.unit));
    entry.insert("dimensions".to_owned(), dimensions(group, variable).map(labels).collect());
    entry
}

fn attributes(attributes: &[(&'static str, Attribute)]) -> Value {
    let value = |value: &Attribute| match value {
        Attribute::Text(text) => json!(text),
        Attribute::Whole(number) => json!(number),
        Attribute::Numbers(numbers) => json!(numbers),
    };
    Value::Object(attributes.iter().map(|(name, of_name)| ((*name).to_owned(), value(of_name))).collect())
}
