//! Key numbers of a propagation: at the nominal design value of each environment the distribution of every quantity and the
//! probability of every requirement, and the design values that reach what is required. Errors are those of independent
//! draws, an upper bound for the other samplings.

use super::output::{Case, Distributed, Output, Probability, Reached};
use crate::job::key_number::KeyNumber;
use crate::statistics::monte_carlo::StandardError;

/// Quantiles that are key numbers, by name.
const QUANTILES: [(&str, f64); 3] = [("q05", 0.05), ("q50", 0.5), ("q95", 0.95)];

/// The key numbers of a propagation.
pub fn key_numbers(output: &Output) -> Vec<KeyNumber> {
    let nominal = output.cases.iter().filter(|case| case.design_value.is_none());
    let mut numbers: Vec<KeyNumber> = nominal.flat_map(of_case).collect();
    numbers.extend(output.reached.iter().filter_map(|reached| of_reached(reached, &output.design_variable)));
    numbers
}

/// Error of a probability, from its interval.
pub fn of_probability(probability: &Probability) -> Option<StandardError> {
    StandardError::of_interval(probability.lower, probability.upper)
}

fn of_case(case: &Case) -> impl Iterator<Item = KeyNumber> {
    let quantities = case.quantities.iter().flat_map(|quantity| of_quantity(quantity, &case.environment));
    let requirements = case.requirements.iter().map(|met| {
        let of = format!("{} ({})", met.requirement, case.environment);
        KeyNumber::new(of, "probability", "", met.probability.value, of_probability(&met.probability))
    });
    quantities.chain(requirements)
}

fn of_quantity(quantity: &Distributed, environment: &str) -> Vec<KeyNumber> {
    let number = |statistic: &str, value, error| {
        let of = format!("{} ({environment})", quantity.name);
        KeyNumber::new(of, statistic, &quantity.unit, value, StandardError::new(error, None))
    };
    let mut numbers = vec![
        number("mean", quantity.mean, quantity.mean_standard_error),
        number("sd", quantity.sd, quantity.sd_standard_error),
    ];
    for (name, probability) in QUANTILES {
        let found = quantity.quantiles.iter().find(|quantile| quantile.probability == probability);
        numbers.extend(found.map(|quantile| number(name, quantile.value, quantile.standard_error)));
    }
    numbers
}

fn of_reached(reached: &Reached, variable: &Option<String>) -> Option<KeyNumber> {
    let value = reached.design_value?;
    // An end of the sweep may cut one side of the interval off, or both.
    let width = reached.interval.map(|[lower, upper]| 2.0 * (upper - value).max(value - lower));
    let error = width.filter(|width| *width > 0.0).and_then(|width| StandardError::of_interval(0.0, width));
    let variable = variable.as_deref().unwrap_or("design value");
    let of = format!("{variable} for {} ({})", reached.requirement, reached.environment);
    Some(KeyNumber::new(of, "reached at", "SI", value, error))
}
