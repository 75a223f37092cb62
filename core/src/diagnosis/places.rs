//! Pairs of nodes of a large model between which effects are sought: first those that the sensors can tell apart, then those near
//! what was found.
//!
//! A watt into a node moves the whitened predictions by a column. Nodes whose columns lie close together are one to the sensors. A
//! path between two nodes moves the predictions by its heat times the difference of their columns, so that a pair which stands for
//! another errs by no more than its heat times the distances of the columns. Representatives are the points of a farthest-first
//! traversal (Gonzalez 1985), whose largest distance is at most twice the best possible one.

use serde::{Deserialize, Serialize};

use crate::diagnosis::FitError;
use crate::diagnosis::engine::{Diagnosis, State};
use crate::diagnosis::linearisation::signature;
use crate::diagnosis::screening::screen::Lead;
use crate::diagnosis::{Problem, Refit};
use crate::effect::{Candidate, Site, candidates, candidates_between, chooses_pairs};
use crate::measurement::sensor_places;
use crate::thermal::NodeKind;

/// Representatives: 2016 pairs.
const MOST_REPRESENTATIVES: usize = 64;
/// Neighbours of a representative in shares of all nodes: its own ones and those of the representatives around it.
const NEIGHBOURS: usize = 4;
/// Most neighbours of a representative.
const MOST_NEIGHBOURS: usize = 60;
/// Boundaries that are ends of their own.
const MOST_BOUNDARIES: usize = 8;
/// Pairs near one that was found which become places.
const MOST_NEAR: usize = 40;
/// Times that pairs near one that was found are added.
const MOST_REFINEMENTS: usize = 6;
/// Those that are fitted at once.
const FITTED_NEAR: usize = 8;
/// The effect whose columns tell nodes apart: heat into one.
const HEAT: &str = "heat-load";

/// Pairs of nodes that are places.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Places {
    /// Representatives, each with the nodes that the sensors see most like it, itself first.
    pub neighbours: Vec<Vec<usize>>,
    /// Pairs between which effects are sought.
    pub pairs: Vec<[usize; 2]>,
    /// How often pairs near one that was found were added.
    pub refinements: usize,
}

impl Places {
    /// Pairs near that of two representatives which are no places yet.
    fn near(&self, ends: [usize; 2]) -> Vec<[usize; 2]> {
        let of = |node: usize| self.neighbours.iter().find(|neighbours| neighbours[0] == node);
        let (true, Some(first), Some(second)) = (self.refinements < MOST_REFINEMENTS, of(ends[0]), of(ends[1])) else {
            return Vec::new();
        };
        let all = first.iter().flat_map(|&a| second.iter().map(move |&b| [a.min(b), a.max(b)]));
        let mut near: Vec<[usize; 2]> = all.filter(|pair| pair[0] < pair[1] && !self.pairs.contains(pair)).collect();
        near.sort_unstable();
        near.dedup();
        near
    }
}

impl Problem {
    /// The same with candidates between the nodes of more pairs, behind those that it has.
    fn between(&self, places: Places) -> Self {
        let sensors = sensor_places(self.measurements.iter());
        let new = places.pairs.get(self.places.pairs.len()..).unwrap_or_default();
        let mut more = candidates_between(&self.model, &sensors, &self.catalogue, new);
        more.retain(|candidate| self.considered.is_empty() || self.considered.contains(&candidate.effect));
        let mut problem = self.clone();
        problem.candidates.extend(more);
        problem.places = places;
        problem
    }

