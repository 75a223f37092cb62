//! A large model by its parts: the picture and tables of groups of nodes in place of hundreds of lines.

use std::collections::BTreeMap;

use crate::document::counted;
use crate::effect::{GroupPlace, Site};
use crate::math::sort::sort_by;
use crate::report::number::{NONE, as_given, significant, with_unit};
use crate::report::page::{Block, Cell, Column, Table};
use crate::report::plot::{Diagram, NodeShape};
use crate::report::view::PassReport;
use crate::thermal::element::{Drawing, Path};
use crate::thermal::{Model, NodeKind};

use super::{depends, element_row, element_table, name_of, nominal, without_empty_columns};

/// A model with more nodes is shown by its parts.
const MOST_NODES: usize = 40;
/// Most parts that a picture holds.
const MOST_PARTS: usize = 24;
/// Most lines of a kind between parts; the largest are drawn.
const MOST_LINES: usize = 24;
/// Elements between two parts up to which the table names them.
const NAMED: usize = 2;
/// Other elements up to which the table has them.
const MOST_OTHERS: usize = 60;

/// The parts of a model: each node is in one.
pub(super) struct Parts {
    names: Vec<String>,
    of: Vec<usize>,
}

/// Elements of a kind between two parts.
#[derive(Default)]
struct Class {
    elements: Vec<usize>,
    total: f64,
    unit: &'static str,
}

impl Parts {
    /// The parts of a model that is too large to be shown node by node: the first group that has a node, the name of a
    /// boundary without one, `other nodes`.
    pub(super) fn new(report: &PassReport<'_>) -> Option<Self> {
        let nodes = &report.model.nodes;
        if nodes.len() <= MOST_NODES {
            return None;
        }
        let (mut names, mut of) = (Vec::new(), Vec::with_capacity(nodes.len()));
        for (index, node) in nodes.iter().enumerate() {
            let holds = |group: &&GroupPlace| matches!(&group.site, Site::Nodes(members) if members.iter().any(|member| member.0 == index));
            let name = match (report.groups.iter().find(holds), node.kind) {
                (Some(group), _) => group.name.clone(),
                (None, NodeKind::Boundary { .. }) => node.name.clone(),
                (None, NodeKind::Diffusion { .. } | NodeKind::Arithmetic) => "other nodes".to_owned(),
            };
            of.push(names.iter().position(|other| *other == name).unwrap_or_else(|| {
                names.push(name);
                names.len() - 1
            }));
        }
        Some(Self { names, of })
    }

    /// The part in which a node is.
    pub(super) fn part(&self, node: usize) -> usize {
        self.of.get(node).copied().unwrap_or(usize::MAX)
    }

    fn members(&self, part: usize) -> impl Iterator<Item = usize> {
        self.of.iter().enumerate().filter(move |(_, of)| **of == part).map(|(node, _)| node)
    }

    /// Passive elements by kind and by the parts that they join, in this order.
    fn classes(&self, model: &Model) -> BTreeMap<(bool, usize, usize), Class> {
        let mut classes: BTreeMap<(bool, usize, usize), Class> = BTreeMap::new();
        for (index, element) in model.elements.iter().enumerate() {
            let physics = element.physics();
            let (true, &[a, b]) = (physics.is_passive(), physics.joined()) else { continue };
            let (a, b) = (self.of[a], self.of[b]);
            let is_radiative = matches!(physics.drawing(), Drawing::Path(Path::Radiation));
            let class = classes.entry((is_radiative, a.min(b), a.max(b))).or_default();
            let description = physics.description(&|node| name_of(model, node).to_owned());
            class.elements.push(index);
            class.total += nominal(model, description.value).unwrap_or(f64::NAN);
            class.unit = description.unit;
        }
        classes
    }

