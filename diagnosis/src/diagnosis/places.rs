//! Places of a large model at which effects are sought: first those that the sensors can tell apart, then those near what was
//! found. Pairs of nodes are chosen first, in a still larger model nodes and elements too.
//!
//! A watt into a node moves the whitened predictions by a column. Nodes whose columns lie close together are one to the sensors;
//! so are those that no sensor sees, whose columns are zero. A path between two nodes moves the predictions by its heat times the
//! difference of their columns, so that a pair which stands for another errs by no more than its heat times the distances of the columns. What an element carries moves them by its heat times
//! the difference of the columns at its ends. Representatives are the points of a farthest-first
//! traversal (Gonzalez 1985), whose largest distance is at most twice the best possible one. Of like columns, as many leaves of one
//! hub have, the temperatures at the fit tell the nodes apart: what a path carries goes with them.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::diagnosis::FitError;
use crate::diagnosis::engine::{Diagnosis, State};
use crate::diagnosis::linearisation::signature;
use crate::diagnosis::screening::screen::Lead;
use crate::diagnosis::{Problem, Refit};
use crate::effect::{Bound, Candidate, Chosen, Limits, Site, candidates_at};
use crate::inference::likelihood::Likelihood;
use crate::math::sort::sort_by;
use crate::measurement::sensor_places;
use crate::thermal::NodeKind;

/// Neighbours of a representative in shares of all nodes: its own ones and those of the representatives around it.
const NEIGHBOURS: usize = 4;
/// Most neighbours of a representative.
const MOST_NEIGHBOURS: usize = 60;
/// Boundaries that are ends of their own.
const MOST_BOUNDARIES: usize = 8;
/// Places near one that was found which are added.
const MOST_NEAR: usize = 40;
/// Times that places near one that was found are added.
const MOST_REFINEMENTS: usize = 6;
/// Those that are fitted at once.
const FITTED_NEAR: usize = 8;
/// The effect whose columns tell nodes apart: heat into one.
const HEAT: &str = "heat-load";

/// Up to which size of a model all places are tried, and how many stand for the others in a larger one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Sizes up to which all places are tried.
    pub limits: Limits,
    /// Most representatives of nodes, and of each kind of element.
    pub representatives: usize,
}

impl Default for Choice {
    fn default() -> Self {
        // 2016 pairs.
        Self { limits: Limits::default(), representatives: 64 }
    }
}

/// Places that were chosen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Places {
    /// Representatives, each with the nodes that the sensors see most like it, itself first.
    pub neighbours: Vec<Vec<usize>>,
    /// Pairs between which effects are sought.
    pub pairs: Vec<[usize; 2]>,
    /// How often places near one that was found were added.
    pub refinements: usize,
    /// The same as `neighbours` of elements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<Vec<usize>>,
    /// Nodes and elements that are places, each with the number of pairs before it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<(usize, Chosen)>,
}

impl Places {
    /// All, in the order in which they were chosen.
    fn all(&self) -> Vec<Chosen> {
        let mut members = self.members.iter().peekable();
        let mut all = Vec::with_capacity(self.pairs.len() + self.members.len());
        for (before, pair) in self.pairs.iter().enumerate() {
            while let Some((_, member)) = members.next_if(|(own, _)| *own <= before) {
                all.push(*member);
            }
            all.push(Chosen::Pair(*pair));
        }
        all.extend(members.map(|(_, member)| *member));
        all
    }

    fn contains(&self, place: Chosen) -> bool {
        match place {
            Chosen::Pair(pair) => self.pairs.contains(&pair),
            member => self.members.iter().any(|(_, own)| *own == member),
        }
    }

    /// Adds a place behind the others, unless it is there.
    fn add(&mut self, place: Chosen) {
        match place {
            _ if self.contains(place) => {}
            Chosen::Pair(pair) => self.pairs.push(pair),
            member => self.members.push((self.pairs.len(), member)),
        }
    }

