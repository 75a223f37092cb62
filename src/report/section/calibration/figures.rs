//! Figures of a calibration: correlations, predictions in time, traces and ranks.

use crate::document::counted;
use crate::document::time::unit_of_time;
use crate::job::calibrate::{Output, ParameterSummary, SensorPredictive};
use crate::math::sort::sort_by;
use crate::report::number::{Shown, stated};
use crate::report::page::{Block, Figure, Text};
use crate::report::plot::{Axis, Chart, HeatMap, Layer, Mark, PairAxis, Shade, Stroke, heat_map, pairs, palette};

/// Unknowns whose traces are drawn: those with the worst R-hat.
const TRACES: usize = 3;
/// Unknowns drawn against one another: those in the strongest correlations.
const PAIRS: usize = 6;
/// Bins of a rank plot.
const RANK_BINS: usize = 16;

/// The figures; all but the pairs and the correlations folded away.
pub(super) fn figures(job: &str, output: &Output) -> Vec<Block> {
    let mut blocks: Vec<Block> = pair_plot(job, output).map(Block::Figure).into_iter().collect();
    blocks.extend(correlations(job, output).map(Block::Figure));
    let predictions: Vec<Block> =
        output.predictive.iter().filter_map(|check| prediction(job, check)).map(Block::Figure).collect();
    if !predictions.is_empty() {
        blocks.push(Block::Details("Posterior predictions in time".into(), predictions));
    }
    let mut worst: Vec<usize> = (0..output.order.len()).collect();
    let rhat = |place: &usize| {
        output.parameters.get(&output.order[*place]).and_then(|summary| summary.rhat).unwrap_or(f64::INFINITY)
    };
    sort_by(&mut worst, |a, b| rhat(b).total_cmp(&rhat(a)));
    let chains: Vec<Block> = worst
        .into_iter()
        .take(TRACES)
        .flat_map(|place| [trace(job, output, place), ranks(job, output, place)])
        .map(Block::Figure)
        .collect();
    if !chains.is_empty() {
        blocks.push(Block::Details("Traces and ranks of the unknowns with the largest R-hat".into(), chains));
    }
    blocks
}

/// How an unknown is shown.
fn shown(summary: Option<&ParameterSummary>) -> Shown {
    summary.map_or_else(|| Shown::written(""), |summary| Shown::parameter(&summary.unit, summary.size()))
}

fn pair_plot(job: &str, output: &Output) -> Option<Figure> {
    let count = output.order.len();
    if count < 2 || output.draws.values.is_empty() {
        return None;
    }
    let strongest = |place: usize| {
        let row = output.correlations.get(place);
        let others = row.into_iter().flatten().enumerate().filter(|(other, _)| *other != place);
        others.map(|(_, value)| value.abs()).fold(0.0, f64::max)
    };
    let mut chosen: Vec<usize> = (0..count).collect();
    sort_by(&mut chosen, |&a, &b| strongest(b).total_cmp(&strongest(a)));
    chosen.truncate(PAIRS);
    chosen.sort_unstable();
    let unknowns: Vec<PairAxis> = chosen
        .iter()
        .map(|&place| {
            let name = &output.order[place];
            let summary = output.parameters.get(name);
            let shown = shown(summary);
            let times = summary.map_or(1.0, |summary| stated(&summary.unit, summary.size()).0);
            let draws = output.draws.values.iter();
            PairAxis {
                title: shown.title(name),
                draws: draws.map(|draw| draw.get(place).map_or(f64::NAN, |value| shown.value(*value))).collect(),
                // Already in the unknown's unit as written.
                marked: summary.map(|summary| times * summary.map),
            }
        })
        .collect();
    let left_off = count - unknowns.len();
    let rest = if left_off == 0 {
        String::new()
    } else {
        format!(
            " {} with weaker correlations {} not drawn.",
            counted(left_off, "further unknown"),
            if left_off == 1 { "is" } else { "are" }
        )
    };
    Some(Figure {
        id: format!("{job}-pairs"),
        drawing: pairs(&unknowns),
        caption: format!(
            "The posterior: each unknown's histogram, and draws of pairs of unknowns; the cross is the most probable \
             point.{rest}"
        )
        .into(),
        alternative: format!("Pair plot of the posterior draws of {}.", counted(unknowns.len(), "unknown")),
    })
}

fn correlations(job: &str, output: &Output) -> Option<Figure> {
    if output.order.len() < 2 {
        return None;
    }
    let rows = output.order.iter().zip(&output.correlations).enumerate().map(|(place, (name, row))| {
        // The lower triangle says it all.
        (name.clone(), false, row.iter().enumerate().map(|(k, value)| (k < place).then_some(*value)).collect())
    });
    let map = HeatMap {
        columns: output.order[..output.order.len() - 1].to_vec(),
        rows: rows
            .skip(1)
            .map(|(name, mark, mut row): (_, _, Vec<_>)| {
                row.pop();
                (name, mark, row)
            })
            .collect(),
        full_scale: 1.0,
        legend: "Posterior correlation".into(),
        decimals: 2,
        is_unsigned: false,
        ..HeatMap::default()
    };
    Some(Figure {
        id: format!("{job}-correlations"),
        drawing: heat_map(&map),
        caption: "Posterior correlations. Near 1 or \u{2212}1 the data determine a combination of the two, not each."
            .into(),
        alternative: "Heat map of the posterior correlations of all unknowns.".into(),
    })
}

