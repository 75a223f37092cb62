//! The file of an ESATAN-TMS thermal model's data, `.TMD`: HDF5 with the model and its results at each instant.
//!
//! The layout was read off two public files of ESATAN-TMS 2018 sp1: `DISCTR_TRANSIENT.TMD` of
//! `pycanha-project/pycanha-core` and `GSG_SAT_POLAR.TMD` of `harper25/ESATAN_PostProcessing`.

mod conductors;
mod nodes;
mod store;

use std::collections::HashSet;

use hdf5_reader::group::Group;

use crate::esatan::rows::{number_or_input, rows_of};
use crate::identifier::{Identifiers, unique};
use crate::{Deck, DeckError, Load, Node, NodeKind, Note, Record};

use nodes::{NodeRow, NodeTable};

/// The analysis whose model is read: files hold one.
const ANALYSIS: &str = "AnalysisSet1";
/// The solution whose results are read.
const SOLUTION: &str = "DataGroup1";

/// Reads a thermal model and its results from the bytes of a `.TMD` file.
///
/// Inactive nodes (type X) and their conductors are left out. Heat, boundary temperatures, capacities and conductances
/// that vary from row to row become inputs; others become numbers. Nodes are grouped by submodel, label and optical
/// coating.
///
/// # Errors
///
/// A file that is damaged, lacks a part of the model, holds kinds of nodes or conductors that are not understood, or is
/// larger than what is read: 65 536 nodes, 524 288 conductors of a kind, 8 388 608 temperatures.
pub fn read_tmd(name: &str, bytes: &[u8]) -> Result<Deck, DeckError> {
    // The library is meant to return an error on every damaged file. Should it panic on one, the file is refused all
    // the same: it borrows the bytes alone, so that nothing half-changed is left.
    let reading = std::panic::catch_unwind(|| read(bytes));
    let message = match reading {
        Ok(Ok(deck)) => return Ok(deck),
        Ok(Err(message)) => message,
        Err(_) => "the file is damaged: its structure cannot be followed; copy it anew from its origin".to_owned(),
    };
    Err(DeckError::of(name, message))
}

fn read(bytes: &[u8]) -> Result<Deck, String> {
    let unreadable = |error| format!("not a readable HDF5 file ({error}); copy it anew from its origin");
    let root = store::open(bytes).and_then(|file| file.root_group()).map_err(unreadable)?;
    let open = |group: &Group, name: &str| {
        group.group(name).map_err(|error| format!("no group `{name}` ({error}); a `.TMD` of ESATAN-TMS holds one"))
    };
    let analysis = open(&root, ANALYSIS)?;
    let solution = open(&analysis, SOLUTION)?;
    let mut deck = Deck {
        title: text(&analysis, "Description").or_else(|| text(&root, "Description")).unwrap_or_default(),
        tool: text(&solution, "ESATAN_version").map_or("ESATAN-TMS".to_owned(), |v| format!("ESATAN-TMS {v}")),
        stefan_boltzmann: number(&analysis, "StefanBoltzmann")?,
        ..Deck::default()
    };
    if deck.stefan_boltzmann.is_some_and(|sigma| !(sigma > 0.0)) {
        return Err("its Stefan-Boltzmann constant is not positive".to_owned());
    }
    let zero_k = number(&analysis, "TAbs")?
        .ok_or_else(|| format!("`{ANALYSIS}` lacks the attribute `TAbs`, the zero of its temperatures in K"))?;
    conductors::look_for_others(&root, &analysis, &mut deck.notes)?;

    let mut table = nodes::read(&analysis, &solution, zero_k)?;
    let has_capacity = table.rows.iter().any(|row| matches!(row.kind, 'D') && row.capacity.iter().any(|&c| c > 0.0));
    let rows = rows_of(&table.times_s, has_capacity, &mut deck.notes)?;
    for row in &mut table.rows {
        row.keep(&rows.kept);
    }
    deck.record = Some(Record { times_s: rows.times_s, is_steady: rows.is_steady, ..Record::default() });

    let mut identifiers = Identifiers::default();
    let place = add_nodes(&table, &mut identifiers, &mut deck)?;
    nodes::add_groups(&table, &place, &mut deck);
    for kind in conductors::KINDS {
        conductors::read(&kind, &analysis, &solution, &table, &place, &rows.kept, &mut identifiers, &mut deck)?;
    }
    Ok(deck)
}

