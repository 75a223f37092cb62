//! How much memory a diagnosis takes, stated before it starts.
//!
//! Of few readings most of it are the columns of a screening, one number a fitted reading. They are bounded: where they are too many,
//! only the best directions are held (`diagnosis::screening::screen`). Of many readings it is what each fit leaves of these, and the
//! columns of heat without a cause (`diagnosis::heat`).

use std::collections::BTreeMap;

use crate::diagnosis::engine::Diagnosis;
use crate::diagnosis::heat::sources;
use crate::diagnosis::screening::screen::MOST_ENTRIES;
use crate::effect::{Chosen, Limits, candidates_at};
use crate::measurement::sensor_places;
use crate::thermal::NodeKind;

/// Directions of a candidate, on average: some effects are tried at several values of a parameter.
const DIRECTIONS: usize = 2;
/// Times that columns stand in memory: as directions, projected, and together for the distribution of the tests.
const COPIES: usize = 3;
/// Sets of effects that are fitted, as many as the longest records have had.
const FITS: usize = 120;
/// Numbers that a fit keeps of a reading: its residual and its error.
const OF_A_FIT: usize = 2;
/// Times that fits stand in memory: as they are known, as they are stored, and in the next stage.
const COPIES_OF_FITS: usize = 3;
/// Times that columns of heat stand in memory: in the Jacobian, and as columns of their own.
const COPIES_OF_HEAT: usize = 2;
/// Bytes of a candidate with its names, and of what its directions and expressions take beside their columns.
const CANDIDATE_BYTES: usize = 20 << 10;
/// Bytes of an element in expressions, programs and factors of the networks that are fitted at a time.
const ELEMENT_BYTES: usize = 96 << 10;

/// About how much memory so many candidates take, whose columns have so many rows, in a model of so many elements and with so many
/// sources of heat without a cause, bytes.
pub fn bytes(candidates: usize, rows: usize, elements: usize, sources: usize) -> u64 {
    let entries = candidates.saturating_mul(DIRECTIONS).saturating_mul(rows).min(2 * MOST_ENTRIES);
    let heat = sources.saturating_mul(rows).saturating_mul(COPIES_OF_HEAT);
    let fits = rows.saturating_mul(FITS * OF_A_FIT * COPIES_OF_FITS);
    let columns = (entries * COPIES).max(heat).saturating_add(fits).saturating_mul(size_of::<f64>());
    let rest = candidates.saturating_mul(CANDIDATE_BYTES).saturating_add(elements.saturating_mul(ELEMENT_BYTES));
    columns.saturating_add(rest) as u64
}

impl Diagnosis {
    /// About how much memory it takes at most, bytes.
    pub fn memory_bytes(&self) -> u64 {
        let problem = self.problem();
        let rows = problem.fitted_readings().len() + problem.parameters.len();
        let candidates = problem.candidates.len() + self.chosen_candidates();
        bytes(candidates, rows, problem.model.elements.len(), sources::count(problem))
    }

    /// How many candidates chosen places of a large model will have, by those of one place of each kind.
    fn chosen_candidates(&self) -> usize {
        let (problem, limits) = (self.problem(), &self.choice.limits);
        let model = &problem.model;
        let is_inner = |node: &usize| !matches!(model.nodes[*node].kind, NodeKind::Boundary { .. });
        let mut inner = (0..model.nodes.len()).filter(is_inner);
        let (Some(a), Some(b)) = (inner.next(), inner.next()) else { return 0 };
        let sensors = sensor_places(problem.measurements.iter());
        let is_wanted =
            |effect: &str| problem.considered.is_empty() || problem.considered.iter().any(|own| own == effect);
        let at = |place: Chosen| candidates_at(model, &sensors, &problem.catalogue, &[place], is_wanted).len();
        let most = self.choice.representatives.min(model.nodes.len());
        let mut count = 0;
        if limits.choose_pairs(model) {
            count += most * (most - 1) / 2 * at(Chosen::Pair([a, b]));
        }
        if limits.choose_members(model) {
            count += most * (at(Chosen::Node(a)) + at(Chosen::Surroundings(a)));
            count += most * self.kinds_to_choose(limits).map(|element| at(Chosen::Element(element))).sum::<usize>();
        }
        count
    }

    /// An element of each kind of which places are to be chosen.
    fn kinds_to_choose(&self, limits: &Limits) -> impl Iterator<Item = usize> {
        let model = &self.problem().model;
        let mut first = BTreeMap::new();
        for element in limits.elements_to_choose(model) {
            first.entry(model.elements[element].physics().kind()).or_insert(element);
        }
        first.into_values()
    }
}
