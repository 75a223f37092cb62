//! Heat in a diagnosis: what the selected effects carry, what is missing where no effect explains it.

use super::figures;
use crate::diagnosis::Verdict;
use crate::diagnosis::output::{EffectHeat, EffectResult, Heat, Output};
use crate::document::p_value;
use crate::math::sort::sort_by;
use crate::report::number::{Shown, fixed, significant, with_error, with_unit};
use crate::report::page::{Block, Cell, Column, Table, Text};
use crate::report::view::PassReport;

/// Places and phases in the table of missing heat.
const MOST_HEAT: usize = 12;
/// Nodes of an effect in the table of carried heat.
const MOST_NODES: usize = 3;

/// The heat that the selected effects give the nodes they act on.
pub(super) fn carried(output: &Output) -> Option<Block> {
    let longest_s = figures::longest_s(output);
    let selected = output.selected.iter().filter_map(|id| output.effects.iter().find(|effect| effect.id == *id));
    let rows: Vec<Vec<Cell>> = selected.flat_map(|effect| of_effect(effect, longest_s)).collect();
    let several = output.effects.iter().flat_map(|effect| &effect.carries).any(|one| one.time_s.is_some());
    let means = if several { " Over a transient each value is the mean of a twelfth of its rows." } else { "" };
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: Text::new(format!(
                "What the selected effects carry: heat into the node over the fitted rows, negative where it is taken \
                 from it.{means}"
            )),
            columns: vec![
                Column::text("Effect"),
                Column::text("Node"),
                Column::number("Smallest", "W"),
                Column::text("in"),
                Column::number("Mean", "W"),
                Column::number("Largest", "W"),
                Column::text("in"),
            ],
            rows,
        })
    })
}

fn of_effect(effect: &EffectResult, longest_s: f64) -> Vec<Vec<Cell>> {
    let mut nodes: Vec<&str> = Vec::new();
    for one in &effect.carries {
        if !nodes.contains(&one.node.as_str()) {
            nodes.push(&one.node);
        }
    }
    let row = |node: &&str| {
        let heat_at_node: Vec<&EffectHeat> = effect.carries.iter().filter(|one| one.node == *node).collect();
        let least = heat_at_node.iter().min_by(|a, b| a.watts.total_cmp(&b.watts))?;
        let most = heat_at_node.iter().max_by(|a, b| a.watts.total_cmp(&b.watts))?;
        let mean = heat_at_node.iter().map(|one| one.watts).sum::<f64>() / heat_at_node.len() as f64;
        Some(vec![
            Cell::code(&effect.id),
            Cell::code(*node),
            significant(least.watts, 2).into(),
            figures::stretch(least.phase.as_deref(), least.time_s, longest_s).into(),
            significant(mean, 2).into(),
            significant(most.watts, 2).into(),
            figures::stretch(most.phase.as_deref(), most.time_s, longest_s).into(),
        ])
    };
    nodes.iter().take(MOST_NODES).filter_map(row).collect()
}

/// The clearest of the missing heat; where an effect explains it, it is stated by that effect.
pub(super) fn missing(output: &Output) -> Option<Block> {
    if output.verdict != Verdict::Unexplained {
        return None;
    }
    let longest_s = figures::longest_s(output);
    let clear = |heat: &Heat| if heat.sd > 0.0 { heat.watts.abs() / heat.sd } else { 0.0 };
    let mut clearest: Vec<&Heat> = output.heat.iter().filter(|heat| clear(heat) > 2.0).collect();
    sort_by(&mut clearest, |a, b| clear(b).total_cmp(&clear(a)));
    let more = clearest.len().saturating_sub(MOST_HEAT);
    let rows: Vec<Vec<Cell>> = clearest
        .into_iter()
        .take(MOST_HEAT)
        .map(|heat| {
            vec![
                Cell::code(&heat.node),
                figures::stretch(heat.phase.as_deref(), heat.time_s, longest_s).into(),
                with_error(heat.watts, heat.sd).into(),
                fixed(clear(heat), 1).into(),
            ]
        })
        .collect();
    let more = if more == 0 {
        String::new()
    } else {
        format!(" {more} more {} above two standard deviations.", if more == 1 { "is" } else { "are" })
    };
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!(
                "Heat that the tuned model lacks, clearest first; positive: the node gets more heat than the model \
                 says.{more}"
            )
            .into(),
            columns: vec![
                Column::text("Node"),
                Column::text("Phase"),
                Column::number("Heat", "W"),
                Column::number("In standard deviations", ""),
            ],
            rows,
        })
    })
}

pub(super) fn goes_with(report: &PassReport<'_>, output: &Output) -> Option<Block> {
    if output.verdict != Verdict::Unexplained {
        return None;
    }
    let rows: Vec<Vec<Cell>> = output
        .goes_with
        .iter()
        .map(|one| {
            let input = report.model.inputs.iter().find(|input| input.name == one.input);
            let shown = input.map_or_else(|| Shown::si("SI"), |input| Shown::written(&input.unit).difference());
            // From watts per SI unit to watts per unit of the input.
            let slope = one.slope / shown.value(1.0);
            let unit = if shown.unit.is_empty() { "W".to_owned() } else { format!("W/{}", shown.unit) };
            vec![
                Cell::code(&one.node),
                Cell::code(&one.input),
                with_unit(&significant(slope, 3), &unit).into(),
                p_value(one.p).into(),
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "What the missing heat goes with: its slope over the input.".into(),
            columns: vec![
                Column::text("Node"),
                Column::text("Input"),
                Column::number("Slope", ""),
                Column::number("p", ""),
            ],
            rows,
        })
    })
}
