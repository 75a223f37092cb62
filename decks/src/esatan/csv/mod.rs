//! Dumps of nodes, conductors and temperatures as CSV, as ESATAN writes them from an output block.
//!
//! The layout was read off the public dumps of `mlauryn/EsatanOpt`, written by ESATAN 2017 sp2: a title, a blank line,
//! the names of columns, and a row an instant. `T12` is a quantity of node 12; `GL:(1;2)` is a conductor, which stands
//! there a second time as `GL:(2;1)`.

mod dump;

use std::collections::{BTreeMap, BTreeSet, HashSet};

use crate::CELSIUS_ZERO_K;
use crate::esatan::DEFAULT_STEFAN_BOLTZMANN;
use crate::esatan::rows::{Rows, number_or_input, rows_of};
use crate::identifier::Identifiers;
use crate::{Coupling, CouplingKind, Deck, DeckError, Group, Load, Node, NodeKind, Note, Record};

use dump::{Column, Dump, Values, described};

/// Heats of a node, which add.
const HEATS: [&str; 5] = ["QS", "QA", "QE", "QI", "QR"];
/// Both values of a pair agree within this, relative to them: they are written with 16 digits.
const PAIR_SCATTER: f64 = 1e-9;
/// Node that ESATAN-TMS adds to its models for surfaces that are inactive.
const INACTIVE: (u32, &str) = (99_998, "INACTIVE_NODE");
/// Node that ESATAN-TMS adds for the environment.
const ENVIRONMENT: (u32, &str) = (99_999, "ENVIRONMENT");

/// Reads the dumps of one model, each a name and a text: nodes, conductors and temperatures, together or apart.
///
/// A dump with one row holds for all rows of the others. Dumps do not tell the kinds of nodes: the environment's node
/// is a boundary, nodes with a capacity are diffusion nodes, others are arithmetic ones. Without any capacity the rows
/// are steady cases.
///
/// # Errors
///
/// Lines that are not understood, pairs whose two directions disagree, dumps whose rows do not belong together, and a
/// model without conductors, or whose environment has no temperature.
pub fn read_csv(files: &[(String, String)]) -> Result<Deck, Vec<DeckError>> {
    let mut errors = Vec::new();
    let mut dumps = Vec::new();
    for (file, text) in files {
        match dump::parse(file, text) {
            Ok(dump) => dumps.push((file.as_str(), dump)),
            Err(more) => errors.extend(more),
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let first_file = files.first().map(|(file, _)| file.as_str()).unwrap_or_default();
    if dumps.is_empty() {
        return Err(vec![DeckError::of(first_file, "no dump is given")]);
    }
    assemble(&dumps).map_err(|error| vec![error])
}

/// Columns of all dumps.
struct Columns<'a> {
    /// Numbers with the file they come from and its lines.
    numbers: BTreeMap<&'a Column, (&'a str, &'a Dump, &'a [f64])>,
    labels: BTreeMap<u32, &'a str>,
    /// The number of rows.
    rows: usize,
}

impl Columns<'_> {
    /// Values of a column, one a row.
    fn series(&self, column: &Column) -> Option<Vec<f64>> {
        let (_, _, values) = self.numbers.get(column)?;
        Some(match values {
            [value] => vec![*value; self.rows],
            values => values.to_vec(),
        })
    }

    fn quantity(&self, quantity: &str, node: u32) -> Option<Vec<f64>> {
        self.series(&Column::Node(quantity.to_owned(), node))
    }

    fn is(&self, node: u32, special: (u32, &str)) -> bool {
        match self.labels.get(&node) {
            Some(label) => label.eq_ignore_ascii_case(special.1),
            None => node == special.0,
        }
    }
}

