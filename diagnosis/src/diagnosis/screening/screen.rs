//! Screening: what each effect and each pair of effects would do to the misfit at a fit, and the family of tests.

use crate::diagnosis::FitError;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::diagnosis::engine::{Diagnosis, SensorNoise};
use crate::diagnosis::linearisation::between_rows::BetweenRows;
use crate::diagnosis::linearisation::bounded::Place;
use crate::diagnosis::linearisation::signature::{self, Signatures};
use crate::diagnosis::misspecified::is_unstated;
use crate::diagnosis::noise::estimate;
use crate::diagnosis::noise::restricted_likelihood::LinearFit;
use crate::diagnosis::odds::narrow_prior::is_prior;
use crate::diagnosis::odds::posterior_odds::nothing_stands;
use crate::diagnosis::odds::prior_scale::{IMPLAUSIBLE, WIDTHS};
use crate::diagnosis::screening::between_values::shapes_between;
use crate::diagnosis::screening::detectable::detectable;
use crate::diagnosis::screening::family::{Extras, Family, MemberKind};
use crate::diagnosis::screening::pairs::best_pairs;
use crate::diagnosis::screening::score::{Column, Prepared, Score};
use crate::diagnosis::{Direction, Linear, Problem, Refit};
use crate::effect::Site;
use crate::inference::likelihood::Likelihood;
use crate::inference::null_maximum::Sampling;
use crate::math::sort::sort_by;
use crate::measurement::{Measurement, Rows, Uncertain};

/// Effects that are kept.
const MOST_LEADS: usize = 80;
/// Pairs that are kept.
const MOST_PAIRS: usize = 300;
/// Pairs of one effect that are kept.
const MOST_PARTNERS: usize = 12;
/// Single-column directions among which pairs are sought.
const MOST_IN_PAIRS: usize = 1500;
/// The same for the pair beside which the noise is estimated.
const MOST_BESIDE_NOISE: usize = 400;
/// Pairs of nodes with an effect that is tried at finite values; all those of ten nodes.
const MOST_PAIRS_PROBED: usize = 45;
/// Numbers of all columns above which only the best directions are held: 200 MB, of which a screening needs a few copies.
pub(crate) const MOST_ENTRIES: usize = 25_000_000;
/// Draws of the family-wise probability.
const DRAWS: usize = 1000;
/// Draws of the probability that is critical for a member: 8 % of it are 1 % of a detectable amplitude.
const DRAWS_OF_CRITICAL: usize = 250;
/// Rounds in which the noise is estimated.
const NOISE_ROUNDS: usize = 3;
/// The name of the test of parameters at their bounds.
pub(crate) const AT_BOUNDS: &str = "parameters at bounds";
/// Power at which amplitudes are said to be detectable.
const POWER: f64 = 0.9;
/// Best directions of an effect that are starts of its fit.
const MOST_STARTS: usize = 3;

/// An effect that stands out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lead {
    /// Position of the candidate.
    pub candidate: usize,
    /// By how much it lowers the sum of squares, less two for each further freedom that it takes.
    pub fall: f64,
    /// Starts of its parameters by name, SI.
    pub starts: Vec<BTreeMap<String, f64>>,
}

/// A test of the family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FamilyTest {
    /// What was tested.
    pub name: String,
    /// What it found worst.
    pub at: String,
    /// Its p-value alone.
    pub p: f64,
}

/// The tests together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FamilySummary {
    /// Family-wise p.
    pub p: f64,
    /// The best of each kind of test.
    pub tests: Vec<FamilyTest>,
}

/// The effects and the pairs that explain most, the best first.
pub(crate) struct Foremost {
    pub leads: Vec<Lead>,
    pub pairs: Vec<[Lead; 2]>,
}

/// What screening found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Screening {
    /// Single effects, best first.
    pub leads: Vec<Lead>,
    /// Pairs, best first.
    pub pairs: Vec<[Lead; 2]>,
    /// Number of pairs.
    pub pairs_screened: u64,
    /// The tests.
    pub family: FamilySummary,
    /// What the data cannot see: position and why.
    pub unseen: Vec<(usize, String)>,
    /// What would have been seen: position, amplitude and unit.
    pub detectable: Vec<(usize, f64, String)>,
}

/// A pair of directions by their positions, with amplitudes and the fall of the sum of squares.
type BestPair = ([usize; 2], [f64; 2], f64);

/// What a direction would explain.
#[derive(Clone)]
struct Explains {
    /// By how much it lowers the sum of squares, as [`Lead::fall`].
    fall: f64,
    /// The direction, without its columns.
    direction: Direction,
    amplitudes: Vec<f64>,
}

