//! What was read of a deck, counted and in sentences.

use bmv_decks::{Deck, NodeKind};
use serde::Serialize;

use crate::document::counted;

use super::coupling::Became;
use super::record::Measured;

/// What was read of a deck and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The deck's title.
    pub title: String,
    /// The tool that wrote it.
    pub tool: String,
    /// Files that it was read from.
    pub sources: Vec<String>,
    /// How much of what.
    pub counts: Counts,
    /// What was assumed, converted or left out, in sentences; those of the reader with their place.
    pub notes: Vec<String>,
    /// Files of the study.
    pub files: Vec<String>,
}

/// How much of what the study has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Nodes that store heat.
    pub diffusion_nodes: usize,
    /// Nodes whose balance closes at every instant.
    pub arithmetic_nodes: usize,
    /// Nodes of given temperature.
    pub boundary_nodes: usize,
    /// Linear conductors.
    pub conductors: usize,
    /// Radiative exchanges.
    pub radiations: usize,
    /// Couplings that became flows.
    pub flows: usize,
    /// Couplings that are left out.
    pub couplings_left_out: usize,
    /// Heat loads.
    pub loads: usize,
    /// Heaters with a thermostat.
    pub heaters: usize,
    /// Inputs.
    pub inputs: usize,
    /// Parameters.
    pub parameters: usize,
    /// Parameters of the deck that nothing uses, which are left out.
    pub parameters_unused: usize,
    /// Groups of the deck.
    pub groups: usize,
    /// Rows of the record that stand in the study.
    pub record_rows: usize,
    /// Nodes of which the record tells the temperature, boundaries aside.
    pub record_nodes: usize,
}

/// Counts what became of a deck.
pub(super) fn counts(
    deck: &Deck,
    is_there: &[bool],
    became: &[Became],
    [parameters, parameters_unused]: [usize; 2],
    measured: Option<&Measured>,
) -> Counts {
    let mut counts = Counts {
        loads: deck.loads.len(),
        heaters: deck.heaters.len(),
        inputs: deck.inputs.len(),
        parameters,
        parameters_unused,
        groups: deck.groups.len(),
        record_rows: measured.map_or(0, |measured| measured.rows.len()),
        record_nodes: measured.map_or(0, |measured| measured.sensors),
        ..Counts::default()
    };
    for (node, _) in deck.nodes.iter().zip(is_there).filter(|(_, is_there)| **is_there) {
        *(match node.kind {
            NodeKind::Diffusion { .. } => &mut counts.diffusion_nodes,
            NodeKind::Arithmetic => &mut counts.arithmetic_nodes,
            NodeKind::Boundary { .. } => &mut counts.boundary_nodes,
        }) += 1;
    }
    for became in became {
        *(match became {
            Became::Conductor(_) => &mut counts.conductors,
            Became::Radiation(_) => &mut counts.radiations,
            Became::Flow => &mut counts.flows,
            Became::Nothing => &mut counts.couplings_left_out,
        }) += 1;
    }
    counts
}

impl Summary {
    /// What was read, in sentences.
    pub fn in_words(&self) -> String {
        let counts = &self.counts;
        let list = |parts: &[(usize, &str)]| {
            let parts: Vec<String> =
                parts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| counted(*count, what)).collect();
            if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") }
        };
        let mut text = format!("Read from {}: `{}`, by {}.\n", self.sources.join(", "), self.title, self.tool);
        text.push_str(&format!(
            "  Nodes: {}.\n",
            list(&[
                (counts.diffusion_nodes, "diffusion node"),
                (counts.arithmetic_nodes, "arithmetic node"),
                (counts.boundary_nodes, "boundary node"),
            ])
        ));
        text.push_str(&format!(
            "  Heat: {}.\n",
            list(&[
                (counts.conductors, "conductor"),
                (counts.radiations, "radiation"),
                (counts.flows, "flow"),
                (counts.loads, "load"),
                (counts.heaters, "heater"),
            ])
        ));
        text.push_str(&format!(
            "  Values: {}.\n",
            list(&[(counts.inputs, "input"), (counts.parameters, "parameter"), (counts.groups, "group")])
        ));
        if counts.parameters_unused > 0 {
            let count = counted(counts.parameters_unused, "parameter");
            text.push_str(&format!("  Left out: {count} of the deck that nothing uses.\n"));
        }
        if counts.record_rows > 0 {
            let (rows, nodes) = (counted(counts.record_rows, "row"), counted(counts.record_nodes, "node"));
            text.push_str(&format!("  Record: {rows} with temperatures of {nodes}.\n"));
        } else {
            text.push_str("  Record: none, so that nothing says whether the import is complete.\n");
        }
        if !self.notes.is_empty() {
            text.push_str("Notes:\n");
            for note in &self.notes {
                text.push_str(&format!("  - {}.\n", note.trim_end_matches('.')));
            }
        }
        text
    }
}
