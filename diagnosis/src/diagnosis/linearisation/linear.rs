//! The whitened problem, linearised at a fit.
//!
//! With `z` the readings, `f` the model, `W' W` the inverse covariance of the noise: `r = W (z - f)`, `J = W df/dtheta`,
//! `g = W df/da`. Normal priors are rows of `r` and `J` of their own (`g` is 0 there), uniform ones bounds of the step `d`:
//! the fit with a step `d` and an amplitude `a` has the sum of squares `|r - J d - g a|^2`.

use std::sync::Arc;

use super::between_rows::BetweenRows;

/// The baseline model at its fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Linear {
    /// Number of rows: readings, then rows of the priors.
    pub rows: usize,
    /// Number of rows that are readings.
    pub readings: usize,
    /// Whitened residuals `r`, by row.
    pub residuals: Vec<f64>,
    /// `J`, row by row (`rows x parameters`), in natural coordinates (logarithms where the prior is logarithmic).
    pub jacobian: Vec<f64>,
    /// Lower bound of each parameter's step, at most 0; minus infinity where there is none.
    pub lower: Vec<f64>,
    /// Upper bound of each parameter's step, at least 0.
    pub upper: Vec<f64>,
}

impl Linear {
    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.lower.len()
    }
}

/// How an effect would move the whitened predictions: one or several columns with an amplitude each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Direction {
    /// Position of the effect's candidate in the problem's list.
    pub candidate: usize,
    /// Position of each amplitude among the effect's parameters; empty where there is a probe.
    pub parameters: Vec<usize>,
    /// Values, SI, of the parameters that only shape the effect, in their order; empty where there is none or a probe.
    pub shape: Vec<f64>,
    /// `g`, column by column (`rows x columns`), 0 in the rows of the priors.
    pub columns: Vec<f64>,
    /// The coordinates that stand for the rows; `None` where these stand for themselves.
    pub coordinates: Option<Arc<BetweenRows>>,
    /// Lower bound of each amplitude, SI: 0 where only positive ones are physical, minus infinity without a bound.
    pub lower: Vec<f64>,
    /// Upper bound of each amplitude, SI.
    pub upper: Vec<f64>,
    /// Plausible size of each amplitude, SI, above 0.
    pub plausible: Vec<f64>,
    /// For an effect that is not smooth at 0: the values of the effect's parameters, SI, at which the column was found as
    /// a finite difference; the amplitude is then a share of these (bounds 0 and infinity, plausible 1). Empty else.
    pub probe: Vec<f64>,
}

impl Direction {
    /// Number of amplitudes.
    pub fn amplitudes(&self) -> usize {
        self.lower.len()
    }

    /// What it is a direction of, without columns.
    pub fn without_columns(&self) -> Self {
        Self {
            candidate: self.candidate,
            parameters: self.parameters.clone(),
            shape: self.shape.clone(),
            columns: Vec::new(),
            coordinates: None,
            lower: self.lower.clone(),
            upper: self.upper.clone(),
            plausible: self.plausible.clone(),
            probe: self.probe.clone(),
        }
    }

    /// The direction with all its rows.
    pub fn on_all_rows(mut self) -> Self {
        if let Some(coordinates) = self.coordinates.take() {
            let columns = self.columns.chunks_exact(coordinates.dimensions());
            self.columns = columns.flat_map(|column| coordinates.rows_of(column)).collect();
        }
        self
    }

    /// A column, by row.
    pub fn column(&self, amplitude: usize) -> &[f64] {
        let rows = self.columns.len() / self.lower.len().max(1);
        &self.columns[amplitude * rows..(amplitude + 1) * rows]
    }
}