impl Explains {
    fn new(direction: &Direction, score: &Score) -> Self {
        Self { fall: fall(score), direction: direction.without_columns(), amplitudes: score.amplitudes.clone() }
    }
}

/// The linearised problem with everything that was scored.
struct Scored<'a> {
    linear: &'a Linear,
    prepared: Prepared,
    /// The same in the coordinates that directions had last.
    in_coordinates: Option<(Arc<BetweenRows>, Prepared)>,
    directions: Vec<Direction>,
    scores: Vec<Score>,
    /// The best direction of each candidate, also of those that were not kept.
    best_of: BTreeMap<usize, Explains>,
    /// Numbers of all columns.
    held: usize,
    /// Directions that were not kept, and pairs that were not tried.
    left_out: u64,
}

impl<'a> Scored<'a> {
    fn new(linear: &'a Linear) -> Self {
        let prepared = Prepared::new(linear);
        Self {
            linear,
            prepared,
            in_coordinates: None,
            directions: Vec::new(),
            scores: Vec::new(),
            best_of: BTreeMap::new(),
            held: 0,
            left_out: 0,
        }
    }

    /// Takes directions and scores them; in between only the best are kept.
    fn take(&mut self, directions: Vec<Direction>) {
        self.held += directions.iter().map(|direction| self.entries(direction)).sum::<usize>();
        let coordinates = directions.iter().find_map(|direction| direction.coordinates.as_ref());
        let is_new = |coordinates: &&Arc<BetweenRows>| {
            self.in_coordinates.as_ref().is_none_or(|(last, _)| !Arc::ptr_eq(last, coordinates))
        };
        if let Some(coordinates) = coordinates.filter(is_new) {
            let mut prepared = Prepared::new(&coordinates.linear(self.linear));
            prepared.largest = self.prepared.largest;
            self.in_coordinates = Some((Arc::clone(coordinates), prepared));
        }
        let score = |direction: &Direction| match (&direction.coordinates, &self.in_coordinates) {
            (Some(_), Some((_, prepared))) => prepared.score(direction),
            _ => self.prepared.score(direction),
        };
        let first = self.scores.len();
        self.scores.par_extend(directions.par_iter().map(score));
        for (direction, score) in directions.iter().zip(&self.scores[first..]).filter(|(_, score)| score.seen) {
            let known = self.best_of.get(&direction.candidate);
            if known.is_none_or(|known| fall(score) > known.fall) {
                self.best_of.insert(direction.candidate, Explains::new(direction, score));
            }
        }
        self.directions.extend(directions);
        if self.held >= 2 * MOST_ENTRIES {
            self.keep(MOST_ENTRIES);
        }
    }

    /// Numbers of a direction's columns on all rows.
    fn entries(&self, direction: &Direction) -> usize {
        direction.amplitudes() * self.linear.rows
    }

