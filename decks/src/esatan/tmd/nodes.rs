//! Nodes of a `.TMD` file: numbers, submodels, labels, and their quantities at each instant.

use std::collections::{BTreeMap, HashSet};

use hdf5_reader::group::Group;
use hdf5_reader::{Datatype, StringSize};

use crate::Deck;

use super::add_group;
use super::store::{FixedText, Table, trimmed};

/// Most nodes.
const NODES: usize = 1 << 16;
/// Most nodes times instants.
const NODE_ROWS: usize = 1 << 23;
/// Most instants.
const ROWS: usize = 1 << 20;
/// Most quantities of a node.
const QUANTITIES: usize = 64;
/// Most submodels.
const MODELS: usize = 1 << 12;

/// The heats of a node, which add.
const HEATS: [&str; 5] = [
    "Total_Solar_Heat_Source",
    "Total_Albedo_Heat_Source",
    "Total_Earth_Heat_Source",
    "Total_Internal_Heat_Source",
    "Total_Rest_Heat_Source",
];

/// The nodes of a file in its order, inactive ones too.
pub(super) struct NodeTable {
    /// Instants in s.
    pub(super) times_s: Vec<f64>,
    /// A row a node.
    pub(super) rows: Vec<NodeRow>,
}

/// A node with its quantities at each instant.
pub(super) struct NodeRow {
    /// `SUB.12`, or `12` in the model at the top.
    pub(super) name: String,
    /// Number of its submodel, from 1.
    pub(super) model: i32,
    /// Path of its submodel; empty at the top.
    pub(super) path: String,
    /// D, B, X.
    pub(super) kind: char,
    pub(super) label: String,
    pub(super) temperature_k: Vec<f64>,
    /// J/K.
    pub(super) capacity: Vec<f64>,
    pub(super) heat_w: Vec<f64>,
    /// m2, at the first instant.
    area: f64,
    absorptivity: f64,
    emissivity: f64,
}

impl NodeRow {
    /// Keeps some of its instants.
    pub(super) fn keep(&mut self, rows: &[usize]) {
        for series in [&mut self.temperature_k, &mut self.capacity, &mut self.heat_w] {
            *series = rows.iter().filter_map(|&row| series.get(row).copied()).collect();
        }
    }

    /// Its name and label.
    pub(super) fn described(&self) -> String {
        if self.label.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.label) }
    }
}

/// Reads all nodes with their quantities.
pub(super) fn read(analysis: &Group, solution: &Group, zero_k: f64) -> Result<NodeTable, String> {
    let numbers = Table::open(analysis, "thermalNodes", &[NODES, 2])?;
    numbers.expect(1, 2, "the number and the submodel of a node")?;
    let paths = model_paths(analysis)?;
    let times = Table::open(solution, "times", &[ROWS])?;
    let count = numbers.shape()[0];
    let instants = times.shape()[0];
    if count == 0 {
        return Err("there is no thermal node; write the file with the model in it".to_owned());
    }
    if count.saturating_mul(instants) > NODE_ROWS {
        return Err(format!("{count} nodes at {instants} instants are more than the {NODE_ROWS} temperatures read"));
    }
    let mut rows = Vec::with_capacity(count);
    for pair in numbers.all::<i32>()?.chunks_exact(2) {
        let [number, model] = [pair[0], pair[1]];
        let path = usize::try_from(model).ok().and_then(|model| paths.get(model.wrapping_sub(1)));
        let path = path.ok_or_else(|| format!("node {number} is in submodel {model}, which `models` lacks"))?;
        rows.push(NodeRow {
            name: if path.is_empty() { number.to_string() } else { format!("{path}.{number}") },
            model,
            path: path.clone(),
            kind: ' ',
            label: String::new(),
            temperature_k: Vec::with_capacity(instants),
            capacity: Vec::with_capacity(instants),
            heat_w: Vec::with_capacity(instants),
            area: 0.0,
            absorptivity: 0.0,
            emissivity: 0.0,
        });
    }
    let mut table = NodeTable { times_s: times.all()?, rows };
    read_texts(analysis, solution, &mut table)?;
    read_quantities(analysis, solution, zero_k, &mut table)?;
    Ok(table)
}

/// Path of each submodel, its names joined by points; empty for the model at the top.
fn model_paths(analysis: &Group) -> Result<Vec<String>, String> {
    let table = Table::open(analysis, "models", &[MODELS])?;
    let dataset = analysis.dataset("models").map_err(|error| format!("`models` cannot be opened: {error}"))?;
    let Datatype::Compound { fields, .. } = dataset.dtype() else {
        return Err("`models` is not a table of submodels".to_owned());
    };
    let field = |name: &str| {
        let field = fields.iter().find(|field| field.name == name);
        field.ok_or_else(|| format!("`models` lacks the column `{name}`"))
    };
    let (name_field, parent_field) = (field("modelName")?, field("parentId")?);
    let Datatype::String { size: StringSize::Fixed(length), .. } = name_field.datatype else {
        return Err("the names in `models` are not of fixed length".to_owned());
    };
    let name_start = name_field.byte_offset as usize;
    let parent_start = parent_field.byte_offset as usize;
    let mut models = Vec::new();
    for bytes in table.all::<FixedText>()? {
        let bytes = bytes.bytes();
        let name = bytes.get(name_start..name_start.saturating_add(length as usize));
        let parent = bytes.get(parent_start..parent_start.saturating_add(4)).and_then(|four| four.try_into().ok());
        let (Some(name), Some(parent)) = (name, parent) else {
            return Err("`models` is shorter than its own columns".to_owned());
        };
        models.push((trimmed(name), i32::from_le_bytes(parent)));
    }
    let mut paths = Vec::with_capacity(models.len());
    for (name, parent) in &models {
        let (mut path, mut parent, mut depth) = (Vec::new(), *parent, 0);
        let mut name = name;
        // The model at the top has no parent within the table, and no place in the name of a node.
        while let Some((above, next)) = usize::try_from(parent).ok().and_then(|p| models.get(p.wrapping_sub(1))) {
            path.push(name.as_str());
            (name, parent, depth) = (above, *next, depth + 1);
            if depth > 64 {
                return Err(format!("submodel {name} is part of itself"));
            }
        }
        path.reverse();
        paths.push(path.join("."));
    }
    Ok(paths)
}

