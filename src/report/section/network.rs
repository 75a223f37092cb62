//! The model: its network as a diagram, and tables of nodes and elements.

mod marked;
mod parts;

use std::collections::BTreeSet;

use crate::document::counted;
use crate::expression::{Dependence, ExprId, Symbol};
use crate::report::number::{NONE, Shown, as_given, with_unit};
use crate::report::page::{Block, Cell, Column, Figure, Section, Table, Text};
use crate::report::plot::{Diagram, NodeShape, network};
use crate::report::view::PassReport;
use crate::thermal::element::{Drawing, Element};
use crate::thermal::{Model, NodeKind};

use super::comparison::{AtNodes, at_nodes};
use super::{Entry, prefix};

/// The section.
pub(super) const SECTION: Entry = Entry::plain(build);

/// The section on the model; of algebraic ones there is none.
fn build(report: &PassReport<'_>) -> Option<Section> {
    let model = report.model;
    if let Some(external) = &model.external {
        // A surrogate gives the parts of each output's error beside it, one for each parameter that is an error.
        let outputs = external.outputs.saturating_sub(external.errors.len());
        let words = format!(
            "This model is no network: {} gives {} for its parameters and inputs, in a steady state. The keys of the jobs hold what \
             it is.",
            external.description,
            counted(outputs, "output")
        );
        let blocks = vec![Block::paragraph(Text::with_names(&words))];
        return Some(Section { id: "model", title: "Thermal model".into(), blocks });
    }
    if model.nodes.is_empty() {
        return None;
    }
    let boundaries = model.nodes.iter().filter(|n| matches!(n.kind, NodeKind::Boundary { .. })).count();
    let mut blocks = Vec::new();
    if !model.title.trim().is_empty() {
        blocks.push(Block::Paragraph(Text::default().strong(model.title.clone())));
    }
    let words = format!(
        "The network has {}, {} of them at a given temperature, and {}.",
        counted(model.nodes.len(), "node"),
        boundaries,
        counted(model.elements.len(), "element")
    );
    blocks.push(Block::paragraph(words));
    blocks.extend(picture(report, false).map(Block::Figure));
    if let Some(parts) = parts::Parts::new(report) {
        blocks.extend(parts.tables(model));
        return Some(Section { id: "model", title: "Thermal model".into(), blocks });
    }
    blocks.push(nodes(model));
    if !model.elements.is_empty() {
        blocks.push(elements(model));
    }
    Some(Section { id: "model", title: "Thermal model".into(), blocks })
}

/// The picture of the network, with what a diagnosis finds missing and what the pass adopts; small for the first screen.
pub(super) fn picture(report: &PassReport<'_>, is_small: bool) -> Option<Figure> {
    let model = report.model;
    if model.nodes.is_empty() {
        return None;
    }
    let deviations = at_nodes(report);
    let (mut diagram, of) = match parts::Parts::new(report) {
        Some(parts) => {
            let mut diagram = parts.diagram(model)?;
            marked::mark(report, &mut diagram, |node| parts.part(node));
            colour(&mut diagram, deviations.as_ref(), |node| parts.part(node));
            (diagram, "by its parts")
        }
        None => {
            let mut diagram = diagram(model);
            marked::mark(report, &mut diagram, |node| node);
            colour(&mut diagram, deviations.as_ref(), |node| node);
            (diagram, "as it is solved")
        }
    };
    diagram.missing.retain(|own| own.from < diagram.nodes.len() && own.to < diagram.nodes.len());
    let what: Vec<&str> = [
        (!diagram.missing.is_empty()).then_some("what is missing is dashed on a yellow band"),
        (!(diagram.adopted.is_empty() && diagram.changed.is_empty()))
            .then_some("what adopted effects add or change lies on a yellow band"),
    ]
    .into_iter()
    .flatten()
    .collect();
    // In small the key below the picture says it.
    let what = if what.is_empty() || is_small { String::new() } else { format!("; {}", what.join(", ")) };
    let missing: Vec<&str> = diagram.missing.iter().map(|own| own.label.as_str()).collect();
    let missing = if missing.is_empty() { String::new() } else { format!(" Marked: {}.", missing.join("; ")) };
    diagram.is_small = is_small;
    let has_deviations = diagram.deviations.iter().any(Option::is_some);
    let state = deviations.filter(|_| has_deviations).map(|own| own.state);
    let what = state.map_or(what.clone(), |state| format!("{what}; numbers and colours: largest deviation{state}, K"));
    Some(Figure {
        id: format!("{}network", prefix(is_small)),
        drawing: network(&diagram),
        caption: format!("The network {of}{what}.{}", if is_small { "" } else { " Positions carry no meaning." })
            .into(),
        alternative: format!(
            "Diagram of the thermal network {of}, with {} and {}.{missing} The section on the thermal model has the tables.",
            counted(diagram.nodes.len(), "box"),
            counted(diagram.paths.len(), "path")
        ),
    })
}