    /// Scores all wanted directions at a fit, of the candidates that are tried. Where they are too many to be held, only the best are kept.
    fn best<'b>(
        problem: &'b Problem,
        likelihood: &'b Likelihood,
        unknowns: &'b [f64],
        linear: &'a Linear,
        is_tried: impl Fn(usize) -> bool,
        wanted: impl Fn(&Direction) -> bool,
    ) -> Result<(Self, Vec<signature::Unseen>, Signatures<'b>), FitError> {
        let signatures = Signatures::new(problem, likelihood, unknowns)?;
        let mut scored = Self::new(linear);
        if problem.is_misspecified {
            // What a model lacks that is wrong everywhere may be far from what the catalogue takes for plausible.
            scored.prepared.largest *= WIDTHS[IMPLAUSIBLE].factor;
        }
        let find = |scored: &mut Self, positions: &[usize]| {
            let mut give = |mut directions: Vec<Direction>| {
                directions.retain(&wanted);
                scored.take(directions);
            };
            signatures.for_each(positions, &mut give)
        };
        let mut late = signature::probed_pairs(problem);
        if late.len() <= MOST_PAIRS_PROBED {
            late.clear();
        }
        let is_first = |place: &usize| late.binary_search(place).is_err() && is_tried(*place);
        let first: Vec<usize> = (0..problem.candidates.len()).filter(is_first).collect();
        let mut unseen = find(&mut scored, &first)?;
        if !late.is_empty() {
            let all = late.len();
            let chosen = scored.likeliest_pairs(problem, late);
            scored.left_out += (all - chosen.len()) as u64;
            unseen.extend(find(&mut scored, &chosen)?);
        }
        scored.end();
        Ok((scored, unseen, signatures))
    }

    /// What the effects that explain most would explain about their best dates and thresholds, the best of each.
    fn between_values(
        &self,
        problem: &Problem,
        signatures: Signatures<'_>,
    ) -> Result<BTreeMap<usize, Explains>, FitError> {
        let mut ranked: Vec<&Explains> = self.best_of.values().collect();
        sort_by(&mut ranked, |a, b| b.fall.total_cmp(&a.fall));
        let shapes = shapes_between(problem, ranked.into_iter().map(|own| &own.direction));
        let mut between = Self::new(self.linear);
        between.prepared.largest = self.prepared.largest;
        signatures.at_shapes(shapes, &mut |directions| {
            between.take(directions);
            between.keep(0);
        })?;
        Ok(between.best_of)
    }

    /// The best directions with all their rows.
    fn end(&mut self) {
        self.keep(MOST_ENTRIES);
        self.directions = std::mem::take(&mut self.directions).into_par_iter().map(Direction::on_all_rows).collect();
        self.in_coordinates = None;
    }

    /// Of pairs of nodes those where other effects explain most: at both nodes, as a path does, or the same one at one of
    /// them. A part between two nodes is a path that also stores heat.
    fn likeliest_pairs(&self, problem: &Problem, pairs: Vec<usize>) -> Vec<usize> {
        let mut falls: BTreeMap<(&str, Vec<usize>), f64> = BTreeMap::new();
        for (place, direction) in self.directions.iter().enumerate() {
            let candidate = &problem.candidates[direction.candidate];
            let key = match &candidate.site {
                Site::Pair(nodes) => ("", nodes.to_vec()),
                Site::Nodes(nodes) if nodes.len() == 1 => (candidate.effect.as_str(), vec![nodes[0].0]),
                _ => continue,
            };
            let fall = falls.entry(key).or_insert(0.0);
            *fall = fall.max(self.fall(place));
        }
        let of = |position: usize| {
            let Site::Pair([a, b]) = problem.candidates[position].site else { return 0.0 };
            let fall = |key: (&str, Vec<usize>)| falls.get(&key).copied().unwrap_or(0.0);
            let own = problem.candidates[position].effect.as_str();
            fall(("", vec![a, b])) + fall((own, vec![a])).max(fall((own, vec![b])))
        };
        let mut order: Vec<(f64, usize)> = pairs.into_iter().map(|position| (of(position), position)).collect();
        sort_by(&mut order, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut chosen: Vec<usize> = order.into_iter().take(MOST_PAIRS_PROBED).map(|(_, position)| position).collect();
        chosen.sort_unstable();
        chosen
    }

    /// Keeps the best directions whose columns have no more numbers together, in their order.
    fn keep(&mut self, entries: usize) {
        let before = self.directions.len();
        let mut order: Vec<usize> = (0..before).collect();
        sort_by(&mut order, |&a, &b| self.fall(b).total_cmp(&self.fall(a)).then(a.cmp(&b)));
        let mut held = 0;
        order.retain(|&place| {
            held += self.entries(&self.directions[place]);
            held <= entries
        });
        order.sort_unstable();
        self.directions = order.iter().map(|&place| std::mem::take(&mut self.directions[place])).collect();
        self.scores = order.iter().map(|&place| self.scores[place].clone()).collect();
        self.held = self.directions.iter().map(|direction| self.entries(direction)).sum();
        self.left_out += (before - order.len()) as u64;
    }

    fn fall(&self, position: usize) -> f64 {
        fall(&self.scores[position])
    }

    /// Positions of directions, best first.
    fn ranked(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.directions.len()).filter(|&d| self.scores[d].seen).collect();
        sort_by(&mut order, |&a, &b| self.fall(b).total_cmp(&self.fall(a)).then(a.cmp(&b)));
        order
    }

    /// The best pairs of different effects, of the `among` best directions of one column: positions and amplitudes.
    fn pairs(&self, among: usize, count: usize) -> Vec<BestPair> {
        let single = self.ranked().into_iter().filter(|&d| self.directions[d].amplitudes() == 1);
        let mut chosen: Vec<usize> = single.take(among).collect();
        chosen.sort_unstable();
        let directions: Vec<Direction> = chosen.iter().map(|&d| self.directions[d].clone()).collect();
        let scores: Vec<Score> = chosen.iter().map(|&d| self.scores[d].clone()).collect();
        best_pairs(&self.prepared, &directions, &scores, count)
            .into_iter()
            .map(|pair| ([chosen[pair.first], chosen[pair.second]], pair.amplitudes, pair.likelihood_ratio))
            .filter(|([a, b], _, _)| self.directions[*a].candidate != self.directions[*b].candidate)
            .collect()
    }
}