fn collect<'a>(dumps: &'a [(&'a str, Dump)], times_s: &[f64], notes: &mut Vec<Note>) -> Result<Columns<'a>, DeckError> {
    let mut columns = Columns { numbers: BTreeMap::new(), labels: BTreeMap::new(), rows: times_s.len() };
    let mut replaced = 0;
    for (file, dump) in dumps {
        if dump.times_s.len() > 1 && dump.times_s != times_s {
            let message = "its rows have other times than those of another dump; give dumps of one run";
            return Err(DeckError::at(file, dump.lines[0], message));
        }
        for (column, values) in &dump.columns {
            match (column, values) {
                (Column::Node(_, node), Values::Texts(texts)) => {
                    let label = texts.first().map(String::as_str).unwrap_or_default();
                    columns.labels.insert(*node, label);
                }
                (_, Values::Numbers(numbers)) => {
                    match columns.numbers.get(column) {
                        Some((_, _, other)) if other.len() == numbers.len() && *other != numbers.as_slice() => {
                            let message = format!("{} has other values in another dump", described(column));
                            return Err(DeckError::at(file, dump.header_line, message));
                        }
                        Some((_, _, other)) => {
                            replaced += usize::from(other.len() != numbers.len());
                            if other.len() > numbers.len() {
                                continue;
                            }
                        }
                        None => {}
                    }
                    columns.numbers.insert(column, (file, dump, numbers));
                }
                _ => {}
            }
        }
    }
    if replaced > 0 {
        let message = format!("{replaced} quantities stand in two dumps: those with more rows are read.");
        notes.push(Note::new(message));
    }
    Ok(columns)
}

fn assemble(dumps: &[(&str, Dump)]) -> Result<Deck, DeckError> {
    let mut deck = Deck { stefan_boltzmann: Some(DEFAULT_STEFAN_BOLTZMANN), ..Deck::default() };
    let mut longest = &dumps[0];
    for dump in dumps {
        if dump.1.times_s.len() > longest.1.times_s.len() {
            longest = dump;
        }
        if dump.1.model != dumps[0].1.model {
            let message = format!("It is of model {}, not of {} as {}.", dump.1.model, dumps[0].1.model, dumps[0].0);
            deck.notes.push(Note::at(dump.0, message));
        }
    }
    deck.title = longest.1.model.clone();
    deck.tool = longest.1.tool.clone();
    let columns = collect(dumps, &longest.1.times_s, &mut deck.notes)?;
    let capacity = |node: u32| columns.quantity("C", node);
    let numbers: BTreeSet<u32> = columns
        .numbers
        .keys()
        .filter_map(|column| if let Column::Node(_, node) = column { Some(*node) } else { None })
        .chain(columns.labels.keys().copied())
        .collect();
    let has_capacity = numbers.iter().any(|&node| capacity(node).is_some_and(|c| c.iter().any(|&c| c > 0.0)));
    let rows = rows_of(&longest.1.times_s, has_capacity, &mut deck.notes)
        .map_err(|message| DeckError::at(longest.0, longest.1.header_line, message))?;
    deck.record = Some(Record { times_s: rows.times_s.clone(), is_steady: rows.is_steady, ..Record::default() });
    let mut identifiers = Identifiers::default();
    let place = add_nodes(&numbers, &columns, &rows, longest, &mut identifiers, &mut deck)?;
    add_couplings(&columns, &rows, &place, &mut identifiers, &mut deck)?;
    if deck.couplings.is_empty() {
        let message = "there is no conductor in the dumps; give the one with `GL:(1;2)` too";
        return Err(DeckError::of(longest.0, message));
    }
    let message = if has_capacity {
        "Dumps do not tell the kinds of nodes: the environment is a boundary, nodes without a capacity are arithmetic."
    } else {
        "The dumps hold no capacities: all nodes but the environment are arithmetic, which is right in steady cases."
    };
    deck.notes.push(Note::new(message));
    let message = format!(
        "Dumps state no Stefan-Boltzmann constant: {DEFAULT_STEFAN_BOLTZMANN:e} W/(m2 K4) is taken, that of ESATAN 2017."
    );
    deck.notes.push(Note::new(message));
    Ok(deck)
}

fn kept(series: Vec<f64>, rows: &Rows) -> Vec<f64> {
    rows.kept.iter().filter_map(|&row| series.get(row).copied()).collect()
}

/// Adds nodes, their loads and groups of one label; the place of each node that is not inactive.
fn add_nodes(
    numbers: &BTreeSet<u32>,
    columns: &Columns,
    rows: &Rows,
    longest: &(&str, Dump),
    identifiers: &mut Identifiers,
    deck: &mut Deck,
) -> Result<BTreeMap<u32, Option<usize>>, DeckError> {
    let mut place = BTreeMap::new();
    let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for &number in numbers {
        if columns.is(number, INACTIVE) {
            place.insert(number, None);
            let message = format!("Node {number} is inactive: it is left out with its conductors.");
            deck.notes.push(Note::new(message));
            continue;
        }
        let temperature_k: Option<Vec<f64>> = columns
            .quantity("T", number)
            .map(|series| kept(series, rows).into_iter().map(|celsius| celsius + CELSIUS_ZERO_K).collect());
        let label = columns.labels.get(&number).copied().filter(|label| !label.is_empty());
        let described = label.map_or(number.to_string(), |label| format!("{number} ({label})"));
        let kind = if columns.is(number, ENVIRONMENT) {
            let Some(series) = temperature_k.clone() else {
                let message = format!("node {number}, the environment, has no temperature; dump `T` of all nodes too");
                return Err(DeckError::at(longest.0, longest.1.header_line, message));
            };
            let input = || (format!("temperature_{number}"), "K", format!("Temperature of node {described}"));
            NodeKind::Boundary { temperature: number_or_input(series, input, identifiers, deck) }
        } else {
            let series = kept(columns.quantity("C", number).unwrap_or_default(), rows);
            if series.iter().all(|&capacity| capacity == 0.0) {
                NodeKind::Arithmetic
            } else if series.iter().all(|&capacity| capacity > 0.0) {
                let input = || (format!("capacity_{number}"), "J/K", format!("Capacity of node {described}"));
                NodeKind::Diffusion { capacity: number_or_input(series, input, identifiers, deck) }
            } else {
                let message = format!("C{number} is negative, or zero in some rows only");
                return Err(DeckError::at(longest.0, longest.1.header_line, message));
            }
        };
        if !matches!(kind, NodeKind::Boundary { .. }) {
            let mut heat_w = vec![0.0; rows.kept.len()];
            for series in HEATS.iter().filter_map(|heat| columns.quantity(heat, number)) {
                for (sum, value) in heat_w.iter_mut().zip(kept(series, rows)) {
                    *sum += value;
                }
            }
            if heat_w.iter().any(|&heat| heat != 0.0) {
                let input = || (format!("heat_{number}"), "W", format!("Heat into node {described}"));
                let power = number_or_input(heat_w, input, identifiers, deck);
                deck.loads.push(Load { name: format!("Q({number})"), into: deck.nodes.len(), power });
            }
        }
        place.insert(number, Some(deck.nodes.len()));
        if let Some(label) = label {
            groups.entry(label).or_default().push(deck.nodes.len());
        }
        let initial_temperature_k = temperature_k.as_ref().and_then(|series| series.first().copied());
        if let Some(record) = &mut deck.record {
            record.temperatures_k.push(temperature_k.unwrap_or_default());
        }
        let label = label.map(str::to_owned);
        deck.nodes.push(Node { name: number.to_string(), label, kind, initial_temperature_k });
    }
    let groups = groups.into_iter().map(|(name, nodes)| Group { name: name.to_owned(), nodes, couplings: Vec::new() });
    deck.groups.extend(groups);
    Ok(place)
}

/// Adds each pair of nodes once, after a comparison of its two directions.
fn add_couplings(
    columns: &Columns,
    rows: &Rows,
    place: &BTreeMap<u32, Option<usize>>,
    identifiers: &mut Identifiers,
    deck: &mut Deck,
) -> Result<(), DeckError> {
    let mut done = HashSet::new();
    let mut one_way = 0;
    for (&column, &(file, dump, values)) in &columns.numbers {
        let Column::Pair(short, from, to) = column else { continue };
        let fail = |message: String| DeckError::at(file, dump.header_line, message);
        let (kind, unit) = match short.as_str() {
            "GL" => (CouplingKind::Linear, "W/K"),
            "GR" => (CouplingKind::Radiative, "m2"),
            _ => return Err(fail(format!("{} is not read: GL and GR are", described(column)))),
        };
        if !done.insert((short, from.min(to), from.max(to))) {
            continue;
        }
        if from == to {
            return Err(fail(format!("{} joins a node to itself", described(column))));
        }
        let reverse = Column::Pair(short.clone(), *to, *from);
        match columns.numbers.get(&reverse) {
            None => one_way += 1,
            Some((_, _, other)) => {
                // Rows of both, where one dump has a single one for all.
                for row in 0..values.len().max(other.len()) {
                    let at = |series: &[f64]| series.get(row).or(series.first()).copied().unwrap_or(f64::NAN);
                    let (one, two) = (at(values), at(other));
                    if !((one - two).abs() <= PAIR_SCATTER * one.abs().max(two.abs())) {
                        let line = dump.lines.get(row).or(dump.lines.first()).copied().unwrap_or(dump.header_line);
                        let message =
                            format!("{} is {one:e}, but {} is {two:e}", described(column), described(&reverse));
                        return Err(DeckError::at(file, line, message));
                    }
                }
            }
        }
        let index = |node: &u32| {
            place
                .get(node)
                .copied()
                .ok_or_else(|| fail(format!("{} joins node {node}, which no dump lists", described(column))))
        };
        let (Some(start), Some(end)) = (index(from)?, index(to)?) else { continue };
        let series = kept(columns.series(column).unwrap_or_default(), rows);
        let name = format!("{short}({from},{to})");
        let input = || (name.clone(), unit, format!("Value of {name}"));
        let value = number_or_input(series, input, identifiers, deck);
        deck.couplings.push(Coupling { name, kind, between: [start, end], value });
    }
    if one_way > 0 {
        let message = format!("{one_way} pairs stand there in one direction only, and are read as if in both.");
        deck.notes.push(Note::new(message));
    }
    Ok(())
}
