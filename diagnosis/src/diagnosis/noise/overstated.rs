//! Whether the noise that a study states is larger than what its readings scatter by.

use crate::diagnosis::{Problem, Refit};
use crate::inference::likelihood::Datum;
use crate::measurement::scatter;

/// What is said where the stated noise of the sensors of `declared` is too large for what a fit of `settled` leaves, of
/// which `free` unknowns were free. Sensors whose noise is inferred say nothing of it.
pub(crate) fn warning(declared: &Problem, settled: &Problem, fit: &Refit, free: usize) -> Option<String> {
    let baseline = settled.hypothesis(&[], 1.0).ok()?;
    let likelihood = baseline.likelihood(settled).ok()?;
    let sensor = |(datum, residual): (&Datum, &f64)| {
        (&declared.measurements[datum.measurement].sensors[datum.sensor], *residual)
    };
    let sensors = scatter::of_stated(likelihood.data().iter().zip(&fit.residuals).map(sensor), &declared.model);
    scatter::warning(&sensors, free)
}