/// What orders directions: the fall of the sum of squares, less two for each freedom beyond the first.
fn fall(score: &Score) -> f64 {
    score.likelihood_ratio - 2.0 * (score.freedom - 1.0).max(0.0)
}

impl Diagnosis {
    /// Screens what a fit of the problem's model leaves; where that is nothing, `whole` also
    /// finds what would have been detected.
    pub(crate) fn screen_problem(&self, problem: &Problem, refit: &Refit, whole: bool) -> Result<Screening, FitError> {
        let likelihood = self.likelihood(problem)?;
        let linear = signature::linearise(&likelihood, &refit.unknowns)?;
        let (scored, unseen, signatures) =
            Scored::best(problem, &likelihood, &refit.unknowns, &linear, |_| true, |_| true)?;
        let (groups, names) = groups(problem, &likelihood);
        let estimated = problem.noise_freedom;
        let extras = Extras { groups: &groups, bounds: true, priors: true, omnibus: estimated.is_none() };
        let mut family = Family::new(&scored.prepared, &scored.directions, &scored.scores, &extras, estimated);
        let sampling = Sampling { key: *self.key(), draws: DRAWS };
        let judged = family.test(&sampling);
        // What was left out might have been found: all of them are paid for (Bonferroni).
        let all = (judged.members.len() as u64 + scored.left_out) as f64;
        let p = if scored.left_out > 0 { judged.p.max(judged.smallest_p * all) } else { judged.p }.clamp(0.0, 1.0);
        let mut tests: Vec<FamilyTest> = Vec::new();
        for member in &judged.members {
            let (name, at) = match member.kind {
                MemberKind::Direction(d) => ("effects", problem.candidates[scored.directions[d].candidate].id.clone()),
                MemberKind::Group(group) => ("means of residuals", names[group].clone()),
                MemberKind::Bound(parameter) => (AT_BOUNDS, refit.names.get(parameter).cloned().unwrap_or_default()),
                MemberKind::Prior(_) => ("distance from the priors", String::new()),
                MemberKind::Omnibus => ("sum of squares", String::new()),
            };
            match tests.iter_mut().find(|test| test.name == name) {
                Some(test) if test.p <= member.p => {}
                Some(test) => (test.at, test.p) = (at, member.p),
                None => tests.push(FamilyTest { name: name.to_owned(), at, p: member.p }),
            }
        }
        let mut screening = Screening {
            leads: self.leads(problem, &scored, signatures)?,
            pairs: Vec::new(),
            pairs_screened: 0,
            family: FamilySummary { p, tests },
            unseen: unseen.into_iter().map(|one| (one.candidate, one.reason.to_string())).collect(),
            detectable: Vec::new(),
        };
        let singles = scored.directions.iter().filter(|direction| direction.amplitudes() == 1).count() as u64;
        screening.pairs_screened = singles * singles.saturating_sub(1) / 2;
        let mut partners: BTreeMap<usize, usize> = BTreeMap::new();
        for pair in scored.pairs(MOST_IN_PAIRS, MOST_PAIRS) {
            // One effect that stands out would fill the list with whatever goes beside it.
            let ends = pair.0.map(|d| scored.directions[d].candidate);
            if ends.iter().any(|candidate| partners.get(candidate).copied().unwrap_or(0) >= MOST_PARTNERS) {
                continue;
            }
            ends.iter().for_each(|candidate| *partners.entry(*candidate).or_default() += 1);
            screening.pairs.push(self.pair(problem, &scored, pair));
        }
        let mut is_seen: BTreeMap<usize, bool> = BTreeMap::new();
        for (direction, score) in scored.directions.iter().zip(&scored.scores) {
            *is_seen.entry(direction.candidate).or_default() |= score.seen;
        }
        for (position, is_seen) in is_seen {
            if !is_seen {
                let why = if is_prior(&problem.candidates[position]) {
                    "nothing presses the parameter out of its prior"
                } else {
                    "within its plausible size it moves no reading by more than the parameters can take up"
                };
                screening.unseen.push((position, why.to_owned()));
            }
        }
        if whole && (p > self.settings().false_alarm || nothing_stands(1.0, p)) {
            let sampling = Sampling { draws: DRAWS_OF_CRITICAL, ..sampling };
            let critical_p = family.critical(self.settings().false_alarm, &sampling);
            for direction in scored.directions.iter().filter(|direction| direction.amplitudes() == 1) {
                if screening.detectable.iter().any(|(candidate, _, _)| *candidate == direction.candidate) {
                    continue;
                }
                let amplitude = detectable(&scored.prepared, direction, critical_p, POWER, estimated);
                if let Some(amplitude) = amplitude.filter(|amplitude| amplitude.is_finite()) {
                    screening.detectable.extend(shown(problem, direction, amplitude));
                }
            }
        }
        Ok(screening)
    }

