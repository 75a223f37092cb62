//! What each candidate would do to the whitened predictions at a fit: its signature.
//!
//! `linearise`: the baseline model at its fit. `directions`: every candidate. An effect that is smooth at amplitude 0
//! has derivatives: with steady phases alone exact ones by adjoints (`adjoint`), with transients as sensitivities of a model
//! that holds many effects with amplitude 0 (`extended`), over long ones as responses of the network linearised along its course
//! (`along`) or, where that cannot be had, on fewer rows (`coarse`); what an amplitude does at fixed temperatures is `slopes`. One that is not smooth, such as a hidden node, is tried at finite
//! values (`probe`), over long records as a node that responds along the course (`added_node`); sensors that are late or whose clocks are off read the predictions at other times (`timing`), exchanged channels are exchanged predictions (`swap`), a prior that is too narrow is its parameter (`parameter`). What no reading can see is stated with its
//! reason (`form`: which of these an effect is, and why not).

pub mod added_node;
mod adjoint;
pub mod along;
mod blank;
mod coarse;
pub mod extended;
pub mod form;
mod parameter;
mod probe;
mod slopes;
mod swap;
mod timing;
pub mod variant;

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::diagnosis::linearisation::linear::{Direction, Linear};
use crate::diagnosis::problem::Problem;
use crate::effect::Site;
use crate::inference::estimate::natural::NaturalObjective;
use crate::inference::estimate::optimise::Objective;
use crate::inference::likelihood::{Likelihood, Whitening};
use crate::inference::target::{LeastSquares, Rejected, Target};
use crate::measurement::Rows;
use added_node::Added;
use adjoint::Phases;
use along::Courses;
use coarse::Coarse;
use form::{Form, Forms};
use variant::Variant;

/// A coordinate this close to a bound, as a share of its range, is at it.
const AT_BOUND: f64 = 1e-9;
/// Entries of the derivatives that are held at once.
const MOST_ENTRIES: usize = 1 << 22;
/// Most candidates whose derivatives are found together.
const MOST_TOGETHER: usize = 2000;

/// A candidate that has no direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Unseen {
    /// Position in the problem's list.
    pub candidate: usize,
    /// Why, such as `steady phases do not see heat capacities`.
    pub reason: FitError,
}

/// Whitened residuals and their slopes at given unknowns (SI, of this likelihood).
///
/// The Jacobian is that of the predictions, so that a step `d` leaves `r - J d`; an unknown of the noise has a column as
/// any other. The bounds are those of a step; exactly 0 for what
/// stands at its bound.
///
/// # Errors
/// [`FitError`] where the likelihood cannot be evaluated there.
pub fn linearise(likelihood: &Likelihood, unknowns: &[f64]) -> Result<Linear, FitError> {
    let mut objective = NaturalObjective::new(likelihood)?;
    let at = objective.coordinates(unknowns);
    let (rows, n) = (objective.rows(), objective.dimension());
    let mut linear = Linear {
        rows,
        readings: objective.data_rows(),
        residuals: vec![0.0; rows],
        jacobian: vec![0.0; rows * n],
        lower: vec![0.0; n],
        upper: vec![0.0; n],
    };
    let mut gradient = vec![0.0; n];
    if objective.slopes(&at, &mut linear.residuals, &mut linear.jacobian, &mut gradient).is_none() {
        // The objective counts reasons; the likelihood tells this one.
        let mut residuals = vec![0.0; linear.readings];
        likelihood.residuals(unknowns, &mut likelihood.workspace(), &mut residuals)?;
        return Err(Rejected::new("derivatives of the predictions are not there").into());
    }
    // The objective's are slopes of the residuals.
    for value in &mut linear.jacobian {
        *value = -*value;
    }
    let bounds = objective.bounds();
    for i in 0..n {
        let width = bounds.upper[i] - bounds.lower[i];
        let scale = if width.is_finite() {
            width
        } else {
            let mut end = unknowns.to_vec();
            end[i] = likelihood.priors()[i].quantile(0.84);
            let end = objective.coordinates(&end)[i];
            (end - at[i]).abs().max(at[i].abs())
        };
        let room = |bound: f64| if (bound - at[i]).abs() <= AT_BOUND * scale { 0.0 } else { bound - at[i] };
        linear.lower[i] = room(bounds.lower[i]).min(0.0);
        linear.upper[i] = room(bounds.upper[i]).max(0.0);
    }
    Ok(linear)
}