    /// The places of a large model at a fit of it.
    fn choose_places(&self, refit: &Refit) -> Result<Places, FitError> {
        let sensors = sensor_places(self.measurements.iter());
        let is_heat = |candidate: &Candidate| candidate.effect == HEAT && matches!(candidate.site, Site::Nodes(_));
        let mut heated = self.clone();
        heated.candidates = candidates(&self.model, &[], &sensors, &self.catalogue);
        heated.candidates.retain(is_heat);
        let likelihood = heated.hypothesis(&[], 1.0)?.likelihood(&heated)?;
        let positions: Vec<usize> = (0..heated.candidates.len()).collect();
        let mut columns: Vec<(usize, Vec<f64>)> = Vec::new();
        signature::for_each_direction(&heated, &likelihood, &refit.unknowns, &positions, &mut |directions| {
            columns.extend(directions.into_iter().filter_map(|direction| {
                let Site::Nodes(nodes) = &heated.candidates[direction.candidate].site else { return None };
                let [(node, _)] = nodes[..] else { return None };
                Some((node, direction.columns))
            }));
        })?;
        let mut neighbours = neighbours(&columns);
        let is_boundary = |node: &usize| matches!(self.model.nodes[*node].kind, NodeKind::Boundary { .. });
        let boundaries = (0..self.model.nodes.len()).filter(is_boundary).take(MOST_BOUNDARIES);
        neighbours.extend(boundaries.map(|node| vec![node]));
        let first: Vec<usize> = neighbours.iter().map(|nodes| nodes[0]).collect();
        let mut pairs = Vec::new();
        for (place, &a) in first.iter().enumerate() {
            for &b in &first[place + 1..] {
                if !(is_boundary(&a) && is_boundary(&b)) {
                    pairs.push([a.min(b), a.max(b)]);
                }
            }
        }
        Ok(Places { neighbours, pairs, refinements: 0 })
    }
}

/// Representatives of nodes with their columns by farthest-first traversal, beginning with the longest column, each with its
/// neighbours.
fn neighbours(columns: &[(usize, Vec<f64>)]) -> Vec<Vec<usize>> {
    let square = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
    let mut nearest: Vec<f64> = columns.iter().map(|(_, column)| column.iter().map(|x| x * x).sum()).collect();
    let count = (NEIGHBOURS * columns.len().div_ceil(MOST_REPRESENTATIVES) + NEIGHBOURS).min(MOST_NEIGHBOURS);
    let mut chosen: Vec<usize> = Vec::new();
    let mut all = Vec::new();
    while chosen.len() < MOST_REPRESENTATIVES {
        let farther = |a: usize, b: usize| if nearest[b] > nearest[a] { b } else { a };
        let Some(next) = (0..columns.len()).filter(|place| !chosen.contains(place)).reduce(farther) else { break };
        let is_first = chosen.is_empty();
        let mut by_distance: Vec<(f64, usize)> = Vec::with_capacity(columns.len());
        for (place, (_, column)) in columns.iter().enumerate() {
            let distance = square(column, &columns[next].1);
            nearest[place] = if is_first { distance } else { nearest[place].min(distance) };
            if place != next {
                by_distance.push((distance, place));
            }
        }
        by_distance.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let near = by_distance.iter().take(count).map(|&(_, place)| columns[place].0);
        all.push(std::iter::once(columns[next].0).chain(near).collect());
        chosen.push(next);
    }
    all
}

impl Diagnosis {
    /// The same with effects between pairs of nodes, at the baseline model's fit; where all pairs are candidates, this.
    pub(crate) fn at_chosen_places(&self, baseline: &Refit) -> Result<Self, FitError> {
        if !chooses_pairs(&self.problem().model) {
            return Ok(self.clone());
        }
        Ok(self.with_places(self.problem().choose_places(baseline)?))
    }

    /// The same with effects between the nodes of more pairs.
    pub(crate) fn with_places(&self, places: Places) -> Self {
        self.with_problem(self.problem().between(places))
    }

