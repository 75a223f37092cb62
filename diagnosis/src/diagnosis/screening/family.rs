//! The family of tests for missing physics, and the probability that the best of them looks as good by chance.
//!
//! Members: every direction that the data see; means of the residuals over groups of rows (sensors, phases); parameters
//! pressed against a bound; the distance of the fit from each normal prior; the sum of squares as a whole. Each has a
//! statistic whose probability where nothing is missing is known, and the family is judged by the smallest of these
//! probabilities. All of them are functions of the same residuals, so that their dependence is known too and is used
//! exactly ([`crate::inference::null_maximum`]): no level is split between members, and like members cost nothing.
//!
//! What is assumed: whitened noise is standard normal (or, with `degrees`, standard normal times a common unknown scale whose
//! square was estimated with so many degrees of freedom), and the model is linear where it matters. The probability is then
//! exact, given which parameters are pressed against their bounds: null residuals are drawn under the condition that these
//! stay pressed, with the true parameter at the bound, which is the worst case. Where the bounds of further parameters lower a
//! likelihood ratio, the probability is an upper limit.

use crate::diagnosis::screening::multi_column::Projected;
use crate::diagnosis::screening::score::Prepared;
use crate::diagnosis::{Direction, Score};
use crate::inference::null_maximum::{Null, Sampling, Several, Side, square_tail};
use crate::math::dense::dot_of_columns as dot;
use crate::math::functions::sqrt;
use crate::math::scalar_products::{coordinates, orthonormal};
use crate::math::sort::sort_by;
use crate::math::special::{normal_cdf, normal_quantile, student_t_cdf, weighted_chi_square_sf};

/// Directions are turned into coordinates where so many suffice.
const LARGEST_RANK: usize = 512;
/// Conditions on parameters at bounds that are kept; each halves the share of the draws that count.
const LARGEST_CONDITIONS: usize = 5;
/// A family-wise probability below this is stated by its upper limit, the sum over the members (Bonferroni): no verdict
/// depends on how much smaller it is, and long records take seconds to draw it.
const CERTAIN: f64 = 1e-9;

/// What a member of the family tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemberKind {
    /// The direction at this position of the list given.
    Direction(usize),
    /// The mean of the residuals over the group at this position.
    Group(usize),
    /// The parameter at this position of the linear problem, pressed against a bound.
    Bound(usize),
    /// The row of this position, a normal prior's.
    Prior(usize),
    /// The sum of squares.
    Omnibus,
}

/// A member of the family as observed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    /// What it tests.
    pub kind: MemberKind,
    /// A score in standard deviations (folded to the side that counts), or a sum of squares.
    pub statistic: f64,
    /// Probability of a larger statistic where nothing is missing, taken alone.
    pub p: f64,
    /// The standard normal number exceeded with that probability.
    pub equivalent: f64,
}

/// Members besides the directions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras<'a> {
    /// Groups of rows whose mean is tested.
    pub groups: &'a [Vec<usize>],
    /// Whether parameters at bounds are.
    pub bounds: bool,
    /// Whether the rows of priors are.
    pub priors: bool,
    /// Whether the sum of squares is (against its own degrees of freedom where the scale is known).
    pub omnibus: bool,
}

/// The family's verdict.
#[derive(Clone, Debug, PartialEq)]
pub struct FamilyWise {
    /// Probability that any member looks as good as the best one where nothing is missing.
    pub p: f64,
    /// Its standard error, from the draws.
    pub se: f64,
    /// Smallest probability of a member.
    pub smallest_p: f64,
    /// The standard normal number exceeded with it.
    pub max_z: f64,
    /// Position of that member; `None` where there are none.
    pub which: Option<usize>,
    /// All members.
    pub members: Vec<Member>,
}

/// The members, and what is needed to draw their statistics together.
#[derive(Clone, Debug)]
pub struct Family {
    /// As observed.
    pub members: Vec<Member>,
    /// Of what the distribution is made when it is first asked for; none afterwards.
    parts: Option<Parts>,
    null: Null,
}

/// What the distribution of the statistics is made of, as columns of the readings.
#[derive(Clone, Debug)]
struct Parts {
    rows: usize,
    freedom: usize,
    singles: Vec<(Vec<f64>, Side)>,
    several: Vec<Several>,
    conditions: Vec<Vec<f64>>,
    omnibus: bool,
    degrees: Option<f64>,
    /// Orthonormal columns of the free parameters.
    free_basis: Vec<f64>,
}