    pub(crate) fn likelihood(&self, problem: &Problem) -> Result<Likelihood, FitError> {
        let baseline = problem.hypothesis(&[], 1.0)?;
        baseline.likelihood(problem)
    }

    /// What effects would explain of what a fit of the problem's model leaves, the best first, without any test.
    pub(crate) fn leads_beside(&self, problem: &Problem, refit: &Refit) -> Result<Vec<Lead>, FitError> {
        let likelihood = self.likelihood(problem)?;
        let linear = signature::linearise(&likelihood, &refit.unknowns)?;
        let (scored, _, signatures) = Scored::best(problem, &likelihood, &refit.unknowns, &linear, |_| true, |_| true)?;
        self.leads(problem, &scored, signatures)
    }

    /// Of some candidates what they would explain of what a fit leaves, the best first; `refit` is that of the problem's model.
    pub(crate) fn leads_among(
        &self,
        problem: &Problem,
        refit: &Refit,
        positions: &[usize],
    ) -> Result<Vec<Lead>, FitError> {
        let likelihood = self.likelihood(problem)?;
        let linear = signature::linearise(&likelihood, &refit.unknowns)?;
        let mut scored = Scored::new(&linear);
        let signatures = Signatures::new(problem, &likelihood, &refit.unknowns)?;
        signatures.for_each(positions, &mut |directions| scored.take(directions))?;
        scored.end();
        self.leads(problem, &scored, signatures)
    }

    /// The effects, best first, with starts from their best directions.
    fn leads(&self, problem: &Problem, scored: &Scored<'_>, signatures: Signatures<'_>) -> Result<Vec<Lead>, FitError> {
        let mut between = scored.between_values(problem, signatures)?;
        // What is better there stands for the best direction of the same effect.
        let in_place = scored.ranked().into_iter().map(|d| {
            let (direction, own) = (&scored.directions[d], scored.fall(d));
            let better = between.remove(&direction.candidate).filter(|better| better.fall > own);
            better.unwrap_or_else(|| Explains::new(direction, &scored.scores[d]))
        });
        let mut order: Vec<Explains> = in_place.collect();
        let kept: BTreeSet<usize> = order.iter().map(|own| own.direction.candidate).collect();
        // Of candidates without a direction that was kept, too.
        for (candidate, own) in scored.best_of.iter().filter(|(candidate, _)| !kept.contains(candidate)) {
            let better = between.remove(candidate).filter(|better| better.fall > own.fall);
            order.push(better.unwrap_or_else(|| own.clone()));
        }
        sort_by(&mut order, |a, b| b.fall.total_cmp(&a.fall));
        Ok(self.in_order(problem, order))
    }

    /// The effects of directions in the order of these, each with starts from its first ones.
    fn in_order(&self, problem: &Problem, order: Vec<Explains>) -> Vec<Lead> {
        let mut leads: Vec<Lead> = Vec::new();
        for Explains { fall, direction, amplitudes } in order {
            let start = || self.start(problem, &direction, &amplitudes);
            let full = leads.len() >= MOST_LEADS;
            match leads.iter_mut().find(|lead| lead.candidate == direction.candidate) {
                Some(lead) if lead.starts.len() < MOST_STARTS => lead.starts.push(start()),
                Some(_) => {}
                None if !full => leads.push(Lead { candidate: direction.candidate, fall, starts: vec![start()] }),
                None => {}
            }
        }
        leads
    }

    /// A pair of directions with their amplitudes as a pair of effects.
    fn pair(&self, problem: &Problem, scored: &Scored<'_>, (ends, amplitudes, fall): BestPair) -> [Lead; 2] {
        let lead = |d: usize, amplitude: f64| Lead {
            candidate: scored.directions[d].candidate,
            fall,
            starts: vec![self.start(problem, &scored.directions[d], &[amplitude])],
        };
        [lead(ends[0], amplitudes[0]), lead(ends[1], amplitudes[1])]
    }