/// Adds nodes with their loads; the place of each of the file's nodes in [`Deck::nodes`], none for inactive ones.
fn add_nodes(table: &NodeTable, identifiers: &mut Identifiers, deck: &mut Deck) -> Result<Vec<Option<usize>>, String> {
    let mut names = HashSet::new();
    let mut place = Vec::with_capacity(table.rows.len());
    let mut inactive = 0;
    let mut heated_boundaries = 0;
    for node in &table.rows {
        if node.kind == 'X' {
            inactive += 1;
            place.push(None);
            continue;
        }
        if !names.insert(node.name.as_str()) {
            return Err(format!("node {} occurs twice", node.name));
        }
        let kind = kind_of(node, identifiers, deck)?;
        let is_heated = node.heat_w.iter().any(|&heat| heat != 0.0);
        let is_boundary = matches!(kind, NodeKind::Boundary { .. });
        if is_heated && is_boundary {
            heated_boundaries += 1;
        } else if is_heated {
            let input = || (format!("heat_{}", node.name), "W", format!("Heat into node {}", node.described()));
            let power = number_or_input(node.heat_w.clone(), input, identifiers, deck);
            deck.loads.push(Load { name: format!("Q({})", node.name), into: deck.nodes.len(), power });
        }
        place.push(Some(deck.nodes.len()));
        if let Some(record) = &mut deck.record {
            record.temperatures_k.push(node.temperature_k.clone());
        }
        deck.nodes.push(Node {
            name: node.name.clone(),
            label: (!node.label.is_empty()).then(|| node.label.clone()),
            kind,
            initial_temperature_k: node.temperature_k.first().copied(),
        });
    }
    let mut note = |count: usize, message: &str| {
        if count > 0 {
            deck.notes.push(Note::new(format!("{count} {message}")));
        }
    };
    note(inactive, "inactive nodes (type X) are left out with their conductors.");
    note(heated_boundaries, "boundary nodes have a heat of their own, which changes nothing and is left out.");
    Ok(place)
}

fn kind_of(node: &NodeRow, identifiers: &mut Identifiers, deck: &mut Deck) -> Result<NodeKind, String> {
    match node.kind {
        'B' => {
            let input =
                || (format!("temperature_{}", node.name), "K", format!("Temperature of node {}", node.described()));
            Ok(NodeKind::Boundary {
                temperature: number_or_input(node.temperature_k.clone(), input, identifiers, deck),
            })
        }
        'D' if node.capacity.iter().all(|&capacity| capacity == 0.0) => Ok(NodeKind::Arithmetic),
        'D' if node.capacity.iter().all(|&capacity| capacity > 0.0) => {
            let input = || (format!("capacity_{}", node.name), "J/K", format!("Capacity of node {}", node.described()));
            Ok(NodeKind::Diffusion { capacity: number_or_input(node.capacity.clone(), input, identifiers, deck) })
        }
        'D' => Err(format!("node {} has capacities that are negative, or zero at times only", node.name)),
        other => Err(format!(
            "node {} is of type {other}; nodes of types D, B and X are read: take fluid loops out of the model first",
            node.name
        )),
    }
}

/// A text attribute, if there is one with a text in it.
fn text(group: &Group, name: &str) -> Option<String> {
    let text = group.attribute(name).and_then(|attribute| attribute.read_strings()).ok()?.into_iter().next()?;
    let text = store::trimmed(text.as_bytes());
    (!text.is_empty()).then_some(text)
}

/// A finite number of an attribute, if there is the attribute.
fn number(group: &Group, name: &str) -> Result<Option<f64>, String> {
    let Ok(attribute) = group.attribute(name) else { return Ok(None) };
    match attribute.read_as_f64() {
        Ok(value) if value.is_finite() => Ok(Some(value)),
        _ => Err(format!("the attribute `{name}` is not a finite number")),
    }
}

/// Adds a group unless it is empty or holds every node.
fn add_group(name: String, members: Vec<usize>, used: &mut HashSet<String>, deck: &mut Deck) {
    if !members.is_empty() {
        let name = unique(used, name, "#");
        deck.groups.push(crate::Group { name, nodes: members, couplings: Vec::new() });
    }
}
