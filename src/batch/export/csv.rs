//! Arrays as CSV: a file a group, a row for each place of the group's rows, a column for each variable and each label
//! across it. Numbers are the shortest text that reads back as the same double; an empty cell is missing.

use crate::job::dataset::{Dataset, Group, Values, Variable};
use crate::report::csv::{number, text as quoted};

/// The files, by name.
pub(super) fn files(dataset: &Dataset) -> Vec<(String, Vec<u8>)> {
    dataset.groups.iter().map(|group| (format!("{}.csv", group.name), table(group).into_bytes())).collect()
}

fn table(group: &Group) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::dataset::Dimension;

    #[test]
    fn a_group_is_a_table_with_a_row_for_each_of_its_places() {
        let mut group =
            Group::new("posterior", vec![Dimension::of_places("chain", 2, 1), Dimension::of_places("draw", 3, 2)]);
        group.numbers("G", "conductance", Some("W/K".to_owned()), vec![0.1, 1e-300, f64::NAN, 4.0]);
        let across = Dimension::of_names("reading", vec!["a, b".to_owned(), "c".to_owned()]);
        group.across("readings", "readings", across, (0..8).map(f64::from).collect());
        let text = table(&group);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "chain,draw,G [W/K],\"readings(a, b)\",readings(c)");
        assert_eq!(lines[1], "0,0,0.1,0,1");
        assert_eq!(lines[3], "1,0,,4,5");
        let tiny: f64 = lines[2].split(',').nth(2).expect("a cell").parse().expect("a number");
        assert_eq!(tiny, 1e-300);
    }
}