    /// Places near that of a candidate at a representative, or at two, which are no places yet.
    fn near(&self, candidate: &Candidate) -> Vec<Chosen> {
        if self.refinements >= MOST_REFINEMENTS {
            return Vec::new();
        }
        let nodes = |node: usize| self.neighbours.iter().find(|neighbours| neighbours[0] == node);
        let each = |representative: Option<&Vec<usize>>, place: fn(usize) -> Chosen| -> Vec<Chosen> {
            let own = representative.filter(|_| !self.members.is_empty());
            own.into_iter().flatten().map(|&member| place(member)).filter(|&place| !self.contains(place)).collect()
        };
        match &candidate.site {
            Site::Pair(ends) => self.near_pair(*ends).into_iter().map(Chosen::Pair).collect(),
            Site::Nodes(own) if !candidate.is_group() => {
                each(own.first().and_then(|&(node, _)| nodes(node)), Chosen::Node)
            }
            Site::Elements(own) if !candidate.is_group() => {
                let of = |element: &usize| self.elements.iter().find(|neighbours| neighbours[0] == *element);
                each(own.first().and_then(of), Chosen::Element)
            }
            Site::Sensors(_) => {
                let surroundings = candidate.bound.iter().find_map(|bound| match bound {
                    Bound::Node(node) => nodes(*node),
                    Bound::Input(_) => None,
                });
                each(surroundings, Chosen::Surroundings)
            }
            Site::Nodes(_) | Site::Elements(_) | Site::Parameter(_) => Vec::new(),
        }
    }

    /// Pairs near that of two representatives which are no places yet.
    pub fn near_pair(&self, ends: [usize; 2]) -> Vec<[usize; 2]> {
        let of = |node: usize| self.neighbours.iter().find(|neighbours| neighbours[0] == node);
        let (Some(first), Some(second)) = (of(ends[0]), of(ends[1])) else { return Vec::new() };
        let all = first.iter().flat_map(|&a| second.iter().map(move |&b| [a.min(b), a.max(b)]));
        let mut near: Vec<[usize; 2]> = all.filter(|pair| pair[0] < pair[1] && !self.pairs.contains(pair)).collect();
        near.sort_unstable();
        near.dedup();
        near
    }
}

/// Whitened columns of nodes or elements.
type Columns = Vec<(usize, Vec<f64>)>;

/// Squares of distances of columns below this share of the longest column's are rounding.
const LIKE: f64 = 1e-18;

/// What tells nodes or elements apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signature {
    /// Index of the node or element.
    pub index: usize,
    /// What a watt there, or the heat that it carries, moves the whitened predictions by.
    pub column: Vec<f64>,
    /// Temperatures at the fit, K, phase by phase; empty where none are known. They decide where columns are alike.
    pub temperatures_k: Vec<f64>,
}

/// How far two places are apart: the square of the distance of their columns, then of their temperatures.
#[derive(Clone, Copy)]
struct Distance(f64, f64);

impl Distance {
    fn of(a: &Signature, b: &Signature, like: f64) -> Self {
        let square = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
        let columns = square(&a.column, &b.column);
        Self(if columns < like { 0.0 } else { columns }, square(&a.temperatures_k, &b.temperatures_k))
    }

    fn total_cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.total_cmp(&other.1))
    }
}

impl Problem {
    /// The same with candidates at more places, behind those that it has; with those of one effect, where it is named.
    fn at_places(&self, places: Places, only: Option<&str>) -> Self {
        let sensors = sensor_places(self.measurements.iter());
        let before = self.places.pairs.len() + self.places.members.len();
        let new: Vec<Chosen> = places.all().into_iter().skip(before).collect();
        let is_wanted = |effect: &str| {
            only.is_none_or(|only| only == effect)
                && (self.considered.is_empty() || self.considered.iter().any(|own| own == effect))
        };
        let more = candidates_at(&self.model, &sensors, &self.catalogue, &new, is_wanted);
        let mut problem = self.clone();
        Arc::make_mut(&mut problem.candidates).extend(more);
        problem.places = places;
        problem
    }