/// All directions, in the order of the candidates, and the candidates that have none. As [`for_each_direction`].
///
/// # Errors
/// [`FitError`].
pub fn directions(
    problem: &Problem,
    likelihood: &Likelihood,
    unknowns: &[f64],
) -> Result<(Vec<Direction>, Vec<Unseen>), FitError> {
    let mut all = Vec::new();
    let positions: Vec<usize> = (0..problem.candidates.len()).collect();
    let unseen = for_each_direction(problem, likelihood, unknowns, &positions, &mut |block| all.extend(block))?;
    Ok((all, unseen))
}

/// Columns, one a reading, of what some elements of the problem's model carry in steady phases at its fit: what a change of an
/// element in proportion to itself would do.
///
/// # Errors
/// [`FitError`] where the fit cannot be evaluated.
pub fn columns_of_elements(
    problem: &Problem,
    likelihood: &Likelihood,
    unknowns: &[f64],
    elements: &[usize],
) -> Result<Vec<Vec<f64>>, FitError> {
    let base = Base::new(problem, likelihood, unknowns)?;
    Phases::new(likelihood, unknowns)?.heats_of_elements(&base, elements)
}

/// Candidates between two nodes that are tried at finite values, each of which takes some transients of its own.
pub fn probed_pairs(problem: &Problem) -> Vec<usize> {
    let forms = Forms::new(problem);
    let is_pair = |&position: &usize| matches!(problem.candidates[position].site, Site::Pair(_));
    let is_probed = |&position: &usize| matches!(forms.of(problem, position), Form::Probe { .. });
    (0..problem.candidates.len()).filter(is_pair).filter(is_probed).collect()
}

/// Gives the directions of candidates block after block, in the order of their positions: a direction for each value
/// of an effect's shape parameters that is tried, or for each probe of an effect that is not smooth at amplitude 0.
/// `likelihood` is that of the problem without effects, `unknowns` (SI) its fit. What comes back are the candidates
/// that have none.
///
/// # Errors
/// [`FitError`] where the fit cannot be evaluated.
pub fn for_each_direction(
    problem: &Problem,
    likelihood: &Likelihood,
    unknowns: &[f64],
    positions: &[usize],
    give: &mut dyn FnMut(Vec<Direction>),
) -> Result<Vec<Unseen>, FitError> {
    let signatures = Signatures::new(problem, likelihood, unknowns)?;
    signatures.for_each(positions, &mut |directions| {
        give(directions.into_par_iter().map(Direction::on_all_rows).collect());
    })
}

/// What the directions of candidates at a fit are found from.
pub struct Signatures<'a> {
    base: Base<'a>,
    coarse: Option<Coarse>,
    courses: Option<Courses>,
    forms: Forms,
    /// Transients have no adjoints here.
    phases: Option<Phases>,
}

impl<'a> Signatures<'a> {
    /// Of a problem whose `likelihood` without effects has its fit at `unknowns` (SI).
    ///
    /// # Errors
    /// [`FitError`] where the fit cannot be evaluated.
    pub fn new(problem: &'a Problem, likelihood: &'a Likelihood, unknowns: &'a [f64]) -> Result<Self, FitError> {
        let base = Base::new(problem, likelihood, unknowns)?;
        // Where the means have no solution, every row is kept.
        let coarse = Coarse::new(&base).ok().flatten().filter(|coarse| coarse.base().is_ok());
        let courses = coarse.as_ref().and_then(|coarse| Courses::new(&base, coarse.kept()));
        let forms = Forms::new(problem);
        let phases = if forms.is_steady() { Some(Phases::new(likelihood, unknowns)?) } else { None };
        Ok(Self { base, coarse, courses, forms, phases })
    }

    /// Gives directions of smooth effects at these values of their shapes (SI, by candidate) in place of the usual ones.
    ///
    /// # Errors
    /// As [`Signatures::for_each`].
    pub fn at_shapes(
        mut self,
        shapes: BTreeMap<usize, Vec<Vec<f64>>>,
        give: &mut dyn FnMut(Vec<Direction>),
    ) -> Result<(), FitError> {
        let positions: Vec<usize> = shapes.keys().copied().collect();
        self.base.shapes = shapes;
        self.for_each(&positions, give).map(|_| ())
    }

