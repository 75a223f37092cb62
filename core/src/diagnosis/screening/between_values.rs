//! Dates and thresholds between those at which every effect is tried.
//!
//! Over a course an effect is tried at a few dates or thresholds ([`thresholds`](crate::diagnosis::linearisation::threshold_levels)).
//! Where the model's parameters take up most of what it does, what is left is near the right value alone, and half a spacing
//! away much of that is lost. So the effects that explain most are tried once more about their best value. These values follow
//! the residuals: they order effects and begin fits, and are in no test.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnosis::linearisation::threshold_levels::spacing_over_course;
use crate::diagnosis::{Direction, Problem};

/// Effects that are tried once more.
const MOST: usize = 200;
/// Values about the best one, in spacings: no value is further than a tenth from one that is tried.
const ABOUT: [f64; 4] = [-0.4, -0.2, 0.2, 0.4];

/// By candidate the shapes about its best one, SI; `ranked` are directions, the best first.
pub(super) fn shapes_between<'a>(
    problem: &Problem,
    ranked: impl Iterator<Item = &'a Direction>,
) -> BTreeMap<usize, Vec<Vec<f64>>> {
    let mut seen = BTreeSet::new();
    let best = ranked.filter(|direction| direction.probe.is_empty() && seen.insert(direction.candidate));
    best.filter_map(|direction| Some((direction.candidate, about(problem, direction)?))).take(MOST).collect()
}

/// The shapes about that of a direction. `None` where none of its parameters is tried at values spread over a course.
fn about(problem: &Problem, direction: &Direction) -> Option<Vec<Vec<f64>>> {
    let candidate = &problem.candidates[direction.candidate];
    let effect = problem.catalogue.get(&candidate.effect)?;
    let parameters = effect.parameters(&problem.model, &candidate.bound);
    let shape = parameters.iter().filter(|parameter| !parameter.amplitude);
    let (place, spacing) = shape.enumerate().find_map(|(place, parameter)| {
        let is_free = !parameter.prior.is_fixed() && place < direction.shape.len();
        let spacing = if is_free { spacing_over_course(problem, candidate, effect, parameter) } else { None };
        Some((place, spacing?))
    })?;
    let moved = |share: f64| {
        let mut shape = direction.shape.clone();
        shape[place] += share * spacing;
        shape
    };
    Some(ABOUT.map(moved).to_vec())
}