    /// Values of an effect's parameters at amplitudes of one of its directions, within the priors.
    fn start(&self, problem: &Problem, direction: &Direction, amplitudes: &[f64]) -> BTreeMap<String, f64> {
        let candidate = &problem.candidates[direction.candidate];
        if let Site::Parameter(index) = candidate.site {
            let at = direction.shape.iter().sum::<f64>() + amplitudes.iter().sum::<f64>();
            let Some(wide) = self.problem().wider_prior(index, 1.0) else { return BTreeMap::new() };
            let (least, most) = wide.support();
            let at = if at <= least { wide.quantile(1e-3) } else { at };
            let at = if at >= most { wide.quantile(1.0 - 1e-3) } else { at };
            return BTreeMap::from([(problem.model.parameters[index].name.clone(), at)]);
        }
        let Some(effect) = problem.catalogue.get(&candidate.effect) else { return BTreeMap::new() };
        let parameters = effect.parameters(&self.problem().model, &candidate.bound);
        let mut values: Vec<f64> = parameters.iter().map(|parameter| parameter.nominal).collect();
        if direction.probe.is_empty() {
            for (&place, amplitude) in direction.parameters.iter().zip(amplitudes) {
                values[place] = *amplitude;
            }
            let shapes = (0..parameters.len()).filter(|place| !direction.parameters.contains(place));
            for (place, shape) in shapes.zip(&direction.shape) {
                values[place] = *shape;
            }
        } else {
            values.clone_from(&direction.probe);
        }
        let inside = |place: usize| {
            let prior = &parameters[place].prior;
            let (lower, upper) = (prior.quantile(0.001), prior.quantile(0.999));
            // An amplitude may lie far beyond what was thought plausible; a bound holds.
            let (least, most) = prior.support();
            let anywhere = direction.probe.is_empty() || problem.is_misspecified;
            let value = if anywhere { values[place] } else { values[place].max(lower).min(upper) };
            let margin = 1e-3 * (upper - lower);
            value.max(least + margin.min(lower - least).max(0.0)).min(most - margin.min(most - upper).max(0.0))
        };
        (0..parameters.len())
            .map(|place| (format!("{}.{}", candidate.id, parameters[place].name), inside(place)))
            .collect()
    }

    /// Degrees of freedom with which the size of the errors is estimated where the sensors have this noise; `None` where
    /// all is stated.
    pub(crate) fn noise_freedom(&self, noise: &[SensorNoise]) -> Option<f64> {
        let measurements = self.problem().measurements.iter().enumerate();
        let parameters = self.problem().parameters.len() as f64;
        let of = |(position, measurement): (usize, &Measurement)| {
            let rows = (0..measurement.len()).filter(|&row| !measurement.held_out(row)).count() as f64;
            let inferred = |value: &Option<Uncertain>| value.as_ref().is_some_and(|v| v.prior().is_some());
            let is_open = measurement.sensors.iter().any(|sensor| inferred(&sensor.sigma) || inferred(&sensor.white));
            let own = noise.iter().find(|one| one.measurement == position).and_then(|one| one.model_error);
            let independent = own.map(|_| {
                let of = noise.iter().filter(|one| one.measurement == position);
                let share = |one: &SensorNoise| {
                    let (error, noise) = (one.model_error.map_or(0.0, |error| error.sd), one.noise.total());
                    let alone = error * error + noise * noise;
                    alone / (one.weighed().total() * one.weighed().total())
                };
                of.map(|one| rows * share(one)).sum()
            });
            independent.or(is_open.then_some(rows)).filter(|_| rows > 0.0)
        };
        let fewest = measurements.filter_map(of).reduce(f64::min);
        fewest.map(|readings| (readings - parameters).max(3.0))
    }