/// Prediction and readings of a sensor over time.
fn prediction(job: &str, check: &SensorPredictive) -> Option<Figure> {
    let rows: Vec<_> = check.rows.iter().filter_map(|row| Some((row.time_s?, row))).collect();
    if rows.len() < 2 {
        return None;
    }
    let shown = Shown::quantity(&check.unit, check.unit == "K");
    let (length, unit) = unit_of_time(rows.iter().map(|(time, _)| *time).fold(0.0, f64::max));
    let rows: Vec<_> = rows.into_iter().map(|(time, row)| (time / length, row)).collect();
    let held_out: Vec<f64> = rows.iter().filter(|(_, row)| row.held_out).map(|(time, _)| *time).collect();
    let shade = held_out.iter().copied().reduce(f64::min).zip(held_out.iter().copied().reduce(f64::max));
    let chart = Chart {
        x: Axis::new(format!("time [{unit}]")),
        y: Axis::new(shown.title(&check.sensor)),
        layers: vec![
            Layer::Band {
                points: rows
                    .iter()
                    .map(|(t, row)| (*t, shown.value(row.band_with_noise[0]), shown.value(row.band_with_noise[1])))
                    .collect(),
                colour: palette::SKY,
                label: "95 % band with noise".into(),
            },
            Layer::Line {
                points: rows.iter().map(|(t, row)| (*t, shown.value(row.mean))).collect(),
                colour: palette::BLUE,
                stroke: Stroke::Solid,
                label: "posterior mean".into(),
            },
            Layer::Dots {
                points: rows.iter().filter_map(|(t, row)| Some((*t, shown.value(row.measured?)))).collect(),
                colour: palette::VERMILION,
                mark: Mark::Disc,
                label: "measured".into(),
            },
        ],
        shades: shade.map(|(from, to)| Shade { from, to }).into_iter().collect(),
        shade_label: if shade.is_some() { "held out".into() } else { String::new() },
        height: 700,
        ..Chart::default()
    };
    Some(Figure {
        id: format!("{job}-prediction-{}-{}", check.measurement, check.sensor),
        drawing: chart.draw(),
        caption: Text::new("What the calibrated model says that sensor ")
            .code(&check.sensor)
            .plain(" reads, and what it read."),
        alternative: format!("Prediction of sensor {} over time with its readings.", check.sensor),
    })
}

/// Kept draws of an unknown by chain: place in the chain and value in the unknown's unit.
fn by_chain(output: &Output, place: usize) -> Vec<Vec<(f64, f64)>> {
    let shown = shown(output.parameters.get(&output.order[place]));
    let mut chains = vec![Vec::new(); usize::try_from(output.chains[0]).unwrap_or(0).min(64)];
    for (index, values) in output.draws.index.iter().zip(&output.draws.values) {
        let chain = usize::try_from(index[0]).ok().and_then(|chain| chains.get_mut(chain));
        if let (Some(chain), Some(value)) = (chain, values.get(place)) {
            chain.push((index[1] as f64, shown.value(*value)));
        }
    }
    chains
}

fn trace(job: &str, output: &Output, place: usize) -> Figure {
    let name = &output.order[place];
    let layers = by_chain(output, place).into_iter().enumerate().map(|(chain, points)| Layer::Line {
        points,
        colour: palette::series(chain),
        stroke: Stroke::Solid,
        label: format!("chain {}", chain + 1),
    });
    let chart = Chart {
        x: Axis::new("Draw"),
        y: Axis::new(shown(output.parameters.get(name)).title(name)),
        layers: layers.collect(),
        height: 500,
        ..Chart::default()
    };
    Figure {
        id: format!("{job}-trace-{name}"),
        drawing: chart.draw(),
        caption: Text::new("Trace of ").code(name).plain(": the kept draws, chain by chain."),
        alternative: format!("Trace of {name}."),
    }
}

/// How often each chain's draws fall on each sixteenth of the ranks; even where the chains agree.
fn ranks(job: &str, output: &Output, place: usize) -> Figure {
    let name = &output.order[place];
    let chains = by_chain(output, place);
    let mut all: Vec<(f64, usize)> = chains
        .iter()
        .enumerate()
        .flat_map(|(chain, points)| points.iter().map(move |(_, value)| (*value, chain)))
        .collect();
    sort_by(&mut all, |a, b| a.0.total_cmp(&b.0));
    let mut counts = vec![[0_u32; RANK_BINS]; chains.len()];
    for (rank, (_, chain)) in all.iter().enumerate() {
        counts[*chain][rank * RANK_BINS / all.len()] += 1;
    }
    let layers = counts.iter().enumerate().map(|(chain, bins)| {
        let mut points: Vec<(f64, f64)> =
            bins.iter().enumerate().map(|(bin, count)| (bin as f64 / RANK_BINS as f64, f64::from(*count))).collect();
        points.push((1.0, f64::from(bins[RANK_BINS - 1])));
        Layer::Line {
            points,
            colour: palette::series(chain),
            stroke: Stroke::Step,
            label: format!("chain {}", chain + 1),
        }
    });
    let chart = Chart {
        x: Axis::over("Rank among all draws, as a share", 0.0, 1.0),
        y: Axis::new("Draws"),
        layers: layers.collect(),
        height: 420,
        ..Chart::default()
    };
    Figure {
        id: format!("{job}-ranks-{name}"),
        drawing: chart.draw(),
        caption: Text::new("Ranks of ").code(name).plain(" by chain; level lines mean that the chains agree."),
        alternative: format!("Rank plot of {name}."),
    }
}