impl Family {
    /// Collects the members. `scores` are those of the directions, in their order. Cost: directions x rows x parameters.
    pub fn new(
        prepared: &Prepared,
        directions: &[Direction],
        scores: &[Score],
        extras: &Extras<'_>,
        degrees: Option<f64>,
    ) -> Self {
        let degrees = degrees.filter(|d| d.is_finite()).map(|d| d.max(1.0));
        let rows = prepared.rows;
        let tail = |x: f64| standard_tail(x, degrees);
        let mut members = Vec::new();
        let mut singles: Vec<(Vec<f64>, Side)> = Vec::new();
        let mut several = Vec::new();
        let mut late = Vec::new();
        let mut add = |members: &mut Vec<Member>, kind, unit: Vec<f64>, side: Side, folded: f64| {
            members.push(member(kind, folded, side.probability(folded, tail)));
            singles.push((unit, side));
        };
        for (position, (direction, score)) in directions.iter().zip(scores).enumerate() {
            match prepared.projected(direction) {
                Projected::Single { mut column, norm, side } if score.seen => {
                    column.iter_mut().for_each(|x| *x /= norm);
                    let folded = side.fold(score.z);
                    let statistic = if folded > 0.0 { folded.min(sqrt(score.likelihood_ratio)) } else { folded };
                    add(&mut members, MemberKind::Direction(position), column, side, statistic);
                }
                Projected::Several { columns, weights, .. } if score.seen => {
                    let statistic = score.likelihood_ratio.min(score.free_ratio);
                    let p = weighted_chi_square_sf(statistic, &weights, degrees);
                    late.push(member(MemberKind::Direction(position), statistic, p));
                    several.push(Several { columns, weights });
                }
                _ => {}
            }
        }
        let mut indicator = |members: &mut Vec<Member>, kind, indicated: &[usize]| {
            let mut column = vec![0.0; rows];
            indicated.iter().filter(|row| **row < rows).for_each(|&row| column[row] = 1.0);
            let square = dot(&column, &column);
            let mut column = prepared.project(&column);
            let norm = sqrt(dot(&column, &column));
            if norm * norm > 1e-6 * square {
                column.iter_mut().for_each(|x| *x /= norm);
                let z = dot(&column, &prepared.residuals);
                add(members, kind, column, Side::Two, z.abs());
            }
        };
        for (position, group) in extras.groups.iter().enumerate() {
            indicator(&mut members, MemberKind::Group(position), group);
        }
        if extras.priors {
            for row in prepared.readings..rows {
                indicator(&mut members, MemberKind::Prior(row), &[row]);
            }
        }
        // Towards the outside of the bound, so that what is observed is positive.
        let mut conditions: Vec<(f64, Vec<f64>)> = Vec::new();
        for pinned in prepared.pinned() {
            let mut column = prepared.project(prepared.parameter(pinned.parameter));
            let norm = sqrt(dot(&column, &column)) * if pinned.at_lower { -1.0 } else { 1.0 };
            column.iter_mut().for_each(|x| *x /= norm);
            conditions.push((pinned.pressure, column.clone()));
            if extras.bounds {
                let kind = MemberKind::Bound(pinned.parameter);
                add(&mut members, kind, column, Side::Positive, pinned.pressure);
            }
        }
        members.extend(late);
        let freedom = prepared.freedom();
        if extras.omnibus && freedom > 0 {
            let square = prepared.chi_square();
            members.push(member(MemberKind::Omnibus, square, square_tail(square, freedom as f64, degrees)));
        }
        sort_by(&mut conditions, |a, b| a.0.total_cmp(&b.0));
        let pressed: Vec<&[f64]> = conditions.iter().map(|(_, column)| column.as_slice()).collect();
        let chosen = orthonormal(&pressed, Vec::new(), 1e-3).1;
        let kept = (0..pressed.len()).filter(|k| chosen.contains(k)).take(LARGEST_CONDITIONS);
        let conditions: Vec<Vec<f64>> = kept.map(|k| pressed[k].to_vec()).collect();
        let omnibus = extras.omnibus && freedom > 0;
        let free_basis = if omnibus { prepared.free_basis().to_vec() } else { Vec::new() };
        let parts = Parts { rows, freedom, singles, several, conditions, omnibus, degrees, free_basis };
        Self { members, parts: Some(parts), null: Null::default() }
    }

    /// The distribution of the statistics where nothing is missing.
    fn null(&mut self) -> &Null {
        if let Some(parts) = self.parts.take() {
            self.null = parts.null();
        }
        &self.null
    }