    /// Noise of the sensors whose noise is not wholly known, from a fit of the problem; beside the pair of effects that
    /// explains most, or of the fit alone. With what explains most beside it, of a record that is long.
    pub(crate) fn estimate_noise(
        &self,
        problem: &Problem,
        declared: &Refit,
        beside_pair: bool,
    ) -> Result<(Vec<SensorNoise>, Option<Foremost>), FitError> {
        let mut bare = problem.clone();
        let mut open = Vec::new();
        for (measurement, entry) in bare.measurements.iter_mut().enumerate() {
            for sensor in 0..entry.sensors.len() {
                // Of the others the noise is known here.
                let declared = &self.problem().measurements[measurement];
                if estimate::is_open(declared, sensor) && !is_unstated(declared) {
                    estimate::fix(entry, sensor, &estimate::EstimatedNoise::white(1.0));
                    open.push((measurement, sensor));
                }
            }
        }
        if open.is_empty() {
            return Ok((Vec::new(), None));
        }
        let likelihood = self.likelihood(&bare)?;
        let known = declared.by_name();
        let unknowns: Vec<f64> =
            likelihood.unknowns().names.iter().map(|name| known.get(name).copied().unwrap_or_default()).collect();
        let linear = signature::linearise(&likelihood, &unknowns)?;
        // A curve beside which the noise is estimated could take the noise for physics.
        let is_long = problem.has_long_transients();
        let is_tried = |candidate: usize| !(is_long && self.is_unknown_function(candidate));
        let is_single = |direction: &Direction| direction.amplitudes() == 1;
        let wanted = |direction: &Direction| is_long || is_single(direction);
        let all = if beside_pair {
            Scored::best(&bare, &likelihood, &unknowns, &linear, is_tried, wanted)?.0.directions
        } else {
            Vec::new()
        };
        let directions: Vec<&Direction> = all.iter().filter(|direction| is_single(direction)).collect();
        let series: Vec<estimate::SensorRows> =
            open.iter().map(|&(measurement, sensor)| sensor_rows(&bare, &likelihood, measurement, sensor)).collect();
        // To begin with, white: as stated, or as large as the residuals.
        let original = &self.problem().measurements;
        let mut settled: Vec<SensorNoise> = series
            .iter()
            .map(|one| {
                let square: f64 = one.rows.iter().map(|&row| linear.residuals[row] * linear.residuals[row]).sum();
                let rms = (square / one.rows.len().max(1) as f64).sqrt().max(f64::MIN_POSITIVE.sqrt());
                let stated = match &original[one.measurement].sensors[one.sensor].sigma {
                    Some(sigma) if sigma.prior().is_none() => sigma.nominal(),
                    _ => rms,
                };
                let noise = estimate::EstimatedNoise::white(stated);
                SensorNoise { measurement: one.measurement, sensor: one.sensor, noise, model_error: None }
            })
            .collect();
        for _ in 0..NOISE_ROUNDS {
            let before = settled.clone();
            let fit = self.fit_of_best_pair(&linear, &directions, &series, &settled);
            let freedom = 1.0 - (linear.parameters() + 2) as f64 / linear.readings.max(1) as f64;
            let current: Vec<estimate::EstimatedNoise> = settled.iter().map(|one| one.noise).collect();
            let found = estimate::most_likely(original, &series, &fit, freedom.max(0.1), &current);
            for (one, noise) in settled.iter_mut().zip(found) {
                one.noise = noise;
            }
            if settled == before {
                break;
            }
        }
        let names: Vec<&str> =
            series.iter().map(|one| original[one.measurement].sensors[one.sensor].name.as_str()).collect();
        let fitted: Vec<usize> = series.iter().map(|one| one.rows.len()).collect();
        let own: Vec<estimate::EstimatedNoise> = settled.iter().map(|one| one.noise).collect();
        for (one, noise) in settled.iter_mut().zip(estimate::where_nothing_is_fitted(&names, &fitted, &own)) {
            one.noise = noise;
        }
        let foremost = (beside_pair && is_long).then(|| {
            let white = whitened(&linear, &series, &settled);
            let scored = scored_anew(&white, &all.iter().collect::<Vec<_>>(), &series, &settled);
            let of = |d: usize| Explains::new(&scored.directions[d], &scored.scores[d]);
            let leads = self.in_order(problem, scored.ranked().into_iter().map(of).collect());
            let pairs = scored.pairs(MOST_BESIDE_NOISE, MOST_PAIRS).into_iter();
            Foremost { leads, pairs: pairs.map(|pair| self.pair(problem, &scored, pair)).collect() }
        });
        Ok((settled, foremost))
    }

    /// What the parameters and the best pair of effects take of the readings of sensors with unit noise, and leave, SI.
    fn fit_of_best_pair(
        &self,
        linear: &Linear,
        directions: &[&Direction],
        series: &[estimate::SensorRows],
        settled: &[SensorNoise],
    ) -> LinearFit {
        let white = whitened(linear, series, settled);
        let scored = scored_anew(&white, directions, series, settled);
        let n = linear.parameters();
        let best: Vec<usize> = match scored.pairs(MOST_BESIDE_NOISE, 1).first() {
            Some((pair, _, _)) => pair.to_vec(),
            None => scored.ranked().into_iter().take(1).collect(),
        };
        let columns: Vec<Column<'_>> = best
            .iter()
            .map(|&d| {
                let own = &scored.directions[d];
                Column { values: own.column(0), lower: own.lower[0], upper: own.upper[0], precision: 0.0 }
            })
            .collect();
        let fit = scored.prepared.fit(&columns);
        let step = scored.prepared.step();
        let mut errors = linear.residuals.clone();
        let mut columns = Vec::new();
        let mut take = |column: Vec<f64>, size: f64, place: Place| {
            errors.iter_mut().zip(&column).for_each(|(error, own)| *error -= own * size);
            if place == Place::Free {
                columns.push(column);
            }
        };
        for parameter in 0..n {
            let column = (0..linear.rows).map(|row| linear.jacobian[row * n + parameter]).collect();
            take(column, step[parameter] + fit.x[parameter], fit.places[parameter]);
        }
        for (position, &d) in best.iter().enumerate() {
            // As it was before it was whitened; of those that were scored only the best are kept.
            let own = &scored.directions[d];
            let is_own = |other: &&Direction| {
                other.candidate == own.candidate
                    && other.parameters == own.parameters
                    && other.shape == own.shape
                    && other.probe == own.probe
            };
            let Some(original) = directions.iter().copied().find(is_own) else { continue };
            take(original.column(0).to_vec(), fit.x[n + position], fit.places[n + position]);
        }
        LinearFit { columns, errors }
    }
}

