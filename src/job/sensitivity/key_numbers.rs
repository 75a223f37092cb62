//! Key numbers of a sensitivity analysis: every parameter's main and total effect on every quantity, with the error from the
//! scatter of the scrambles.

use super::output::{Index, Output};
use crate::job::key_number::KeyNumber;
use crate::statistics::monte_carlo::StandardError;

/// Least error of a share of the variance: differences of what does not matter matter to nobody, and replicates of a share
/// that is nearly 0 are no normal sample.
const LEAST: f64 = 1e-4;

/// The key numbers of a sensitivity analysis.
pub(super) fn key_numbers(output: &Output) -> Vec<KeyNumber> {
    let mut numbers = Vec::new();
    for case in &output.cases {
        for quantity in &case.quantities {
            let Some(sobol) = &quantity.sobol else { continue };
            let mut add = |statistic: &str, effects: &[Index]| {
                for (parameter, Index { estimate, .. }) in output.parameters.iter().zip(effects) {
                    let error = StandardError::of_replicates(estimate.lower, estimate.upper, output.scrambles);
                    let error =
                        error.map(|error| StandardError { standard_error: error.standard_error.max(LEAST), ..error });
                    let of = format!("{} on {} ({})", parameter.name, quantity.name, case.environment);
                    numbers.push(KeyNumber::new(of, statistic, "", estimate.value, error));
                }
            };
            add("main effect", &sobol.main);
            add("total effect", &sobol.total);
        }
    }
    numbers
}