    /// The places of a large model at a fit of it.
    fn choose_places(&self, refit: &Refit, choice: &Choice) -> Result<Places, FitError> {
        let sensors = sensor_places(self.measurements.iter());
        let mut heated = self.clone();
        let nodes: Vec<Chosen> = (0..self.model.nodes.len()).map(Chosen::Node).collect();
        let mut heat = candidates_at(&self.model, &sensors, &self.catalogue, &nodes, |effect| effect == HEAT);
        heat.retain(|candidate| matches!(candidate.site, Site::Nodes(_)));
        heated.candidates = Arc::new(heat);
        let likelihood = heated.hypothesis(&[], 1.0)?.likelihood(&heated)?;
        let positions: Vec<usize> = (0..heated.candidates.len()).collect();
        let mut columns: Columns = Vec::new();
        signature::for_each_direction(&heated, &likelihood, &refit.unknowns, &positions, &mut |directions| {
            columns.extend(directions.into_iter().filter_map(|direction| {
                let Site::Nodes(nodes) = &heated.candidates[direction.candidate].site else { return None };
                let [(node, _)] = nodes[..] else { return None };
                Some((node, direction.columns))
            }));
        })?;
        let most = choice.representatives;
        let signatures = self.signatures(&likelihood, refit, &columns)?;
        let mut places = Places { neighbours: neighbours(&signatures, most), ..Places::default() };
        if choice.limits.choose_members(&self.model) {
            let first = |all: &[Vec<usize>]| all.iter().map(|members| members[0]).collect::<Vec<usize>>();
            let elements = choice.limits.elements_to_choose(&self.model);
            for (_, columns) in self.element_columns(&likelihood, refit, &columns, elements)? {
                let one = |(index, column)| Signature { index, column, ..Signature::default() };
                let signatures: Vec<Signature> = columns.into_iter().map(one).collect();
                places.elements.extend(neighbours(&signatures, most));
            }
            let nodes = first(&places.neighbours);
            let is_seen = |node: &&usize| columns.iter().any(|(own, _)| own == *node);
            nodes.iter().filter(is_seen).for_each(|&node| places.add(Chosen::Node(node)));
            nodes.iter().for_each(|&node| places.add(Chosen::Surroundings(node)));
            first(&places.elements).into_iter().for_each(|element| places.add(Chosen::Element(element)));
        }
        let is_boundary = |node: &usize| matches!(self.model.nodes[*node].kind, NodeKind::Boundary { .. });
        let boundaries = (0..self.model.nodes.len()).filter(is_boundary).take(MOST_BOUNDARIES);
        places.neighbours.extend(boundaries.map(|node| vec![node]));
        let first: Vec<usize> = places.neighbours.iter().map(|nodes| nodes[0]).collect();
        for (place, &a) in first.iter().enumerate() {
            for &b in &first[place + 1..] {
                if !(is_boundary(&a) && is_boundary(&b)) {
                    places.pairs.push([a.min(b), a.max(b)]);
                }
            }
        }
        Ok(places)
    }

    /// Inner nodes with their columns, those that no sensor sees with zeros, and their temperatures in steady phases at a fit.
    fn signatures(
        &self,
        likelihood: &Likelihood,
        refit: &Refit,
        seen: &[(usize, Vec<f64>)],
    ) -> Result<Vec<Signature>, FitError> {
        let states = likelihood.steady_states(&refit.unknowns)?;
        let rows = seen.first().map_or(0, |(_, column)| column.len());
        let by_node: BTreeMap<usize, &Vec<f64>> = seen.iter().map(|(node, column)| (*node, column)).collect();
        let is_inner = |node: &usize| !matches!(self.model.nodes[*node].kind, NodeKind::Boundary { .. });
        let signature = |index| Signature {
            index,
            column: by_node.get(&index).map_or_else(|| vec![0.0; rows], |column| column.to_vec()),
            temperatures_k: states.iter().filter_map(|state| state.temperatures.get(index).copied()).collect(),
        };
        Ok((0..self.model.nodes.len()).filter(is_inner).map(signature).collect())
    }

    /// Columns of elements, kind by kind: of what they carry at a fit; of a watt through them where
    /// transients are fitted.
    fn element_columns(
        &self,
        likelihood: &Likelihood,
        refit: &Refit,
        nodes: &[(usize, Vec<f64>)],
        elements: Vec<usize>,
    ) -> Result<BTreeMap<&str, Columns>, FitError> {
        let columns = if self.has_transients() {
            let by_node: BTreeMap<usize, &[f64]> = nodes.iter().map(|(node, own)| (*node, own.as_slice())).collect();
            let rows = nodes.first().map_or(0, |(_, own)| own.len());
            let through = |&element: &usize| {
                let mut column = vec![0.0; rows];
                for (node, sign) in self.model.elements[element].nodes().iter().zip([1.0, -1.0]) {
                    let own = by_node.get(node).copied().unwrap_or_default();
                    column.iter_mut().zip(own).for_each(|(sum, value)| *sum += sign * value);
                }
                column
            };
            elements.iter().map(through).collect()
        } else {
            signature::columns_of_elements(self, likelihood, &refit.unknowns, &elements)?
        };
        let mut by_kind: BTreeMap<&str, Columns> = BTreeMap::new();
        for (element, column) in elements.into_iter().zip(columns) {
            by_kind.entry(self.model.elements[element].physics().kind()).or_default().push((element, column));
        }
        Ok(by_kind)
    }
}