/// Gives boxes the deviations at their nodes, the largest of each; `place` says which box stands for a node.
fn colour(diagram: &mut Diagram, deviations: Option<&AtNodes>, place: impl Fn(usize) -> usize) {
    let Some(AtNodes { largest, full_scale, .. }) = deviations else { return };
    diagram.full_scale = *full_scale;
    diagram.deviations = vec![None; diagram.nodes.len()];
    for (node, deviation) in largest.iter().enumerate().filter_map(|(node, own)| Some((node, (*own)?))) {
        if let Some(own) =
            diagram.deviations.get_mut(place(node)).filter(|own| own.is_none_or(|own| deviation.abs() > own.abs()))
        {
            *own = Some(deviation);
        }
    }
}

fn diagram(model: &Model) -> Diagram {
    let mut out = Diagram::default();
    out.nodes.extend(model.nodes.iter().map(|node| {
        let shape = match node.kind {
            NodeKind::Diffusion { .. } => NodeShape::Diffusion,
            NodeKind::Arithmetic => NodeShape::Arithmetic,
            NodeKind::Boundary { .. } => NodeShape::Boundary,
        };
        (node.name.clone(), shape)
    }));
    for element in &model.elements {
        let physics = element.physics();
        match physics.drawing() {
            Drawing::Path(path) => {
                for pair in physics.joined().windows(2) {
                    out.paths.push((element.name.clone(), path, pair[0], pair[1]));
                }
            }
            Drawing::Source(source) => {
                out.sources.extend(physics.heated().map(|node| (element.name.clone(), source, node)));
            }
        }
    }
    out
}

/// Value at nominal parameters and inputs, SI; `None` where it depends on more than these.
fn nominal(model: &Model, id: ExprId) -> Option<f64> {
    let allowed = Dependence::PARAMETER.union(Dependence::INPUT);
    if !model.graph.dependence(id).within(allowed) {
        return None;
    }
    let value = model.graph.evaluate(id, &|symbol| match symbol {
        Symbol::Parameter(i) => model.parameters.get(i as usize).map_or(f64::NAN, |p| p.nominal),
        Symbol::Input(i) => model.inputs.get(i as usize).map_or(f64::NAN, |p| p.nominal),
        _ => f64::NAN,
    });
    Some(value)
}

/// Names of what expressions depend on.
fn depends(model: &Model, ids: &[ExprId]) -> String {
    let symbols: BTreeSet<Symbol> = ids.iter().flat_map(|&id| model.graph.symbols(id)).collect();
    let names: Vec<String> = symbols
        .into_iter()
        .filter_map(|symbol| match symbol {
            Symbol::Parameter(i) => model.parameters.get(i as usize).map(|p| p.name.clone()),
            Symbol::Input(i) => model.inputs.get(i as usize).map(|p| p.name.clone()),
            Symbol::Node(i) => model.nodes.get(i as usize).map(|n| format!("temperature of {}", n.name)),
            Symbol::Time => Some("time".into()),
            Symbol::Mode(_) | Symbol::Local(_) | Symbol::Output(_) => None,
        })
        .collect();
    if names.is_empty() { NONE.to_owned() } else { names.join(", ") }
}