    /// Orders effects between nodes near those of a set, where these stand for others. `None` if they stand for themselves.
    pub(crate) fn refine(&self, problem: &Problem, state: &State, place: usize) -> Result<Option<State>, FitError> {
        let set = &state.refits[place].effects;
        for &effect in set {
            let Site::Pair(ends) = problem.candidates[effect].site else { continue };
            let near = problem.places.near(ends);
            let rest: Vec<usize> = set.iter().copied().filter(|&other| other != effect).collect();
            let Some(from) = state.refits.iter().position(|refit| refit.effects == rest) else { continue };
            if near.is_empty() {
                continue;
            }
            let mut leads = self.leads_near(state, &near, effect, from)?;
            leads.truncate(MOST_NEAR);
            let mut next = state.clone();
            next.places.pairs.extend(leads.iter().map(|(pair, _)| *pair));
            next.places.refinements += 1;
            let refined = self.with_places(next.places.clone());
            let name = &problem.candidates[effect].effect;
            for (pair, lead) in leads.iter().take(FITTED_NEAR) {
                let is_there = |candidate: &Candidate| {
                    candidate.effect == *name
                        && matches!(candidate.site, Site::Pair([a, b]) if [a.min(b), a.max(b)] == *pair)
                };
                if let Some(candidate) = refined.problem().candidates.iter().rposition(is_there) {
                    next.order(&[&Lead { candidate, ..lead.clone() }], &rest, from);
                }
            }
            // Where no neighbour shows anything, the search goes on beside the set as it is.
            if !next.pending.is_empty() {
                return Ok(Some(next));
            }
        }
        Ok(None)
    }

    /// What an effect between each of some pairs would explain beside a fit, the most first.
    fn leads_near(
        &self,
        state: &State,
        pairs: &[[usize; 2]],
        effect: usize,
        from: usize,
    ) -> Result<Vec<([usize; 2], Lead)>, FitError> {
        let mut places = self.problem().places.clone();
        places.pairs.extend_from_slice(pairs);
        let wide = self.with_places(places);
        let problem = wide.with_noise(&state.noise, &state.most_steps).with(&state.refits[from])?;
        let name = &problem.candidates[effect].effect;
        let begin = self.problem().candidates.len();
        let positions: Vec<usize> = (begin..problem.candidates.len())
            .filter(|&position| problem.candidates[position].effect == *name)
            .collect();
        let leads = wide.leads_among(&problem, &state.refits[from], &positions)?;
        let of = |lead: Lead| match problem.candidates[lead.candidate].site {
            Site::Pair([a, b]) => Some(([a.min(b), a.max(b)], lead)),
            _ => None,
        };
        Ok(leads.into_iter().filter_map(of).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn representatives_are_far_apart_and_have_their_neighbours() {
        // Two bundles of nodes, and one node apart.
        let columns: Vec<(usize, Vec<f64>)> = (0..130)
            .map(|node| match node {
                129 => (node, vec![0.0, -50.0]),
                _ if node % 2 == 0 => (node, vec![100.0 + 1e-3 * node as f64, 0.0]),
                _ => (node, vec![0.0, 100.0 - 1e-3 * node as f64]),
            })
            .collect();
        let all = neighbours(&columns);
        assert_eq!(all.len(), MOST_REPRESENTATIVES);
        assert!(all[..3].iter().any(|nodes| nodes[0] == 129), "what lies apart comes early");
        // 130 nodes are 3 a representative: four times that and four more.
        assert!(all.iter().all(|nodes| nodes.len() == 1 + 16));
        for nodes in all.iter().filter(|nodes| nodes[0] != 129) {
            assert!(nodes.iter().all(|node| node % 2 == nodes[0] % 2), "bundles stay apart: {nodes:?}");
        }
        let places = Places {
            neighbours: vec![vec![1, 4], vec![2, 3, 4], vec![9]],
            pairs: vec![[1, 2], [1, 9], [2, 9]],
            refinements: 0,
        };
        assert_eq!(places.near([1, 2]), [[1, 3], [1, 4], [2, 4], [3, 4]]);
        assert_eq!(places.near([9, 2]), [[3, 9], [4, 9]]);
        assert!(places.near([1, 3]).is_empty(), "3 stands for itself");
        assert!(Places { refinements: MOST_REFINEMENTS, ..places }.near([1, 2]).is_empty());
    }
}
