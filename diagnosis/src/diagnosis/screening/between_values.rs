//! Dates and thresholds between those at which every effect is tried.
//!
//! Over a course an effect is tried at a few dates or thresholds ([`thresholds`](crate::diagnosis::linearisation::threshold_levels)).
//! The model's parameters may take up most of what it does. Only what is near the right value is left then, and half a spacing
//! away much of that is lost. So the effects that explain most are tried once more about their best value. These values follow
//! the residuals: they order effects and begin fits, and are in no test.

use std::collections::BTreeMap;

use crate::diagnosis::linearisation::threshold_levels::spacing_over_course;
use crate::diagnosis::{Direction, Problem};

/// Effects with a date or a threshold that are tried once more.
const MOST: usize = 200;
/// Values about the best one, in spacings: no value is further than a tenth from one that is tried.
const ABOUT: [f64; 4] = [-0.4, -0.2, 0.2, 0.4];

/// By candidate the shapes about its best one, SI; `ranked` has the best direction of each candidate, the best first.
pub(super) fn shapes_between<'a>(
    problem: &Problem,
    ranked: impl Iterator<Item = &'a Direction>,
) -> BTreeMap<usize, Vec<Vec<f64>>> {
    let smooth = ranked.filter(|direction| direction.probe.is_empty());
    smooth.filter_map(|direction| Some((direction.candidate, about(problem, direction)?))).take(MOST).collect()
}

/// The shapes about that of a direction. `None` where no date or threshold of it is tried at values spread over a course.
fn about(problem: &Problem, direction: &Direction) -> Option<Vec<Vec<f64>>> {
    let candidate = &problem.candidates[direction.candidate];
    let effect = problem.catalogue.get(&candidate.effect)?;
    let parameters = effect.parameters(&problem.model, &candidate.bound);
    // Beside another one that is free a threshold is tried at its prior's quantiles.
    let mut shape = parameters.iter().filter(|parameter| !parameter.amplitude).enumerate();
    let (place, parameter) = shape.find(|(_, parameter)| !parameter.prior.is_fixed())?;
    let spacing = spacing_over_course(problem, candidate, effect, parameter)?;
    let moved = |share: f64| {
        let mut shape = direction.shape.clone();
        *shape.get_mut(place)? += share * spacing;
        Some(shape)
    };
    ABOUT.into_iter().map(moved).collect()
}
