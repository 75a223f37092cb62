//! Parts of a model, and what a calibration can use where a deck names neither contacts nor materials.
//!
//! A part is a set of nodes: those with numbers in ranges that the user states, else a submodel or a label of the deck.
//! Conductors within a part, and between two parts, get a factor of 1 each as a parameter; so do radiations between two
//! parts that matter to one of them, and all other radiations one together. Temperatures of boundaries and heats by
//! part become inputs, which a test sets.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use bmv_decks::{CouplingKind, Deck, Group, Input, NodeKind, Note, Parameter, Value};
use thiserror::Error;

use crate::document::visible::escaped;
use crate::math::sort::{sort_by, sort_by_key};

use super::name::Names;

/// Most factors of a kind; further couplings share the last one.
const MOST_FACTORS: usize = 24;
/// Most inputs of a kind.
const MOST_INPUTS: usize = 24;
/// Radiation between two parts has a factor of its own if it is this share of what one of them exchanges.
const SHARE_THAT_MATTERS: f64 = 0.1;
/// A boundary that is colder is space, and no input, K.
const SPACE_K: f64 = 10.0;

/// A range of node numbers that belongs to a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Range {
    part: String,
    /// Of nodes whose names have one: `SUB` of `SUB.12`.
    submodel: Option<String>,
    first: u64,
    last: u64,
    line: usize,
}

/// A list of parts that is not understood.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{file}:{line}:{column}: {reason}")]
pub struct PartsError {
    file: String,
    line: usize,
    column: usize,
    reason: String,
}

/// Ranges of a CSV file with the columns `part,first,last`, and `submodel` where numbers repeat.
///
/// # Errors
/// The first line that is not understood.
pub fn ranges(file: &str, text: &str) -> Result<Vec<Range>, PartsError> {
    let wrong = |line: usize, column: usize, reason: String| PartsError {
        file: escaped(file).into_owned(),
        line,
        column,
        reason,
    };
    let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    let (_, header) = lines.next().unwrap_or((0, ""));
    let header: Vec<&str> = header.split(',').map(str::trim).collect();
    let place = |name: &str| header.iter().position(|column| *column == name);
    let (Some(part), Some(first), Some(last)) = (place("part"), place("first"), place("last")) else {
        return Err(wrong(1, 1, "expected the columns `part,first,last`, as in `rim,1070,1099`".to_owned()));
    };
    let submodel = place("submodel");
    let mut ranges: Vec<Range> = Vec::new();
    for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let cells: Vec<&str> = line.split(',').collect();
        let column = |cell: usize| 1 + cells.iter().take(cell).map(|text| text.chars().count() + 1).sum::<usize>();
        if cells.len() != header.len() {
            let reason = format!("{} cells, but the header has {} columns", cells.len(), header.len());
            return Err(wrong(index + 1, 1, reason));
        }
        let number = |cell: usize| {
            cells[cell].trim().parse::<u64>().map_err(|_| {
                let reason = format!("`{}` is no node number: write a whole number", escaped(cells[cell].trim()));
                wrong(index + 1, column(cell), reason)
            })
        };
        let range = Range {
            part: cells[part].trim().to_owned(),
            submodel: submodel.map(|cell| cells[cell].trim().to_owned()).filter(|name| !name.is_empty()),
            first: number(first)?,
            last: number(last)?,
            line: index + 1,
        };
        if range.part.is_empty() {
            return Err(wrong(index + 1, column(part), "the part has no name".to_owned()));
        }
        if range.first > range.last {
            let reason = format!("the range ends at {}, before it begins at {}", range.last, range.first);
            return Err(wrong(index + 1, column(last), reason));
        }
        let overlaps =
            |other: &&Range| other.submodel == range.submodel && other.first <= range.last && range.first <= other.last;
        if let Some(other) = ranges.iter().find(overlaps) {
            let reason = format!("the range has numbers of line {} (`{}`)", other.line, escaped(&other.part));
            return Err(wrong(index + 1, column(first), reason));
        }
        ranges.push(range);
    }
    if ranges.is_empty() {
        return Err(wrong(2, 1, "no part is listed: write a line as `rim,1070,1099`".to_owned()));
    }
    Ok(ranges)
}

/// The part of each node of a deck, and the names of the parts.
struct Division {
    of: Vec<usize>,
    names: Vec<String>,
}