    /// The smallest probability of a member, and its position.
    fn smallest(&self) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        for (position, member) in self.members.iter().enumerate() {
            let better = best.is_none_or(|(at, p)| {
                member.p < p || (member.p == p && member.equivalent > self.members[at].equivalent)
            });
            if better {
                best = Some((position, member.p));
            }
        }
        best
    }

    /// Judges the family. A probability below 1e-9 is stated by its upper limit.
    pub fn test(&mut self, sampling: &Sampling) -> FamilyWise {
        let (which, smallest_p) = self.smallest().map_or((None, 1.0), |(which, p)| (Some(which), p));
        // Given conditions, of which each holds for about half of the draws and those that exclude each other for fewer.
        let conditions = self.parts.as_ref().map_or(0, |parts| parts.conditions.len());
        let limit = smallest_p * self.members.len() as f64 * f64::from(1 << (2 * conditions));
        let (p, se) = if which.is_some() && limit < CERTAIN {
            (limit, 0.0)
        } else {
            self.null().probability(smallest_p, sampling)
        };
        let max_z = which.map_or(f64::NEG_INFINITY, |which| self.members[which].equivalent);
        FamilyWise { p, se, smallest_p, max_z, which, members: self.members.clone() }
    }

    /// Probability, and its standard error, that the smallest probability of a member is at most this where nothing is missing.
    pub fn probability(&mut self, smallest_p: f64, sampling: &Sampling) -> (f64, f64) {
        self.null().probability(smallest_p, sampling)
    }

    /// The smallest probability of a member that stays unusual at a level (0.005, say) for the whole family: found by false
    /// position on the logarithms, to half a per cent, with the same random numbers for each trial.
    pub fn critical(&mut self, level: f64, sampling: &Sampling) -> f64 {
        self.null().critical(level, sampling)
    }
}

impl Parts {
    /// Turns all directions to the coordinates of their span where that is small.
    fn null(self) -> Null {
        let Self { rows, freedom, singles, several, conditions, omnibus, degrees, free_basis } = self;
        let all: Vec<&[f64]> = singles
            .iter()
            .map(|(unit, _)| unit.as_slice())
            .chain(several.iter().flat_map(|s| s.columns.chunks_exact(rows.max(1))))
            .chain(conditions.iter().map(Vec::as_slice))
            .collect();
        let span = coordinates(&all, LARGEST_RANK.min(7 * rows / 10));
        let sides = singles.iter().map(|(_, side)| *side).collect();
        let mut null = Null { dimensions: rows, freedom, omnibus, degrees, sides, ..Null::default() };
        match span {
            Some((mut units, dimensions)) => {
                // The columns themselves are needed no more.
                let count = singles.len() * dimensions;
                drop(singles);
                let others = units.split_off(count);
                let mut found = others.as_slice();
                let mut next = |count: usize| {
                    let (these, rest) = found.split_at(count * dimensions);
                    found = rest;
                    these.to_vec()
                };
                null.dimensions = dimensions;
                null.units = units;
                null.several = several
                    .into_iter()
                    .map(|s| Several { columns: next(s.weights.len()), weights: s.weights })
                    .collect();
                null.conditions = next(conditions.len());
                null.remainder = freedom.saturating_sub(dimensions);
            }
            None => {
                null.units = singles.into_iter().flat_map(|(unit, _)| unit).collect();
                null.conditions = conditions.concat();
                null.several = several;
                null.projected_out = free_basis;
            }
        }
        null
    }
}

fn member(kind: MemberKind, statistic: f64, p: f64) -> Member {
    Member { kind, statistic, p, equivalent: -normal_quantile(p.clamp(1e-300, 1.0 - 1e-16)) }
}

/// Upper tail of the standard normal, or of Student's t.
pub(crate) fn standard_tail(x: f64, degrees: Option<f64>) -> f64 {
    match degrees {
        None => normal_cdf(-x),
        Some(d) => student_t_cdf(-x, d),
    }
}

/// Scores, family and verdict at once.
pub fn p_value(
    prepared: &Prepared,
    directions: &[Direction],
    extras: &Extras<'_>,
    sampling: &Sampling,
    degrees: Option<f64>,
) -> FamilyWise {
    let scores: Vec<Score> = directions.iter().map(|direction| prepared.score(direction)).collect();
    Family::new(prepared, directions, &scores, extras, degrees).test(sampling)
}
