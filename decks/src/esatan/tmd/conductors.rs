//! Conductors of a `.TMD` file.

use std::collections::{BTreeMap, HashSet};

use hdf5_reader::group::Group;

use crate::esatan::rows::number_or_input;
use crate::identifier::{Identifiers, unique};
use crate::{Coupling, CouplingKind, Deck, Note, Value};

use super::nodes::NodeTable;
use super::store::Table;
use super::{ANALYSIS, SOLUTION};

/// Most conductors of a kind.
const CONDUCTORS: usize = 1 << 19;
/// Most values of conductances that vary.
const VARYING_VALUES: usize = 1 << 24;
/// Most instants.
const ROWS: usize = 1 << 20;

/// A kind of conductors with its names in the file.
pub(super) struct Kind {
    /// GL, GR.
    short: &'static str,
    law: CouplingKind,
    unit: &'static str,
}

/// The kinds that are read.
pub(super) const KINDS: [Kind; 2] = [
    Kind { short: "GL", law: CouplingKind::Linear, unit: "W/K" },
    Kind { short: "GR", law: CouplingKind::Radiative, unit: "m2" },
];

/// Refuses conductors of other kinds, and notes analyses and solutions that are not read.
pub(super) fn look_for_others(root: &Group, analysis: &Group, notes: &mut Vec<Note>) -> Result<(), String> {
    let unreadable = |error| format!("its list of contents cannot be read: {error}");
    let (analyses, _) = root.member_names().map_err(unreadable)?;
    let (solutions, tables) = analysis.member_names().map_err(unreadable)?;
    for name in analyses.iter().filter(|name| *name != ANALYSIS).chain(solutions.iter().filter(|n| *n != SOLUTION)) {
        notes.push(Note::new(format!("`{name}` is left out: `{ANALYSIS}/{SOLUTION}` is read.")));
    }
    let is_other = |name: &&String| {
        name.strip_prefix("conductors").is_some_and(|short| KINDS.iter().all(|kind| kind.short != short))
    };
    match tables.iter().find(is_other) {
        Some(name) => Err(format!(
            "it holds `{name}`; conductors GL and GR are read: take other kinds out of the model, or give them as GL"
        )),
        None => Ok(()),
    }
}

/// Adds the conductors of one kind between active nodes.
pub(super) fn read(
    kind: &Kind,
    analysis: &Group,
    solution: &Group,
    nodes: &NodeTable,
    place: &[Option<usize>],
    kept: &[usize],
    identifiers: &mut Identifiers,
    deck: &mut Deck,
) -> Result<(), String> {
    let short = kind.short;
    let pairs = Table::open(analysis, &format!("conductors{short}"), &[CONDUCTORS, 4])?;
    pairs.expect(1, 4, "two nodes and two submodels")?;
    let count = pairs.shape()[0];
    if count == 0 {
        return Ok(());
    }
    let pairs = pairs.all::<i32>()?;
    let mut series = read_values(kind, solution, nodes.times_s.len(), count)?;
    let mut used = HashSet::new();
    let (mut to_itself, mut negative) = (0_usize, 0_usize);
    for (conductor, row) in pairs.chunks_exact(4).enumerate() {
        let mut ends = [0_usize; 2];
        for (end, (&index, &model)) in ends.iter_mut().zip(row[..2].iter().zip(&row[2..])) {
            let position = usize::try_from(index).ok().and_then(|index| index.checked_sub(1));
            *end = position.filter(|&position| position < nodes.rows.len()).ok_or_else(|| {
                format!("{short} {} joins node number {index} of {} in order", conductor + 1, nodes.rows.len())
            })?;
            let node = &nodes.rows[*end];
            if node.model != model {
                return Err(format!(
                    "{short} {} joins node {} in submodel {model}, but that node is in submodel {}",
                    conductor + 1,
                    node.name,
                    node.model
                ));
            }
        }
        let (Some(from), Some(to)) = (place[ends[0]], place[ends[1]]) else { continue };
        if from == to {
            to_itself += 1;
            continue;
        }
        let name = format!("{short}({},{})", nodes.rows[ends[0]].name, nodes.rows[ends[1]].name);
        let name = unique(&mut used, name, "#");
        let first = series.first[conductor];
        let value = match series.varying.remove(&conductor) {
            None => Value::Number(first),
            Some(values) => {
                let values: Vec<f64> = kept.iter().filter_map(|&row| values.get(row).copied()).collect();
                let input = || (name.clone(), kind.unit, format!("Value of {name}"));
                number_or_input(values, input, identifiers, deck)
            }
        };
        negative += usize::from(first < 0.0);
        deck.couplings.push(Coupling { name, kind: kind.law, between: [from, to], value });
    }
    for (count, what) in [(to_itself, "join a node to itself and are left out"), (negative, "start with a value < 0")] {
        if count > 0 {
            deck.notes.push(Note::new(format!("{count} conductors {short} {what}.")));
        }
    }
    Ok(())
}

/// Values of conductors: the first of each, and all of those that vary.
struct Series {
    first: Vec<f64>,
    varying: BTreeMap<usize, Vec<f64>>,
}

fn read_values(kind: &Kind, solution: &Group, instants: usize, count: usize) -> Result<Series, String> {
    let short = kind.short;
    let table = Table::open(solution, &format!("conductorData{short}"), &[ROWS, CONDUCTORS, 8])?;
    table.expect(0, instants, "`times`")?;
    table.expect(1, count, &format!("`conductors{short}`"))?;
    table.expect(2, 2, "value and state")?;
    let mut series = Series { first: Vec::new(), varying: BTreeMap::new() };
    table.each_row(|row, values: &[f64]| {
        for (conductor, pair) in values.chunks_exact(2).enumerate() {
            let [value, state] = [pair[0], pair[1]];
            if !value.is_finite() {
                return Err(format!("{short} {} is not finite in row {}", conductor + 1, row + 1));
            }
            // Every public file has 1 here.
            if state != 1.0 {
                return Err(format!("{short} {} has the state {state} in row {}, not 1", conductor + 1, row + 1));
            }
            if row == 0 {
                series.first.push(value);
            } else if let Some(values) = series.varying.get_mut(&conductor) {
                values.push(value);
            } else if value != series.first[conductor] {
                if (series.varying.len() + 1).saturating_mul(instants) > VARYING_VALUES {
                    return Err(format!("more than {VARYING_VALUES} values of {short} vary; write out fewer instants"));
                }
                let mut values = vec![series.first[conductor]; row];
                values.push(value);
                series.varying.insert(conductor, values);
            }
        }
        Ok(())
    })?;
    Ok(series)
}