/// Divides a deck by ranges of node numbers.
///
/// # Errors
/// A range in which no node lies.
pub fn divide_by_ranges(deck: &mut Deck, file: &str, ranges: &[Range]) -> Result<(), PartsError> {
    let mut used = HashSet::new();
    let mut stated = vec![None; deck.nodes.len()];
    for (node, stated) in deck.nodes.iter().zip(&mut stated) {
        let (submodel, number) = node.name.rsplit_once('.').unwrap_or(("", &node.name));
        let Ok(number) = number.parse::<u64>() else { continue };
        let holds = |range: &&Range| {
            range.submodel.as_deref().is_none_or(|name| name == submodel)
                && (range.first..=range.last).contains(&number)
        };
        if let Some(range) = ranges.iter().find(holds) {
            used.insert(range.line);
            *stated = Some(range.part.clone());
        }
    }
    if let Some(range) = ranges.iter().find(|range| !used.contains(&range.line)) {
        let submodel = range.submodel.as_ref().map_or(String::new(), |name| format!("{}.", escaped(name)));
        return Err(PartsError {
            file: escaped(file).into_owned(),
            line: range.line,
            column: 1,
            reason: format!("no node of the deck is called {submodel}{} to {}", range.first, range.last),
        });
    }
    let count = stated.iter().filter(|part| part.is_none()).count();
    if count > 0 {
        // The note goes into the study, which is the same wherever the list lay.
        let name = Path::new(file).file_name().unwrap_or_default().to_string_lossy();
        deck.notes.push(Note::new(format!("{count} nodes are in no part of `{name}`: the deck's groups say theirs.")));
    }
    divide(deck, division(deck, &stated));
    Ok(())
}

/// Divides a deck by its own submodels and labels.
pub fn divide_by_groups(deck: &mut Deck) {
    let stated = vec![None; deck.nodes.len()];
    divide(deck, division(deck, &stated));
}

/// Parts as stated, else the first group of the deck that has a node, else `rest`.
fn division(deck: &Deck, stated: &[Option<String>]) -> Division {
    let mut names: Vec<String> = Vec::new();
    let mut of = Vec::with_capacity(deck.nodes.len());
    for (node, stated) in stated.iter().enumerate() {
        let group = deck.groups.iter().find(|group| group.nodes.contains(&node)).map(|group| group.name.as_str());
        let name = stated.as_deref().or(group).unwrap_or("rest");
        of.push(names.iter().position(|other| other == name).unwrap_or_else(|| {
            names.push(name.to_owned());
            names.len() - 1
        }));
    }
    Division { of, names }
}

fn divide(deck: &mut Deck, division: Division) {
    let mut symbols = Names::default();
    for name in (deck.inputs.iter().map(|entry| &entry.name))
        .chain(deck.parameters.iter().map(|entry| &entry.name))
        .chain(deck.tables.iter().map(|entry| &entry.name))
    {
        symbols.symbol(name);
    }
    add_groups(deck, &division);
    add_factors(deck, &division, CouplingKind::Linear, &mut symbols);
    add_factors(deck, &division, CouplingKind::Radiative, &mut symbols);
    add_boundaries(deck, &division, &mut symbols);
    add_heats(deck, &division, &mut symbols);
}

/// The parts as groups before those of the deck; of groups with the same nodes the first stays.
fn add_groups(deck: &mut Deck, division: &Division) {
    let of_part = |part: usize| (0..division.of.len()).filter(|&node| division.of[node] == part).collect();
    let parts = division.names.iter().enumerate();
    let mut groups: Vec<Group> =
        parts.map(|(part, name)| Group { name: name.clone(), nodes: of_part(part), couplings: Vec::new() }).collect();
    groups.append(&mut deck.groups);
    let is_inner = |node: &usize| !matches!(deck.nodes[*node].kind, NodeKind::Boundary { .. });
    let mut seen = HashSet::new();
    groups.retain(|group| {
        let mut inner: Vec<usize> = group.nodes.iter().copied().filter(is_inner).collect();
        inner.sort_unstable();
        !group.couplings.is_empty() || (!inner.is_empty() && seen.insert(inner))
    });
    deck.groups = groups;
}

/// Couplings that share a factor.
#[derive(Default)]
struct Class {
    couplings: Vec<usize>,
    total: f64,
}

