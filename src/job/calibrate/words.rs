//! What stands against a calibration, in words.

use crate::document::counted;
use crate::inference::estimate::identifiability::{Combination, Finding};
use crate::inference::estimate::point_estimate::End;
use crate::inference::sampler::convergence::{Convergence, LeaningOnBound, Objection};

fn end(end: End) -> &'static str {
    match end {
        End::Lower => "lower",
        End::Upper => "upper",
    }
}

/// Objections against the chains.
pub(in crate::job) fn objections(convergence: &Convergence, names: &[String]) -> Vec<String> {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "undefined (the draws do not vary)".to_owned(), |value| format!("{value:.digits$}"))
    };
    convergence
        .objections
        .iter()
        .map(|objection| match objection {
            Objection::RHat { parameter, value } => format!(
                "R-hat of {} is {}: the chains do not agree (wanted: below 1.01)",
                names[*parameter],
                number(*value, 3)
            ),
            Objection::EssBulk { parameter, value } => format!(
                "the effective sample size of {} is {} (wanted: 400 or more)",
                names[*parameter],
                number(*value, 0)
            ),
            Objection::EssTail { parameter, value } => format!(
                "the effective sample size in the tails of {} is {} (wanted: 400 or more)",
                names[*parameter],
                number(*value, 0)
            ),
            Objection::Divergences { count } => format!(
                "{} diverged: the posterior is narrower in places than the sampler's steps, and its draws \
                 may miss them. Shorter steps help (`\"acceptance\": 0.95` with `\"warmup\": 1000`); where they do not, look \
                 for parameters at a bound or that act only together, or take `\"sampler\": \"smc\"`",
                counted(*count, "trajectory")
            ),
            Objection::DepthLimited { count } => format!(
                "{} {} cut short: the sampler moves too slowly along a direction that the data leave \
                 open. A longer warm-up helps (`\"warmup\": 1000`), or a parameter fixed",
                counted(*count, "trajectory"),
                if *count == 1 { "was" } else { "were" }
            ),
        })
        .collect()
}

/// Findings about parameters: from the fit, then from the draws. Of what are errors of a surrogate alone (`is_error`, by position)
/// nobody expects the data to say anything.
pub(super) fn findings(
    found: &[Finding],
    leaning: &[LeaningOnBound],
    names: &[String],
    is_error: &dyn Fn(usize) -> bool,
) -> Vec<String> {
    let is_of_errors = |finding: &&Finding| match finding {
        Finding::FlatDirection { shares, .. } => shares.iter().all(|share| is_error(share.parameter)),
        Finding::OnlyTogether { first, second, .. } => is_error(*first) && is_error(*second),
        Finding::AtBound { .. } => false,
    };
    let mut words: Vec<String> = found
        .iter()
        .filter(|finding| !is_of_errors(finding))
        .map(|finding| match finding {
            Finding::AtBound { parameter, end: which, .. } => format!(
                "The best fit holds {} at the {} bound of its prior: the data pull beyond it. Relax the bound with a \
                 physical reason, or look for physics that is missing.",
                names[*parameter],
                end(*which)
            ),
            Finding::FlatDirection { information, shares } => {
                let list: Vec<&str> = shares.iter().map(|share| names[share.parameter].as_str()).collect();
                let share = (100.0 * information).round();
                match list.as_slice() {
                    [one] => format!(
                        "The data say almost nothing about {one} ({share} % of what the prior says): its posterior is \
                         its prior."
                    ),
                    _ => format!(
                        "The data say almost nothing about one combination of {} ({share} % of what the prior says): \
                         only other combinations of them are determined.",
                        list.join(", ")
                    ),
                }
            }
            Finding::OnlyTogether { first, second, combination } => {
                let (a, b) = (&names[*first], &names[*second]);
                let together = match combination {
                    Combination::Product => format!("{a} \u{d7} {b}"),
                    Combination::Quotient => format!("{a} / {b}"),
                    Combination::Sum => format!("{a} + {b}"),
                    Combination::Difference => format!("{a} \u{2212} {b}"),
                };
                format!("{a} and {b} act on these data only as {together}: fix one of them, or measure it apart.")
            }
        })
        .collect();
    for lean in leaning {
        let which = if lean.upper { "upper" } else { "lower" };
        words.push(format!(
            "{:.0} % of the draws of {} lie within 1 % of the {which} bound of its prior.",
            100.0 * lean.share,
            names[lean.parameter]
        ));
    }
    words
}