    /// The picture of the parts, where they are not too many.
    pub(super) fn diagram(&self, model: &Model) -> Option<Diagram> {
        if self.names.len() > MOST_PARTS {
            return None;
        }
        let mut out = Diagram::default();
        out.nodes.extend(self.names.iter().enumerate().map(|(part, name)| {
            let is = |test: fn(&NodeKind) -> bool| self.members(part).all(|node| test(&model.nodes[node].kind));
            let shape = if is(|kind| matches!(kind, NodeKind::Boundary { .. })) {
                NodeShape::Boundary
            } else if is(|kind| matches!(kind, NodeKind::Arithmetic)) {
                NodeShape::Arithmetic
            } else {
                NodeShape::Diffusion
            };
            (name.clone(), shape)
        }));
        let mut lines: Vec<((bool, usize, usize), Class)> =
            self.classes(model).into_iter().filter(|((_, a, b), _)| a != b).collect();
        sort_by(&mut lines, |a, b| (a.0.0).cmp(&b.0.0).then(b.1.total.total_cmp(&a.1.total)).then(a.0.cmp(&b.0)));
        for kind in [false, true] {
            for ((_, a, b), class) in lines.iter().filter(|line| line.0.0 == kind).take(MOST_LINES) {
                let path = if kind { Path::Radiation } else { Path::Conductor };
                let name = match class.elements.as_slice() {
                    [one] => model.elements[*one].name.clone(),
                    many => counted(many.len(), if kind { "radiation" } else { "conductor" }),
                };
                out.paths.push((name, path, *a, *b));
            }
        }
        let mut sources: BTreeMap<(usize, bool), Vec<&str>> = BTreeMap::new();
        for element in &model.elements {
            let physics = element.physics();
            match physics.drawing() {
                Drawing::Source(source) => {
                    if let Some(node) = physics.heated() {
                        let is_load = source == crate::thermal::element::Source::Load;
                        sources.entry((self.of[node], is_load)).or_default().push(&element.name);
                    }
                }
                Drawing::Path(path) if !physics.is_passive() => {
                    for pair in physics.joined().windows(2) {
                        out.paths.push((element.name.clone(), path, self.of[pair[0]], self.of[pair[1]]));
                    }
                }
                Drawing::Path(_) => {}
            }
        }
        for ((part, is_load), names) in sources {
            let (source, word) = if is_load {
                (crate::thermal::element::Source::Load, "load")
            } else {
                (crate::thermal::element::Source::Heater, "heater")
            };
            let name = if let [one] = names.as_slice() { (*one).to_owned() } else { counted(names.len(), word) };
            out.sources.push((name, source, part));
        }
        Some(out)
    }

    /// Tables of the parts, of what joins them, and of the other elements.
    pub(super) fn tables(&self, model: &Model) -> Vec<Block> {
        let rows = (self.names.iter().enumerate())
            .map(|(part, name)| {
                let nodes: Vec<usize> = self.members(part).collect();
                let capacity: f64 = nodes
                    .iter()
                    .filter_map(|&node| match model.nodes[node].kind {
                        NodeKind::Diffusion { capacity } => nominal(model, capacity),
                        NodeKind::Arithmetic | NodeKind::Boundary { .. } => None,
                    })
                    .sum();
                let ends = match nodes.as_slice() {
                    [] => NONE.to_owned(),
                    [one] => model.nodes[*one].name.clone(),
                    [first, .., last] => format!("{} to {}", model.nodes[*first].name, model.nodes[*last].name),
                };
                let capacity =
                    if capacity > 0.0 { with_unit(&significant(capacity, 4), "J/K") } else { NONE.to_owned() };
                vec![Cell::code(name), nodes.len().to_string().into(), ends.into(), capacity.into()]
            })
            .collect();
        let parts = Table {
            caption: "Parts: groups of the model's nodes. The nodes are in the model's file.".into(),
            columns: vec![
                Column::text("Part"),
                Column::number("Nodes", ""),
                Column::text("First and last"),
                Column::number("Capacity together", ""),
            ],
            rows,
        };
        let joints = self.classes(model).into_iter().map(|((is_radiative, a, b), class)| {
            let between = if a == b {
                format!("within {}", self.names[a])
            } else {
                format!("{} to {}", self.names[a], self.names[b])
            };
            let names = match class.elements.as_slice() {
                few if few.len() <= NAMED => {
                    few.iter().map(|&index| model.elements[index].name.as_str()).collect::<Vec<&str>>().join(", ")
                }
                _ => NONE.to_owned(),
            };
            let ids: Vec<_> = (class.elements.iter())
                .map(|&index| model.elements[index].physics().description(&|_| String::new()).value)
                .collect();
            vec![
                (if is_radiative { "radiation" } else { "conduction" }).into(),
                between.into(),
                class.elements.len().to_string().into(),
                with_unit(&as_given(significant(class.total, 4).parse().unwrap_or(class.total)), class.unit).into(),
                depends(model, &ids).into(),
                names.into(),
            ]
        });
        let joints = Table {
            caption: "What joins the parts, at nominal parameters and inputs: conductances or exchange areas (without \
                      the Stefan-Boltzmann constant) added up."
                .into(),
            columns: vec![
                Column::text("Kind"),
                Column::text("Place"),
                Column::number("Number", ""),
                Column::number("Together", ""),
                Column::text("Depends on"),
                Column::text("Elements"),
            ],
            rows: joints.collect(),
        };
        let others: Vec<_> = model.elements.iter().filter(|element| !element.physics().is_passive()).collect();
        let mut blocks = vec![Block::Table(parts), Block::Table(without_empty_columns(joints))];
        if !others.is_empty() {
            let shown = others.iter().take(MOST_OTHERS).map(|element| element_row(model, element)).collect();
            blocks.push(element_table(shown));
            if others.len() > MOST_OTHERS {
                let more = counted(others.len() - MOST_OTHERS, "more element");
                blocks.push(Block::paragraph(format!("{more} of other kinds stand in the model's file.")));
            }
        }
        blocks
    }
}