fn read_texts(analysis: &Group, solution: &Group, table: &mut NodeTable) -> Result<(), String> {
    let names = column_names(analysis, "thermalNodesStringAttributes")?;
    let column = |name: &str| position(&names, name, "thermalNodesStringAttributes");
    let (kind_column, label_column) = (column("Type")?, column("Label")?);
    let texts = Table::open(solution, "thermalNodesStringData", &[ROWS, NODES, QUANTITIES])?;
    let width = expect_sizes(&texts, table, names.len())?;
    texts.each_row(|row, values: &[FixedText]| {
        for (node, texts) in table.rows.iter_mut().zip(values.chunks_exact(width)) {
            let kind = texts[kind_column].first();
            if row == 0 {
                node.kind = kind;
                node.label = texts[label_column].text();
            } else if node.kind != kind {
                return Err(format!(
                    "node {} is of type {} at first and {kind} in row {}; write out the solutions apart",
                    node.name,
                    node.kind,
                    row + 1
                ));
            }
        }
        Ok(())
    })
}

fn read_quantities(analysis: &Group, solution: &Group, zero_k: f64, table: &mut NodeTable) -> Result<(), String> {
    let names = column_names(analysis, "thermalNodesRealAttributes")?;
    let column = |name: &str| position(&names, name, "thermalNodesRealAttributes");
    let (temperature, capacity) = (column("Temperature")?, column("Capacitance")?);
    let heats = HEATS.map(column).into_iter().collect::<Result<Vec<usize>, String>>()?;
    let optional = |name: &str| names.iter().position(|other| other == name);
    let [area, absorptivity, emissivity] = ["Area", "Solar_Absorptivity", "Infra-Red_Emissivity"].map(optional);
    let numbers = Table::open(solution, "thermalNodesRealData", &[ROWS, NODES, QUANTITIES])?;
    let width = expect_sizes(&numbers, table, names.len())?;
    numbers.each_row(|row, values: &[f64]| {
        for (node, values) in table.rows.iter_mut().zip(values.chunks_exact(width)) {
            let heat_w: f64 = heats.iter().map(|&heat| values[heat]).sum();
            let temperature_k = values[temperature] + zero_k;
            if !(temperature_k.is_finite() && heat_w.is_finite() && values[capacity].is_finite()) {
                return Err(format!("node {} has no finite quantities in row {}", node.name, row + 1));
            }
            node.temperature_k.push(temperature_k);
            node.capacity.push(values[capacity]);
            node.heat_w.push(heat_w);
            if row == 0 {
                let value = |column: Option<usize>| column.map_or(0.0, |column| values[column]);
                (node.area, node.absorptivity, node.emissivity) = (value(area), value(absorptivity), value(emissivity));
            }
        }
        Ok(())
    })
}

fn column_names(analysis: &Group, name: &str) -> Result<Vec<String>, String> {
    let table = Table::open(analysis, name, &[QUANTITIES])?;
    Ok(table.all::<FixedText>()?.iter().map(FixedText::text).collect())
}

fn position(names: &[String], name: &str, table: &str) -> Result<usize, String> {
    names.iter().position(|other| other == name).ok_or_else(|| format!("`{table}` lacks `{name}`"))
}

/// Checks that a table holds every instant, node and column; the number of columns, at least 1.
fn expect_sizes(table: &Table, nodes: &NodeTable, columns: usize) -> Result<usize, String> {
    table.expect(0, nodes.times_s.len(), "`times`")?;
    table.expect(1, nodes.rows.len(), "`thermalNodes`")?;
    table.expect(2, columns, "its list of columns")?;
    Ok(columns.max(1))
}

/// Groups nodes by submodel, by label, and by optical coating.
pub(super) fn add_groups(table: &NodeTable, place: &[Option<usize>], deck: &mut Deck) {
    let mut submodels: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    let mut labels: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    // Bits order the coatings, since floats have no order of their own.
    let mut coatings: BTreeMap<(u64, u64), Vec<usize>> = BTreeMap::new();
    for (node, place) in table.rows.iter().zip(place) {
        let Some(place) = *place else { continue };
        if !node.path.is_empty() {
            submodels.entry(&node.path).or_default().push(place);
        }
        if !node.label.is_empty() {
            labels.entry(&node.label).or_default().push(place);
        }
        if node.area > 0.0 && (node.emissivity > 0.0 || node.absorptivity > 0.0) {
            let coating = (node.absorptivity.to_bits(), node.emissivity.to_bits());
            coatings.entry(coating).or_default().push(place);
        }
    }
    let mut used = HashSet::new();
    for (path, members) in submodels {
        add_group(path.to_owned(), members, &mut used, deck);
    }
    for (label, members) in labels {
        add_group(label.to_owned(), members, &mut used, deck);
    }
    for ((absorptivity, emissivity), members) in coatings {
        let name = format!("alpha {} epsilon {}", f64::from_bits(absorptivity), f64::from_bits(emissivity));
        add_group(name, members, &mut used, deck);
    }
}