fn value_cell(model: &Model, id: ExprId, shown: &Shown) -> Cell {
    nominal(model, id).map_or_else(
        || Cell::from("varies"),
        |value| {
            let number = if shown.is_celsius() { shown.number(value) } else { as_given(value) };
            Cell::from(with_unit(&number, &shown.unit))
        },
    )
}

fn name_of(model: &Model, node: usize) -> &str {
    model.nodes.get(node).map_or(NONE, |n| n.name.as_str())
}

fn nodes(model: &Model) -> Block {
    let rows = model
        .nodes
        .iter()
        .map(|node| {
            let (kind, value, ids) = match node.kind {
                NodeKind::Diffusion { capacity } => {
                    ("stores heat", value_cell(model, capacity, &Shown::si("J/K")), vec![capacity])
                }
                NodeKind::Arithmetic => ("no storage", Cell::from(NONE), Vec::new()),
                NodeKind::Boundary { temperature } => {
                    ("given temperature", value_cell(model, temperature, &Shown::celsius()), vec![temperature])
                }
            };
            let celsius = Shown::celsius();
            let limits = |range: Option<[f64; 2]>| {
                range.map_or_else(|| NONE.to_owned(), |[a, b]| format!("{} to {}", celsius.number(a), celsius.text(b)))
            };
            vec![
                Cell::code(&node.name),
                kind.into(),
                value,
                depends(model, &ids).into(),
                node.area.map_or_else(|| NONE.to_owned(), as_given).into(),
                limits(node.limits.yellow).into(),
                limits(node.limits.red).into(),
                node.alias.clone().unwrap_or_else(|| NONE.to_owned()).into(),
            ]
        })
        .collect();
    let columns = vec![
        Column::text("Node"),
        Column::text("Kind"),
        Column::number("Capacity or temperature", ""),
        Column::text("Depends on"),
        Column::number("Area", "m\u{00B2}"),
        Column::text("Caution limits"),
        Column::text("Red limits"),
        Column::text("Other name"),
    ];
    Block::Table(without_empty_columns(Table {
        caption: "Nodes, at nominal parameters and inputs.".into(),
        columns,
        rows,
    }))
}

fn elements(model: &Model) -> Block {
    element_table(model.elements.iter().map(|element| element_row(model, element)).collect())
}

fn element_row(model: &Model, element: &Element) -> Vec<Cell> {
    let description = element.physics().description(&|node| name_of(model, node).to_owned());
    let ids: Vec<ExprId> = std::iter::once(description.value).chain(description.others).collect();
    vec![
        Cell::code(&element.name),
        description.what.into(),
        description.ends.into(),
        value_cell(model, description.value, &Shown::si(description.unit)),
        depends(model, &ids).into(),
    ]
}

fn element_table(rows: Vec<Vec<Cell>>) -> Block {
    Block::Table(Table {
        caption: "Elements, at nominal parameters and inputs: conductance, exchange area (without the \
                  Stefan-Boltzmann constant), power or drive."
            .into(),
        columns: vec![
            Column::text("Element"),
            Column::text("Kind"),
            Column::text("Between"),
            Column::number("Value", ""),
            Column::text("Depends on"),
        ],
        rows,
    })
}

/// The table without columns that say nothing in any row.
fn without_empty_columns(mut table: Table) -> Table {
    let empty = Cell::from(NONE);
    for position in (1..table.columns.len()).rev() {
        if table.rows.iter().all(|row| row.get(position) == Some(&empty)) {
            table.columns.remove(position);
            for row in &mut table.rows {
                row.remove(position);
            }
        }
    }
    table
}
