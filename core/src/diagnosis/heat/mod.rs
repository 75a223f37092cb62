//! Heat that the baseline model lacks, whatever its cause: in steady data independent in every node and phase, in
//! transients in every node and stretch of time, beside a bias of every sensor.
//!
//! With `H` the whitened effect of these sources, columns scaled to norm 1, and amplitudes `q ~ N(0, s^2)`, the residuals
//! freed of the parameters are normal with covariance `I + s^2 H H'`; so evidence and heat are known in closed form
//! (Rasmussen & Williams 2006, section 2.7). Nodes and sensors are added one by one, each with the best of four sizes s,
//! while the evidence rises by more than the logarithm of the number of choices. Then the model is linearised anew with
//! the heat in it, until it stays: the heat may have let the parameters go far from where they were without it.

mod relations;
pub mod sources;

use crate::diagnosis::fits::evidence::{Amplitude, Evidence};
use crate::diagnosis::output::{GoesWith, Heat};
use crate::diagnosis::{Problem, Refit};
use crate::math::cholesky;
use crate::math::dense::{dot_of_columns as dot, square};
use crate::math::functions::ln;
use crate::watch;
use relations::relations;
use sources::{Kind, NoHeat, Source, Sources, State, norms};

/// Most nodes and sensors.
const MOST_KINDS: usize = 4;
/// Sizes s that are tried, in standard deviations of the noise.
const SIZES: [f64; 4] = [1.0, 4.0, 16.0, 64.0];
/// Most linearisations with heat.
const MOST_STEPS: usize = 6;
/// Shares of a step that are tried.
const SHARES: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];
/// Fall of half the sum of squares below which the linearisation stays.
const STAYS: f64 = 0.02;

/// The heat that is missing.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingHeat {
    /// Log evidence of a model with such sources.
    pub log_evidence: f64,
    /// The heat of each node and phase or stretch.
    pub heat: Vec<Heat>,
    /// What it goes with.
    pub goes_with: Vec<GoesWith>,
}

/// Sources that are needed: position and standard deviation of the amplitude beforehand.
type Needed = Vec<(usize, f64)>;

/// Adds the kind that raises the evidence most, while it pays for its choice among all kinds and sizes. What comes back
/// are the sources and the price of all choices.
fn needed(state: &State, list: &[Source], norms: &[f64], without: f64) -> (Needed, f64) {
    let evidence = Evidence::new(&state.linear);
    let mut kinds: Vec<Kind> = Vec::new();
    for (source, norm) in list.iter().zip(norms) {
        if *norm > 0.0 && !kinds.contains(&source.kind) {
            kinds.push(source.kind);
        }
    }
    let price = ln((kinds.len() * SIZES.len()).max(1) as f64);
    let (mut kept, mut chosen, mut highest): (Vec<(Kind, f64)>, Needed, f64) = (Vec::new(), Vec::new(), 0.0);
    while kept.len() < MOST_KINDS {
        let mut best: Option<(f64, (Kind, f64), Needed)> = None;
        for &kind in kinds.iter().filter(|kind| !kept.iter().any(|(kept_kind, _)| kept_kind == *kind)) {
            for size in SIZES {
                watch::check();
                let with: Vec<(Kind, f64)> = kept.iter().copied().chain([(kind, size)]).collect();
                let needed_sources: Needed = (0..list.len())
                    .filter(|&place| norms[place] > 0.0)
                    .filter_map(|place| {
                        let (_, size) = with.iter().find(|(sized_kind, _)| *sized_kind == list[place].kind)?;
                        Some((place, size / norms[place]))
                    })
                    .collect();
                let Some(value) = evidence.log_evidence(&amplitudes(state, &needed_sources)) else { continue };
                let gain = value - without - with.len() as f64 * price;
                if best.as_ref().is_none_or(|(best_gain, _, _)| gain > *best_gain) {
                    best = Some((gain, (kind, size), needed_sources));
                }
            }
        }
        match best {
            Some((gain, kind, best_needed)) if gain > highest => {
                kept.push(kind);
                chosen = best_needed;
                highest = gain;
            }
            _ => break,
        }
    }
    let paid = kept.len() as f64 * price;
    (chosen, paid)
}

fn amplitudes<'a>(state: &'a State, chosen: &Needed) -> Vec<Amplitude<'a>> {
    let free = |&(place, sd): &(usize, f64)| Amplitude {
        values: &state.columns[place],
        sd,
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
    };
    chosen.iter().map(free).collect()
}

