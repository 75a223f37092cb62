//! How the expected information is spread over the candidates: its histogram, and the candidates against each condition.

use crate::job::design::{Axis as Condition, Output};
use crate::report::number::{Shown, significant};
use crate::report::page::{Block, Figure};
use crate::report::plot::{Along, Axis, Chart, Layer, Limit, Mark, palette};

/// Fewer candidates than this have no distribution to look at.
const FEWEST: usize = 8;
/// Most bins of the histogram.
const MOST_BINS: usize = 20;

/// The blocks; none with few candidates.
pub(super) fn blocks(job: &str, output: &Output) -> Vec<Block> {
    let known: Vec<f64> = output.candidates.iter().filter_map(|candidate| candidate.information_nats).collect();
    if known.len() < FEWEST {
        return Vec::new();
    }
    let mut blocks: Vec<Block> = histogram(job, output, &known).into_iter().map(Block::Figure).collect();
    let figures: Vec<Block> = output.axes.iter().map(|axis| Block::Figure(scatter(job, output, axis))).collect();
    if !figures.is_empty() {
        blocks.push(Block::Details(format!("Information against each condition ({})", figures.len()), figures));
    }
    blocks
}

/// Equally wide bins, as many as the square root of the candidates; none where all are equal.
fn histogram(job: &str, output: &Output, known: &[f64]) -> Option<Figure> {
    let (low, high) = known.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    if low >= high || !(high - low).is_finite() {
        return None;
    }
    let bins = ((known.len() as f64).sqrt().ceil() as usize).clamp(4, MOST_BINS);
    let others = output.candidates.iter().filter(|own| !own.allowed && own.information_nats.is_some()).count();
    // Candidates that are not allowed stand beside the others, each in a half of the bin.
    let parts = if others > 0 { 2 } else { 1 };
    let edges: Vec<f64> =
        (0..=bins * parts).map(|edge| low + (high - low) * edge as f64 / (bins * parts) as f64).collect();
    let bars = |allowed: bool, colour, label: &str| {
        let mut heights = vec![0.0; bins * parts];
        let counted = output.candidates.iter().filter(|own| own.allowed == allowed);
        for value in counted.filter_map(|own| own.information_nats) {
            let bin = (((value - low) / (high - low) * bins as f64) as usize).min(bins - 1);
            heights[bin * parts + usize::from(!allowed)] += 1.0;
        }
        Layer::Bars { edges: edges.clone(), heights, colour, label: label.to_owned() }
    };
    let mut layers = vec![bars(true, palette::BLUE, if others > 0 { "allowed" } else { "" })];
    if others > 0 {
        layers.push(bars(false, palette::AMBER, "not allowed"));
    }
    let best = output.best.as_ref().map(|best| Limit {
        along: Along::X,
        value: best.information_nats,
        label: format!("best {}", significant(best.information_nats, 3)),
        colour: palette::INK,
    });
    let chart = Chart {
        x: Axis::new("expected information [nats]"),
        y: Axis::new("candidates"),
        layers,
        limits: best.into_iter().collect(),
        height: 700,
        ..Chart::default()
    };
    let caption = format!(
        "Histogram of the expected information about {} over {} candidates: {} to {} nats.",
        output.learn.join(", "),
        known.len(),
        significant(low, 3),
        significant(high, 3)
    );
    Some(Figure {
        id: format!("{job}-information-histogram"),
        drawing: chart.draw(),
        alternative: caption.clone(),
        caption: caption.into(),
    })
}

fn scatter(job: &str, output: &Output, axis: &Condition) -> Figure {
    let shown = Shown::written(&axis.unit);
    let dots = |allowed: bool| -> Vec<(f64, f64)> {
        let of = output.candidates.iter().filter(|candidate| candidate.allowed == allowed);
        of.filter_map(|own| Some((shown.value(*own.conditions.get(&axis.input)?), own.information_nats?))).collect()
    };
    let layer = |points, colour, mark, label: &str| Layer::Dots { points, colour, mark, label: label.to_owned() };
    let mut layers = vec![layer(dots(true), palette::BLUE, Mark::Disc, "candidates")];
    if !dots(false).is_empty() {
        layers.push(layer(dots(false), palette::VERMILION, Mark::Ring, "not allowed"));
    }
    let chart = Chart {
        x: Axis::new(shown.title(&axis.input)),
        y: Axis::new("expected information [nats]"),
        layers,
        height: 700,
        ..Chart::default()
    };
    let caption =
        format!("Expected information about {} against {}, a point a candidate.", output.learn.join(", "), axis.input);
    Figure {
        id: format!("{job}-information-against-{}", axis.input),
        drawing: chart.draw(),
        alternative: caption.clone(),
        caption: caption.into(),
    }
}
