//! Couplings of a deck as elements of a study: conductors, radiations, and flows for what neither may be.

use bmv_decks::{Coupling, CouplingKind, Deck, NodeKind, Value};

use crate::batch::next_pass::text::Item;
use crate::study::model::tabulated::product;

use super::model::Written;
use super::name::{Names, renamed};

/// More couplings of a kind stand in a table.
const MOST_OBJECTS: usize = 50;

/// What a coupling became: its name there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Became {
    /// A conductor.
    Conductor(String),
    /// A radiation.
    Radiation(String),
    /// A flow.
    Flow,
    /// It is left out.
    Nothing,
}

/// The couplings of a study.
#[derive(Debug, Default)]
pub(super) struct Couplings {
    /// Of each coupling of the deck what it became.
    pub became: Vec<Became>,
    /// Entries of `conductors` and `radiations`.
    pub objects: [Vec<(String, Item)>; 2],
    /// Tables of the same, where there are many.
    pub tables: [Option<String>; 2],
    /// Entries of `flows`.
    pub flows: Vec<(String, Item)>,
    /// What was changed or left out, in sentences.
    pub notes: Vec<String>,
}

/// One that is a conductor or radiation.
struct Passive<'d> {
    coupling: &'d Coupling,
    name: String,
}

/// The couplings of a deck; radiative values are multiplied by `area_factor`.
pub(super) fn couplings(deck: &Deck, written: &Written, area_factor: f64) -> Couplings {
    let mut couplings = Couplings::default();
    let mut names = [Names::default(), Names::default(), Names::default()];
    let mut passive: [Vec<Passive>; 2] = [Vec::new(), Vec::new()];
    let (mut loops, mut into_boundaries, mut negative) = (0, 0, 0);
    let is_boundary = |node: usize| matches!(deck.nodes[node].kind, NodeKind::Boundary { .. });
    for coupling in &deck.couplings {
        let [a, b] = coupling.between;
        let is_negative = match &coupling.value {
            Value::Number(value) => *value < 0.0,
            Value::Scaled { parameter, factor } => written.nominal(parameter) * factor < 0.0,
            Value::Expression(_) => false,
        };
        let one_way = coupling.kind == CouplingKind::OneWay;
        couplings.became.push(if a == b {
            loops += 1;
            Became::Nothing
        } else if one_way && is_boundary(b) {
            into_boundaries += 1;
            Became::Nothing
        } else if is_negative || (one_way && !is_boundary(a)) {
            negative += usize::from(is_negative);
            let factor = if coupling.kind == CouplingKind::Radiative { area_factor } else { 1.0 };
            let value = written.text(&coupling.value, factor);
            let heat = match coupling.kind {
                CouplingKind::Radiative => format!("sigma * {value} * (Ta^4 - Tb^4)"),
                CouplingKind::Linear | CouplingKind::OneWay => format!("{value} * (Ta - Tb)"),
            };
            let mut entries = vec![("between", written.ends(coupling)), ("heat", Item::text(&heat))];
            entries.extend(one_way.then(|| ("one_way", Item::Raw("true".to_owned()))));
            couplings.flows.push((names[2].label(&coupling.name), object(entries)));
            Became::Flow
        } else {
            // A flow out of a boundary takes its heat from nowhere anyway.
            let kind = usize::from(coupling.kind == CouplingKind::Radiative);
            let name = names[kind].label(&coupling.name);
            passive[kind].push(Passive { coupling, name: name.clone() });
            if kind == 0 { Became::Conductor(name) } else { Became::Radiation(name) }
        });
    }
    for (kind, list) in passive.into_iter().enumerate() {
        let (value, unit, factor) = [("conductance", "W/K", 1.0), ("exchange_area", "m2", area_factor)][kind];
        let (rows, objects): (Vec<Passive>, Vec<Passive>) =
            (list.into_iter()).partition(|row| !matches!(row.coupling.value, Value::Expression(_)));
        let (rows, more) = if rows.len() > MOST_OBJECTS { (rows, Vec::new()) } else { (Vec::new(), rows) };
        couplings.objects[kind] = (more.into_iter().chain(objects))
            .map(|row| {
                let entries =
                    vec![("between", written.ends(row.coupling)), (value, written.scalar(&row.coupling.value, factor))];
                (row.name, object(entries))
            })
            .collect();
        couplings.tables[kind] = (!rows.is_empty()).then(|| table(&rows, unit, factor, written));
    }
    let is_renamed = |(coupling, became): &(&Coupling, &Became)| match became {
        Became::Conductor(name) | Became::Radiation(name) => *name != coupling.name,
        Became::Flow | Became::Nothing => false,
    };
    let renamed = deck.couplings.iter().zip(&couplings.became).filter(is_renamed).count();
    let notes = [
        (renamed, "couplings have names with `_` for what the study format does not allow in names"),
        (loops, "couplings of a node with itself are left out: they carry no heat"),
        (into_boundaries, "one-way couplings into boundary nodes are left out: they change no temperature"),
        (negative, "couplings with a value below 0 are flows: a conductor or radiation has none"),
    ];
    couplings.notes =
        (notes.into_iter()).filter(|(count, _)| *count > 0).map(|(count, note)| format!("{count} {note}")).collect();
    couplings
}

fn object(entries: Vec<(&str, Item)>) -> Item {
    Item::Object(entries.into_iter().map(|(key, item)| (key.to_owned(), item)).collect())
}

/// A table of couplings as the study format reads it.
fn table(rows: &[Passive], unit: &str, scale: f64, written: &Written) -> String {
    let mut text = format!("name,from,to,value [{unit}],parameter,factor\n");
    for row in rows {
        let [from, to] = row.coupling.between.map(|end| cell(written.node(end)));
        let value = match &row.coupling.value {
            Value::Number(value) => format!("{},,", number(value * scale)),
            Value::Scaled { parameter, factor } => {
                format!(",{},{}", written.symbol(parameter), number(factor * scale))
            }
            // Expressions stand in objects.
            Value::Expression(_) => continue,
        };
        text.push_str(&format!("{},{from},{to},{value}\n", cell(&row.name)));
    }
    text
}

/// A number with as few digits as read back to it; nothing for what is not finite.
pub(super) fn number(value: f64) -> String {
    crate::document::canonical::float(value).unwrap_or_default()
}

/// A text as a cell of a CSV file.
pub(super) fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

impl Written {
    /// The two nodes of a coupling.
    fn ends(&self, coupling: &Coupling) -> Item {
        Item::List(coupling.between.iter().map(|&end| Item::text(self.node(end))).collect())
    }

    /// A value times a number as the study format writes it.
    pub(super) fn scalar(&self, value: &Value, scale: f64) -> Item {
        match value {
            Value::Number(value) => Item::number(value * scale),
            Value::Expression(text) if scale == 1.0 => Item::text(&renamed(text, &self.symbols)),
            Value::Scaled { .. } | Value::Expression(_) => Item::text(&self.text(value, scale)),
        }
    }

    /// The same as a factor of a longer expression.
    fn text(&self, value: &Value, scale: f64) -> String {
        match value {
            Value::Number(value) => match value * scale {
                negative if negative < 0.0 => format!("({})", number(negative)),
                other => number(other),
            },
            Value::Scaled { parameter, factor } => product(self.symbol(parameter), factor * scale),
            Value::Expression(text) => product(&format!("({})", renamed(text, &self.symbols)), scale),
        }
    }
}