/// Most probable step of the parameters and amplitudes of the chosen sources, and the amplitudes' standard deviations, of
/// the linear problem with no bound but those that hold already.
fn solve(state: &State, chosen: &Needed) -> Option<(Vec<f64>, Vec<f64>, Vec<f64>)> {
    let linear = &state.linear;
    let n = linear.parameters();
    let free: Vec<usize> = (0..n).filter(|&i| linear.lower[i] < 0.0 && linear.upper[i] > 0.0).collect();
    let slopes: Vec<Vec<f64>> =
        free.iter().map(|&i| (0..linear.rows).map(|row| linear.jacobian[row * n + i]).collect()).collect();
    let columns: Vec<&[f64]> = slopes
        .iter()
        .map(Vec::as_slice)
        .chain(chosen.iter().map(|&(place, _)| state.columns[place].as_slice()))
        .collect();
    let first = free.len();
    let k = columns.len();
    let mut factor = square(k, |a, b| dot(columns[a], columns[b]));
    for (position, &i) in free.iter().enumerate() {
        // What the data do not see stays where it is.
        let width = linear.upper[i] - linear.lower[i];
        factor[position * k + position] += if width.is_finite() { 1e-6 / (width * width) } else { 0.0 };
    }
    for (position, (_, sd)) in chosen.iter().enumerate() {
        factor[(first + position) * k + first + position] += 1.0 / (sd * sd);
    }
    cholesky::factor(&mut factor, k).ok()?;
    let mut mean: Vec<f64> = columns.iter().map(|column| dot(column, &linear.residuals)).collect();
    cholesky::solve(&factor, &mut mean);
    let covariance = cholesky::inverse(&factor, k);
    let mut step = vec![0.0; n];
    for (position, &i) in free.iter().enumerate() {
        step[i] = mean[position].max(linear.lower[i]).min(linear.upper[i]);
    }
    let heat: Vec<f64> = (0..chosen.len()).map(|k| mean[first + k]).collect();
    let sds = (0..chosen.len()).map(|source| covariance[(first + source) * (k + 1)].max(0.0).sqrt()).collect();
    Some((step, heat, sds))
}

/// What the fit with sources minimises.
fn objective(state: &State, chosen: &Needed) -> f64 {
    let square = |&(place, sd): &(usize, f64)| state.amplitudes[place] * state.amplitudes[place] / (sd * sd);
    state.half_square + 0.5 * chosen.iter().map(square).sum::<f64>()
}

/// The linearisation at the most probable state with the chosen sources: damped Gauss-Newton steps.
fn settle(sources: &Sources, mut state: State, chosen: &Needed) -> State {
    for _ in 0..MOST_STEPS {
        let Some((step, heat, _)) = solve(&state, chosen) else { break };
        let before = objective(&state, chosen);
        let next = SHARES.into_iter().find_map(|share| {
            let shorter: Vec<f64> = step.iter().map(|d| share * d).collect();
            let mut amplitudes = state.amplitudes.clone();
            for (&(place, _), q) in chosen.iter().zip(&heat) {
                amplitudes[place] += share * (q - amplitudes[place]);
            }
            let next = sources.at(&sources.stepped(&state.unknowns, &shorter)?, &amplitudes)?;
            (objective(&next, chosen) < before).then_some(next)
        });
        let Some(next) = next else { break };
        let fall = before - objective(&next, chosen);
        state = next;
        if fall < STAYS {
            break;
        }
    }
    state
}

/// The heat that a fit of the baseline model lacks.
///
/// # Errors
/// Why it is not known.
pub fn missing_heat(problem: &Problem, baseline: &Refit) -> Result<MissingHeat, NoHeat> {
    let sources = Sources::new(problem)?;
    let list = sources.list();
    let state = sources.at(&baseline.unknowns, &vec![0.0; list.len()]).ok_or(NoHeat::NotSolved)?;
    let without = Evidence::new(&state.linear).log_evidence(&[]).ok_or(NoHeat::NotDetermined)?;
    let norms = norms(&state.columns);
    let (chosen, price) = needed(&state, list, &norms, without);
    let state = settle(&sources, state, &chosen);
    let with = Evidence::new(&state.linear).log_evidence(&amplitudes(&state, &chosen)).ok_or(NoHeat::NotDetermined)?;
    // Biases alone are an effect of the catalogue, not something else.
    let has_heat = chosen.iter().any(|&(place, _)| matches!(list[place].kind, Kind::Node(_)));
    // Not as a difference to the baseline fit: where that is forced to sums of squares of 1e8, it is off by millions.
    let log_evidence = match has_heat {
        true => with + sources.constant(&state, baseline).ok_or(NoHeat::NotDetermined)? - price,
        false => f64::NEG_INFINITY,
    };
    let (_, amplitudes, sds) = solve(&state, &chosen).ok_or(NoHeat::NotDetermined)?;
    let mut heat = Vec::new();
    for ((&(place, _), watts), sd) in chosen.iter().zip(&amplitudes).zip(sds) {
        let source = &list[place];
        let Kind::Node(node) = source.kind else { continue };
        let node = problem.model.nodes[node].name.clone();
        heat.push(Heat { node, phase: source.phase.clone(), time_s: source.time_s, watts: *watts, sd });
    }
    let watts: Vec<(&Source, f64)> =
        chosen.iter().zip(&amplitudes).map(|(&(place, _), watts)| (&list[place], *watts)).collect();
    Ok(MissingHeat { log_evidence, heat, goes_with: relations(problem, &watts) })
}
