//! A parameter that its prior does not hold: it moves as the fit's own, but for the rows of the priors.

use super::{Base, Found};
use crate::diagnosis::FitError;
use crate::diagnosis::error::NoDirection;
use crate::diagnosis::linearisation::linear::Direction;
use crate::inference::target::{LeastSquares, Target};

/// Slopes of the readings by every unknown, found when first asked for.
#[derive(Default)]
pub(super) struct Parameters {
    /// `readings x unknowns`, whitened, of the predictions; or why there are none.
    slopes: Option<Result<Vec<f64>, FitError>>,
}

impl Parameters {
    /// The direction of a parameter; its amplitude is what is added to the value at the fit, which stands as its shape.
    pub fn direction(&mut self, base: &Base<'_>, position: usize, index: usize) -> Found {
        let problem = base.problem;
        let place =
            problem.parameters.iter().position(|&inferred| inferred == index).ok_or(NoDirection::NotInferred)?;
        if problem.joint.iter().any(|joint_prior| joint_prior.places().contains(&place)) {
            return Err(NoDirection::PosteriorAsPrior.into());
        }
        let wide = problem.wider_prior(index, 1.0).ok_or(NoDirection::Known)?;
        let slopes = self.slopes.get_or_insert_with(|| slopes(base)).as_ref().map_err(Clone::clone)?;
        let n = base.unknowns.len();
        let mut column: Vec<f64> = slopes.chunks_exact(n.max(1)).map(|row| row[place]).collect();
        if column.iter().all(|value| *value == 0.0) {
            return Err(NoDirection::NoReading.into());
        }
        column.resize(base.rows, 0.0);
        let (least, most) = wide.support();
        let at = base.unknowns[place];
        Ok(vec![Direction {
            candidate: position,
            parameters: vec![0],
            shape: vec![at],
            columns: column,
            lower: vec![(least - at).min(0.0)],
            upper: vec![(most - at).max(0.0)],
            plausible: vec![0.5 * (wide.quantile(0.84) - wide.quantile(0.16))],
            ..Direction::default()
        }])
    }
}

fn slopes(base: &Base<'_>) -> Result<Vec<f64>, FitError> {
    let (readings, n) = (base.residuals.len(), base.unknowns.len());
    let mut jacobian = vec![0.0; readings * n];
    let (mut residuals, mut gradient) = (vec![0.0; readings], vec![0.0; n]);
    let mut memory = base.likelihood.workspace();
    base.likelihood.jacobian(base.unknowns, &mut memory, &mut residuals, &mut jacobian, &mut gradient)?;
    jacobian.iter_mut().for_each(|slope| *slope = -*slope);
    Ok(jacobian)
}
