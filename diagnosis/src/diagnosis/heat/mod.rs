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

use std::collections::BTreeMap;

use crate::diagnosis::fits::evidence::{Amplitude, Cut, Evidence, Products};
use crate::diagnosis::output::{GoesWith, Heat};
use crate::diagnosis::{Problem, Refit};
use crate::math::cholesky;
use crate::math::dense::{dot_of_columns as dot, square};
use crate::math::functions::ln;
use crate::math::scalar_products::{products_between, products_of_all};
use crate::math::sort::sort_by_key;
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

/// The sources that move something, by kind, with the products of their columns as far as they were asked for.
struct Kinds<'a> {
    evidence: Evidence<'a>,
    columns: Vec<&'a [f64]>,
    norms: Vec<f64>,
    /// Positions of the sources of each kind.
    places: BTreeMap<Kind, Vec<usize>>,
    products: Vec<Products>,
    /// Products of two columns, the lower position first.
    between: BTreeMap<(usize, usize), f64>,
}

impl<'a> Kinds<'a> {
    fn new(state: &'a State, list: &[Source]) -> Self {
        let evidence = Evidence::new(&state.linear);
        let columns: Vec<&[f64]> = state.columns.iter().map(Vec::as_slice).collect();
        let norms = norms(&state.columns);
        let mut places: BTreeMap<Kind, Vec<usize>> = BTreeMap::new();
        for (place, source) in list.iter().enumerate().filter(|(place, _)| norms[*place] > 0.0) {
            places.entry(source.kind).or_default().push(place);
        }
        let mut between = BTreeMap::new();
        for own in places.values() {
            let of_kind: Vec<&[f64]> = own.iter().map(|&place| columns[place]).collect();
            for (&place, products) in own.iter().zip(products_of_all(&of_kind)) {
                between.extend(own.iter().zip(products).map(|(&other, product)| ((other, place), product)));
            }
        }
        Self { products: evidence.products(&columns), evidence, columns, norms, places, between }
    }

    /// Finds the products of all columns with those of a kind.
    fn take(&mut self, kind: Kind) {
        let own = self.places.get(&kind).map(Vec::as_slice).unwrap_or_default();
        let of_kind: Vec<&[f64]> = own.iter().map(|&place| self.columns[place]).collect();
        for (place, products) in products_between(&self.columns, &of_kind).into_iter().enumerate() {
            let pair = |other: usize| (place.min(other), place.max(other));
            self.between.extend(own.iter().zip(products).map(|(&other, product)| (pair(other), product)));
        }
    }

    /// The sources of kinds with sizes, ascending.
    fn needed(&self, with: &[(Kind, f64)]) -> Needed {
        let of = |(kind, size): &(Kind, f64)| {
            let own = self.places.get(kind).into_iter().flatten();
            own.map(|&place| (place, size / self.norms[place])).collect::<Needed>()
        };
        let mut needed: Needed = with.iter().flat_map(of).collect();
        sort_by_key(&mut needed, |(place, _)| *place);
        needed
    }

    fn log_evidence(&self, needed: &Needed) -> Option<f64> {
        let added: Vec<(Cut, &Products)> =
            needed.iter().map(|&(place, sd)| (Cut::nowhere(sd), &self.products[place])).collect();
        let between = |one: usize, other: usize| {
            let (one, other) = (needed[one].0, needed[other].0);
            self.between.get(&(one.min(other), one.max(other))).copied().unwrap_or(f64::NAN)
        };
        self.evidence.log_evidence_by_products(&added, &between)
    }

    /// Adds the kind that raises the evidence most, while it pays for its choice among all kinds and sizes. What comes back
    /// are the kinds, their sources, and the price of all choices.
    fn choose(&mut self) -> Option<(Vec<Kind>, Needed, f64)> {
        let without = self.evidence.log_evidence(&[])?;
        let price = ln((self.places.len() * SIZES.len()).max(1) as f64);
        let (mut kept, mut chosen, mut highest): (Vec<(Kind, f64)>, Needed, f64) = (Vec::new(), Vec::new(), 0.0);
        while kept.len() < MOST_KINDS {
            let mut best: Option<(f64, (Kind, f64), Needed)> = None;
            for &kind in self.places.keys().filter(|kind| !kept.iter().any(|(kept_kind, _)| kept_kind == *kind)) {
                for size in SIZES {
                    watch::check();
                    let with: Vec<(Kind, f64)> = kept.iter().copied().chain([(kind, size)]).collect();
                    let needed = self.needed(&with);
                    let Some(value) = self.log_evidence(&needed) else { continue };
                    let gain = value - without - with.len() as f64 * price;
                    if best.as_ref().is_none_or(|(best_gain, _, _)| gain > *best_gain) {
                        best = Some((gain, (kind, size), needed));
                    }
                }
            }
            match best {
                Some((gain, kind, best_needed)) if gain > highest => {
                    self.take(kind.0);
                    kept.push(kind);
                    chosen = best_needed;
                    highest = gain;
                }
                _ => break,
            }
        }
        let paid = kept.len() as f64 * price;
        Some((kept.into_iter().map(|(kind, _)| kind).collect(), chosen, paid))
    }
}

fn amplitudes<'a>(state: &'a State, chosen: &Needed) -> Vec<Amplitude<'a>> {
    let free = |&(place, sd): &(usize, f64)| Amplitude { values: &state.columns[place], prior: Cut::nowhere(sd) };
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
    let products = products_of_all(&columns);
    let mut factor = square(k, |a, b| products[a.max(b)][a.min(b)]);
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
    state.half_square + penalty(&state.amplitudes, chosen)
}

/// What the amplitudes' distribution beforehand adds to it.
fn penalty(amplitudes: &[f64], chosen: &Needed) -> f64 {
    0.5 * chosen.iter().map(|&(place, sd)| amplitudes[place] * amplitudes[place] / (sd * sd)).sum::<f64>()
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
            let unknowns = sources.stepped(&state.unknowns, &shorter)?;
            let after = sources.half_square(&unknowns, &amplitudes)? + penalty(&amplitudes, chosen);
            (after < before).then_some((unknowns, amplitudes))
        });
        let next = next.and_then(|(unknowns, amplitudes)| sources.at(&unknowns, &amplitudes));
        let Some(next) = next.filter(|next| objective(next, chosen) < before) else { break };
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
    let (kinds, chosen, price) = Kinds::new(&state, list).choose().ok_or(NoHeat::NotDetermined)?;
    // From here on sources that are not needed have no heat.
    let places: Vec<usize> = (0..list.len()).filter(|&place| kinds.contains(&list[place].kind)).collect();
    let chosen: Needed =
        chosen.into_iter().map(|(place, sd)| (places.partition_point(|&other| other < place), sd)).collect();
    let sources = Sources::of(problem, &|kind| kinds.contains(&kind))?;
    let list = sources.list();
    let state = settle(&sources, state.only(&places), &chosen);
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
