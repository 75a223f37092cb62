//! Samples to distributions, probabilities and joint distributions.

use super::output::{Case, Conditional, Distributed, FailedSample, Joint, Met, Probability, Quantile, Spec};
use crate::statistics::clusters::{Clusters, effective_samples};
use crate::statistics::histogram::{Histogram, PairHistogram, edges_sorted};
use crate::statistics::interval::Interval;
use crate::statistics::moments::{Moments, correlation};
use crate::statistics::quantile::{quantile_sorted, quantile_standard_error_sorted, sorted};
use crate::study::requirement::ALL;
use crate::thermal::Model;

/// Probabilities of the quantiles given.
const QUANTILES: [f64; 7] = [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99];
/// Points of the distribution function.
const CDF_POINTS: usize = 100;
/// Bins of each axis of a joint distribution.
const JOINT_BINS: usize = 24;
/// Confidence of intervals.
const CONFIDENCE: f64 = 0.95;

/// Summary of one case. `values` holds the samples of each quantity of the settings, NaN where a solution failed;
/// `clusters` the samples that share a draw.
pub fn case(
    spec: &Spec,
    model: &Model,
    (environment, design_value): (String, Option<f64>),
    values: &[Vec<f64>],
    clusters: &[Clusters],
    nominal: &[f64],
    failed: u64,
    failures: Vec<FailedSample>,
) -> Case {
    let quantities = spec
        .quantities
        .iter()
        .enumerate()
        .map(|(position, &index)| {
            let quantity = &model.quantities[index];
            let mut finite: Vec<f64> = values[position].iter().copied().filter(|v| v.is_finite()).collect();
            finite.sort_unstable_by(f64::total_cmp);
            let mut distributed = distribution(&finite, nominal[position]);
            if !clusters.is_empty() {
                let effective = effective_samples(clusters, &values[position]);
                widen(&mut distributed, (values[position].len() as f64 / effective).sqrt());
            }
            distributed.name.clone_from(&quantity.name);
            distributed.unit.clone_from(&quantity.unit);
            distributed.is_temperature = quantity.is_temperature;
            distributed
        })
        .collect();
    let joint = spec.joint.iter().map(|&pair| joint_of(spec, model, pair, values)).collect();
    Case {
        environment,
        design_value,
        quantities,
        requirements: requirements(spec, model, values, clusters),
        joint,
        main_effects: Vec::new(),
        failed,
        failures,
    }
}

/// Distribution of sorted finite samples.
fn distribution(sorted: &[f64], nominal: f64) -> Distributed {
    let moments = Moments::of(sorted);
    let histogram = Histogram::of_sorted(edges_sorted(sorted), sorted);
    Distributed {
        name: String::new(),
        unit: String::new(),
        is_temperature: false,
        nominal,
        mean: moments.mean(),
        mean_standard_error: moments.mean_standard_error(),
        sd: moments.sd(),
        sd_standard_error: moments.sd_standard_error(),
        minimum: sorted.first().copied().unwrap_or(f64::NAN),
        maximum: sorted.last().copied().unwrap_or(f64::NAN),
        quantiles: QUANTILES
            .iter()
            .map(|&probability| Quantile {
                probability,
                value: quantile_sorted(sorted, probability),
                standard_error: quantile_standard_error_sorted(sorted, probability),
            })
            .collect(),
        histogram_edges: histogram.edges,
        histogram_counts: histogram.counts,
        cdf: (0..CDF_POINTS).map(|i| quantile_sorted(sorted, (i as f64 + 0.5) / CDF_POINTS as f64)).collect(),
    }
}

/// Standard errors of samples that are not independent.
fn widen(distributed: &mut Distributed, factor: f64) {
    distributed.mean_standard_error *= factor;
    distributed.sd_standard_error *= factor;
    for quantile in &mut distributed.quantiles {
        quantile.standard_error *= factor;
    }
}