/// Representatives of nodes, or elements, by farthest-first traversal, beginning with the longest column, each
/// with its neighbours: where these would be too many, all the nearest and ever fewer of those farther away.
pub fn neighbours(places: &[Signature], most: usize) -> Vec<Vec<usize>> {
    let length = |place: &Signature| place.column.iter().map(|x| x * x).sum::<f64>();
    let like = LIKE * places.iter().map(length).fold(0.0, f64::max);
    let mut nearest: Vec<Distance> = places.iter().map(|place| Distance(length(place), 0.0)).collect();
    let wide = NEIGHBOURS * places.len().div_ceil(most) + NEIGHBOURS;
    let count = wide.min(MOST_NEIGHBOURS);
    let rank = |k: usize| k + (wide - count) * k * k / (count * count);
    let mut chosen: Vec<usize> = Vec::new();
    let mut all = Vec::new();
    while chosen.len() < most {
        let farther = |a: usize, b: usize| if nearest[b].total_cmp(&nearest[a]).is_gt() { b } else { a };
        let Some(next) = (0..places.len()).filter(|place| !chosen.contains(place)).reduce(farther) else { break };
        let is_first = chosen.is_empty();
        let mut by_distance: Vec<(Distance, usize)> = Vec::with_capacity(places.len());
        for (place, signature) in places.iter().enumerate() {
            let distance = Distance::of(signature, &places[next], like);
            let is_nearer = is_first || distance.total_cmp(&nearest[place]).is_lt();
            nearest[place] = if is_nearer { distance } else { nearest[place] };
            if place != next {
                by_distance.push((distance, place));
            }
        }
        sort_by(&mut by_distance, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let near = (0..count).filter_map(|k| by_distance.get(rank(k))).map(|&(_, place)| places[place].index);
        all.push(std::iter::once(places[next].index).chain(near).collect());
        chosen.push(next);
    }
    all
}

impl Diagnosis {
    /// The same with effects at chosen places, at the baseline model's fit; where all places are candidates, this.
    pub(crate) fn at_chosen_places(&self, baseline: &Refit) -> Result<Self, FitError> {
        if !self.choice.limits.choose_pairs(&self.problem().model) {
            return Ok(self.clone());
        }
        Ok(self.with_places(self.problem().choose_places(baseline, &self.choice)?))
    }

    /// The same with effects at more places.
    pub(crate) fn with_places(&self, places: Places) -> Self {
        self.with_problem(self.problem().at_places(places, None))
    }

    /// Orders effects at places near those of a set, where these stand for others. `None` if they stand for themselves.
    pub(crate) fn refine(&self, problem: &Problem, state: &State, place: usize) -> Result<Option<State>, FitError> {
        let set = &state.refits[place].effects;
        for &effect in set {
            let near = problem.places.near(&problem.candidates[effect]);
            let rest: Vec<usize> = set.iter().copied().filter(|&other| other != effect).collect();
            let Some(from) = state.refits.iter().position(|refit| refit.effects == rest) else { continue };
            if near.is_empty() {
                continue;
            }
            let mut leads = self.leads_near(state, &near, effect, from)?;
            leads.truncate(MOST_NEAR);
            let mut next = state.clone();
            leads.iter().for_each(|(place, _, _)| next.places.add(*place));
            next.places.refinements += 1;
            let refined = self.with_places(next.places.clone());
            for (_, id, lead) in leads.iter().take(FITTED_NEAR) {
                if let Some(candidate) = refined.problem().candidates.iter().rposition(|own| own.id == *id) {
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

    /// What an effect at each of some places would explain beside a fit, the most first, each with the id of its candidate.
    fn leads_near(
        &self,
        state: &State,
        near: &[Chosen],
        effect: usize,
        from: usize,
    ) -> Result<Vec<(Chosen, String, Lead)>, FitError> {
        let mut places = self.problem().places.clone();
        near.iter().for_each(|&place| places.add(place));
        let name = &self.problem().candidates[effect].effect;
        let wide = self.with_problem(self.problem().at_places(places, Some(name)));
        let problem = wide.with_noise(&state.noise, &state.most_steps).with(&state.refits[from])?;
        let positions: Vec<usize> = (self.problem().candidates.len()..problem.candidates.len()).collect();
        let leads = wide.leads_among(&problem, &state.refits[from], &positions)?;
        let of = |lead: Lead| {
            let candidate = &problem.candidates[lead.candidate];
            let place = match &candidate.site {
                Site::Pair([a, b]) => Chosen::Pair([*a.min(b), *a.max(b)]),
                Site::Nodes(nodes) => Chosen::Node(nodes.first()?.0),
                Site::Elements(elements) => Chosen::Element(*elements.first()?),
                Site::Sensors(_) => candidate.bound.iter().find_map(|bound| match bound {
                    Bound::Node(node) => Some(Chosen::Surroundings(*node)),
                    Bound::Input(_) => None,
                })?,
                Site::Parameter(_) => return None,
            };
            Some((place, candidate.id.clone(), lead))
        };
        Ok(leads.into_iter().filter_map(of).collect())
    }
}
