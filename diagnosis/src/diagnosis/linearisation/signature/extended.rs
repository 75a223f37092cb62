//! Exact derivatives of many effects at once: sensitivities of a model that holds them all with amplitude 0.

use crate::diagnosis::error::NoDirection;
use rayon::prelude::*;

use super::variant::{self, Variant};
use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::linearisation::linear::Direction;
use crate::inference::likelihood::Likelihood;
use crate::inference::target::{LeastSquares, Target};

/// Most variants that are solved together; blocks of them are solved beside one another, so that there are enough for all
/// threads.
const TOGETHER: usize = 96;

/// Solves variants together; where they do not go together, in halves, so that one that fails spoils no other.
pub fn solve(base: &Base<'_>, variants: &[Variant<'_>], directions: &mut [Found]) {
    let blocks: Vec<Vec<Solved>> = variants.par_chunks(TOGETHER).map(|block| solved(base, block)).collect();
    for (variant, direction) in variants.iter().zip(blocks.into_iter().flatten()) {
        variant::put(&mut directions[variant.asked], direction);
    }
}

/// A variant's direction, `None` where nothing depends on it, or why there is none.
type Solved = Result<Option<Direction>, FitError>;

fn solved(base: &Base<'_>, variants: &[Variant<'_>]) -> Vec<Solved> {
    match together(base, variants) {
        Ok(directions) => directions.into_iter().map(Ok).collect(),
        Err(reason) if variants.len() < 2 => variants.iter().map(|_| Err(reason.clone())).collect(),
        Err(_) => {
            let (first, second) = variants.split_at(variants.len() / 2);
            let mut all = solved(base, first);
            all.extend(solved(base, second));
            all
        }
    }
}

/// A direction for each variant; `None` where nothing depends on it.
fn together(base: &Base<'_>, variants: &[Variant<'_>]) -> Result<Vec<Option<Direction>>, FitError> {
    let (likelihood, widths) = extended(base, variants)?;
    let model_parameters = base.likelihood.model_parameters();
    let added: usize = widths.iter().sum();
    let mut unknowns = base.unknowns[..model_parameters].to_vec();
    unknowns.extend(std::iter::repeat_n(0.0, added));
    unknowns.extend(&base.unknowns[model_parameters..]);
    let (readings, n) = (likelihood.residual_count(), unknowns.len());
    if readings != base.residuals.len() || n != likelihood.dimension() {
        return Err(NoDirection::ChangesMeasurement.into());
    }
    let mut jacobian = vec![0.0; readings * n];
    let (mut residuals, mut gradient) = (vec![0.0; readings], vec![0.0; n]);
    let mut memory = likelihood.workspace();
    likelihood.jacobian(&unknowns, &mut memory, &mut residuals, &mut jacobian, &mut gradient)?;
    let mut first = model_parameters;
    let mut directions = Vec::with_capacity(variants.len());
    for (variant, width) in variants.iter().zip(widths) {
        let columns = (first..first + width).map(|place| {
            let readings = (0..readings).map(|row| -jacobian[row * n + place]);
            readings.collect::<Vec<f64>>()
        });
        directions.push(variant.direction(base.rows, columns)?);
        first += width;
    }
    Ok(directions)
}

/// The likelihood of the model with all variants, and the number of amplitudes of each.
fn extended(base: &Base<'_>, variants: &[Variant<'_>]) -> Result<(Likelihood, Vec<usize>), FitError> {
    let problem = base.problem;
    let mut hypothesis = problem.hypothesis(&[], 1.0)?;
    let mut widths = Vec::with_capacity(variants.len());
    for (number, variant) in variants.iter().enumerate() {
        let candidate = &problem.candidates[variant.candidate];
        let name = format!("{} ({number})", candidate.id);
        hypothesis.add_as(problem, candidate, variant.effect, &name, variant.parameters.clone())?;
        widths.push(variant.parameters.iter().filter(|parameter| parameter.amplitude).count());
    }
    Ok((hypothesis.likelihood(problem)?, widths))
}
