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

/// Clusters of nodes: 2016 pairs.
const MOST_CLUSTERS: usize = 64;
/// Boundaries that are ends of their own.
const MOST_BOUNDARIES: usize = 8;
/// Pairs near one that was found which become places.
const MOST_NEAR: usize = 40;
/// Those that are fitted at once.
const FITTED_NEAR: usize = 8;
/// The effect whose columns tell nodes apart: heat into one.
const HEAT: &str = "heat-load";

/// Pairs of nodes that are places.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Places {
    /// Nodes that the sensors see alike, the one that stands for them first.
    pub clusters: Vec<Vec<usize>>,
    /// Pairs between which effects are sought.
    pub pairs: Vec<[usize; 2]>,
}

impl Places {
    /// The pairs between two clusters that are not places yet; none if some were added before.
    fn near(&self, ends: [usize; 2]) -> Vec<[usize; 2]> {
        let cluster = |node: usize| self.clusters.iter().find(|cluster| cluster.contains(&node));
        let (Some(first), Some(second)) = (cluster(ends[0]), cluster(ends[1])) else { return Vec::new() };
        let joins =
            |[a, b]: [usize; 2]| first.contains(&a) && second.contains(&b) || first.contains(&b) && second.contains(&a);
        let were_added = self.pairs.iter().filter(|&&pair| joins(pair)).count() > 1;
        if were_added || std::ptr::eq(first, second) {
            return Vec::new();
        }
        let all = first.iter().flat_map(|&a| second.iter().map(move |&b| [a.min(b), a.max(b)]));
        all.filter(|pair| !self.pairs.contains(pair)).collect()
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
        signature::for_each_direction(&heated, &likelihood, &refit.unknowns, &positions, &mut |direction| {
            if let Site::Nodes(nodes) = &heated.candidates[direction.candidate].site
                && let [(node, _)] = nodes[..]
            {
                columns.push((node, direction.columns));
            }
        })?;
        let mut clusters = clusters(&columns);
        let is_boundary = |node: &usize| matches!(self.model.nodes[*node].kind, NodeKind::Boundary { .. });
        let boundaries = (0..self.model.nodes.len()).filter(is_boundary).take(MOST_BOUNDARIES);
        clusters.extend(boundaries.map(|node| vec![node]));
        let first: Vec<usize> = clusters.iter().map(|cluster| cluster[0]).collect();
        let mut pairs = Vec::new();
        for (place, &a) in first.iter().enumerate() {
            for &b in &first[place + 1..] {
                if !(is_boundary(&a) && is_boundary(&b)) {
                    pairs.push([a.min(b), a.max(b)]);
                }
            }
        }
        Ok(Places { clusters, pairs })
    }
}

/// Clusters of nodes with their columns by farthest-first traversal, beginning with the longest column.
fn clusters(columns: &[(usize, Vec<f64>)]) -> Vec<Vec<usize>> {
    let square = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
    let length = |column: &[f64]| column.iter().map(|x| x * x).sum::<f64>();
    let mut nearest: Vec<(f64, usize)> = columns.iter().map(|(_, column)| (length(column), usize::MAX)).collect();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < MOST_CLUSTERS.min(columns.len()) {
        let farther = |a: usize, b: usize| if nearest[b].0 > nearest[a].0 { b } else { a };
        let Some(next) = (0..columns.len()).filter(|place| !chosen.contains(place)).reduce(farther) else { break };
        for (place, (_, column)) in columns.iter().enumerate() {
            let distance = square(column, &columns[next].1);
            if nearest[place].1 == usize::MAX || distance < nearest[place].0 {
                nearest[place] = (distance, chosen.len());
            }
        }
        nearest[next] = (0.0, chosen.len());
        chosen.push(next);
    }
    let mut clusters: Vec<Vec<usize>> = chosen.iter().map(|&place| vec![columns[place].0]).collect();
    for (place, (node, _)) in columns.iter().enumerate() {
        if !chosen.contains(&place)
            && let Some(cluster) = clusters.get_mut(nearest[place].1)
        {
            cluster.push(*node);
        }
    }
    clusters
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
            return Ok(Some(next));
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
    fn representatives_are_far_apart_and_stand_for_their_neighbours() {
        // Two bundles of nodes, and one node apart.
        let columns: Vec<(usize, Vec<f64>)> = (0..130)
            .map(|node| match node {
                129 => (node, vec![0.0, -50.0]),
                _ if node % 2 == 0 => (node, vec![100.0 + 1e-3 * node as f64, 0.0]),
                _ => (node, vec![0.0, 100.0 - 1e-3 * node as f64]),
            })
            .collect();
        let clusters = clusters(&columns);
        assert_eq!(clusters.len(), MOST_CLUSTERS);
        assert!(clusters[..3].iter().any(|cluster| *cluster == [129]), "what lies apart comes early");
        assert_eq!(clusters.iter().map(Vec::len).sum::<usize>(), 130);
        for cluster in &clusters {
            assert!(cluster.iter().all(|node| node % 2 == cluster[0] % 2), "bundles stay apart: {cluster:?}");
        }
        let places = Places { clusters: vec![vec![1, 4, 5], vec![2, 3], vec![9]], pairs: vec![[1, 2], [1, 9], [2, 9]] };
        assert_eq!(places.near([1, 2]), [[1, 3], [2, 4], [3, 4], [2, 5], [3, 5]]);
        assert_eq!(places.near([9, 2]), [[3, 9]]);
        let refined = Places { pairs: [places.pairs.clone(), vec![[1, 3]]].concat(), ..places };
        assert!(refined.near([1, 2]).is_empty(), "they were looked at");
    }
}