/// Each requirement, then all together where there are several.
fn requirements(spec: &Spec, model: &Model, values: &[Vec<f64>], clusters: &[Clusters]) -> Vec<Met> {
    let samples = values.first().map_or(0, Vec::len);
    let position_of = |quantity: usize| spec.quantities.iter().position(|&q| q == quantity);
    let mut all = vec![true; samples];
    let mut met_requirements = Vec::new();
    for requirement in &spec.requirements {
        let Some(position) = position_of(requirement.quantity) else { continue };
        let met_by_sample: Vec<bool> = values[position].iter().map(|&value| requirement.met(value)).collect();
        for (flag, &ok) in all.iter_mut().zip(&met_by_sample) {
            *flag &= ok;
        }
        let quantity = &model.quantities[requirement.quantity];
        met_requirements.push(Met {
            requirement: requirement.name.clone(),
            probability: probability(&met_by_sample, clusters),
            required: requirement.probability,
            below: requirement.below,
            above: requirement.above,
            unit: quantity.unit.clone(),
            quantity: quantity.name.clone(),
        });
    }
    if met_requirements.len() > 1 {
        let required = met_requirements.iter().map(|m| m.required).fold(0.0, f64::max);
        met_requirements.push(Met {
            requirement: ALL.to_owned(),
            probability: probability(&all, clusters),
            required,
            below: None,
            above: None,
            unit: String::new(),
            quantity: String::new(),
        });
    }
    met_requirements
}

fn probability(met: &[bool], clusters: &[Clusters]) -> Probability {
    let (count, samples) = (met.iter().filter(|&&ok| ok).count() as u64, met.len() as u64);
    let value = count as f64 / samples.max(1) as f64;
    let Interval { lower, upper } = if clusters.is_empty() {
        Interval::wilson(count, samples, CONFIDENCE)
    } else {
        let indicators: Vec<f64> = met.iter().map(|&ok| f64::from(u8::from(ok))).collect();
        Interval::wilson_effective(value, effective_samples(clusters, &indicators), CONFIDENCE)
    };
    Probability { value, lower, upper }
}

/// Joint distribution of two quantities, with the second's distribution where the first lies in each bin.
fn joint_of(spec: &Spec, model: &Model, [a, b]: [usize; 2], values: &[Vec<f64>]) -> Joint {
    let both: Vec<(f64, f64)> = values[a]
        .iter()
        .zip(&values[b])
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .map(|(&x, &y)| (x, y))
        .collect();
    let (x, y): (Vec<f64>, Vec<f64>) = both.iter().copied().unzip();
    let pairs = PairHistogram::new(equal_edges(&x), equal_edges(&y), &x, &y);
    let lines = pairs.y_edges.len().saturating_sub(1).max(1);
    let counts = pairs.counts.chunks(lines).map(<[u64]>::to_vec).collect();
    let (x_edges, y_edges) = (pairs.x_edges, pairs.y_edges);
    let mut conditional = Vec::new();
    for bin in x_edges.windows(2) {
        let last = bin[1] == x_edges[x_edges.len() - 1];
        let inside: Vec<f64> = both
            .iter()
            .filter(|(x, _)| *x >= bin[0] && (*x < bin[1] || last && *x <= bin[1]))
            .map(|&(_, y)| y)
            .collect();
        if inside.is_empty() {
            continue;
        }
        let inside = sorted(&inside);
        conditional.push(Conditional {
            x: 0.5 * (bin[0] + bin[1]),
            mean: Moments::of(&inside).mean(),
            q05: quantile_sorted(&inside, 0.05),
            q95: quantile_sorted(&inside, 0.95),
            samples: inside.len() as u64,
        });
    }
    let (first, second) = (&model.quantities[spec.quantities[a]], &model.quantities[spec.quantities[b]]);
    Joint {
        x: first.name.clone(),
        y: second.name.clone(),
        units: [first.unit.clone(), second.unit.clone()],
        correlation: Some(correlation(&x, &y)).filter(|r| r.is_finite()),
        x_edges,
        y_edges,
        counts,
        conditional,
    }
}

/// Edges of equal bins from the smallest to the largest value.
fn equal_edges(values: &[f64]) -> Vec<f64> {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
    if low >= high || !(high - low).is_finite() {
        return edges_sorted(values);
    }
    (0..=JOINT_BINS)
        .map(|i| if i == JOINT_BINS { high } else { low + (high - low) * i as f64 / JOINT_BINS as f64 })
        .collect()
}