fn add_factors(deck: &mut Deck, division: &Division, kind: CouplingKind, symbols: &mut Names) {
    let is_radiative = kind == CouplingKind::Radiative;
    let mut classes: BTreeMap<[usize; 2], Class> = BTreeMap::new();
    let mut of_part = vec![0.0; division.names.len()];
    for (index, coupling) in deck.couplings.iter().enumerate() {
        let Value::Number(value) = coupling.value else { continue };
        if coupling.kind != kind || coupling.between[0] == coupling.between[1] || !(value > 0.0) {
            continue;
        }
        let mut pair = coupling.between.map(|end| division.of[end]);
        pair.sort_unstable();
        for (position, &part) in pair.iter().enumerate() {
            if position == 0 || part != pair[0] {
                of_part[part] += value;
            }
        }
        let class = classes.entry(pair).or_default();
        class.couplings.push(index);
        class.total += value;
    }
    let matters = |pair: &[usize; 2], class: &Class| {
        let least = pair.iter().map(|&part| of_part[part]).fold(f64::INFINITY, f64::min);
        !is_radiative || (pair[0] != pair[1] && class.total >= SHARE_THAT_MATTERS * least)
    };
    let mut rest = Class::default();
    let mut own: Vec<([usize; 2], Class)> = Vec::new();
    let mut by_size: Vec<([usize; 2], Class)> = classes.into_iter().collect();
    sort_by(&mut by_size, |a, b| b.1.total.total_cmp(&a.1.total).then(a.0.cmp(&b.0)));
    for (pair, class) in by_size {
        if own.len() < MOST_FACTORS && matters(&pair, &class) {
            own.push((pair, class));
        } else {
            rest.couplings.extend(class.couplings);
            rest.total += class.total;
        }
    }
    sort_by_key(&mut own, |entry| entry.0);
    let (short, what, unit) = if is_radiative { ("GR", "radiations", "m2") } else { ("GL", "conductors", "W/K") };
    let of_own = own.into_iter().map(|([a, b], class)| {
        let (from, to) = (&division.names[a], &division.names[b]);
        if a == b {
            (format!("f_{short}_{from}"), format!("within {from}"), class)
        } else {
            (format!("f_{short}_{from}_{to}"), format!("between {from} and {to}"), class)
        }
    });
    let of_rest = (!rest.couplings.is_empty())
        .then(|| (format!("f_{short}_rest"), "within parts and between those that exchange little".to_owned(), rest));
    for (name, place, class) in of_own.chain(of_rest) {
        let name = symbols.symbol(&name);
        for &coupling in &class.couplings {
            let entry = &mut deck.couplings[coupling].value;
            if let Value::Number(factor) = *entry {
                *entry = Value::Scaled { parameter: name.clone(), factor };
            }
        }
        let count = class.couplings.len();
        let total = class.total;
        deck.parameters.push(Parameter {
            name,
            unit: "1".to_owned(),
            nominal: 1.0,
            description: format!("factor of the {count} {what} {place}, {total:.4} {unit} together in the deck"),
        });
    }
}

/// A new input, constant over the record.
fn add_input(deck: &mut Deck, input: Input) {
    if let Some(record) = &mut deck.record {
        record.inputs.push(vec![input.nominal; record.times_s.len()]);
    }
    deck.inputs.push(input);
}

/// Boundaries of a part that have one temperature become an input together.
fn add_boundaries(deck: &mut Deck, division: &Division, symbols: &mut Names) {
    let coupled: HashSet<usize> = deck.couplings.iter().flat_map(|coupling| coupling.between).collect();
    // Bits tell equal temperatures apart from others.
    let mut boundaries: BTreeMap<(usize, u64), Vec<usize>> = BTreeMap::new();
    for (index, node) in deck.nodes.iter().enumerate() {
        if let NodeKind::Boundary { temperature: Value::Number(kelvin) } = node.kind
            && kelvin >= SPACE_K
            && coupled.contains(&index)
        {
            boundaries.entry((division.of[index], kelvin.to_bits())).or_default().push(index);
        }
    }
    if boundaries.len() > MOST_INPUTS {
        deck.notes.push(Note::new(format!("{} boundary temperatures stay numbers.", boundaries.len())));
        return;
    }
    for ((part, bits), nodes) in boundaries {
        let part = &division.names[part];
        let name = symbols.symbol(&format!("T_{part}"));
        for node in nodes {
            let temperature = Value::Scaled { parameter: name.clone(), factor: 1.0 };
            deck.nodes[node].kind = NodeKind::Boundary { temperature };
        }
        let description = format!("temperature of {part}");
        add_input(deck, Input { name, unit: "K".to_owned(), nominal: f64::from_bits(bits), description });
    }
}

/// The constant heats of a part become an input, of which each node has its share.
fn add_heats(deck: &mut Deck, division: &Division, symbols: &mut Names) {
    let mut heats: BTreeMap<usize, Class> = BTreeMap::new();
    for (index, load) in deck.loads.iter().enumerate() {
        if let Value::Number(power_w) = load.power {
            let heat = heats.entry(division.of[load.into]).or_default();
            heat.couplings.push(index);
            heat.total += power_w;
        }
    }
    heats.retain(|_, heat| heat.total != 0.0);
    if heats.len() > MOST_INPUTS {
        deck.notes.push(Note::new(format!("the heats of {} parts stay numbers.", heats.len())));
        return;
    }
    for (part, heat) in heats {
        let part = &division.names[part];
        let name = symbols.symbol(&format!("Q_{part}"));
        for &load in &heat.couplings {
            let entry = &mut deck.loads[load].power;
            if let Value::Number(power_w) = *entry {
                *entry = Value::Scaled { parameter: name.clone(), factor: power_w / heat.total };
            }
        }
        let description = format!("heat into {part}, shared by its nodes as in the deck");
        add_input(deck, Input { name, unit: "W".to_owned(), nominal: heat.total, description });
    }
}
