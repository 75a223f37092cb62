//! Arrays as CSV: a file a group, a row for each place of the group's rows, a column for each variable and each label
//! across it. Numbers are the shortest text that reads back as the same double; an empty cell is missing.

use crate::job::dataset::{Dataset, Group, Values, Variable};
use crate::report::csv::{number, text as quoted};

/// The files, by name.
pub(super) fn files(dataset: &Dataset) -> Vec<(String, Vec<u8>)> {
    dataset.groups.iter().map(|group| (format!("{}.csv", group.name), table(group).into_bytes())).collect()
}

/// One group as CSV: a column a dimension and a variable.
pub fn table(group: &Group) -> String {
    let mut heading: Vec<String> = group.rows.iter().map(|dimension| quoted(dimension.name)).collect();
    for variable in &group.variables {
        let unit = variable.unit.as_ref().map_or_else(String::new, |unit| format!(" [{unit}]"));
        match &variable.across {
            None => heading.push(quoted(&format!("{}{unit}", variable.name))),
            Some(across) => heading.extend(
                (0..across.labels.len())
                    .map(|place| quoted(&format!("{}({}){unit}", variable.name, across.labels.text(place)))),
            ),
        }
    }
    let mut text = heading.join(",");
    text.push('\n');
    for row in 0..group.len() {
        let mut cells = labels(group, row);
        cells.extend(group.variables.iter().flat_map(|variable| of_row(variable, row)));
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}

/// The labels of a row, the last dimension running fastest.
fn labels(group: &Group, row: usize) -> Vec<String> {
    let mut rest = row;
    let mut labels: Vec<String> = Vec::new();
    for dimension in group.rows.iter().rev() {
        let count = dimension.labels.len().max(1);
        labels.push(quoted(&dimension.labels.text(rest % count)));
        rest /= count;
    }
    labels.reverse();
    labels
}

/// The cells of a variable in a row.
fn of_row(variable: &Variable, row: usize) -> Vec<String> {
    let width = variable.across.as_ref().map_or(1, |across| across.labels.len());
    let cells = row * width..(row + 1) * width;
    match &variable.values {
        Values::Numbers(values) => values.get(cells).unwrap_or_default().iter().copied().map(number).collect(),
        Values::Texts(values) => values.get(cells).unwrap_or_default().iter().map(|text| quoted(text)).collect(),
    }
}
