//! Figures of a diagnosis: how surely each effect, and where heat is missing.

use super::chance;
use crate::diagnosis::Verdict;
use crate::diagnosis::output::{EffectResult, Heat, Output};
use crate::document::time::unit_of_time;
use crate::report::number::significant;
use crate::report::page::{Block, Figure, slug};
use crate::report::plot::{Axis, Bar, HeatMap, bar_chart, heat_map, palette};

/// Effects in the bars.
const MOST_BARS: usize = 8;
/// Rows of the map.
const MOST_ROWS: usize = 40;

/// The figures of a job.
pub(super) fn figures(job: &str, output: &Output) -> Vec<Block> {
    [probabilities(job, output), heat(job, output)].into_iter().flatten().map(Block::Figure).collect()
}

fn probabilities(job: &str, output: &Output) -> Option<Figure> {
    if output.verdict == Verdict::Adequate || output.effects.is_empty() {
        return None;
    }
    let worth = |effect: &&EffectResult| !effect.changes_nothing || output.selected.contains(&effect.id);
    let shown = output.effects.iter().filter(worth).take(MOST_BARS).filter(|effect| effect.probability >= 5e-4);
    let mut bars: Vec<Bar> = shown
        .map(|effect| Bar {
            label: effect.id.clone(),
            from: 0.0,
            value: effect.probability,
            interval: None,
            text: chance(effect.probability),
            colour: if output.selected.contains(&effect.id) { palette::GREEN } else { palette::BLUE },
        })
        .collect();
    for (label, value) in
        [("nothing missing", output.probability_nothing), ("something else", output.probability_unexplained)]
    {
        bars.push(Bar {
            label: label.to_owned(),
            from: 0.0,
            value,
            interval: None,
            text: chance(value),
            colour: palette::MUTED,
        });
    }
    let axis = Axis::over("Probability", 0.0, 1.0).up_to(1.0);
    Some(Figure {
        id: slug(&format!("{job} probabilities")),
        drawing: bar_chart(&axis, &bars, None),
        caption: "Probability that each effect is missing; over all sets that it belongs to, so that they need not sum to one.".into(),
        alternative: "Bars: probability of each effect".to_owned(),
    })
}

/// The last instant at which heat is stated, s: all are in its unit.
pub(super) fn longest_s(output: &Output) -> f64 {
    let carried = output.effects.iter().flat_map(|effect| &effect.carries).filter_map(|one| one.time_s);
    output.heat.iter().filter_map(|heat| heat.time_s).chain(carried).fold(0.0, f64::max)
}

/// The phase of some heat, or its instant in a record that ends about `longest_s`.
pub(super) fn stretch(phase: Option<&str>, time_s: Option<f64>, longest_s: f64) -> String {
    match (phase, time_s) {
        (Some(phase), _) => phase.to_owned(),
        (None, Some(time)) => {
            let (length, unit) = unit_of_time(longest_s);
            format!("{} {unit}", significant(time / length, 4))
        }
        (None, None) => String::new(),
    }
}

fn heat(job: &str, output: &Output) -> Option<Figure> {
    let mut nodes: Vec<&str> = Vec::new();
    let mut rows: Vec<String> = Vec::new();
    let longest_s = longest_s(output);
    let name = |heat: &Heat| stretch(heat.phase.as_deref(), heat.time_s, longest_s);
    for heat in &output.heat {
        if !nodes.contains(&heat.node.as_str()) {
            nodes.push(&heat.node);
        }
        let row = name(heat);
        if !rows.contains(&row) {
            rows.push(row);
        }
    }
    if rows.is_empty() {
        return None;
    }
    let cell = |row: &String, node: &&str| {
        let node_heat = output.heat.iter().find(|heat| heat.node == **node && name(heat) == *row);
        node_heat.filter(|heat| heat.watts.abs() > heat.sd).map(|heat| heat.watts)
    };
    let map = HeatMap {
        columns: nodes.iter().map(|node| (*node).to_owned()).collect(),
        rows: rows
            .iter()
            .take(MOST_ROWS)
            .map(|row| (row.clone(), false, nodes.iter().map(|node| cell(row, node)).collect()))
            .collect(),
        full_scale: 0.0,
        limit: None,
        legend: "missing heat [W]; positive: the model lacks heat in the node".to_owned(),
        mark_label: String::new(),
        decimals: 2,
        is_unsigned: false,
        is_small: false,
    };
    Some(Figure {
        id: slug(&format!("{job} missing heat")),
        drawing: heat_map(&map),
        caption:
            "Heat that the tuned model lacks, by node and phase, whatever its cause; grey: less than its own standard \
                  deviation."
                .into(),
        alternative: "Map of the missing heat by node and phase".to_owned(),
    })
}