    /// Gives the directions of candidates as [`for_each_direction`], but where few coordinates stand for the rows of a direction, it
    /// has these.
    ///
    /// # Errors
    /// [`FitError`] where the fit cannot be evaluated.
    pub fn for_each(&self, positions: &[usize], give: &mut dyn FnMut(Vec<Direction>)) -> Result<Vec<Unseen>, FitError> {
        let Self { base, coarse, courses, forms, phases } = self;
        let problem = base.problem;
        let coarse_base = coarse.as_ref().and_then(|coarse| coarse.base().ok());
        let fewer_rows = coarse.as_ref().zip(coarse_base.as_ref());
        let (mut swaps, mut timings) = (swap::Swaps::default(), timing::Timings::default());
        let mut parameters = parameter::Parameters::default();
        let mut unseen = Vec::new();
        let together = (MOST_ENTRIES / base.rows.max(1)).clamp(16, MOST_TOGETHER);
        for block in positions.chunks(together) {
            let forms: Vec<Form<'_>> = block.iter().map(|&position| forms.of(problem, position)).collect();
            let smooth: Vec<(usize, &Form<'_>)> =
                block.iter().copied().zip(&forms).filter(|(_, form)| matches!(form, Form::Smooth { .. })).collect();
            let exact = || match fewer_rows {
                Some(fewer_rows) => exact_on_fewer_rows(base, fewer_rows, courses.as_ref(), &smooth),
                None => exact(base, phases.as_ref(), &smooth),
            };
            let added = self.added_nodes(block, &forms);
            let probe = |((&position, form), added): ((&usize, &Form<'_>), &Option<Added>)| match (form, fewer_rows) {
                _ if added.is_some() => None,
                (Form::Probe { effect }, Some((coarse, coarse_base))) if coarse.takes(position) => {
                    Some(coarse.on_all_rows(base, probe::directions(coarse_base, position, effect)))
                }
                (Form::Probe { effect }, _) => Some(probe::directions(base, position, effect)),
                _ => None,
            };
            let probed = || block.par_iter().zip(&forms).zip(&added).filter_map(probe).collect::<Vec<Found>>();
            let (exact, probed) = rayon::join(exact, probed);
            let is_added: Vec<bool> = added.iter().map(Option::is_some).collect();
            let added: Vec<Added> = added.into_iter().flatten().collect();
            let of_nodes = courses.as_ref().map(|courses| courses.directions_of_nodes(base, &added));
            let mut of_nodes = of_nodes.into_iter().flatten();
            let (mut exact, mut probed) = (exact.into_iter(), probed.into_iter());
            let mut found = Vec::new();
            for ((&position, form), is_added) in block.iter().zip(&forms).zip(is_added) {
                let candidate_directions = match form {
                    Form::Unseen(reason) => Err((*reason).into()),
                    Form::Probe { .. } if is_added => of_nodes.next().unwrap_or(Err(NoDirection::NotScreened.into())),
                    Form::Smooth { .. } => exact.next().unwrap_or(Err(NoDirection::NotScreened.into())),
                    Form::Probe { .. } => probed.next().unwrap_or(Err(NoDirection::NotScreened.into())),
                    Form::Swap => swaps.direction(base, position),
                    Form::Timing { effect } => timings.directions(base, position, effect),
                    Form::Parameter(index) => parameters.direction(base, position, *index),
                };
                match candidate_directions {
                    Ok(candidate_directions) => found.extend(candidate_directions),
                    Err(reason) => unseen.push(Unseen { candidate: position, reason }),
                }
            }
            give(found);
        }
        Ok(unseen)
    }

    /// By candidate of a block what its probes add, where that is a node whose responses are found along the courses.
    fn added_nodes(&self, block: &[usize], forms: &[Form<'_>]) -> Vec<Option<Added>> {
        let is_found = |position: usize| {
            let is_shown = self.coarse.as_ref().is_some_and(|coarse| coarse.takes(position));
            is_shown && self.courses.is_some() && !self.forms.has_steady_phases()
        };
        let of = |(&position, form): (&usize, &Form<'_>)| match form {
            Form::Probe { effect } if is_found(position) => added_node::added(&self.base, position, effect),
            _ => None,
        };
        block.par_iter().zip(forms).map(of).collect()
    }
}

/// The directions of effects that are smooth at amplitude 0.
fn exact(base: &Base<'_>, phases: Option<&Phases>, asked: &[(usize, &Form<'_>)]) -> Vec<Found> {
    let variants = variant::variants(base, asked);
    let mut exact_directions: Vec<Found> = asked.iter().map(|_| Ok(Vec::new())).collect();
    match phases {
        Some(phases) => phases.directions(base, &variants, &mut exact_directions),
        None => extended::solve(base, &variants, &mut exact_directions),
    }
    without_reading(exact_directions)
}

/// The same where effects on nodes are found on fewer rows. Thresholds are those between the levels of all rows.
fn exact_on_fewer_rows(
    base: &Base<'_>,
    (coarse, coarse_base): (&Coarse, &Base<'_>),
    courses: Option<&Courses>,
    asked: &[(usize, &Form<'_>)],
) -> Vec<Found> {
    // What a sensor adds to its readings leaves the network as it is: its course has all rows.
    let takes = |candidate: usize| {
        let is_of_sensors = || matches!(base.problem.candidates[candidate].site, Site::Sensors(_));
        coarse.takes(candidate) || (courses.is_some() && is_of_sensors())
    };
    let (on_fewer, on_all): (Vec<Variant<'_>>, Vec<Variant<'_>>) =
        variant::variants(base, asked).into_iter().partition(|variant| takes(variant.candidate));
    let none = || -> Vec<Found> { asked.iter().map(|_| Ok(Vec::new())).collect() };
    let drawn = || {
        let mut directions = none();
        if let Some(courses) = courses {
            courses.directions(base, &on_fewer, &mut directions);
            return directions;
        }
        extended::solve(coarse_base, &on_fewer, &mut directions);
        let on_all_rows = |(found, (position, _)): (Found, &(usize, &Form<'_>))| {
            if coarse.takes(*position) { coarse.on_all_rows(base, found) } else { found }
        };
        directions.into_par_iter().zip(asked).map(on_all_rows).collect::<Vec<Found>>()
    };
    let whole = || {
        let mut directions = none();
        extended::solve(base, &on_all, &mut directions);
        directions
    };
    let (drawn, whole) = rayon::join(drawn, whole);
    let of_both = drawn.into_iter().zip(whole).zip(asked);
    without_reading(of_both.map(|((drawn, whole), asked)| if takes(asked.0) { drawn } else { whole }).collect())
}

/// Says of candidates without a direction that no reading depends on them.
fn without_reading(mut exact_directions: Vec<Found>) -> Vec<Found> {
    for directions in exact_directions.iter_mut().filter(|directions| directions.as_ref().is_ok_and(Vec::is_empty)) {
        *directions = Err(NoDirection::NoReading.into());
    }
    exact_directions
}

/// The directions of a candidate, or why there is none.
pub type Found = Result<Vec<Direction>, FitError>;

/// The model without effects at its fit.
pub struct Base<'a> {
    problem: &'a Problem,
    likelihood: &'a Likelihood,
    unknowns: &'a [f64],
    /// Whitened residuals of the readings.
    residuals: Vec<f64>,
    whitening: Whitening,
    /// Readings and rows of priors.
    rows: usize,
    /// Values (SI) of the shapes of candidates that are not tried at the usual ones.
    shapes: BTreeMap<usize, Vec<Vec<f64>>>,
}

impl<'a> Base<'a> {
    /// The model at values of its unknowns.
    ///
    /// # Errors
    /// Why nothing can be predicted there.
    pub fn new(problem: &'a Problem, likelihood: &'a Likelihood, unknowns: &'a [f64]) -> Result<Self, FitError> {
        let mut residuals = vec![0.0; likelihood.residual_count()];
        likelihood.residuals(unknowns, &mut likelihood.workspace(), &mut residuals)?;
        let rows = NaturalObjective::new(likelihood)?.rows();
        let whitening = likelihood.whitening(unknowns)?;
        Ok(Self { problem, likelihood, unknowns, residuals, whitening, rows, shapes: BTreeMap::new() })
    }

    /// Unknowns of another likelihood that has most of these: by name, others at their prior's median.
    fn carried(&self, other: &Likelihood) -> Vec<f64> {
        let base_unknowns = self.likelihood.unknowns();
        let values: std::collections::HashMap<&str, f64> =
            base_unknowns.names.iter().map(String::as_str).zip(self.unknowns.iter().copied()).collect();
        (other.unknowns().names.iter().zip(&other.unknowns().priors))
            .map(|(name, prior)| values.get(name.as_str()).copied().unwrap_or_else(|| prior.quantile(0.5)))
            .collect()
    }
}

/// Which kinds of measurement have readings to fit.
fn kinds(problem: &Problem) -> (bool, bool) {
    let (mut steady, mut transient) = (false, false);
    for measurement in &problem.measurements {
        let sensors = measurement.sensors.len();
        let has_reading = |row| (0..sensors).any(|sensor| measurement.reading(row, sensor).is_some());
        let used = measurement.fitted_rows().any(has_reading);
        match measurement.rows {
            Rows::Steady(_) => steady |= used,
            Rows::Transient { .. } => transient |= used,
        }
    }
    (steady, transient)
}