/// A linear problem of unit noise, whitened.
fn whitened(linear: &Linear, series: &[estimate::SensorRows], settled: &[SensorNoise]) -> Linear {
    let filters = estimate::whitening(series, settled.iter().map(|one| &one.noise));
    let mut white = linear.clone();
    estimate::whiten(series, &filters, &mut white.residuals);
    let n = linear.parameters();
    for parameter in 0..n {
        let mut column: Vec<f64> = (0..linear.rows).map(|row| linear.jacobian[row * n + parameter]).collect();
        estimate::whiten(series, &filters, &mut column);
        for (row, value) in column.into_iter().enumerate() {
            white.jacobian[row * n + parameter] = value;
        }
    }
    white
}

/// Directions of unit noise scored with another one, in which the problem is whitened; the best are kept.
fn scored_anew<'a>(
    white: &'a Linear,
    directions: &[&Direction],
    series: &[estimate::SensorRows],
    settled: &[SensorNoise],
) -> Scored<'a> {
    let filters = estimate::whitening(series, settled.iter().map(|one| &one.noise));
    let mut scored = Scored::new(white);
    for &direction in directions {
        let mut own = direction.clone();
        for column in own.columns.chunks_exact_mut(white.rows.max(1)) {
            estimate::whiten(series, &filters, column);
        }
        scored.take(vec![own]);
        if scored.directions.len() >= 2 * MOST_BESIDE_NOISE {
            scored.keep(MOST_BESIDE_NOISE * white.rows);
        }
    }
    scored
}

/// Rows of the sensors and of the steady phases, with their names.
fn groups(problem: &Problem, likelihood: &Likelihood) -> (Vec<Vec<usize>>, Vec<String>) {
    let (mut groups, mut names) = (Vec::new(), Vec::new());
    let mut add = |rows: Vec<usize>, name: String| {
        if rows.len() > 1 {
            groups.push(rows);
            names.push(name);
        }
    };
    for (index, measurement) in problem.measurements.iter().enumerate() {
        let own: Vec<(usize, usize, usize)> = (likelihood.data().iter().enumerate())
            .filter(|(_, datum)| datum.measurement == index)
            .map(|(position, datum)| (position, datum.row, datum.sensor))
            .collect();
        for (place, sensor) in measurement.sensors.iter().enumerate() {
            let rows = own.iter().filter(|(_, _, other)| *other == place).map(|(position, _, _)| *position).collect();
            add(rows, format!("sensor {}", sensor.name));
        }
        if let Rows::Steady(phases) = &measurement.rows {
            for (row, phase) in phases.iter().enumerate() {
                let rows = own.iter().filter(|(_, other, _)| *other == row).map(|(position, _, _)| *position).collect();
                add(rows, format!("phase {}", phase.name));
            }
        }
    }
    (groups, names)
}

fn sensor_rows(problem: &Problem, likelihood: &Likelihood, measurement: usize, sensor: usize) -> estimate::SensorRows {
    let mut rows = Vec::new();
    let mut times_s = Vec::new();
    for (position, datum) in likelihood.data().iter().enumerate() {
        if datum.measurement == measurement && datum.sensor == sensor {
            rows.push(position);
            times_s.push(match &problem.measurements[measurement].rows {
                Rows::Steady(_) => datum.row as f64,
                Rows::Transient { inputs, .. } => inputs.times_s[datum.row],
            });
        }
    }
    estimate::SensorRows { measurement, sensor, rows, times_s }
}

/// An amplitude of a direction in the unit of its parameter; a share of a probe becomes the probe's first amplitude.
fn shown(problem: &Problem, direction: &Direction, amplitude: f64) -> Option<(usize, f64, String)> {
    let candidate = &problem.candidates[direction.candidate];
    let parameters = problem.catalogue.get(&candidate.effect)?.parameters(&problem.model, &candidate.bound);
    let (place, value) = match direction.parameters.first() {
        Some(&place) => (place, amplitude),
        None => {
            let place = parameters.iter().position(|parameter| parameter.amplitude)?;
            (place, amplitude * direction.probe.get(place)?)
        }
    };
    let unit = &parameters.get(place)?.unit;
    Some((direction.candidate, unit.difference_from_si(value), unit.text.clone()))
}
