//! A correlation in brief.

use crate::job::correlate::{Ended, Kind, Output};
use crate::report::number::{Shown, fixed};
use crate::report::section::brief::Brief;
use crate::report::view::JobEntry;

/// A correlation in brief.
pub(in crate::report::section) struct Correlation;

impl Brief for Correlation {
    type Kind = Kind;

    fn headline(_: &JobEntry, output: &Output) -> Vec<String> {
        let met = if output.ended == Ended::NotMet { "not met" } else { "met" };
        vec![format!(
            "{}: criteria {met}, RMSE {} to {} K, largest {} to {} K",
            output.method.words(),
            fixed(output.before.rmse, 2),
            fixed(output.after.rmse, 2),
            fixed(output.before.max, 2),
            fixed(output.after.max, 2)
        )]
    }

    fn essentials(output: &Output) -> Vec<(String, String)> {
        let value =
            |name: &String, unit: &str, value: f64| (name.clone(), Shown::parameter_of(unit, value).text(value));
        output.parameters.iter().map(|own| value(&own.name, &own.unit, own.after)).collect()
    }
}
